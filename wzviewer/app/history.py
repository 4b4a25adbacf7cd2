"""Undo and redo of everything that changes the scene: nothing is forgotten, only marked otherwise."""

from collections.abc import Mapping
from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.changes import Change, Entry, EntryKind, History, bring_back, marked, take_back
from wzviewer.app.naming import DETAIL, name_in, title_of
from wzviewer.app.places import level_here
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.core.marks import Mark, clean_name
from wzviewer.core.scene import Scene

DONE = {
    "make": "made {}",
    "vary": "made another {}",
    "hide": "hid {}",
    "show": "showed {}",
    "remove": "deleted {}",
    "rename": "renamed {}",
    "choose": "chose another {}",
}


def wording(entry: Entry) -> str:
    """Returns an entry in words, beginning small."""
    text = DONE[entry.kind].format("finer detail" if entry.what == DETAIL else f"“{entry.what}”")
    return text.replace("another finer", "other")


# ------------------------------------------------------------------ through the history


def undo(services: Services, state: AppState, command: cmd.Undo) -> AppState:
    """Takes back the newest change that holds."""
    entry = state.history.undoable
    if entry is None:
        is_making = state.job is not None and state.job.kind == "level"
        return state.with_toast(
            "A level is in the making. Esc cancels it." if is_making else "Nothing to undo."
        )
    state = _settled(services, _moved(state, state.history.at - 1))
    return state.with_toast(f"Undone: {wording(entry)}.", button="Redo", command=cmd.Redo())


def redo(services: Services, state: AppState, command: cmd.Redo) -> AppState:
    """Brings back the change that was taken back last."""
    entry = state.history.redoable
    if entry is None:
        return state.with_toast("Nothing to redo.")
    state = _settled(services, _moved(state, state.history.at + 1))
    return state.with_toast(f"Redone: {wording(entry)}.")


def jump(services: Services, state: AppState, command: cmd.JumpInHistory) -> AppState:
    """Undoes or redoes as far as an entry of the list."""
    at = min(max(command.at, 0), len(state.history.entries))
    return _settled(services, _moved(state, at)) if at != state.history.at else state


def _moved(state: AppState, at: int) -> AppState:
    history = state.history
    for entry in reversed(history.entries[at : history.at]):
        take_back(state.scene, entry)
    for entry in history.entries[history.at : at]:
        bring_back(state.scene, entry)
    return replace(state, history=replace(history, at=at))


def _settled(services: Services, state: AppState) -> AppState:
    """What a change entails: offers to undo the one before end, and so does work that nobody would miss."""
    toasts = tuple(t for t in state.toasts if not isinstance(t.command, cmd.Undo | cmd.Redo))
    # Auto detail must not bring back what was just taken away.
    state = replace(state, toasts=toasts, asked_for=state.view.camera)
    job = state.job
    if job is None or job.kind != "level" or job.is_cancelling:
        return state
    if state.scene.is_visible(job.parent) and not job.is_auto:
        return state
    services.client.cancel()
    return replace(state, job=replace(job, is_cancelling=True), goal=None, is_goal_waiting=False)


# ------------------------------------------------------------------ changes


def changed(
    services: Services, state: AppState, kind: EntryKind, index: int, marks: Mapping[int, Mark]
) -> AppState:
    """Sets marks, and remembers it; nothing when they are set already."""
    entry = marked(state.scene, kind, name_in(state.scene, index), marks)
    if not entry.changes:
        return state
    return _settled(services, replace(state, history=state.history.then(entry)))


def made(state: AppState, index: int, other: int | None = None) -> AppState:
    """Remembers a level that has just been finished.

    Args:
        state: of the app.
        index: of the level.
        other: the level whose place it takes, when it is another of that.
    """
    scene = state.scene
    changes = [Change(index, Mark("removed"), Mark())]
    if other is not None and scene.mark(other).sight == "shown":
        changes.append(Change(other, scene.mark(other), replace(scene.mark(other), sight="hidden")))
        scene.hide(other)
    kind: EntryKind = "make" if other is None else "vary"
    entry = Entry(kind, name_in(scene, index), tuple(changes))
    return replace(state, history=state.history.with_made(entry))


def show_level(services: Services, state: AppState, command: cmd.ShowLevel) -> AppState:
    """Shows a level, or hides it."""
    if not _is_changeable(state, command.index):
        return state
    mark = state.scene.mark(command.index)
    kind: EntryKind = "show" if command.is_shown else "hide"
    sight = replace(mark, sight="shown" if command.is_shown else "hidden")
    return changed(services, state, kind, command.index, {command.index: sight})


def delete_level(services: Services, state: AppState, command: cmd.DeleteLevel) -> AppState:
    """Takes a level out of the tree, and says how to get it back."""
    if not _is_changeable(state, command.index):
        return state
    index, name = command.index, name_in(state.scene, command.index)
    mark = replace(state.scene.mark(index), sight="removed")
    state = changed(services, state, "remove", index, {index: mark})
    return state.with_toast(f"Deleted “{name}”.", button="Undo", command=cmd.Undo())


def rename_level(services: Services, state: AppState, command: cmd.RenameLevel) -> AppState:
    """Gives a level another name; an empty one is its prompt again."""
    if not 0 <= command.index < len(state.scene):
        return state
    state = replace(state, renaming=None)
    name = clean_name(command.name)
    name = "" if name == title_of(state.scene[command.index]) else name
    mark = replace(state.scene.mark(command.index), name=name)
    return changed(services, state, "rename", command.index, {command.index: mark})


def delete_here(services: Services, state: AppState, command: cmd.DeleteHere) -> AppState:
    """Takes the level that the view is in out of the tree."""
    index = level_here(state) if len(state.scene) else 0
    if index == 0:
        return state.with_toast("The photo itself cannot be deleted.")
    return delete_level(services, state, cmd.DeleteLevel(index))


def begin_rename(services: Services, state: AppState, command: cmd.BeginRename) -> AppState:
    """Edits the name of a level, in the tree of levels."""
    if not len(state.scene):
        return state
    index = command.index if command.index is not None else level_here(state)
    return replace(state, renaming=index, panels=replace(state.panels, tree=True))


def end_rename(services: Services, state: AppState, command: cmd.EndRename) -> AppState:
    """Leaves the name as it was."""
    return replace(state, renaming=None)


def _is_changeable(state: AppState, index: int) -> bool:
    return 0 < index < len(state.scene) and state.scene.is_committed(index)


# ------------------------------------------------------------------ from a file


def restored(scene: Scene) -> History:
    """Returns the history of a scene that was just loaded, as far as its marks tell.

    Every level that is seen was made; what was removed can be brought back, the oldest first.
    """
    held, gone = list[Entry](), list[Entry]()
    for level in list(scene)[1:]:
        mark = scene.mark(level.index)
        shown = replace(mark, sight="shown")
        change = Change(level.index, replace(mark, sight="removed"), shown)
        if mark.sight != "hidden":
            (gone if mark.sight == "removed" else held).append(
                Entry("make", name_in(scene, level.index), (change,))
            )
    return History((*held, *gone), len(held))
