"""Mouse and keyboard to commands."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from imgui_bundle import imgui

from tests.app.fakes import make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.input import WHEEL_LIMIT
from wzviewer.app.keys import key_named
from wzviewer.app.settings import Settings
from wzviewer.app.state import Panels, empty_state
from wzviewer.app.window import GlfwWindow
from wzviewer.gl.context import import_glfw

K = imgui.Key


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


def scroll(screen, state, steps, *modifiers):
    """Scrolls over the picture with keys held; returns all commands until it has come to rest."""
    screen.move(640, 300)
    screen.frame(state)
    for key in modifiers:
        screen.io.add_key_event(key, True)
    commands = []
    for right, down in steps:
        screen.io.add_mouse_wheel_event(right, down)
        commands += screen.frame(state)
    for _ in range(15):
        commands += screen.frame(state)
    for key in modifiers:
        screen.io.add_key_event(key, False)
    return commands + screen.frame(state)


@pytest.mark.parametrize(("key", "kind"), [(imgui.Key.mod_ctrl, "orbit"), (imgui.Key.mod_shift, "pan")])
def test_scrolling_with_a_key_held_is_a_drag_in_both_directions(screen, state, key, kind):
    assert scroll(screen, state, [(0.5, 0.25), (0.0, 0.0), (-0.25, 1.0)], key) == [
        cmd.BeginDrag(kind, 640.0, 300.0),
        cmd.DragTo(655.0, 307.5),
        cmd.DragTo(647.5, 337.5),
        cmd.EndDrag(),
    ]


def test_letting_the_key_go_ends_it_and_zooms_again(screen, state):
    screen.move(640, 300)
    screen.frame(state)
    screen.io.add_key_event(imgui.Key.mod_ctrl, True)
    screen.io.add_mouse_wheel_event(0.0, 1.0)
    screen.frame(state)
    screen.io.add_key_event(imgui.Key.mod_ctrl, False)
    screen.io.add_mouse_wheel_event(0.0, 1.0)
    assert screen.frame(state) == [cmd.EndDrag(), cmd.Zoom(640.0, 300.0, 1.0)]


def test_scrolling_sideways_alone_does_nothing(screen, state):
    assert scroll(screen, state, [(1.0, 0.0)]) == []


def test_a_burst_of_a_touchpad_is_limited(screen, state):
    assert scroll(screen, state, [(0.0, 90.0)]) == [cmd.Zoom(640.0, 300.0, WHEEL_LIMIT)]


def test_losing_the_focus_lets_go_of_keys_and_buttons(screen, state):
    screen.io.add_key_event(imgui.Key.w, True)
    assert [type(c) for c in screen.frame(state)] == [cmd.Fly]
    screen.io.add_focus_event(False)
    screen.frame(state)
    assert screen.frame(state) == []
    screen.io.add_focus_event(True)
    assert screen.frame(state) == []
    screen.move(640, 300)
    screen.frame(state)
    screen.io.add_mouse_button_event(0, True)
    screen.frame(state)
    screen.move(700, 300)
    assert [type(c) for c in screen.frame(state)] == [cmd.BeginDrag, cmd.DragTo]
    screen.io.add_focus_event(False)
    assert cmd.EndDrag() in screen.frame(state) + screen.frame(state)


def test_keys_that_fly_are_places_on_the_keyboard(screen, state):
    screen.letters = "zqsdae"  # as on a French keyboard
    (fly,) = screen.press(state, imgui.Key.z)
    assert (fly.right, fly.down, fly.forward) == (0.0, 0.0, 1.0)
    (left,) = screen.press(state, imgui.Key.q)
    assert left.right == -1.0
    assert screen.press(state, imgui.Key.w) == []
    assert screen.press(state, imgui.Key.z, imgui.Key.mod_ctrl) == [cmd.Undo()]


def test_ctrl_counts_as_it_was_when_the_key_went_down(screen, state):
    """In a long frame Ctrl comes up before imgui looks: Ctrl S must not fly backwards."""
    screen.modifiers = {imgui.Key.s: (True, False), imgui.Key.z: (True, True)}
    assert screen.press(state, imgui.Key.s) == [cmd.Save()]
    assert screen.press(state, imgui.Key.z) == [cmd.Redo()]
    screen.modifiers = {imgui.Key.s: (False, False)}
    assert [type(c) for c in screen.press(state, imgui.Key.s)] == [cmd.Fly]


def test_names_of_keys():
    assert key_named("Z") == imgui.Key.z
    assert key_named(",") == imgui.Key.comma
    assert [key_named(name) for name in ("", "é", "Esc", "1")] == [None] * 4


def test_keys_of_the_authors_viewer(screen, state):
    K = imgui.Key
    theirs = replace(state, settings=Settings(keymap="authors"))
    assert screen.press(theirs, K.r) == [cmd.Generate()]
    assert screen.press(theirs, K.z) == [cmd.Undo()]
    assert screen.press(theirs, K.x) == [cmd.Save()]
    assert screen.press(theirs, K.p) == [cmd.GoToNearest()]
    assert screen.press(theirs, K.f2) == [cmd.ToggleAuto()]
    assert screen.press(theirs, K.enter) == [cmd.Generate()]  # ours, where theirs are free
    (turn,) = screen.press(theirs, K.a)
    assert turn == cmd.Turn(-1.0, 0.0, pytest.approx(1 / 60))
    (fly,) = screen.press(theirs, K.right_arrow)
    assert (fly.right, fly.down, fly.forward) == (1.0, 0.0, 0.0)
    (closer,) = screen.press(theirs, K.v)
    (further,) = screen.press(theirs, K.b)
    assert closer.notches == -further.notches > 0
    assert screen.press(state, K.v) == [cmd.NextMode()]


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
    making = replace(state, panels=Panels(dialog="making"))
    assert screen.press(making, imgui.Key.enter) == [cmd.Escape()]


def test_a_shortcut_counts_when_ctrl_is_let_go_first_within_one_long_frame(screen):
    glfw = import_glfw()
    window = GlfwWindow.__new__(GlfwWindow)  # no display: only what follows keys
    window._modifiers, window._fresh = {}, set()
    window._glfw = SimpleNamespace(**{**vars(glfw), "get_key_name": lambda place, scancode: "a"})
    screen.io.config_input_trickle_event_queue = True  # as in the app
    text, selected = "ladybug", []

    def draw(state, ui):
        nonlocal text
        imgui.set_keyboard_focus_here() if not selected else None
        _, text = imgui.input_text("##line", text)
        if found := imgui.internal.get_input_text_state(imgui.get_item_id()):
            selected.append(abs(found.get_selection_end() - found.get_selection_start()))
        return []

    def event(place, key, is_down, held, mod=None):
        """As glfw reports it: to the window, and then to imgui's own callback."""
        window._on_key(None, place, 0, is_down, held)
        if mod is not None:
            screen.io.add_key_event(K.mod_ctrl, mod)
        screen.io.add_key_event(key, bool(is_down))

    state = empty_state(640, 420)
    for _ in range(4):
        screen.frame(state, draw)
    for is_down in (True, False):  # the cursor goes to the end: nothing is selected
        screen.io.add_key_event(K.end, is_down)
        screen.frame(state, draw)
    event(glfw.KEY_LEFT_CONTROL, K.left_ctrl, 1, 0, True)
    screen.frame(state, draw)  # Ctrl is down when the long frame begins
    assert selected[-1] == 0
    event(glfw.KEY_A, K.a, 1, glfw.MOD_CONTROL)
    event(glfw.KEY_LEFT_CONTROL, K.left_ctrl, 0, glfw.MOD_CONTROL, False)
    event(glfw.KEY_A, K.a, 0, 0)
    screen.frame(state, draw)
    assert selected[-1] == len("ladybug")
    screen.frame(state, draw)
    assert not screen.io.key_ctrl
