"""How strong the unseen octaves may be.

Fitted on photographs: energy of a new octave = last octave x (last / previous)^0.5, that is, for the three
octaves of an enlargement by eight, sigma = 1.43 b1^1.5 b2^-0.62, where b1 and b2 are the RMS of the finest
two octaves that are seen.  Sparse edges are not counted: letters and wires call for no texture beside them.
"""

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import (
    blurred,
    dense_rms,
    first_band,
    local_rms,
    orientation,
    ramp,
    stretched,
)

LAW_GAIN = 1.3 * 1.43  # 1.0 matches the statistics of photographs, 1.3 looks better
CEILING = 15.0
"""No detail is stronger than this RMS, in grey levels."""
PROMPTED_FLOOR = 0.05
"""Least contrast, as a share of the luminance, where a prompt names the material."""


def lawful_sigma(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the RMS in grey levels that the law gives to the detail of each coarse pixel.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
    """
    height, width = plane.shape
    half = cv2.resize(plane, (max(width // 2, 1), max(height // 2, 1)), interpolation=cv2.INTER_AREA)
    fine = texture_evidence(plane)
    wide = stretched(local_rms(first_band(half), 3.0), width, height)
    return LAW_GAIN * fine**1.5 * (wide + np.float32(0.3)) ** np.float32(-0.62)


def texture_evidence(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the RMS of the finest octave as far as it is texture, in grey levels.

    The least RMS of the neighbourhood is the measure, or a strong edge would leak grain to both its sides.
    """
    fine = dense_rms(first_band(plane), 3.0)
    calm = cv2.erode(fine, np.ones((11, 11), np.uint8))
    return np.minimum(fine, np.float32(1.7) * blurred(calm, 3.0) + np.float32(0.2))


def edge_damping(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0.35..1: detail steps back from strong contours."""
    strength = orientation(plane, 1.0, 1.5).strength
    damping: FloatArray = np.float32(0.35) + np.float32(0.65) / (1 + np.square(strength / np.float32(14)))
    return damping


def tone_damping(plane: FloatArray) -> FloatArray:
    """Returns 0.2..1: little detail in the black and in the burnt-out, where it could only be clipped."""
    return ramp(plane, 0, 40).clip(0.25, 1) * ramp(262 - plane, 0, 40).clip(0.2, 1)


def sigma_map(plane: FloatArray, gain: FloatArray, floor: FloatArray, truthful: bool) -> FloatArray:
    """Returns the RMS of the detail, ``(h, w)`` in grey levels, at the observation's size.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
        gain: ``(h, w)`` factor of the material on the law.
        floor: ``(h, w)`` least contrast of the material, as a share of the luminance.
        truthful: the observation is a photograph: where it shows no texture, the floor does not apply.
    """
    floor_sigma = floor * np.maximum(plane, 24)
    if truthful:
        floor_sigma *= np.float32(0.25) + np.float32(0.75) * ramp(texture_evidence(plane), 0.8, 2.0)
    sigma = np.sqrt(np.square(gain * lawful_sigma(plane)) + np.square(floor_sigma))
    return np.minimum(sigma, CEILING) * tone_damping(plane) * edge_damping(plane)
