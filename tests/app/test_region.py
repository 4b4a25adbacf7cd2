"""The frame of the next level: drawn, shown, asked for."""

from dataclasses import replace

import numpy as np
import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain, tick
from wzviewer.app.panels.frame import seen_rect
from wzviewer.app.region import drawn_frame
from wzviewer.app.viewing import advance


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def state(services):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    return state


def drawn(services, state, start=(400.0, 100.0), end=(480.0, 152.5)):
    drag = [cmd.BeginDrag("orbit", *start), cmd.DragTo(*end), cmd.EndDrag()]
    return apply(services, state, [cmd.ToggleRegion(), *drag])


def rested(services, state):
    view = replace(state.view, focused=state.view.camera, moved_s=-10.0)
    return tick(services, replace(state, view=view), False)


def test_a_drag_draws_a_frame_in_the_views_aspect(services, state):
    before = state.view.camera
    state = drawn(services, state)
    assert state.view.camera is before  # the picture stood still
    assert not state.region.is_drawing
    assert state.panels.prompt_focus
    corners = [before.project(state.region.camera.unproject(*at, 1.0))[:2] for at in ((0, 0), (640, 420))]
    assert np.allclose(corners, [(400.0, 100.0), (480.0, 152.5)], atol=1e-6)


def test_the_frame_grows_from_any_corner():
    assert drawn_frame((100, 100), (164, 110), (640, 420)) == pytest.approx((100, 100, 64, 42))
    assert drawn_frame((100, 100), (36, 90), (640, 420)) == pytest.approx((36, 58, 64, 42))


def test_enter_makes_the_frame_and_flies_there(services, state):
    state = apply(services, drawn(services, state), [cmd.EditPrompt("a bird"), cmd.Generate()])
    assert state.job is not None
    assert state.region.camera is None
    for _ in range(200):
        state = drain(services, advance(replace(state, now_s=state.now_s + 1 / 30), 1 / 30), 0.0)
    level = state.scene[1]
    centre = state.view.home.unproject(440.0, 126.25, 1.0)
    x, y, _ = level.camera.project(centre)
    assert np.allclose((x, y), (level.camera.width / 2, level.camera.height / 2), atol=1.0)
    assert state.view.camera.focal_px / state.view.home.focal_px == pytest.approx(8.0, rel=0.01)


def test_a_click_draws_nothing_and_escape_leaves(services, state):
    state = drawn(services, state, end=(403.0, 101.0))
    assert state.region.is_drawing
    assert state.region.camera is None
    assert not apply(services, state, [cmd.Escape()]).region.is_drawing
    assert apply(services, drawn(services, state), [cmd.Escape()]).region.camera is None
    panned = apply(services, state, [cmd.BeginDrag("pan", 10.0, 10.0), cmd.DragTo(30.0, 10.0), cmd.EndDrag()])
    assert panned.view.camera is not state.view.camera  # the other button moves as ever


def test_while_something_runs_the_frame_waits_and_the_view_stays(services, state):
    near = replace(state, view=replace(state.view, camera=state.view.home.zoomed_to_region(0.2, 0.2, 8.0)))
    busy = apply(services, near, [cmd.Generate()])
    busy = replace(busy, view=replace(busy.view, camera=state.view.home))
    state = apply(services, drawn(services, busy), [cmd.Generate()])
    assert len(state.queue.goals) == 1
    assert state.view.flight is None
    assert state.region.camera is None


def test_where_enter_would_go_is_found_once_a_place(services, state, monkeypatch):
    state = rested(services, state)
    assert state.region.aim.focal_px / state.view.camera.focal_px == pytest.approx(7.5, rel=0.1)
    from wzviewer.app import framing

    monkeypatch.setattr(framing, "plan_level", lambda *a: 1 / 0)
    assert framing.aim(state) is state
    monkeypatch.undo()
    deep = replace(state, view=replace(state.view, camera=state.view.home.zoomed_to_region(0.5, 0.5, 8.0)))
    deep = rested(services, deep)
    assert deep.region.aim is None  # it is the view itself


def test_the_frame_is_seen_where_it_was_drawn(screen, services, state):
    state = drawn(services, state)
    screen.width, screen.height = 640, 420
    screen.frame(state)
    rect = seen_rect(state, state.region.camera)
    assert (rect.x, rect.y, rect.width) == pytest.approx((400.0, 100.0, 80.0), abs=1e-3)
