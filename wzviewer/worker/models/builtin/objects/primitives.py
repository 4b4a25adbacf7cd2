"""Primitives: rows of one flat array and the compiled distance functions that read them.

A body is `P` (n, 36) float64, sorted by group::

     0 type       1 op (0 union, 1 smooth subtract)   2 blend radius k    3 material
     4:7 centre   7:16 R, local axes from object axes, rows               16:28 parameters
    28 texture   29 group    30:33, 33 bounding sphere    34 smallest step for a normal    35 casts shadow

Inside a group surfaces melt into each other by the cubic smooth minimum; between groups the nearer
wins.  Lengths are in body lengths; y forward, z up, the support is z = 0.
"""

from math import sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT

ELLIPSOID, DOME, CONE, BOX, CYLINDER, BEZIER, CARD = range(7)
ROW = 36
FAR = 1.0e9


@njit(**JIT)
def ellipsoid_distance(x: float, y: float, z: float, a: float, b: float, c: float) -> float:
    """Returns the first-order distance to an ellipsoid: k0 (k0 - 1) / k1 (Quilez)."""
    k0 = sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    k1 = sqrt((x / (a * a)) ** 2 + (y / (b * b)) ** 2 + (z / (c * c)) ** 2)
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
def bezier_distance(P: np.ndarray, i: int, x: float, y: float, z: float) -> float:
    """Returns the distance to a quadratic Bezier tube whose radius changes linearly."""
    ax, ay, az = P[i, 16] - x, P[i, 17] - y, P[i, 18] - z
    bx, by, bz = P[i, 19] - P[i, 16], P[i, 20] - P[i, 17], P[i, 21] - P[i, 18]
    cx, cy, cz = P[i, 22] - P[i, 19] - bx, P[i, 23] - P[i, 20] - by, P[i, 24] - P[i, 21] - bz
    k0 = ax * bx + ay * by + az * bz
    k1 = 2.0 * (bx * bx + by * by + bz * bz) + ax * cx + ay * cy + az * cz
    k2 = 3.0 * (bx * cx + by * cy + bz * cz)
    k3 = cx * cx + cy * cy + cz * cz
    best, t = FAR, 0.0
    for step in range(5):
        s = step * 0.25
        px, py, pz = ax + s * (2 * bx + s * cx), ay + s * (2 * by + s * cy), az + s * (2 * bz + s * cz)
        d = px * px + py * py + pz * pz
        if d < best:
            best, t = d, s
    for _ in range(3):  # Newton on half the derivative of the squared distance
        slope = k1 + t * (2.0 * k2 + 3.0 * k3 * t)
        if abs(slope) > 1e-12:
            t = min(max(t - (k0 + t * (k1 + t * (k2 + t * k3))) / slope, 0.0), 1.0)
    px, py, pz = ax + t * (2 * bx + t * cx), ay + t * (2 * by + t * cy), az + t * (2 * bz + t * cz)
    d = min(px * px + py * py + pz * pz, best)
    return sqrt(d) - (P[i, 25] + t * (P[i, 26] - P[i, 25]))


@njit(**JIT)
def sample(texture: np.ndarray, u: float, v: float) -> float:
    """Returns a bilinear sample of a square texture on [-1, 1]^2, clamped."""
    n = texture.shape[0]
    x = min(max((u * 0.5 + 0.5) * n - 0.5, 0.0), n - 1.001)
    y = min(max((v * 0.5 + 0.5) * n - 0.5, 0.0), n - 1.001)
    i, j = int(x), int(y)
    a, b = x - i, y - j
    top = texture[j, i] * (1.0 - a) + texture[j, i + 1] * a
    return top * (1.0 - b) + (texture[j + 1, i] * (1.0 - a) + texture[j + 1, i + 1] * a) * b


@njit(**JIT)
def card_distance(P: np.ndarray, i: int, x: float, y: float, z: float, T: np.ndarray) -> float:
    """Returns the distance to a thin curved sheet: a baked outline, lifted by a quadratic height."""
    size = P[i, 16]
    u, v = x / size, y / size
    beyond = sqrt(max(abs(u) - 1.0, 0.0) ** 2 + max(abs(v) - 1.0, 0.0) ** 2)
    flat = (sample(T[int(P[i, 28])], u, v) + beyond) * size
    lift = P[i, 18] * x * x + P[i, 19] * y * y + P[i, 20] * x * y + P[i, 21] * abs(x)
    edge = abs(z - lift) - P[i, 17]
    return 0.8 * (min(max(flat, edge), 0.0) + sqrt(max(flat, 0.0) ** 2 + max(edge, 0.0) ** 2))


@njit(**JIT)
def primitive_distance(P: np.ndarray, i: int, x: float, y: float, z: float, T: np.ndarray) -> float:
    """Returns the signed distance of an object point to primitive i, a lower bound outside it."""
    kind = int(P[i, 0])
    if kind == BEZIER:
        return bezier_distance(P, i, x, y, z)
    x, y, z = x - P[i, 4], y - P[i, 5], z - P[i, 6]
    lx = P[i, 7] * x + P[i, 8] * y + P[i, 9] * z
    ly = P[i, 10] * x + P[i, 11] * y + P[i, 12] * z
    lz = P[i, 13] * x + P[i, 14] * y + P[i, 15] * z
    if kind == ELLIPSOID:
        return ellipsoid_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18])
    if kind == DOME:
        return smooth_max(
            ellipsoid_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18]), P[i, 19] - lz, P[i, 20]
        )
    if kind == CONE:
        return cone_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18])
    if kind == BOX:
        return box_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18], P[i, 19])
    if kind == CYLINDER:
        return cylinder_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18])
    return card_distance(P, i, lx, ly, lz, T)


@njit(**JIT)
def smooth_max(a: float, b: float, k: float) -> float:
    """Returns the cubic smooth maximum of width k."""
    h = max(k - abs(a - b), 0.0) / max(k, 1e-9)
    return max(a, b) + h * h * h * k / 6.0


@njit(**JIT)
def field(
    P: np.ndarray,
    ids: np.ndarray,
    first: int,
    last: int,
    x: float,
    y: float,
    z: float,
    T: np.ndarray,
    skip: int,
) -> tuple[float, int]:
    """Returns (signed distance, nearest primitive) over ids[first:last]; `skip` is left out.

    A primitive whose bounding sphere (which holds its blend radius) is farther than the best so far
    cannot change the result and is not evaluated.
    """
    best, who, group = FAR, -1, -1.0
    inner, nearest, member = FAR, FAR, -1
    for q in range(first, last):
        i = ids[q]
        if i == skip:
            continue
        if P[i, 29] != group:
            if inner < best:
                best, who = inner, member
            group, inner, nearest, member = P[i, 29], FAR, FAR, -1
        dx, dy, dz = x - P[i, 30], y - P[i, 31], z - P[i, 32]
        radius = P[i, 33]
        bound = sqrt(dx * dx + dy * dy + dz * dz) - radius
        if bound >= best or bound >= inner:
            continue
        d = bound
        if bound < 0.6 * radius or radius > 0.2:
            d = max(primitive_distance(P, i, x, y, z, T), bound)
        k = P[i, 2]
        if P[i, 1] > 0.5:
            inner = smooth_max(inner, -d, k)
            continue
        if d < nearest:
            nearest, member = d, i
        inner = -smooth_max(-inner, -d, k)
    if inner < best:
        best, who = inner, member
    return best, who
