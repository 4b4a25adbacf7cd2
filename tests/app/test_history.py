"""Undo and redo."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_level, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.history import restored, undoable
from wzviewer.app.state import Job


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


def test_undo_leaves_a_level_in_the_making_alone(services):
    state = state_with(make_scene(2))
    level = state.scene[1]
    camera = level.camera.zoomed_to_region(0.5, 0.5, 8.0)
    state.scene.append(make_level(state.scene, 1, camera, level.image))
    assert undoable(state.scene) == 1
    state = replace(state, job=Job(1, "level", "", 0.0, level=2))
    state = apply(services, state, [cmd.Undo()])
    assert state.scene.visible() == [0, 1, 2]
    assert "Esc" in state.toasts[-1].text


def test_a_loaded_scene_redoes_the_oldest_first():
    scene = make_scene(4)
    scene.hide(3)
    scene.hide(2)
    assert restored(scene) == (3, 2)
    scene.show(restored(scene)[-1])
    assert scene.visible() == [0, 1, 2]
