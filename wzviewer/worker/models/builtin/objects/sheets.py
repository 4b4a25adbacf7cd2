"""Thin sheets cut along an outline: fins, petals, feathers."""

from functools import lru_cache

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import Pen, Vector

Outline = tuple[tuple[float, float], ...]
"""Points of a closed curve; a smooth one is drawn through them."""


def place_card(
    pen: Pen, outline: Outline, root: tuple[float, float], axes: DoubleArray, thickness: float, material: int,
    origin: Vector, bend: tuple[float, float, float, float],
) -> None:  # fmt: skip
    """Adds a card whose drawing's (0, 0) lies at `origin` and whose drawing axes are axes[0] and axes[1]."""
    points = np.asarray(outline)
    centre = (points.min(0) + points.max(0)) / 2
    half = float(np.ptp(points, axis=0).max()) / 2 * 1.12
    place = np.asarray(origin) + centre[0] * axes[0] + centre[1] * axes[1]
    at = (float((root[0] - centre[0]) / half), float((root[1] - centre[1]) / half))
    texture = pen.texture(drawn(outline), None)
    pen.card(
        (float(place[0]), float(place[1]), float(place[2])), axes, half, thickness, bend, texture, material,
        (0.0, 0.0), 1.1, at,
    )  # fmt: skip


@lru_cache(maxsize=64)
def drawn(outline: Outline) -> FloatArray:
    """Returns the distances to an outline in its own window, baked once."""
    points = np.asarray(outline)
    centre = (points.min(0) + points.max(0)) / 2
    window = baking.Window(
        (float(centre[0]), float(centre[1])), float(np.ptp(points, axis=0).max()) / 2 * 1.12
    )
    return baking.outline_distance(baking.closed_curve(list(outline)), window, 2)
