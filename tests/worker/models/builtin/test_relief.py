import cv2
import numpy as np

from wzviewer.worker.models.builtin.depth.refine import segment
from wzviewer.worker.models.builtin.relief import (
    border_ramp,
    limit_slope,
    low_pass,
    relief_from_shading,
)

H, W = 360, 544


def gravel(seed=0):
    rng = np.random.default_rng(seed)
    total = np.zeros((H, W), np.float32)
    for size in (3, 6, 12, 24):
        grid = rng.random((H // size + 2, W // size + 2)).astype(np.float32)
        total += cv2.resize(grid, (W, H), interpolation=cv2.INTER_CUBIC) * 0.25
    return np.repeat(np.clip(0.5 + 1.6 * (total - 0.5), 0, 1)[..., None], 3, 2).astype(np.float32)


def spread(v):
    return float(np.subtract(*np.percentile(v, (95, 5))))


def test_amplitude_is_the_share_of_the_width_and_proportional():
    image = gravel()
    labels = segment(image)
    three, six = (relief_from_shading(image, labels, amplitude_share=a) for a in (0.02, 0.04))
    inner = (slice(80, -80), slice(80, -80))
    assert 0.7 < spread(three[inner]) / (0.02 * W) < 1.3  # measured: 0.96
    assert 1.6 < spread(six[inner]) / spread(three[inner]) < 2.1  # measured: 1.9 (slopes are limited)


def test_dark_is_deep():
    image = gravel()
    h = relief_from_shading(image, np.zeros((H, W), np.int32))
    level = image[..., 0] - cv2.GaussianBlur(image[..., 0], (0, 0), 30)
    inner = (slice(80, -80), slice(80, -80))
    assert np.corrcoef(h[inner].ravel(), level[inner].ravel())[0, 1] > 0.5  # measured: 0.8


def test_blur_flat_color_and_sky_get_none():
    image = gravel()
    labels = np.zeros((H, W), np.int32)
    blurred = cv2.GaussianBlur(image, (0, 0), 12)
    assert np.abs(relief_from_shading(blurred, labels)).max() < 0.05 * spread(
        relief_from_shading(image, labels)
    )
    assert np.abs(relief_from_shading(np.full_like(image, 0.5), labels)).max() == 0
    sky = np.zeros((H, W), bool)
    sky[: H // 2] = True
    assert np.abs(relief_from_shading(image, labels, sky=sky)[: H // 2 - 12]).max() < 0.5  # measured: 0.1 px


def test_it_ends_at_the_border_and_is_invisible_to_the_parent():
    image = gravel()
    h = relief_from_shading(image, segment(image))
    edge = np.concatenate([h[0], h[-1], h[:, 0], h[:, -1]])
    assert not edge.any()
    assert np.abs(low_pass(h, W / 8)).max() < 0.12 * spread(h)  # measured: 0.07, in the fading border
    assert border_ramp(H, W)[H // 2, W // 2] == 1


def test_slopes_are_limited():
    cliff = np.zeros((120, 160), np.float32)
    cliff[:, 80:] = 12
    slope = np.abs(np.diff(limit_slope(cliff), axis=1)).max()
    assert slope < 2.5  # measured: 1.6; before: 12


def test_texture_height_is_heard():
    image = gravel()
    labels = np.zeros((H, W), np.int32)
    waves = np.repeat(np.sin(np.arange(W) / 4, dtype=np.float32)[None], H, 0)
    change = relief_from_shading(image, labels, waves) - relief_from_shading(image, labels)
    inner = (slice(80, -80), slice(80, -80))
    assert np.corrcoef(change[inner].ravel(), waves[inner].ravel())[0, 1] > 0.5  # measured: 0.9
