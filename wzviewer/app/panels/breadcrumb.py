"""Top: where one is, from the photo down, with pictures; a click flies there.  Back and forward."""

from dataclasses import dataclass

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.keys import label_of
from wzviewer.app.layout import Rect
from wzviewer.app.naming import name_in
from wzviewer.app.panels.surface import Ui, elided, face, picture, plate, quiet, tooltip
from wzviewer.app.panels.tree import details_of
from wzviewer.app.panels.wording import magnification_text
from wzviewer.app.places import level_here
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32
from wzviewer.app.trail import can_go_back, can_go_forward
from wzviewer.core.scene import Scene

BUTTON_PT = (26.0, 30.0)
PICTURE_PT = (40.0, 27.0)
NAME_PT = 92.0  # longest name
GAP_PT, ARROW_PT = 7.0, 15.0
NARROWEST_PT = 150.0  # below it there is no room for a single crumb
ARTICLES = ("a ", "an ", "the ", "one ")


@dataclass(frozen=True)
class Crumb:
    """A level on the way: ``width`` in imgui units, with its name or only its picture."""

    index: int
    width: float
    has_name: bool


def draw_breadcrumb(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the way from the photo to the view, as much of its end as there is room for."""
    rect = ui.layout.breadcrumb
    if not len(state.scene) or rect.width < ui.pt(NARROWEST_PT):
        return []
    commands: list[cmd.Command] = []
    path = state.scene.path(level_here(state))
    with face(ui.fonts.regular, theme.SMALL_PT + 1.0):
        magnification = magnification_text(max(state.view.magnification, 0.0))
        fixed = ui.pt(2 * BUTTON_PT[0] + 3 * GAP_PT + 16) + imgui.calc_text_size(magnification).x
        crumbs, width = chosen(state.scene, path, rect.width - fixed, ui)
        if fixed + width > rect.width:
            return []  # not even a picture has room
        imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(8), ui.pt(8)))
        with plate("breadcrumb", Rect(rect.x, rect.y, fixed + width, rect.height)):
            commands += _steps(state, ui)
            x, y = imgui.get_cursor_screen_pos().x, rect.y
            for number, crumb in enumerate(crumbs):
                if number:
                    x = _arrow(ui, x, y, has_gap=number == 1 and crumb.index != path[1])
                if _crumb(ui, state.scene, crumb, x, y, is_here=crumb.index == path[-1]):
                    commands.append(cmd.GoToLevel(crumb.index))
                x += crumb.width
            _label(ui, magnification, x + ui.pt(GAP_PT), y, ui.colors.accent)
        imgui.pop_style_var()
    return commands


def chosen(scene: Scene, path: list[int], room: float, ui: Ui) -> tuple[list[Crumb], float]:
    """Returns the crumbs of a path that are shown, and their width.

    All with their names where there is room; else those between without; else the last ones of them, and
    these without names, too, where not even the last one fits.
    """
    bare = ui.pt(PICTURE_PT[0] + 8)
    names = {i: _width(ui, scene, i) for i in path}
    short = {i: names[i] if i in (path[0], path[-1]) else bare for i in path}
    none = dict.fromkeys(path, bare)
    found: tuple[list[int], float] = ([], 0.0)
    for widths in (names, short, none):
        found = fitting(path, [widths[i] for i in path], room, ui)
        if found[0] == path or (widths is short and found[1] <= room):
            break
    return [Crumb(i, widths[i], widths[i] > bare) for i in found[0]], found[1]


def fitting(path: list[int], widths: list[float], room: float, ui: Ui) -> tuple[list[int], float]:
    """Returns the levels of a path that are shown, and their width: the first, and the last that fit.

    Args:
        path: level indices from the root.
        widths: of their crumbs, imgui units.
        room: imgui units.
        ui: for the width of the arrows.
    """
    arrow = ui.pt(ARROW_PT)
    last, width = len(path) - 1, widths[-1]
    if last == 0:
        return path, width
    width += widths[0] + 2 * arrow
    # With the second one shown there are no dots, and so one arrow less.
    while last > 1 and width + widths[last - 1] + (arrow if last > 2 else 0.0) <= room:
        last -= 1
        width += widths[last] + arrow
    if last == 1:
        width -= arrow  # nothing is left out
    if width > room:
        return path[-1:], widths[-1]
    return [path[0], *path[last:]], width


def name_of(scene: Scene, index: int) -> str:
    """Returns the name of a level in a crumb: its prompt without the article."""
    title = name_in(scene, index)
    return next((title[len(a) :] for a in ARTICLES if title.startswith(a)), title).lower()


def _width(ui: Ui, scene: Scene, index: int) -> float:
    name = min(imgui.calc_text_size(name_of(scene, index)).x, ui.pt(NAME_PT))
    return ui.pt(PICTURE_PT[0] + GAP_PT + 8) + name


def _steps(state: AppState, ui: Ui) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    steps: tuple[tuple[str, str, cmd.Command, bool], ...] = (
        (icons.ICON_FA_ARROW_LEFT, "The view before", cmd.GoBack(), can_go_back(state)),
        (icons.ICON_FA_ARROW_RIGHT, "The view after", cmd.GoForward(), can_go_forward(state)),
    )
    with quiet():
        for icon, what, command, is_possible in steps:
            imgui.begin_disabled(not is_possible)
            imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
            if imgui.button(f"{icon}##{what}", (ui.pt(BUTTON_PT[0]), ui.pt(BUTTON_PT[1]))):
                commands.append(command)
            imgui.pop_style_var()
            imgui.end_disabled()
            tooltip(f"{what}   {label_of(type(command), state.settings.keymap)}")
            imgui.same_line(0.0, ui.pt(2))
    return commands


def _crumb(ui: Ui, scene: Scene, crumb: Crumb, x: float, y: float, is_here: bool) -> bool:
    index, width = crumb.index, crumb.width
    imgui.set_cursor_screen_pos((x, y + ui.pt(6)))
    pressed = imgui.invisible_button(f"crumb{index}", (width, ui.layout.breadcrumb.height - ui.pt(12)))
    if imgui.is_item_hovered():
        lower, upper = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        imgui.get_window_draw_list().add_rect_filled(lower, upper, u32(ui.colors.hover), ui.pt(6))
    top = y + (ui.layout.breadcrumb.height - ui.pt(PICTURE_PT[1])) / 2
    at = (x + ui.pt(4), top, ui.pt(PICTURE_PT[0]), ui.pt(PICTURE_PT[1]))
    picture(ui, ui.thumbnails.get(index), at, is_here)
    name = elided(name_of(scene, index), ui.pt(NAME_PT)) if crumb.has_name else ""
    _label(ui, name, x + ui.pt(4 + PICTURE_PT[0] + GAP_PT), y, ui.colors.text if is_here else ui.colors.muted)
    tooltip(details_of(scene, index))
    return pressed


def _arrow(ui: Ui, x: float, y: float, has_gap: bool) -> float:
    """A chevron, with dots where levels are left out; returns where the next crumb begins."""
    for sign in ("…", "›") if has_gap else ("›",):
        offset = (ui.pt(ARROW_PT) - imgui.calc_text_size(sign).x) / 2
        _label(ui, sign, x + offset, y, ui.colors.muted)
        x += ui.pt(ARROW_PT)
    return x


def _label(ui: Ui, text: str, x: float, y: float, color: theme.Rgba) -> None:
    top = y + (ui.layout.breadcrumb.height - imgui.get_text_line_height()) / 2
    imgui.get_window_draw_list().add_text((x, top), u32(color), text)
