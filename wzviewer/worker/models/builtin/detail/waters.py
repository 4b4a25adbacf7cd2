"""Lakes: blue and calm below the horizon, which colour and roughness alone take for sky or haze."""

import math

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.clusters import Region, split_off

LEAST_SHARE = 0.002  # of the picture; smaller patches are shade
LEAST_Y = 0.5  # the upper shore lies below this part of the height
CALM = 4.5  # grey levels of the finest octave
PLAIN = frozenset({"sky", "plaster", "smooth"})


def with_waters(
    image: FloatArray, labels: ByteArray, regions: tuple[Region, ...], names: tuple[str, ...]
) -> tuple[ByteArray, tuple[Region, ...], tuple[str, ...]]:
    """Returns labels, regions and names, with one region more where the picture has open water.

    Args:
        image: ``(h, w, 3)`` in 0..1.
        labels: ``(h, w)`` u8, index into `regions`.
        regions: statistics per label.
        names: material per label.
    """
    bluish = [
        i
        for i, (region, name) in enumerate(zip(regions, names, strict=True))
        if name in PLAIN and _blue(region)
    ]
    water = _low_pieces(np.isin(labels, bluish))
    if not water.any():
        return labels, regions, names
    parted, more = split_off(image, labels, regions, water)
    return (labels, regions, names) if more[-1].fine > CALM else (parted, more, (*names, "ripple"))


def _blue(region: Region) -> bool:
    hue = math.degrees(math.atan2(region.blue_yellow, region.green_red)) % 360
    return 170 < hue < 300 and math.hypot(region.green_red, region.blue_yellow) > 7


def _low_pieces(mask: BoolArray) -> BoolArray:
    """The pieces of a mask that lie as a whole in the lower half and are no scraps."""
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    low = stats[:, cv2.CC_STAT_TOP] > LEAST_Y * mask.shape[0]
    low &= stats[:, cv2.CC_STAT_AREA] > LEAST_SHARE * mask.size
    low &= stats[:, cv2.CC_STAT_WIDTH] > 1.5 * stats[:, cv2.CC_STAT_HEIGHT]  # seen aslant, as water is
    low[0] = False
    return low[pieces] if count > 1 else np.zeros_like(mask)
