"""Asking for levels, and taking them over."""

from dataclasses import replace

import numpy as np
import pytest

from tests.app.fakes import checker, fake_services, make_level, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.aiming import level_camera, plan_level
from wzviewer.app.apply import apply, drain
from wzviewer.app.generation import request
from wzviewer.app.state import Goal, View, empty_state
from wzviewer.app.viewing import advance
from wzviewer.core.camera import Camera
from wzviewer.worker import client as ev


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def state(services):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    return state


def goal_at(state, camera, prompt=""):
    return Goal(camera, prompt, camera.unproject(camera.width / 2, camera.height / 2, 1.0))


def zoomed(state, factor, x=0.5, y=0.5):
    return replace(state, view=replace(state.view, camera=state.view.home.zoomed_to_region(x, y, factor)))


def settle(services, state, frames=200):
    for _ in range(frames):
        state = replace(state, now_s=state.now_s + 1 / 30)
        state = drain(services, advance(state, 1 / 30), 0.0)
    return state


def test_the_next_camera_is_what_is_on_the_screen(services, state):
    near = zoomed(state, 8.0, 0.4, 0.6)
    near = settle(services, apply(services, near, [cmd.EditPrompt("a bird"), cmd.Generate()]))
    level = near.scene[1]
    assert level.parent == 0
    assert level.prompt == "a bird"
    assert near.scene.is_committed(1)
    assert max(level.camera.width, level.camera.height) == near.scene[0].camera.width
    for x, y in ((0.0, 0.0), (0.5, 0.5), (1.0, 1.0)):
        point = near.view.camera.unproject(x * 640, y * 420, 1.0)
        at = level.camera.project(point)[:2] / [level.camera.width, level.camera.height]
        assert np.allclose(at, [x, y], atol=0.01)
    assert near.prompt == ""  # done, so the line is free again
    assert near.job is None


def test_the_worker_is_told_of_the_levels_that_a_new_one_will_lie_over(services, state):
    for x, prompt in ((0.5, "a bird"), (0.57, "a butterfly")):
        near = zoomed(state, 8.0, x)
        state = settle(services, apply(services, near, [cmd.EditPrompt(prompt), cmd.Generate()]))
    assert [level.parent for level in state.scene] == [None, 0, 0]
    assert services.client.beside == [[], [1]]


def test_not_close_enough_flies_closer_and_says_so(services, state):
    state = apply(services, state, [cmd.Generate()])
    assert state.job is None
    assert "closer" in state.toasts[-1].text
    state = settle(services, state)
    assert len(state.scene) == 2
    assert state.view.magnification == pytest.approx(8.0, rel=0.25)  # a window crops the photo a little


def test_much_closer_makes_the_levels_between_first(services, state):
    state = apply(services, zoomed(state, 64.0), [cmd.EditPrompt("an eye"), cmd.Generate()])
    state = settle(services, state)
    assert [level.prompt for level in state.scene] == ["", "", "an eye"]
    assert [level.parent for level in state.scene] == [None, 0, 1]
    assert state.scene.magnification(2) / state.scene.magnification(1) == pytest.approx(8.0, rel=0.3)


def test_the_parent_is_the_finest_level_that_shows_the_centre():
    state = state_with(make_scene(3))
    home = state.view.home
    assert plan_level(state.scene, goal_at(state, home.zoomed_to_region(0.5, 0.5, 500.0))).parent == 2
    assert plan_level(state.scene, goal_at(state, home.zoomed_to_region(0.9, 0.2, 500.0))).parent == 0
    assert plan_level(state.scene, goal_at(state, home.zoomed_to_region(0.5, 0.5, 4.0))).parent == 0
    state.scene.hide(1)
    assert plan_level(state.scene, goal_at(state, home.zoomed_to_region(0.5, 0.5, 500.0))).parent == 0
    assert plan_level(state.scene, goal_at(state, home.zoomed_to_region(9.0, 0.5, 8.0))) is None


def test_level_camera_has_the_windows_aspect():
    scene = make_scene(1)
    camera = level_camera(scene, Camera.initial(1600, 800))
    assert (camera.width, camera.height) == (136, 68)


def test_what_auto_detail_makes_already_is_not_begun_again(services, state):
    near = zoomed(state, 8.0)
    near = request(services, near, goal_at(near, near.view.camera), is_auto=True)
    asked = apply(services, near, [cmd.Generate()])
    assert not asked.job.is_auto
    assert asked.job.request_id == near.job.request_id
    other = apply(services, near, [cmd.EditPrompt("a bird"), cmd.Generate()])
    assert other.job.is_cancelling
    assert other.goal.prompt == "a bird"


def test_a_refusal_stands_at_the_prompt_until_it_changes(services, state):
    services.client.refuses.add("zzz")
    state = apply(services, zoomed(state, 8.0), [cmd.EditPrompt("zzz"), cmd.Generate()])
    state = settle(services, state, 5)
    assert "no zzz here" in state.refusal
    assert state.prompt == "zzz"
    assert len(state.scene) == 1
    assert apply(services, state, [cmd.EditPrompt("zz")]).refusal == ""


def test_cancel_drops_the_preview(services, state):
    state = apply(services, zoomed(state, 8.0), [cmd.Generate()])
    state = settle(services, state, 3)
    assert len(state.scene) == 2
    assert not state.scene.is_committed(1)
    assert not state.is_dirty
    state = apply(services, state, [cmd.Escape()])
    assert state.job.is_cancelling
    state = settle(services, state, 3)
    assert len(state.scene) == 1
    assert state.job is None


def test_the_same_twice_is_made_once_and_says_so(services, state):
    state = apply(services, zoomed(state, 8.0), [cmd.Generate(), cmd.Generate()])
    assert sum(call[0] == "synthesize" for call in services.client.calls) == 1
    assert "already" in state.toasts[-1].text
    assert state.queue.goals == ()


def test_a_lost_worker_loses_no_finished_level(services):
    state = state_with(make_scene(2))
    services.client.load(state.scene)
    state = apply(services, zoomed(state, 64.0), [cmd.Generate()])
    state = settle(services, state, 3)
    services.client.lose()
    state = settle(services, state, 3)
    assert len(state.scene) == 2
    assert state.job is None
    assert [t.text for t in state.toasts] == ["The worker was killed."]


def test_the_photo_becomes_the_first_level_under_the_users_hand(services):
    photo = checker(136, 90)
    state = replace(empty_state(640, 420), photo=photo)
    state = replace(state, view=View.at_home(Camera.initial(136, 90), 640, 420))
    state = apply(services, state, [cmd.Generate()])
    state = apply(services, state, [cmd.BeginDrag("pan", 10.0, 10.0), cmd.DragTo(50.0, 10.0), cmd.EndDrag()])
    cx = state.view.camera.cx
    state = settle(services, state)
    assert len(state.scene) == 1
    assert state.view.camera.cx == cx
    assert state.scene.is_committed(0)
    assert state.is_dirty  # E_0 took its seconds too


def test_a_failed_photo_stays_flat_and_can_be_tried_again(services):
    services.client.fails = True
    state = replace(empty_state(640, 420), photo=checker(136, 90))
    state = settle(services, apply(services, state, [cmd.Generate()]), 5)
    assert state.has_document
    assert state.toasts[-1].kind == "error"
    services.client.fails = False
    assert len(settle(services, apply(services, state, [cmd.Generate()])).scene) == 1


def test_events_of_a_closed_document_are_ignored(services, state):
    state = drain(services, state, 0.0)
    services.client._queue.append(ev.LevelFinished(77, state.scene[0]))
    assert len(drain(services, state, 0.0).scene) == 1


def test_a_fault_in_a_handler_becomes_a_notice(services, state):
    services.client.synthesize = lambda *a, **k: 1 / 0
    state = apply(services, zoomed(state, 8.0), [cmd.Generate()])
    assert "division" in state.toasts[-1].text
    assert state.job is None


def test_a_view_beyond_the_border_asks_for_an_extension(services, state):
    home = state.view.home
    plan = plan_level(state.scene, goal_at(state, home.zoomed_to_region(1.0, 0.5, 1.0)))
    assert plan.is_extension
    assert plan.parent == 0
    inside = plan_level(state.scene, goal_at(state, home.zoomed_to_region(0.5, 0.5, 1.2)))
    assert not inside.is_extension
    near = plan_level(state.scene, goal_at(state, home.zoomed_to_region(1.0, 0.5, 8.0)))
    assert near is None or not near.is_extension  # a zoom is a zoom, also at the border
    moved = apply(services, zoomed(state, 1.0, 1.0, 0.5), [cmd.Generate()])
    assert moved.job is not None  # asked for at once, without flying closer


def test_a_long_frame_counts_in_how_long_something_took(services, state):
    state = apply(services, zoomed(state, 8.0), [cmd.Generate()])
    state = replace(state, now_s=state.now_s + 0.1, stalled_s=3.0)  # motions went on by a tenth only
    assert state.clock_s - state.job.started_s == pytest.approx(3.1)


def test_a_worker_that_was_ended_by_a_cancel_is_no_error():
    services = fake_services()
    state = replace(state_with(make_scene(1)), is_worker_ready=True)
    for is_after_cancel, count in ((True, 0), (False, 1)):
        services.client._queue.append(ev.WorkerLost(0, "did not answer the cancel in time", is_after_cancel))
        state = drain(services, state, 0.0)
        assert len(state.toasts) == count
        assert not state.is_worker_ready


def test_a_view_that_was_zoomed_while_the_photo_was_read_keeps_its_middle(services):
    state = replace(empty_state(640, 420), photo=checker(136, 90))
    state = apply(
        services, state.with_view(View.at_home(Camera.initial(136, 90), 640, 420)), [cmd.Generate()]
    )
    near = state.view.home.zoomed_to_region(0.2, 0.3, 8.0)
    state = drain(services, state.with_view(replace(state.view, camera=near, focused=near)), 0.0)
    while not len(state.scene):
        state = drain(services, state, 0.0)
    assert state.view.camera is near
    assert np.allclose(near.project(state.view.focus)[:2], (320, 210))
    assert state.view.focused is None  # to be looked for again, on the surface that is there now


def test_what_is_asked_for_is_not_cut_off_where_an_older_finer_level_comes_first():
    scene = make_scene(1)
    root = scene[0].camera
    places = ((0.4, 0.5, 4.0, "a ladybug"), (0.5, 0.5, 2.0, ""))
    for index, (x, y, factor, prompt) in enumerate(places, 1):
        camera = root.zoomed_to_region(x, y, factor)
        scene.append(make_level(scene, 0, camera, checker(136, 90), prompt))
        scene.commit(index)

    def parent_of(prompt, x, factor):
        camera = root.zoomed_to_region(x, 0.5, factor)
        return plan_level(scene, goal_at(state_with(scene), camera, prompt)).parent

    assert parent_of("a snail", 0.55, 8.0) == 0  # beside both, and before both
    assert parent_of("", 0.55, 8.0) == 2  # plain detail leaves the ladybug what it has
    assert parent_of("a snail", 0.62, 8.0) == 2  # clear of the ladybug's picture
    assert parent_of("a snail", 0.53, 16.0) == 2  # the photo would be too coarse
