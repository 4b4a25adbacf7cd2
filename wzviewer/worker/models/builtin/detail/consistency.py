"""Consistency: the new picture, shrunk, is what was there before.

Two tools.  `precompensated` changes the *input* of the sharpener until its output shrinks back to the
observation; adding the residual to the output instead gives rims that the next level makes eight times wider.
`projected` is the last word: it moves every coarse pixel's block by the gain that makes its mean right and
keeps every value inside 0..255, which always exists where the enlargement is a whole number.
"""

import math

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.crisp import BaseUpscaler
from wzviewer.worker.models.builtin.detail.measures import (
    area_down,
    enlarged,
    luma,
    orientation,
    ramp,
    stretched,
)

REQUIRED_DB = 40.0
"""The promise of the product: PSNR between the shrunk new image and the observation, every level."""


def psnr_db(a: FloatArray, b: FloatArray, peak: float = 255.0) -> float:
    """Returns the peak signal-to-noise ratio in dB, at most 120."""
    error = float(np.mean(np.square(a.astype(np.float64) - b)))
    return 120.0 if error <= peak * peak * 1e-12 else 10 * math.log10(peak * peak / error)


def consistency_db(image: FloatArray, observation: FloatArray, peak: float = 255.0) -> float:
    """Returns the PSNR of the image, shrunk by area to the observation's size, against it."""
    height, width = observation.shape[:2]
    return psnr_db(area_down(image, width, height), observation, peak)


def precompensated(
    base: BaseUpscaler, observation: FloatArray, doublings: int, level: int, passes: int
) -> FloatArray:
    """Returns an input for `base` whose output shrinks back to the observation better.

    Runs the base at one doubling less than asked, at a quarter of the cost; the correction carries over.
    """
    height, width = observation.shape[:2]
    box = np.ones((3, 3), np.uint8)
    lowest, highest = cv2.erode(observation, box) - 3, cv2.dilate(observation, box) + 3
    trial, best, best_db = observation, observation, 0.0
    for index in range(passes + 1):
        residual = observation - area_down(base(trial, max(doublings - 1, 1), level), width, height)
        db = psnr_db(residual, np.zeros_like(residual))
        if db > best_db:
            best, best_db = trial, db
        if db > 43 or index == passes:
            break
        trial = np.clip(trial + 0.9 * residual, lowest, highest)
    return best


def reconciled(crisp: FloatArray, observation: FloatArray, target_db: float = 40.6) -> FloatArray:
    """Returns the crisp picture, softened where it contradicts the observation, so that `target_db` is met.

    The soft picture is the bicubic one; its share is a function of the local error with one tolerance for the
    whole image, found by bisection.  Chaotic areas keep most of the crispness and take the residual instead:
    nobody can see an overshoot there.
    """
    height, width = observation.shape[:2]
    soft = _softly_enlarged(observation, crisp.shape[1], crisp.shape[0])
    soft_error = observation - area_down(soft, width, height)
    crisp_error = observation - area_down(crisp, width, height)
    share = _crisp_share(crisp_error, soft_error, target_db)
    field = orientation(luma(observation), 1.0, 2.0)
    chaos = (1 - ramp(field.coherence, 0.4, 0.2)) * ramp(field.strength, 1.0, 2.0)
    share = np.maximum(share, 0.8 * chaos)
    fine = stretched(share, crisp.shape[1], crisp.shape[0])[..., None]
    mixed = soft + fine * (crisp - soft)
    residual = (observation - area_down(mixed, width, height)) * chaos[..., None]
    return mixed + stretched(residual, crisp.shape[1], crisp.shape[0])


def _softly_enlarged(observation: FloatArray, width: int, height: int) -> FloatArray:
    """Returns the bicubic picture after two back-projections, with a bound on its overshoot."""
    box, rows, columns = np.ones((3, 3), np.uint8), *observation.shape[:2]
    soft = enlarged(observation, width, height)
    for _ in range(2):
        soft += enlarged(observation - area_down(soft, columns, rows), width, height)
    lowest = stretched(cv2.erode(observation, box), width, height) - 6
    return np.clip(soft, lowest, stretched(cv2.dilate(observation, box), width, height) + 6)


def _crisp_share(crisp_error: FloatArray, soft_error: FloatArray, target_db: float) -> FloatArray:
    size = cv2.blur(np.abs(crisp_error).max(axis=2), (3, 3))
    allowed = 255.0**2 / 10 ** (target_db / 10)
    low, high = 0.0, 64.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        share = np.clip(middle / (size + 1e-3), 0, 1)[..., None]
        error = float(np.mean(np.square(soft_error + share * (crisp_error - soft_error))))
        low, high = (middle, high) if error <= allowed else (low, middle)
    return np.clip(np.float32(low) / (size + np.float32(1e-3)), 0, 1)


def projected(image: FloatArray, observation: FloatArray, target_db: float = 40.1) -> FloatArray:
    """Returns the nearest-looking image, inside 0..255, that shrinks to the observation.

    First smooth corrections, which nobody sees; if they do not suffice, the exact one per block.  At a whole
    enlargement the result always reaches `REQUIRED_DB`.  At a broken one two coarse pixels share a fine
    pixel, so black beside white may have no solution; then the best found is returned.
    """
    height, width = observation.shape[:2]
    size = (image.shape[1], image.shape[0])
    result = np.clip(image, 0, 255)
    for _ in range(12):
        residual = observation - area_down(result, width, height)
        if psnr_db(residual, np.zeros_like(residual)) >= target_db:
            return result
        result = np.clip(result + enlarged(residual, *size), 0, 255)
    for _ in range(24):
        if consistency_db(result, observation) >= target_db:
            break
        result = _with_block_means(result, observation)
    return result


def _with_block_means(image: FloatArray, observation: FloatArray) -> FloatArray:
    """Moves every block towards white or black by the share that makes its mean the observed one.

    With mean m, wanted M > m: x + (255 - x) (M - m) / (255 - m); with M < m: x M / m.  Both are exact and
    stay inside 0..255.
    """
    height, width = observation.shape[:2]
    size = (image.shape[1], image.shape[0])
    mean = area_down(image, width, height)
    wanted = np.clip(observation, 0, 255)
    lift = np.clip((wanted - mean) / np.maximum(255 - mean, 1e-3), 0, 1)
    fade = np.clip((mean - wanted) / np.maximum(mean, 1e-3), 0, 1)
    lift = cv2.resize(lift, size, interpolation=cv2.INTER_NEAREST)
    fade = cv2.resize(fade, size, interpolation=cv2.INTER_NEAREST)
    return np.clip(image + (255 - image) * lift - image * fade, 0, 255)
