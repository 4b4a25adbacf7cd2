"""Over all, on Ctrl K: a line of text, and below it the commands that it may mean."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.palette import Entry, entries_of, found
from wzviewer.app.panels.surface import Ui, colored, elided, face, plate, shade
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

WIDTH_PT = 560.0
TOP = 0.12  # of the window's height
PADDING_PT, FIELD_PT, ROW_PT = 12.0, 34.0, 34.0
MAX_ROWS = 9
ENTERS = (imgui.Key.enter, imgui.Key.keypad_enter)


def draw_palette(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the palette; a command that is chosen closes it and follows."""
    if not state.palette.is_open:
        return []
    hits = found(entries_of(state, ui.letters), state.palette.text)
    window = ui.layout.window
    top = TOP * window.height
    room = int((window.height - top - ui.pt(2 * PADDING_PT + FIELD_PT + 20)) / ui.pt(ROW_PT))
    first, rows = shown(state.palette.marked, len(hits), min(MAX_ROWS, max(room, 1)))
    width = min(ui.pt(WIDTH_PT), window.width - ui.pt(24))
    height = ui.pt(2 * PADDING_PT + FIELD_PT + 8 + ROW_PT * max(rows, 1))
    is_left = shade(ui) or imgui.is_key_pressed(imgui.Key.escape, repeat=False)
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(PADDING_PT), ui.pt(PADDING_PT)))
    with plate("palette", Rect((window.width - width) / 2, top, width, height), alpha=0.98, is_front=True):
        commands, chosen = _field(state, hits)
        if not hits:
            _nothing(ui)
        for number in range(first, first + rows):
            if _row(ui, number - first, hits[number], number == marked_of(state, hits)):
                chosen = hits[number]
    imgui.pop_style_var()
    if chosen is not None:
        return [cmd.ClosePalette(), chosen.command]
    return [cmd.ClosePalette()] if is_left else commands


def marked_of(state: AppState, hits: list[Entry]) -> int:
    """Returns which of the hits is marked."""
    return state.palette.marked % len(hits) if hits else 0


def shown(marked: int, count: int, rows: int) -> tuple[int, int]:
    """Returns the first of the hits in view and how many: the marked one is among them."""
    if count <= rows:
        return 0, count
    marked %= count
    return min(max(marked - rows // 2, 0), count - rows), rows


def _field(state: AppState, hits: list[Entry]) -> tuple[list[cmd.Command], Entry | None]:
    """The line of text; Up and Down mark another entry, Enter runs it."""
    F, commands = imgui.InputTextFlags_, list[cmd.Command]()

    def on_key(data: imgui.InputTextCallbackData) -> int:
        commands.append(cmd.MarkEntry(1 if data.event_key == imgui.Key.down_arrow else -1))
        return 0

    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(-1.0)
    flags = F.callback_history.value
    changed, text = imgui.input_text_with_hint("##find", "What to do", state.palette.text, flags, on_key)
    if changed and not imgui.is_key_pressed(imgui.Key.escape):
        commands.append(cmd.EditPalette(text))
    entered = imgui.is_item_deactivated() and any(imgui.is_key_pressed(key, repeat=False) for key in ENTERS)
    return commands, hits[marked_of(state, hits)] if entered and hits else None


def _nothing(ui: Ui) -> None:
    imgui.set_cursor_pos((ui.pt(PADDING_PT + 10), ui.pt(PADDING_PT + FIELD_PT + 16)))
    with colored(ui.colors.muted):
        imgui.text_unformatted("No such command")


def _row(ui: Ui, row: int, entry: Entry, is_marked: bool) -> bool:
    width, height = imgui.get_window_size().x - ui.pt(2 * PADDING_PT), ui.pt(ROW_PT)
    imgui.set_cursor_pos((ui.pt(PADDING_PT), ui.pt(PADDING_PT + FIELD_PT + 8) + row * height))
    at = imgui.get_cursor_screen_pos()
    pressed = imgui.invisible_button(entry.title, (width, height))
    draw = imgui.get_window_draw_list()
    if is_marked or imgui.is_item_hovered():
        color = ui.colors.pressed if is_marked else ui.colors.hover
        draw.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), u32(color), ui.pt(7))
    y = at.y + (height - imgui.get_text_line_height()) / 2
    keys = 0.0
    with face(ui.fonts.regular, theme.SMALL_PT):
        keys = imgui.calc_text_size(entry.keys).x
        beside = (at.x + width - keys - ui.pt(10), at.y + (height - imgui.get_text_line_height()) / 2)
        draw.add_text(beside, u32(ui.colors.muted), entry.keys)
    title = elided(entry.title, width - keys - ui.pt(34))
    draw.add_text((at.x + ui.pt(10), y), u32(ui.colors.accent if is_marked else ui.colors.text), title)
    return bool(pressed)
