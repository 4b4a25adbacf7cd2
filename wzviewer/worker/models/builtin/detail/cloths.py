"""Cloth: evenly rough from thread to thread, which colour alone takes for skin, leather or a painted wall."""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.clusters import Region, split_off
from wzviewer.worker.models.builtin.detail.measures import (
    area_down,
    dense_rms,
    drawn_not_lettered,
    first_band,
    luma,
    widely_blurred,
)

LEAST_SHARE = 0.004  # of the picture
LEAST_FINE, NOISE_GAIN = 1.1, 4.0
"""In grey levels, and over the photograph's own noise: threads show as 1.3 to 2.3, leather beside them .6."""
MOST_SPREAD = 1.3
"""The next octave over the finest: .9 to 1.15 in cloth, 1.4 to 1.9 in leather."""
LEAST_TONES = 0.5
MOST_FINE = 5.0  # a rug
WINDOW_PX, REACH_PX, MOST_OF = 4.0, 12.0, 0.3
LIKE_CLOTH = frozenset({"skin"})


def with_cloths(
    image: FloatArray, labels: ByteArray, regions: tuple[Region, ...], names: tuple[str, ...]
) -> tuple[ByteArray, tuple[Region, ...], tuple[str, ...]]:
    """Returns labels, regions and names, with one region more where what looked like leather is woven.

    Args:
        image: ``(h, w, 3)`` in 0..1.
        labels: ``(h, w)`` u8, index into `regions`.
        regions: statistics per label.
        names: material per label.
    """
    candidates = np.isin(labels, [i for i, name in enumerate(names) if name in LIKE_CLOTH])
    if candidates.mean() < LEAST_SHARE:
        return labels, regions, names
    calm = min(region.calm for region in regions)
    cloth = _whole_pieces(
        _woven(luma(image) * np.float32(255), max(LEAST_FINE, NOISE_GAIN * calm)) & candidates
    )
    cloth &= candidates
    if cloth.mean() < LEAST_SHARE:
        return labels, regions, names
    return *split_off(image, labels, regions, cloth), (*names, "weave")


def _woven(grey: FloatArray, least_fine: float) -> BoolArray:
    """Where fine roughness is dense, of all tones and no coarser than it is fine."""
    height, width = grey.shape
    half = area_down(grey, max(width // 2, 1), max(height // 2, 1))
    fine = dense_rms(first_band(grey), WINDOW_PX)
    middle = cv2.resize(dense_rms(first_band(half), WINDOW_PX / 2), (width, height))
    rough = (fine > least_fine) & (fine < MOST_FINE) & (middle < MOST_SPREAD * fine)
    found: BoolArray = rough & (drawn_not_lettered(grey) > LEAST_TONES)
    return found


def _whole_pieces(woven: BoolArray) -> BoolArray:
    """Where much of the neighbourhood is woven, less scraps."""
    most = (widely_blurred(woven.astype(np.float32), REACH_PX) > MOST_OF).astype(np.uint8)
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(most, connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] > LEAST_SHARE * most.size
    large[0] = False
    return large[pieces] if count > 1 else np.zeros_like(woven)
