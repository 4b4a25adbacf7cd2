"""Consistency: the new picture, shrunk, is what was there before.

The network base learnt to be consistent, and detail is laid on without what the observation could see of it,
so little is left to do.  `projected` is the last word: it moves every coarse pixel's block by the gain that
makes its mean right and keeps every value inside 0..255, which always exists where the enlargement is a whole
number.
"""

import math

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import area_down, enlarged

REQUIRED_DB = 40.0
"""The promise of the product: PSNR between the shrunk new image and the observation, every level."""
TARGET_DB = 43.0
"""What is worked towards: the observation is a rendering, itself some 44 dB from the parent's image, to which
the promise is to hold as well."""

TURNS, MARGIN_DB = 8, 0.2
"""Clipping and the enlargement's blur leave a little of every turn undone."""


def psnr_db(a: FloatArray, b: FloatArray, peak: float = 255.0) -> float:
    """Returns the peak signal-to-noise ratio in dB, at most 120."""
    error = float(np.mean(np.square(a.astype(np.float64) - b)))
    return 120.0 if error <= peak * peak * 1e-12 else 10 * math.log10(peak * peak / error)


def consistency_db(image: FloatArray, observation: FloatArray, peak: float = 255.0) -> float:
    """Returns the PSNR of the image, shrunk by area to the observation's size, against it."""
    height, width = observation.shape[:2]
    return psnr_db(area_down(image, width, height), observation, peak)


def projected(image: FloatArray, observation: FloatArray, target_db: float = TARGET_DB) -> FloatArray:
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


def brought_near(image: FloatArray, observation: FloatArray, least_db: float) -> FloatArray:
    """Returns the image, inside 0..255, moved no farther than to shrink to the observation well enough.

    What is left out of it on purpose, such as noise, is not laid on it again.

    Args:
        image: ``(H, W, 3)`` grey levels.
        observation: ``(h, w, 3)`` grey levels.
        least_db: what is enough.
    """
    height, width = observation.shape[:2]
    size = (image.shape[1], image.shape[0])
    for _ in range(TURNS):
        residual = observation - area_down(image, width, height)
        short_db = least_db - psnr_db(residual, np.zeros_like(residual))
        if short_db <= 0:
            return image
        share = np.float32(1 - 10 ** (-(short_db + MARGIN_DB) / 20))
        image = np.clip(image + share * enlarged(residual, *size), 0, 255)
    return projected(image, observation, least_db)


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
