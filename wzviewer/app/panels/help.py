"""Over all, on F1: the table of keys and gestures."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import BINDINGS, Binding
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, face, plate, shade
from wzviewer.app.state import AppState

WIDTH_PT, FRAME_PT = 800.0, 98.0  # the frame: title and margins
COLUMNS = (("Look", "Make"), ("File", "Panels", "Film"))
KEY_PT = 150.0  # width of the keys, before what they do
ROW_PT, HEAD_PT = 26.0, 34.0


def draw_help(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the help; a click anywhere closes it."""
    if not state.panels.help:
        return []
    window = ui.layout.window
    is_clicked = shade(ui)
    width, height = min(ui.pt(WIDTH_PT), window.width - 24), min(ui.pt(needed_pt()), window.height - 24)
    rect = Rect((window.width - width) / 2, (window.height - height) / 2, width, height)
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(28), ui.pt(24)))
    with plate("help", rect, alpha=0.97, scrolls=True, is_front=True):
        is_clicked |= imgui.is_window_hovered() and imgui.is_mouse_clicked(0)
        with face(ui.fonts.bold, theme.HEAD_PT):
            imgui.text_unformatted("Keys and gestures")
        left, top = imgui.get_cursor_pos_x(), imgui.get_cursor_pos_y() + ui.pt(8)
        part = (imgui.get_content_region_avail().x + ui.pt(16)) / len(COLUMNS)
        for number, groups in enumerate(COLUMNS):
            _column(ui, groups, left + number * part, top, part - ui.pt(16))
    imgui.pop_style_var()
    return [cmd.Toggle("help")] if is_clicked else []


def needed_pt() -> float:
    """Returns the height that shows all keys, pt."""
    columns = (sum(HEAD_PT + ROW_PT * len(rows_of(group)) for group in groups) for groups in COLUMNS)
    return max(columns) + FRAME_PT


def rows_of(group: str) -> list[Binding]:
    """Returns the keys of a group, in the order of the table."""
    return [binding for binding in BINDINGS if binding.group == group]


def _column(ui: Ui, groups: tuple[str, ...], left: float, y: float, width: float) -> None:
    for group in groups:
        imgui.set_cursor_pos((left, y + ui.pt(8)))
        with face(ui.fonts.bold, theme.SMALL_PT), colored(ui.colors.accent):
            imgui.text_unformatted(group.upper())
        y += ui.pt(HEAD_PT)
        for binding in rows_of(group):
            imgui.set_cursor_pos((left, y))
            imgui.text_unformatted(binding.label)
            imgui.set_cursor_pos((left + min(ui.pt(KEY_PT), 0.45 * width), y))
            with colored(ui.colors.muted):
                imgui.text_unformatted(binding.what)
            y += ui.pt(ROW_PT)
