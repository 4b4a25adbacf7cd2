"""Layers of a depth map: what an occlusion step is, as against a steep slope, and what it separates."""

import cv2
import numpy as np
from scipy import ndimage

from wzviewer.core.types import BoolArray, FloatArray, IntArray

STEP_PX, STEP_SHARE, STEP_SLOPE = 4.0, 0.03, 1.5  # a step is larger than 4 px and 3 % (or 56 degrees)
SMALLEST_LAYER_PX = 60  # at the working size; smaller islands join the nearest layer


def step_mask(target: FloatArray, shrink: float, focal_px: float) -> BoolArray:
    """Where a reduced target has an occlusion step, as against a steep slope.

    Args:
        target: (h, w) parallax, native px, finite, `shrink` times smaller than the image.
        shrink: image pixels per pixel here.
        focal_px: of the level.

    Returns:
        (h, w): within 16 image px the target changes by more than 4 px, more than 3 % of its inverse
        depth (or more than 1.5 px a px), and most of the change in thrice the distance is here.
    """
    near_px = 2 * max(round(16 / shrink / 2), 1) + 1
    smooth = cv2.medianBlur(target, 5) if min(target.shape) > 5 else target
    here = _range(smooth, near_px)
    around = _range(smooth, 3 * near_px)
    least = np.minimum(STEP_SHARE * np.abs(focal_px + smooth), STEP_SLOPE * 16)
    return np.asarray((here > np.maximum(least, STEP_PX)) & (here > 0.6 * around), bool)


def _range(v: FloatArray, size_px: int) -> FloatArray:
    kernel = np.ones((size_px, size_px), np.uint8)
    return cv2.dilate(v, kernel) - cv2.erode(v, kernel)


def nearest_fill(v: FloatArray, known: BoolArray) -> FloatArray:
    """Fills unknown pixels with the nearest known value; 0 if there is none."""
    if known.all():
        return v
    if not known.any():
        return np.zeros_like(v)
    rows, columns = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return v[rows, columns]


def cut_along(labels: IntArray, step: BoolArray) -> IntArray:
    """Cuts segments along the target's steps, so that each has one offset."""
    if not step.any():
        return np.unique(labels, return_inverse=True)[1].reshape(labels.shape).astype(np.int32)
    _, layers, stats, _ = cv2.connectedComponentsWithStats((~step).astype(np.uint8), connectivity=4)
    sure = ~step & (stats[:, cv2.CC_STAT_AREA] >= SMALLEST_LAYER_PX)[layers]
    layers = nearest_fill(layers.astype(np.float32), sure).astype(np.int64)
    pairs = labels.astype(np.int64) * (int(layers.max()) + 1) + layers
    return np.unique(pairs, return_inverse=True)[1].reshape(labels.shape).astype(np.int32)
