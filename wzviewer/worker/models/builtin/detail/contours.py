"""Contours of metal and beyond the photograph: what is murky amid reflections is none the less cut.

A contour that the level before drew three coarse pixels wide is as wide here; a picture of such is a murk.
What the coarser picture could have missed is room: within it faint contours become as steep as a coarse pixel
is, by shock filtering (Osher and Rudin 1990; Alvarez and Mazorra 1994).  Strong ones the base has made steep
already; more would contradict what was there.
"""

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.measures import (
    area_down,
    blurred,
    enlarged,
    luma,
    ramp,
    stretched,
)

CUT = frozenset({"metal"})
"""What has cut outlines even where the photograph is murky."""
SOFT = frozenset({"sky", "blur", "air", "haze", "wet", "tear"})
"""What has none, or a lens made them soft."""
CONTOUR_RMS = 1.3
"""In grey levels, 45.9 dB: what of contours the coarser picture may have missed."""
FAINT, FADE = 70.0, 70.0
"""Range of grey levels over 5 px of the observation: below the first contours are faint, and until when."""
MOST_STEP = 7.0  # grey levels, about the most that one coarse pixel changes by
FINER, STEPS, STEP = 2, 12, 0.35
SMOOTH_PX, AFTER_PX = 1.8, 0.5
BASE_STEPS, BASE_SHARE = 11, 0.9
"""At half the size of the new image; a little softness stays, or metal were cut out of paper."""
CERTAIN = 0.6
"""In grey levels per px^2, of the second derivative across a contour: below it nothing is a contour."""


def with_steeper(base: FloatArray, observation: FloatArray, share: FloatArray) -> FloatArray:
    """Returns the crisp base ``(H, W, 3)`` in grey levels with its faint contours steeper.

    Args:
        base: ``(H, W, 3)`` in grey levels.
        observation: ``(h, w, 3)`` in grey levels.
        share: ``(H, W)`` in 0..1, where they may be.
    """
    height, width = share.shape
    half = area_down(base, max(width // 2, 1), max(height // 2, 1))
    added = (_shocked(half, BASE_STEPS) - half) * np.float32(BASE_SHARE)
    added *= stretched(_faint(luma(observation)), half.shape[1], half.shape[0])[..., None]
    seen = area_down(added, observation.shape[1], observation.shape[0])
    added -= stretched(seen, half.shape[1], half.shape[0])  # what is seen stays as it is
    return base + share[..., None] * stretched(added, width, height)


def supposed(observation: FloatArray, labels: ByteArray, names: tuple[str, ...]) -> FloatArray:
    """Returns what an invented observation ``(h, w, 3)`` should have been, in grey levels.

    Args:
        observation: ``(h, w, 3)`` in grey levels.
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
    """
    sharp = np.array([name not in SOFT for name in names], np.float32)[labels]
    return with_contours(observation, sharp) if sharp.any() else observation


def with_contours(observation: FloatArray, share: FloatArray) -> FloatArray:
    """Returns the observation ``(h, w, 3)`` with its faint contours steeper, in grey levels.

    Args:
        observation: ``(h, w, 3)`` in grey levels.
        share: ``(h, w)`` in 0..1, where they may be; not where a lens made them soft.
    """
    height, width = observation.shape[:2]
    fine = enlarged(observation, FINER * width, FINER * height)
    added = area_down(_shocked(fine, STEPS) - fine, width, height)
    least = np.abs(added).max(2) / np.float32(MOST_STEP)
    added *= (share * _faint(luma(observation)) / (1 + least))[..., None]
    rms = float(np.sqrt(np.mean(np.square(added))))
    return np.clip(observation + added * np.float32(min(1.0, CONTOUR_RMS / max(rms, 1e-3))), 0, 255)


def _faint(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: where there is no strong contour; ``plane`` is luma in grey levels."""
    box = np.ones((5, 5), np.uint8)
    span = cv2.dilate(plane, box) - cv2.erode(plane, box)
    return blurred(1 - ramp(span, FAINT, FADE), 1.0)


def _shocked(image: FloatArray, steps: int) -> FloatArray:
    """Returns the image in which light and dark meet at their contours; ``(h, w, 3)`` in grey levels."""
    box = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    result = image
    for _ in range(steps):
        side = np.float32(STEP) * np.tanh(_across(luma(result)) / np.float32(CERTAIN))[..., None]
        result = result + np.maximum(-side, 0) * (cv2.dilate(result, box) - result)
        result = result - np.maximum(side, 0) * (result - cv2.erode(result, box))
    return blurred(result, AFTER_PX)


def _across(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the second derivative across the contours, positive on their dark side."""
    smooth = blurred(plane, SMOOTH_PX)
    x, y, xx, yy, xy = (
        cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=scale)
        for order, scale in (((1, 0), 0.125), ((0, 1), 0.125), ((2, 0), 0.25), ((0, 2), 0.25), ((1, 1), 0.25))
    )
    total: FloatArray = (x * x * xx + 2 * x * y * xy + y * y * yy) / (x * x + y * y + np.float32(0.02))
    return total
