"""Folds of leather: narrow, dark and drawn out, which roughness and direction alone take for grained wood."""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray

HIDES = frozenset({"skin", "weave"})
MAY_BE_FOLD = frozenset({"fibre", "metal"})
MOST_WIDTH, RING_PX = 0.045, 9
"""Of the picture's width; and how far around a piece is looked."""
LEAST_AROUND = 0.5
"""From this share of its surroundings on a narrow piece is of the hide that it lies in."""
LEAST_PX = 30


def with_folds(labels: ByteArray, names: tuple[str, ...]) -> ByteArray:
    """Returns labels in which narrow pieces of what looks like wood or iron amid leather are leather.

    Args:
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
    """
    hide, fold = (np.array([name in known for name in names])[labels] for known in (HIDES, MAY_BE_FOLD))
    leather = next((index for index, name in enumerate(names) if name == "skin"), None)
    if leather is None or not fold.any():
        return labels
    return np.where(_narrow_amid(fold, hide), leather, labels).astype(np.uint8)


def _narrow_amid(fold: BoolArray, hide: BoolArray) -> BoolArray:
    """The pieces of a mask that are narrow and lie mostly amid another."""
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(fold.astype(np.uint8), connectivity=4)
    inside = cv2.distanceTransform(fold.astype(np.uint8), cv2.DIST_L2, 3)
    radius = np.zeros(count, np.float32)
    np.maximum.at(radius, pieces[fold], inside[fold])
    narrow = (2 * radius < MOST_WIDTH * fold.shape[1]) & (stats[:, cv2.CC_STAT_AREA] >= LEAST_PX)
    narrow[0] = False
    for piece in np.flatnonzero(narrow):
        x, y, width, height, _ = stats[piece]
        window = np.s_[max(y - RING_PX, 0) : y + height + RING_PX, max(x - RING_PX, 0) : x + width + RING_PX]
        own = (pieces[window] == piece).astype(np.uint8)
        ring = (cv2.dilate(own, np.ones((2 * RING_PX + 1,) * 2, np.uint8)) > 0) & (own == 0)
        narrow[piece] = ring.any() and hide[window][ring].mean() > LEAST_AROUND
    found: BoolArray = narrow[pieces]
    return found
