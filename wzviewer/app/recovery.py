"""Autosave, seen from the state: what is in no file is journalled, and asked for after a crash."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.documents import run_errand, with_scene
from wzviewer.app.errands import Errand
from wzviewer.app.journal import Leftover
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, View
from wzviewer.app.wishes import Queue
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene


def keep(services: Services, state: AppState) -> None:
    """Tells the journal how things stand; called every frame."""
    is_midway = state.timeline.is_retiming or (state.job is not None and state.job.instead_of is not None)
    if state.is_dirty and is_midway:
        return  # of a drag, or of a variant for which another stands back
    if state.is_dirty:
        source = state.path if state.path is not None else state.source
        services.journal.keep(state.scene, state.name, state.timeline.path, source)
    else:
        services.journal.clear()


def ask_to_recover(services: Services, state: AppState) -> AppState:
    """Asks about levels that a crash left behind; called once, at the start."""
    leftover = services.journal.leftover()
    if leftover is None:
        return state
    return replace(state, leftover=leftover, panels=replace(state.panels, dialog="recover"))


def settle_recovery(services: Services, state: AppState, command: cmd.SettleRecovery) -> AppState:
    """Carries out the answer: opens the levels as a document, or deletes them."""
    leftover = state.leftover
    state = replace(state, leftover=None, panels=replace(state.panels, dialog=""))
    if leftover is None:
        return state
    if command.answer == "discard":
        services.journal.discard(leftover)
        return state
    errand = Errand(
        f"Bringing back {leftover.name or 'the scene'}",
        lambda services, state, scene: _recovered(services, state, leftover, scene),
        lambda services, state, why: state.with_toast(f"The levels could not be recovered: {why}.", "error"),
    )
    return run_errand(services, state, errand, lambda: _read(services, leftover))


def _read(services: Services, leftover: Leftover) -> Scene:
    """What can be read of it.

    Raises:
        OSError: when that is nothing.
    """
    try:
        return services.journal.recover(leftover)
    except ValueError as error:
        raise OSError(str(error)) from error


def _recovered(services: Services, state: AppState, leftover: Leftover, scene: Scene) -> AppState:
    """The document is what a crash left, from now on, and is not saved."""
    width, height = state.view.camera.width, state.view.camera.height
    view = View.at_home(Camera.initial(width, height), width, height)
    name = leftover.name or "recovered"
    fresh = replace(state, view=view, name=name, photo=None, job=None, goal=None, queue=Queue())
    fresh = with_scene(services, fresh, scene, path=None)
    # In this order: the levels lie in a session of our own before the old one is deleted.
    services.journal.keep(scene, name, fresh.timeline.path, leftover.source)
    services.journal.discard(leftover)
    fresh = replace(fresh, saved=(0, {}), source=leftover.source)
    return fresh.with_toast(f"Recovered {leftover.what}.", "done")
