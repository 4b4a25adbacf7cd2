"""Hard things: shells of snails and sea snails, struck and rusty metal, crystals."""

from math import atan2, cos, exp, pi, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, cells3, fade, noise3, smoothstep
from wzviewer.worker.models.builtin.objects.primitives import SPIRAL, sample, spiral_nearest
from wzviewer.worker.models.builtin.objects.terms import (
    COAT,
    HEIGHT,
    LOST,
    ROUGH,
    bump,
    gain,
    grain,
    local,
    tint,
)


@njit(**JIT)
def shell(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A spiral shell: growth lines across the tube, bands and flames of the second colour along it.

    Free: 17 bands (cycles around the tube), 18 their strength, 19 flames, 20 height of growth ribs,
    21 spiral cords.
    """
    a, b, c = local(P, i, x, y, z)
    turn, angle = 0.0, 0.0
    if P[i, 0] == SPIRAL:
        _, turn, angle = spiral_nearest(P, i, a, b, c)
    w = 0.35 * noise3(turn * 3.0, angle * 3.0, 1.0) + 0.12 * noise3(turn * 14.0, angle * 9.0, 2.0)
    band = cos(M[m, 17] * angle + 1.0 + w)
    tint(out, M, m, M[m, 18] * smoothstep(0.25, 0.75, band))
    flame = noise3(turn * 2.6 + 0.8 * angle, angle * 1.1, 3.0) + 0.5 * w
    tint(out, M, m, M[m, 19] * smoothstep(0.15, 0.35, flame))
    gain(out, 1.0 + 0.10 * noise3(turn * 9.0, 0.0, 4.0) + 0.07 * noise3(turn * 31.0, angle, 5.0))
    far = max(sqrt(a * a + b * b), 1e-4)
    lines, high = 46.0, M[m, 20]
    stray = 0.014 * noise3(turn * 5.0, angle * 4.0, 8.0) + 0.005 * noise3(turn * 23.0, angle * 17.0, 9.0)
    for octave in range(3):
        # Where the tube runs slanting lines lie closer than their turn says: the finer ones go early.
        lam = (2.0 if octave == 0 else 1.0) * far / lines
        n = noise3((turn + stray) * lines, 0.35 * angle, 6.0 + octave)
        f = bump(out, n, high, lam, px)
        gain(out, 1.0 + 0.06 * f * n)
        lines *= 3.1
        high *= 0.3  # finer ribs are lower, else their sides all shade alike
    lam = 0.045
    cord = cos(angle * 2.0 * pi * 2.2 * M[m, 21])
    out[HEIGHT] += fade(lam, px) * 0.0016 * cord * min(M[m, 21], 1.0)
    f = fade(0.004, px)
    if f > 0.0:
        near, second, ident = cells3(x / 0.004, y / 0.004, z / 0.004)
        edge = 1.0 - smoothstep(0.0, 0.15, second - near)
        out[HEIGHT] -= f * 0.00012 * edge
        gain(out, 1.0 + f * (0.06 * (ident - 0.5) - 0.05 * edge))
    grain(out, x, y, z, px, 0.006, 0.008)


@njit(**JIT)
def metal(
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
    """Worked metal: hair scratches, dents, a patina of the second colour in what lies low.

    Free: 17 patina, 18 a struck relief (channel 0 of the card) of this radius or 0, 19 ridges around
    the edge or 0.
    """
    a, b, _ = local(P, i, x, y, z)
    low = 0.0
    if M[m, 18] > 0.0:
        r = sqrt(a * a + b * b)
        k = int(P[i, 28])
        h = sample(C[k, 0], a / M[m, 18], b / M[m, 18])
        face = 1.0 - smoothstep(0.985, 1.0, r / M[m, 18])
        out[HEIGHT] += M[m, 16] * h * face
        low = face * (1.0 - smoothstep(0.05, 0.45, h))
        ridge = 0.5 + 0.5 * cos(atan2(b, a) * M[m, 19])
        lam = 2.0 * pi * M[m, 18] / max(M[m, 19], 1.0)
        f = fade(lam, px) * (1.0 - face) if M[m, 19] > 0.0 else 0.0
        out[HEIGHT] += f * 0.25 * lam * ridge
        gain(out, 1.0 - 0.35 * f * (1.0 - ridge))
    n = noise3(x * 7.0, y * 7.0, z * 7.0) + 0.5 * noise3(x * 29.0, y * 29.0, z * 29.0)
    share = M[m, 17] * smoothstep(-0.2, 0.9, 0.9 * n + 1.3 * low - 0.2)
    tint(out, M, m, share)
    out[ROUGH] += 0.30 * share + 0.05 * n
    lam = 0.05
    for _ in range(3):
        s = 1.0 / lam
        u = noise3((x + 0.3 * y) * s * 2.6, (y - 0.3 * x) * s * 0.22, z * s)
        v = noise3((x - 0.8 * y) * s * 0.25, (y + 0.8 * x) * s * 2.2, z * s + 3.0)
        scratch = (1.0 - smoothstep(0.0, 0.05, abs(u))) + (1.0 - smoothstep(0.0, 0.04, abs(v)))
        f = fade(0.10 * lam, px)
        out[HEIGHT] -= f * 0.0035 * lam * scratch
        gain(out, 1.0 - 0.10 * f * scratch)
        out[LOST] += (1.0 - f) * 0.003
        lam *= 0.25
    bump(out, n, 0.003, 0.1, px)
    grain(out, x, y, z, px, 0.004, 0.004)


@njit(**JIT)
def rust(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Iron eaten by rust: scales, pits, powder from orange to black; dull."""
    n = noise3(x * 4.0, y * 4.0, z * 4.0) + 0.6 * noise3(x * 11.0, y * 11.0, z * 11.0)
    n += 0.4 * noise3(x * 33.0, y * 33.0, z * 33.0)
    tint(out, M, m, smoothstep(-0.6, 0.7, n))
    lam = 0.06
    for _ in range(4):
        f = fade(lam, px)
        out[LOST] += (1.0 - f) * 0.03
        if f > 0.0:
            w = 0.5 * noise3(x * 2.5 / lam, y * 2.5 / lam, z * 2.5 / lam)
            near, second, ident = cells3(x / lam + w, y / lam + w, z / lam - w)
            flake = smoothstep(0.0, 0.25, second - near)
            out[HEIGHT] += f * 0.09 * lam * (flake + ident)
            gain(out, 1.0 + f * (0.5 * (ident - 0.5) - 0.35 * (1.0 - flake)))
        lam *= 0.3
    out[COAT] = 0.0
    grain(out, x, y, z, px, 0.003, 0.03)


@njit(**JIT)
def crystal(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A crystal's faces: milky at the foot, veils inside, growth steps across the prism faces.

    Free: 17 half length.
    """
    a, b, c = local(P, i, x, y, z)
    rise = 0.5 + 0.5 * c / max(M[m, 17], 1e-6)
    veil = noise3(x * 4.0 + noise3(x * 5.0, y * 5.0, z * 5.0), y * 4.0, z * 3.0)
    tint(out, M, m, 0.75 * (1.0 - smoothstep(0.0, 0.55, rise + 0.25 * veil)))
    gain(out, 1.0 + 0.35 * veil)
    crack = exp(-((noise3(x * 4.0 + z * 3.0, y * 5.0, z * 8.0) / 0.05) ** 2))
    for e in range(3):
        out[e] += 0.30 * crack * (0.8 - out[e]) * (1.0 - smoothstep(0.4, 1.0, rise))
    # Growth steps come in fields, and the finer they are the lower: all over they looked engraved.
    lam, high = 0.05, 0.0016 * smoothstep(-0.1, 0.5, noise3(x * 2.5, y * 2.5, z * 3.5 + 9.0))
    for _ in range(3):
        n = noise3(0.2 * a / lam, 0.2 * b / lam, 2.0 * c / lam)
        bump(out, n, high, lam, px)
        lam *= 0.3
        high *= 0.5
    grain(out, x, y, z, px, 0.006, 0.003)
