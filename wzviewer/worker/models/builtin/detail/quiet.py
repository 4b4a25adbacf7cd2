"""A photograph without its noise: enlarged, a camera's grain is a canvas and a JPEG's ringing a mosaic.

What is taken out is no stronger than what the photograph has where it shows nothing; the new picture gets it
back as fine as a camera would have it there (`overlay.film_grain`).  Non-local means (Buades, Coll and Morel
2005): a pixel becomes the mean of those nearby whose neighbourhoods differ from its own by noise alone.
"""

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.amplitude import NATURAL
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.measures import blurred, luma
from wzviewer.worker.models.builtin.detail.overlay import GRAIN_GAIN, calmest

MOST_CALM = 1.2
"""RMS of the finest octave in the calmest region, in grey levels: more is strokes or stones, not noise."""
LEAST_NOISE_RMS, MOST_NOISE_RMS, NOISE_GAIN = 0.4, 1.8, 1.2
BLOTCH_RMS = 2.5
"""Of the colours, in grey levels: skies measure .5 to 1, and a dim one 2.4 to 4."""
REACH_PX, NEAR_PX, PATCH_PX = 5, 3.0, 1.0
SOFTNESS = 4.0
"""Of the difference of two noisy pixels: over as much likeness fades; over less, clouds have steps."""
CHANNELS = np.array([0.6, 1.2, 0.6], np.float32)


def noise_rms(context: Context) -> float:
    """Returns the noise of the photograph in grey levels, 0 if nothing in it is calm enough to tell."""
    calm = calmest(context)
    if not context.regions or calm > MOST_CALM:
        return 0.0
    return NOISE_GAIN * min(max(GRAIN_GAIN * calm, LEAST_NOISE_RMS), MOST_NOISE_RMS)


def without_noise(
    image: FloatArray, labels: ByteArray, names: tuple[str, ...], context: Context
) -> FloatArray:
    """Returns ``(h, w, 3)`` grey levels without the photograph's noise; what grew keeps all of its light.

    Leaves, stone or fur may be as faint as noise, in the shade or afar, and there noise is not seen.

    Args:
        image: ``(h, w, 3)`` in grey levels.
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
        context: of the photograph.
    """
    image, noise = without_blotches(image), noise_rms(context)
    plain = np.array([name not in NATURAL for name in names], np.float32)[labels]
    if noise == 0 or not plain.any():
        return image
    share = blurred(plain, NEAR_PX)[..., None]
    return image + share * (quieted(image, noise) - image)


def without_blotches(image: FloatArray) -> FloatArray:
    """Returns ``(h, w, 3)`` grey levels of the same light, with calmer colours.

    A camera's colours are guessed from every second pixel, and compressed more than its light: hair had blue
    and green fringes, leaves had freckles.
    """
    light = luma(image)[..., None]
    return light + quieted(image - light, BLOTCH_RMS)


def quieted(image: FloatArray, noise: float) -> FloatArray:
    """Returns ``(h, w, 3)`` grey levels without noise of the given RMS; contours and texture stay.

    Args:
        image: ``(h, w, 3)`` in grey levels.
        noise: RMS in grey levels, above 0.
    """
    height, width = image.shape[:2]
    padded = cv2.copyMakeBorder(image, *(REACH_PX,) * 4, cv2.BORDER_REFLECT_101)
    expected = np.float32(2 * noise * noise * CHANNELS.sum())
    total, weights = np.zeros_like(image), np.zeros((height, width), np.float32)
    for dy in range(-REACH_PX, REACH_PX + 1):
        for dx in range(-REACH_PX, REACH_PX + 1):
            other = padded[REACH_PX + dy :, REACH_PX + dx :][:height, :width]
            weight = _likeness(image, other, expected) * np.float32(
                np.exp(-0.5 * (dx**2 + dy**2) / NEAR_PX**2)
            )
            total += weight[..., None] * other
            weights += weight
    return total / weights[..., None]


def _likeness(image: FloatArray, other: FloatArray, expected: np.float32) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: how far neighbourhoods differ by noise alone."""
    apart = cv2.GaussianBlur(np.square(image - other) @ CHANNELS, (0, 0), PATCH_PX)
    likeness: FloatArray = np.exp(-apart / (np.float32(SOFTNESS) * expected))
    return likeness
