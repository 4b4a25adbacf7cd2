"""On the picture: the frame of the next level, while it is drawn, once it is, and where Enter would go."""

from collections.abc import Iterable
from itertools import pairwise

from imgui_bundle import imgui

from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, face
from wzviewer.app.panels.wording import magnification_text
from wzviewer.app.region import drawn_frame
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.core.camera import Camera

TICK_PT = 14.0  # of the corners of a frame that is only offered
DIM: theme.Rgba = (0.0, 0.0, 0.0, 0.38)  # around a frame while it is drawn
PILL: theme.Rgba = (0.05, 0.055, 0.065, 0.72)  # behind a label
EDGE: theme.Rgba = (0.0, 0.0, 0.0, 0.55)  # beside the line, so that it is seen on any picture


def draw_frame(state: AppState, ui: Ui) -> None:
    """Draws what applies, below all panels."""
    region, camera = state.region, state.view.camera
    if not len(state.scene):
        return
    ratio = imgui.get_io().display_framebuffer_scale
    if region.start_px is not None and region.end_px is not None:
        size = (camera.width, camera.height)
        x, y, width, height = drawn_frame(region.start_px, region.end_px, size)
        rect = Rect(x / ratio.x, y / ratio.y, width / ratio.x, height / ratio.y)
        _dim(ui, rect)
        _outline(ui, rect, camera.width / max(width, 1.0), "")
        return
    if region.camera is not None:
        found = seen_rect(state, region.camera)
        if found is not None:
            hint = "" if region.is_of_drop else "   Enter makes it"
            _outline(ui, found, _factor(region.camera, camera), hint)
    is_current = bool(region.aimed_for) and region.aimed_for[0] is camera
    if region.aim is not None and is_current and (region.camera is not None or is_asking(state, ui)):
        found = seen_rect(state, region.aim)
        if found is not None:
            _ticks(ui, found, _factor(region.aim, camera))


def draw_place(state: AppState, ui: Ui, camera: Camera) -> None:
    """Draws where something that waits will be made."""
    found = seen_rect(state, camera)
    if found is not None:
        _outline(ui, found, _factor(camera, state.view.camera), "")


def seen_rect(state: AppState, frame: Camera) -> Rect | None:
    """Returns where the view shows the frame of a camera, imgui units; None where it does not."""
    view, ratio = state.view.camera, imgui.get_io().display_framebuffer_scale
    depth = float(frame.to_camera(state.view.focus)[2])
    if depth <= 0:
        return None
    corners = [frame.unproject(x, y, depth) for x, y in ((0.0, 0.0), (frame.width, frame.height))]
    (x0, y0, z0), (x1, y1, z1) = (view.project(point) for point in corners)
    if min(z0, z1) <= 0 or not (x0 < x1 and y0 < y1):
        return None
    return Rect(x0 / ratio.x, y0 / ratio.y, (x1 - x0) / ratio.x, (y1 - y0) / ratio.y)


def is_asking(state: AppState, ui: Ui) -> bool:
    """Whether the user is about to ask: then it matters where that would be."""
    if state.job is not None or state.view.is_moving or _is_typing_elsewhere(state):
        return False
    bar, mouse = ui.layout.prompt, imgui.get_io().mouse_pos
    is_over = bar.x <= mouse.x <= bar.right and bar.y <= mouse.y <= bar.bottom
    return is_over or bool(state.prompt.strip()) or imgui.get_io().want_text_input


def _is_typing_elsewhere(state: AppState) -> bool:
    """Whether a line of text other than the prompt has the cursor."""
    return bool(state.panels.dialog) or state.palette.is_open or state.renaming is not None


def _factor(frame: Camera, view: Camera) -> float:
    return frame.focal_px / frame.width * view.width / view.focal_px


def _dim(ui: Ui, rect: Rect) -> None:
    draw, window, color = imgui.get_background_draw_list(), ui.layout.window, u32(DIM)
    for low, high in (
        ((0.0, 0.0), (window.width, rect.y)),
        ((0.0, rect.bottom), (window.width, window.height)),
        ((0.0, rect.y), (rect.x, rect.bottom)),
        ((rect.right, rect.y), (window.width, rect.bottom)),
    ):
        draw.add_rect_filled(low, high, color)


def _outline(ui: Ui, rect: Rect, factor: float, hint: str) -> None:
    draw = imgui.get_background_draw_list()
    low, high = (rect.x, rect.y), (rect.right, rect.bottom)
    draw.add_rect(low, high, u32(EDGE), ui.pt(3), ui.pt(4))
    draw.add_rect(low, high, u32(theme.DARK.accent), ui.pt(3), ui.pt(2))
    _label(ui, rect, f"{magnification_text(factor)}{hint}", theme.DARK.accent)


def _ticks(ui: Ui, rect: Rect, factor: float) -> None:
    """Corners only: it is an offer, and the picture is what one looks at."""
    draw = imgui.get_background_draw_list()
    tick = min(ui.pt(TICK_PT), rect.width / 3, rect.height / 3)
    for line in _corners(rect, tick):
        for color, width in ((EDGE, 4.0), (theme.ON_PICTURE, 1.8)):
            for a, b in pairwise(line):
                draw.add_line(a, b, u32(color, 0.85), ui.pt(width))
    _label(ui, rect, magnification_text(factor), theme.ON_PICTURE)


def _corners(rect: Rect, tick: float) -> Iterable[tuple[tuple[float, float], ...]]:
    for x, inward_x in ((rect.x, tick), (rect.right, -tick)):
        for y, inward_y in ((rect.y, tick), (rect.bottom, -tick)):
            yield ((x + inward_x, y), (x, y), (x, y + inward_y))


def _label(ui: Ui, rect: Rect, text: str, color: theme.Rgba) -> None:
    """Below the frame, or inside it where that is out of the window."""
    draw = imgui.get_background_draw_list()
    with face(ui.fonts.regular, theme.SMALL_PT):
        size = imgui.calc_text_size(text)
        x = min(max(rect.x + ui.pt(7), ui.pt(12)), ui.layout.window.width - size.x - ui.pt(12))
        y = rect.bottom + ui.pt(8)
        if y + size.y > ui.layout.prompt.y - ui.pt(6):
            y = min(rect.bottom, ui.layout.prompt.y) - size.y - ui.pt(8)
        low, high = (x - ui.pt(7), y - ui.pt(2)), (x + size.x + ui.pt(7), y + size.y + ui.pt(3))
        draw.add_rect_filled(low, high, u32(PILL), ui.pt(6))
        draw.add_text((x, y), u32(color), text)
