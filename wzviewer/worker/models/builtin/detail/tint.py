"""How colour varies beside light in what is invented wholly: around the colour that is there.

A grey level of detail turns the hue of a colour a little; what has no colour it shifts between warm and cool.
Light forms lean one way at one level and the other way at the next, so that no descent drifts.
"""

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import area_down, luma, ramp, stretched

TURN = 0.7  # radians per unit of detail / light
MOST_TURN = 0.22
WARMTH = 0.28
SWING, MOST_SWING = 1.5, 0.3
"""What there is less of, sparse lights or thin dark lines, is paler by this per unit of detail / light."""
COLOURFUL = 32.0
"""From this distance of the channels on, in grey levels, a colour is varied by its hue alone."""
WARM = np.array([1.0, -0.05, -2.36], np.float32)
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
    lean = np.float32(1 if level % 2 else -1)
    ratio = detail / np.maximum(light, 24)
    turn = np.clip(ratio * np.float32(TURN), -MOST_TURN, MOST_TURN) * lean
    swing = np.clip(ratio * np.float32(SWING * _rarer(detail)), -MOST_SWING, MOST_SWING)
    warmth = np.float32(WARMTH) * lean * (1 - ramp(base.max(2) - base.min(2), 0, COLOURFUL)) * detail
    colour = base - light[..., None]
    across = np.float32(GREY_AXIS) * (np.roll(colour, 1, 2) - np.roll(colour, -1, 2))
    added = colour * swing[..., None] + across * turn[..., None] + warmth[..., None] * WARM
    return stretched(added, width, height)


def _rarer(detail: FloatArray) -> float:
    """Returns -1 where the lights are sparse, 1 where the dark lines are."""
    return -1.0 if float(np.mean(detail[::4, ::4] ** 3)) > 0 else 1.0
