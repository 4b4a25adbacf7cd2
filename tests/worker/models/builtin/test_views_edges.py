"""Depth steps of a level beyond the photograph: which are steps, and at which pixel."""

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.core.constants import FOCAL_PX, IMAGE_WIDTH_PX
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.edges import clean_edges, even_small_steps, has_steps

SIZE = 128
GAIN = float(np.tan(np.deg2rad(12.0)))
SKY, PETAL = np.float32([0.5, 0.6, 0.8]), np.float32([0.9, 0.6, 0.1])


def axis_of(factor: float) -> DepthAxis:
    root = Camera.initial(SIZE, SIZE, FOCAL_PX * SIZE / IMAGE_WIDTH_PX)
    return DepthAxis.of(root.zoomed_to_region(0.5, 0.5, factor) if factor > 1 else root)


def step_of(jump_px: float) -> np.ndarray:
    """Relief with a step of so many native px in its middle."""
    return np.where(np.arange(SIZE) < SIZE // 2, 0.0, jump_px).astype(np.float32) * np.ones(
        (SIZE, 1), np.float32
    )


@pytest.mark.parametrize(("factor", "jump_px", "is_step"), [(8, 40, False), (8, 400, True), (64, 40, True)])
def test_within_the_errors_of_the_photographs_depth_there_is_no_step(factor, jump_px, is_step):
    axis, relief = axis_of(factor), step_of(jump_px)
    even = even_small_steps(relief, axis, GAIN)
    assert np.array_equal(even, relief) == is_step
    assert has_steps(axis.shift_of(even), axis, GAIN) == is_step
    if not is_step:
        assert np.abs(np.diff(even, axis=1)).max() < 2.0  # px a px; measured: 1.6
        assert np.array_equal(even[:, [20, -20]], relief[:, [20, -20]])


def test_a_slope_is_left_alone():
    slope = np.linspace(0, 100, SIZE, dtype=np.float32) * np.ones((SIZE, 1), np.float32)
    assert even_small_steps(slope, axis_of(8), GAIN) is slope


def test_the_soft_rim_of_a_magnified_picture_goes_with_the_near_side():
    axis = axis_of(8)
    x = np.arange(SIZE, dtype=np.float32)
    share = np.clip((x - SIZE // 2 + 4) / 8, 0, 1)[None, :, None]  # of the sky: soft over eight pixels
    halo = np.where((x >= SIZE // 2 + 4) & (x < SIZE // 2 + 8), np.float32(0.15), 0)[None, :, None]
    image = np.ones((SIZE, 1, 1), np.float32) * (PETAL + share * (SKY - PETAL) + halo)
    clean = clean_edges(axis.shift_of(step_of(5000.0)), image.astype(np.float32), axis, GAIN)
    edge = np.count_nonzero(clean[20:-20] > -1.0, axis=1)
    assert (edge >= SIZE // 2 + 6).all()  # on the bright rim; measured: + 7, and + 3 with the rule of level 0
    assert (edge <= SIZE // 2 + 10).all()
