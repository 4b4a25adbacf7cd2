"""Over the picture, once: the three things that can be done with it."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.hint import is_shown
from wzviewer.app.keys import label_of
from wzviewer.app.layout import Rect
from wzviewer.app.panels.notices import has_notices, notices_place, taken_on_the_left
from wzviewer.app.panels.surface import Ui, colored, face, plate, quiet, tooltip
from wzviewer.app.state import AppState

SIZE_PT = (330.0, 98.0)
ICON_PT, ROW_PT = 28.0, 26.0
KEY_PT = (84.0, 62.0)  # the latter where there is little room
CROSS_PT = 26.0
NARROWEST_PT = 190.0  # for its shortest words


def draw_hint(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the hint, beside the tree and below the breadcrumb."""
    if not is_shown(state) or state.panels.statistics:
        return []
    right = notices_place(state, ui.layout).x if has_notices(state) else ui.layout.window.width
    place = place_of(ui, taken_on_the_left(state, ui.layout), right)
    if place.width < ui.pt(NARROWEST_PT):
        return []  # it comes again once there is room
    is_narrow = place.width < ui.pt(SIZE_PT[0])
    with plate("hint", place, alpha=0.9):
        corner = imgui.get_cursor_pos()
        for number, (icon, key, words) in enumerate(_lines(state)):
            what = words[1] if is_narrow else words[0]
            y = corner.y + number * ui.pt(ROW_PT)
            with colored(ui.colors.accent):
                _at(corner.x, y, icon)
            with face(ui.fonts.bold):
                _at(corner.x + ui.pt(ICON_PT), y, key)
            _at(corner.x + ui.pt(ICON_PT + KEY_PT[is_narrow]), y, what)
        return _cross(ui)


def place_of(ui: Ui, left: float, right: float) -> Rect:
    """Returns where the hint stands: in the middle of the window, as far as there is room.

    Args:
        ui: what to draw with.
        left: where its room begins, imgui units.
        right: where it ends.
    """
    layout = ui.layout
    width, height = ui.pt(SIZE_PT[0]), ui.pt(SIZE_PT[1])
    margin = layout.toolbar.x
    low, high = left + margin, right - margin
    width = min(width, high - low)
    x = min(max((layout.window.width - width) / 2, low), high - width)
    return Rect(x, layout.toolbar.bottom + margin, width, height)


def _lines(state: AppState) -> tuple[tuple[str, str, tuple[str, str]], ...]:
    generate = label_of(cmd.Generate, state.settings.keymap).split(",")[0]
    return (
        (icons.ICON_FA_MAGNIFYING_GLASS_PLUS, "Scroll", ("zoom to the cursor", "zoom")),
        (icons.ICON_FA_UP_DOWN_LEFT_RIGHT, "Drag", ("look around", "look")),
        (icons.ICON_FA_WAND_MAGIC_SPARKLES, generate, ("new detail there", "detail")),
    )


def _at(x: float, y: float, text: str) -> None:
    imgui.set_cursor_pos((x, y))
    imgui.text_unformatted(text)


def _cross(ui: Ui) -> list[cmd.Command]:
    size = imgui.get_window_size()
    imgui.set_cursor_pos((size.x - ui.pt(CROSS_PT + 6), ui.pt(6)))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    with quiet(), face(ui.fonts.regular, theme.SMALL_PT):
        pressed = imgui.button(f"{icons.ICON_FA_XMARK}##hint", (ui.pt(CROSS_PT), ui.pt(CROSS_PT)))
    imgui.pop_style_var()
    tooltip("Do not show this again")
    return [cmd.DismissHint()] if pressed else []
