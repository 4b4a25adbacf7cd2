"""Variants of a level: made with other seeds, one of them shown."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.generation import ask
from wzviewer.app.layout import Rect
from wzviewer.app.panels.branches import tree_rows
from wzviewer.app.panels.variants import draw_variants
from wzviewer.app.state import Goal
from wzviewer.app.variants import SEED_STRIDE, group_of
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.marks import Mark


@pytest.fixture
def services():
    return fake_services()


def settle(services, state, frames=60):
    for _ in range(frames):
        state = drain(services, replace(state, now_s=state.now_s + 1 / 30), 0.0)
    return state


def with_variants(services, count):
    state = state_with(make_scene(2))
    services.client.load(state.scene)
    for _ in range(count - 1):
        state = settle(services, apply(services, state, [cmd.Another()]))
    return state


def shown(state):
    return [i for i in group_of(state.scene, 1) if state.scene.mark(i).sight == "shown"]


def test_another_is_a_sibling_with_another_seed_and_takes_its_place(services):
    state = with_variants(services, 3)
    levels = [state.scene[i] for i in (1, 2, 3)]
    assert {level.parent for level in levels} == {0}
    assert {level.prompt for level in levels} == {"thing 1"}
    assert len({level.camera.key for level in levels}) == 1
    assert [level.seed for level in levels] == [0, SEED_STRIDE, 2 * SEED_STRIDE]
    assert shown(state) == [3]
    assert group_of(state.scene, 2) == (1, 2, 3)
    assert [e.kind for e in state.history.entries] == ["make", "vary", "vary"]


def test_the_older_is_seen_alone_until_the_new_preview_stands_and_then_the_new_one(services):
    state = with_variants(services, 2)
    state = apply(services, state, [cmd.Another()])
    sights = []
    while state.job is not None:
        state = drain(services, replace(state, now_s=state.now_s + 1 / 30), 0.0)
        sights.append(tuple(i for i in state.scene.visible() if i > 0))
    # Begins, coarse, surfels, better preview, optimisation, finished: never two at once.
    assert sights == [(2,), (2,), (2,), (3,), (3,), (3,)]
    assert [e.kind for e in state.history.entries] == ["make", "vary", "vary"]
    assert shown(apply(services, state, [cmd.Undo()])) == [2]


def test_a_variant_that_is_cancelled_gives_its_place_back(services, tmp_path):
    state = apply(services, with_variants(services, 2), [cmd.Another()])
    while state.job is not None and state.job.instead_of is None:
        state = drain(services, state, 0.0)
    saved = apply(services, state, [cmd.SaveTo(tmp_path / "midway.wz")])
    assert load_scene(tmp_path / "midway.wz").visible() == [0, 2]
    state = settle(services, apply(services, saved, [cmd.CancelJob()]))
    assert state.scene.visible() == [0, 2]


@pytest.mark.parametrize("name", ["", "the red one"])
def test_a_variant_in_the_making_is_nothing_to_save_until_it_is_finished(services, name):
    state = with_variants(services, 2)
    state.scene.set_mark(2, Mark("shown", name))
    state = replace(state, saved=(state.num_finished, state.scene.marks))
    state = apply(services, state, [cmd.Another()])
    while state.job.instead_of is None:
        state = drain(services, state, 0.0)
    assert state.scene.mark(2).sight == "hidden"
    assert not state.is_dirty
    state.scene.set_mark(1, replace(state.scene.mark(1), name="the other"))  # this would be lost
    assert state.is_dirty
    state.scene.set_mark(1, Mark("hidden"))
    assert settle(services, state).is_dirty


def test_undo_of_another_brings_the_one_before_back(services):
    state = apply(services, with_variants(services, 3), [cmd.Undo()])
    assert shown(state) == [2]
    assert shown(apply(services, state, [cmd.Redo()])) == [3]


def test_choosing_and_stepping_show_one(services):
    state = apply(services, with_variants(services, 3), [cmd.ChooseVariant(1)])
    assert shown(state) == [1]
    for step, expected in ((-1, 3), (-1, 2), (1, 3), (1, 1)):
        state = apply(services, state, [cmd.StepVariant(step)])
        assert shown(state) == [expected]
    state = apply(services, state, [cmd.Undo()])
    assert shown(state) == [3]
    assert [(row.index, row.variants) for row in tree_rows(state.scene)] == [(0, 1), (3, 3)]


def test_several_are_made_from_one_request(services):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    camera = state.view.home.zoomed_to_region(0.5, 0.5, 8.0)
    state = replace(state, view=replace(state.view, camera=camera))
    state = settle(services, apply(services, state, [cmd.EditPrompt("a bird"), cmd.Generate(3)]))
    assert [level.prompt for level in state.scene] == ["", "a bird", "a bird", "a bird"]
    assert services.client.seeds == [1, 1 + SEED_STRIDE, 1 + 2 * SEED_STRIDE]
    assert shown(state) == [3]
    assert state.variants == 3


def test_cancelling_one_of_several_ends_the_rest_of_them(services):
    state = state_with(make_scene(2))
    services.client.load(state.scene)
    state = apply(services, state, [cmd.Another(1, 4)])
    state = settle(services, state, 8)
    assert len(state.scene) >= 3
    state = settle(services, apply(services, state, [cmd.CancelJob()]))
    assert state.job is None
    assert state.queue.goals == ()
    assert len(state.scene) <= 4


def test_variants_survive_the_file(services, tmp_path):
    state = apply(services, with_variants(services, 3), [cmd.ChooseVariant(2)])
    save_scene(state.scene, tmp_path / "v.wz")
    loaded = load_scene(tmp_path / "v.wz")
    assert group_of(loaded, 1) == (1, 2, 3)
    assert loaded.visible() == [0, 2]
    reopened = apply(services, state_with(loaded), [cmd.ChooseVariant(3)])
    assert reopened.scene.visible() == [0, 3]


def test_a_deleted_variant_leaves_the_group_and_its_seed_is_not_used_again(services):
    state = apply(services, with_variants(services, 2), [cmd.DeleteLevel(1)])
    assert group_of(state.scene, 2) == (2,)
    state = settle(services, apply(services, state, [cmd.Another(2)]))
    assert [level.seed for level in state.scene][1:] == [0, SEED_STRIDE, 2 * SEED_STRIDE]


def test_the_open_strip_says_what_another_is_of(services):
    state = with_variants(services, 2)
    near = state.scene[2].camera.zoomed_to_region(0.5, 0.5, 8.0)
    focus = state.scene[2].frame.origin
    goal = Goal(near, "a key", focus)
    state = settle(services, ask(services, state, goal))
    assert state.scene[3].prompt == "a key"
    state = settle(services, apply(services, state, [cmd.Another()]))
    assert (state.scene[4].parent, state.scene[4].prompt) == (0, "thing 1")
    state = apply(services, state, [cmd.Escape()])
    assert state.variants is None
    state = settle(services, apply(services, state, [cmd.ChooseVariant(2), cmd.Escape(), cmd.Another()]))
    assert (state.scene[5].parent, state.scene[5].prompt) == (2, "a key")


def test_there_is_no_other_photo(services):
    state = apply(services, state_with(make_scene(1)), [cmd.Another(), cmd.StepVariant(1)])
    assert "no level" in state.toasts[-1].text
    assert state.job is None


def test_the_strip_shows_one_on_a_click_and_closes(screen, services):
    state = with_variants(services, 3)
    assert state.variants is not None
    rect = Rect(330.0, 700.0, 620.0, 0.0)

    def draw(state, ui):
        return draw_variants(state, ui, rect)[0]

    for _ in range(2):
        screen.frame(state, draw)
    found = set()
    for x in range(400, 900, 25):
        for y in (660, 684):
            for is_down in (None, True, False):
                screen.move(x, y)
                if is_down is not None:
                    screen.io.add_mouse_button_event(0, is_down)
                found |= set(screen.frame(state, draw))
    expected = {cmd.ChooseVariant(1), cmd.ChooseVariant(2), cmd.OpenVariants(None)}
    assert expected <= found
    assert any(isinstance(c, cmd.Another) for c in found)
    assert cmd.ChooseVariant(3) not in found
    assert apply(services, state, [cmd.OpenVariants(None)]).variants is None
