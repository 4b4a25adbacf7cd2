"""Small pictures of the levels."""

import numpy as np
import pytest

from wzviewer.app.thumbnails import shrunk


@pytest.mark.parametrize(
    ("size", "limit_px"), [((37, 50), 10), ((50, 37), 25), ((9, 12), 100), ((720, 1088), 384)]
)
def test_a_thumbnail_is_the_mean_over_whole_blocks(size, limit_px):
    image = np.random.default_rng(1).integers(0, 256, (*size, 3), dtype=np.uint8)
    factor = max(max(size) // limit_px, 1)
    height, width = size[0] // factor, size[1] // factor
    blocks = image[: height * factor, : width * factor].reshape(height, factor, width, factor, 3)
    small = shrunk(image, limit_px)
    assert small.shape == (height, width, 3)
    assert max(small.shape) >= min(limit_px, max(size))
    assert np.abs(small - blocks.mean(axis=(1, 3))).max() <= 0.5  # rounding, and nothing else
