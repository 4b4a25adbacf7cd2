"""Below the toolbar, on request: everything that changed the scene; a click goes back or forth to there."""

from dataclasses import replace

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.history import wording
from wzviewer.app.panels.surface import Ui, colored, elided, face, plate
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

WIDTH_PT, ROW_PT = 300.0, 30.0
MAX_ROWS = 11  # then it scrolls
ICONS = {
    "make": icons.ICON_FA_WAND_MAGIC_SPARKLES,
    "vary": icons.ICON_FA_DICE,
    "hide": icons.ICON_FA_EYE_SLASH,
    "show": icons.ICON_FA_EYE,
    "remove": icons.ICON_FA_TRASH,
    "rename": icons.ICON_FA_PEN,
    "choose": icons.ICON_FA_CLONE,
}


def draw_history(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel, the oldest entry first."""
    if not state.panels.history or not len(state.scene):
        return []
    side, entries = ui.layout.side, state.history.entries
    rows = min(len(entries) + 1, MAX_ROWS)
    height = min(ui.pt(42 + rows * ROW_PT), side.height)
    rect = replace(side, width=min(ui.pt(WIDTH_PT), side.width), height=height)
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(8), ui.pt(8)))
    with plate("history", rect, alpha=0.97, is_front=True, scrolls=True):
        imgui.indent(ui.pt(6))
        with face(ui.fonts.bold):
            imgui.text_unformatted("History")
        imgui.unindent(ui.pt(6))
        imgui.dummy((1.0, ui.pt(6)))
        names = [
            (icons.ICON_FA_IMAGE, "Opened"),
            *((ICONS[e.kind], wording(e)) for e in entries),
        ]
        for at, (icon, name) in enumerate(names):
            if _row(ui, at, state.history.at, icon, name):
                commands.append(cmd.JumpInHistory(at))
    imgui.pop_style_var(2)
    return commands


def _row(ui: Ui, at: int, present: int, icon: str, name: str) -> bool:
    """A step; those that were taken back are dim."""
    left, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    if at == present and imgui.is_window_appearing():
        imgui.set_scroll_here_y(0.5)
    pressed = imgui.invisible_button(f"step{at}", (width, ui.pt(ROW_PT)))
    if imgui.is_item_hovered():
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        imgui.get_window_draw_list().add_rect_filled(low, high, u32(ui.colors.hover), ui.pt(6))
    draw, color = imgui.get_window_draw_list(), ui.colors.muted if at > present else ui.colors.text
    if at == present:
        color = ui.colors.accent
    text = elided(f"{name[:1].upper()}{name[1:]}", width - ui.pt(40))
    with face(ui.fonts.regular, theme.SMALL_PT + 1.0), colored(color):
        y = left.y + (ui.pt(ROW_PT) - imgui.get_text_line_height()) / 2
        draw.add_text((left.x + ui.pt(6), y), u32(color, 0.6 if at > present else 0.8), icon)
        draw.add_text((left.x + ui.pt(34), y), u32(color), text)
    return pressed
