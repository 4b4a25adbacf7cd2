"""The hint on the first photo: shown until one of the things that it names is done, and never again."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.preferring import with_settings
from wzviewer.app.services import Services
from wzviewer.app.state import AppState

ACTIONS = (cmd.Zoom, cmd.ZoomTo, cmd.BeginDrag, cmd.Generate, cmd.DismissHint)


def is_shown(state: AppState) -> bool:
    """Whether the hint stands over the picture."""
    return state.has_document and not state.settings.hint_seen


def after(services: Services, state: AppState, command: cmd.Command) -> AppState:
    """Takes the hint away once the user has done what it says; called after every command."""
    if not is_shown(state) or not isinstance(command, ACTIONS):
        return state
    return with_settings(services, state, replace(state.settings, hint_seen=True))


def dismiss(services: Services, state: AppState, command: cmd.DismissHint) -> AppState:
    """Leaves it to `after`, as all that takes the hint away."""
    return state
