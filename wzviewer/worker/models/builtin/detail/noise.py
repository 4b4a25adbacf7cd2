"""Periodic random fields, the ingredients of every procedural material.

All fields are ``(n, n)`` float32 and tile without a seam.  Sources: fractal noise by spectral synthesis
(Peitgen and Saupe 1988); cellular noise (Worley 1996); ridged multifractal (Musgrave 1994).
"""

import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numba import njit

from wzviewer.core.types import FloatArray, IntArray


def normalized(field: FloatArray) -> FloatArray:
    """Returns the field with mean 0 and standard deviation 1."""
    return ((field - field.mean()) / (field.std() + 1e-6)).astype(np.float32)


def fractal(
    n: int, slope: float, rng: np.random.Generator, stretch: float = 1.0, lowest: float = 0.0
) -> FloatArray:
    """Returns spectral noise with power ``|f|^(-2 slope)``.

    Args:
        n: side in px.
        slope: amplitude falls by this exponent; 0 is white, 2 is clouds.
        rng: source of randomness.
        stretch: below 1 the features become longer along x by its inverse.
        lowest: cycles per tile below which there is nothing.
    """
    fx = np.fft.rfftfreq(n, 1 / n).astype(np.float32)[None] / stretch
    fy = np.fft.fftfreq(n, 1 / n).astype(np.float32)[:, None]
    radius = np.hypot(fx, fy)
    radius[0, 0] = 1
    gain = radius**-slope * (radius >= max(lowest, 0.5))
    gain[0, 0] = 0
    spectrum = np.fft.rfft2(rng.standard_normal((n, n), np.float32)) * gain
    return normalized(np.fft.irfft2(spectrum, s=(n, n)).astype(np.float32))


def wrapped(field: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Returns the periodic field sampled at float pixel positions, bilinear."""
    return cv2.remap(
        field, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
    )


def warped(field: FloatArray, amount_px: float, rng: np.random.Generator, slope: float = 1.6) -> FloatArray:
    """Returns the field displaced by a smooth random vector field of the given RMS in px."""
    n = len(field)
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    dx, dy = (amount_px * _enlarged_wrapped(fractal(n // 4, slope, rng, lowest=3)) for _ in range(2))
    return wrapped(field, (x + dx) % n, (y + dy) % n)


def _enlarged_wrapped(field: FloatArray) -> FloatArray:
    """Enlarges by four on the torus: smooth fields need no more."""
    padded = np.pad(field, 4, mode="wrap")
    return cv2.resize(padded, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC)[16:-16, 16:-16]


def periodic_blur(field: FloatArray, sigma: float) -> FloatArray:
    """Returns the Gaussian blur on the torus."""
    pad = min(math.ceil(4 * sigma), len(field))
    padded = np.pad(field, pad, mode="wrap")
    return cv2.GaussianBlur(padded, (0, 0), sigma)[pad:-pad, pad:-pad]


def shaded(height: FloatArray, light_deg: float = 126.0) -> FloatArray:
    """Returns the relief lit from the upper left, about -1..1: what makes a tile look photographed."""
    grad_x = 0.5 * (np.roll(height, -1, 1) - np.roll(height, 1, 1))
    grad_y = 0.5 * (np.roll(height, -1, 0) - np.roll(height, 1, 0))
    light = math.radians(light_deg)
    slope = grad_x * math.cos(light) - grad_y * math.sin(light)
    return (slope / np.sqrt(1 + grad_x * grad_x + grad_y * grad_y)).astype(np.float32)


def ridged(
    n: int, octaves: int, base_cells: int, rng: np.random.Generator, stretch: float = 1.0
) -> FloatArray:
    """Returns a ridged multifractal: sharp crests, smooth valleys, detail mostly on the crests."""
    total, weight = np.zeros((n, n), np.float32), np.ones((n, n), np.float32)
    for octave in range(octaves):
        cells = base_cells * 2**octave
        layer = banded(n, cells, rng, stretch)
        crest = (1 - np.minimum(np.abs(layer) * 0.8, 1)) ** 2
        total += crest * weight * 0.6**octave
        weight = np.clip(crest * 1.6, 0, 1)
    return normalized(total)


def banded(n: int, cells: float, rng: np.random.Generator, stretch: float = 1.0) -> FloatArray:
    """Returns noise of one size: about ``cells`` waves per tile."""
    noise = fractal(n, 0.0, rng)
    radius_x = np.fft.rfftfreq(n, 1 / n).astype(np.float32)[None] / stretch
    radius_y = np.fft.fftfreq(n, 1 / n).astype(np.float32)[:, None]
    gain = np.exp(-((np.hypot(radius_x, radius_y) / cells - 1) ** 2) / 0.18)
    return normalized(np.fft.irfft2(np.fft.rfft2(noise) * gain, s=(n, n)).astype(np.float32))


def cellular(
    n: int, cells: int, rng: np.random.Generator, stretch: float = 1.0
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Returns the distances in px to the nearest two of scattered points, and the nearest's index.

    Args:
        n: side in px.
        cells: points per side; one jittered point per grid cell.
        rng: source of randomness.
        stretch: above 1 the cells become taller than wide.
    """
    columns, rows = max(cells, 3), max(round(cells / stretch), 3)
    points = rng.uniform(0.08, 0.92, (rows, columns, 2)).astype(np.float32)  # so that 3x3 cells suffice
    return _cellular(n, points)


@njit(cache=True, nogil=True)
def _cellular(n: int, points: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    rows, columns = points.shape[0], points.shape[1]
    size_x, size_y = n / columns, n / rows
    first = np.empty((n, n), np.float32)
    second = np.empty((n, n), np.float32)
    index = np.empty((n, n), np.int32)
    for y in range(n):
        cell_y = int(y / size_y)
        for x in range(n):
            cell_x = int(x / size_x)
            best, next_best, nearest = 1e9, 1e9, 0
            for j in range(cell_y - 1, cell_y + 2):
                for i in range(cell_x - 1, cell_x + 2):
                    point = points[j % rows, i % columns]
                    dx = (i + point[0]) * size_x - x
                    dy = (j + point[1]) * size_y - y
                    distance = dx * dx + dy * dy
                    if distance < best:
                        next_best, best, nearest = best, distance, (j % rows) * columns + i % columns
                    elif distance < next_best:
                        next_best = distance
            first[y, x], second[y, x], index[y, x] = math.sqrt(best), math.sqrt(next_best), nearest
    return first, second, index


Stamp = Callable[[FloatArray, FloatArray], tuple[Any, Any]]
"""From coordinates in px, along and across a form, to its height and how far it covers what lies below."""


def stamped(
    field: FloatArray, count: int, reach_px: int, stamp: Stamp, rng: np.random.Generator
) -> FloatArray:
    """Returns the field with forms laid over it, turned at random, the later ones over the earlier.

    Args:
        field: ``(n, n)`` periodic.
        count: how many.
        reach_px: no form goes farther from its centre.
        stamp: draws one.
        rng: source of randomness.
    """
    n = len(field)
    result = field.copy()
    span = np.arange(-reach_px, reach_px + 1)
    for x, y, angle in rng.uniform((0, 0, 0), (n, n, 2 * math.pi), (count, 3)):
        rows, columns = (np.mod(int(c) + span, n) for c in (y, x))
        dx, dy = (span - (x % 1))[None].astype(np.float32), (span - (y % 1))[:, None].astype(np.float32)
        c, s = math.cos(angle), math.sin(angle)
        height, cover = stamp(c * dx + s * dy, c * dy - s * dx)
        place = np.ix_(rows, columns)
        result[place] += (cover * (height - result[place])).astype(np.float32)
    return result


def drawn_wrapped(canvas: FloatArray, points: list[tuple[float, float]], tone: float, width: int) -> None:
    """Draws a line, or with width 0 a filled polygon, on the torus, which is drawn at twice its size."""
    n, path = len(canvas), 2 * np.array(points)
    low, high = np.floor(path.min(0) / n).astype(int), np.floor((path.max(0) + 1) / n).astype(int)
    for row in range(low[1], high[1] + 1):
        for column in range(low[0], high[0] + 1):
            moved = np.round((path - (n * column, n * row)) * 16).astype(np.int32)
            if width:
                cv2.polylines(canvas, [moved], False, tone, width, shift=4)
            else:
                cv2.fillPoly(canvas, [moved], tone, shift=4)
