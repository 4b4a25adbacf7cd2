"""Lattice noise and cells for materials, compiled; float64, so that 8^6 zooms keep their grain."""

from math import floor, sqrt

from numba import njit

# Entry kernels hold no lock, raise nothing from arithmetic (smaller code) and are cached on disk.
# Numba notices edits only in an entry kernel's own file, so those carry a digest of the others.
ENTRY = {"cache": True, "nogil": True, "error_model": "numpy"}
# What only kernels call needs no Python wrapper and no cache of its own: half the compile time.
JIT = {"nogil": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@njit(**JIT)
def hash_bits(i: int, j: int, k: int) -> int:
    """Returns 32 pseudo-random bits of an integer lattice point."""
    h = (i * 73856093) ^ (j * 19349663) ^ (k * 83492791)
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 2246822519) & 0xFFFFFFFF
    return h ^ (h >> 16)


@njit(**JIT)
def hash_unit(i: int, j: int, k: int) -> float:
    """Returns a pseudo-random number in [0, 1) of an integer lattice point."""
    return hash_bits(i, j, k) / 4294967296.0


@njit(**JIT)
def noise3(x: float, y: float, z: float) -> float:
    """Returns smooth value noise in [-1, 1] with wavelength of about 2 (quintic, Perlin 2002)."""
    i, j, k = floor(x), floor(y), floor(z)
    u, v, w = x - i, y - j, z - k
    u = u * u * u * (u * (u * 6.0 - 15.0) + 10.0)
    v = v * v * v * (v * (v * 6.0 - 15.0) + 10.0)
    w = w * w * w * (w * (w * 6.0 - 15.0) + 10.0)
    total = 0.0
    for c in range(8):
        a, b, e = c & 1, (c >> 1) & 1, c >> 2
        weight = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if e else 1.0 - w)
        total += weight * hash_unit(i + a, j + b, k + e)
    return 2.0 * total - 1.0


@njit(**JIT)
def cells3(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Returns (F1, F2, id in [0, 1)) of Worley cells of size 1, points jittered by .9."""
    i, j, k = floor(x), floor(y), floor(z)
    u, v, w = x - i, y - j, z - k
    # Each axis is searched nearest side first, so that most of the 27 cells are too far to be looked at.
    sx, sy, sz = (1 if u > 0.5 else -1), (1 if v > 0.5 else -1), (1 if w > 0.5 else -1)
    first, second, ident = 9.0, 9.0, 0
    for p in range(3):
        a = 0 if p == 0 else (sx if p == 1 else -sx)
        gap_x = 0.0 if p == 0 else (1.0 - u if a > 0 else u) ** 2
        if gap_x >= second:
            break
        for q in range(3):
            b = 0 if q == 0 else (sy if q == 1 else -sy)
            gap_y = gap_x + (0.0 if q == 0 else (1.0 - v if b > 0 else v) ** 2)
            if gap_y >= second:
                break
            for r in range(3):
                e = 0 if r == 0 else (sz if r == 1 else -sz)
                gap_z = gap_y + (0.0 if r == 0 else (1.0 - w if e > 0 else w) ** 2)
                if gap_z >= second:
                    break
                h = hash_bits(i + a, j + b, k + e)
                dx = a - u + 0.05 + (h & 1023) * (0.9 / 1023)
                dy = b - v + 0.05 + ((h >> 10) & 1023) * (0.9 / 1023)
                dz = e - w + 0.05 + ((h >> 20) & 1023) * (0.9 / 1023)
                d = dx * dx + dy * dy + dz * dz
                if d < first:
                    first, second, ident = d, first, h
                elif d < second:
                    second = d
    return sqrt(first), sqrt(second), ((ident * 2654435761) & 0xFFFFFF) / 16777216.0


@njit(**JIT)
def fade(wavelength: float, px: float) -> float:
    """Returns 0 for what one pixel cannot show and 1 from four pixels a wave: no term aliases."""
    return min(max(wavelength / (2.0 * px) - 1.0, 0.0), 1.0)


@njit(**JIT)
def smoothstep(low: float, high: float, x: float) -> float:
    """Returns the cubic step from 0 at low to 1 at high."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)
