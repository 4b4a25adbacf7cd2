"""Distances to plain shapes about their own origin, compiled; `primitives` reads their sizes from rows.

Lengths are in body lengths.  Outside a shape each is the distance or a lower bound of it.
"""

from math import cos, pi, sin, sqrt

from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT


@njit(**JIT)
def ellipsoid_distance(x: float, y: float, z: float, a: float, b: float, c: float) -> float:
    """Returns the first-order distance to an ellipsoid: k0 (k0 - 1) / k1 (Quilez)."""
    p, q, r = 1.0 / a, 1.0 / b, 1.0 / c
    x, y, z = x * p, y * q, z * r
    k0 = sqrt(x * x + y * y + z * z)
    x, y, z = x * p, y * q, z * r
    k1 = sqrt(x * x + y * y + z * z)
    if k1 < 1e-9:
        return -min(a, min(b, c))
    return k0 * (k0 - 1.0) / k1


@njit(**JIT)
def cone_distance(x: float, y: float, z: float, h: float, r0: float, r1: float) -> float:
    """Returns the distance to a round cone: spheres r0 at z = 0 and r1 at z = h, and their hull."""
    q = sqrt(x * x + y * y)
    b = (r0 - r1) / h
    a = sqrt(max(1.0 - b * b, 0.0))
    k = -b * q + a * z
    if k < 0.0:
        return sqrt(q * q + z * z) - r0
    if k > a * h:
        return sqrt(q * q + (z - h) ** 2) - r1
    return q * a + z * b - r0


@njit(**JIT)
def box_distance(x: float, y: float, z: float, a: float, b: float, c: float, r: float) -> float:
    """Returns the distance to a box with half sides a, b, c and edges rounded by r."""
    u, v, w = abs(x) - a + r, abs(y) - b + r, abs(z) - c + r
    outside = sqrt(max(u, 0.0) ** 2 + max(v, 0.0) ** 2 + max(w, 0.0) ** 2)
    return outside + min(max(u, max(v, w)), 0.0) - r


@njit(**JIT)
def cylinder_distance(x: float, y: float, z: float, radius: float, half: float, r: float) -> float:
    """Returns the distance to a capped cylinder along z with edges rounded by r."""
    u, w = sqrt(x * x + y * y) - radius + r, abs(z) - half + r
    return min(max(u, w), 0.0) + sqrt(max(u, 0.0) ** 2 + max(w, 0.0) ** 2) - r


@njit(**JIT)
def prism_distance(x: float, y: float, z: float, r: float, half: float, tip: float) -> float:
    """Returns a bound of the distance to a hexagonal prism, flat below, six faces to its tip above."""
    d, n = -half - z, sqrt(tip * tip + r * r)
    for k in range(6):
        angle = k * pi / 3.0
        q = x * cos(angle) + y * sin(angle)
        d = max(d, q - r)
        uneven = 1.0 - 0.22 * (k % 2)  # every other face of the tip is the larger one
        d = max(d, (q * tip + (z - half) * r - r * tip * uneven) / n)
    return d


@njit(**JIT)
def smooth_max(a: float, b: float, k: float) -> float:
    """Returns the cubic smooth maximum of width k."""
    h = max(k - abs(a - b), 0.0) / max(k, 1e-9)
    return max(a, b) + h * h * h * k / 6.0
