"""Notices: over what darkens the rest they are read, and take no click."""

from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from tests.app.fakes import make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.layout import arrange
from wzviewer.app.overlays import LogView, PaletteView
from wzviewer.app.panels.notices import uppermost
from wzviewer.app.state import Film, Panels

COVERS = {
    "dialog": {"panels": Panels(dialog="unsaved", help=True)},
    "palette": {"palette": PaletteView(is_open=True), "log": LogView(is_open=True)},
    "log": {"log": LogView(is_open=True), "panels": Panels(help=True)},
    "help": {"panels": Panels(help=True, start=True)},
    "start": {"panels": Panels(start=True)},
}


def depth_of(name):
    """How far in front a window is."""
    return imgui.internal.find_window_display_index(imgui.internal.find_window_by_name(name))


@pytest.mark.parametrize("cover", COVERS)
def test_notices_stay_readable_over_what_darkens_the_rest(screen, cover):
    state = replace(state_with(make_scene(2)), film=Film(Path("a/b.mp4"), 0.0, 0.4))
    state = state.with_toast("Undone.", button="Redo", command=cmd.Redo())
    rect = arrange(1280, 800, 1.0).toasts
    assert cmd.CancelFilm() in screen.click(state, rect.right - 40, rect.y + 20)
    covered = replace(state, **COVERS[cover])
    assert uppermost(covered) == cover
    for _ in range(2):
        screen.frame(covered)
    assert depth_of("shade") < depth_of("film")
    assert depth_of("shade") < depth_of("toast0")
    assert (depth_of("toast0") < depth_of(cover)) == (cover == "dialog")
    assert cmd.CancelFilm() not in screen.click(covered, rect.right - 40, rect.y + 20)
