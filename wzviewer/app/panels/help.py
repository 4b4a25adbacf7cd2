"""Over all, on F1: the table of keys and gestures."""

from itertools import chain

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import LETTERS, Binding, keymap_of
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, face, plate, shade
from wzviewer.app.settings import KeymapName
from wzviewer.app.state import AppState

WIDTH_PT = 800.0
COLUMN_PT = 380.0  # narrowest; below it one column has all groups, and scrolls
TITLES = {"wzviewer": "Keys and gestures", "authors": "Keys of the authors' release, and gestures"}
COLUMNS = (("Look", "File", "Film"), ("Make", "Panels"))  # about equally long
KEY_PT = 158.0  # width of the keys, before what they do
ROW_PT, HEAD_PT, TITLE_PT = 23.0, 30.0, 36.0
PADDING_PT = 16.0
DENSEST = 0.76  # of these heights, where the window is low; then it scrolls


def draw_help(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the help; a click anywhere closes it."""
    if not state.panels.help:
        return []
    window = ui.layout.window
    is_clicked = shade(ui)
    keymap = state.settings.keymap
    width = min(ui.pt(WIDTH_PT), window.width - 24)
    is_narrow = width < ui.pt(len(COLUMNS) * COLUMN_PT)
    groups = [tuple(chain(*COLUMNS))] if is_narrow else COLUMNS
    columns = [[(group, rows_of(group, keymap, ui.letters)) for group in column] for column in groups]
    wanted = max(sum(HEAD_PT + ROW_PT * len(rows) for _, rows in column) for column in columns)
    frame, most = ui.pt(TITLE_PT + 2 * PADDING_PT), window.height - 24
    density = min(max((most - frame) / ui.pt(wanted), DENSEST), 1.0)
    height = min(density * ui.pt(wanted) + frame, most)
    rect = Rect((window.width - width) / 2, (window.height - height) / 2, width, height)
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(28), ui.pt(PADDING_PT)))
    with plate("help", rect, alpha=0.97, scrolls=True, is_front=True):
        is_clicked |= imgui.is_window_hovered() and imgui.is_mouse_clicked(0)
        with face(ui.fonts.bold, theme.HEAD_PT):
            imgui.text_unformatted(TITLES[keymap])
        left, top = imgui.get_cursor_pos_x(), imgui.get_cursor_pos_y()
        part = (imgui.get_content_region_avail().x + ui.pt(16)) / len(columns)
        for number, column in enumerate(columns):
            _column(ui, column, (left + number * part, top), part - ui.pt(16), density)
    imgui.pop_style_var()
    return [cmd.Toggle("help")] if is_clicked else []


def rows_of(group: str, keymap: KeymapName = "wzviewer", letters: str = LETTERS) -> list[Binding]:
    """Returns the keys of a group, in the order of the table."""
    return [binding for binding in keymap_of(keymap, letters).bindings if binding.group == group]


def _column(
    ui: Ui,
    groups: list[tuple[str, list[Binding]]],
    at: tuple[float, float],
    width: float,
    density: float,
) -> None:
    left, y = at
    size_pt = theme.BODY_PT if density > 0.9 else theme.SMALL_PT
    for group, rows in groups:
        imgui.set_cursor_pos((left, y + density * ui.pt(8)))
        with face(ui.fonts.bold, theme.SMALL_PT), colored(ui.colors.accent):
            imgui.text_unformatted(group.upper())
        y += density * ui.pt(HEAD_PT)
        with face(ui.fonts.regular, size_pt):
            for binding in rows:
                imgui.set_cursor_pos((left, y))
                imgui.text_unformatted(binding.label)
                imgui.set_cursor_pos((left + min(ui.pt(KEY_PT), 0.45 * width), y))
                with colored(ui.colors.muted):
                    imgui.text_unformatted(binding.what)
                y += density * ui.pt(ROW_PT)
