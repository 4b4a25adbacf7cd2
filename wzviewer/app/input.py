"""Mouse and keyboard, as imgui has gathered them, to commands.

Reads imgui's input only, so that it runs without a window: a test pushes events into `imgui.get_io()`.
Positions are framebuffer pixels, imgui's are logical points; a panel under the cursor keeps the mouse.
"""

from dataclasses import dataclass, replace

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.keys import BINDINGS, FAST, FLY_KEYS, SLOW, matches
from wzviewer.app.state import AppState

LEFT, RIGHT, MIDDLE = 0, 1, 2
SIDE_BUTTONS: dict[int, type[cmd.Command]] = {3: cmd.GoBack, 4: cmd.GoForward}
DRAG_PX = 4.0  # a hand trembles while it clicks
LONGEST_STEP_S = 0.1  # a stall is no reason to jump
WHEEL_LIMIT = 4.0  # notches in a frame: some touchpads report bursts


@dataclass(frozen=True)
class Hand:
    """What the mouse is doing between frames.

    Attributes:
        button: that was pressed over the picture; None when none is down.
        at_px: where it was pressed.
        is_dragging: whether it has moved far enough.
    """

    button: int | None = None
    at_px: tuple[float, float] = (0.0, 0.0)
    is_dragging: bool = False


def read_input(state: AppState, hand: Hand) -> tuple[Hand, list[cmd.Command]]:
    """Returns the commands of this frame's mouse and keyboard; call between new_frame and render."""
    hand, commands = _read_mouse(state, hand)
    return hand, [*commands, *_read_keys(state)]


def mouse_px() -> tuple[float, float]:
    """Returns the cursor in framebuffer pixels."""
    io = imgui.get_io()
    ratio = io.display_framebuffer_scale
    return io.mouse_pos.x * ratio.x, io.mouse_pos.y * ratio.y


def _read_mouse(state: AppState, hand: Hand) -> tuple[Hand, list[cmd.Command]]:
    io = imgui.get_io()
    x, y = mouse_px()
    commands: list[cmd.Command] = []
    if hand.button is not None:
        hand, commands = _held(hand, x, y)
    if io.want_capture_mouse or not state.has_document or not imgui.is_mouse_pos_valid():
        return hand, commands
    if io.mouse_wheel:
        notches = max(-WHEEL_LIMIT, min(WHEEL_LIMIT, io.mouse_wheel))
        commands.append(cmd.Zoom(x, y, notches))
    for button, command in SIDE_BUTTONS.items():
        if imgui.is_mouse_clicked(button):
            commands.append(command())
    if imgui.is_mouse_double_clicked(LEFT):
        return Hand(), [*commands, cmd.ZoomTo(x, y)]
    for button in (LEFT, RIGHT, MIDDLE):
        if hand.button is None and imgui.is_mouse_clicked(button):
            hand = Hand(button, (x, y))
    return hand, commands


def _held(hand: Hand, x: float, y: float) -> tuple[Hand, list[cmd.Command]]:
    """Follows the button that is down: nothing, a drag, or its end."""
    assert hand.button is not None  # the caller saw it
    if not imgui.is_mouse_down(hand.button):
        return Hand(), [cmd.EndDrag()] if hand.is_dragging else []
    far = max(abs(x - hand.at_px[0]), abs(y - hand.at_px[1])) >= DRAG_PX
    if hand.is_dragging:
        return hand, [cmd.DragTo(x, y)]
    if not far:
        return hand, []
    pans = hand.button == RIGHT or imgui.get_io().key_shift
    begin = cmd.BeginDrag("pan" if pans else "orbit", *hand.at_px)
    return replace(hand, is_dragging=True), [begin, cmd.DragTo(x, y)]


def _read_keys(state: AppState) -> list[cmd.Command]:
    io = imgui.get_io()
    if state.panels.dialog:
        return _answer(state)
    if io.want_text_input:  # keys are dead while typing; the prompt line reads its own Enter and Escape
        return []
    if imgui.is_popup_open("", imgui.PopupFlags_.any_popup.value):  # a menu takes Escape, and no other key
        if imgui.is_key_pressed(imgui.Key.escape, repeat=False):
            imgui.internal.close_popup_to_level(0, True)
        return []
    commands: list[cmd.Command] = []
    for binding in BINDINGS:
        pressed = any(imgui.is_key_pressed(key, repeat=False) for key in binding.keys)
        if pressed and binding.command is not None and matches(binding, io.key_ctrl, io.key_shift):
            commands.append(binding.command())
    if io.key_ctrl or not state.has_document:
        return commands
    return [*commands, *_fly(io.key_shift, io.key_alt)]


def _answer(state: AppState) -> list[cmd.Command]:
    """A dialog takes Escape and Enter and no other key; its line of text reads its own Enter."""
    if imgui.is_key_pressed(imgui.Key.escape, repeat=False):
        return [cmd.Escape()]
    if state.panels.dialog == "drop" and imgui.is_key_pressed(imgui.Key.enter, repeat=False):
        return [cmd.SettleDrop("insert")]
    if state.panels.dialog == "recover" and imgui.is_key_pressed(imgui.Key.enter, repeat=False):
        return [cmd.SettleRecovery("recover")]
    if state.panels.dialog == "unsaved" and imgui.is_key_pressed(imgui.Key.enter, repeat=False):
        return [cmd.SettleUnsaved("save")]
    return []


def _fly(is_fast: bool, is_slow: bool) -> list[cmd.Command]:
    held = [step for key, step in FLY_KEYS.items() if imgui.is_key_down(key)]
    if not held:
        return []
    speed = FAST if is_fast else SLOW if is_slow else 1.0
    right, down, forward = (speed * sum(step[axis] for step in held) for axis in range(3))
    return [cmd.Fly(right, down, forward, min(imgui.get_io().delta_time, LONGEST_STEP_S))]
