"""At the foot, on request: the keys of a film on a ruler, their times, and the preview's controls."""

from dataclasses import dataclass

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import label_of
from wzviewer.app.layout import MARGIN_PT, Rect
from wzviewer.app.panels.surface import Ui, colored, face, plate, quiet, small, tooltip
from wzviewer.app.panels.wording import magnification_text
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.core.keyframes import SECONDS_LIMIT, Pace

HEIGHT_PT = 126.0
BUTTON_PT, GAP_PT, CLOCK_PT, SECONDS_PT = 32.0, 2.0, 118.0, 76.0
RULER_PT, KEY_PT = 46.0, 9.0  # height of the ruler, half of a key's diagonal
PACES: tuple[tuple[Pace, str, str], ...] = (
    ("flow", icons.ICON_FA_BEZIER_CURVE, "Go smoothly through this key"),
    ("stop", icons.ICON_FA_PAUSE, "Come to rest at this key"),
    ("corner", icons.ICON_FA_ANGLE_UP, "Do not slow down: turn at once"),
)
TICKS_S = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0)
TICK_PT = 54.0  # between two labels


def foot_height(state: AppState, scale: float) -> float:
    """Returns what the timeline takes off the foot of the window, imgui units."""
    return (HEIGHT_PT + MARGIN_PT) * scale if is_shown(state) else 0.0


def is_shown(state: AppState) -> bool:
    """Whether the timeline is on the screen."""
    return state.panels.timeline and len(state.scene) > 0


def draw_timeline(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel."""
    if not is_shown(state):
        return []
    window, margin, height = ui.layout.window, ui.pt(MARGIN_PT), ui.pt(HEIGHT_PT)
    rect = Rect(margin, window.height - margin - height, window.width - 2 * margin, height)
    with plate("timeline", rect, alpha=0.95):
        commands = _controls(state, ui, rect)
        imgui.set_cursor_pos_y(height - ui.pt(RULER_PT + 20.0))
        if state.timeline.path.keys:
            return commands + _ruler(state, ui)
        _invitation(ui)
    return commands


def _invitation(ui: Ui) -> None:
    line = f"Fly to a view and press {label_of(cmd.AddKey)}; then to the next one. "
    imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() + ui.pt(16))
    small(ui, line + f"Or begin with {icons.ICON_FA_ROUTE} above.")


# ------------------------------------------------------------------ controls


@dataclass(frozen=True)
class _Button:
    icon: str
    what: str
    command: cmd.Command
    is_possible: bool = True
    is_lit: bool = False


def _controls(state: AppState, ui: Ui, rect: Rect) -> list[cmd.Command]:
    """The row of buttons: preview, the selected key, and the whole path."""
    commands: list[cmd.Command] = []
    step, whole = ui.pt(BUTTON_PT + GAP_PT), _whole_buttons(state)
    right = rect.width - ui.pt(14) - (len(whole) + 2) * step
    has_clock = right > ui.pt(14 + CLOCK_PT) + 6 * step
    keys_x = ui.pt(14 + (CLOCK_PT if has_clock else 8.0)) + 3 * step
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (ui.pt(GAP_PT), ui.pt(7)))
    with quiet():
        commands += _row(ui, _preview_buttons(state))
        if has_clock:
            _clock(state, ui)
        imgui.same_line(keys_x)
        commands += _row(ui, _key_buttons(state))
        commands += _selected(state, ui, right - keys_x - 3 * step)
        imgui.same_line(right)
        commands += _menus(state, ui)
        imgui.same_line()
        commands += _row(ui, whole)
    imgui.pop_style_var()
    return commands


def _clock(state: AppState, ui: Ui) -> None:
    line = state.timeline
    imgui.same_line(0.0, ui.pt(10))
    imgui.align_text_to_frame_padding()
    with colored(ui.colors.text if line.path.keys else ui.colors.muted):
        imgui.text_unformatted(f"{line.at_s:.1f} / {line.path.duration_s:.1f} s")


def _preview_buttons(state: AppState) -> tuple[_Button, ...]:
    line = state.timeline
    icon = icons.ICON_FA_PAUSE if line.is_playing else icons.ICON_FA_PLAY
    has_keys, can_play = bool(line.path.keys), line.path.num_pieces > 0
    return (
        _Button(icons.ICON_FA_BACKWARD_STEP, "The key before   ,", cmd.StepKey(-1), has_keys),
        _Button(icon, "Play, stop   Space", cmd.TogglePlay(), can_play, line.is_playing),
        _Button(icons.ICON_FA_FORWARD_STEP, "The key after   .", cmd.StepKey(1), has_keys),
    )


def _key_buttons(state: AppState) -> tuple[_Button, ...]:
    has_key = state.timeline.selected is not None
    update = "Give the selected key the view on screen"
    return (
        _Button(icons.ICON_FA_CIRCLE_PLUS, f"Add the view as a key   {label_of(cmd.AddKey)}", cmd.AddKey()),
        _Button(icons.ICON_FA_CAMERA_ROTATE, update, cmd.UpdateKey(), has_key),
        _Button(icons.ICON_FA_TRASH_CAN, "Delete the selected key   Del", cmd.DeleteKey(), has_key),
    )


def _whole_buttons(state: AppState) -> tuple[_Button, ...]:
    line = state.timeline
    can_play = line.path.num_pieces > 0
    return (
        _Button(icons.ICON_FA_REPEAT, "Loop", cmd.ToggleLoop(), len(line.path.keys) > 1, line.path.is_loop),
        _Button(icons.ICON_FA_FILM, "Film through these keys", cmd.PlanKeysFilm(), can_play),
        _Button(icons.ICON_FA_XMARK, "Close the timeline   L", cmd.Toggle("timeline")),
    )


def _row(ui: Ui, buttons: tuple[_Button, ...]) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    for number, button in enumerate(buttons):
        if number:
            imgui.same_line()
        if _pressed(ui, button):
            commands.append(button.command)
    return commands


def _pressed(ui: Ui, button: _Button) -> bool:
    size = (ui.pt(BUTTON_PT), ui.pt(30))
    imgui.begin_disabled(not button.is_possible)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, ui.pt(5)))
    with colored(ui.colors.accent if button.is_lit else ui.colors.text):
        is_pressed = imgui.button(f"{button.icon}##{button.what}", size)
    imgui.pop_style_var()
    imgui.end_disabled()
    tooltip(button.what)
    return bool(is_pressed)


def _selected(state: AppState, ui: Ui, room: float) -> list[cmd.Command]:
    """How the path goes through the selected key, and the time to the next; as far as there is room."""
    path, index = state.timeline.path, state.timeline.selected
    paces = ui.pt(14) + len(PACES) * ui.pt(BUTTON_PT + GAP_PT)
    if index is None or index >= len(path.keys) or room < paces:
        return []
    commands: list[cmd.Command] = []
    key = path.keys[index]
    imgui.same_line(0.0, ui.pt(14))
    for number, (pace, icon, what) in enumerate(PACES):
        if number:
            imgui.same_line()
        if _pressed(ui, _Button(icon, what, cmd.SetKeyPace(index, pace), is_lit=key.pace == pace)):
            commands.append(cmd.SetKeyPace(index, pace))
    if index >= path.num_pieces or room < paces + ui.pt(12 + SECONDS_PT + 12):
        return commands
    imgui.same_line(0.0, ui.pt(12))
    imgui.set_next_item_width(ui.pt(SECONDS_PT))
    with colored(ui.colors.field, imgui.Col_.frame_bg):
        is_changed, seconds = imgui.drag_float("##seconds", key.seconds, 0.02, *SECONDS_LIMIT, "%.1f s")
    tooltip("Time to the next key: drag, or double click and type")
    if is_changed:
        commands.append(cmd.SetKeySeconds(index, seconds, is_done=False))
    elif imgui.is_item_deactivated() and state.timeline.is_retiming:
        commands.append(cmd.SetKeySeconds(index, key.seconds))
    return commands


def _menus(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Keys to begin with, and files."""
    commands: list[cmd.Command] = []
    begin = _Button(icons.ICON_FA_ROUTE, "Begin with ready keys", cmd.ClearKeys())
    if _pressed(ui, begin):
        imgui.open_popup("ready keys")
    corner = (imgui.get_item_rect_max().x, imgui.get_window_pos().y - ui.pt(6))
    imgui.same_line()
    if _pressed(ui, _Button(icons.ICON_FA_FILE_EXPORT, "Camera paths as files", cmd.ClearKeys())):
        imgui.open_popup("path files")
    line = state.timeline
    imgui.set_next_window_pos(corner, imgui.Cond_.always.value, (0.5, 1.0))
    if imgui.begin_popup("ready keys"):
        commands += _items(
            ("The way from the photo to here", cmd.FillKeys("way"), True),
            ("Every level down to here", cmd.FillKeys("levels"), True),
            (f"An orbit, {state.plan.orbit_deg:.0f}° to either side", cmd.FillKeys("orbit"), True),
            ("", cmd.ClearKeys(), True),
            ("Take back the last change", cmd.BringBackKeys(), bool(line.past)),
            ("Remove all keys", cmd.ClearKeys(), bool(line.path.keys)),
        )
        imgui.end_popup()
    imgui.set_next_window_pos(corner, imgui.Cond_.always.value, (0.5, 1.0))
    if imgui.begin_popup("path files"):
        commands += _items(
            ("Open a camera path…", cmd.AskPath(True), True),
            ("Save as camera path…", cmd.AskPath(False), bool(line.path.keys)),
        )
        imgui.separator()
        small(ui, "JSON, as nerfstudio has it")
        imgui.end_popup()
    return commands


def _items(*items: tuple[str, cmd.Command, bool]) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    for name, command, is_possible in items:
        if not name:
            imgui.separator()
        elif imgui.menu_item_simple(name, "", False, is_possible):
            commands.append(command)
    return commands


# ------------------------------------------------------------------ ruler


@dataclass(frozen=True)
class _Ruler:
    """Where moments lie."""

    x: float
    y: float
    width: float
    height: float
    span_s: float

    def x_of(self, time_s: float) -> float:
        return self.x + self.width * time_s / self.span_s

    def time_at(self, x: float) -> float:
        return min(max((x - self.x) / self.width, 0.0), 1.0) * self.span_s


def _ruler(state: AppState, ui: Ui) -> list[cmd.Command]:
    at = imgui.get_cursor_screen_pos()
    room, pad = imgui.get_content_region_avail().x, ui.pt(KEY_PT + 3)
    ruler = _Ruler(at.x + pad, at.y, room - 2 * pad, ui.pt(RULER_PT), state.timeline.span_s)
    _ticks(ui, ruler, state.timeline.path.duration_s)
    commands = _keys(state, ui, ruler)
    imgui.set_cursor_screen_pos((at.x, at.y))
    imgui.invisible_button("ruler", (room, ui.pt(RULER_PT)))
    if imgui.is_item_active():
        commands.append(cmd.ScrubTo(ruler.time_at(imgui.get_mouse_pos().x)))
    _playhead(ui, ruler, state.timeline.at_s)
    return commands


def _ticks(ui: Ui, ruler: _Ruler, duration_s: float) -> None:
    draw = imgui.get_window_draw_list()
    middle = ruler.y + ui.pt(31)
    bar = ((ruler.x, middle - ui.pt(3)), (ruler.x + ruler.width, middle + ui.pt(3)))
    draw.add_rect_filled(*bar, u32(ui.colors.field), ui.pt(3))
    end = (ruler.x_of(duration_s), middle + ui.pt(3))
    draw.add_rect_filled(bar[0], end, u32(ui.colors.accent, 0.45), ui.pt(3))
    per_label = ruler.span_s * ui.pt(TICK_PT) / ruler.width
    step = next((s for s in TICKS_S if s >= per_label), TICKS_S[-1])
    with face(ui.fonts.regular, theme.SMALL_PT - 1.5):
        for number in range(int(ruler.span_s / step + 1e-6) + 1):
            x = ruler.x_of(number * step)
            label = f"{number * step:g} s" if number else "0"
            width = imgui.calc_text_size(label).x
            x_label = min(x - width / 2, ruler.x + ruler.width - width)
            draw.add_text((x_label, ruler.y), u32(ui.colors.muted), label)
            draw.add_line((x, ruler.y + ui.pt(15)), (x, ruler.y + ui.pt(20)), u32(ui.colors.faint), ui.pt(1))


def _keys(state: AppState, ui: Ui, ruler: _Ruler) -> list[cmd.Command]:
    """Diamonds that can be pressed and dragged; a loop has one more, for its end."""
    commands: list[cmd.Command] = []
    line = state.timeline
    times = [*line.path.times_s, line.path.duration_s][: line.path.num_pieces + 1]
    half = ui.pt(KEY_PT)
    y = ruler.y + ui.pt(31)
    for index, time_s in reversed(list(enumerate(times))):  # of two at one place, the later is dragged
        x = ruler.x_of(time_s)
        is_end = index == len(line.path.keys)
        imgui.set_cursor_screen_pos((x - half, y - half))
        imgui.invisible_button(f"key {index}", (2 * half, 2 * half))
        is_hot = imgui.is_item_hovered() or imgui.is_item_active()
        if imgui.is_item_activated() and not is_end:
            commands.append(cmd.SelectKey(index))
        if index and imgui.is_item_active() and imgui.is_mouse_dragging(0, ui.pt(3)):
            commands.append(cmd.RetimeKey(index, ruler.time_at(imgui.get_mouse_pos().x)))
        if index and imgui.is_item_deactivated() and line.is_retiming:
            commands.append(cmd.RetimeKey(index, time_s, is_done=True))
        _diamond(ui, (x, y), is_lit=line.selected == index, is_hot=is_hot, is_end=is_end)
        if is_hot:
            imgui.set_tooltip(_about(state, index, time_s))
    return commands


def _about(state: AppState, index: int, time_s: float) -> str:
    keys = state.timeline.path.keys
    if index == len(keys):
        return f"Back at the first key, {time_s:.2f} s"
    ratio = keys[index].camera.focal_px / keys[index].camera.width
    home = state.view.home
    magnification = magnification_text(ratio / (home.focal_px / home.width))
    return f"Key {index + 1}, {time_s:.2f} s, {magnification}"


def _diamond(ui: Ui, at: tuple[float, float], is_lit: bool, is_hot: bool, is_end: bool) -> None:
    x, y = at
    half = ui.pt(KEY_PT - (1.5 if is_end else 0.0))
    corners = ((x, y - half), (x + half, y), (x, y + half), (x - half, y))
    draw = imgui.get_window_draw_list()
    fill = ui.colors.accent if is_lit or is_hot else ui.colors.text
    if not is_end:
        draw.add_quad_filled(*corners, u32(fill))
    draw.add_quad(*corners, u32(ui.colors.solid if not is_end else fill), ui.pt(1.5))


def _playhead(ui: Ui, ruler: _Ruler, time_s: float) -> None:
    draw = imgui.get_window_draw_list()
    x = ruler.x_of(min(time_s, ruler.span_s))
    top, bottom = ruler.y + ui.pt(13), ruler.y + ruler.height + ui.pt(2)
    draw.add_line((x, top), (x, bottom), u32(ui.colors.accent), ui.pt(2))
    wing = ui.pt(5)
    draw.add_triangle_filled((x - wing, top), (x + wing, top), (x, top + wing), u32(ui.colors.accent))
