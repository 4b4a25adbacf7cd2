"""Scattered values made dense: push-pull pyramids and normalised blurs, on float32 maps."""

import cv2
import numpy as np
from numba import njit, prange

from wzviewer.core.types import BoolArray, FloatArray


def push_pull(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Extends values smoothly to where their weight is zero (Gortler et al. 1996, simplified).

    Args:
        values: (h, w) or (h, w, c) float32, finite everywhere.
        weights: (h, w) float32 in [0, 1]; where 1 the value is kept.

    Returns:
        An array shaped like ``values``; zero if no weight is positive.
    """
    height, width = weights.shape
    if min(height, width) <= 2 or not (weights < 1).any():
        kept = weights if values.ndim == 2 else weights[..., None]
        total = max(float(weights.sum()), 1e-9)
        mean = (values * kept).sum(axis=(0, 1)) / total
        return (kept * values + (1 - kept) * mean).astype(np.float32, copy=False)
    half = ((width + 1) // 2, (height + 1) // 2)
    coarse_weights = cv2.resize(weights, half, interpolation=cv2.INTER_AREA)
    coarse = cv2.resize(_weighted(values, weights), half, interpolation=cv2.INTER_AREA)
    divisor = np.maximum(coarse_weights, 1e-6)
    coarse = (coarse / (divisor if values.ndim == 2 else divisor[..., None])).astype(np.float32, copy=False)
    filled = push_pull(coarse, np.minimum(coarse_weights * 4, 1).astype(np.float32, copy=False))
    wide = np.asarray(cv2.resize(filled, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
    return _blended(values, weights, wide)


def _weighted(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Returns values (h, w) or (h, w, c) times their weights (h, w)."""
    return values * (weights if values.ndim == 2 else weights[..., None])


def _blended(values: FloatArray, weights: FloatArray, wide: FloatArray) -> FloatArray:
    """Mixes values into others, both (h, w) or (h, w, c), by weights (h, w); into the others' own memory."""
    shape = (*weights.shape, -1)
    _mix(np.ascontiguousarray(values, np.float32).reshape(shape), weights, wide.reshape(shape))
    return wide


@njit(cache=True, nogil=True, parallel=True)
def _mix(values: FloatArray, weights: FloatArray, wide: FloatArray) -> None:
    for y in prange(weights.shape[0]):
        for x in range(weights.shape[1]):
            kept = weights[y, x]
            for c in range(wide.shape[2]):
                wide[y, x, c] = kept * values[y, x, c] + (np.float32(1) - kept) * wide[y, x, c]


def masked_blur(values: FloatArray, mask: BoolArray, sigma_px: float) -> FloatArray:
    """Gaussian blur that ignores pixels outside a mask (h, w); push-pull where none is near."""
    weights = mask.astype(np.float32)
    total = blur(weights, sigma_px)
    kept = weights if values.ndim == 2 else weights[..., None]
    near = total if values.ndim == 2 else total[..., None]
    mean = blur((values * kept).astype(np.float32, copy=False), sigma_px) / np.maximum(near, 1e-6)
    return push_pull(mean.astype(np.float32, copy=False), (total > 1e-3).astype(np.float32))


def blur(values: FloatArray, sigma_px: float) -> FloatArray:
    """Gaussian blur with replicated borders; wide ones are made at a lower resolution."""
    factor = int(max(1, sigma_px // 5))
    if factor == 1:
        return cv2.GaussianBlur(values, (0, 0), sigma_px, borderType=cv2.BORDER_REPLICATE).astype(
            np.float32, copy=False
        )
    height, width = values.shape[:2]
    small = (max(1, round(width / factor)), max(1, round(height / factor)))
    low = cv2.resize(values, small, interpolation=cv2.INTER_AREA)
    low = cv2.GaussianBlur(low, (0, 0), sigma_px / factor, borderType=cv2.BORDER_REPLICATE)
    return cv2.resize(low, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32, copy=False)


def disc(radius_px: int) -> "cv2.typing.MatLike":
    """Returns a round structuring element."""
    size = 2 * radius_px + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))


def dilated(mask: BoolArray, radius_px: int) -> BoolArray:
    """Grows a mask (h, w) by a disc."""
    grown = cv2.dilate(mask.astype(np.uint8), disc(radius_px))
    return np.asarray(grown) > 0
