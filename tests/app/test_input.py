"""Mouse and keyboard to commands."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from tests.app.fakes import make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.state import Panels, empty_state


@pytest.fixture
def state():
    return state_with(make_scene(1))


def drag(screen, state, button, *modifiers):
    screen.move(640, 300)
    screen.frame(state)
    for key in modifiers:
        screen.io.add_key_event(key, True)
    screen.io.add_mouse_button_event(button, True)
    commands = screen.frame(state)
    for x in (642, 660, 700):
        screen.move(x, 310)
        commands += screen.frame(state)
    screen.io.add_mouse_button_event(button, False)
    commands += screen.frame(state)
    return commands


def test_wheel_zooms_to_the_cursor(screen, state):
    screen.move(700, 300)
    screen.frame(state)
    screen.io.add_mouse_wheel_event(0.0, 2.0)
    assert screen.frame(state) == [cmd.Zoom(700.0, 300.0, 2.0)]


def test_wheel_over_a_panel_is_the_panels(screen, state):
    screen.move(60, 110)
    screen.frame(state)
    screen.frame(state)
    screen.io.add_mouse_wheel_event(0.0, 2.0)
    assert screen.frame(state) == []


def test_positions_are_framebuffer_pixels(screen, state):
    screen.io.display_framebuffer_scale = imgui.ImVec2(2.0, 2.0)
    screen.move(700, 300)
    screen.frame(state)
    screen.io.add_mouse_wheel_event(0.0, 1.0)
    assert screen.frame(state) == [cmd.Zoom(1400.0, 600.0, 1.0)]


def test_drag_orbits_from_where_it_began(screen, state):
    commands = drag(screen, state, 0)
    assert commands[0] == cmd.BeginDrag("orbit", 640.0, 300.0)
    assert commands[-2:] == [cmd.DragTo(700.0, 310.0), cmd.EndDrag()]


@pytest.mark.parametrize(("button", "modifiers"), [(1, ()), (0, (imgui.Key.mod_shift,))])
def test_right_and_shift_drag_pan(screen, state, button, modifiers):
    assert drag(screen, state, button, *modifiers)[0].kind == "pan"


def test_a_click_is_no_drag(screen, state):
    assert screen.click(state, 640, 300) == []


def test_double_click_flies_there(screen, state):
    screen.click(state, 640, 300)
    assert cmd.ZoomTo(640.0, 300.0) in screen.click(state, 640, 300)


def test_keys(screen, state):
    K = imgui.Key
    assert screen.press(state, K.g) == [cmd.Generate()]
    assert screen.press(state, K.enter) == [cmd.Generate()]
    assert screen.press(state, K.home) == [cmd.GoHome()]
    assert screen.press(state, K.escape) == [cmd.Escape()]
    assert screen.press(state, K.z, K.mod_ctrl) == [cmd.Undo()]
    assert screen.press(state, K.z, K.mod_ctrl, K.mod_shift) == [cmd.Redo()]
    assert screen.press(state, K.z) == []
    assert screen.press(state, K.s, K.mod_ctrl) == [cmd.Save()]  # and does not fly backwards
    assert screen.press(state, K.f1) == [cmd.Toggle("help")]


def test_held_keys_fly_as_long_as_the_frame(screen, state):
    (fly,) = screen.press(state, imgui.Key.w)
    assert fly == cmd.Fly(0.0, 0.0, 1.0, pytest.approx(1 / 60))
    (fast,) = screen.press(state, imgui.Key.a, imgui.Key.mod_shift)
    assert fast.right == -3.0


def test_the_start_page_has_no_picture_to_move(screen):
    start = empty_state(1280, 800)
    screen.move(20, 20)
    screen.frame(start)
    screen.io.add_mouse_wheel_event(0.0, 1.0)
    assert screen.frame(start) == []
    assert screen.press(start, imgui.Key.w) == []


def test_a_dialog_takes_escape_and_enter_only(screen, state):
    asking = replace(state, panels=Panels(dialog="unsaved"))
    assert screen.press(asking, imgui.Key.g) == []
    assert screen.press(asking, imgui.Key.enter) == [cmd.SettleUnsaved("save")]
    assert screen.press(asking, imgui.Key.escape) == [cmd.Escape()]
