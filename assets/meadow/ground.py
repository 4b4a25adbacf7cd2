"""The lie of the land: height of the ground, and where the path runs."""

import numpy as np
from numpy.typing import ArrayLike

from meadow.noise import noise_field, smooth_ramp
from meadow.world import RANGES, DoubleArray


def path_x(z: ArrayLike) -> DoubleArray:
    """Where the middle of the path lies at distance `z`."""
    z = np.asarray(z, np.float64)
    return 0.34 + 0.085 * z + 0.36 * np.sin(0.55 * z - 0.7) * smooth_ramp(1.0, 5.0, z)


def path_share(x: ArrayLike, z: ArrayLike) -> DoubleArray:
    """How much a place belongs to the footpath, 0 to 1."""
    ragged = 0.22 * (noise_field(x, z, 3.0, 3.3) - 0.5)
    off = np.abs(np.asarray(x) - path_x(z)) + ragged
    wide = 0.10 + 0.035 * np.minimum(z, 12.0)
    return (
        (1 - smooth_ramp(0.35, 1.1, off / wide)) * (1 - smooth_ramp(18.0, 22.0, z)) * smooth_ramp(2.7, 3.4, z)
    )


def ground_height(x: ArrayLike, z: ArrayLike) -> DoubleArray:
    """Height of the land at (x, z)."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    rise = 0.10 * (noise_field(x, z, 0.5, 1.5) - 0.5) * smooth_ramp(1.0, 4.0, z) + 0.45 * (
        noise_field(x, z, 0.13, 8.2) - 0.5
    ) * smooth_ramp(4.0, 14.0, z)
    rise = rise + 0.011 * np.maximum(z - 5.0, 0.0) - 0.035 * path_share(x, z)
    for middle, reach, base, seed, peaks in RANGES:
        crest = np.full(x.shape, base)
        for slope, tall, wide in peaks:
            crest = crest + tall * np.exp(-(((x / np.maximum(z, 1.0) - slope) / wide) ** 2))
        rough = 0.45 + 1.10 * noise_field(x, z * 0.6, 5.5 / middle, seed, 6)
        rise = rise + crest * rough * np.exp(-(((z - middle) / reach) ** 2))
    return rise
