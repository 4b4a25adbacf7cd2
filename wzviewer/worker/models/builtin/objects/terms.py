"""Terms that materials are made of: tints, relief, grain; and the columns of a material's output."""

import numpy as np
from numba import njit

from wzviewer.worker.models.builtin.objects.noise import JIT, fade, noise3

# Columns of a pattern's output; LOST is the slope variance of the terms still hidden.
RED, GREEN, BLUE, ROUGH, HEIGHT, LOST, COAT, THIN, OUTPUTS = range(9)


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
