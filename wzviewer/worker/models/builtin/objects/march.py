"""The marcher: rays against a body's arrays, and how much light reaches a point.

Rays are parallel (a level's field of view is below 8 degrees), given by image position; a tile of
rays shares the list of primitives whose bounding spheres it can meet.  Kernels hold no lock, so a
thread pool runs several bands at once; every output row is written by one thread: same bytes
whatever the number of threads.
"""

from math import sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import ENTRY, JIT, smoothstep
from wzviewer.worker.models.builtin.objects.primitives import FAR, field, gap

KERNELS = "df5fdce8"  # digest of the files whose functions are compiled in; a test holds it
LAYERS = 3  # a ray passes this many hair-thin surfaces
CLOSE_PX = 1.0 / 1500.0  # body lengths a pixel: a longer body is a close-up
_STEPS = 120
_SOFT = 0.14  # half angle of the cone towards the light
_LOOK = 0.25  # body lengths: what is farther from the cone is not looked at
_TOGETHER = 32  # points
_NEAR_PX = 12.0  # from here on a ray goes where its gap would close, not only where the gap reaches


@njit(**JIT)
def _span(
    P: np.ndarray, ids: np.ndarray, first: int, last: int, o: np.ndarray, d: np.ndarray, wider: float
) -> tuple[float, float]:
    """Returns the ray parameters of the first entry into and the last exit from the bounding spheres.

    The spheres are `wider` by that.
    """
    near, far = FAR, -FAR
    for q in range(first, last):
        i = ids[q]
        x, y, z, r = P[i, 30] - o[0], P[i, 31] - o[1], P[i, 32] - o[2], P[i, 33] + wider
        b = x * d[0] + y * d[1] + z * d[2]
        h = r * r - (x * x + y * y + z * z) + b * b
        if h > 0.0:
            near, far = min(near, b - sqrt(h)), max(far, b + sqrt(h))
    return near, far


@njit(**JIT)
def _gradient(
    P: np.ndarray,
    ids: np.ndarray,
    first: int,
    last: int,
    p: np.ndarray,
    here: float,
    px: float,
    T: np.ndarray,
    skip: int,
    who: int,
    n: np.ndarray,
) -> None:
    """Writes the unit normal of who's group at p, where its distance is `here`, into n.

    Four taps at the corners of a tetrahedron; in a close-up, where a surface hardly bends within a
    pixel, three taps ahead of p.
    """
    n[:] = 0.0
    while P[ids[first], 29] != P[who, 29]:
        first += 1
    while P[ids[last - 1], 29] != P[who, 29]:
        last -= 1
    e = max(0.7 * px, P[who, 34])
    if px < CLOSE_PX:
        n[0] = gap(P, ids, first, last, p[0] + e, p[1], p[2], T, skip, FAR) - here
        n[1] = gap(P, ids, first, last, p[0], p[1] + e, p[2], T, skip, FAR) - here
        n[2] = gap(P, ids, first, last, p[0], p[1], p[2] + e, T, skip, FAR) - here
    else:
        e *= 0.577
        for c in range(4):
            sx = 1.0 if c == 0 or c == 3 else -1.0
            sy = 1.0 if c == 1 or c == 3 else -1.0
            sz = 1.0 if c == 2 or c == 3 else -1.0
            d = gap(P, ids, first, last, p[0] + sx * e, p[1] + sy * e, p[2] + sz * e, T, skip, FAR)
            n[0] += sx * d
            n[1] += sy * d
            n[2] += sz * d
    length = max(sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2), 1e-12)
    n[0], n[1], n[2] = n[0] / length, n[1] / length, n[2] / length


@njit(**ENTRY)
def approach(
    P: np.ndarray,
    T: np.ndarray,
    opacity: np.ndarray,
    ids: np.ndarray,
    spans: np.ndarray,
    centres: np.ndarray,
    frame: np.ndarray,
    radius: float,
    start: np.ndarray,
    via: np.ndarray,
) -> None:
    """Writes how far all rays of a tile can go before any of them meets a surface into start[:, 0].

    A ray through the tile's centre is marched as a cylinder; `radius` holds the tile, body lengths.
    Where what it meets lets light through, it goes on without that primitive: from via[:, k] on, all
    rays that hit it can go on to start[:, k + 1].

    Args:
        P: as in `trace`.
        T: as in `trace`.
        opacity: as in `trace`.
        ids: as in `trace`.
        spans: as in `trace`.
        centres: (tiles, 2) image positions.
        frame: as in `trace`.
        radius: half a tile's diagonal, body lengths.
        start: (tiles, LAYERS) out, along the ray.
        via: (tiles, LAYERS) out, a primitive or -1.
    """
    o, d = np.zeros(3), frame[3]
    for k in range(spans.shape[0]):
        first, last = spans[k, 0], spans[k, 1]
        start[k], via[k] = -FAR, -1
        if first == last:
            continue
        for c in range(3):
            o[c] = frame[0, c] + centres[k, 0] * frame[1, c] + centres[k, 1] * frame[2, c]
        t, far = _span(P, ids, first, last, o, d, radius)
        skip = -1
        for layer in range(LAYERS):
            who = -1
            for _ in range(_STEPS):
                x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
                free, who, _next = field(P, ids, first, last, x, y, z, T, skip)
                if free < 2.0 * radius or t > far:
                    break
                t += 0.85 * sqrt(free * free - radius * radius)
            start[k, layer] = t
            if t > far or who < 0 or opacity[who] > 0.97:
                break
            via[k, layer] = skip = who


@njit(**JIT)
def _next_step(free: float, others: float, before: float, moved: float, px: float) -> float:
    """Returns how far a ray may go where its gap to one surface closes evenly: to just before its end.

    Never past where another surface may begin.
    """
    return min(0.97 * free * moved / (before - free), min(3.0 * free, 0.95 * others))


@njit(**ENTRY)
def trace(
    P: np.ndarray,
    T: np.ndarray,
    opacity: np.ndarray,
    ids: np.ndarray,
    spans: np.ndarray,
    rays: np.ndarray,
    ray_tile: np.ndarray,
    start: np.ndarray,
    via: np.ndarray,
    frame: np.ndarray,
    px: float,
    depth: np.ndarray,
    hit: np.ndarray,
    normal: np.ndarray,
) -> None:
    """Marches rays; up to `LAYERS` hits each, because a hair thinner than a pixel lets light through.

    Args:
        P: (n, 36) primitives.
        T: (k, s, s) float32 outlines.
        opacity: (n,) coverage of a pixel by each primitive, below 1 for hairs.
        ids: primitive lists of all tiles, one after the other.
        spans: (tiles, 2) where each tile's list begins and ends in `ids`.
        rays: (r, 2) image positions.
        ray_tile: (r,) tile of each ray.
        start: (tiles, LAYERS) from `approach`.
        via: (tiles, LAYERS) from `approach`.
        frame: (4, 3) object-space origin at image (0, 0), steps per image x and y, unit direction.
        px: one pixel in body lengths.
        depth: (r, LAYERS) out, along the ray, body lengths.
        hit: (r, LAYERS) out, primitive or -1.
        normal: (r, LAYERS, 3) out.
    """
    o, p, n, d = np.zeros(3), np.zeros(3), np.zeros(3), frame[3]
    for r in range(rays.shape[0]):
        hit[r, :] = -1
        first, last = spans[ray_tile[r], 0], spans[ray_tile[r], 1]
        for c in range(3):
            o[c] = frame[0, c] + rays[r, 0] * frame[1, c] + rays[r, 1] * frame[2, c]
        tile, follows = ray_tile[r], True
        t, far = _span(P, ids, first, last, o, d, 0.0)
        t = max(t, start[tile, 0])
        skip, layer, last_who, before, moved, sure = -1, 0, -1, FAR, 0.0, 0.0
        for _ in range(_STEPS):
            if t > far or layer == LAYERS:
                break
            p[0], p[1], p[2] = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
            free, who, others = field(P, ids, first, last, p[0], p[1], p[2], T, skip)
            if moved > sure and (free < -0.25 * px or free > 0.5 * before):
                t += sure - moved  # the gap did not close evenly: back to what was sure
                moved, last_who = sure, -1
                continue
            if free < 0.25 * px:
                depth[r, layer], hit[r, layer] = t, who
                _gradient(P, ids, first, last, p, free, px, T, skip, who, n)
                normal[r, layer] = n
                layer += 1
                if opacity[who] > 0.97:
                    break
                skip, last_who = who, -1
                follows = follows and via[tile, layer - 1] == who
                if follows and layer < LAYERS and start[tile, layer] > t:
                    t, moved = start[tile, layer], 0.0
                    continue
            even = who == last_who and free < min(before, _NEAR_PX * px)
            sure = max(0.92 * free, 0.2 * px)
            moved = max(_next_step(free, others, before, moved, px), sure) if even else sure
            before, last_who = free, who
            t += moved


@njit(**JIT)
def _around(points: np.ndarray, first: int, last: int, c: np.ndarray) -> float:
    """Writes the middle of points[first:last] into c (3,); returns how far the farthest is from it."""
    for a in range(3):
        low, high = FAR, -FAR
        for q in range(first, last):
            low, high = min(low, points[q, a]), max(high, points[q, a])
        c[a] = 0.5 * (low + high)
    far = 0.0
    for q in range(first, last):
        x, y, z = points[q, 0] - c[0], points[q, 1] - c[1], points[q, 2] - c[2]
        far = max(far, x * x + y * y + z * z)
    return sqrt(far)


@njit(**JIT)
def _nearby(P: np.ndarray, ids: np.ndarray, count: int, p: np.ndarray, reach: float, out: np.ndarray) -> int:
    """Lists into `out` the primitives of ids[:count] within `reach` of a point; returns how many."""
    found = 0
    for k in range(count):
        i = ids[k]
        x, y, z = p[0] - P[i, 30], p[1] - P[i, 31], p[2] - P[i, 32]
        r = P[i, 33] + reach
        if x * x + y * y + z * z < r * r:
            out[found] = i
            found += 1
    return found


@njit(**JIT)
def _toward_light(
    P: np.ndarray,
    ids: np.ndarray,
    count: int,
    p: np.ndarray,
    light: np.ndarray,
    wide: float,
    around: float,
    out: np.ndarray,
) -> tuple[int, float]:
    """Lists the primitives of ids[:count] near the ray to the light from p, or from any point around it.

    Returns:
        how many, and where the last one ends.
    """
    found, end = 0, 0.0
    for k in range(count):
        i = ids[k]
        x, y, z = P[i, 30] - p[0], P[i, 31] - p[1], P[i, 32] - p[2]
        b = x * light[0] + y * light[1] + z * light[2]
        r = P[i, 33] + wide * max(b + around, 0.0) + 0.02 + around
        if b > -r and x * x + y * y + z * z - b * b < r * r:
            out[found] = i
            found += 1
            end = max(end, b + r)
    return found, end


@njit(**JIT)
def _sky_seen(
    P: np.ndarray, T: np.ndarray, ids: np.ndarray, count: int, p: np.ndarray, n: np.ndarray, reach: float
) -> float:
    """Returns the share of the sky that reaches a point: four taps along the normal."""
    total, weight, tap = 0.0, 0.5, reach
    for _ in range(4):
        x, y, z = p[0] + tap * n[0], p[1] + tap * n[1], p[2] + tap * n[2]
        free = gap(P, ids, 0, count, x, y, z, T, -1, tap)
        free = min(free, max(z, 0.0) if n[2] < 0.9 else FAR)
        total += weight * max(tap - max(free, 0.0), 0.0) / tap
        weight *= 0.62
        tap *= 2.3
    return max(1.0 - 0.95 * total, 0.0)


@njit(**JIT)
def _key_seen(
    P: np.ndarray,
    T: np.ndarray,
    ids: np.ndarray,
    count: int,
    p: np.ndarray,
    light: np.ndarray,
    end: float,
    start: float,
) -> float:
    """Returns the share of the key light that reaches a point: a cone's, as far as nothing narrows it."""
    seen, t = 1.0, start
    for _ in range(56):
        if t > end or seen < 0.01:
            break
        x, y, z = p[0] + t * light[0], p[1] + t * light[1], p[2] + t * light[2]
        free = gap(P, ids, 0, count, x, y, z, T, -1, _SOFT * t + _LOOK)
        seen = min(seen, free / (_SOFT * t) * 0.5 + 0.5)
        near = min(max(free, 0.012 + 0.03 * t), 0.12)
        t += max(near, (free - _SOFT * t) / (1.0 + _SOFT))
    return smoothstep(0.0, 1.0, seen)


@njit(**ENTRY)
def occlude(
    P: np.ndarray,
    T: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    light: np.ndarray,
    px: float,
    reach: float,
    out: np.ndarray,
) -> None:
    """Writes (share of the sky seen, share of the key light seen) of each point into out (n, 2).

    P holds only what casts shadows: no hairs.  Points that follow each other lie close together, so
    each `_TOGETHER` of them share the list of what is near.

    Four taps along the normal, the support plane included; a cone march toward the light with half
    angle .14 (penumbra).  `reach` is the length of the first tap's step, body lengths.
    """
    n = P.shape[0]
    everything, ids = np.arange(n), np.zeros(n, np.int64)
    near, toward, middle = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(3)
    for first in range(0, points.shape[0], _TOGETHER):
        last = min(first + _TOGETHER, points.shape[0])
        around = _around(points, first, last, middle)
        nears = _nearby(P, everything, n, middle, 14.0 * reach + around, near)
        towards, _ = _toward_light(P, everything, n, middle, light, _SOFT, around, toward)
        for q in range(first, last):
            p = points[q]
            count = _nearby(P, near, nears, p, 14.0 * reach, ids)
            out[q, 0] = _sky_seen(P, T, ids, count, p, normals[q], reach)
            count, end = _toward_light(P, toward, towards, p, light, _SOFT, 0.0, ids)
            out[q, 1] = _key_seen(P, T, ids, count, p, light, end, 5.5 * px)
