"""On the start page: what a crash left behind, and the files that were open lately, with pictures."""

from datetime import datetime

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.panels.surface import Ui, colored, elided, face, picture, quiet, tooltip
from wzviewer.app.recents import RecentFile
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

COLUMNS = 4
GAP_PT = 10.0
PICTURE_PT = 92.0  # height
ROW_PT = PICTURE_PT + 34.0
HEAD_PT = 40.0
FOOT_PT = 12.0  # of a row, below the names: not needed below the last one
LEFTOVER_PT = 48.0
TITLE_HEIGHT_PT = 274.0  # of the page without all this
CROSS_PT = 24.0


def extra_height(state: AppState, ui: Ui) -> tuple[float, int]:
    """Returns how much higher the page is, imgui units, and how many rows of files have room."""
    extra = ui.pt(LEFTOVER_PT) if _has_leftover(state) else 0.0
    room = ui.layout.window.height - ui.pt(TITLE_HEIGHT_PT + HEAD_PT + 32) - extra
    needed = -(-len(state.recents.files) // COLUMNS)
    rows = max(min(needed, int(room / ui.pt(ROW_PT))), 0)
    return extra + (ui.pt(HEAD_PT + rows * ROW_PT - FOOT_PT) if rows else 0.0), rows


def draw_leftover(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws a way back to levels that were not saved, after "Later" was answered."""
    left = state.leftover
    if left is None or not _has_leftover(state):
        return []
    width = imgui.get_content_region_avail().x
    text = f"{icons.ICON_FA_CLOCK_ROTATE_LEFT}   Bring back {left.what}, not saved"
    with colored(ui.colors.accent):
        pressed = imgui.button(elided(text, width - ui.pt(20)), (width, ui.pt(LEFTOVER_PT - 8)))
    return [cmd.SettleRecovery("recover")] if pressed else []


def _has_leftover(state: AppState) -> bool:
    """Over a document there is no way back to them: it would be gone."""
    return state.leftover is not None and not state.has_document


def draw_recents(state: AppState, ui: Ui, rows: int) -> list[cmd.Command]:
    """Draws the newest files, as many rows as have room."""
    if not rows:
        return []
    commands = _head(ui)
    corner = imgui.get_cursor_screen_pos()
    gap = ui.pt(GAP_PT)
    width = (imgui.get_content_region_avail().x - (COLUMNS - 1) * gap) / COLUMNS
    for number, file in enumerate(state.recents.files[: rows * COLUMNS]):
        row, column = divmod(number, COLUMNS)
        at = (corner.x + column * (width + gap), corner.y + row * ui.pt(ROW_PT))
        commands += _card(ui, file, at, width)
    return commands


def _head(ui: Ui) -> list[cmd.Command]:
    text = "Clear list"
    imgui.dummy((1.0, ui.pt(2)))
    top, left = imgui.get_cursor_pos_y(), imgui.get_cursor_pos_x()
    room = imgui.get_content_region_avail().x
    imgui.set_cursor_pos_y(top + ui.pt(4))
    with face(ui.fonts.bold, theme.SMALL_PT), colored(ui.colors.muted):
        imgui.text_unformatted("RECENT")
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(6), ui.pt(3)))
    with face(ui.fonts.regular, theme.SMALL_PT), quiet(), colored(ui.colors.muted):
        imgui.set_cursor_pos((left + room - imgui.calc_text_size(text).x - ui.pt(12), top))
        pressed = imgui.button(text)
    imgui.pop_style_var()
    tooltip("Forget these files; the files themselves stay")
    imgui.set_cursor_pos((left, top + ui.pt(HEAD_PT - 13)))
    return [cmd.ClearRecents()] if pressed else []


def _card(ui: Ui, file: RecentFile, at: tuple[float, float], width: float) -> list[cmd.Command]:
    """A picture with its name; a click opens it, the cross on it takes it off the list."""
    x, y = at
    height = ui.pt(PICTURE_PT)
    imgui.set_cursor_screen_pos(at)
    imgui.set_next_item_allow_overlap()
    pressed = imgui.invisible_button(f"recent {file.path}", (width, ui.pt(ROW_PT - 8)))
    draw = imgui.get_window_draw_list()
    is_hovered = imgui.is_mouse_hovering_rect(at, (x + width, y + ui.pt(ROW_PT - 8)))
    if is_hovered:
        lower = (x + width + ui.pt(4), y + ui.pt(ROW_PT - 6))
        draw.add_rect_filled((x - ui.pt(4), y - ui.pt(4)), lower, u32(ui.colors.hover), ui.pt(8))
    tooltip(_details(file))
    alpha = 0.3 if file.is_missing else 1.0
    picture(ui, ui.recents.get(file.path), (x, y, width, height), is_here=False, opacity=alpha)
    color = ui.colors.muted if file.is_missing else ui.colors.text
    with face(ui.fonts.regular, theme.SMALL_PT):
        if file.is_missing:
            middle = (x + (width - imgui.calc_text_size("not found").x) / 2, y + height / 2 - ui.pt(8))
            draw.add_text(middle, u32(ui.colors.text), "not found")
        draw.add_text((x + ui.pt(2), y + height + ui.pt(4)), u32(color), elided(file.path.name, width))
    if is_hovered and _cross(ui, file, (x + width - ui.pt(CROSS_PT + 4), y + ui.pt(4))):
        return [cmd.RemoveRecent(file.path)]
    return [cmd.Open(file.path)] if pressed else []


def _cross(ui: Ui, file: RecentFile, at: tuple[float, float]) -> bool:
    imgui.set_cursor_screen_pos(at)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    with colored(ui.colors.solid, imgui.Col_.button):
        pressed = imgui.button(f"{icons.ICON_FA_XMARK}##{file.path}", (ui.pt(CROSS_PT), ui.pt(CROSS_PT)))
    imgui.pop_style_var()
    tooltip("Take off this list")
    return bool(pressed)


def _details(file: RecentFile) -> str:
    opened = datetime.fromtimestamp(file.opened_s)
    when = f"opened {opened.day} {opened:%B %Y, %H:%M}"
    return "\n".join([str(file.path), "It is not there now." if file.is_missing else when])
