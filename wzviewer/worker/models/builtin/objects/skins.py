"""Skins of animals: fur and plumage, fish scales, lizard hide, flight feathers, fins, clear wings."""

from math import atan2, cos, exp, floor, pi, sin, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, cells3, fade, hash_unit, noise3, smoothstep
from wzviewer.worker.models.builtin.objects.primitives import CONE, sample, station
from wzviewer.worker.models.builtin.objects.terms import (
    COAT,
    HEIGHT,
    LOST,
    OPAQUE,
    ROUGH,
    THIN,
    bump,
    gain,
    grain,
    local,
    tint,
)


@njit(**JIT)
def fur(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    x: float,
    y: float,
    z: float,
    px: float,
    colored: bool,
    out: np.ndarray,
) -> None:
    """Hair or soft plumage that lies along the part: tufts, strands, single hairs.

    Free: 17 how long a strand is for its width, 18 contrast, 19 stripes, 20 their wavelength, 21 to 23
    see `coats`.
    """
    a, b, c = local(P, i, x, y, z)
    if P[i, 0] == CONE:
        b, c = c, b
    lam, stretch = M[m, 9], M[m, 17]
    if colored and M[m, 19] > 0.0:
        turn = (
            y / M[m, 20]
            + 0.30 * noise3(x * 5.0, y * 5.0, z * 5.0)
            + 0.10 * noise3(x * 23.0, y * 9.0, z * 23.0)
        )
        band = smoothstep(-0.05, 0.45, sin(2.0 * pi * turn) + 0.5 * noise3(x * 90.0, y * 30.0, z * 90.0))
        tint(out, M, m, M[m, 19] * band)
    if M[m, 21] > 0.0:  # its hairs are drawn one by one: this is the skin that they take their colour from
        out[ROUGH] = 1.0
        gain(
            out,
            1.0 + 0.10 * noise3(x * 14.0, y * 14.0, z * 14.0) + 0.06 * noise3(x * 60.0, y * 60.0, z * 60.0),
        )
        return
    sway = 0.9 * noise3(x * 9.0, y * 9.0, z * 9.0)
    lam *= 4.0
    tone, weight = 1.0, 0.5
    for octave in range(8):  # tufts, strands, hairs; finer ones are longer for their width
        f = fade(lam, px)
        if f <= 0.0:
            break
        s = 2.0 / lam
        n = noise3(a * s + sway, b * s / stretch + 3.1 * octave, c * s + 0.5 * sway)
        bump(out, n, M[m, 16], lam, px)
        tone += f * M[m, 18] * weight * n
        weight = 1.0 if octave == 0 else 0.8 * weight
        lam *= 0.40
        stretch *= 1.6
    gain(out, max(tone, 0.25))
    grain(out, x, y, z, px, 2.0 * lam, 0.01)


@njit(**JIT)
def fish(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    x: float,
    y: float,
    z: float,
    px: float,
    T: np.ndarray,
    out: np.ndarray,
) -> None:
    """Overlapping scales on a loft, a smooth head with its gill cover; dark above, pale below.

    Free: 17 where the head begins (y), 18 strength of the scales' dark edges, 19 second colour's
    share on the back, 20 how pale the belly is.
    """
    a, b, c = local(P, i, x, y, z)
    cx, cz, wide, above, below = station(T, P, i, b)
    up = c - cz
    angle = atan2(up / (above if up > 0.0 else below), abs(a - cx) / wide)
    high = sin(angle) + 0.12 * noise3(x * 12.0, y * 12.0, z * 12.0)
    blotch = noise3(x * 27.0, y * 19.0, z * 27.0) + 0.6 * noise3(x * 70.0, y * 50.0, z * 70.0)
    back = smoothstep(-0.10, 0.95, high + 0.10 * blotch)
    tint(out, M, m, M[m, 19] * back)
    pale = M[m, 20] * smoothstep(0.05, 0.80, -high)
    for e in range(3):
        out[e] += pale * ((0.78, 0.76, 0.68)[e] - out[e])
    lam = M[m, 9]
    cover = M[m, 17] + 0.045 * cos(2.2 * angle)  # the gill cover's rear edge bulges backwards
    head = smoothstep(-0.008, 0.008, b - cover + 0.030)
    # A scale is a disc that reaches back under nothing and over the next row: the front one is seen.
    row, wide = (0.5 - b) / lam, angle * 0.17 / (0.62 * lam)
    k = floor(row) - 1.0
    across = wide + 0.5 * (k % 2.0)
    column = floor(across)
    u, v = 2.0 * (across - column) - 1.0, (row - k) / 1.42
    if (0.80 * u) ** 2 + v * v > 1.0:
        k += 1.0
        across = wide + 0.5 * (k % 2.0)
        column = floor(across)
        u, v = 2.0 * (across - column) - 1.0, (row - k) / 1.42
    ident, turn = hash_unit(int(k), int(column), 29), hash_unit(int(k), int(column), 31)
    rho = sqrt(0.64 * u * u + v * v)
    f = fade(lam, px) * (1.0 - head)
    rim = smoothstep(0.80, 0.99, rho)
    # No two lie quite alike: one flashes while its neighbour is dull.
    out[HEIGHT] += f * lam * (0.10 * (rho - 1.2 * rim) + 0.07 * ((ident - 0.5) * u + (turn - 0.5) * v))
    out[ROUGH] *= 1.0 + 0.6 * f * (turn - 0.5)
    gain(out, 1.0 + f * (0.34 * (ident - 0.5) - M[m, 18] * rim * (1.0 - 0.6 * pale) + 0.16 * (0.7 - rho)))
    g = fade(0.10 * lam, px) * (1.0 - head)
    if g > 0.0:
        wave = cos(2.0 * pi * rho * 13.0 + 0.6 * noise3(x * 4.0 / lam, y * 4.0 / lam, z * 4.0 / lam))
        out[HEIGHT] += g * 0.0025 * lam * wave
        gain(out, 1.0 + 0.06 * g * wave)
    out[LOST] += (1.0 - fade(lam, px)) * 0.012
    _head(b - cover, angle, head, blotch, x, y, z, px, out)
    line = 1.0 - smoothstep(0.006, 0.018, abs(angle - 0.18 - 0.5 * max(b, 0.0)) * 0.1)
    gain(out, 1.0 - 0.22 * line * (1.0 - head) * (0.5 + 0.5 * cos(2.0 * pi * row)))
    gain(out, 1.0 + 0.09 * blotch + 0.10 * noise3(x * 7.0, y * 7.0, z * 7.0))
    grain(out, x, y, z, px, 0.25 * lam, 0.006)


@njit(**JIT)
def _head(
    ahead: float,
    angle: float,
    head: float,
    blotch: float,
    x: float,
    y: float,
    z: float,
    px: float,
    out: np.ndarray,
) -> None:
    """Grooves of the gill cover and its plates, pores, and skin that does not shine like glass."""
    side = 1.0 - smoothstep(0.75, 1.0, abs(sin(angle)))
    groove = exp(-((ahead / 0.006) ** 2)) * side
    plate = ahead - 0.062 - 0.030 * cos(2.0 * (angle + 0.25))
    fold = exp(-((plate / 0.004) ** 2)) * side * smoothstep(-0.9, -0.6, angle) * head
    out[HEIGHT] -= fade(0.02, px) * (0.004 * groove + 0.0022 * fold)
    gain(out, 1.0 - 0.45 * groove - 0.22 * fold)
    shine = head * smoothstep(0.0, 0.01, ahead) * (1.0 - smoothstep(0.0, 0.02, plate)) * side
    gain(out, 1.0 + 0.22 * shine + 0.10 * head * blotch)
    out[COAT] *= 1.0 - 0.45 * head * (1.0 - 0.5 * shine)
    out[ROUGH] *= 1.0 + 0.35 * head
    lumps = noise3(x * 34.0, y * 26.0, z * 34.0) + 0.5 * noise3(x * 90.0, y * 70.0, z * 90.0)
    bump(out, lumps, 0.0011 * head, 0.03, px)
    near, _, _ = cells3(x * 75.0, y * 75.0, z * 75.0)
    gain(out, 1.0 - 0.20 * head * fade(0.012, px) * (1.0 - smoothstep(0.10, 0.26, near)))


@njit(**JIT)
def hide(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Beads of horn or lime, every one its own tone, in blotches of the second colour.

    Free: 17 height of a bead for its size, 18 blotches, 19 their wavelength, 20 length of a bead for
    its width, 21 how dark the furrows are.
    """
    lam = M[m, 9]
    if M[m, 18] > 0.0:
        s = 2.0 / M[m, 19]
        n = noise3(x * s, y * s, z * s) + 0.5 * noise3(x * s * 2.7, y * s * 2.7, z * s * 2.7)
        n += 0.35 * fade(lam, px) * noise3(x / lam, y / lam, z / lam)
        tint(out, M, m, M[m, 18] * smoothstep(-0.05, 0.45, n))
    for octave in range(3):
        f = fade(lam, px)
        out[LOST] += (1.0 - f) * 0.04 * M[m, 17]
        if f > 0.0:
            s = 1.0 / lam
            near, second, ident = cells3(x * s, y * s / M[m, 20], z * s)
            furrow = 1.0 - smoothstep(0.02, 0.22, second - near)
            out[HEIGHT] += f * M[m, 17] * lam * (1.0 - near * near - 0.5 * furrow)
            weight = 1.0 if octave == 0 else 0.4
            gain(out, 1.0 + f * weight * (0.40 * (ident - 0.5) - M[m, 21] * furrow))
        lam *= 0.21
    gain(out, 1.0 + 0.12 * noise3(x * 9.0, y * 9.0, z * 9.0))
    grain(out, x, y, z, px, 3.0 * lam, 0.012)


@njit(**JIT)
def plumes(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    x: float,
    y: float,
    z: float,
    px: float,
    T: np.ndarray,
    out: np.ndarray,
) -> None:
    """A folded wing or a tail: a list of feathers, the uppermost first, each with shaft and barbs.

    Rows of texture 17 hold root (y, z), tip (y, z), half width, tone, and share of the second colour
    on the edges; 18 is how many.
    """
    _, b, c = local(P, i, x, y, z)
    table = T[int(M[m, 17])]
    shade = 0.0
    for k in range(int(M[m, 18])):
        dy, dz = table[k, 2] - table[k, 0], table[k, 3] - table[k, 1]
        length = sqrt(dy * dy + dz * dz)
        dy, dz = dy / length, dz / length
        t = ((b - table[k, 0]) * dy + (c - table[k, 1]) * dz) / length
        side = (b - table[k, 0]) * dz - (c - table[k, 1]) * dy
        if t < -0.1 or t > 1.04:
            continue
        half = table[k, 4] * sqrt(min(max(1.0 - t, 0.0) * 4.5, 1.0)) * min(0.55 + 1.8 * max(t, 0.0), 1.0)
        gap = max(abs(side) - half, (t - 1.0) * length)
        if gap >= 0.0 or t < 0.0:
            shade = max(shade, exp(-max(gap, 0.0) / 0.008) * min(1.0, 6.0 * t + 0.6))
            continue
        rim = smoothstep(0.72, 0.94, abs(side) / max(half, 1e-6) + 0.15 * noise3(b * 60.0, c * 60.0, k * 1.0))
        rim = max(rim, smoothstep(0.93, 0.985, t))
        gain(out, table[k, 5] * (1.0 + 0.10 * noise3(t * 9.0, side * 60.0, k * 1.7)))
        tint(out, M, m, table[k, 6] * rim)
        shaft = 1.0 - smoothstep(0.0012, 0.0012 + max(0.002, px), abs(side))
        gain(out, 1.0 - 0.35 * shaft)
        out[HEIGHT] += fade(0.006, px) * 0.0012 * shaft
        out[HEIGHT] += fade(0.03, px) * 0.006 * (1.0 - abs(side) / max(half, 1e-6))
        lam = M[m, 9]
        for _ in range(2):
            barb = (t * length - 0.9 * abs(side)) / lam + 0.25 * noise3(b * 45.0, c * 45.0, 1.0 * k)
            f = fade(lam, px)
            wave = cos(2.0 * pi * barb)
            out[HEIGHT] += f * 0.05 * lam * wave
            gain(out, 1.0 + 0.14 * f * wave)
            lam *= 0.13
        break
    gain(out, 1.0 - 0.55 * shade)
    grain(out, x, y, z, px, 0.01, 0.01)


@njit(**JIT)
def vane(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A single feather on a card: shaft, barbs that part here and there, bars, down at its foot.

    Free: 17 wavelength of the bars, 18 their strength, 19 where (y) the down ends.
    """
    a, b, _ = local(P, i, x, y, z)
    lam, down = M[m, 9], M[m, 19]
    s = b - 0.75 * abs(a) + 0.010 * noise3(a * 30.0, b * 12.0, 1.0)
    side = 7 if a > 0.0 else 3
    bar = sin(2.0 * pi * s / M[m, 17]) + 0.45 * noise3(a * 18.0, b * 18.0, 4.0)
    tint(out, M, m, M[m, 18] * smoothstep(-0.12, 0.12, bar))
    lock = s / (9.0 * lam) + 0.4 * noise3(s * 70.0, 1.0 * side, 0.0)
    n, open_share = floor(lock), lock - floor(lock)
    parts = hash_unit(int(n), side, 5)
    width = 0.10 * smoothstep(0.62, 0.95, parts) * smoothstep(0.02, 0.09, abs(a))
    gap = 1.0 - smoothstep(width, width + max(0.03, 2.0 * px / (9.0 * lam)), open_share)
    out[OPAQUE] = 1.0 - gap * min(1.0, width * 60.0)
    fluff = 1.0 - smoothstep(-0.03, 0.05, b - down + 0.03 * noise3(a * 40.0, b * 40.0, 2.0))
    for e in range(3):
        out[e] += fluff * (0.72 - out[e])
    hair = noise3(a * 130.0 + 14.0 * noise3(a * 16.0, b * 16.0, 6.0), b * 60.0, 8.0)
    out[OPAQUE] *= 1.0 - 0.85 * fluff * smoothstep(-0.1, 0.4, hair + 0.5 * abs(a) / 0.05 - 0.4)
    for octave in range(3):
        f = fade(lam, px)
        wave = cos(2.0 * pi * (s if octave != 1 else s + 1.5 * abs(a)) / lam)
        out[HEIGHT] += f * 0.07 * lam * wave
        gain(out, 1.0 + 0.20 * f * wave)
        lam *= 0.17
    shaft = abs(a) - 0.0075 * (0.9 - 0.8 * b)
    quill = 1.0 - smoothstep(-0.0015, max(0.0015, px), shaft)
    for e in range(3):
        out[e] += quill * ((0.70, 0.60, 0.44)[e] - out[e])
    out[OPAQUE] = max(out[OPAQUE], quill)
    out[HEIGHT] += 0.006 * fade(0.01, px) * (1.0 - smoothstep(-0.008, 0.001, shaft))
    gain(out, 1.0 + 0.14 * noise3(a * 25.0, b * 25.0, 3.0))
    grain(out, x, y, z, px, 0.01, 0.01)


@njit(**JIT)
def fin(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A fin: rays that fan out of its root and branch, skin between them that lets light through.

    Free: 17 rays a radian, 18 how opaque the skin is, 19 how far the second colour reaches in.
    """
    a, b, _ = local(P, i, x, y, z)
    du, dv = a - P[i, 22], b - P[i, 23]
    far, angle = sqrt(du * du + dv * dv), atan2(dv, du)
    count = M[m, 17] * (1.0 if far < 0.55 * P[i, 16] else 2.0)
    phase = angle * count + 0.15 * noise3(a * 14.0, b * 14.0, 2.0)
    ray = (0.5 + 0.5 * cos(2.0 * pi * phase)) ** 2
    lam = far / max(count, 1.0)
    f = fade(lam, px)
    edge = smoothstep(
        M[m, 19] - 0.25, M[m, 19] + 0.25, far / P[i, 16] + 0.1 * noise3(a * 20.0, b * 20.0, 1.0)
    )
    tint(out, M, m, 0.8 * edge)
    cloud = noise3(a * 26.0, b * 26.0, 4.0)
    gain(out, 1.0 - 0.45 * f * (ray - 0.37) + 0.14 * cloud)
    out[HEIGHT] += f * 0.10 * lam * ray
    joint = 0.5 + 0.5 * cos(2.0 * pi * far / 0.012)
    gain(out, 1.0 - 0.18 * fade(0.012, px) * joint * ray)
    skin = M[m, 18] * (1.0 - 0.25 * edge + 0.20 * cloud)
    solid = skin + (1.0 - skin) * (0.37 + f * (ray - 0.37))
    out[OPAQUE] = min(max(solid + 0.6 * (1.0 - smoothstep(0.2, 0.8, far / P[i, 16])), 0.0), 1.0)
    out[THIN] = 1.0 - 0.4 * ray
    grain(out, x, y, z, px, 0.02, 0.01)


@njit(**JIT)
def membrane(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    x: float,
    y: float,
    z: float,
    px: float,
    C: np.ndarray,
    out: np.ndarray,
) -> None:
    """An insect's clear wing: dark veins from a baked distance, skin that shimmers, tiny hairs.

    Free: 17 half width of a vein, 18 how opaque the skin is.
    """
    a, b, _ = local(P, i, x, y, z)
    size, k = P[i, 16], int(P[i, 28])
    vein = sample(C[k, 0], a / size, b / size)
    soft = max(0.006, 0.8 * px / size)
    dark = 1.0 - smoothstep(-soft, soft, vein - M[m, 17])
    shimmer = noise3(a * 11.0, b * 11.0, 1.0)
    for e in range(3):
        out[e] *= 1.0 + 0.35 * shimmer * (1.0, -0.2, -0.8)[e]
    tint(out, M, m, dark)
    out[OPAQUE] = M[m, 18] + (1.0 - M[m, 18]) * 0.92 * dark
    out[HEIGHT] += fade(0.02, px) * 0.003 * dark + fade(0.06, px) * 0.004 * noise3(a * 30.0, b * 30.0, 7.0)
    f = fade(0.0035, px)
    if f > 0.0:
        near, _, _ = cells3(a / 0.0035, b / 0.0035, 0.0)
        dot = 1.0 - smoothstep(0.10, 0.22, near)
        gain(out, 1.0 - 0.5 * f * dot)
        out[OPAQUE] = min(out[OPAQUE] + 0.5 * f * dot, 1.0)
    grain(out, x, y, z, px, 0.003, 0.01)
