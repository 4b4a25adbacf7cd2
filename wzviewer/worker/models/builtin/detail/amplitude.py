"""How strong the unseen octaves may be.

Fitted on photographs: energy of a new octave = last octave x (last / previous)^0.5, that is, for the three
octaves of an enlargement by eight, sigma = 1.43 b1^1.5 b2^-0.62, where b1 and b2 are the RMS of the finest
two octaves that are seen.  Sparse edges are not counted: letters and wires call for no texture beside them.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.measures import (
    blurred,
    dense_rms,
    drawn_not_lettered,
    first_band,
    local_rms,
    orientation,
    ramp,
    stretched,
    widely_blurred,
)

LAW_GAIN = 1.3 * 1.43  # 1.0 matches the statistics of photographs, 1.3 looks better
PHOTOGRAPHED_GAIN, GROWN_GAIN = 1.4, 0.85
"""On all detail of a first zoom, which is nearer to the truth so in its gradients (divergence of a castle's
.29, .32, .19 at 1.0, here .25, .23, .17), and on that of what grew: with more, leaves hid their trees."""
NOISE_RMS = 0.6
"""What a clean photograph's noise and compression leave in its finest octave, in grey levels."""
NATURAL = frozenset({"foliage", "rock", "sand", "fur", "straw", "bark"})
REGIONAL_SHARE, WOOD_SHARE = 0.7, 1.0
"""Least detail of a place, as a share of what the law gives to its whole region."""
HEM_PX, HEM_TONES = 10.0, 0.6
LEAST_IN_WOOD = 0.6
"""What remains of that where a wood looks lettered: light crowns in dark gaps are two tones, too."""
WOOD_SPREAD = 1.5
"""Below this ratio of the octaves leaves are a texture, above it they are things with contours."""
LIGHT_PX, CROWN_PX, LIGHT_BIAS = 7.0, 0.7, 8.0  # the last in grey levels
LIGHT_POWER, LEAST_LIGHT_GAIN, MOST_LIGHT_GAIN = 3.0, 0.2, 1.5
"""Of the ratio of a place's light to its surroundings': to the first power crowns drowned in their leaves."""
FOCUS_NEAR_PX, FOCUS_WIDE_PX = 3.0, 12.0
BLUNT, SHARP = 1.1, 1.45
"""The gradient at .7 px over that at 2 px, on contours: .7 to 1.1 out of focus, 1.4 to 2.6 in focus."""
LEAST_EDGE = 1.5  # grey levels per px
GLITTER_PX = 5.0
WET_TONE = 85.0
"""In grey levels: half of what is this dark may be `glossy`."""
SHADE_GAIN, MOST_IN_SHADE = 2.0, 0.5
"""Beyond the photograph a shadow has more contrast for its light, up to a share of it, or it is black."""
GLOW = 6.0
"""More of it in what is nearly black, in grey levels: there the forms shine on a black ground."""
BLACK_PERCENTILE, MOST_BLACK = 1.0, 48.0
"""Of the luma, and at most so many grey levels: what a photograph shows as black, for haze or for film."""
MOST_OF_LIGHT, DIM, LEFT_IN_BLACK, SHADE_PX = 0.9, 8.0, 1.0, 1.5
"""Detail, at most, as a share of the light above the black, less where that is dim; and in the black itself.

In a wood whose black is 30 the finest octaves measure 2.6 grey levels at 36, 6 at 48, 16 at 62, 22 at 95."""
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
    wide = np.maximum(wide, fine)  # finer louder than coarser is noise: no reason for more of it
    return law(fine, wide)


def law(fine: FloatArray, wide: FloatArray) -> FloatArray:
    """Returns the RMS of three new octaves after the two finest that are seen, all in grey levels."""
    return LAW_GAIN * fine**1.5 * (wide + np.float32(0.3)) ** np.float32(-0.62)


def regional_sigma(regions: tuple[Region, ...], names: tuple[str, ...]) -> FloatArray:
    """Returns ``(n,)``: what the law gives to each region as a whole, 0 for what is smooth or made by hand.

    A wood is leafy also where its finest octave happens to be calm; patches of leaves would look pasted.
    """
    fine = np.array([region.fine for region in regions], np.float32)
    wide = np.array([max(region.middle, region.fine) for region in regions], np.float32)
    grown = np.array([name in NATURAL for name in names], np.float32)
    share = np.where(woods(regions, names), np.float32(WOOD_SHARE), np.float32(REGIONAL_SHARE))
    return share * grown * law(fine, wide)


def woods(regions: tuple[Region, ...], names: tuple[str, ...]) -> BoolArray:
    """Returns ``(n,)``: which regions are leaves from afar, one dense texture."""
    dense = [region.wide < WOOD_SPREAD * (region.fine + 0.1) for region in regions]
    return np.array(dense) & np.array([name == "foliage" for name in names])


def texture_evidence(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the RMS of the finest octave as far as it is texture, in grey levels.

    Texture is everywhere; letters, windows and wires leave flat places between them.  So the measure is the
    *median* of the octave's size, less the noise of a camera; and the least of the neighbourhood, or a strong
    edge would leak grain to both its sides.
    """
    band = first_band(plane)
    dense = np.minimum(dense_rms(band, 3.0), _median_rms(band) + np.float32(0.1))
    calm = blurred(cv2.erode(dense, np.ones((7, 7), np.uint8)), 3.0)
    found = np.minimum(dense, np.float32(1.7) * calm + np.float32(0.2)) * drawn_not_lettered(plane)
    return np.sqrt(np.maximum(found * found - np.float32(NOISE_RMS**2), 0))


def _median_rms(band: FloatArray) -> FloatArray:
    """The RMS that a Gaussian variable of the same median size has, over 9 px."""
    steps = np.clip(np.abs(band) * 12 + 0.5, 0, 255).astype(np.uint8)
    middle = cv2.medianBlur(steps, 9).astype(np.float32) / 12
    return blurred(middle, 1.5) / np.float32(0.6745)


def in_focus(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: whether the contours here or nearby are as sharp as pixels can show.

    What lies between sharp contours is in focus, too: it looks bare only because it was too far away.
    """
    fine, coarse = _gradient(plane, 0.7), _gradient(plane, 2.0)
    weight = np.square(coarse)
    found = [
        np.sqrt(widely_blurred(weight * np.square(fine / (coarse + np.float32(0.3))), sigma))
        / np.sqrt(widely_blurred(weight, sigma) + np.float32(LEAST_EDGE**2))
        for sigma in (FOCUS_NEAR_PX, FOCUS_WIDE_PX)
    ]
    return ramp(np.maximum(*found), BLUNT, SHARP - BLUNT)


def _gradient(plane: FloatArray, sigma: float) -> FloatArray:
    smooth = blurred(plane, sigma)
    grad_x, grad_y = (
        cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=0.125) for order in ((1, 0), (0, 1))
    )
    return np.hypot(grad_x, grad_y)


def edge_damping(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0.35..1: detail steps back from strong contours."""
    strength = orientation(plane, 1.0, 1.5).strength
    damping: FloatArray = np.float32(0.35) + np.float32(0.65) / (1 + np.square(strength / np.float32(14)))
    return damping


def tone_damping(plane: FloatArray) -> FloatArray:
    """Returns 0.2..1: little detail in the black and in the burnt-out, where it could only be clipped."""
    return ramp(plane, 0, 20).clip(0.25, 1) * bright_damping(plane)


def bright_damping(plane: FloatArray) -> FloatArray:
    """Returns 0.2..1: little detail in the burnt-out."""
    return ramp(262 - plane, 0, 40).clip(0.2, 1)


def hems(natural: FloatArray, plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: where what grew is but a narrow band of two tones, as where two others mix.

    Args:
        natural: ``(h, w)`` share of `NATURAL` materials.
        plane: ``(h, w)`` luma of the observation in grey levels.
    """
    narrow = 1 - ramp(widely_blurred(natural, HEM_PX), 0.35, 0.25)
    lettered = 1 - ramp(blurred(drawn_not_lettered(plane), 3.0), HEM_TONES, 0.25)
    return natural * narrow * lettered


def light_gain(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0.2..1.5: leaves in the light have more contrast than those in the gaps between.

    Without it a wood is a carpet: the forms that the photograph has are where its light is.
    """
    bias = np.float32(LIGHT_BIAS)
    ratio = (blurred(plane, CROWN_PX) + bias) / (widely_blurred(plane, LIGHT_PX) + bias)
    gain: FloatArray = ratio ** np.float32(LIGHT_POWER)
    return gain.clip(LEAST_LIGHT_GAIN, MOST_LIGHT_GAIN)


def shade_ceiling(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the most detail in grey levels that what is this dark shows in a photograph.

    Where no light falls nothing has contrast, however leafy its region is: deep shade is quiet.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
    """
    black = min(float(np.percentile(plane, BLACK_PERCENTILE)), MOST_BLACK)
    light = np.maximum(blurred(plane, SHADE_PX) - np.float32(black), 0)
    return np.float32(MOST_OF_LIGHT) * light * light / (light + np.float32(DIM)) + np.float32(LEFT_IN_BLACK)


def glossy(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: where something dark glitters, an eye or a wet nose amid fur.

    Glitter is specks, hair is lines: of a speck both curvatures are negative.  Their share measures .01 to
    .025 in fur, .03 to .1 on noses and eyes.
    """
    smooth = blurred(plane, 0.8)
    xx, yy, xy = (cv2.Sobel(smooth, cv2.CV_32F, *order) for order in ((2, 0), (0, 2), (1, 1)))
    middle, spread = 0.5 * (xx + yy), np.sqrt(np.square(0.5 * (xx - yy)) + xy * xy)
    weaker = np.minimum(middle + spread, 0)
    energy = blurred(np.square(middle) + np.square(spread), GLITTER_PX) * 2
    share = blurred(weaker * weaker, GLITTER_PX) / (energy + 1)
    dark = 1 - ramp(blurred(plane, GLITTER_PX), 70, 30)
    return ramp(share, 0.03, 0.02) * dark


def wet_places(plane: FloatArray, animal: BoolArray) -> BoolArray:
    """Returns ``(h, w)``: what of an animal is neither hair nor hide, but the wet dark of an eye or a nose.

    Glitter marks the place; what is dark about it belongs to it.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
        animal: ``(h, w)`` where it is hair or hide for all that the description knows.
    """
    side = 2 * round(1.5 * GLITTER_PX) + 1
    near = cv2.dilate((glossy(plane) > 0.5).astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    found: BoolArray = near & (blurred(plane, GLITTER_PX) < WET_TONE) & animal
    return found


def sigma_map(
    plane: FloatArray,
    gain: FloatArray,
    floor: FloatArray,
    micro: FloatArray,
    ceiling: FloatArray,
    regional: FloatArray,
    wood: FloatArray,
    truthful: bool,
) -> FloatArray:
    """Returns the RMS of the detail, ``(h, w)`` in grey levels, at the observation's size.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
        gain: ``(h, w)`` factor of the material on the law.
        floor: ``(h, w)`` least contrast of the material, as a share of the luminance.
        micro: ``(h, w)`` the same where the observation is in focus, if it is `truthful`.
        ceiling: ``(h, w)`` most that the material may have, in grey levels.
        regional: ``(h, w)`` of `regional_sigma`; not where there are letters.
        wood: ``(h, w)`` 1 in `woods`, where there are none.
        truthful: the observation is a photograph: where it shows no texture, the floor does not apply.
    """
    floor_sigma = floor * np.maximum(plane, 24)
    if truthful:
        floor_sigma *= np.float32(0.25) + np.float32(0.75) * ramp(texture_evidence(plane), 0.8, 2.0)
        if micro.any():
            floor_sigma = np.maximum(floor_sigma, micro * np.maximum(plane, 24) * in_focus(plane))
    else:
        floor_sigma *= 1 + np.float32(SHADE_GAIN) * (1 - ramp(plane, 15, 60))
    grown = np.maximum(widely_blurred(drawn_not_lettered(plane), 8.0), np.float32(LEAST_IN_WOOD) * wood)
    texture = np.maximum(lawful_sigma(plane), regional * grown)
    sigma = np.minimum(np.sqrt(np.square(gain * texture) + np.square(floor_sigma)), ceiling)
    if truthful:
        sigma *= np.where(regional > 0, np.float32(GROWN_GAIN) * light_gain(plane), np.float32(1))
        sigma *= np.float32(PHOTOGRAPHED_GAIN) * tone_damping(plane) * edge_damping(plane)
        return np.minimum(sigma, shade_ceiling(plane))
    glow = np.float32(GLOW) * (1 - ramp(plane, 8, 25))
    shade = np.float32(MOST_IN_SHADE) * plane + np.float32(0.8) + glow
    return np.minimum(sigma * bright_damping(plane) * edge_damping(plane), shade)
