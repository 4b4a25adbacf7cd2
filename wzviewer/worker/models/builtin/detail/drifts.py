"""What drifts in air and water, larger than a coarse pixel: veils of cloud, motes, nets of light.

They are the forms of what has no outline: faint enough for the coarser picture to have missed them.
"""

import math
from typing import Any

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.noise import (
    banded,
    fractal,
    normalized,
    periodic_blur,
    stamped,
    warped,
)

STRENGTHS = {"air": 0.95, "haze": 1.25, "plankton": 1.3}
"""Of the forms that anything else may have, 47.3 dB of the coarser picture: 1.3 are 45.0 dB.

Air is made from a photograph's grain, which the coarser picture saw and nobody wants to see."""
MOST_MOTE_PX = 11
LEAST_PX = 32
SPARSE_PX = 260  # of the observation, per mote


def veils(n: int, rng: np.random.Generator) -> FloatArray:
    """Banks of droplets: billows lit from above, thin here and dense there, ``(n, n)``."""
    depth = warped(fractal(n, 1.7, rng, lowest=n / 96), 5.0, rng)
    wisps = warped(fractal(n, 1.1, rng, lowest=n / 24), 6.0, rng)
    lit = depth - np.roll(periodic_blur(depth, 2.0), (3, 2), (0, 1))
    return normalized(depth + 0.5 * normalized(lit) + 0.35 * wisps * np.clip(0.6 + 0.5 * depth, 0, 1.5))


def motes(n: int, rng: np.random.Generator) -> FloatArray:
    """Motes near and far of the plane in focus: small and clear, or large, pale discs, ``(n, n)``."""

    def mote(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        away = rng.random() ** 1.5
        size = rng.uniform(0.7, 1.6) + 7.0 * away
        disc = np.clip((size - np.hypot(u, v)) / (0.8 + 0.5 * size * rng.uniform(0.3, 1.0)) + 0.3, 0, 1)
        disc = disc * disc * (3 - 2 * disc)
        return rng.uniform(0.6, 1.4) * (1.5 - away), 0.75 * disc

    return stamped(np.zeros((n, n), np.float32), n * n // SPARSE_PX, MOST_MOTE_PX, mote, rng)


def net(n: int, rng: np.random.Generator) -> FloatArray:
    """The net of light that ripples throw into water, drawn out flat, strong here and gone there."""
    lines = np.zeros((n, n), np.float32)
    for wave_px, width, weight in ((44, 0.3, 1.0), (26, 0.35, 0.6)):
        wave = warped(banded(n, n / wave_px, rng, stretch=0.6), 4.0, rng)
        lines += weight * np.exp(-np.square(wave / width))
    patches = np.clip(0.6 + 0.7 * fractal(n, 1.6, rng, lowest=n / 160), 0, 1.8)
    return normalized(lines * patches)


def drifting(name: str, height: int, width: int, rng: np.random.Generator) -> FloatArray | None:
    """Returns ``(height, width)`` in deviations: what drifts in a material, or None where nothing does.

    Args:
        name: of the material.
        height: of the observation in px.
        width: of the observation in px.
        rng: source of randomness.
    """
    n = max(4 * math.ceil(max(height, width) / 4), LEAST_PX)
    if name not in STRENGTHS:
        return None
    made = veils(n, rng) if name != "plankton" else 0.6 * net(n, rng) + 0.5 * fractal(n, 1.7, rng)
    if name != "air":
        made = made + normalized(motes(n, rng))
    return np.float32(STRENGTHS[name]) * normalized(made)[:height, :width]
