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
from wzviewer.worker.models.builtin.objects.primitives import FAR, field

KERNELS = "0649db44"  # digest of the files whose functions are compiled in; a test holds it
LAYERS = 3  # a ray passes this many hair-thin surfaces
_STEPS = 120
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
    eps: float,
    T: np.ndarray,
    skip: int,
    who: int,
    n: np.ndarray,
) -> None:
    """Writes the unit normal at p into n: four taps of who's group at the corners of a tetrahedron."""
    n[:] = 0.0
    while P[ids[first], 29] != P[who, 29]:
        first += 1
    while P[ids[last - 1], 29] != P[who, 29]:
        last -= 1
    for c in range(4):
        sx = 1.0 if c == 0 or c == 3 else -1.0
        sy = 1.0 if c == 1 or c == 3 else -1.0
        sz = 1.0 if c == 2 or c == 3 else -1.0
        e = eps * 0.577
        d, _, _ = field(P, ids, first, last, p[0] + sx * e, p[1] + sy * e, p[2] + sz * e, T, skip)
        n[0] += sx * d
        n[1] += sy * d
        n[2] += sz * d
    length = max(sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2), 1e-12)
    n[0], n[1], n[2] = n[0] / length, n[1] / length, n[2] / length


@njit(**ENTRY)
def approach(
    P: np.ndarray,
    T: np.ndarray,
    ids: np.ndarray,
    spans: np.ndarray,
    centres: np.ndarray,
    frame: np.ndarray,
    radius: float,
    start: np.ndarray,
) -> None:
    """Writes how far all rays of a tile can go before any of them meets a surface into start (tiles,).

    A ray through the tile's centre is marched as a cylinder; `radius` holds the tile, body lengths.
    """
    o, d = np.zeros(3), frame[3]
    for k in range(spans.shape[0]):
        first, last = spans[k, 0], spans[k, 1]
        start[k] = -FAR
        if first == last:
            continue
        for c in range(3):
            o[c] = frame[0, c] + centres[k, 0] * frame[1, c] + centres[k, 1] * frame[2, c]
        t, far = _span(P, ids, first, last, o, d, radius)
        for _ in range(_STEPS):
            x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
            gap, _who, _next = field(P, ids, first, last, x, y, z, T, -1)
            if gap < 2.0 * radius or t > far:
                break
            t += 0.85 * sqrt(gap * gap - radius * radius)
        start[k] = t


@njit(**JIT)
def _next_step(gap: float, others: float, before: float, moved: float, px: float) -> float:
    """Returns how far a ray may go where its gap to one surface closes evenly: to just before its end.

    Never past where another surface may begin.
    """
    return min(0.9 * gap * moved / (before - gap), min(3.0 * gap, 0.95 * others))


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
        start: (tiles,) from `approach`.
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
        t, far = _span(P, ids, first, last, o, d, 0.0)
        t = max(t, start[ray_tile[r]])
        skip, layer, last_who, before, moved, sure = -1, 0, -1, FAR, 0.0, 0.0
        for _ in range(_STEPS):
            if t > far or layer == LAYERS:
                break
            p[0], p[1], p[2] = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
            gap, who, others = field(P, ids, first, last, p[0], p[1], p[2], T, skip)
            if moved > sure and (gap < -0.25 * px or gap > 0.5 * before):
                t += sure - moved  # the gap did not close evenly: back to what was sure
                moved, last_who = sure, -1
                continue
            if gap < 0.25 * px:
                depth[r, layer], hit[r, layer] = t, who
                _gradient(P, ids, first, last, p, max(0.7 * px, P[who, 34]), T, skip, who, n)
                normal[r, layer] = n
                layer += 1
                if opacity[who] > 0.97:
                    break
                skip, last_who = who, -1
            even = who == last_who and gap < min(before, _NEAR_PX * px)
            sure = max(0.92 * gap, 0.2 * px)
            moved = max(_next_step(gap, others, before, moved, px), sure) if even else sure
            before, last_who = gap, who
            t += moved


@njit(**JIT)
def _nearby(P: np.ndarray, x: float, y: float, z: float, reach: float, ids: np.ndarray) -> int:
    """Lists into ids the primitives within `reach` of a point; returns how many."""
    count = 0
    for i in range(P.shape[0]):
        dx, dy, dz = x - P[i, 30], y - P[i, 31], z - P[i, 32]
        r = P[i, 33] + reach
        if dx * dx + dy * dy + dz * dz < r * r:
            ids[count] = i
            count += 1
    return count


@njit(**JIT)
def _toward_light(
    P: np.ndarray, p: np.ndarray, light: np.ndarray, wide: float, ids: np.ndarray
) -> tuple[int, float]:
    """Lists the primitives near the ray from p to the light; returns (how many, where the last one ends)."""
    count, end = 0, 0.0
    for i in range(P.shape[0]):
        x, y, z = P[i, 30] - p[0], P[i, 31] - p[1], P[i, 32] - p[2]
        b = x * light[0] + y * light[1] + z * light[2]
        r = P[i, 33] + wide * max(b, 0.0) + 0.02
        if b > -r and x * x + y * y + z * z - b * b < r * r:
            ids[count] = i
            count += 1
            end = max(end, b + r)
    return count, end


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

    P holds only what casts shadows: no hairs.

    Four taps along the normal, the support plane included; a cone march toward the light with half
    angle .14 (penumbra).  `reach` is the length of the first tap's step, body lengths.
    """
    ids = np.zeros(P.shape[0], np.int64)
    soft = 0.14
    for q in range(points.shape[0]):
        p, n = points[q], normals[q]
        total, weight, tap = 0.0, 0.5, reach
        count = _nearby(P, p[0], p[1], p[2], 14.0 * reach, ids)
        for _ in range(4):
            x, y, z = p[0] + tap * n[0], p[1] + tap * n[1], p[2] + tap * n[2]
            gap, _who, _next = field(P, ids, 0, count, x, y, z, T, -1)
            gap = min(gap, max(z, 0.0) if n[2] < 0.9 else FAR)
            total += weight * max(tap - max(gap, 0.0), 0.0) / tap
            weight *= 0.62
            tap *= 2.3
        out[q, 0] = max(1.0 - 0.95 * total, 0.0)
        count, end = _toward_light(P, p, light, soft, ids)
        seen, t = 1.0, 5.5 * px
        for _ in range(56):
            if t > end or seen < 0.01:
                break
            x, y, z = p[0] + t * light[0], p[1] + t * light[1], p[2] + t * light[2]
            gap, _who, _next = field(P, ids, 0, count, x, y, z, T, -1)
            seen = min(seen, gap / (soft * t) * 0.5 + 0.5)
            t += min(max(gap, 0.012 + 0.03 * t), 0.12)
        out[q, 1] = smoothstep(0.0, 1.0, seen)
