"""How colour varies beside light in what is invented wholly: around the colour that is there.

As in daylight, what is light leans towards yellow and what is dark away from it: orange to gold and rust,
green to lime and bottle green.  What has no colour is shifted between warm and cool, the other way at every
other level.
"""

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import area_down, luma, ramp, stretched

TURN = 1.2  # radians per unit of detail / light
MOST_TURN = 0.25
WARMTH = 0.34
SWING, MOST_SWING = 0.8, 0.2
"""What there is less of, sparse lights or thin dark lines, is paler by this per unit of detail / light."""
COLOURFUL = 0.35
"""From this distance of the channels on, as a share of the greatest, a colour is varied by its hue alone."""
WARM = np.array([1.0, -0.2, -1.593], np.float32)
"""From cool to warm, without luma."""
GREY_AXIS = 3**-0.5


def tinted(base: FloatArray, detail: FloatArray, level: int) -> FloatArray:
    """Returns what to add to the colours, ``(H, W, 3)`` in grey levels, of hardly any luma.

    Args:
        base: ``(H, W, 3)`` in grey levels.
        detail: ``(H, W)`` in grey levels, smooth and without what the observation could see of it.
        level: of the new image.
    """
    height, width = detail.shape
    size = (max(width // 2, 1), max(height // 2, 1))  # colour needs no more, as in any film
    base, detail = area_down(base, *size), area_down(detail, *size)
    light = luma(base)
    ratio = detail / np.maximum(light, 24)
    swing = np.clip(ratio * np.float32(SWING * _rarer(detail)), -MOST_SWING, MOST_SWING)
    colour = base - light[..., None]
    turn = np.clip(ratio * np.float32(TURN), -MOST_TURN, MOST_TURN) * _to_yellow(colour)
    across = np.float32(GREY_AXIS) * (np.roll(colour, 1, 2) - np.roll(colour, -1, 2))
    strongest = base.max(2)
    plain = 1 - ramp(1 - base.min(2) / np.maximum(strongest, 8), 0, COLOURFUL)
    warmth = np.float32(WARMTH if level % 2 else -WARMTH) * plain * detail
    added = colour * swing[..., None] + across * turn[..., None] + warmth[..., None] * WARM
    return stretched(added, width, height)


def _to_yellow(colour: FloatArray) -> FloatArray:
    """Returns the sine of the way from each hue to yellow; ``colour`` is ``(h, w, 3)`` less its light."""
    red = colour[..., 0] - 0.5 * (colour[..., 1] + colour[..., 2])
    green = np.float32(0.75**0.5) * (colour[..., 1] - colour[..., 2])
    way: FloatArray = np.float32(0.75**0.5) * red - np.float32(0.5) * green
    return way / (np.hypot(red, green) + np.float32(4))


def _rarer(detail: FloatArray) -> float:
    """Returns -1 where the lights are sparse, 1 where the dark lines are."""
    return -1.0 if float(np.mean(detail[::4, ::4] ** 3)) > 0 else 1.0
