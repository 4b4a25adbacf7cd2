"""Above the magnification: the photo with a frame where one is; a click flies there."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import label_for
from wzviewer.app.layout import Rect
from wzviewer.app.locating import Location, location
from wzviewer.app.panels.surface import Ui, plate, tooltip
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

PADDING_PT = 4.0
SMALLEST_PT = 14.0  # of the frame; a smaller one is a cross
CROSS_PT, HOLE_PT = 15.0, 6.0


def draw_locator(state: AppState, ui: Ui) -> tuple[list[cmd.Command], Rect]:
    """Draws the inset; it is away at home, and where what is behind the picture is looked at.

    Returns:
        What was asked for, and its place; without a size while it is away.
    """
    room, thumbnail = ui.layout.locator, ui.thumbnails.get(0)
    nothing: list[cmd.Command] = []
    if not state.panels.locator or state.panels.statistics or not len(state.scene) or room.width <= 0:
        return nothing, Rect(room.x, room.y, 0.0, 0.0)
    here = location(state)
    if here is None:
        return nothing, Rect(room.x, room.y, 0.0, 0.0)
    root = state.scene[0].camera
    aspect = thumbnail.aspect if thumbnail is not None else root.width / root.height
    pad = ui.pt(PADDING_PT)
    width = min(room.width - 2 * pad, (room.height - 2 * pad) * aspect)
    height = width / aspect
    rect = Rect(
        room.right - width - 2 * pad, room.bottom - height - 2 * pad, width + 2 * pad, height + 2 * pad
    )
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (pad, pad))
    commands = nothing
    with plate("locator", rect):
        at = imgui.get_cursor_screen_pos()
        inner = Rect(at.x, at.y, width, height)
        if imgui.invisible_button("photo", (width, height)):
            mouse = imgui.get_io().mouse_pos
            x, y = (mouse.x - inner.x) / width, (mouse.y - inner.y) / height
            commands.append(cmd.GoToPhoto(min(max(x, 0.0), 1.0), min(max(y, 0.0), 1.0)))
        if imgui.is_item_hovered():
            key = label_for(cmd.Toggle("locator"), state.settings.keymap)
            tooltip(f"Where you are in the photo. A click flies there.   {key}")
        draw = imgui.get_window_draw_list()
        low, high = (inner.x, inner.y), (inner.right, inner.bottom)
        if thumbnail is not None:
            white = u32((1.0, 1.0, 1.0, 1.0))
            draw.add_image_rounded(thumbnail.ref, low, high, (0.0, 0.0), (1.0, 1.0), white, ui.pt(5))
        else:
            draw.add_rect_filled(low, high, u32(ui.colors.field), ui.pt(5))
        draw.push_clip_rect(low, high, True)
        _mark(ui, inner, here)
        draw.pop_clip_rect()
    imgui.pop_style_var()
    return commands, rect


def _mark(ui: Ui, inner: Rect, here: Location) -> None:
    """A frame; once it is too small to see, a cross around the place."""
    draw = imgui.get_window_draw_list()
    x0, x1 = (inner.x + share * inner.width for share in (here.left, here.right))
    y0, y1 = (inner.y + share * inner.height for share in (here.top, here.bottom))
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    lines: list[tuple[tuple[float, float], tuple[float, float]]] = []
    if x1 - x0 < ui.pt(SMALLEST_PT):
        hole, end = ui.pt(HOLE_PT), ui.pt(CROSS_PT)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            lines.append(((x + dx * hole, y + dy * hole), (x + dx * end, y + dy * end)))
    for color, width in (((0.0, 0.0, 0.0, 0.75), 4.5), (theme.DARK.accent, 2.2)):
        if not lines:
            draw.add_rect((x0, y0), (x1, y1), u32(color), ui.pt(2), ui.pt(width))
        if lines:
            draw.add_circle((x, y), ui.pt(HOLE_PT), u32(color), 0, ui.pt(width))
        for a, b in lines:
            draw.add_line(a, b, u32(color), ui.pt(width))
