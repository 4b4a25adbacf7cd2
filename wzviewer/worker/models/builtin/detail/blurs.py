"""What was out of focus: it stays so however near one comes, or a blurred meadow is crackled by cells."""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.amplitude import in_focus
from wzviewer.worker.models.builtin.detail.clusters import Region, split_off
from wzviewer.worker.models.builtin.detail.measures import (
    area_down,
    dense_rms,
    first_band,
    luma,
    widely_blurred,
)

LIVES = frozenset({"foliage", "venation", "petal", "floret", "cell", "straw", "bark"})
"""What would grow veins and cells of its own."""
LEAST_SHARE = 0.003  # of the picture
MOST_FINE, NOISE_GAIN = 1.2, 3.0
"""In grey levels, and over the photograph's own noise: more is texture, which no lens shows out of focus."""
MOST_FOCUS = 0.3
WINDOW_PX, REACH_PX = 4.0, 16.0
LEAST_SPREAD = 2.0
"""The third octave over the finest: 1 to 1.7 in what is even, 2.5 to 6 in forms out of focus."""
GAP_PX = 9  # what is narrower lies between sharp things


def with_blurs(
    image: FloatArray, labels: ByteArray, regions: tuple[Region, ...], names: tuple[str, ...]
) -> tuple[ByteArray, tuple[Region, ...], tuple[str, ...]]:
    """Returns labels, regions and names, with one region more where what lives is out of focus.

    Args:
        image: ``(h, w, 3)`` in 0..1.
        labels: ``(h, w)`` u8, index into `regions`.
        regions: statistics per label.
        names: material per label.
    """
    candidates = np.isin(labels, [index for index, name in enumerate(names) if name in LIVES])
    if candidates.mean() < LEAST_SHARE:
        return labels, regions, names
    calm = min(region.calm for region in regions)
    blurs = out_of_focus(luma(image) * np.float32(255), max(MOST_FINE, NOISE_GAIN * calm)) & candidates
    blurs = _large_pieces(blurs)
    if not blurs.any():
        return labels, regions, names
    return *split_off(image, labels, regions, blurs), (*names, "blur")


def out_of_focus(plane: FloatArray, most_fine: float = MOST_FINE) -> BoolArray:
    """Returns ``(h, w)``: where there are forms, but none finer than a lens out of focus leaves.

    Args:
        plane: ``(h, w)`` luma in grey levels.
        most_fine: RMS of the finest octave, in grey levels, above which it is texture.
    """
    height, width = plane.shape
    quarter = area_down(plane, max(width // 4, 1), max(height // 4, 1))
    fine = dense_rms(first_band(plane), WINDOW_PX)
    wide = cv2.resize(dense_rms(first_band(quarter), WINDOW_PX / 2), (width, height))
    soft = ((fine < most_fine) & (in_focus(plane) < MOST_FOCUS)).astype(np.float32)
    spread = widely_blurred(wide * soft, REACH_PX) / (
        widely_blurred((fine + np.float32(0.3)) * soft, REACH_PX) + np.float32(1e-3)
    )
    found = (soft > 0) & (spread > LEAST_SPREAD)
    opened = cv2.morphologyEx(found.astype(np.uint8), cv2.MORPH_OPEN, np.ones((GAP_PX, GAP_PX), np.uint8))
    return np.asarray(opened > 0)


def _large_pieces(mask: BoolArray) -> BoolArray:
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] > LEAST_SHARE * mask.size
    large[0] = False
    return large[pieces] if count > 1 else np.zeros_like(mask)
