"""Notices: dismissed, expanded, and the retry that some of them offer."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.generation import generate, reconstruct
from wzviewer.app.prompting import with_prompt
from wzviewer.app.services import Services
from wzviewer.app.state import AppState


def dismiss(services: Services, state: AppState, command: cmd.DismissToast) -> AppState:
    """Removes a notice."""
    return replace(state, toasts=tuple(t for t in state.toasts if t.text != command.text))


def expand(services: Services, state: AppState, command: cmd.ExpandToast) -> AppState:
    """Shows or hides the details of a notice."""
    toasts = tuple(
        replace(t, is_expanded=not t.is_expanded, born_s=state.now_s) if t.text == command.text else t
        for t in state.toasts
    )
    return replace(state, toasts=toasts)


def retry(services: Services, state: AppState, command: cmd.Retry) -> AppState:
    """Asks again, with the same words, for what failed."""
    prompt = next((t.retry for t in state.toasts if t.text == command.text), None)
    if prompt is None or state.job is not None:
        return state
    state = dismiss(services, state, cmd.DismissToast(command.text))
    if not len(state.scene):
        return reconstruct(services, state)
    return generate(services, with_prompt(state, prompt or state.prompt), cmd.Generate())
