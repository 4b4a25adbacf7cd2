"""Above the prompt line: the variants of a level side by side; a click shows one, Keep closes the strip."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import label_of
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, face, picture, plate, tooltip
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.app.variants import are_variants, group_of

TILE_PT = (72.0, 48.0)
GAP_PT, PADDING_PT = 6.0, 8.0
BUTTON_PT = 92.0


def draw_variants(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    """Draws the strip, as many of the newest as there is room for; returns also its height."""
    index = state.variants
    if index is None or not index < len(state.scene) or not state.scene.is_committed(index):
        return [], 0.0
    group, is_making = group_of(state.scene, index), _is_making(state, index)
    if not group:
        return [], 0.0
    step = ui.pt(TILE_PT[0] + GAP_PT)
    room = above.width - ui.pt(2 * PADDING_PT + BUTTON_PT)
    first = max(len(group) + is_making - max(int(room // step), 1), 0)
    width = (len(group) - first + is_making) * step + ui.pt(2 * PADDING_PT + BUTTON_PT)
    rect = Rect(above.x + (above.width - width) / 2, above.y, width, 0.0)
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(PADDING_PT), ui.pt(PADDING_PT)))
    with plate("variants", rect, grows="up"):
        for number, i in list(enumerate(group))[first:]:
            is_shown = state.scene.mark(i).sight == "shown"
            if _tile(ui, i, number, is_shown) and not is_shown:
                commands.append(cmd.ChooseVariant(i))
            imgui.same_line(0.0, ui.pt(GAP_PT))
        if is_making:
            _empty(ui, len(group))
            imgui.same_line(0.0, ui.pt(GAP_PT))
        commands += _buttons(state, ui, index)
        height = imgui.get_window_height()
    imgui.pop_style_var()
    return commands, height


def _is_making(state: AppState, index: int) -> bool:
    goal = state.job.goal if state.job is not None else None
    if goal is None or goal.like is None or goal.like >= len(state.scene):
        return False
    return are_variants(state.scene[goal.like], state.scene[index])


def _tile(ui: Ui, index: int, number: int, is_shown: bool) -> bool:
    width, height = ui.pt(TILE_PT[0]), ui.pt(TILE_PT[1])
    at = imgui.get_cursor_screen_pos()
    pressed = imgui.invisible_button(f"variant{index}", (width, height))
    is_lit = is_shown or imgui.is_item_hovered()
    picture(ui, ui.thumbnails.get(index), (at.x, at.y, width, height), is_shown, 1.0 if is_lit else 0.6)
    _number(ui, at.x, at.y + height, number)
    tooltip("This one is shown" if is_shown else "Show this one   PgUp, PgDn")
    return pressed


def _empty(ui: Ui, number: int) -> None:
    """The place of the one in the making."""
    width, height = ui.pt(TILE_PT[0]), ui.pt(TILE_PT[1])
    at = imgui.get_cursor_screen_pos()
    imgui.dummy((width, height))
    draw, corner = imgui.get_window_draw_list(), (at.x + width, at.y + height)
    draw.add_rect_filled((at.x, at.y), corner, u32(ui.colors.field), ui.pt(5))
    dots = "…"
    x = at.x + (width - imgui.calc_text_size(dots).x) / 2
    draw.add_text((x, at.y + (height - imgui.get_text_line_height()) / 2), u32(ui.colors.accent), dots)
    _number(ui, at.x, corner[1], number)


def _number(ui: Ui, x: float, bottom: float, number: int) -> None:
    """In the lower left corner, readable on any picture."""
    draw, text = imgui.get_window_draw_list(), str(number + 1)
    with face(ui.fonts.bold, theme.SMALL_PT - 1.0):
        size = imgui.calc_text_size(text)
        low = (x + ui.pt(3), bottom - size.y - ui.pt(5))
        high = (low[0] + size.x + ui.pt(8), bottom - ui.pt(3))
        draw.add_rect_filled(low, high, u32((0.0, 0.0, 0.0, 0.6)), ui.pt(4))
        draw.add_text((low[0] + ui.pt(4), low[1] + ui.pt(1)), u32(theme.ON_PICTURE), text)


def _buttons(state: AppState, ui: Ui, index: int) -> list[cmd.Command]:
    """Two buttons, one above the other, as high as a tile."""
    commands: list[cmd.Command] = []
    size = (ui.pt(BUTTON_PT), (ui.pt(TILE_PT[1]) - ui.pt(4)) / 2)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(4), 0.0))
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.0, ui.pt(4)))
    imgui.begin_group()
    with face(ui.fonts.regular, theme.SMALL_PT):
        if imgui.button(f"{icons.ICON_FA_DICE} Another", size):
            commands.append(cmd.Another(index))
        key = label_of(cmd.Another, state.settings.keymap)
        tooltip(f"The same once more, with another seed   {key}")
        with colored(ui.colors.accent):
            if imgui.button(f"{icons.ICON_FA_CHECK} Keep", size):
                commands.append(cmd.OpenVariants(None))
        tooltip("Keep the one that is shown; the others stay in the scene, hidden")
    imgui.end_group()
    imgui.pop_style_var(2)
    return commands
