"""Looking behind the picture: false colours, and the panel that switches them."""

from dataclasses import replace

import numpy as np

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.layout import arrange
from wzviewer.app.look import (
    FULL,
    HOLE,
    MODES,
    RAMP,
    Look,
    coverage_colors,
    depth_colors,
    level_color,
    tinted,
)
from wzviewer.app.state import Panels


def test_near_is_light_far_is_dark_and_nowhere_is_black():
    depth = np.array([[1.0, 2.0, 4.0, np.nan, 0.0]])
    colors = depth_colors(depth)[0]
    assert (colors[3:] == 0).all()
    assert colors[0].sum() > colors[1].sum() > colors[2].sum()
    assert (depth_colors(np.full((3, 3), 2.0)) == RAMP[0].astype(np.uint8)).all()  # no range at all
    assert (depth_colors(np.full((2, 2), np.nan)) == 0).all()


def test_depths_are_even_in_ratios():
    a = depth_colors(np.geomspace(1.0, 100.0, 50)[None])
    b = depth_colors(np.geomspace(1e-6, 1e-4, 50)[None])
    assert np.abs(a.astype(int) - b).max() <= 1


def test_each_level_has_a_colour_of_its_own():
    colors = np.array([level_color(i) for i in range(8)])
    apart = np.abs(colors[:, None] - colors[None]).max(-1)[~np.eye(8, dtype=bool)]
    assert apart.min() > 0.1  # measured 0.23
    grey = np.full((1, 4, 3), 128, np.uint8)
    levels = np.array([[-1, 0, 1, 2]], np.int32)
    picture = tinted(grey, levels)[0]
    assert (picture[0] == 0).all()
    assert len({tuple(c) for c in picture}) == 4


def test_holes_shine():
    colors = coverage_colors(np.float32([[0.0, 0.8, 1.0]]))[0]
    assert (colors[0] == HOLE).all()
    assert (colors[2] == FULL).all()
    assert colors[1, 0] > FULL[0]


def test_the_panel_switches_modes(screen):
    state = replace(state_with(make_scene(2)), panels=Panels(statistics=True))
    rect = arrange(1280, 800, 1.0).statistics
    (command,) = screen.click(state, rect.x + 14 + 36 + 71, rect.y + 12 + 9)
    assert command == cmd.SetLook(Look("levels"))
    (command,) = screen.click(state, rect.x + 24, rect.y + 12 + 26 + 8)
    assert command == cmd.SetLook(Look(modulation=False))


def test_the_key_goes_round_the_modes():
    services, state = fake_services(), state_with(make_scene(2))
    seen = []
    for _ in MODES:
        state = apply(services, state, [cmd.NextMode()])
        seen.append(state.look.mode)
    assert seen == ["levels", "depth", "coverage", "picture"]
