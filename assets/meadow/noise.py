"""Value noise on a lattice of integers, compiled, and its sums of octaves."""

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from meadow.world import DoubleArray


@njit(nogil=True)  # no cache on disk: it runs once
def lattice_hash(x: int, y: int, z: int) -> float:
    """A number in [0, 1) for a point of the lattice."""
    n = np.uint32(x) * np.uint32(0x8DA6B343) ^ np.uint32(y) * np.uint32(0xD8163841)
    n ^= np.uint32(z) * np.uint32(0xCB1AB31F)
    n = (n ^ (n >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    n = (n ^ (n >> np.uint32(12))) * np.uint32(0x297A2D39)
    n ^= n >> np.uint32(15)
    return float(n & np.uint32(0xFFFFFF)) / 16777216.0


@njit(nogil=True)
def value_noise(x: float, y: float, z: float) -> float:
    """Value noise in [0, 1] with quintic interpolation."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    a, b, c = x - i, y - j, z - k
    a = a * a * a * (a * (a * 6 - 15) + 10)
    b = b * b * b * (b * (b * 6 - 15) + 10)
    c = c * c * c * (c * (c * 6 - 15) + 10)
    total = 0.0
    for dk in range(2):
        for dj in range(2):
            row = lattice_hash(i, j + dj, k + dk) * (1 - a) + lattice_hash(i + 1, j + dj, k + dk) * a
            total += row * (b if dj else 1 - b) * (c if dk else 1 - c)
    return total


@njit(nogil=True)
def fbm(x: float, y: float, z: float, octaves: int) -> float:
    """A sum of octaves of `value_noise`, each twice as fine and half as strong, in [0, 1]."""
    total, weight, norm = 0.0, 0.5, 0.0
    for _ in range(octaves):
        total += weight * value_noise(x, y, z)
        norm += weight
        x, y, z = 2.03 * x + 17.1, 2.01 * y + 5.7, 1.98 * z + 9.3
        weight *= 0.5
    return total / norm


@njit(nogil=True)
def _fbm_map(x: DoubleArray, z: DoubleArray, seed: float, octaves: int) -> DoubleArray:
    out = np.empty(x.size)
    for i in range(x.size):
        out[i] = fbm(x[i], seed, z[i], octaves)
    return out


def noise_field(x: ArrayLike, z: ArrayLike, frequency: float, seed: float, octaves: int = 4) -> DoubleArray:
    """Fractal noise in [0, 1] over the plane, of the broadcast shape of `x` and `z`."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    flat = _fbm_map(np.ascontiguousarray(x.ravel() * frequency), z.ravel() * frequency, seed, octaves)
    return np.asarray(flat, np.float64).reshape(x.shape)


def smooth_ramp(low: float, high: float, x: ArrayLike) -> DoubleArray:
    """0 below `low`, 1 above `high`, a cubic between."""
    t = np.clip((np.asarray(x, np.float64) - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t), np.float64)
