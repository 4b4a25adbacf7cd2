"""The tiles of what no eye sees: from the skin of a leaf and the inside of a cell down to atoms and below.

Like those of `tiles` they are luminance, seamless, and finer than about 16 px; unlike them they are lit as
an electron microscope lights: forms first, little grain.
"""

import itertools
import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import area_down
from wzviewer.worker.models.builtin.detail.noise import (
    banded,
    cellular,
    fractal,
    normalized,
    periodic_blur,
    ridged,
    shaded,
    stamped,
    warped,
)

RING_SPREAD = 0.24  # of the wavelength
MARGIN_PX = 14  # no atom and no bond is longer


def tissue(n: int, rng: np.random.Generator) -> FloatArray:
    """The skin of a leaf: cells like pillows, and stomata, between two orders of veins."""
    veins = np.maximum(1.3 * _veins(n, n // 96, 3.4, 7.0, rng), _veins(n, n // 30, 1.8, 3.0, rng))
    inner, _, index = cellular(n, n // 9, rng)
    full = rng.uniform(0.5, 1.2, index.max() + 1).astype(np.float32)[index]
    pillow = full * np.sqrt(np.clip(1 - np.square(inner / 6.6), 0, 1))

    def stoma(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        radius = np.hypot(u / 5.5, v / 3.6)
        slit = np.exp(-np.square(u / 3.2) - np.square(v / 0.8))
        return 1.1 - 2.4 * slit - 0.7 * radius**4, (radius < 1)

    cells = warped(stamped(pillow.astype(np.float32), n * n // 1600, 7, stoma, rng), 1.5, rng)
    height = cells * (1 - 0.6 * veins.clip(0, 1)) + 0.3 * fractal(n, 1.6, rng, lowest=12)
    lit = 0.3 * height + 1.2 * shaded(1.7 * height)
    return normalized(periodic_blur(lit + 1.1 * veins + 0.45 * shaded(3 * veins), 0.5))


def _veins(n: int, cells: int, half_px: float, bend: float, rng: np.random.Generator) -> FloatArray:
    """Returns ``(n, n)`` in 0..1: a net about so many cells a side, its lines of an even width."""
    first, second, _ = cellular(n, cells, rng)
    apart = second - first
    slope = np.hypot(*(np.roll(apart, -1, axis) - np.roll(apart, 1, axis) for axis in (0, 1))) / 2
    away = warped((apart / np.maximum(slope, 0.35)).astype(np.float32), bend, rng)
    return np.exp(-np.square(away / half_px))


def granule(n: int, rng: np.random.Generator) -> FloatArray:
    """The inside of a cell: beans with folds across them, clear bubbles, and specks in a faint mesh."""
    base = 0.25 * fractal(n, 1.2, rng, lowest=n / 24) - 0.2 * np.abs(banded(n, n / 12, rng))

    def bubble(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size = rng.uniform(2.0, 5.0)
        radius = np.hypot(u, v) / size
        return 0.9 * radius**3 - 0.7 + 0.25 * (u + v) / size, (radius < 1).astype(np.float32)

    def bean(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        length, width = rng.uniform(5.5, 9.0), rng.uniform(3.0, 4.2)
        bent = v + rng.uniform(-0.02, 0.02) * u * u
        radius = (np.abs(u) / length) ** 2.4 + (np.abs(bent) / width) ** 2.4
        folds = 0.5 * np.sin(1.9 * u + 0.6 * np.sin(bent)) * (radius < 0.7)
        rim = np.exp(-np.square((radius - 0.85) / 0.2))
        return rng.uniform(0.4, 1.0) + folds + 0.5 * rim - 0.15 * bent, (radius < 1.1).astype(np.float32)

    def speck(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        inside = (np.hypot(u, v) < 1.3).astype(np.float32)
        return 1.1 * inside, inside

    specks = stamped(base.astype(np.float32), n * n // 170, 3, speck, rng)
    height = stamped(stamped(specks, n * n // 560, 6, bubble, rng), n * n // 620, 11, bean, rng)
    return normalized(periodic_blur(height + 0.7 * shaded(1.2 * height), 0.6))


def membrane(n: int, rng: np.random.Generator) -> FloatArray:
    """Folded membranes, two dark lines each, close together here and with bubbles between them there."""
    wave = warped(banded(n, n / 22, rng), 2.0, rng)
    wave = wave + 0.4 * fractal(n, 1.6, rng, lowest=6)
    lines = np.cos(2 * math.pi * 1.15 * wave).astype(np.float32)
    sharp = np.tanh(1.8 * lines + 0.5)
    packed = np.clip(0.75 + 0.6 * fractal(n, 1.5, rng, lowest=8), 0.15, 1).astype(np.float32)
    first, _, index = cellular(n, n // 15, rng)
    size = (rng.uniform(-8.0, 6.0, index.max() + 1).astype(np.float32))[index]
    ring = np.exp(-np.square((first - size) / 1.1)) * (size > 1.5)
    height = sharp * packed * (1 - (first < size)) + 1.3 * ring
    return normalized(periodic_blur((height + 0.6 * shaded(1.5 * height)).astype(np.float32), 0.6))


def molecule(n: int, rng: np.random.Generator) -> FloatArray:
    """Great molecules: each a lobed ball of knotted chain, lit, crowded over each other in dark water."""

    def knotted(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size, lobes, turn = rng.uniform(3.5, 8.0), rng.integers(2, 5), rng.uniform(0, 6.3)
        radius = np.hypot(u, v) / (size * (1 + 0.14 * np.cos(lobes * np.arctan2(v, u) + turn)))
        chain = np.sin(1.35 * u + turn + 1.1 * np.sin(0.9 * v)) * np.sin(1.25 * v - turn + 1.1 * np.sin(u))
        dome = np.sqrt(np.clip(1 - radius**2, 0, 1))
        height = rng.uniform(0.2, 0.7) + 1.5 * dome + 0.45 * chain * dome + 0.04 * (u - v)
        return height, np.clip(6 * (1.02 - radius), 0, 1)

    water = 0.2 * fractal(n, 1.0, rng, lowest=n / 20)
    height = stamped(water.astype(np.float32), n * n // 110, 10, knotted, rng)
    return normalized(periodic_blur(height + 0.6 * shaded(1.3 * height), 0.5))


def atom(n: int, rng: np.random.Generator) -> FloatArray:
    """Balls and sticks: atoms of three kinds on bonded chains that cross, the near ones lighter."""
    canvas = np.zeros((2 * n, 2 * n), np.float32)
    kinds = ((3.6, 0.9), (3.0, 0.45), (2.1, 1.4))
    for depth in np.linspace(0.35, 1.0, 3):
        for _ in range(n * n // 800):
            _chain(canvas, n, rng, float(depth), kinds)
    lit = periodic_blur(area_down(canvas, n, n), 0.5)
    return normalized(lit + 0.35 * shaded(3.0 * lit))


def _chain(
    canvas: FloatArray,
    n: int,
    rng: np.random.Generator,
    depth: float,
    kinds: tuple[tuple[float, float], ...],
) -> None:
    """Draws one bonded chain with a branch at every other atom."""
    x, y, heading = rng.uniform((0, 0, 0), (n, n, 2 * math.pi))
    bends = heading + np.cumsum(rng.normal(0, 0.35, 6) + 0.9 * np.array([1, -1, 1, -1, 1, -1]))
    steps = 8.0 * np.stack([np.cos(bends), np.sin(bends)], 1)
    spine = np.array([x, y]) + np.cumsum(steps, 0)
    side = spine[1:5] + 7.0 * np.stack([np.cos(bends[1:5] + 1.9), np.sin(bends[1:5] + 1.9)], 1)
    for a, b in [*itertools.pairwise(spine), *zip(spine[1:5], side, strict=True)]:
        for start in _on_torus(a, n):
            _line(canvas, start, start + b - a, 0.4 * depth)
    for centre, kind in zip([*side, *spine], [2] * 4 + list(rng.integers(0, 2, 6)), strict=True):
        for place in _on_torus(centre, n):
            _ball(canvas, place, kinds[kind][0], depth * kinds[kind][1])


def _on_torus(place: np.ndarray, n: int) -> list[np.ndarray]:
    """Returns the place within the tile, and where a form smaller than `MARGIN_PX` comes in again."""
    place = np.mod(place, n)
    sides = [[0, n] if c < MARGIN_PX else [0, -n] if c > n - MARGIN_PX else [0] for c in place]
    return [place + shift for shift in itertools.product(*sides)]


def _line(canvas: FloatArray, start: np.ndarray, end: np.ndarray, tone: float) -> None:
    a, b = (np.round(32 * p).astype(int).tolist() for p in (start, end))
    cv2.line(canvas, a, b, tone, 4, cv2.LINE_8, 4)


def _ball(canvas: FloatArray, centre: np.ndarray, radius: float, tone: float) -> None:
    for share, shade in ((1.0, 0.35), (0.85, 0.75), (0.55, 1.0)):
        place = np.round(32 * (centre - 0.3 * radius * (1 - share))).astype(int).tolist()
        cv2.circle(canvas, place, round(32 * share * radius), tone * shade, -1, cv2.LINE_8, 4)


def lattice(n: int, rng: np.random.Generator) -> FloatArray:
    """Atoms in rows, grain against grain: what a crystal is in the end, as a scanning tip feels it."""
    _, _, index = cellular(n, max(n // 110, 3), rng)
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    height, tone = np.zeros((n, n), np.float32), np.zeros((n, n), np.float32)
    for grain in np.unique(index):
        inside = index == grain
        row, column = np.argwhere(inside)[0]
        place = np.stack([_around(x[inside] - column, n), _around(y[inside] - row, n)])
        height[inside], tone[inside] = _rows_of_atoms(place, rng)
    lit = height * (1 + tone) + 0.7 * shaded(3.0 * periodic_blur(height, 0.7))
    return normalized(periodic_blur(lit.astype(np.float32), 0.5) + 0.2 * fractal(n, 1.6, rng, lowest=n / 40))


def _around(offset: FloatArray, n: int) -> FloatArray:
    """Returns offsets on the torus within half a turn of nothing."""
    return np.mod(offset + n / 2, n) - n / 2


def _rows_of_atoms(place: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Returns height and tone of a hexagonal packing, turned at random, at places ``(2, k)`` in px."""
    angle, pitch = rng.uniform(0, math.pi / 3), 10.5
    across = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]) @ place
    across += 1.2 * np.sin(across[::-1] / 31 + angle)
    line = np.floor(across[1] / (0.866 * pitch))
    column = across[0] / pitch + 0.5 * np.mod(line, 2)
    radius = np.hypot(column - np.floor(column) - 0.5, 0.866 * (across[1] / (0.866 * pitch) - line - 0.5))
    table = rng.normal(0, 0.16, 4096) + 0.7 * (rng.random(4096) < 0.03) - 0.9 * (rng.random(4096) < 0.03)
    tone = table[np.mod(131 * line + np.floor(column), 4096).astype(int)]
    dome = np.sqrt(np.clip(1 - np.square(radius / 0.5), 0, 1))
    return dome.astype(np.float32), tone.astype(np.float32)


def orbital(n: int, rng: np.random.Generator) -> FloatArray:
    """Clouds of electrons: standing waves around every atom, round or lobed, which cross each other."""
    impulses = np.zeros((n, n), np.float32)
    row, column = rng.integers(0, n, (2, n * n // 380))
    impulses[row, column] = rng.choice([-1.0, 1.0], len(row))
    glow = np.abs(impulses)
    lobed = rng.random(len(row)) < 0.5
    away = rng.integers(-4, 5, (2, len(row)))
    impulses[np.mod(row + away[0], n)[lobed], np.mod(column + away[1], n)[lobed]] -= impulses[row, column][
        lobed
    ]
    waves, cores = _ringed(impulses, n / 8.5), periodic_blur(glow, 2.2)
    return normalized(waves + 1.2 * cores / cores.max() + 0.5 * normalized(periodic_blur(glow, 7.0)))


def _ringed(impulses: FloatArray, cycles: float) -> FloatArray:
    """Two or three rings around every impulse: more of them are a target."""
    n = len(impulses)
    radius = np.hypot(np.fft.rfftfreq(n, 1 / n)[None], np.fft.fftfreq(n, 1 / n)[:, None])
    gain = np.exp(-np.square((radius / cycles - 1) / RING_SPREAD))
    return normalized(np.fft.irfft2(np.fft.rfft2(impulses) * gain, s=(n, n)).astype(np.float32))


def nucleus(n: int, rng: np.random.Generator) -> FloatArray:
    """Kernels of atoms: tight handfuls of balls of two kinds, each in a glow, far from each other."""
    empty = 0.25 * fractal(n, 1.6, rng, lowest=n / 40)

    def handful(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        height, cover = (np.exp(-(u * u + v * v) / size**2) for size in (6.5, 6.0))
        for place, tone in zip(rng.normal(0, 2.1, (11, 2)), rng.choice([0.6, 1.5], 11), strict=True):
            ball = np.hypot(u - place[0], v - place[1]) / 2.2
            seen = np.clip(3 * (1 - ball), 0, 1)
            height = height * (1 - seen) + seen * (tone + 0.6 - 0.9 * ball**2)
            cover = np.maximum(cover, seen)
        return height, cover

    return normalized(periodic_blur(stamped(empty.astype(np.float32), n * n // 420, 12, handful, rng), 0.5))


def froth(n: int, rng: np.random.Generator) -> FloatArray:
    """Froth of nothing: bubbles of all sizes, bright where their walls meet."""
    total = np.zeros((n, n), np.float32)
    for cells, width, weight in ((n // 17, 1.8, 1.0), (n // 9, 1.2, 0.6), (n // 5, 0.9, 0.35)):
        first, second, _ = cellular(n, cells, rng)
        some = np.clip(0.6 + 0.8 * fractal(n, 1.2, rng, lowest=8), 0, 1.2)
        wall = np.exp(-np.square((second - first) / width)) + 0.25 * first / (n / cells)
        total += weight * warped((some * wall).astype(np.float32), 1.5, rng)
    return normalized(periodic_blur(total, 0.5))


def caustic(n: int, rng: np.random.Generator) -> FloatArray:
    """Water near: soft swells with glints where they face the light, drawn out flat, in gusts."""
    swell = ridged(n, 3, n // 44, rng, stretch=0.32)
    gust = np.clip(0.7 + 0.8 * fractal(n, 1.6, rng, stretch=0.6), 0.1, 2.2)
    glint = np.clip(swell - 0.9, 0, 3) ** 1.5
    height = warped((gust * (0.5 * swell + 1.1 * glint)).astype(np.float32), 5.0, rng, slope=1.8)
    return normalized(periodic_blur(height + 1.2 * shaded(1.6 * height, 100.0), 0.8))


def air(n: int, rng: np.random.Generator) -> FloatArray:
    """Breaths of mist, so soft that they have no outline."""
    return normalized(periodic_blur(warped(fractal(n, 1.2, rng, lowest=n / 32), 4.0, rng), 2.0))


def haze(n: int, rng: np.random.Generator) -> FloatArray:
    """Droplets adrift in soft light: of all sizes, out of focus and in, few and in swarms."""
    swarms = np.clip(0.4 + 0.7 * fractal(n, 1.8, rng, lowest=4), 0.05, 1.6)
    ground = np.zeros((n, n), np.float32)

    def drop(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size, blur = 0.7 + 3.5 * rng.random() ** 3, rng.uniform(0.3, 1.2)
        disc = np.clip((size - np.hypot(u, v)) / (0.3 + blur * size) + 0.4, 0, 1)
        return rng.uniform(0.7, 1.7) / (0.5 + blur), 0.8 * disc * disc * (3 - 2 * disc)

    return normalized(stamped(ground, n * n // 420, 8, drop, rng) * swarms)


MATTER_MAKERS: dict[str, Callable[[int, np.random.Generator], FloatArray]] = {
    "tissue": tissue,
    "granule": granule,
    "cytoplasm": granule,
    "membrane": membrane,
    "molecule": molecule,
    "atom": atom,
    "lattice": lattice,
    "orbital": orbital,
    "nucleus": nucleus,
    "froth": froth,
    "caustic": caustic,
    "air": air,
    "haze": haze,
}
