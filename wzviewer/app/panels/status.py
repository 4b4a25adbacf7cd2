"""Bottom corners: a scale bar on the left, the magnification on the right."""

from dataclasses import replace
from itertools import pairwise

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.look import MODES
from wzviewer.app.panels.surface import Ui, elided, face, plate
from wzviewer.app.panels.wording import magnification_text, share_text
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.core.navigation import scale_bar

BAR_LIMIT_PT = 150.0
PADDING_PT = 12.0
FIGURE_PT = 20.0  # size of the magnification
FLAT = imgui.WindowFlags_.no_background.value | imgui.WindowFlags_.no_inputs.value


def draw_scale_bar(state: AppState, ui: Ui) -> None:
    """Draws a bar of a round length at the depth of the focus, told in widths of the photo there.

    So at home it is the share of the photo's width that it covers on the screen.
    """
    view = state.view
    if view.focus_depth <= 0 or not len(state.scene):
        return
    ratio = imgui.get_io().display_framebuffer_scale.x
    photos_per_pt = view.camera.pixel_scale(view.focus_depth) * ratio / photo_width(state)
    rect, text_pt = ui.layout.scale_bar, theme.SMALL_PT
    bar = scale_bar(photos_per_pt, min(ui.pt(BAR_LIMIT_PT), rect.width - ui.pt(2 * PADDING_PT)))
    with plate("scale bar", rect, FLAT), face(ui.fonts.regular, text_pt):
        text, draw = share_text(bar.length), imgui.get_window_draw_list()
        width = max(bar.width_px, imgui.calc_text_size(text).x)
        _ground(ui, replace(rect, width=width + ui.pt(2 * PADDING_PT)))
        x, y, tick = rect.x + ui.pt(PADDING_PT), rect.bottom - ui.pt(11), ui.pt(6)
        points = ((x, y - tick), (x, y), (x + bar.width_px, y), (x + bar.width_px, y - tick))
        for a, b in pairwise(points):
            draw.add_line(a, b, u32(ui.colors.text), ui.pt(1.6))
        draw.add_text((x, rect.y + ui.pt(7)), u32(ui.colors.text), text)


def photo_width(state: AppState) -> float:
    """Returns how wide the photo is where one looks, world units."""
    photo = state.scene[0].camera
    depth = float(photo.to_camera(state.view.focus)[2])
    return (depth if depth > 0 else 1.0) * photo.width / photo.fx


def draw_status(state: AppState, ui: Ui) -> None:
    """Draws the total magnification, and where one is."""
    rect, inset = ui.layout.status, ui.pt(PADDING_PT)
    figure = magnification_text(max(state.view.magnification, 0.0))
    with plate("status", rect, FLAT):
        with face(ui.fonts.regular, theme.SMALL_PT):
            line = status_line(state, rect.width - 2 * inset)
            line_width = imgui.calc_text_size(line).x
        with face(ui.fonts.bold, FIGURE_PT):
            figure_width = imgui.calc_text_size(figure).x
        width = max(line_width, figure_width) + 2 * inset
        _ground(ui, replace(rect, x=rect.right - width, width=width))
        draw, right = imgui.get_window_draw_list(), rect.right - inset
        with face(ui.fonts.regular, theme.SMALL_PT):
            draw.add_text((right - line_width, rect.y + ui.pt(4)), u32(ui.colors.muted), line)
        with face(ui.fonts.bold, FIGURE_PT):
            draw.add_text((right - figure_width, rect.y + ui.pt(20)), u32(ui.colors.text), figure)


def _ground(ui: Ui, rect: Rect) -> None:
    """As behind panels, as wide as what stands on it: straight on a bright picture nothing is readable."""
    draw, corners = imgui.get_window_draw_list(), ((rect.x, rect.y), (rect.right, rect.bottom))
    draw.push_clip_rect(*corners)  # imgui's own leaves out the edge
    draw.add_rect_filled(*corners, u32(ui.colors.panel), ui.pt(theme.ROUNDING_PT))
    draw.add_rect(*corners, u32(ui.colors.faint), ui.pt(theme.ROUNDING_PT), ui.pt(1))
    draw.pop_clip_rect()


def status_line(state: AppState, room: float) -> str:
    """Where one is, within a width; the name of the document is the title of the window, too."""
    count = len(state.scene.visible())
    has_auto = state.settings.auto_detail and count > 0
    auto = [f"{icons.ICON_FA_WAND_MAGIC_SPARKLES} auto detail"] if has_auto else []
    levels = [f"{count} levels"] if count > 1 else []
    if state.errand is not None:  # for a moment, and what one waits for
        return elided(f"{state.errand.line} …", room)
    if state.look.mode != "picture":  # which some of them do not look like
        return elided(f"{dict(MODES)[state.look.mode]} · Esc for the picture", room)
    whole = " · ".join([*auto, state.name, *levels])
    if imgui.calc_text_size(whole).x <= room or not auto + levels:
        return elided(whole, room)
    return " · ".join(auto + levels)
