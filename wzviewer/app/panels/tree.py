"""Left: the tree of levels with their pictures; a click flies there."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.panels.surface import Ui, elided, face, plate, tooltip
from wzviewer.app.panels.wording import count_text, magnification_text
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.core.scene import Level, Scene

ROW_PT = 58.0
INDENT_PT = 12.0
MAX_INDENT = 4  # deeper rows stay here, or the names would have no room
PICTURE_PT = 70.0


def draw_tree(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the tree, the newest level in view."""
    rows = tree_rows(state.scene)
    if not state.panels.tree or not rows:
        return []
    commands: list[cmd.Command] = []
    rect = ui.layout.tree
    height = min(rect.height, ui.pt(12 + len(rows) * (ROW_PT + 4)))
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(6), ui.pt(6)))
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.0, ui.pt(4)))
    with plate("tree", type(rect)(rect.x, rect.y, rect.width, height), scrolls=True):
        nearest = _nearest(state)
        for index, depth in rows:
            if _row(state, ui, state.scene[index], depth, index == nearest):
                commands.append(cmd.GoToLevel(index))
    imgui.pop_style_var(2)
    return commands


def tree_rows(scene: Scene) -> list[tuple[int, int]]:
    """Returns (level, depth in the tree) of the visible levels, children below their parent."""
    rows: list[tuple[int, int]] = []
    waiting = [(0, 0)] if len(scene) else []
    while waiting:
        index, depth = waiting.pop()
        rows.append((index, depth))
        waiting += [(child, depth + 1) for child in reversed(scene.children(index))]
    return rows


def title_of(level: Level) -> str:
    """Returns the name of a level: its prompt, or what it is."""
    if level.parent is None:
        return "Photo"
    return level.prompt or "Detail"


def _nearest(state: AppState) -> int:
    """The visible level whose scale is nearest to the view's, among those that hold its centre."""
    view = state.view
    best, best_gap = 0, float("inf")
    for index in state.scene.visible():
        camera = state.scene[index].camera
        x, y, z = camera.project(view.focus)
        if z > 0 and 0 <= x <= camera.width and 0 <= y <= camera.height:
            ratio = camera.focal_px / camera.width * view.camera.width / view.camera.focal_px
            gap = abs(ratio - 1.0 / ratio)
            if gap < best_gap:
                best, best_gap = index, gap
    return best


def _row(state: AppState, ui: Ui, level: Level, depth: int, is_here: bool) -> bool:
    at = imgui.get_cursor_screen_pos()
    width, height = imgui.get_content_region_avail().x, ui.pt(ROW_PT)
    pressed = imgui.invisible_button(f"level{level.index}", (width, height))
    draw = imgui.get_window_draw_list()
    corner = (at.x + width, at.y + height)
    if imgui.is_item_hovered() or is_here:
        shade = theme.HOVER if imgui.is_item_hovered() else theme.FIELD
        draw.add_rect_filled((at.x, at.y), corner, u32(shade), ui.pt(7))
    x = at.x + ui.pt(5 + INDENT_PT * min(depth, MAX_INDENT))
    picture = (x, at.y + ui.pt(5), ui.pt(PICTURE_PT), height - ui.pt(10))
    _picture(ui, level, picture, is_here)
    _words(state, ui, level, x + ui.pt(PICTURE_PT + 9), at.y + ui.pt(10), corner[0] - ui.pt(4))
    tooltip(details_of(level))
    return pressed


def details_of(level: Level) -> str:
    """Returns what a level is made of, for its tooltip."""
    lines = [title_of(level), f"{len(level.surfels):,} surfels"]
    lines += [f"{name}: {record.backend}, {record.seconds:.1f} s" for name, record in level.stages.items()]
    return "\n".join(lines)


def _picture(ui: Ui, level: Level, rect: tuple[float, float, float, float], is_here: bool) -> None:
    """The level's picture, cropped to the frame."""
    x, y, width, height = rect
    draw = imgui.get_window_draw_list()
    thumbnail = ui.thumbnails.get(level.index)
    if thumbnail is None:
        draw.add_rect_filled((x, y), (x + width, y + height), u32(theme.FIELD), ui.pt(5))
    else:
        excess = thumbnail.aspect / (width / height)
        u, v = (0.5 - 0.5 / excess, 0.0) if excess > 1 else (0.0, 0.5 - 0.5 * excess)
        corners = ((x, y), (x + width, y + height), (u, v), (1 - u, 1 - v))
        draw.add_image_rounded(thumbnail.ref, *corners, u32((1, 1, 1, 1)), ui.pt(5))
    if is_here:
        draw.add_rect((x, y), (x + width, y + height), u32(theme.ACCENT), ui.pt(5), ui.pt(1.5))


def _words(state: AppState, ui: Ui, level: Level, x: float, y: float, right: float) -> None:
    draw = imgui.get_window_draw_list()
    is_making = not state.scene.is_committed(level.index)
    line = "in the making" if is_making else magnification_text(state.scene.magnification(level.index))
    if not is_making and right - x > ui.pt(95):
        line += f" · {count_text(len(level.surfels))}"
    with face(ui.fonts.regular):
        draw.add_text((x, y), u32(theme.TEXT), elided(title_of(level), right - x))
    with face(ui.fonts.regular, theme.SMALL_PT):
        color = theme.ACCENT if is_making else theme.MUTED
        draw.add_text((x, y + ui.pt(20)), u32(color), elided(line, right - x))
