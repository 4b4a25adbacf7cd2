"""Compiled parts of fur: where hairs are rooted, what draws them together, and how they are drawn."""

from math import floor, pi, sin, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import ENTRY, JIT, hash_bits, noise3

KERNELS = "dd3e6066"  # digest of the files whose functions are compiled in; a test holds it
_FOOT = 0.75  # of a pixel: a root farther from its middle is another pixel's
_CUTICLE_PX = 2.5  # half width from which on a hair shows its scales


@njit(**JIT)
def _sited(i: int, j: int, k: int, seed: int, lam: float, out: np.ndarray) -> int:
    """Writes the point of lattice cell (i, j, k) of size `lam` into out (3,); returns its hash."""
    h = hash_bits(i + 7919 * seed, j, k)
    out[0] = (i + (h & 1023) / 1023.0) * lam
    out[1] = (j + ((h >> 10) & 1023) / 1023.0) * lam
    out[2] = (k + ((h >> 20) & 1023) / 1023.0) * lam
    return h


@njit(**ENTRY)
def sow(
    points: np.ndarray,
    normals: np.ndarray,
    lam: float,
    seed: int,
    image_from_object: np.ndarray,
    foot_px: float,
    cells: np.ndarray,
    roots: np.ndarray,
    away: np.ndarray,
) -> None:
    """Finds for each surface point whether the root of its lattice cell lies within its pixel.

    One root a cell of object space: the same hairs from every view and at every level.

    Args:
        points: (n, 3) object points.
        normals: (n, 3) object space.
        lam: side of a cell, body lengths.
        seed: of the lattice.
        image_from_object: (2, 3) image px of an object vector.
        foot_px: side of what a point stands for, px.
        cells: (n, 3) out, int64.
        roots: (n, 3) out, object points in the tangent plane.
        away: (n,) out, px between point and root; infinite if it lies elsewhere.
    """
    site = np.zeros(3)
    for q in range(points.shape[0]):
        p, n = points[q], normals[q]
        for c in range(3):
            cells[q, c] = floor(p[c] / lam)
        _sited(cells[q, 0], cells[q, 1], cells[q, 2], seed, lam, site)
        over = (site[0] - p[0]) * n[0] + (site[1] - p[1]) * n[1] + (site[2] - p[2]) * n[2]
        x, y = 0.0, 0.0
        for c in range(3):
            step = site[c] - over * n[c] - p[c]
            roots[q, c] = p[c] + step
            x += image_from_object[0, c] * step
            y += image_from_object[1, c] * step
        far = max(abs(x), abs(y))
        away[q] = far if far < _FOOT * foot_px else np.inf


@njit(**ENTRY)
def gather(points: np.ndarray, lam: float, seed: int, toward: np.ndarray, ident: np.ndarray) -> None:
    """Writes the vector to the nearest point of a jittered lattice (n, 3), and its number in [0, 1) (n,)."""
    site = np.zeros(3)
    for q in range(points.shape[0]):
        x, y, z = points[q]
        i, j, k = floor(x / lam), floor(y / lam), floor(z / lam)
        nearest = np.inf
        for a in range(-1, 2):
            for b in range(-1, 2):
                for c in range(-1, 2):
                    h = _sited(i + a, j + b, k + c, seed, lam, site)
                    d = (site[0] - x) ** 2 + (site[1] - y) ** 2 + (site[2] - z) ** 2
                    if d < nearest:
                        nearest = d
                        ident[q] = ((h * 2654435761) & 0xFFFFFF) / 16777216.0
                        toward[q, 0], toward[q, 1], toward[q, 2] = site[0] - x, site[1] - y, site[2] - z


@njit(**ENTRY)
def wave(points: np.ndarray, frequency: float, out: np.ndarray) -> None:
    """Writes smooth noise of a frequency, per body length, at points (n, 3) into out (n,)."""
    for q in range(points.shape[0]):
        out[q] = noise3(points[q, 0] * frequency, points[q, 1] * frequency, points[q, 2] * frequency)


@njit(**JIT)
def _strayed(
    s: float, lie: np.ndarray, side: np.ndarray, tip: np.ndarray, length: float, bow: float, out: np.ndarray
) -> None:
    """Writes how far along the skin (3,) a hair is from its root, at a share s of its length."""
    swing, pull = length * bow * sin(1.3 * pi * s), s**1.4
    for c in range(3):
        out[c] = length * s * lie[c] + swing * side[c] + pull * tip[c]


@njit(**ENTRY)
def grow(
    points: np.ndarray,
    normals: np.ndarray,
    lie: np.ndarray,
    tip: np.ndarray,
    shape: np.ndarray,
    frame: np.ndarray,
    joints: np.ndarray,
    along: np.ndarray,
) -> None:
    """Bends hairs: off the skin and back to it, to a side, towards the middle of their tuft.

    Of a hair of which only a piece is seen, that piece has its middle at its point.

    Args:
        points: (n, 3) object points.
        normals: (n, 3) unit, object space.
        lie: (n, 3) unit directions in the skin.
        tip: (n, 3) by how much its tuft draws a hair's tip.
        shape: (n, 5) length (body lengths), share of it where the piece begins, share that is seen,
            slope at the root, bow to a side.
        frame: (4, 3) px of an object vector in camera axes; then position x, y, relief, all px.
        joints: (n, k, 4) out: x, y px on rays that are straight on, relief px; the last is not written.
        along: (n, k, 3) out, unit tangents in camera axes.
    """
    count = joints.shape[1]
    side, root, way = np.zeros(3), np.zeros(3), np.zeros((count, 3))
    for n in range(points.shape[0]):
        u, v = normals[n], lie[n]
        side[0], side[1], side[2] = (
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        )
        length, start, piece, lift, bow = shape[n]
        _strayed(start, v, side, tip[n], length, bow, root)
        for k in range(count):
            s = start + piece * k / (count - 1)
            _strayed(s, v, side, tip[n], length, bow, way[k])
            rise = length * lift * (s - 0.55 * s * s)
            for c in range(3):
                way[k, c] += points[n, c] - root[c] + rise * u[c]
        if start > 0.0:
            for c in range(3):
                root[c] = 0.5 * (way[count - 1, c] - way[0, c])
            for k in range(count):
                for c in range(3):
                    way[k, c] -= root[c]
        for k in range(count):
            for r in range(3):
                joints[n, k, r] = frame[3, r] + (
                    frame[r, 0] * way[k, 0] + frame[r, 1] * way[k, 1] + frame[r, 2] * way[k, 2]
                )
        for k in range(count):
            a, b = max(k - 1, 0), min(k + 1, count - 1)
            x, y = joints[n, b, 0] - joints[n, a, 0], joints[n, b, 1] - joints[n, a, 1]
            z = joints[n, b, 2] - joints[n, a, 2]
            far = max(sqrt(x * x + y * y + z * z), 1e-9)
            along[n, k, 0], along[n, k, 1], along[n, k, 2] = x / far, y / far, z / far


@njit(**ENTRY)
def light(
    along: np.ndarray,
    shape: np.ndarray,
    tone: np.ndarray,
    shift: np.ndarray,
    base: np.ndarray,
    pale: np.ndarray,
    to_light: np.ndarray,
    to_eye: np.ndarray,
    colors: np.ndarray,
) -> None:
    """Lights hairs along their length (Kajiya & Kay 1989), darker at the root, by the light on the skin.

    Args:
        along: (n, k, 3) unit tangents, camera axes.
        shape: (n, 5) as in `grow`.
        tone: (n,) brightness of each hair.
        shift: (n,) by how much each one's highlight is moved.
        base: (n, 3) colour of the hair.
        pale: (n, 3) colour of its highlight.
        to_light: (3,) camera axes.
        to_eye: (3,) camera axes.
        colors: (n, k, 3) float32 out.
    """
    count = along.shape[1]
    for n in range(along.shape[0]):
        bright = 0.2126 * base[n, 0] + 0.7152 * base[n, 1] + 0.0722 * base[n, 2]
        steep = 1.0 - 0.7 * min(bright, 1.0)  # among pale hairs light is scattered down to their roots
        for k in range(count):
            tl, tv = 0.0, 0.0
            for c in range(3):
                tl += along[n, k, c] * to_light[c]
                tv += along[n, k, c] * to_eye[c]
            across, aside = sqrt(max(1.0 - tl * tl, 0.0)), sqrt(max(1.0 - tv * tv, 0.0))
            mirrored = min(max(across * aside - tl * tv - shift[n], 0.0), 1.2)
            ramp = 1.0 + steep * (0.55 * (shape[n, 1] + shape[n, 2] * k / (count - 1)) ** 0.7 - 0.45)
            body = (0.55 + 0.45 * across) * ramp * tone[n]
            shine = (0.34 * mirrored**6 + 0.40 * mirrored**28) * ramp
            for c in range(3):
                colors[n, k, c] = body * base[n, c] + shine * pale[n, c]


@njit(**ENTRY)
def draw(
    joints: np.ndarray,
    colors: np.ndarray,
    light: np.ndarray,
    lengths: np.ndarray,
    first_row: int,
    depth: np.ndarray,
    color: np.ndarray,
    owner: np.ndarray,
) -> None:
    """Draws tapering hairs into the rows of a picture that begin at `first_row`: the nearest one is seen.

    Args:
        joints: (n, k, 4) x, y px, relief px, half width px.
        colors: (n, k, 3) float32.
        light: (2,) image part of the unit direction to the light.
        lengths: (n,) float32 hair lengths, px.
        first_row: image row of the first array row.
        depth: (h, w) float32, in and out.
        color: (h, w, 3) float32, in and out.
        owner: (h, w) int32, in and out: number of the hair.
    """
    h, w = depth.shape
    count = joints.shape[1] - 1
    for n in range(joints.shape[0]):
        for k in range(count):
            x0, y0, x1, y1 = joints[n, k, 0], joints[n, k, 1], joints[n, k + 1, 0], joints[n, k + 1, 1]
            y0, y1 = y0 - first_row, y1 - first_row
            wide = max(joints[n, k, 3], joints[n, k + 1, 3]) + 1.0
            if max(y0, y1) < -wide or min(y0, y1) > h + wide or max(x0, x1) < -wide or min(x0, x1) > w + wide:
                continue
            dx, dy = x1 - x0, y1 - y0
            length = max(sqrt(dx * dx + dy * dy), 1e-6)
            tx, ty = dx / length, dy / length
            lit = -ty * light[0] + tx * light[1]
            steep = abs(dy) > abs(dx)
            # Along the longer axis line by line, across it as wide as the hair.
            a0, a1, b0, db = (y0, y1, x0, dx) if steep else (x0, x1, y0, dy)
            da = a1 - a0
            if abs(da) < 1e-6:
                continue
            major, minor = (h, w) if steep else (w, h)
            # A little past its joints, or a bend through 45 degrees leaves a notch.
            past = abs(db) / length
            before = joints[n, k, 3] * past if k > 0 else 0.0
            after = joints[n, k + 1, 3] * past if k < count - 1 else 0.0
            low, high = (a0 - before, a1 + after) if da > 0.0 else (a1 - after, a0 + before)
            thick = length / abs(da)
            for a in range(max(floor(low + 0.5), 0), min(floor(high + 0.5), major)):
                t = (a + 0.5 - a0) / da
                middle = b0 + t * db
                t = min(max(t, 0.0), 1.0)
                half = joints[n, k, 3] + t * (joints[n, k + 1, 3] - joints[n, k, 3])
                reach = max(half * thick, 0.5)
                z = joints[n, k, 2] + t * (joints[n, k + 1, 2] - joints[n, k, 2])
                along = (k + t) / count
                for b in range(max(floor(middle - reach + 0.5), 0), min(floor(middle + reach + 0.5), minor)):
                    across = min(max((b + 0.5 - middle) / reach, -1.0), 1.0)
                    if (steep and dy > 0.0) or (not steep and dx < 0.0):
                        across = -across
                    front = z - 0.5 * half * (1.0 - across * across)
                    y, x = (a, b) if steep else (b, a)
                    if front >= depth[y, x]:
                        continue
                    tone = 1.0 - 0.42 * across * across + 0.30 * across * lit
                    if half > _CUTICLE_PX:
                        u = along * lengths[n] / (0.55 * half) + 0.5 * across * across + 0.37 * n
                        u -= floor(u)
                        fine = min(0.25 * (half - _CUTICLE_PX), 1.0)
                        tone *= 1.0 - 0.16 * fine * u * u * u
                    depth[y, x], owner[y, x] = front, n
                    for c in range(3):
                        own = colors[n, k, c] + t * (colors[n, k + 1, c] - colors[n, k, c])
                        color[y, x, c] = own * tone
