"""Left: the tree of levels with their pictures; a click flies there, an eye hides, F2 renames."""

from itertools import pairwise

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import label_of
from wzviewer.app.naming import name_in
from wzviewer.app.panels.branches import Row, tree_rows
from wzviewer.app.panels.surface import Ui, colored, elided, face, menu, picture, plate, quiet, tooltip
from wzviewer.app.panels.wording import count_text, magnification_text, stage_text
from wzviewer.app.places import level_here
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.app.variants import can_vary
from wzviewer.core.scene import Scene

ROW_PT, GAP_PT = 58.0, 4.0
INDENT_PT = 12.0
MAX_INDENT = 4  # deeper rows stay here, or the names would have no room
PICTURE_PT = 64.0
EYE_PT = 26.0
BUILTIN = "builtin"  # who makes a stage when nothing else is said
HIDDEN_ALPHA = 0.38  # of what is not seen


def draw_tree(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the tree, the level that one is in scrolled into view."""
    rows = tree_rows(state.scene)
    if not state.panels.tree or not rows:
        return []
    commands: list[cmd.Command] = []
    rect = ui.layout.tree
    height = height_of(ui, len(rows))
    if height < ui.pt(12 + ROW_PT):
        return []  # not even a row has room
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(6), ui.pt(6)))
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.0, ui.pt(GAP_PT)))
    with plate("tree", type(rect)(rect.x, rect.y, rect.width, height), scrolls=True):
        nearest = level_here(state)
        if state.renaming is None:
            _changes("renaming", -1)
        for row in rows:
            if not imgui.is_rect_visible((1.0, ui.pt(ROW_PT))) and row.index != nearest:
                imgui.dummy((1.0, ui.pt(ROW_PT)))
                continue
            commands += _row(state, ui, row, row.index == nearest)
    imgui.pop_style_var(2)
    return commands


def height_of(ui: Ui, rows: int) -> float:
    """Returns the height of a tree of so many rows, imgui units."""
    return min(ui.layout.tree.height, ui.pt(12 + rows * (ROW_PT + GAP_PT) - GAP_PT))


def _row(state: AppState, ui: Ui, row: Row, is_here: bool) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    index, at = row.index, imgui.get_cursor_screen_pos()
    width, height = imgui.get_content_region_avail().x, ui.pt(ROW_PT)
    corner = (at.x + width, at.y + height)
    # While its own eye is pressed the row stays hovered, or the eye would be gone.
    over = imgui.HoveredFlags_.allow_when_blocked_by_active_item.value
    is_hovered = imgui.is_window_hovered(over) and imgui.is_mouse_hovering_rect((at.x, at.y), corner)
    if is_hovered or is_here:
        shade = ui.colors.hover if is_hovered else ui.colors.field
        imgui.get_window_draw_list().add_rect_filled((at.x, at.y), corner, u32(shade), ui.pt(7))
    _lines(ui, row, at.x, at.y)
    opacity = 1.0 if row.is_seen else HIDDEN_ALPHA
    x = at.x + ui.pt(5 + INDENT_PT * min(row.depth, MAX_INDENT))
    frame = (x, at.y + ui.pt(5), ui.pt(PICTURE_PT), height - ui.pt(10))
    picture(ui, ui.thumbnails.get(index), frame, is_here, opacity)
    has_eye = index > 0 and (is_hovered or state.scene.mark(index).sight != "shown")
    right, text_x = corner[0] - ui.pt(EYE_PT + 2 if has_eye else 4), x + ui.pt(PICTURE_PT + 9)
    _words(state, ui, row, text_x, at.y + ui.pt(10), right)
    # What lies on the row comes first: of items in one place the first one has the mouse.
    if state.renaming == index:
        commands += _rename(state, ui, index, (text_x - ui.pt(5), at.y + ui.pt(5)), corner[0])
    elif has_eye:
        commands += _eye(state, ui, index, (corner[0] - ui.pt(EYE_PT + 2), at.y + ui.pt(16)))
    imgui.set_cursor_screen_pos(at)
    pressed = imgui.invisible_button(f"level{index}", (width, height))
    if is_here:
        _follow(index)
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(0):
        commands.append(cmd.BeginRename(index))
    elif pressed:
        commands.append(cmd.GoToLevel(index))
    if imgui.is_item_hovered():
        tooltip(details_of(state.scene, index))
    return commands + _menu(state, ui, row)


def _follow(index: int) -> None:
    """Scrolls to the level that one is in, once when it becomes another."""
    if _changes("here", index):
        imgui.set_scroll_here_y(0.5)


def _changes(what: str, value: int) -> bool:
    """Whether a number is another than in the frame before, as the window remembers it."""
    storage, key = imgui.get_state_storage(), imgui.get_id(what)
    before = storage.get_int(key, -1)
    storage.set_int(key, value)
    return bool(before != value)


def _lines(ui: Ui, row: Row, x: float, y: float) -> None:
    """What joins a row to its parent, and passes by to siblings further below."""
    draw, color = imgui.get_window_draw_list(), u32(ui.colors.line)
    top, bottom = y - ui.pt(GAP_PT), y + ui.pt(ROW_PT)

    def column(depth: int) -> float:
        return x + ui.pt(5 + INDENT_PT * min(depth, MAX_INDENT) + 5)

    for depth in row.passing:
        if 0 < depth <= MAX_INDENT:
            draw.add_line((column(depth - 1), top), (column(depth - 1), bottom), color, ui.pt(1))
    if row.depth == 0:
        return
    line, middle = column(row.depth - 1), y + ui.pt(ROW_PT) / 2
    if row.depth > MAX_INDENT:  # no room for a step to the right: a short line from picture to picture
        draw.add_line((line, top - ui.pt(5)), (line, y + ui.pt(5)), color, ui.pt(1))
        return
    corner = ((line, top - ui.pt(5)), (line, middle), (x + ui.pt(3 + INDENT_PT * row.depth), middle))
    for a, b in pairwise(corner):
        draw.add_line(a, b, color, ui.pt(1))
    if not row.is_last:
        draw.add_line((line, middle), (line, bottom), color, ui.pt(1))


def _eye(state: AppState, ui: Ui, index: int, at: tuple[float, float]) -> list[cmd.Command]:
    is_shown = state.scene.mark(index).sight == "shown"
    imgui.set_cursor_screen_pos(at)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    icon = icons.ICON_FA_EYE if is_shown else icons.ICON_FA_EYE_SLASH
    with quiet(), colored(ui.colors.muted):
        pressed = imgui.button(f"{icon}##eye{index}", (ui.pt(EYE_PT), ui.pt(EYE_PT)))
    imgui.pop_style_var()
    tooltip("Hide this and what is inside" if is_shown else "Show it again")
    return [cmd.ShowLevel(index, not is_shown)] if pressed else []


def _rename(state: AppState, ui: Ui, index: int, at: tuple[float, float], right: float) -> list[cmd.Command]:
    """The name as a line of text: Enter and a click elsewhere take it, Escape does not."""
    imgui.set_cursor_screen_pos(at)
    imgui.set_next_item_width(right - at[0] - ui.pt(3))
    if _changes("renaming", index):
        imgui.set_keyboard_focus_here()
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(5), ui.pt(3)))
    flags = imgui.InputTextFlags_.auto_select_all.value
    with colored(ui.colors.solid, imgui.Col_.frame_bg):
        _, text = imgui.input_text(f"##name{index}", name_in(state.scene, index), flags)
    imgui.pop_style_var()
    if not imgui.is_item_deactivated():
        return []
    return [cmd.EndRename() if imgui.is_key_pressed(imgui.Key.escape) else cmd.RenameLevel(index, text)]


def _menu(state: AppState, ui: Ui, row: Row) -> list[cmd.Command]:
    """What the right button offers."""
    with menu(ui, f"menu{row.index}", is_context=True) as is_open:
        return _offers(state, row) if is_open else []


def _offers(state: AppState, row: Row) -> list[cmd.Command]:
    scene, index, keymap = state.scene, row.index, state.settings.keymap
    is_shown, is_done = scene.mark(index).sight == "shown", scene.is_committed(index)
    offers: list[tuple[str, str, cmd.Command, bool]] = [
        ("Fly there", "", cmd.GoToLevel(index), True),
        ("Rename", label_of(cmd.BeginRename, keymap), cmd.BeginRename(index), True),
    ]
    if index > 0:
        offers += [
            ("Hide" if is_shown else "Show", "", cmd.ShowLevel(index, not is_shown), is_done),
            ("Another", label_of(cmd.Another, keymap), cmd.Another(index), can_vary(scene, index)),
            ("Variants", "", cmd.OpenVariants(index), row.variants > 1),
            ("Delete", label_of(cmd.DeleteHere, keymap), cmd.DeleteLevel(index), is_done),
        ]
    return [c for name, key, c, is_possible in offers if imgui.menu_item(name, key, False, is_possible)[0]]


def details_of(scene: Scene, index: int) -> str:
    """Returns what a level is made of, for its tooltip."""
    level, name = scene[index], name_in(scene, index)
    lines = [name, f"{len(level.surfels):,} points"]
    if level.prompt and level.prompt != name:
        lines.insert(1, f"“{level.prompt}”")
    for stage, record in level.stages.items():
        by = "" if record.backend == BUILTIN else f" by {record.backend}"
        lines.append(f"{stage_text(stage)}{by} {record.seconds:.1f} s")
    return "\n".join(lines)


def with_unit(line: str, room: float) -> str:
    """Returns a line that ends in a count with what is counted, where there is room."""
    whole = f"{line} points"
    return whole if imgui.calc_text_size(whole).x <= room else line


def _words(state: AppState, ui: Ui, row: Row, x: float, y: float, right: float) -> None:
    draw, index = imgui.get_window_draw_list(), row.index
    level, is_making = state.scene[index], not state.scene.is_committed(index)
    line = (
        "in the making"
        if is_making
        else magnification_text(state.scene.magnification(index), right - x < ui.pt(95))
    )
    if row.variants > 1:
        line += f" · {row.number} of {row.variants}"
    has_count = not is_making and row.variants <= 1 and right - x > ui.pt(95)
    if has_count:
        line += f" · {count_text(len(level.surfels))}"
    with face(ui.fonts.regular):
        name = u32(ui.colors.text if row.is_seen else ui.colors.muted)  # not paler: it is there to be read
        draw.add_text((x, y), name, elided(name_in(state.scene, index), right - x))
    with face(ui.fonts.regular, theme.SMALL_PT):
        line = with_unit(line, right - x) if has_count else line
        color = ui.colors.accent if is_making else ui.colors.muted
        draw.add_text((x, y + ui.pt(20)), u32(color), elided(line, right - x))
