"""Mouse and keyboard, as imgui has gathered them, to commands.

Reads imgui's input only, so that it runs without a window: a test pushes events into `imgui.get_io()`.
Positions are framebuffer pixels, imgui's are logical points; a panel under the cursor keeps the mouse.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from types import MappingProxyType

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.keys import (
    FAST,
    LETTERS,
    SLOW,
    Binding,
    Held,
    Modifiers,
    keymap_of,
    matches,
    works_while_typing,
)
from wzviewer.app.state import AppState, DragKind
from wzviewer.app.summoning import covers_picture

LEFT, RIGHT, MIDDLE = 0, 1, 2
KEYS_OVER = frozenset((imgui.Key.escape, imgui.Key.f1, imgui.Key.f12))  # alive over a covered picture
SIDE_BUTTONS: dict[int, type[cmd.Command]] = {3: cmd.GoBack, 4: cmd.GoForward}
ANSWERS: dict[str, cmd.Command] = {  # what Enter says; a file, to the others
    "drop": cmd.SettleDrop("insert"),
    "making": cmd.Escape(),
    "recover": cmd.SettleRecovery("recover"),
    "unsaved": cmd.SettleUnsaved("save"),
}
DRAG_PX = 4.0  # a hand trembles while it clicks
LONGEST_STEP_S = 0.1  # a stall is no reason to jump
SCROLL_PT = 30.0  # that a notch moves what is held by Ctrl or Shift
SCROLL_REST_S = 0.2  # without scrolling, after which it is let go
ZOOM_RATE = 5.0  # notches a second, of a key that is held
WHEEL_LIMIT = 4.0  # notches in a frame: some touchpads report bursts


@dataclass(frozen=True)
class Scroll:
    """Fingers on a touchpad that turn or shift the picture: the same as a drag, in steps.

    Attributes:
        kind: which of both.
        at_px: where the cursor was when it began.
        by_px: how far it has gone.
        rest_s: time since the last step, s.
    """

    kind: DragKind
    at_px: tuple[float, float]
    by_px: tuple[float, float] = (0.0, 0.0)
    rest_s: float = 0.0


@dataclass(frozen=True)
class Hand:
    """What the mouse is doing between frames.

    Attributes:
        button: that was pressed over the picture; None when none is down.
        at_px: where it was pressed.
        is_dragging: whether it has moved far enough.
        scroll: what Ctrl or Shift with the wheel is doing, or None.
    """

    button: int | None = None
    at_px: tuple[float, float] = (0.0, 0.0)
    is_dragging: bool = False
    scroll: Scroll | None = None


def read_input(
    state: AppState, hand: Hand, letters: str = LETTERS, modifiers: Modifiers = MappingProxyType({})
) -> tuple[Hand, list[cmd.Command]]:
    """Returns the commands of this frame's mouse and keyboard; call between new_frame and render.

    Args:
        state: of the app.
        hand: as the last frame left it.
        letters: printed on the keyboard at the places of W A S D Q E.
        modifiers: held at the last press of each key, as far as that is known.
    """
    hand, commands = _read_mouse(state, hand)
    return hand, [*commands, *_read_keys(state, letters, modifiers)]


def typed_ahead(state: AppState) -> list[cmd.Command]:
    """Returns what was typed while the cursor is on its way to the prompt line; call before the panels.

    The line itself drops what comes before it has the cursor: on slow frames a word or two.
    """
    is_coming = state.panels.prompt_focus > 0 and not imgui.get_io().want_text_input
    text = _typed() if is_coming else ""
    if state.panels.prompt_focus == cmd.FocusPrompt().frames:  # a mouse that moved kept the sign from its key
        text = text.removeprefix("/")
    return [cmd.EditPrompt(state.prompt + text)] if text else []


def _typed() -> str:
    """The characters of this frame that no field has taken."""
    return "".join(c for c in map(chr, imgui.get_io().input_queue_characters) if c.isprintable())


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
    is_over_picture = state.has_document and not io.want_capture_mouse and imgui.is_mouse_pos_valid()
    hand, asked = _scrolled(hand, (x, y), is_over_picture)
    commands += asked
    if not is_over_picture:
        return hand, commands
    if io.mouse_wheel and _scroll_kind() is None:
        commands.append(cmd.Zoom(x, y, _limited(io.mouse_wheel)))
    for button, command in SIDE_BUTTONS.items():
        if imgui.is_mouse_clicked(button):
            commands.append(command())
    if imgui.is_mouse_double_clicked(LEFT):
        return Hand(), [*commands, cmd.ZoomTo(x, y)]
    for button in (LEFT, RIGHT, MIDDLE):
        if hand.button is None and imgui.is_mouse_clicked(button):
            commands += [cmd.EndDrag()] if hand.scroll is not None else []
            hand = Hand(button, (x, y))
    return hand, commands


def _scroll_kind() -> DragKind | None:
    """What scrolling does besides zooming, by the modifiers that are held."""
    io = imgui.get_io()
    return "orbit" if io.key_ctrl else "pan" if io.key_shift else None


def _limited(notches: float) -> float:
    return max(-WHEEL_LIMIT, min(WHEEL_LIMIT, notches))


def _scrolled(
    hand: Hand, at_px: tuple[float, float], is_over_picture: bool
) -> tuple[Hand, list[cmd.Command]]:
    """Follows Ctrl or Shift with the wheel: begin, steps in both directions, end."""
    io = imgui.get_io()
    scroll, kind = hand.scroll, _scroll_kind()
    steps = (_limited(io.mouse_wheel_h), _limited(io.mouse_wheel))
    commands: list[cmd.Command] = []
    is_stepping = any(steps) and is_over_picture
    rest_s = 0.0 if is_stepping or scroll is None else scroll.rest_s + io.delta_time
    if scroll is not None and (kind != scroll.kind or rest_s > SCROLL_REST_S):
        scroll = None
        commands.append(cmd.EndDrag())
    if is_stepping and scroll is None and kind is not None and hand.button is None:
        scroll = Scroll(kind, at_px)
        commands.append(cmd.BeginDrag(kind, *at_px))
    if scroll is not None and is_stepping:
        ratio = io.display_framebuffer_scale.x
        right, down = (by + SCROLL_PT * ratio * step for by, step in zip(scroll.by_px, steps, strict=True))
        scroll = replace(scroll, by_px=(right, down))
        commands.append(cmd.DragTo(scroll.at_px[0] + right, scroll.at_px[1] + down))
    scroll = replace(scroll, rest_s=rest_s) if scroll is not None else None
    return replace(hand, scroll=scroll), commands


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


def _read_keys(state: AppState, letters: str, modifiers: Modifiers) -> list[cmd.Command]:
    io = imgui.get_io()
    if state.panels.dialog:
        return _answer(state)
    if state.palette.is_open:  # which reads its own
        return []
    keymap = keymap_of(state.settings.keymap, letters)
    if io.want_text_input:  # other keys are for the line, which reads its own Enter and Escape
        if io.key_alt:  # AltGr, which some systems report as Ctrl and Alt, types signs
            return []
        return _pressed([b for b in keymap.bindings if works_while_typing(b)], modifiers)
    if state.panels.prompt_focus:  # what is typed goes into the line
        return []
    if imgui.is_popup_open("", imgui.PopupFlags_.any_popup.value):  # a menu takes Escape, and no other key
        if imgui.is_key_pressed(imgui.Key.escape, repeat=False):
            imgui.internal.close_popup_to_level(0, True)
        return []
    is_covered = covers_picture(state)
    commands = _pressed(keymap.bindings, modifiers, is_covered)
    if cmd.FocusPrompt() in commands:  # in the same frame: what follows the slash is for the line
        text = _typed().partition("/")[2]
        return [cmd.FocusPrompt(), *([cmd.EditPrompt(state.prompt + text)] if text else [])]
    if io.key_ctrl or is_covered or not state.has_document:
        return commands
    held = [
        what
        for key, what in keymap.held.items()
        if imgui.is_key_down(key) and not modifiers.get(key, (False, False))[0]
    ]
    return [*commands, *_moves(state, held)] if held else commands


def _pressed(
    bindings: Iterable[Binding], modifiers: Modifiers, is_covered: bool = False
) -> list[cmd.Command]:
    """What the keys that were pressed in this frame ask for."""
    io, commands = imgui.get_io(), list[cmd.Command]()
    for binding in bindings:
        keys = KEYS_OVER.intersection(binding.keys) if is_covered and not binding.ctrl else binding.keys
        pressed = [key for key in keys if imgui.is_key_pressed(key, repeat=False)]
        held_with = modifiers.get(pressed[0], (io.key_ctrl, io.key_shift)) if pressed else (False, False)
        if pressed and binding.command is not None and matches(binding, *held_with):
            commands.append(binding.command())
    return commands


def _answer(state: AppState) -> list[cmd.Command]:
    """A dialog takes Escape and Enter and no other key; its line of text reads its own Enter."""
    if imgui.is_key_pressed(imgui.Key.escape, repeat=False):
        return [cmd.Escape()]
    if imgui.get_io().want_text_input:
        return []
    if imgui.is_key_pressed(imgui.Key.enter, repeat=False):
        return [ANSWERS.get(state.panels.dialog, cmd.ConfirmPath())]
    return []


def _moves(state: AppState, held: list[Held]) -> list[cmd.Command]:
    """What the keys that are held do in this frame."""
    io, camera = imgui.get_io(), state.view.camera
    speed = FAST if io.key_shift else SLOW if io.key_alt else 1.0
    dt_s = min(io.delta_time, LONGEST_STEP_S)
    right, down, forward = (speed * sum(what.fly[axis] for what in held) for axis in range(3))
    turn_right, turn_down = (speed * sum(what.turn[axis] for what in held) for axis in range(2))
    closer = speed * sum(what.zoom for what in held)
    commands: list[cmd.Command] = []
    if right or down or forward:
        commands.append(cmd.Fly(right, down, forward, dt_s))
    if turn_right or turn_down:
        commands.append(cmd.Turn(turn_right, turn_down, dt_s))
    if closer:
        commands.append(cmd.Zoom(camera.width / 2, camera.height / 2, closer * ZOOM_RATE * dt_s))
    return commands
