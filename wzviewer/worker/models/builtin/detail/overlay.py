"""Detail is laid on the crisp base: as light, as paint, as hue; contours roughen; camera grain is last."""

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.measures import area_down, blurred, enlarged, luma, stretched
from wzviewer.worker.models.builtin.detail.tint import tinted

LEAST_GRAIN_RMS, MOST_GRAIN_RMS, GRAIN_GAIN = 0.2, 1.8, 2.0
"""In grey levels, at level 1 only; photographs at 2K measure 0.4 to 2.0 in their skies, about twice of what
is left of it at the working size (0.26 to 0.83)."""
LOUDEST = 1.5
"""Of the calmest region's: what is even and louder has clouds or folds in it, too."""
WORKING_PX, LEAST_PX = 1088, 256
"""Long side of that size; a smaller photograph was shrunk more, and more of its noise is gone: of a castle's
1.75 at 2040 px there are .98 at 1088 and .42 at 255.  Even smaller ones count as of the second."""
GRAIN_PX, CLUMPS_PX, CLUMPED = 0.5, 2.4, 0.65
"""Deviations of grains and of clumps of them, and the clumps' share: noise of a camera is correlated by .37
to .86 from pixel to pixel (eight skies and walls), and still by .1 to .45 over five."""
GRAIN_OF_TONES = ((0, 0.35), (20, 0.7), (60, 1.0), (130, 1.0), (200, 0.62), (255, 0.35))
"""Grey level and share; skies of 120 to 180 measure 2.0, of 180 to 243 1.2 to 1.3."""
PHOTOGRAPHED_HUE = np.array([0.3, -0.08, -0.25], np.float32)
"""How far a grey level of detail shifts the colour of a photograph: warm to cool, hardly any luma."""
WHITE = 254.0
MISSED_RMS = 1.1
"""In grey levels, 47.3 dB: so much of the forms of an invention the coarser picture may have missed.

Without it forms end where a coarse pixel does, and every level is a carpet of one mesh."""
MISSED_PX = 10.0  # of the observation: larger forms would be tones of whole places
DEEP_LIGHT = 0.9
"""Share of the detail beyond the photograph that is light, not paint: paint would grey what is colourful."""
EVEN = frozenset({"sky", "smooth"})
LEAST_LIGHT, MOST_STOPS = 6.0, 2.1
"""In grey levels, and as a natural logarithm: no ridge in a shadow is more than eight times as light."""


def with_detail(
    base: FloatArray,
    detail: FloatArray,
    observation: FloatArray,
    level: int,
    light_share: FloatArray | float = 0.5,
    forms: FloatArray | None = None,
) -> FloatArray:
    """Returns base plus detail, in grey levels: as light, as paint, a little as hue.

    The light keeps the ratio of the channels, hence the colour.  What the observation could see of the
    detail is taken out of it again.

    Args:
        base: ``(H, W, 3)`` in grey levels.
        detail: ``(H, W)`` in grey levels.
        observation: ``(h, w, 3)`` in grey levels.
        level: of the new image: beyond the photograph's own, hue varies with the forms, see `tint`.
        light_share: of a photograph's detail, ``(H, W)`` or one for all; light on a leaf is green, not white.
        forms: ``(h, w)`` in deviations, of what the observation hardly could see.
    """
    unseen = _unseen(detail, observation)
    if forms is not None:
        unseen += _missed(detail, observation, forms)
    as_light = np.float32(DEEP_LIGHT) if level > 1 else light_share
    light = as_light * unseen / np.maximum(luma(base), 24)
    image = base * (1 + light[..., None]) + ((1 - as_light) * unseen)[..., None]
    if level > 1:
        return image + tinted(base, unseen, level)
    hue = _unseen(np.roll(blurred(detail, 1.2), (113, 71), (0, 1)), observation)
    return image + hue[..., None] * PHOTOGRAPHED_HUE


def multiplied(detail: FloatArray, plane: FloatArray) -> FloatArray:
    """Returns detail ``(H, W)`` as factors on the light: in a shadow ridges shine, nothing is below black.

    Nor above white: lights fade into the room that is left.  Where detail is weak for the light ``plane``,
    ``(H, W)`` in grey levels, it stays what it is.
    """
    light = np.maximum(plane, np.float32(LEAST_LIGHT))
    made = light * np.expm1(np.minimum(detail / light, np.float32(MOST_STOPS)))
    room = np.maximum(np.float32(WHITE) - plane, np.float32(1))
    return np.where(made > 0, -room * np.expm1(-made / room), made)


def _unseen(detail: FloatArray, observation: FloatArray) -> FloatArray:
    height, width = observation.shape[:2]
    return detail - stretched(area_down(detail, width, height), detail.shape[1], detail.shape[0])


def _missed(detail: FloatArray, observation: FloatArray, forms: FloatArray) -> FloatArray:
    """Returns ``(H, W)``: of the detail and of its forms, what is too faint to contradict the observation."""
    height, width = observation.shape[:2]
    seen = area_down(detail, width, height)
    seen -= blurred(seen, MISSED_PX)
    seen += forms * np.float32(MISSED_RMS)
    most = MISSED_RMS * max(1.0, float(np.sqrt(np.mean(forms * forms))))
    excess = most / max(float(np.sqrt(np.mean(seen * seen))), most)
    return enlarged(seen * np.float32(excess), detail.shape[1], detail.shape[0])


def grain_rms(context: Context) -> FloatArray:
    """Returns ``(n,)`` the photograph's noise in grey levels per region; the new picture has it, too.

    What is even shows its own, because there is nothing else in it; the rest has that of the calmest region.
    """
    least = calmest(context)
    calm = [
        min(region.calm, LOUDEST * least) if name in EVEN and region.share > 0.03 else least
        for region, name in zip(context.regions, context.materials, strict=True)
    ]
    lost = np.float32(max(WORKING_PX / max(*context.labels.shape, LEAST_PX), 1.0) ** 0.5)
    found = np.float32(GRAIN_GAIN) * np.array(calm, np.float32)
    return lost * np.clip(found, LEAST_GRAIN_RMS, MOST_GRAIN_RMS)


def calmest(context: Context) -> float:
    """Returns the least RMS of the finest octave that a region of some size has, in grey levels."""
    return min((region.calm for region in context.regions if region.share > 0.03), default=0.0)


def film_grain(plane: FloatArray, seeds: tuple[int, ...]) -> FloatArray:
    """Returns ``(H, W)``: a camera's noise, or a sky would be plastic; of unit RMS in the middle tones.

    Photographs have it not from pixel to pixel alone: colour filters and compression make clumps of it.  They
    have less in the lights, where a tone curve is flat, and in the black.

    Args:
        plane: ``(H, W)`` luma in grey levels.
        seeds: of the noise.
    """
    rng = np.random.default_rng([*seeds, 7])
    height, width = plane.shape
    fine = blurred(rng.standard_normal(plane.shape, np.float32), GRAIN_PX)
    half = rng.standard_normal((max(height // 2, 1), max(width // 2, 1)), np.float32)  # smooth enough for it
    clumps = stretched(blurred(half, CLUMPS_PX / 2), width, height)
    grain = _normalized(fine) + np.float32(CLUMPED) * _normalized(clumps)
    shares = np.interp(np.arange(256), *np.transpose(GRAIN_OF_TONES)).astype(np.float32)
    tones = np.clip(plane + np.float32(0.5), 0, 255).astype(np.uint8)
    return _normalized(grain) * cv2.LUT(tones, shares)


def _normalized(plane: FloatArray) -> FloatArray:
    return plane / (plane.std() + np.float32(1e-6))


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
