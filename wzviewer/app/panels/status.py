"""Bottom corners: a scale bar on the left, the magnification on the right."""

from itertools import pairwise

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import theme
from wzviewer.app.panels.surface import Ui, elided, face, plate
from wzviewer.app.panels.wording import UNIT, length_text, magnification_text
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.core.navigation import scale_bar

BAR_LIMIT_PT = 150.0
ABOUT_UNIT = f"1 {UNIT} is the median distance in the photo"
SHADOW = (  # x and y, pt, and opacity
    *((0.0, 1.0, 0.9), (0.0, -1.0, 0.5), (1.0, 0.0, 0.6), (-1.0, 0.0, 0.6)),
    *((1.0, 1.0, 0.5), (-1.0, 1.0, 0.5), (1.0, -1.0, 0.3), (-1.0, -1.0, 0.3)),
)
FLAT = imgui.WindowFlags_.no_background.value | imgui.WindowFlags_.no_inputs.value


def draw_scale_bar(state: AppState, ui: Ui) -> None:
    """Draws a bar of a round length at the depth of the focus."""
    view = state.view
    if view.focus_depth <= 0 or not len(state.scene):
        return
    ratio = imgui.get_io().display_framebuffer_scale.x
    units_per_pt = view.camera.pixel_scale(view.focus_depth) * ratio
    bar = scale_bar(units_per_pt, ui.pt(BAR_LIMIT_PT))
    rect = ui.layout.scale_bar
    with plate("scale bar", rect, FLAT):
        draw = imgui.get_window_draw_list()
        x, y, tick = rect.x + ui.pt(2), rect.bottom - ui.pt(9), ui.pt(6)
        points = ((x, y - tick), (x, y), (x + bar.width_px, y), (x + bar.width_px, y - tick))
        for color, width in ((theme.SHADE, 4.0), (theme.ON_PICTURE, 1.6)):
            for a, b in pairwise(points):
                draw.add_line(a, b, u32(color), ui.pt(width))
        with face(ui.fonts.regular, theme.SMALL_PT):
            shadowed(ui, (x + ui.pt(1), y - ui.pt(26)), length_text(bar.length))


def draw_status(state: AppState, ui: Ui) -> None:
    """Draws the total magnification, and where one is."""
    rect = ui.layout.status
    with plate("status", rect, FLAT):
        text = magnification_text(max(state.view.magnification, 0.0))
        with face(ui.fonts.bold, 20.0):
            width = imgui.calc_text_size(text).x
            shadowed(ui, (rect.right - width - ui.pt(2), rect.bottom - ui.pt(29)), text)
        with face(ui.fonts.regular, theme.SMALL_PT):
            line = status_line(state, rect.width - ui.pt(4))
            width = imgui.calc_text_size(line).x
            shadowed(ui, (rect.right - width - ui.pt(2), rect.bottom - ui.pt(47)), line, theme.ON_PICTURE)


def status_line(state: AppState, room: float) -> str:
    """Where one is, within a width; the name of the document is the title of the window, too."""
    count = len(state.scene.visible())
    has_auto = state.settings.auto_detail and count > 0
    auto = [f"{icons.ICON_FA_WAND_MAGIC_SPARKLES} auto detail"] if has_auto else []
    levels = [f"{count} levels"] if count > 1 else []
    if state.errand is not None:  # for a moment, and what one waits for
        return elided(f"{state.errand.line} …", room)
    whole = " · ".join([*auto, state.name, *levels])
    if imgui.calc_text_size(whole).x <= room or not auto + levels:
        return elided(whole, room)
    return " · ".join(auto + levels)


def shadowed(ui: Ui, at: tuple[float, float], text: str, color: theme.Rgba = theme.ON_PICTURE) -> None:
    """Text straight on the picture, readable on any."""
    draw = imgui.get_window_draw_list()
    for dx, dy, alpha in SHADOW:
        draw.add_text((at[0] + ui.pt(dx), at[1] + ui.pt(dy)), u32((0, 0, 0, 0.75), alpha), text)
    draw.add_text(at, u32(color), text)
