"""Detail is laid on the crisp base: as light, as paint, as hue; contours roughen; camera grain is last."""

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.measures import area_down, blurred, luma, stretched

LEAST_GRAIN_RMS, MOST_GRAIN_RMS, GRAIN_GAIN = 0.2, 1.8, 2.0
"""In grey levels, at level 1 only; photographs at 2K measure 0.4 to 2.0 in their skies, about twice of what
is left of it at the working size (0.26 to 0.83)."""
EVEN = frozenset({"sky", "smooth"})
LEAST_LIGHT, MOST_STOPS = 6.0, 1.6
"""In grey levels, and as a natural logarithm: no ridge in a shadow is more than five times as light as it."""


def with_detail(
    base: FloatArray,
    detail: FloatArray,
    observation: FloatArray,
    hue_per_level: FloatArray,
    light_share: FloatArray | float = 0.5,
) -> FloatArray:
    """Returns base plus detail, in grey levels: partly as light, partly as paint, a little as hue.

    The light keeps the ratio of the channels, hence the colour.  What the observation could see of the
    detail is taken out of it again.

    Args:
        base: ``(H, W, 3)`` in grey levels.
        detail: ``(H, W)`` in grey levels.
        observation: ``(h, w, 3)`` in grey levels.
        hue_per_level: ``(3,)`` of the light that a grey level of detail shifts the colour by.
        light_share: ``(H, W)`` or one for all; what is light of a leaf is green, not white.
    """
    unseen = _unseen(detail, observation)
    hue = _unseen(np.roll(blurred(detail, 1.2), (113, 71), (0, 1)), observation)
    light = light_share * unseen / np.maximum(luma(base), 24)
    paint = (1 - light_share) * unseen
    return base * (1 + light[..., None]) + paint[..., None] + hue[..., None] * hue_per_level


def multiplied(detail: FloatArray, plane: FloatArray) -> FloatArray:
    """Returns detail ``(H, W)`` as factors on the light: in a shadow ridges shine, nothing is below black.

    Where detail is weak for the light ``plane``, ``(H, W)`` in grey levels, it stays what it is.
    """
    light = np.maximum(plane, np.float32(LEAST_LIGHT))
    return light * np.expm1(np.minimum(detail / light, np.float32(MOST_STOPS)))


def _unseen(detail: FloatArray, observation: FloatArray) -> FloatArray:
    height, width = observation.shape[:2]
    return detail - stretched(area_down(detail, width, height), detail.shape[1], detail.shape[0])


def grain_rms(context: Context) -> FloatArray:
    """Returns ``(n,)`` the photograph's noise in grey levels per region; the new picture has it, too.

    What is even shows its own, because there is nothing else in it; the rest has that of the calmest region.
    """
    calmest = min((region.calm for region in context.regions if region.share > 0.03), default=0.0)
    calm = [
        region.calm if name in EVEN and region.share > 0.03 else calmest
        for region, name in zip(context.regions, context.materials, strict=True)
    ]
    return np.clip(np.float32(GRAIN_GAIN) * np.array(calm, np.float32), LEAST_GRAIN_RMS, MOST_GRAIN_RMS)


def film_grain(shape: tuple[int, ...], seeds: tuple[int, ...]) -> FloatArray:
    """Returns ``(H, W)`` of unit RMS: a camera's noise, or a sky would look like plastic."""
    rng = np.random.default_rng([*seeds, 7])
    grain = blurred(rng.standard_normal(shape, np.float32), 0.5)
    return grain / (grain.std() + np.float32(1e-6))


def roughened(base: FloatArray, texture: FloatArray, roughness_px: FloatArray) -> FloatArray:
    """Returns the base with its contours displaced by the texture, so that a leafy outline is leafy.

    Args:
        base: ``(H, W, 3)`` grey levels.
        texture: ``(H, W)`` of unit RMS.
        roughness_px: ``(H, W)`` RMS displacement.
    """
    if roughness_px.max() < 0.1:
        return base
    height, width = texture.shape
    bumps = blurred(texture, 2.2) + 0.4 * blurred(texture, 1.1)
    bumps /= bumps.std() + np.float32(1e-6)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    map_x = x + roughness_px * np.roll(bumps, (37, 61), (0, 1))
    map_y = y + roughness_px * np.roll(bumps, (-53, 29), (0, 1))
    return cv2.remap(base, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
