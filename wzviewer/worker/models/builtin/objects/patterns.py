"""Materials in object space: colour and relief whose every term fades below two pixels a wave.

A material is a row of `M` (m, 128) float64, albedos linear::

     0 pattern    1:4 albedo    4:7 second albedo    7 roughness    8 metal    9 wavelength
    10 wrap (soft terminator)   11 F0    12 translucency    13 coat    14 sheen    15 coat roughness
    16 relief amplitude         17:28 free, per pattern         28 lets rays through (thin sheets)
    32:128 marks: up to 8 coloured ellipsoids painted on the first albedo, see `terms.marks`

As the pixel shrinks, terms that were sub-pixel appear, so a zoom shows finer structure that was
there all along.  The slope variance of the terms still hidden is returned too: it broadens the
highlights, as the unseen bumps do (Toksvig 2005).
"""

from math import floor, sqrt

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.botany import cap, fibre, florets, gills, leaf, moss, petal, wood
from wzviewer.worker.models.builtin.objects.chitin import chitin, elytra, eye, pronotum, striae
from wzviewer.worker.models.builtin.objects.minerals import crystal, metal, rust, shell
from wzviewer.worker.models.builtin.objects.noise import (
    ENTRY,
    JIT,
    cells3,
    fade,
    hash_unit,
    noise3,
    smoothstep,
)
from wzviewer.worker.models.builtin.objects.primitives import sample
from wzviewer.worker.models.builtin.objects.skins import fin, fish, fur, hide, membrane, plumes, vane
from wzviewer.worker.models.builtin.objects.terms import (
    COAT,
    HEIGHT,
    LOST,
    OPAQUE,
    OUTPUTS,
    ROUGH,
    THIN,
    bump,
    gain,
    grain,
    marks,
    tint,
)

KERNELS = "f1f1f56e"  # digest of the files whose functions are compiled in; a test holds it
PLAIN, ELYTRA, PRONOTUM, EYE, CHITIN, HAIR, WING, STRIAE, PLASTIC, STONE, WATER = range(11)
FUR, FISH, HIDE, PLUMES, VANE, FIN, MEMBRANE, PETAL, LEAF, CAP, GILLS, FIBRE, WOOD = range(11, 24)
FLORETS, MOSS, SHELL, METAL, RUST, CRYSTAL = range(24, 30)
MATERIAL = 128
SHADED = 24  # the columns that shading reads
SHEET = 28


@njit(**JIT)
def _hair(
    P: np.ndarray, i: int, M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray
) -> None:
    """Every hair its own share of the two colours; fibres along it up close."""
    tint(out, M, m, hash_unit(i, 5, 11))
    radius = max(P[i, 25], 1e-6)
    grain(out, x, y, z, px, 1.2 * radius, 0.02)


@njit(**JIT)
def _scales(x: float, y: float, px: float, lam: float, out: np.ndarray) -> float:
    """Adds rows of butterfly scales along the radius from the wing root; returns each one's number."""
    r = sqrt(x * x + y * y) + 1e-6
    warp = 0.35 * noise3(x * 40.0, y * 40.0, 3.0)
    row = r / lam + warp
    k = floor(row)
    # Columns are counted on the circle of the row, in steps that double with the radius.
    across = np.arctan2(y, x) * (2.0 ** floor(np.log2(r / lam + 1.0) + 0.5)) * 1.4 + 0.5 * (k % 2.0)
    column = floor(across)
    u, v = 2.0 * (across - column) - 1.0, row - k
    ident = hash_unit(int(k), int(column), 17)
    f = fade(lam, px)
    tip = smoothstep(0.70, 1.0, v + 0.55 * u * u)
    out[HEIGHT] += f * 0.16 * lam * (v * (1.0 - 0.35 * u * u) - tip)
    out[LOST] += (1.0 - f) * 0.02
    gain(out, 1.0 + f * (0.26 * (ident - 0.5) - 0.30 * tip))
    ribs = fade(0.10 * lam, px)
    if ribs > 0.0:
        wave = np.cos(2.0 * np.pi * 9.0 * u)
        out[HEIGHT] += ribs * 0.004 * lam * wave
        gain(out, 1.0 + ribs * 0.10 * wave)
    return ident


@njit(**JIT)
def _wing(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    x: float,
    y: float,
    z: float,
    px: float,
    T: np.ndarray,
    C: np.ndarray,
    out: np.ndarray,
) -> None:
    """A scaled membrane: veins, dark border, pale dots, all from baked distances, so edges stay crisp."""
    x, y, z = x - P[i, 4], y - P[i, 5], z - P[i, 6]
    a = P[i, 7] * x + P[i, 8] * y + P[i, 9] * z
    b = P[i, 10] * x + P[i, 11] * y + P[i, 12] * z
    size, k = P[i, 16], int(P[i, 28])
    u, v = a / size, b / size
    w = 0.006 * noise3(a * 22.0, b * 22.0, 1.0) + 0.003 * noise3(a * 75.0, b * 75.0, 2.0)
    lam = M[m, 9]
    w += 0.004 * fade(2.0 * lam, px) * noise3(a * 2.0 / lam, b * 2.0 / lam, 9.0)
    inside = -sample(T[k], u, v)
    vein, dots, shade = sample(C[k, 0], u, v), sample(C[k, 1], u, v), sample(C[k, 2], u, v)
    soft = max(0.006, 0.7 * px / size)
    gain(out, 1.0 + 0.16 * noise3(a * 9.0, b * 9.0, 5.0) + 0.08 * noise3(a * 31.0, b * 31.0, 6.0))
    for c in range(3):  # the ground colour pales from the root to the margin
        out[c] *= 1.0 + M[m, 20] * (shade - 0.5) * (0.5, 1.0, 1.5)[c]
    # Scales darken towards the veins and the root; faint rays run outward through every cell.
    gain(
        out, 1.0 - 0.34 * (1.0 - smoothstep(0.0, 0.075, vein)) - 0.30 * (1.0 - smoothstep(0.05, 0.34, shade))
    )
    ray = np.arctan2(b - P[i, 23], a - P[i, 22])
    gain(out, 1.0 + 0.10 * noise3(ray * 38.0, shade * 5.0, 2.5))
    # Rubbed and missing scales, in patches of a few.
    worn = 0.09 * fade(4.0 * lam, px) * noise3(a * 0.5 / lam, b * 0.5 / lam, 3.3)
    gain(out, 1.0 + worn + 0.09 * fade(2.0 * lam, px) * noise3(a / lam, b / lam, 4.1))
    black = 1.0 - smoothstep(-soft, soft, min(vein - M[m, 17], inside - M[m, 18] * (0.7 + 0.6 * shade)) + w)
    tint(out, M, m, black)
    white = M[m, 19] * (1.0 - smoothstep(-soft, soft, dots + 0.7 * w))
    for c in range(3):
        out[c] += white * black * ((0.72, 0.70, 0.66)[c] - out[c])
    # Veins stand out like ribs and the membrane sags between them.
    out[HEIGHT] += fade(0.03, px) * 0.0042 * (1.0 - smoothstep(0.0, M[m, 17] + 0.012, vein))
    out[HEIGHT] += fade(0.08, px) * 0.010 * smoothstep(0.0, 0.16, vein)
    out[THIN] = 1.0 - 0.8 * black
    _scales(a - P[i, 22], b - P[i, 23], px, lam, out)
    grain(out, x, y, z, px, 0.12 * lam, 0.010)


@njit(**JIT)
def _plastic(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Moulded plastic: almost flat, faint flow lines, hair scratches up close."""
    gain(out, 1.0 + 0.03 * noise3(x * 9.0, y * 9.0, z * 9.0))
    out[HEIGHT] += fade(0.2, px) * 0.0006 * noise3(x * 8.0, y * 8.0, z * 8.0)
    scratch = 1.0 - smoothstep(0.0, 0.05, abs(noise3(x * 60.0 + y * 9.0, y * 6.0, z * 40.0)))
    out[HEIGHT] -= fade(0.006, px) * 0.00012 * scratch
    grain(out, x, y, z, px, 0.006, 0.006)


@njit(**JIT)
def _stone(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Speckled rock: bands, mineral grains, pores."""
    band = noise3(x * 3.0 + 1.5 * noise3(x * 2.0, y * 2.0, z * 2.0), y * 3.0, z * 7.0)
    tint(out, M, m, smoothstep(0.0, 0.7, band) * 0.7)
    s = 1.0 / M[m, 9]
    f = fade(M[m, 9], px)
    w = 0.5 * noise3(x * s * 1.1, y * s * 1.1, z * s * 1.1) + 0.3 * noise3(
        x * s * 3.1, y * s * 3.1, z * s * 3.1
    )
    near, _, ident = cells3(x * s + w, y * s - w, z * s + w)
    speck = 1.0 - smoothstep(0.25, 0.65, near)
    gain(out, 1.0 + f * speck * (0.7 * (ident - 0.5) - (0.45 if ident < 0.16 else 0.0)))
    gain(out, 1.0 + 0.18 * noise3(x * 13.0, y * 13.0, z * 13.0))
    for octave in range(4):
        lam = 0.25 * 0.45**octave
        bump(out, noise3(x * 2.0 / lam, y * 2.0 / lam, z * 2.0 / lam), 0.022 * lam, lam, px)
    grain(out, x, y, z, px, 0.01, 0.02)


@njit(**JIT)
def _later(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    m: int,
    kind: int,
    x: float,
    y: float,
    z: float,
    px: float,
    T: np.ndarray,
    C: np.ndarray,
    colored: bool,
    out: np.ndarray,
) -> None:
    """Evaluates the patterns from `FUR` on."""
    if kind == FUR:
        fur(P, i, M, m, x, y, z, px, colored, out)
    elif kind == FISH:
        fish(P, i, M, m, x, y, z, px, T, out)
    elif kind == HIDE:
        hide(P, i, M, m, x, y, z, px, out)
    elif kind == PLUMES:
        plumes(P, i, M, m, x, y, z, px, T, out)
    elif kind == VANE:
        vane(P, i, M, m, x, y, z, px, out)
    elif kind == FIN:
        fin(P, i, M, m, x, y, z, px, out)
    elif kind == MEMBRANE:
        membrane(P, i, M, m, x, y, z, px, C, out)
    elif kind == PETAL:
        petal(P, i, M, m, x, y, z, px, out)
    elif kind == LEAF:
        leaf(P, i, M, m, x, y, z, px, C, out)
    elif kind == CAP:
        cap(P, i, M, m, x, y, z, px, out)
    elif kind == GILLS:
        gills(P, i, M, m, x, y, z, px, out)
    elif kind == FIBRE:
        fibre(P, i, M, m, x, y, z, px, out)
    elif kind == WOOD:
        wood(M, m, x, y, z, px, out)
    elif kind == FLORETS:
        florets(P, i, M, m, x, y, z, px, out)
    elif kind == MOSS:
        moss(M, m, x, y, z, px, out)
    elif kind == SHELL:
        shell(P, i, M, m, x, y, z, px, out)
    elif kind == METAL:
        metal(P, i, M, m, x, y, z, px, C, out)
    elif kind == RUST:
        rust(M, m, x, y, z, px, out)
    else:
        crystal(P, i, M, m, x, y, z, px, out)


@njit(**JIT)
def _pattern(
    P: np.ndarray,
    i: int,
    M: np.ndarray,
    x: float,
    y: float,
    z: float,
    px: float,
    T: np.ndarray,
    C: np.ndarray,
    colored: bool,
    out: np.ndarray,
) -> None:
    """Evaluates the material of primitive i at an object point into out (OUTPUTS,).

    Without `colored` only the relief counts, and what only colours is left out.
    """
    m = int(P[i, 3])
    for c in range(3):
        out[c] = M[m, 1 + c]
    out[ROUGH], out[HEIGHT], out[LOST], out[COAT], out[THIN] = M[m, 7], 0.0, 0.0, 1.0, 1.0
    out[OPAQUE] = 1.0
    kind = int(M[m, 0])
    if colored:
        marks(M, m, x, y, z, px, out)
    if kind >= FUR:
        _later(P, i, M, m, kind, x, y, z, px, T, C, colored, out)
    elif kind == ELYTRA:
        elytra(P, i, M, m, x, y, z, px, colored, out)
    elif kind == PRONOTUM:
        pronotum(P, i, M, m, x, y, z, px, out)
    elif kind == EYE:
        eye(P, i, M, m, x, y, z, px, out)
    elif kind == CHITIN:
        chitin(P, i, M, m, x, y, z, px, out)
    elif kind == HAIR:
        _hair(P, i, M, m, x, y, z, px, out)
    elif kind == WING:
        _wing(P, i, M, m, x, y, z, px, T, C, out)
    elif kind == STRIAE:
        striae(P, i, M, m, x, y, z, px, out)
    elif kind == PLASTIC:
        _plastic(M, m, x, y, z, px, out)
    elif kind == STONE:
        _stone(M, m, x, y, z, px, out)
    elif kind != WATER:
        gain(out, 1.0 + 0.12 * noise3(x * 11.0, y * 11.0, z * 11.0))
        grain(out, x, y, z, px, 0.05, 0.012)


@njit(**ENTRY)
def evaluate(
    P: np.ndarray,
    M: np.ndarray,
    T: np.ndarray,
    C: np.ndarray,
    hit: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    px: float,
    out: np.ndarray,
    bumped: np.ndarray,
) -> None:
    """Evaluates materials at hit points: columns of `out` (n, OUTPUTS), and bumped normals (n, 3).

    The relief's gradient is taken by forward differences of 3/4 px and limited to a slope of 1.2.
    """
    e = 0.75 * px
    tap = np.zeros(OUTPUTS)
    u, v, height = np.zeros(3), np.zeros(3), np.zeros(3)
    for q in range(hit.shape[0]):
        i, n, p = hit[q], normals[q], points[q]
        # Tangents u and v for two taps: u is n turned about the axis that n is farthest from.
        if abs(n[2]) < 0.7:
            u[0], u[1], u[2] = -n[1], n[0], 0.0
        else:
            u[0], u[1], u[2] = 0.0, -n[2], n[1]
        length = sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
        u[0], u[1], u[2] = u[0] / length, u[1] / length, u[2] / length
        v[0], v[1], v[2] = n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]
        for k in range(3):
            s, t = (e if k == 1 else 0.0), (e if k == 2 else 0.0)
            x, y, z = p[0] + s * u[0] + t * v[0], p[1] + s * u[1] + t * v[1], p[2] + s * u[2] + t * v[2]
            _pattern(P, i, M, x, y, z, px, T, C, k == 0, tap)
            height[k] = tap[HEIGHT]
            if k == 0:
                out[q] = tap
        a, b = (height[1] - height[0]) / e, (height[2] - height[0]) / e
        slope = max(sqrt(a * a + b * b), 1e-9)
        limit = min(1.0, 1.2 / slope)
        for c in range(3):
            bumped[q, c] = n[c] - (a * u[c] + b * v[c]) * limit
        length = sqrt(bumped[q, 0] ** 2 + bumped[q, 1] ** 2 + bumped[q, 2] ** 2)
        for c in range(3):
            bumped[q, c] /= length
