"""All panels of a frame, in order; the flat photo before E_0 exists."""

from dataclasses import replace

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.panels.breadcrumb import draw_breadcrumb
from wzviewer.app.panels.dialogs import draw_dialogs
from wzviewer.app.panels.frame import draw_frame
from wzviewer.app.panels.help import draw_help
from wzviewer.app.panels.hint import draw_hint
from wzviewer.app.panels.history import draw_history
from wzviewer.app.panels.keep import draw_keep
from wzviewer.app.panels.locator import draw_locator
from wzviewer.app.panels.log import draw_log
from wzviewer.app.panels.look import draw_look
from wzviewer.app.panels.notices import (
    draw_notices,
    draw_notices_over,
    has_notices,
    is_side_taken,
    notices_place,
    uppermost,
)
from wzviewer.app.panels.palette import draw_palette
from wzviewer.app.panels.prompt import draw_prompt
from wzviewer.app.panels.settings import draw_settings
from wzviewer.app.panels.start import draw_start, draw_start_over
from wzviewer.app.panels.status import draw_scale_bar, draw_status
from wzviewer.app.panels.surface import Ui
from wzviewer.app.panels.timeline import draw_timeline
from wzviewer.app.panels.toolbar import draw_toolbar
from wzviewer.app.panels.tree import draw_tree
from wzviewer.app.places import shows_photo
from wzviewer.app.state import AppState
from wzviewer.core.camera import Camera


def draw_screen(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws everything but the scene; returns what the user asked for."""
    commands: list[cmd.Command] = []
    if not state.has_document:
        commands += draw_start(state, ui)
    else:
        if shows_photo(state):
            _flat_photo(state, ui)
        asked, ui = _at_the_foot(state, ui)
        commands += asked + draw_toolbar(state, ui) + draw_breadcrumb(state, ui)
        if not is_side_taken(state) and not ui.layout.tree.overlaps(ui.layout.prompt):
            commands += draw_tree(state, ui)
        draw_frame(state, ui)
        draw_scale_bar(state, ui)
        draw_status(state, ui)
        commands += draw_look(state, _beside_notices(state, ui)) + draw_timeline(state, ui)
    if not uppermost(state):  # else they are drawn with what covers the rest
        commands += draw_notices(state, ui, notices_place(state, ui.layout))
    commands += draw_keep(state, ui) + draw_settings(state, ui) + draw_history(state, ui)
    commands += draw_hint(state, ui) + draw_start_over(state, ui) + draw_help(state, ui)
    commands += draw_log(state, ui) + draw_palette(state, ui)
    if uppermost(state) not in ("", "dialog"):
        draw_notices_over(state, ui)
    return commands + draw_dialogs(state, ui)


def _at_the_foot(state: AppState, ui: Ui) -> tuple[list[cmd.Command], Ui]:
    """What stands at the foot comes first: all else ends above it, as the interface that is returned says."""
    asked, stack = draw_prompt(state, ui)
    located, inset = draw_locator(state, ui)
    return asked + located, replace(ui, layout=ui.layout.clear_of((stack, inset)))


def _beside_notices(state: AppState, ui: Ui) -> Ui:
    """The statistics end above notices that have no room beside them."""
    place = notices_place(state, ui.layout)
    if not has_notices(state):
        return ui
    statistics = ui.layout.statistics.above([place], ui.pt(7))
    return replace(ui, layout=replace(ui.layout, statistics=statistics))


def _flat_photo(state: AppState, ui: Ui) -> None:
    """The photo where E_0 will stand: it takes zoom and pan, and no depth."""
    photo, view = ui.photo, state.view
    if photo is None or state.photo is None:
        return
    height, width = state.photo.shape[:2]
    source = Camera.initial(width, height)
    ratio = view.camera.fx / source.fx
    io = imgui.get_io().display_framebuffer_scale
    x0, y0 = view.camera.cx - source.cx * ratio, view.camera.cy - source.cy * ratio
    upper = (x0 / io.x, y0 / io.y)
    lower = ((x0 + width * ratio) / io.x, (y0 + height * ratio) / io.y)
    imgui.get_background_draw_list().add_image(photo.ref, upper, lower)
