"""The list in the open dialog, where the desktop has none: folders to enter, files to choose."""

import os

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.listing import Listing, matching
from wzviewer.app.panels.surface import Ui, colored, elided

ROWS, ROW_PT = 8, 26.0
ICON_PT = 26.0


def draw_folder(ui: Ui, listing: Listing, text: str) -> list[cmd.Command]:
    """Draws the list; a click enters a folder or takes a file, a second one opens it."""
    found, commands = matching(listing, text), list[cmd.Command]()
    room = (0.0, ui.pt(ROWS * ROW_PT + 8))
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(4), ui.pt(4)))
    with colored(ui.colors.field, imgui.Col_.child_bg):
        imgui.begin_child("folder", room, imgui.ChildFlags_.always_use_window_padding.value)
    if listing.folder.parent != listing.folder:
        up = str(listing.folder.parent)
        if _row(ui, icons.ICON_FA_ARROW_UP, "The folder above", "up"):
            commands.append(cmd.EditPath(up if up.endswith(os.sep) else up + os.sep))
    for name in found.folders:
        if _row(ui, icons.ICON_FA_FOLDER, name, f"folder {name}"):
            commands.append(cmd.EditPath(str(listing.folder / name) + os.sep))
    for name in found.files:
        path = str(listing.folder / name)
        is_scene = name.lower().endswith(".wz")
        icon = icons.ICON_FA_LAYER_GROUP if is_scene else icons.ICON_FA_IMAGE
        is_chosen = path == text.strip()
        if _row(ui, icon, name, f"file {name}", is_chosen):
            # Of two quick clicks the first may have entered a folder: it opens only what it has chosen.
            is_second = is_chosen and imgui.get_mouse_clicked_count(0) > 1
            commands.append(cmd.ConfirmPath() if is_second else cmd.EditPath(path))
    if not (found.folders or found.files):
        imgui.set_cursor_pos((ui.pt(ICON_PT + 6), imgui.get_cursor_pos_y() + ui.pt(4)))
        with colored(ui.colors.muted):
            imgui.text_unformatted("Nothing here that can be opened" if listing.is_read else "Reading …")
    imgui.end_child()
    imgui.pop_style_var(2)
    return commands


def _row(ui: Ui, icon: str, name: str, key: str, is_chosen: bool = False) -> bool:
    """A line of the list; returns whether it was clicked."""
    at, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    flags = imgui.SelectableFlags_.allow_double_click.value
    imgui.push_style_var(imgui.StyleVar_.frame_rounding.value, ui.pt(5))
    pressed, _ = imgui.selectable(f"##{key}", is_chosen, flags, (width, ui.pt(ROW_PT)))
    imgui.pop_style_var()
    draw, y = imgui.get_window_draw_list(), at.y + (ui.pt(ROW_PT) - imgui.get_font_size()) / 2
    muted = imgui.get_color_u32(ui.colors.muted)
    draw.add_text((at.x + ui.pt(6), y), muted, icon)
    color = imgui.get_color_u32(ui.colors.text)
    draw.add_text((at.x + ui.pt(6 + ICON_PT), y), color, elided(name, width - ui.pt(12 + ICON_PT)))
    return bool(pressed)
