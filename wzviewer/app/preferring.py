"""Changing settings: at once, and for the next start."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.settings import Settings
from wzviewer.app.state import AppState


def change_settings(services: Services, state: AppState, command: cmd.ChangeSettings) -> AppState:
    """Prefers something else."""
    return with_settings(services, state, command.settings)


def with_settings(services: Services, state: AppState, settings: Settings) -> AppState:
    """Returns the state with other settings, which are kept; auto detail may look at this view again."""
    complaint = services.store.save(settings)
    state = replace(state, settings=settings, asked_for=None)
    return state.with_toast(complaint, "error") if complaint else state
