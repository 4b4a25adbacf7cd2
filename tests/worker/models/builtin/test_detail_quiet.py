"""A photograph's noise is taken out before it is enlarged, and nothing else is."""

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.measures import luma
from wzviewer.worker.models.builtin.detail.quiet import noise_rms, quieted, without_blotches, without_noise


def region(calm, share=0.5):
    return Region(share, 70, 0, -20, 1, 1, 1, 0.5, 0.2, 0.9, calm=calm)


def context(*calm):
    return Context(np.zeros((4, 4), np.uint8), ("sky",) * len(calm), tuple(map(region, calm)), "")


@pytest.mark.parametrize(
    ("calm", "noise"),
    [((0.5, 4.0), 1.2), ((0.1, 4.0), 0.48), ((0.9,), 2.16), ((2.0, 4.0), 0.0), ((), 0.0)],
)
def test_noise_is_known_from_what_is_calm(calm, noise):
    assert noise_rms(context(*calm)) == pytest.approx(noise, abs=1e-5)


def test_a_noisy_ramp_becomes_the_ramp():
    ramp = np.tile(np.linspace(80, 160, 90, dtype=np.float32)[None, :, None], (60, 1, 3))
    noisy = ramp + np.random.default_rng(0).normal(0, 1.5, ramp.shape).astype(np.float32)
    made = quieted(noisy, 1.5)
    assert (made - ramp)[8:-8, 8:-8].std() < 0.4  # measured 0.25
    assert np.abs(np.diff(cv2.blur(made, (1, 9)), axis=1)).max() < 2.5  # measured 1.4: no steps


def test_contours_and_texture_stay():
    y, x = np.mgrid[0:60, 0:90]
    wall = np.where(x < 45, 60.0, 180.0) + 12 * np.sin(x * 1.9) * np.sin(y * 1.7)
    wall = np.repeat(wall[..., None], 3, 2).astype(np.float32)
    made = quieted(wall, 1.2)
    assert np.abs(made - wall).mean() < 0.9  # measured 0.6 of a texture of 6 and a step of 120


def test_what_grew_is_left_alone():
    noisy = np.random.default_rng(0).normal(120, 1.5, (40, 80, 3)).astype(np.float32)
    labels = np.zeros((40, 80), np.uint8)
    labels[:, 40:] = 1
    made = without_noise(noisy, labels, ("sky", "foliage"), context(0.7))
    assert made[:, :28].std() < 0.4  # measured 0.2
    np.testing.assert_allclose(luma(made)[:, 52:], luma(noisy)[:, 52:], atol=0.5)  # measured 0.3
    for names, calm in ((("fur", "foliage"), 0.7), (("sky", "sky"), 3.0)):
        kept = without_noise(noisy, labels, names, context(calm))
        np.testing.assert_allclose(luma(kept), luma(noisy), atol=0.5)


def test_freckles_fade_and_light_and_colours_stay():
    image = np.full((40, 80, 3), (90, 110, 60), np.float32)
    image[:, 40:] = (200, 60, 60)
    speckles = np.random.default_rng(0).normal(0, 2.0, (40, 80)).astype(np.float32)
    freckled = image + speckles[..., None] * np.array([1, 0, -2.6], np.float32)
    light = np.random.default_rng(1).normal(0, 6.0, (40, 80, 1)).astype(np.float32)
    made = without_blotches(freckled + light)
    np.testing.assert_allclose(luma(made), luma(freckled + light), atol=0.6)  # measured 0.4
    left = (made - image - light)[:, 8:72, 2].std()
    assert left < 1.6  # measured 0.9 of 5.2
