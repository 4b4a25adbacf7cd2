"""Lattice noise and cells for materials, compiled; float64, so that 8^6 zooms keep their grain."""

from math import floor, sqrt

from numba import njit

# Entry kernels hold no lock, raise nothing from arithmetic (smaller code) and are cached on disk.
# Numba notices edits only in an entry kernel's own file: after editing another one, touch them.
ENTRY = {"cache": True, "nogil": True, "error_model": "numpy"}
# What only kernels call needs no Python wrapper and no cache of its own: half the compile time.
JIT = {"nogil": True, "error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@njit(**JIT)
def hash_unit(i: int, j: int, k: int) -> float:
    """Returns a pseudo-random number in [0, 1) of an integer lattice point."""
    h = (i * 73856093) ^ (j * 19349663) ^ (k * 83492791)
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 2246822519) & 0xFFFFFFFF
    return (h ^ (h >> 16)) / 4294967296.0


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
    first, second, ident = 9.0, 9.0, 0.0
    for n in range(27):
        c = (n + 13) % 27  # the cell itself first: most others are then too far to be looked at
        a, b, e = c % 3 - 1, (c // 3) % 3 - 1, c // 9 - 1
        near = (u if a < 0 else (1.0 - u if a > 0 else 0.0)) ** 2
        near += (v if b < 0 else (1.0 - v if b > 0 else 0.0)) ** 2
        near += (w if e < 0 else (1.0 - w if e > 0 else 0.0)) ** 2
        if near >= second:
            continue
        h = hash_unit(i + a, j + b, k + e)
        # One hash gives three jitters: its digits in base 256.
        h1 = h * 256.0 - int(h * 256.0)
        h2 = h1 * 256.0 - int(h1 * 256.0)
        dx, dy, dz = a + 0.05 + 0.9 * h - u, b + 0.05 + 0.9 * h1 - v, e + 0.05 + 0.9 * h2 - w
        d = dx * dx + dy * dy + dz * dz
        if d < first:
            first, second, ident = d, first, h2
        elif d < second:
            second = d
    return sqrt(first), sqrt(second), ident


@njit(**JIT)
def fade(wavelength: float, px: float) -> float:
    """Returns 0 for what one pixel cannot show and 1 from four pixels a wave: no term aliases."""
    return min(max(wavelength / (2.0 * px) - 1.0, 0.0), 1.0)


@njit(**JIT)
def smoothstep(low: float, high: float, x: float) -> float:
    """Returns the cubic step from 0 at low to 1 at high."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)
