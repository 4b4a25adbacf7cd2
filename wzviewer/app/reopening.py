"""Recent files, seen from the state: noted when opened or saved, opened again, taken off the list."""

from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.state import AppState


def note_document(services: Services, state: AppState, path: Path) -> None:
    """Puts the document that is open at the top of the list, with its photo."""
    image = state.scene[0].image if len(state.scene) else state.photo
    if image is not None:
        services.recents.note(path, image)


def follow(services: Services, state: AppState) -> AppState:
    """Takes over what the list has become; called every frame."""
    news = services.recents.poll()
    if news is None:
        return state
    state = replace(state, recents=news)
    return state.with_toast(news.complaint, "error") if news.complaint else state


def remove(services: Services, state: AppState, command: cmd.RemoveRecent) -> AppState:
    """Takes a file off the list, and off the page at once."""
    services.recents.remove(command.path)
    left = tuple(file for file in state.recents.files if file.path != command.path)
    return replace(state, recents=replace(state.recents, files=left))


def clear(services: Services, state: AppState, command: cmd.ClearRecents) -> AppState:
    """Empties the list."""
    services.recents.clear()
    return replace(state, recents=replace(state.recents, files=()))
