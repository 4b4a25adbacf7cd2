"""Left: the tree of levels with their pictures; a click flies there."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.panels.surface import Ui, elided, face, picture, plate, tooltip
from wzviewer.app.panels.wording import count_text, magnification_text
from wzviewer.app.places import level_here
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
        nearest = level_here(state)
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


def _row(state: AppState, ui: Ui, level: Level, depth: int, is_here: bool) -> bool:
    at = imgui.get_cursor_screen_pos()
    width, height = imgui.get_content_region_avail().x, ui.pt(ROW_PT)
    pressed = imgui.invisible_button(f"level{level.index}", (width, height))
    draw = imgui.get_window_draw_list()
    corner = (at.x + width, at.y + height)
    if imgui.is_item_hovered() or is_here:
        shade = ui.colors.hover if imgui.is_item_hovered() else ui.colors.field
        draw.add_rect_filled((at.x, at.y), corner, u32(shade), ui.pt(7))
    x = at.x + ui.pt(5 + INDENT_PT * min(depth, MAX_INDENT))
    frame = (x, at.y + ui.pt(5), ui.pt(PICTURE_PT), height - ui.pt(10))
    picture(ui, ui.thumbnails.get(level.index), frame, is_here)
    _words(state, ui, level, x + ui.pt(PICTURE_PT + 9), at.y + ui.pt(10), corner[0] - ui.pt(4))
    tooltip(details_of(level))
    return pressed


def details_of(level: Level) -> str:
    """Returns what a level is made of, for its tooltip."""
    lines = [title_of(level), f"{len(level.surfels):,} surfels"]
    lines += [f"{name}: {record.backend}, {record.seconds:.1f} s" for name, record in level.stages.items()]
    return "\n".join(lines)


def _words(state: AppState, ui: Ui, level: Level, x: float, y: float, right: float) -> None:
    draw = imgui.get_window_draw_list()
    is_making = not state.scene.is_committed(level.index)
    line = "in the making" if is_making else magnification_text(state.scene.magnification(level.index))
    if not is_making and right - x > ui.pt(95):
        line += f" · {count_text(len(level.surfels))}"
    with face(ui.fonts.regular):
        draw.add_text((x, y), u32(ui.colors.text), elided(title_of(level), right - x))
    with face(ui.fonts.regular, theme.SMALL_PT):
        color = ui.colors.accent if is_making else ui.colors.muted
        draw.add_text((x, y + ui.pt(20)), u32(color), elided(line, right - x))
