"""Files dropped on the window: opened, or put into the picture."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from imgui_bundle import imgui

from tests.app.fakes import checker, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.errands import AtOnce
from wzviewer.app.layout import Rect
from wzviewer.app.panels.dialogs import beside
from wzviewer.app.state import empty_state
from wzviewer.app.variants import CUTOUT, can_vary
from wzviewer.app.window import GlfwWindow
from wzviewer.core.files import save_scene
from wzviewer.core.photos import encode_png


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def cutout(tmp_path):
    alpha = np.zeros((60, 40, 1), np.uint8)
    alpha[10:50, 10:30] = 255
    path = tmp_path / "robin.png"
    path.write_bytes(encode_png(np.dstack([checker(40, 60), alpha])))
    return path


def close_up(services):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    camera = state.view.home.zoomed_to_region(0.4, 0.5, 8.0)
    return replace(state, view=replace(state.view, camera=camera))


def test_a_picture_on_an_open_scene_asks_what_it_is_for(services, cutout, screen):
    state = apply(services, close_up(services), [cmd.Drop(cutout)])
    assert state.panels.dialog == "drop"
    screen.frame(state)
    assert screen.press(state, imgui.Key.enter) == [cmd.SettleDrop("insert")]
    assert screen.press(state, imgui.Key.escape) == [cmd.Escape()]
    assert apply(services, state, [cmd.Escape()]).panels.dialog == ""


def test_putting_it_in_sends_it_to_the_worker_and_leaves_the_line_alone(services, cutout):
    state = apply(services, close_up(services), [cmd.EditPrompt("a bird"), cmd.Drop(cutout)])
    state = apply(services, state, [cmd.SettleDrop("insert")])
    assert state.prompt == "a bird"
    (sent,) = services.client.cutouts
    assert sent.shape == (60, 40, 4)
    assert sent[30, 20, 3] == 255
    assert sent[0, 0, 3] == 0
    for _ in range(10):
        state = drain(services, state, 0.0)
    assert state.scene[1].prompt == "robin"
    assert can_vary(state.scene, 1)  # what the fake makes says nothing of a picture
    state.scene[1].notes[CUTOUT] = True
    again = apply(services, state, [cmd.Another(1)])
    assert again.toasts[-1].text.startswith("A picture that was put in has no variants")
    assert not can_vary(state.scene, 1)


@pytest.mark.parametrize("zoom", [1.0, 8.0, 40.0])
@pytest.mark.parametrize("at", [(0.5, 0.5), (0.2, 0.7), (0.97, 0.03)])
def test_it_is_put_where_it_was_dropped_in_a_frame_that_shows_nothing_but_the_photo(
    services, cutout, zoom, at
):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    camera = state.view.home.zoomed_to_region(0.5, 0.5, zoom)
    state = replace(state, view=replace(state.view, camera=camera))
    place = (at[0] * camera.width, at[1] * camera.height)
    point = camera.unproject(*place, 1.0)
    asked = apply(services, state, [cmd.Drop(cutout, place)])
    frame = asked.region.camera
    assert asked.region.is_of_drop
    x, y, _ = frame.project(point)
    # The fake's surface has a dent, so that what is under the cursor is not quite at depth 1.
    assert (x, y) == pytest.approx((frame.width / 2, frame.height / 2), abs=0.5)
    corners = [frame.unproject(u, v, 1.0) for u in (0, frame.width) for v in (0, frame.height)]
    seen = state.scene[0].camera.project(np.array(corners))
    assert seen[:, :2].min() > -1
    assert (seen[:, :2].max(0) < np.array(state.scene[0].image.shape[1::-1]) + 1).all()
    state = apply(services, asked, [cmd.SettleDrop("insert")])
    assert state.region.camera is None
    assert state.job.goal.camera.key == frame.key  # near enough: it is not asked to come closer
    assert state.view.flight is None or state.view.flight.end.key == frame.key
    for _ in range(40):  # at 40x a level between comes first
        state = drain(services, state, 0.0)
    assert len(services.client.cutouts) == 1
    assert state.scene[len(state.scene) - 1].prompt == "robin"


def test_the_frame_of_a_drop_goes_with_the_question_and_one_that_was_drawn_stays(services, cutout):
    state = close_up(services)
    camera = state.view.camera
    asked = apply(services, state, [cmd.Drop(cutout, (300.0, 200.0))])
    assert asked.region.camera is not None
    assert apply(services, asked, [cmd.Escape()]).region.camera is None
    drawn = [cmd.ToggleRegion(), cmd.BeginDrag("orbit", 50, 60), cmd.DragTo(250, 260), cmd.EndDrag()]
    state = apply(services, state, drawn)
    frame = state.region.camera
    assert frame is not None
    asked = apply(services, state, [cmd.Drop(cutout, (300.0, 200.0))])
    assert asked.region.camera is frame
    assert apply(services, asked, [cmd.Escape()]).region.camera is frame
    state = apply(services, asked, [cmd.SettleDrop("insert")])
    assert state.job.goal.camera is frame
    assert camera.key == asked.view.camera.key


def test_beside_the_picture_it_goes_into_the_middle(services, cutout):
    state = close_up(services)
    far = state.view.home.zoomed(320, 210, 0.25)
    state = replace(state, view=replace(state.view, camera=far))
    asked = apply(services, state, [cmd.Drop(cutout, (5.0, 5.0))])
    assert asked.panels.dialog == "drop"
    assert asked.region.camera is None


@pytest.mark.parametrize("kind", ["unsaved", "making", "recover"])
def test_a_drop_answers_no_question(services, cutout, kind):
    state = close_up(services)
    state = replace(state, after=lambda s: s, panels=replace(state.panels, dialog=kind))
    after = apply(services, state, [cmd.Drop(cutout, (300.0, 200.0))])
    assert after.panels == state.panels
    assert after.after is state.after
    assert after.toasts[-1].text.endswith("then drop robin.png once more.")


def test_a_second_drop_and_one_on_a_path_dialog_take_its_place(services, cutout, tmp_path):
    state = apply(services, close_up(services), [cmd.AskOpen()])
    assert state.panels.dialog == "open"
    first = apply(services, state, [cmd.Drop(cutout, (300.0, 200.0))])
    second = apply(services, first, [cmd.Drop(cutout, (100.0, 100.0))])
    assert first.panels.dialog == second.panels.dialog == "drop"
    assert first.region.camera.key != second.region.camera.key
    assert second.panels.dialog_list is None


@pytest.mark.parametrize(
    ("frame", "y"),
    [
        (Rect(500, 250, 200, 100), 250 + 100 + 30),  # below it
        (Rect(500, 320, 200, 120), 320 - 30 - 150),  # there is no room below: above it
        (Rect(500, 100, 200, 60), 200),  # it hides nothing: it stays
        (Rect(900, 250, 50, 50), 200),
        (Rect(0, 0, 1200, 600), 200),  # nowhere is room
        (None, 200),
    ],
)
def test_the_question_hides_no_frame_that_it_is_about(frame, y):
    moved = beside(Rect(400, 200, 400, 150), frame, Rect(0, 0, 1200, 600), 30.0)
    assert (moved.x, moved.y, moved.width, moved.height) == (400, y, 400, 150)


class Held(AtOnce):
    """Work on files that ends when it is told to."""

    is_held = True

    def poll(self):
        return None if self.is_held else super().poll()


def test_no_frame_waits_for_a_dropped_picture_and_the_question_stands_while_another_file_is_busy(cutout):
    services = fake_services(errands=Held())
    state = close_up(services)
    asked = apply(services, state, [cmd.Drop(cutout, (300.0, 200.0))])
    state = apply(services, asked, [cmd.SettleDrop("insert")])
    assert state.errand.line == "Reading robin.png"
    assert state.panels.dialog == ""
    assert state.region.camera is asked.region.camera  # the frame stays, to be seen
    assert state.job is None
    again = apply(services, state, [cmd.Drop(cutout), cmd.SettleDrop("insert")])
    assert again.panels.dialog == "drop"
    assert again.toasts[-1].text == "One moment: reading robin.png …"
    services.errands.is_held = False
    state = drain(services, state, 0.0)
    assert state.job.goal.cutout is not None
    assert state.region.camera is None


def test_while_something_runs_it_waits(services, cutout):
    state = apply(services, close_up(services), [cmd.Generate(), cmd.Drop(cutout), cmd.SettleDrop("insert")])
    assert [goal.prompt for goal in state.queue.goals] == ["robin"]


def test_opening_it_opens_it(services, cutout):
    state = apply(services, close_up(services), [cmd.Drop(cutout), cmd.SettleDrop("open")])
    assert state.name == "robin.png"
    assert len(state.scene) == 0


def test_a_scene_and_a_drop_on_the_start_page_are_opened_at_once(services, cutout, tmp_path):
    assert apply(services, empty_state(640, 420), [cmd.Drop(cutout)]).photo is not None
    save_scene(make_scene(3), tmp_path / "s.wz")
    state = apply(services, close_up(services), [cmd.Drop(tmp_path / "s.wz")])
    assert len(state.scene) == 3


def test_what_is_no_picture_is_a_notice(services, tmp_path):
    (tmp_path / "bad.png").write_bytes(b"no picture")
    state = apply(services, close_up(services), [cmd.Drop(tmp_path / "bad.png"), cmd.SettleDrop("insert")])
    assert state.toasts[-1].kind == "error"
    assert state.job is None


def test_a_refused_picture_leaves_no_words_behind(services, cutout):
    services.client.refuses.add("robin")
    state = apply(services, close_up(services), [cmd.Drop(cutout), cmd.SettleDrop("insert")])
    for _ in range(3):
        state = drain(services, state, 0.0)
    assert state.prompt == ""
    assert "robin" in state.refusal


@pytest.mark.parametrize("is_open", [True, False])
def test_what_nothing_can_open_is_said_before_anything_is_asked(services, tmp_path, is_open):
    path = tmp_path / "notes.txt"
    path.write_text("milk")
    state = replace(close_up(services), saved=(0, {})) if is_open else empty_state(640, 420)
    assert state.is_dirty is is_open
    state = apply(services, state, [cmd.Drop(path)])
    assert state.panels.dialog == ""
    assert [t.text for t in state.toasts] == ["notes.txt is neither a photo nor a scene of wzviewer."]


@pytest.mark.parametrize(
    ("cursor", "platform", "at_px"),
    [
        ((100.0, 50.0), "x11", (200.0, 100.0)),  # the framebuffer is twice as dense as the window
        ((-3.0, 50.0), "x11", None),  # glfw was not told: it is where the cursor was before
        ((100.0, 50.0), "wayland", None),  # never told
    ],
)
def test_the_window_says_where_in_framebuffer_pixels(cursor, platform, at_px):
    window = object.__new__(GlfwWindow)
    window._window, window._dropped = None, []
    window._glfw = SimpleNamespace(
        get_cursor_pos=lambda _: cursor,
        get_window_size=lambda _: (640, 420),
        get_framebuffer_size=lambda _: (1280, 840),
        get_platform=lambda: platform,
        PLATFORM_WAYLAND="wayland",
    )
    window._on_drop(None, ["robin.png"])
    assert window._dropped == [Path("robin.png")]
    assert window._dropped_at_px == at_px
