"""Insect skins: punctured, netted, furrowed; spots, shields, facets, and what they show up close."""

from math import floor, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, cells3, fade, hash_unit, noise3, smoothstep
from wzviewer.worker.models.builtin.objects.terms import HEIGHT, LOST, bump, gain, grain, tint


@njit(**JIT)
def cuticle(out: np.ndarray, x: float, y: float, z: float, px: float, wavelength: float, pits: float) -> None:
    """Adds what chitin shows up close: punctures, a net of small cells, plates, grain."""
    f = fade(wavelength, px)
    if f > 0.0 and pits > 0.0:
        s = 0.8 / wavelength
        d, _, ident = cells3(x * s, y * s, z * s)
        if ident > 0.35:
            size = 0.16 + 0.16 * ident
            pit = 1.0 - smoothstep(0.35 * size, size, d)
            rim = smoothstep(size, 1.15 * size, d) * (1.0 - smoothstep(1.15 * size, 1.7 * size, d))
            out[HEIGHT] -= f * pits * (pit - 0.12 * rim) * wavelength
            gain(out, 1.0 - 0.30 * f * pit)
    out[LOST] += (1.0 - f) * 0.25 * pits * pits
    net = 0.26 * wavelength
    f = fade(net, px)
    if f > 0.0:
        s = 1.0 / net
        w = 0.18 * noise3(x * s * 1.7, y * s * 1.7, z * s * 1.7)
        a, b, ident = cells3(x * s + w, y * s - w, z * s + w)
        edge = 1.0 - smoothstep(0.02, 0.15, b - a)
        out[HEIGHT] -= f * 0.018 * net * (edge - 0.5 * (1.0 - a))
        gain(out, 1.0 - f * (0.07 * edge - 0.05 * (ident - 0.5)))
    out[LOST] += (1.0 - f) * 0.003
    plates = 0.05 * wavelength
    f = fade(plates, px)
    if f > 0.0:
        s = 1.0 / plates
        a, b, ident = cells3(x * s, y * s, z * s)
        edge = 1.0 - smoothstep(0.0, 0.22, b - a)
        out[HEIGHT] -= f * 0.02 * plates * edge
        gain(out, 1.0 - f * (0.08 * edge + 0.06 * (ident - 0.5)))
    grain(out, x, y, z, px, 0.12 * wavelength, 0.012)


@njit(**JIT)
def elytra(
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
    """Seven spots, pale shoulders, the seam: the wing cases of a ladybird."""
    lx, ly = (x - P[i, 4]) / P[i, 16], (y - P[i, 5]) / P[i, 17]
    lz = max((z - P[i, 6]) / P[i, 18], 0.0)
    side = 1.0 if lx > 0.0 else -1.0
    u = abs(lx)
    w = 0.0
    if colored:
        w = noise3(lx * 4.0, ly * 4.0, lz * 4.0 + side) * 0.030 + noise3(x * 90.0, y * 90.0, z * 90.0) * 0.006
        w += 0.0025 * fade(0.004, px) * noise3(x * 500.0, y * 500.0, z * 500.0)
        gain(
            out, 1.0 + 0.10 * noise3(x * 7.0, y * 7.0, z * 7.0) + 0.06 * noise3(x * 23.0, y * 23.0, z * 23.0)
        )
    rim = smoothstep(0.82, 1.02, sqrt(lx * lx + ly * ly))
    gain(out, 1.0 - 0.35 * rim)
    count = int(M[m, 17]) if colored else 0
    soft = max(0.0045, 1.5 * px)
    for s in range(count):
        sx = 0.0 if s == 0 else (0.62 if s == 1 else (0.33 if s == 2 else 0.56))
        sy = 0.80 if s == 0 else (0.36 if s == 1 else (-0.08 if s == 2 else -0.56))
        r = 0.20 if s == 0 else (0.195 if s == 1 else (0.235 if s == 2 else 0.205))
        sz = sqrt(max(1.0 - sx * sx - sy * sy, 0.0))
        d = sqrt((u - sx) ** 2 + (ly - sy) ** 2 + (lz - sz) ** 2) - r + w
        tint(out, M, m, 1.0 - smoothstep(-soft, soft, d))
    if M[m, 18] > 0.0:
        pale = 1.0 - smoothstep(0.045, 0.085, sqrt((u - 0.20) ** 2 + 0.7 * (ly - 0.945) ** 2) + 0.5 * w)
        for c in range(3):
            out[c] += M[m, 18] * pale * ((0.75, 0.62, 0.45)[c] - out[c])
    # The seam: a groove between two low ridges; dark where dirt gathers.
    d = abs(x + 0.0012 * noise3(0.5, y * 30.0, 0.0))
    groove = 1.0 - smoothstep(0.0010, 0.0042, d)
    ridge = smoothstep(0.003, 0.006, d) * (1.0 - smoothstep(0.008, 0.014, d))
    f = fade(0.0075, px)
    g = fade(0.020, px)
    out[HEIGHT] += 0.0011 * g * ridge - 0.0032 * f * groove
    width = max(0.0030, 0.8 * px)
    gain(out, 1.0 - 0.72 * min(1.0, 0.0045 / width) * (1.0 - smoothstep(0.3 * width, 1.5 * width, d)))
    cuticle(out, x, y, z, px, M[m, 9], M[m, 16])


@njit(**JIT)
def pronotum(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """A dark shield with a pale patch on either front corner; punctured."""
    lx, ly = abs(x - P[i, 4]) / P[i, 16], (y - P[i, 5]) / P[i, 17]
    w = 0.06 * noise3(x * 14.0, y * 14.0, z * 14.0) + 0.015 * noise3(x * 80.0, y * 80.0, z * 80.0)
    patch = smoothstep(-0.03, 0.03, lx - 0.66 + 0.22 * (0.30 - ly) + w)
    tint(out, M, m, patch * M[m, 17])
    gain(out, 1.0 + 0.08 * noise3(x * 25.0, y * 25.0, z * 25.0))
    cuticle(out, x, y, z, px, M[m, 9], M[m, 16])


@njit(**JIT)
def eye(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Hexagonal facets, each a small convex lens, on an eye whose local z looks outward."""
    x, y, z = x - P[i, 4], y - P[i, 5], z - P[i, 6]
    a = P[i, 7] * x + P[i, 8] * y + P[i, 9] * z
    b = P[i, 10] * x + P[i, 11] * y + P[i, 12] * z
    c = P[i, 13] * x + P[i, 14] * y + P[i, 15] * z
    flat = max(sqrt(a * a + b * b), 1e-9)
    arc = np.arctan2(flat, c) * P[i, 16] / flat
    lam = M[m, 9]
    u, v = a * arc / lam, b * arc / lam
    # Two interleaved rectangular lattices make the hexagonal one; the nearer centre wins.
    h = sqrt(3.0)
    u0, v0 = u - floor(u + 0.5), v - h * floor(v / h + 0.5)
    u1, v1 = u - floor(u) - 0.5, v - h * (floor(v / h) + 0.5)
    r2 = min(u0 * u0 + v0 * v0, u1 * u1 + v1 * v1)
    f = bump(out, 0.55 * (1.0 - 3.2 * r2), lam, lam, px)
    ident = hash_unit(floor(u - u0 + 0.5), floor(v - v0 + 0.5), 3)
    gain(out, 1.0 + f * (0.30 * (ident - 0.5) - 1.4 * max(r2 - 0.16, 0.0) * 4.0))
    tint(out, M, m, 0.5 * smoothstep(-0.4, 0.9, c / max(P[i, 18], 1e-9)) * (0.8 + 0.2 * ident))
    grain(out, x, y, z, px, 0.3 * lam, 0.008)
    out[LOST] = min(out[LOST], 0.02)


@njit(**JIT)
def chitin(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Legs, heads, antennae: dark, mottled, finely sculptured, reddish where thin."""
    n = noise3(x * 18.0, y * 18.0, z * 18.0) + 0.5 * noise3(x * 55.0, y * 55.0, z * 55.0)
    tint(out, M, m, smoothstep(-0.2, 1.2, n))
    cuticle(out, x, y, z, px, M[m, 9], M[m, 16])


@njit(**JIT)
def striae(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Lengthwise furrows with punctures, a seam, colour drifting from flank to back."""
    lx, ly = (x - P[i, 4]) / P[i, 16], (y - P[i, 5]) / P[i, 17]
    width = sqrt(max(1.0 - ly * ly, 0.04))
    s = min(max(lx / width, -0.999), 0.999)
    angle = np.arcsin(s)
    drift = 0.5 + 0.5 * noise3(x * 3.0, y * 3.0, 0.0)
    tint(out, M, m, smoothstep(0.35, 1.1, abs(s)) * 0.8 + 0.25 * drift)
    count = M[m, 17]
    phase = angle * count / np.pi
    off = abs(phase - floor(phase) - 0.5) * 2.0
    lam = np.pi * P[i, 16] * width / count
    f = fade(lam, px) * (1.0 - smoothstep(0.80, 0.97, abs(s)))
    furrow = smoothstep(0.70, 1.0, off)
    out[HEIGHT] -= f * 0.10 * lam * furrow
    gain(out, 1.0 - 0.45 * f * furrow)
    beads = 0.5 + 0.5 * np.cos(2.0 * np.pi * y / 0.016)
    out[HEIGHT] -= f * fade(0.016, px) * 0.0016 * furrow * beads
    d = abs(x)
    gain(out, 1.0 - 0.6 * (1.0 - smoothstep(0.002, max(0.006, px), d)))
    out[HEIGHT] -= fade(0.012, px) * 0.003 * (1.0 - smoothstep(0.0, 0.006, d))
    cuticle(out, x, y, z, px, M[m, 9], M[m, 16])
