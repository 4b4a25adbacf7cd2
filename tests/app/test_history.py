"""Undo and redo of everything that changes the scene."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_level, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.history import made, restored, wording
from wzviewer.app.naming import name_in
from wzviewer.app.state import Job
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.marks import MAX_NAME_CHARS, Mark


@pytest.fixture
def services():
    return fake_services()


def test_undo_hides_newest_first_and_redo_brings_back(services):
    state = state_with(make_scene(3))
    state = apply(services, state, [cmd.Undo()])
    assert state.scene.visible() == [0, 1]
    state = apply(services, state, [cmd.Undo(), cmd.Undo()])
    assert state.scene.visible() == [0]
    assert state.toasts[-1].text == "Nothing to undo."
    state = apply(services, state, [cmd.Redo()])
    assert state.scene.visible() == [0, 1]
    state = apply(services, state, [cmd.Redo(), cmd.Redo()])
    assert state.scene.visible() == [0, 1, 2]
    assert state.toasts[-1].text == "Nothing to redo."


def test_undo_is_a_change_and_undoing_it_is_none(services):
    state = state_with(make_scene(2))
    assert not state.is_dirty
    state = apply(services, state, [cmd.Undo()])
    assert state.is_dirty
    assert not apply(services, state, [cmd.Redo()]).is_dirty


def test_everything_is_undone_in_turn(services):
    state = state_with(make_scene(4))
    untouched = state.scene.marks
    steps = [cmd.ShowLevel(3, False), cmd.RenameLevel(2, "wing"), cmd.ShowLevel(3, True), cmd.DeleteLevel(1)]
    seen = [state.scene.marks]
    for step in steps:
        state = apply(services, state, [step])
        seen.append(state.scene.marks)
    assert [wording(e) for e in state.history.entries[3:]] == [
        "hid “thing 3”",
        "renamed “thing 2”",
        "showed “thing 3”",
        "deleted “thing 1”",
    ]
    assert state.scene.visible() == [0]
    for marks in reversed(seen[:-1]):
        state = apply(services, state, [cmd.Undo()])
        assert state.scene.marks == marks
    assert state.scene.marks == untouched
    state = apply(services, state, [cmd.JumpInHistory(len(state.history.entries))])
    assert state.scene.marks == seen[-1]
    state = apply(services, state, [cmd.JumpInHistory(0)])
    assert state.scene.visible() == [0]


def test_a_change_after_undo_ends_redo(services):
    state = apply(services, state_with(make_scene(3)), [cmd.Undo(), cmd.RenameLevel(1, "x")])
    assert state.history.redoable is None
    assert state.scene.visible() == [0, 1]


def test_what_changes_nothing_is_no_step(services):
    state = state_with(make_scene(2))
    same = [
        cmd.RenameLevel(1, "thing 1"),
        cmd.ShowLevel(1, True),
        cmd.ShowLevel(0, False),
        cmd.DeleteLevel(0),
    ]
    assert apply(services, state, same).history == state.history


def test_a_deleted_level_offers_undo_until_something_else_changes(services):
    state = apply(services, state_with(make_scene(3)), [cmd.DeleteLevel(2)])
    assert (state.toasts[-1].button, state.toasts[-1].command) == ("Undo", cmd.Undo())
    assert apply(services, state, [cmd.Undo()]).scene.visible() == [0, 1, 2]
    later = apply(services, state, [cmd.RenameLevel(1, "x")])
    assert not any(toast.command == cmd.Undo() for toast in later.toasts)


def test_a_level_that_comes_does_not_end_redo(services):
    state = apply(services, state_with(make_scene(3)), [cmd.Undo()])
    level = state.scene[1]
    camera = level.camera.zoomed_to_region(0.2, 0.5, 8.0)
    state.scene.append(make_level(state.scene, 1, camera, level.image))
    state.scene.commit(3)
    state = made(state, 3)
    assert state.scene.visible() == [0, 1, 3]
    state = apply(services, state, [cmd.Redo()])
    assert state.scene.visible() == [0, 1, 2, 3]
    assert apply(services, state, [cmd.Undo(), cmd.Undo()]).scene.visible() == [0, 1]
    assert wording(state.history.entries[1]) == "made finer detail"


def test_undo_ends_auto_detail_which_nobody_asked_for(services):
    state = making(state_with(make_scene(3)), parent=1)
    state = apply(services, replace(state, job=replace(state.job, is_auto=True)), [cmd.Undo()])
    assert state.job.is_cancelling


def test_undo_leaves_another_level_in_the_making_alone(services):
    state = making(state_with(make_scene(3)), parent=1)
    state = apply(services, state, [cmd.Undo()])
    assert state.scene.visible() == [0, 1, 3]
    assert not state.job.is_cancelling


def test_undo_of_the_parent_ends_what_nobody_would_see(services):
    state = making(state_with(make_scene(3)), parent=2)
    state = apply(services, state, [cmd.Undo()])
    assert state.job.is_cancelling
    assert services.client.calls == [("cancel",)]


def making(state, parent):
    level = state.scene[parent]
    camera = level.camera.zoomed_to_region(0.5, 0.5, 8.0)
    state.scene.append(make_level(state.scene, parent, camera, level.image))
    return replace(state, job=Job(1, "level", "", 0.0, level=len(state.scene) - 1, parent=parent))


def test_a_loaded_scene_redoes_what_was_removed_the_oldest_first(services):
    scene = make_scene(4)
    scene.set_mark(3, Mark("removed"))
    scene.set_mark(2, Mark("removed"))
    scene.hide(1)
    history = restored(scene)
    assert [entry.changes[0].index for entry in history.entries] == [2, 3]
    assert history.at == 0
    state = replace(state_with(scene), history=history)
    state = apply(services, state, [cmd.Redo(), cmd.ShowLevel(1, True)])
    assert state.scene.visible() == [0, 1, 2]


def test_names_are_kept_in_the_file_and_clean(services, tmp_path):
    state = apply(services, state_with(make_scene(3)), [cmd.RenameLevel(2, "  the\nwing\x07 " + "x" * 200)])
    assert name_in(state.scene, 2).startswith("the wing xxx")
    assert len(name_in(state.scene, 2)) == MAX_NAME_CHARS
    state = apply(services, state, [cmd.RenameLevel(1, "fly")])
    assert state.is_dirty
    save_scene(state.scene, tmp_path / "s.wz")
    loaded = load_scene(tmp_path / "s.wz")
    assert name_in(loaded, 1) == "fly"
    assert [level.prompt for level in loaded] == ["", "thing 1", "thing 2"]
    state = apply(services, state, [cmd.RenameLevel(1, "")])
    assert name_in(state.scene, 1) == "thing 1"


def test_rename_in_place_begins_at_the_level_here(services):
    state = replace(state_with(make_scene(2)))
    state = apply(services, state, [cmd.Toggle("tree"), cmd.BeginRename()])
    assert (state.renaming, state.panels.tree) == (0, True)
    assert apply(services, state, [cmd.EndRename()]).renaming is None
    assert apply(services, state, [cmd.RenameLevel(0, "home")]).renaming is None
