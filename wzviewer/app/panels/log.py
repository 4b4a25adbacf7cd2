"""Over all, on F12: the last messages of the app and its worker."""

import logging

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.logbook import LEVELS, LogLine
from wzviewer.app.panels.surface import Ui, choice, colored, face, plate, primary, shade
from wzviewer.app.state import AppState

SIZE_PT = (900.0, 520.0)
CHOICE_PT, BUTTON_PT = 270.0, 92.0


def draw_log(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the window; a click beside it closes it."""
    if not state.log.is_open:
        return []
    window = ui.layout.window
    commands: list[cmd.Command] = [cmd.ToggleLog()] if shade(ui) else []
    width, height = (min(ui.pt(SIZE_PT[0]), window.width - 24), min(ui.pt(SIZE_PT[1]), window.height - 24))
    rect = Rect((window.width - width) / 2, (window.height - height) / 2, width, height)
    with plate("log", rect, alpha=0.98, is_front=True):
        with face(ui.fonts.bold, theme.HEAD_PT):
            imgui.text_unformatted("Log")
        commands += _lines(ui) + _foot(state, ui)
    return commands


def _lines(ui: Ui) -> list[cmd.Command]:
    """The messages, the newest below; it stays there unless one has scrolled up."""
    foot = ui.pt(34) + 2 * imgui.get_style().item_spacing.y
    room = imgui.get_content_region_avail()
    flags = imgui.ChildFlags_.none.value
    imgui.begin_child("lines", (room.x, max(room.y - foot, ui.pt(40))), flags)
    with face(ui.fonts.regular, theme.SMALL_PT):
        if not ui.log:
            with colored(ui.colors.muted):
                imgui.text_unformatted("Nothing yet.")
        imgui.push_text_wrap_pos(0.0)
        for line in ui.log:
            with colored(_color(ui, line)):
                imgui.text_unformatted(str(line))
        imgui.pop_text_wrap_pos()
    if imgui.is_window_appearing() or imgui.get_scroll_y() >= imgui.get_scroll_max_y():
        imgui.set_scroll_here_y(1.0)
    imgui.end_child()
    return []


def _color(ui: Ui, line: LogLine) -> theme.Rgba:
    if line.level >= logging.ERROR:
        return ui.colors.error
    return ui.colors.accent if line.level >= logging.WARNING else ui.colors.text


def _foot(state: AppState, ui: Ui) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    top = imgui.get_cursor_pos_y() + imgui.get_style().item_spacing.y
    width = imgui.get_window_size().x - imgui.get_style().window_padding.x
    left = width - ui.pt(2 * BUTTON_PT + 16) - imgui.get_style().window_padding.x
    imgui.set_cursor_pos_y(top + ui.pt(4))  # these buttons are less high
    imgui.begin_child("levels", (min(ui.pt(CHOICE_PT), left), ui.pt(30)))
    level = choice(ui, "level", [(name, level) for level, name in LEVELS], state.log.level)
    imgui.end_child()
    if level is not None:
        commands.append(cmd.SetLogLevel(level))
    imgui.set_cursor_pos((width - ui.pt(2 * BUTTON_PT + 8), top))
    if imgui.button("Copy all", (ui.pt(BUTTON_PT), ui.pt(34))):
        commands.append(cmd.CopyLog())
    imgui.same_line(0.0, ui.pt(8))
    with primary(ui), face(ui.fonts.bold):
        if imgui.button("Close##log", (ui.pt(BUTTON_PT), ui.pt(34))):
            commands.append(cmd.ToggleLog())
    return commands
