"""Undo and redo of levels: hidden and shown again, never forgotten."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.core.scene import Scene


def undoable(scene: Scene) -> int | None:
    """Returns the newest finished level that is seen, the photo apart; None when there is none."""
    seen = [i for i in scene.visible() if i > 0 and scene.is_committed(i)]
    return max(seen, default=None)


def undo(services: Services, state: AppState, command: cmd.Undo) -> AppState:
    """Hides the newest level."""
    if state.job is not None and state.job.level is not None:
        return state.with_toast("A level is in the making. Esc cancels it.")
    index = undoable(state.scene)
    if index is None:
        return state.with_toast("Nothing to undo.")
    state.scene.hide(index)
    # Auto detail must not bring back what was just taken away.
    return replace(state, undone=(*state.undone, index), asked_for=state.view.camera)


def redo(services: Services, state: AppState, command: cmd.Redo) -> AppState:
    """Shows the level that was hidden last."""
    if not state.undone:
        return state.with_toast("Nothing to redo.")
    state.scene.show(state.undone[-1])
    return replace(state, undone=state.undone[:-1])


def noted(state: AppState) -> AppState:
    """A new level ends what redo could bring back, as in every editor."""
    return replace(state, undone=())


def restored(scene: Scene) -> tuple[int, ...]:
    """What redo can bring back in a scene that was just loaded: the oldest hidden level first."""
    return tuple(sorted(scene.hidden, reverse=True))
