"""Fronts and edges: where the hidden world begins."""

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.edges import clean_edges, has_steps, sharpen_steps
from wzviewer.worker.models.builtin.views.fronts import grow_fronts

GAIN = float(np.tan(np.deg2rad(12)))
WIDE = DepthAxis.of(Camera.initial(200, 120, 200.0))
SHAPE = (120, 200)


def step(near: float = 200.0, far: float = -60.0) -> np.ndarray:
    return np.where(np.arange(SHAPE[1])[None] < 100, near, far).astype(np.float32) + np.zeros(
        SHAPE, np.float32
    )


def test_axis_is_invertible_at_every_level():
    relief = np.array([-150, -3, 0, 0.25, 40, 7000], np.float32)
    for focal_px in (200.0, 7e13):
        axis = DepthAxis(focal_px, 200.0)
        assert np.allclose(axis.relief_of(axis.shift_of(relief)), relief, rtol=2e-5, atol=1e-4)
    far = np.array([1e15], np.float32)
    axis = DepthAxis(7e13, 1024.0)
    assert np.allclose(axis.relief_of(axis.shift_of(far)), far, rtol=1e-4)  # measured 2e-6


def test_wide_axis_is_parallax():
    relief = np.array([100.0, -50.0], np.float32)
    assert np.allclose(WIDE.shift_of(relief), -relief / (1 + relief / 200.0))


def test_front_reaches_as_far_as_the_orbit_looks():
    shift = step()
    fronts = grow_fronts(shift, WIDE, GAIN, np.ones(SHAPE, bool), np.zeros(SHAPE, bool))
    width = fronts.reached[60].sum()
    wanted = min(1.1 * GAIN * 260 + 4, 0.18 * WIDE.base_px)
    assert abs(width - wanted) <= 2
    assert (fronts.shift[fronts.reached] == -60).all()
    assert not fronts.reached[:, 100:].any()


def test_front_never_enters_what_lies_behind_it():
    shift = step()
    shift[:, 90:95] = -120  # a slit that is deeper than the far side
    fronts = grow_fronts(shift, WIDE, GAIN, np.ones(SHAPE, bool), np.zeros(SHAPE, bool))
    assert (fronts.shift[fronts.reached] < shift[fronts.reached]).all()
    assert not fronts.reached[:, 90:95].any()


def test_islands_of_sky_do_not_lower_the_horizon():
    sky = np.zeros(SHAPE, bool)
    sky[:30] = True
    sky[100:103, 150:153] = True
    shift = np.where(sky, -195.0, 0.0).astype(np.float32)
    fronts = grow_fronts(shift, WIDE, GAIN, np.ones(SHAPE, bool), sky)
    main = fronts.reached & (fronts.origin[..., 0] < 30)
    assert main.any()
    assert np.nonzero(main)[0].max() < 30 + 12 + 50


def test_slopes_become_steps_and_smooth_maps_stay():
    shift = step()
    shift[:, 98:102] = np.linspace(200, -60, 6, dtype=np.float32)[1:5]
    sharp = sharpen_steps(shift, WIDE, GAIN)
    assert set(np.unique(sharp)) == {-60.0, 200.0}
    smooth = np.linspace(0, 50, SHAPE[1], dtype=np.float32)[None] + np.zeros(SHAPE, np.float32)
    assert np.array_equal(clean_edges(smooth, np.zeros((*SHAPE, 3), np.float32), WIDE, GAIN), smooth)
    assert not has_steps(smooth, WIDE, GAIN)


def test_step_moves_to_the_colour_edge():
    image = np.zeros((*SHAPE, 3), np.float32)
    image[:, :97] = [0.9, 0.8, 0.1]  # the object ends 3 px before its depth does
    image[:, 97:] = [0.1, 0.3, 0.8]
    clean = clean_edges(step(), image, WIDE, GAIN)
    edge = (clean[60] > 0).sum()
    assert 97 <= edge <= 99  # the colour edge and up to 2 px of fringe


def slope(steepness: float) -> np.ndarray:
    """A surface that falls evenly over 24 px, about as steep as a step is."""
    x = np.arange(SHAPE[1], dtype=np.float32)
    fall = steepness * 3.0 / GAIN * np.clip(x - 88, 0, 24)  # 3 px of image shift a px is a step
    return (100 - fall)[None] + np.zeros(SHAPE, np.float32)


@pytest.mark.parametrize(
    ("steepness", "bumps_px", "is_step"),
    [(0.5, 0.0, False), (0.7, 8.0, False), (1.2, 0.0, True), (1.2, 8.0, True)],
)
def test_a_slope_is_a_step_as_a_whole_or_not_at_all(steepness, bumps_px, is_step):
    image = np.where(np.arange(SHAPE[1]) < 97, 0.8, 0.2).astype(np.float32)[None, :, None]
    bumps = np.random.default_rng(3).normal(0, bumps_px, SHAPE).astype(np.float32)
    shift = slope(steepness) + bumps
    shift[:20, :30] = 700  # an edge of something else, far from it
    clean = clean_edges(shift, np.broadcast_to(image, (*SHAPE, 3)), WIDE, GAIN)
    jump, before = (np.abs(np.diff(s, axis=1))[40:].max(axis=1) for s in (clean, shift))
    torn = (jump > 2 * before).mean()  # of the rows
    assert torn == is_step  # where colour may part a slope, or each pixel decides: 1, .55, 1, 1
