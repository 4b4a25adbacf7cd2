"""Where a level ends: its parent goes on there, which has nothing of what was put in."""

import numpy as np

from wzviewer.core.constants import COVERAGE_FEATHER, FEATHER_MIN_PX
from wzviewer.core.types import FloatArray

MOST_SHARE = 0.08  # of the shorter side: a preview is smaller than its level


def border_px(shape: tuple[int, int]) -> float:
    """Returns how far in from the border of a picture (h, w) its level fades into its parent."""
    shorter = min(shape)
    return max(COVERAGE_FEATHER * shorter, min(FEATHER_MIN_PX, MOST_SHARE * shorter))


def within(shape: tuple[int, int], width: float, uneven: FloatArray | float = 1.0) -> FloatArray:
    """Returns (h, w) 0 where a level fades out, rising smoothly to 1 further in.

    Args:
        shape: (h, w) of the picture.
        width: over which it rises, of the shorter side.
        uneven: (h, w) factor of the distance, about 1.
    """
    h, w = shape
    rows, columns = np.arange(h) + 0.5, np.arange(w) + 0.5
    down, across = np.minimum(rows, h - rows), np.minimum(columns, w - columns)
    away = (np.minimum(down[:, None], across[None, :]) - border_px(shape)) / min(h, w)
    t = np.clip(away * uneven / width, 0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)
