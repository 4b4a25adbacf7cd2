import cv2
import numpy as np
import pytest

from wzviewer.core.constants import SKY_DEPTH
from wzviewer.worker.models.builtin.depth import DepthEstimator, DepthReading, depth_from_reading


@pytest.fixture(scope="module")
def estimator():
    return DepthEstimator()


def meadow(h=360, w=544):
    rng = np.random.default_rng(0)
    rows = np.linspace(0, 1, h, dtype=np.float32)[:, None, None]
    clouds = cv2.resize(rng.random((8, 12)).astype(np.float32), (w, h), interpolation=cv2.INTER_CUBIC)[
        ..., None
    ]
    sky = np.float32([0.45, 0.65, 0.92]) + 0.25 * rows + 0.08 * clouds
    blades = cv2.resize(rng.random((h, w // 3)).astype(np.float32), (w, h))[..., None] - 0.5
    grass = np.float32([0.30, 0.42, 0.16]) * (1 + 0.9 * blades * rows)
    horizon = (0.45 * h + 6 * np.sin(np.arange(w) / 25)).astype(int)
    below = np.arange(h)[:, None] >= horizon[None]
    return np.clip(np.where(below[..., None], grass, sky), 0, 1).astype(np.float32), below


def test_a_landscape_has_its_sky_and_a_ground_that_comes_nearer(estimator):
    image, below = meadow()
    reading = estimator.read(image)
    assert reading.kind == "landscape"
    assert reading.sky[~below].mean() > 0.9
    assert reading.sky[below].mean() < 0.05
    rows = reading.disparity[:, 100:-100].mean(1)
    assert rows[-20:].mean() > 1.5 * rows[200:220].mean()


def test_reading_is_finite_and_the_same_every_time(estimator):
    image, _ = meadow(180, 272)
    first, second = estimator.read(image), DepthEstimator().read(image)
    assert np.array_equal(first.disparity, second.disparity)
    assert np.array_equal(first.sky, second.sky)
    assert first.disparity.dtype == np.float32
    assert np.isfinite(first.disparity).all()
    assert 0 <= first.confidence <= 1


@pytest.mark.parametrize(("h", "w"), [(16, 16), (300, 200), (37, 211)])
def test_any_size_and_shape(estimator, h, w):
    image = np.random.default_rng(0).random((h, w, 3)).astype(np.float32)
    reading = estimator.read(image)
    assert reading.disparity.shape == reading.sky.shape == (h, w)
    assert np.isfinite(reading.disparity).all()
    assert reading.disparity.min() >= 0
    z = depth_from_reading(reading)
    assert np.isfinite(z).all()
    assert z.min() > 0


@pytest.mark.parametrize("level", [0.0, 0.5, 1.0])
def test_one_flat_color_is_survived(estimator, level):
    reading = estimator.read(np.full((64, 96, 3), level, np.float32))
    assert np.isfinite(depth_from_reading(reading)).all()


def test_grey_pictures_and_nan_pixels_are_read(estimator):
    image, _ = meadow(180, 272)
    grey = np.repeat(image.mean(2, keepdims=True), 3, 2)
    grey[3, 4] = np.nan
    assert np.isfinite(estimator.read(grey).disparity).all()


def test_depth_law():
    disparity = np.linspace(0, 1, 400, dtype=np.float32).reshape(20, 20)
    sky = np.zeros((20, 20), bool)
    sky[0] = True
    z = depth_from_reading(DepthReading(disparity, sky, "landscape", 1.0))
    assert (z[sky] == np.float32(SKY_DEPTH)).all()
    assert abs(np.median(z[~sky]) - 1) < 1e-6
    assert (np.diff(z[1:].ravel()) <= 0).all()
    # 1 / (eps + (1 - eps) d), up to one factor
    law = 1 / (0.06 + 0.94 * disparity[1:] / np.percentile(disparity, 98))
    ratio = (z[1:] / law).ravel()
    assert ratio.max() / ratio.min() - 1 < 1e-4  # measured: 3e-7


def test_all_sky_is_survived():
    reading = DepthReading(np.zeros((8, 8), np.float32), np.ones((8, 8), bool), "landscape", 1.0)
    assert (depth_from_reading(reading) == np.float32(SKY_DEPTH)).all()


def test_trainable_starts_at_the_reading(estimator):
    image, _ = meadow(180, 272)
    reading = estimator.read(image)
    out = estimator.trainable(reading, image)().detach().numpy()
    small = cv2.resize(reading.disparity, out.shape[::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(out - small).max() < 1e-5
