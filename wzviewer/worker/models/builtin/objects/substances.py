"""Substance words: the same body cast in metal, carved in wood or stone, blown in glass, overgrown."""

from dataclasses import replace

import numpy as np

from wzviewer.core.types import DoubleArray
from wzviewer.worker.models.builtin.objects.bodies import Body, Tint, Vector, linear, shaded
from wzviewer.worker.models.builtin.objects.coats import LENGTH
from wzviewer.worker.models.builtin.objects.patterns import (
    METAL,
    MOSS,
    PLASTIC,
    RUST,
    SHEET,
    STONE,
    WATER,
    WOOD,
)
from wzviewer.worker.models.builtin.objects.terms import MARKS

# Pattern, colours, roughness, metal, wavelength, wrap, f0, coat, coat roughness.
_SOLIDS: dict[str, tuple[int, Vector, Vector, float, float, float, float, float]] = {
    "wood": (WOOD, linear(186, 132, 78), linear(128, 78, 40), 0.50, 0.02, 0.20, 0.30, 0.22),
    "stone": (STONE, linear(150, 146, 138), linear(104, 100, 94), 0.80, 0.030, 0.15, 0.05, 0.35),
    "marble": (STONE, linear(238, 234, 226), linear(206, 202, 198), 0.30, 0.100, 0.45, 0.80, 0.10),
    "moss": (MOSS, linear(70, 96, 30), linear(168, 190, 70), 0.90, 0.07, 0.50, 0.0, 0.4),
    "rust": (RUST, linear(150, 74, 32), linear(70, 38, 26), 0.90, 0.06, 0.15, 0.0, 0.4),
    "plastic": (PLASTIC, linear(200, 40, 30), linear(200, 40, 30), 0.42, 0.02, 0.12, 0.75, 0.13),
}
GOLD = linear(226, 172, 70)


def recast(body: Body, tint: Tint) -> Body:
    """Returns the body in the substance that the prompt asks for; itself if it asks for none."""
    if tint.substance in _SOLIDS:
        return replace(body, materials=_solid(body.materials, tint))
    if tint.substance == "metal":
        return replace(body, materials=_metal(body.materials, tint.color or GOLD))
    if tint.substance in {"glass", "ice"}:
        return _clear(body, tint)
    return body


def _solid(materials: DoubleArray, tint: Tint) -> DoubleArray:
    pattern, color, second, rough, wavelength, wrap, coat, coat_rough = _SOLIDS[tint.substance]
    if tint.color is not None and tint.substance not in {"moss", "rust"}:
        color, second = tint.color, shaded(tint.color, 0.55 if pattern != PLASTIC else 1.0)
    out = np.zeros_like(materials)
    out[:, :16] = [pattern, *color, *second, rough, 0.0, wavelength, wrap, 0.04, 0.0, coat, 0.0, coat_rough]
    return out


def _metal(materials: DoubleArray, color: Vector) -> DoubleArray:
    """Keeps every relief and takes every colour: fur and feathers become cast ones."""
    out = materials.copy()
    out[:, 1:4], out[:, 4:7] = color, shaded(color, 0.55)
    out[:, 7], out[:, 8], out[:, 10], out[:, 12:15] = 0.30, 1.0, 0.05, 0.0
    out[:, LENGTH] = 0.0
    out[:, MARKS] = 0.0
    out[:, SHEET] = 0.0
    plain = np.isin(out[:, 0], (0, 5))
    out[plain, 0] = METAL
    return out


def _clear(body: Body, tint: Tint) -> Body:
    color = tint.color or ((0.92, 0.97, 0.96) if tint.substance == "glass" else (0.80, 0.92, 1.0))
    out = np.zeros_like(body.materials)
    out[:, :16] = [WATER, 0, 0, 0, 0, 0, 0, 0.05, 0.0, 0.02, 0.0, 0.04, 0.0, 1.0, 0.0, 0.04]
    white = 0.05 if tint.substance == "ice" else 0.012
    out[:, 1:7] = white
    thick = tuple(0.25 + 0.75 * float(c) for c in color)
    return replace(body, materials=out, refractive=True, clear=thick)  # type: ignore[arg-type]
