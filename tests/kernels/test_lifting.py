"""The compiled lift is the numpy one."""

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift as reference
from wzviewer.kernels.lifting import lift

TINY = 2e-5  # measured 7e-6, of quaternions of round footprints on a body of 480 000 pixels


def scene():
    """A bumpy surface in steps, with holes, a pixel at the camera and one beyond it."""
    rng = np.random.default_rng(4)
    image = rng.random((150, 170, 3), np.float32)
    relief = (np.cumsum(rng.normal(0, 2, (150, 170)), axis=1) + 90 * (rng.random((150, 1)) > 0.9)).astype(
        np.float32
    )
    relief[rng.random(relief.shape) > 0.95] = np.nan
    relief[3, 3], relief[5, 5], relief[7, 7:11] = -1024, -2000, [np.nan, 5, np.nan, 4]
    return image, relief, Camera.initial(170, 150)


def equal(one, two):
    assert len(one) == len(two)
    for name, values in one.arrays().items():
        other = two.arrays()[name]
        assert values.dtype == other.dtype == np.float32
        if name == "quats":  # q and -q turn alike
            other = other * np.sign((values * other).sum(1, keepdims=True))
        assert np.allclose(values, other, rtol=TINY, atol=TINY), name


@pytest.mark.filterwarnings("ignore:invalid value")
def test_surfels_are_those_of_the_reference():
    image, relief, camera = scene()
    equal(lift(image, relief, camera), reference(image, relief, camera))


@pytest.mark.filterwarnings("ignore:invalid value")
def test_parts_and_layers_of_a_picture():
    image, relief, camera = scene()
    rng = np.random.default_rng(1)
    opacity, mask = rng.random(relief.shape, np.float32), rng.random(relief.shape) > 0.7
    window = {"offset_px": (-20, 31)}
    equal(
        lift(image, relief, camera, opacity=opacity, **window),
        reference(image, relief, camera, opacity=opacity, **window),
    )
    equal(
        lift(image[::-1], relief[::-1], camera, mask, 0.9, **window),
        reference(image[::-1], relief[::-1], camera, None, mask, 0.9, **window),
    )


def test_nothing_to_lift():
    image, relief, camera = scene()
    assert len(lift(image, np.full_like(relief, np.nan), camera)) == 0
    assert len(lift(image[:0], relief[:0], camera)) == 0
