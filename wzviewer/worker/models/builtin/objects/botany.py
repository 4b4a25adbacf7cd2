"""Plants and fungi: petals, leaves, caps with warts, gills, stems, wood, discs of florets, moss."""

from math import atan2, cos, floor, pi, sin, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, cells3, fade, hash_unit, noise3, smoothstep
from wzviewer.worker.models.builtin.objects.primitives import sample
from wzviewer.worker.models.builtin.objects.terms import (
    HEIGHT,
    LOST,
    ROUGH,
    THIN,
    bump,
    gain,
    grain,
    local,
    tint,
)

GOLDEN_ANGLE = pi * (3.0 - sqrt(5.0))
GOLDEN_TURN = (3.0 - sqrt(5.0)) / 2.0


@njit(**JIT)
def petal(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A petal on a card: folds along it, fine veins, a velvet of cells; second colour at the root.

    Free: 17 how far out (0..1) the second colour reaches, 18 depth of the folds.
    """
    a, b, _ = local(P, i, x, y, z)
    size = P[i, 16]
    along = (b - P[i, 23]) / (2.0 * size)
    w = 0.10 * noise3(a * 20.0, b * 6.0, 1.0 * i)
    tint(out, M, m, 1.0 - smoothstep(M[m, 17] - 0.18, M[m, 17] + 0.18, along + w))
    fold = noise3(a / size * 5.0, along * 0.8, 1.7 * i)
    out[HEIGHT] += fade(0.4 * size, px) * M[m, 18] * 0.05 * size * fold
    lam = 0.16 * size
    for octave in range(3):
        n = noise3(2.0 * a / lam + 0.2 * noise3(b * 9.0, a * 9.0, 0.5), along * 1.6, 2.0 * octave + i)
        f = bump(out, n, 0.05, lam, px)
        gain(out, 1.0 + 0.10 * f * n)
        lam *= 0.4
    gain(out, 1.0 + 0.16 * (hash_unit(i, 3, 9) - 0.5) - 0.22 * (1.0 - smoothstep(0.0, 0.35, along)))
    lam = M[m, 9]
    f = fade(lam, px)
    out[LOST] += (1.0 - f) * 0.02
    if f > 0.0:
        near, second, ident = cells3(x / lam, y / lam, z / lam)
        out[HEIGHT] += f * 0.22 * lam * (1.0 - near * near)
        gain(out, 1.0 + f * (0.12 * (ident - 0.5) - 0.15 * (1.0 - smoothstep(0.0, 0.2, second - near))))
    grain(out, x, y, z, px, 0.25 * lam, 0.012)


@njit(**JIT)
def leaf(
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
    """A leaf on a card: midrib, side veins and their net from baked distances, cells between.

    Free: 17 autumn (0..1), 18 amount of brown spots.
    """
    a, b, _ = local(P, i, x, y, z)
    size, k = P[i, 16], int(P[i, 28])
    u, v = a / size, b / size
    rib, side, inside = sample(C[k, 0], u, v), sample(C[k, 1], u, v), sample(C[k, 2], u, v)
    patch = noise3(a * 4.0, b * 4.0, 2.0) + 0.5 * noise3(a * 13.0, b * 13.0, 3.0)
    gain(out, 1.0 + 0.16 * patch)
    if M[m, 17] > 0.0:
        turn = smoothstep(-0.6, 0.7, patch + 1.4 * M[m, 17] - 0.7 - 2.0 * min(side, 0.15))
        for e in range(3):
            out[e] += turn * ((0.52, 0.10, 0.012)[e] - out[e])
    s = noise3(a * 24.0, b * 24.0, 6.0) + 0.4 * noise3(a * 70.0, b * 70.0, 6.5)
    spot = M[m, 18] * smoothstep(0.62, 0.78, s)
    for e in range(3):
        out[e] += spot * ((0.13, 0.06, 0.02)[e] - out[e])
    soft = max(0.005, 0.7 * px / size)
    wide = 0.016 * (1.0 - 0.35 * v)
    vein = max(
        1.0 - smoothstep(-soft, soft, rib - wide),
        0.75 * (1.0 - smoothstep(-soft, soft, side - 0.005 - 0.3 * soft)),
    )
    tint(out, M, m, 0.85 * vein)
    gain(out, 1.0 - 0.22 * (1.0 - smoothstep(0.0, 0.055, min(side, rib))) * (1.0 - vein))
    out[HEIGHT] += fade(0.10, px) * 0.016 * smoothstep(0.0, 0.16, min(side, 0.16))
    out[HEIGHT] += fade(0.03, px) * 0.006 * (1.0 - smoothstep(0.0, wide + 0.02, rib))
    lam = M[m, 9]
    w = 0.30 * noise3(a * 3.0 / lam, b * 3.0 / lam, 1.0)
    for octave in range(2):
        f = fade(lam, px) * (1.0 - vein)
        if f > 0.0:
            near, second, ident = cells3(a / lam + w, b / lam - w, 4.0 + octave)
            net = 1.0 - smoothstep(0.02, 0.14, second - near)
            tint(out, M, m, 0.35 * f * net)
            out[HEIGHT] += f * 0.05 * lam * (1.0 - near * near - 0.6 * net)
            gain(out, 1.0 + 0.14 * f * (ident - 0.5))
        lam *= 0.16
    out[THIN] = 1.0 - 0.5 * vein
    gain(out, 1.0 - 0.30 * (1.0 - smoothstep(0.0, 0.02, -inside)))
    grain(out, x, y, z, px, 2.0 * lam, 0.012)


@njit(**JIT)
def cap(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A mushroom's cap: warts of the second colour that stand out, a striate rim, slime that shines.

    Free: 17 share of places that bear a wart, 18 radius of the cap.
    """
    a, b, _ = local(P, i, x, y, z)
    far = sqrt(a * a + b * b) / M[m, 18]
    gain(out, 1.0 + 0.15 * noise3(x * 6.0, y * 6.0, z * 6.0) - 0.20 * smoothstep(0.75, 1.05, far))
    lam = M[m, 9]
    w = 0.30 * noise3(x * 2.2 / lam, y * 2.2 / lam, z * 2.2 / lam)
    near, _, ident = cells3(x / lam + w, y / lam + w, z / lam - w)
    size = (0.26 + 0.30 * hash_unit(int(ident * 9973.0), 3, 1)) * (1.0 - 0.35 * far)
    size *= 1.0 if ident < M[m, 17] else 0.0
    rag = 0.10 * noise3(x * 9.0 / lam, y * 9.0 / lam, z * 9.0 / lam)
    wart = (1.0 - smoothstep(size - 0.05, size + 0.05, near + rag)) if size > 0.0 else 0.0
    tint(out, M, m, wart)
    out[HEIGHT] += fade(lam, px) * 0.20 * lam * wart * (1.0 + 0.5 * rag)
    out[ROUGH] += 0.35 * wart
    angle = atan2(b, a)
    rim = smoothstep(0.80, 0.98, far)
    out[HEIGHT] -= (
        fade(0.03, px) * 0.0012 * rim * (0.5 + 0.5 * cos(64.0 * angle + 2.0 * noise3(a * 8.0, b * 8.0, 0.0)))
    )
    dirt = smoothstep(0.55, 0.75, noise3(x * 31.0, y * 31.0, z * 31.0))
    gain(out, 1.0 - 0.35 * dirt)
    n = noise3(angle * 30.0, far * 4.0, 2.0)
    gain(out, 1.0 + 0.06 * n)
    bump(out, n, 0.002, 0.05, px)
    f = fade(0.006, px)
    if f > 0.0:
        near, second, _ = cells3(x / 0.006, y / 0.006, z / 0.006)
        net = 1.0 - smoothstep(0.0, 0.2, second - near)
        gain(out, 1.0 - 0.12 * f * net)
        out[HEIGHT] -= f * 0.0004 * net
    grain(out, x, y, z, px, 0.004, 0.012)


@njit(**JIT)
def gills(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Blades that run from a stem to the rim; free: 17 how many."""
    a, b, _ = local(P, i, x, y, z)
    far = sqrt(a * a + b * b)
    phase = atan2(b, a) * M[m, 17] / (2.0 * pi) + 0.2 * noise3(a * 9.0, b * 9.0, 0.0)
    lam = 2.0 * pi * max(far, 1e-4) / M[m, 17]
    f = fade(lam, px)
    edge = abs(phase - floor(phase) - 0.5) * 2.0
    out[HEIGHT] += f * 0.35 * lam * (1.0 - edge)
    gain(out, 1.0 - 0.55 * f * edge)
    grain(out, x, y, z, px, 0.01, 0.012)


@njit(**JIT)
def fibre(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Stems and stalks: streaks along local z, finer ones inside; second colour in patches.

    Free: 17 how long a streak is for its width, 18 share of the second colour.
    """
    a, b, c = local(P, i, x, y, z)
    lam = M[m, 9]
    tint(out, M, m, M[m, 18] * smoothstep(-0.1, 0.7, noise3(a * 9.0, b * 9.0, c * 5.0)))
    for octave in range(4):
        s = 2.0 / lam
        n = noise3(a * s, b * s, c * s / M[m, 17] + 5.0 * octave)
        f = bump(out, n, M[m, 16], lam, px)
        gain(out, 1.0 + 0.11 * f * n)
        lam *= 0.36
    grain(out, x, y, z, px, lam, 0.012)


@njit(**JIT)
def wood(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Carved wood, its fibres along y: rings, rays, pores."""
    w = 0.05 * noise3(x * 2.0, y * 0.7, z * 2.0) + 0.012 * noise3(x * 9.0, y * 2.0, z * 9.0)
    r = sqrt((x + 0.35 + w) ** 2 + (z - 0.9 + w) ** 2)
    ring = r / 0.045
    late = ring - floor(ring)
    tint(out, M, m, 0.75 * smoothstep(0.35, 0.95, late) * (1.0 - smoothstep(0.95, 1.0, late)))
    lam = 0.03
    for _ in range(4):
        n = noise3(2.0 * x / lam, 0.12 * y / lam, 2.0 * z / lam)
        f = bump(out, n, 0.02, lam, px)
        gain(out, 1.0 + 0.10 * f * n)
        lam *= 0.35
    pore = smoothstep(0.55, 0.75, noise3(x * 170.0, y * 14.0, z * 170.0))
    gain(out, 1.0 - 0.35 * fade(0.012, px) * pore)
    out[HEIGHT] -= fade(0.012, px) * 0.0012 * pore
    grain(out, x, y, z, px, 0.004, 0.012)


@njit(**JIT)
def florets(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """The disc of a daisy or a sunflower: buds on Vogel's spiral (1979), riper towards the rim.

    Wavelength: spacing of the buds.  Free: 17 radius within which the second colour rules.
    """
    a, b, _ = local(P, i, x, y, z)
    lam = 0.62 * M[m, 9]
    r, turned = sqrt(a * a + b * b), atan2(b, a) / (2.0 * pi)
    n0, spread = int((r / lam) ** 2), int(2.2 * r / lam) + 2
    best, which = 9.0, 0
    for n in range(max(n0 - spread, 0), n0 + spread + 1):
        off = n * GOLDEN_TURN - turned
        off -= floor(off + 0.5)
        if abs(off) * r > 0.3 * M[m, 9] and n > 12:
            continue
        rad = lam * sqrt(n + 0.5)
        d = (r - rad) ** 2 + 4.0 * r * rad * sin(pi * off) ** 2
        if d < best:
            best, which = d, n
    d = sqrt(best) / M[m, 9]
    f = fade(M[m, 9], px)
    ident = hash_unit(which, 7, 2)
    tint(out, M, m, 1.0 - smoothstep(0.75, 1.25, r / max(M[m, 17], 1e-6) + 0.3 * (ident - 0.5)))
    bud = max(1.0 - (d / 0.56) ** 2, 0.0)
    out[HEIGHT] += f * 0.75 * M[m, 9] * sqrt(bud)
    gain(out, 1.0 + f * (0.30 * (ident - 0.5) + 0.25 * bud - 0.55 * smoothstep(0.35, 0.6, d)))
    out[LOST] += (1.0 - f) * 0.05
    rad, turn = lam * sqrt(which + 0.5), which * GOLDEN_ANGLE
    lobes = cos(5.0 * atan2(a - rad * cos(turn), b - rad * sin(turn)))
    g = fade(0.25 * M[m, 9], px)
    out[HEIGHT] += g * 0.05 * M[m, 9] * lobes * smoothstep(0.05, 0.3, d)
    grain(out, x, y, z, px, 0.3 * M[m, 9], 0.02)


@njit(**JIT)
def moss(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Cushions of moss: clumps, stems whose tips are bright, leaflets."""
    n = noise3(x * 5.0, y * 5.0, z * 5.0)
    gain(out, 1.0 + 0.30 * n)
    lam = 0.07
    for _ in range(4):
        f = fade(lam, px)
        out[LOST] += (1.0 - f) * 0.03
        if f > 0.0:
            w = 0.5 * noise3(x * 3.0 / lam, y * 3.0 / lam, z * 3.0 / lam)
            near, _, ident = cells3(x / lam + w, y / lam - w, z / lam + w)
            tip = max(1.0 - near, 0.0)
            out[HEIGHT] += f * 0.30 * lam * tip
            tint(out, M, m, 0.30 * f * tip * ident)
            gain(out, 1.0 + f * (0.9 * tip - 0.55))
        lam *= 0.3
    grain(out, x, y, z, px, 0.002, 0.03)
