"""A picture continued beyond what is known: what stays, what goes on, and how deep."""

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.extend import extended
from wzviewer.worker.models.builtin.views.layers import Surface

WIDTH, HEIGHT, HORIZON, KNOWN = 240, 160, 60, 120
AXIS = DepthAxis.of(Camera.initial(WIDTH, HEIGHT, 250.0))
SKY, FAR_RELIEF = np.float32([0.4, 0.6, 0.9]), 9000.0


@pytest.fixture(scope="module")
def frame():
    """A blue sky over ground with rows of two greens, which comes nearer downwards."""
    rows = np.arange(HEIGHT)
    stripes = np.where(
        (rows // 8 % 2)[:, None, None] == 1, np.float32([0.2, 0.5, 0.1]), np.float32([0.5, 0.7, 0.3])
    )
    is_sky = (rows < HORIZON)[:, None] & np.ones((1, WIDTH), bool)
    image = np.where(is_sky[..., None], SKY, np.broadcast_to(stripes, (HEIGHT, WIDTH, 3)))
    depth = np.clip(100.0 - 1.0 * (rows - HORIZON), 0.0, 100.0)[:, None] * np.ones((1, WIDTH))
    relief = np.where(is_sky, FAR_RELIEF, depth).astype(np.float32)
    return Surface(image.astype(np.float32), AXIS.shift_of(relief), relief, is_sky)


@pytest.fixture(scope="module")
def known():
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[:, :KNOWN] = True
    return mask


@pytest.fixture(scope="module")
def made(frame, known):
    hidden = np.where(known[..., None], frame.image, np.float32([1.0, 0.0, 1.0])).astype(np.float32)
    relief = np.where(known, frame.relief, np.float32(0))
    return extended(Surface(hidden, AXIS.shift_of(relief), relief, frame.sky & known), known, AXIS, 3)


def test_what_is_known_stays(frame, known, made):
    np.testing.assert_array_equal(made.image[known], frame.image[known])
    np.testing.assert_array_equal(made.relief[known], frame.relief[known])
    np.testing.assert_array_equal(made.sky[known], frame.sky[known])


def test_nothing_of_the_unknown_is_used(made):
    assert made.image[..., 1].min() > 0.2  # magenta has no green


def test_the_rows_go_on(frame, known, made):
    wrong = np.abs(made.image - frame.image).max(-1) > 0.1
    assert wrong[~known].mean() < 0.15  # measured 0.07, at the horizon


def test_the_horizon_goes_on_in_label_and_depth(frame, known, made):
    assert (made.sky != frame.sky)[~known].mean() < 0.1  # measured 0.054: a horizon of 3 px either way
    ground = ~frame.sky & ~made.sky & ~known
    assert np.abs(made.shift - frame.shift)[ground].mean() < 3.0  # of 71 px of range; measured 0.7
    assert made.relief[made.sky & ~known] == pytest.approx(FAR_RELIEF, rel=1e-3)


def test_the_same_seed_gives_the_same_bytes(frame, known, made):
    again = extended(frame, known, AXIS, 3)
    np.testing.assert_array_equal(again.image, made.image)
    np.testing.assert_array_equal(again.relief, made.relief)
