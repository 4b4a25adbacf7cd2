"""Primitives: rows of one flat array and the compiled distance functions that read them.

A body is `P` (n, 36) float64, sorted by group::

     0 type       1 op (0 union, 1 smooth subtract)   2 blend radius k    3 material
     4:7 centre   7:16 R, local axes from object axes, rows               16:28 parameters
    28 texture   29 group    30:33, 33 bounding sphere    34 smallest step for a normal    35 casts shadow

Inside a group surfaces melt into each other by the cubic smooth minimum; between groups the nearer
wins.  Lengths are in body lengths; y forward, z up, the support is z = 0.
"""

from math import atan2, cos, exp, floor, log, pi, sin, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT
from wzviewer.worker.models.builtin.objects.shapes import (
    box_distance,
    cone_distance,
    cylinder_distance,
    ellipsoid_distance,
    prism_distance,
    smooth_max,
)

ELLIPSOID, DOME, CONE, BOX, CYLINDER, BEZIER, CARD, LOFT, SPIRAL, PRISM, TORUS = range(11)
ROW = 36
FAR = 1.0e9
LOFT_STEP = 0.72  # of the first-order distance to a loft, which is a bound then


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
def chord_bound(P: np.ndarray, i: int, x: float, y: float, z: float) -> float:
    """Returns a cheap lower bound of the distance to a Bezier tube: to its chord, less how far it bends."""
    ax, ay, az = x - P[i, 16], y - P[i, 17], z - P[i, 18]
    bx, by, bz = P[i, 22] - P[i, 16], P[i, 23] - P[i, 17], P[i, 24] - P[i, 18]
    length = bx * bx + by * by + bz * bz
    t = min(max((ax * bx + ay * by + az * bz) / max(length, 1e-18), 0.0), 1.0)
    ax, ay, az = ax - t * bx, ay - t * by, az - t * bz
    # A quadratic curve strays from its chord by no more than half the way to its control point's mean.
    cx = P[i, 19] - 0.5 * (P[i, 16] + P[i, 22])
    cy = P[i, 20] - 0.5 * (P[i, 17] + P[i, 23])
    cz = P[i, 21] - 0.5 * (P[i, 18] + P[i, 24])
    stray = 0.5 * sqrt(cx * cx + cy * cy + cz * cz) + max(P[i, 25], P[i, 26]) + P[i, 2]
    return sqrt(ax * ax + ay * ay + az * az) - stray


@njit(**JIT)
def loft_bound(P: np.ndarray, i: int, x: float, y: float, z: float) -> float:
    """Returns a cheap lower bound of the distance to a loft: to the box that holds it, columns 16:22."""
    x, y, z = x - P[i, 4], y - P[i, 5], z - P[i, 6]
    u = P[i, 7] * x + P[i, 8] * y + P[i, 9] * z
    v = P[i, 10] * x + P[i, 11] * y + P[i, 12] * z
    w = P[i, 13] * x + P[i, 14] * y + P[i, 15] * z
    u = max(max(P[i, 18] - u, u - P[i, 19]), 0.0)
    v = max(max(P[i, 16] - v, v - P[i, 17]), 0.0)
    w = max(max(P[i, 20] - w, w - P[i, 21]), 0.0)
    return LOFT_STEP * sqrt(u * u + v * v + w * w) - P[i, 2]


@njit(**JIT)
def tighter(P: np.ndarray, i: int, x: float, y: float, z: float, bound: float) -> float:
    """Returns a lower bound of the distance to primitive i, less its blend: a ball holds long parts badly."""
    if P[i, 0] == BEZIER:
        return max(bound, chord_bound(P, i, x, y, z))
    if P[i, 0] == LOFT:
        return max(bound, loft_bound(P, i, x, y, z))
    return bound


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
def card_distance(P: np.ndarray, i: int, x: float, y: float, z: float, T: np.ndarray, enough: float) -> float:
    """Returns the distance to a thin curved sheet: a baked outline, lifted by a quadratic height.

    Beyond `enough` a lower bound, which needs no texture.
    """
    size = P[i, 16]
    lift = P[i, 18] * x * x + P[i, 19] * y * y + P[i, 20] * x * y + P[i, 21] * abs(x)
    edge = abs(z - lift) - P[i, 17]
    if 0.8 * edge >= enough:
        return 0.8 * edge
    u, v = x / size, y / size
    beyond = sqrt(max(abs(u) - 1.0, 0.0) ** 2 + max(abs(v) - 1.0, 0.0) ** 2)
    flat = (sample(T[int(P[i, 28])], u, v) + beyond) * size
    return 0.8 * (min(max(flat, edge), 0.0) + sqrt(max(flat, 0.0) ** 2 + max(edge, 0.0) ** 2))


@njit(**JIT)
def station(T: np.ndarray, P: np.ndarray, i: int, y: float) -> tuple[float, float, float, float, float]:
    """Returns (cx, cz, half width, height above, height below) of a loft's section at local y.

    Rows 0..4 of the loft's texture hold them from y = P[16] to P[17]; quadratic B-splines, so the
    normal has no steps at any magnification.
    """
    m, n = int(P[i, 28]), T.shape[2]
    x = min(max((y - P[i, 16]) / (P[i, 17] - P[i, 16]), 0.0), 1.0) * (n - 1)
    k = min(max(int(x + 0.5), 1), n - 2)
    f = x - k
    a, b, c = 0.5 * (0.5 - f) ** 2, 0.75 - f * f, 0.5 * (0.5 + f) ** 2
    return (
        a * T[m, 0, k - 1] + b * T[m, 0, k] + c * T[m, 0, k + 1],
        a * T[m, 1, k - 1] + b * T[m, 1, k] + c * T[m, 1, k + 1],
        max(a * T[m, 2, k - 1] + b * T[m, 2, k] + c * T[m, 2, k + 1], 1e-5),
        max(a * T[m, 3, k - 1] + b * T[m, 3, k] + c * T[m, 3, k + 1], 1e-5),
        max(a * T[m, 4, k - 1] + b * T[m, 4, k] + c * T[m, 4, k + 1], 1e-5),
    )


@njit(**JIT)
def loft_distance(P: np.ndarray, i: int, x: float, y: float, z: float, T: np.ndarray) -> float:
    """Returns a bound of the distance to a body along y with half-elliptic sections from a table.

    Columns 16:22 are the box that holds it: y, x, z, low and high each.
    """
    cx, cz, a, above, below = station(T, P, i, y)
    u, w = x - cx, z - cz
    b = above if w > 0.0 else below
    p, q = 1.0 / a, 1.0 / b
    u, w = u * p, w * q
    k0 = sqrt(u * u + w * w)
    u, w = u * p, w * q
    k1 = sqrt(u * u + w * w)
    d = k0 * (k0 - 1.0) / k1 if k1 > 1e-9 else -min(a, b)
    beyond = max(max(P[i, 16] - y, y - P[i, 17]), 0.0)
    if beyond > 0.0:
        d = sqrt(max(d, 0.0) ** 2 + beyond * beyond)
    return LOFT_STEP * d


@njit(**JIT)
def spiral_nearest(P: np.ndarray, i: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Returns (distance bound, turn angle, angle around the tube) of a logarithmic spiral tube.

    Parameters: 16 radius, 17 growth b, 18 rise, 19 tube, 20 flattening, 21:23 first and last turn
    angle, 23 knobs' height, 24 knobs a turn, 25 slant of the section, 26 flare of the lip, 27 e^(2 pi b).
    """
    r, phi = sqrt(x * x + y * y), atan2(y, x)
    big, rise, growth = P[i, 16], P[i, 18], P[i, 17]
    along = max((r * big + z * rise) / (big * big + rise * rise), 1e-6)
    turn = floor((log(along) / growth - phi) / (2.0 * pi)) - 1.0
    below = exp(growth * (phi + 2.0 * pi * turn))
    tilt_c, tilt_s = cos(P[i, 25]), sin(P[i, 25])
    reach = P[i, 19] * max(P[i, 20], 1.0) * (1.0 + P[i, 23]) * (1.0 + P[i, 26])
    best, best_turn, best_u, best_w = FAR, 0.0, 1.0, 0.0
    for c in range(5):
        # The likeliest whorl first: most of the others are then too far to be looked at.
        whorl = 1.0 if c == 0 else (2.0 if c == 1 else (0.0 if c == 2 else 3.0))
        end, off, across = phi + 2.0 * pi * (turn + whorl), 0.0, r
        once = P[i, 27]
        g = below * (once if c == 0 else (once * once if c == 1 else (1.0 if c == 2 else once * once * once)))
        if c == 4:  # the round end of the tube
            end = P[i, 22]
            g, across = exp(growth * end), r * cos(phi - end)
            off = sin(phi - end) * r if across > 0.0 else r
        elif end < P[i, 21] or end > P[i, 22]:
            continue
        u, w = across - big * g, z - rise * g
        if sqrt(u * u + w * w + off * off) - reach * g > best:
            continue
        u, w = tilt_c * u + tilt_s * w, tilt_c * w - tilt_s * u
        a = P[i, 19] * g
        lip = max(end - P[i, 22] + 0.9, 0.0) / 0.9
        a *= 1.0 + P[i, 26] * lip * lip
        if P[i, 23] > 0.0 and abs(u) < 2.0 * a:
            swell = max(cos(P[i, 24] * end), 0.0)
            angle = atan2(w / P[i, 20], u)
            a *= 1.0 + P[i, 23] * swell * swell * exp(-5.0 * (angle + 0.6) ** 2)
        b = a * P[i, 20]
        k0 = sqrt((u / a) ** 2 + (w / b) ** 2 + (off / a) ** 2)
        k1 = sqrt((u / (a * a)) ** 2 + (w / (b * b)) ** 2 + (off / (a * a)) ** 2)
        d = k0 * (k0 - 1.0) / k1 if k1 > 1e-9 else -min(a, b)
        if d < best:
            best, best_turn, best_u, best_w = d, end, u, w / P[i, 20]
    return 0.68 * best, best_turn, atan2(best_w, best_u)


@njit(**JIT)
def primitive_distance(
    P: np.ndarray, i: int, x: float, y: float, z: float, T: np.ndarray, enough: float
) -> float:
    """Returns the signed distance of an object point to primitive i, a lower bound outside it.

    What is farther than `enough` need not be known well.
    """
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
    if kind == LOFT:
        return loft_distance(P, i, lx, ly, lz, T)
    if kind == SPIRAL:
        return spiral_nearest(P, i, lx, ly, lz)[0]
    if kind == PRISM:
        return prism_distance(lx, ly, lz, P[i, 16], P[i, 17], P[i, 18])
    if kind == TORUS:
        return sqrt((sqrt(lx * lx + ly * ly) - P[i, 16]) ** 2 + lz * lz) - P[i, 17]
    return card_distance(P, i, lx, ly, lz, T, enough)


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
) -> tuple[float, int, float]:
    """Returns (signed distance, nearest primitive, next) over ids[first:last]; `skip` is left out.

    Next is a lower bound of the distance to every other group.  A primitive whose bounding sphere
    (which holds its blend radius), box or chord is farther than the best so far cannot change the
    result and is not evaluated.
    """
    best, who, group, behind = FAR, -1, -1.0, FAR
    inner, nearest, member = FAR, FAR, -1
    for q in range(first, last):
        i = ids[q]
        if i == skip:
            continue
        if P[i, 29] != group:
            behind = min(behind, max(inner, best))
            if inner < best:
                best, who = inner, member
            group, inner, nearest, member = P[i, 29], FAR, FAR, -1
        dx, dy, dz = x - P[i, 30], y - P[i, 31], z - P[i, 32]
        radius = P[i, 33]
        away, beyond = dx * dx + dy * dy + dz * dz, radius + max(behind, best)
        if away >= beyond * beyond and beyond > 0.0:
            continue
        bound = sqrt(away) - radius
        tight = tighter(P, i, x, y, z, bound) if bound < min(best, inner) else bound
        if tight >= best or tight >= inner:
            behind = min(behind, tight if tight >= best else FAR)
            continue
        d = bound
        if bound < 0.6 * radius or radius > 0.2:
            d = max(primitive_distance(P, i, x, y, z, T, min(best, inner)), bound)
        k = P[i, 2]
        if P[i, 1] > 0.5:
            if -d > inner:
                member = i  # the cut shows the material of what cut it
            inner = smooth_max(inner, -d, k)
            continue
        if d < nearest:
            nearest, member = d, i
        inner = -smooth_max(-inner, -d, k)
    behind = min(behind, max(inner, best))
    if inner < best:
        best, who = inner, member
    return best, who, behind


@njit(**JIT)
def gap(
    P: np.ndarray,
    ids: np.ndarray,
    first: int,
    last: int,
    x: float,
    y: float,
    z: float,
    T: np.ndarray,
    skip: int,
    limit: float,
) -> float:
    """Returns `field`'s distance alone, or `limit` where it is larger: what is farther is not looked at."""
    best, group, inner = limit, -1.0, FAR
    for q in range(first, last):
        i = ids[q]
        if i == skip:
            continue
        if P[i, 29] != group:
            best, group, inner = min(best, inner), P[i, 29], FAR
        dx, dy, dz = x - P[i, 30], y - P[i, 31], z - P[i, 32]
        radius = P[i, 33]
        nearest = min(best, inner)
        away, beyond = dx * dx + dy * dy + dz * dz, radius + nearest
        if beyond <= 0.0 or away >= beyond * beyond:
            continue
        bound = sqrt(away) - radius
        if tighter(P, i, x, y, z, bound) >= nearest:
            continue
        d = bound
        if bound < 0.6 * radius or radius > 0.2:
            d = max(primitive_distance(P, i, x, y, z, T, nearest), bound)
        if P[i, 1] > 0.5:
            inner = smooth_max(inner, -d, P[i, 2])
        else:
            inner = -smooth_max(-inner, -d, P[i, 2])
    return min(best, inner)
