"""Terms that materials are made of: tints, relief, grain; and the columns of a material's output."""

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, fade, noise3, smoothstep

# Columns of a pattern's output; LOST is the slope variance of the terms still hidden,
# OPAQUE the share of light that a thin sheet stops.
RED, GREEN, BLUE, ROUGH, HEIGHT, LOST, COAT, THIN, OPAQUE, OUTPUTS = range(10)

MARKS, MARK, LAST_MARK = 32, 12, 8  # columns of a material's painted marks


@njit(**JIT)
def tint(out: np.ndarray, M: np.ndarray, m: int, share: float) -> None:
    """Mixes the second albedo over the colour."""
    for c in range(3):
        out[c] += share * (M[m, 4 + c] - out[c])


@njit(**JIT)
def gain(out: np.ndarray, factor: float) -> None:
    """Multiplies the colour."""
    for c in range(3):
        out[c] *= factor


@njit(**JIT)
def bump(out: np.ndarray, height: float, amplitude: float, wavelength: float, px: float) -> float:
    """Adds a relief term of a wavelength, faded; its slopes go to LOST where it is hidden."""
    f = fade(wavelength, px)
    out[HEIGHT] += f * amplitude * height
    out[LOST] += (1.0 - f) * 4.0 * (amplitude / wavelength) ** 2
    return f


@njit(**JIT)
def grain(
    out: np.ndarray, x: float, y: float, z: float, px: float, wavelength: float, amplitude: float
) -> None:
    """Adds scale-free noise from a wavelength down to two pixels; amplitude as a share of each wave."""
    total = 0.0
    for octave in range(14):
        f = fade(wavelength, px)
        if f <= 0.0:
            break
        s = 2.0 / wavelength
        n = noise3(x * s + 7.1 * octave, y * s, z * s)
        out[HEIGHT] += f * n * amplitude * wavelength
        total += f * n * 0.55**octave
        wavelength *= 0.5
    out[LOST] += 8.0 * amplitude * amplitude
    gain(out, 1.0 + 0.10 * total)


@njit(**JIT)
def local(P: np.ndarray, i: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Returns an object point in the axes of primitive i."""
    x, y, z = x - P[i, 4], y - P[i, 5], z - P[i, 6]
    return (
        P[i, 7] * x + P[i, 8] * y + P[i, 9] * z,
        P[i, 10] * x + P[i, 11] * y + P[i, 12] * z,
        P[i, 13] * x + P[i, 14] * y + P[i, 15] * z,
    )


@njit(**JIT)
def marks(M: np.ndarray, m: int, x: float, y: float, z: float, px: float, out: np.ndarray) -> None:
    """Paints the material's coloured ellipsoids, mirrored at x = 0, one over the other.

    Columns from `MARKS` on, `MARK` each: used, centre, radii, softness, ragged, colour.
    """
    if M[m, MARKS] < 0.5:
        return
    rag = noise3(x * 14.0, y * 9.0, z * 14.0) + 0.6 * noise3(x * 60.0, y * 25.0, z * 60.0)
    rag += 0.5 * fade(0.006, px) * noise3(x * 330.0, y * 110.0, z * 330.0)
    for k in range(LAST_MARK):
        c = MARKS + MARK * k
        if M[m, c] < 0.5:
            break
        u = (abs(x) - M[m, c + 1]) / M[m, c + 4]
        v = (y - M[m, c + 2]) / M[m, c + 5]
        w = (z - M[m, c + 3]) / M[m, c + 6]
        d = np.sqrt(u * u + v * v + w * w) - 1.0 + M[m, c + 8] * rag
        small = min(M[m, c + 4], min(M[m, c + 5], M[m, c + 6]))
        soft = max(M[m, c + 7], 0.7 * px / small)
        share = 1.0 - smoothstep(-soft, soft, d)
        for e in range(3):
            out[e] += share * (M[m, c + 9 + e] - out[e])
