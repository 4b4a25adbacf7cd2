"""Where notices stand: top right, and the film in the making above them."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.layout import Layout, Rect
from wzviewer.app.panels.keep import draw_film
from wzviewer.app.panels.surface import Ui
from wzviewer.app.panels.toasts import draw_toasts
from wzviewer.app.state import AppState

START_PT = 660.0  # width of the start page with recent files
NARROWEST_PT = 180.0  # notice
FOOT_PT = 138.0  # below the statistics: a film in the making and one notice


def has_notices(state: AppState) -> bool:
    """Whether there is anything to say."""
    return state.film is not None or any(toast.is_alive(state.now_s) for toast in state.toasts)


def is_side_taken(state: AppState) -> bool:
    """Whether another panel stands where the tree does."""
    panels = state.panels
    return panels.keep or panels.settings or panels.history


def taken_on_the_left(state: AppState, layout: Layout) -> float:
    """Returns the right edge of what stands below the toolbar, imgui units."""
    if is_side_taken(state):
        return layout.side.right
    return layout.tree.right if state.panels.tree and len(state.scene) else layout.tree.x


def notices_place(state: AppState, layout: Layout) -> Rect:
    """Returns where notices may stand: out of the way of the statistics, and of what is on the left."""
    if not state.has_document:
        return _beside_start(layout)
    if not state.panels.statistics:
        return layout.toasts
    beside = layout.toasts_beside
    if beside.x > taken_on_the_left(state, layout):
        return beside
    column = layout.statistics
    height = min(FOOT_PT * layout.scale, column.height / 2)
    return replace(column, y=column.bottom - height, height=height)


def _beside_start(layout: Layout) -> Rect:
    """Right of the start page where that leaves room, else over its corner; there is no toolbar."""
    toasts, gap = layout.toasts, layout.toolbar.y
    room = (layout.window.width - START_PT * layout.scale) / 2 - 2 * gap
    width = min(toasts.width, room) if room >= NARROWEST_PT * layout.scale else toasts.width
    return replace(toasts, x=toasts.right - width, y=gap, width=width)


def draw_notices(state: AppState, ui: Ui, place: Rect, is_front: bool = False) -> list[cmd.Command]:
    """Draws the film in the making, and the notices below it.

    Args:
        state: of the app.
        ui: what to draw with.
        place: where they may stand.
        is_front: whether they stand before all that was drawn earlier, to be read only.
    """
    asked, height = draw_film(state, ui, place, is_front)
    rest = replace(place, y=place.y + height, height=max(place.height - height, 0.0))
    return asked + draw_toasts(state, ui, rest, is_front)


def draw_notices_over(state: AppState, ui: Ui) -> None:
    """Draws them at the very top, to be read only: they stay readable while something darkens the rest."""
    place, top = notices_place(state, ui.layout), ui.layout.toolbar.y
    draw_notices(state, ui, replace(place, y=top, height=place.bottom - top), is_front=True)


def uppermost(state: AppState) -> str:
    """Returns what stands over all else, or nothing; in the order that `screen` draws them."""
    panels = state.panels
    covers = {
        "dialog": bool(panels.dialog),
        "palette": state.palette.is_open,
        "log": state.log.is_open,
        "help": panels.help,
        "start": panels.start and state.has_document,
    }
    return next((name for name, is_there in covers.items() if is_there), "")
