"""The tiles of the last levels, a family each: what lived, stone, metal and water do not end alike.

What lived ends in twisted chains, stone in rows of two kinds of atoms and the clouds about them, metal in
waves of its electrons, water in cages of its bent molecules; all of them in what binds a nucleus.  The tiles
are made like those of `matter`.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import area_down
from wzviewer.worker.models.builtin.detail.noise import (
    banded,
    cellular,
    drawn_wrapped,
    fractal,
    normalized,
    periodic_blur,
    shaded,
    stamped,
    warped,
)

TURN_PX, COIL_PX = 15.0, 4.2
"""Of a double helix: length of a turn, and how far its strands are from its axis."""
SALT_PX, ICE_PX, SHELL_PX = 7.5, 13.0, 18.0
"""From one to the next of what lies in rows."""


def helix(n: int, rng: np.random.Generator) -> FloatArray:
    """Twisted chains: two strands about each other, rungs between them; the near ones are lighter."""
    canvas = np.full((2 * n, 2 * n), -0.6, np.float32)
    for depth in np.linspace(0.3, 1.0, n * n // 1400):
        x, y, heading, phase = rng.uniform((0, 0, 0, 0), (n, n, 2 * math.pi, TURN_PX))
        bends = heading + np.cumsum(rng.normal(0, 0.045, 64))
        axis = np.array([x, y]) + np.cumsum(1.6 * np.stack([np.cos(bends), np.sin(bends)], 1), 0)
        _draw_helix(canvas, axis, bends, 2 * math.pi * (phase + 1.6 * np.arange(64)) / TURN_PX, float(depth))
    lit = periodic_blur(area_down(canvas, n, n), 0.5)
    return normalized(lit + 0.4 * shaded(2.2 * lit))


def _draw_helix(
    canvas: FloatArray, axis: FloatArray, bends: FloatArray, turn: FloatArray, tone: float
) -> None:
    """Draws rungs, then what of both strands is behind, then what is before."""
    side = np.stack([-np.sin(bends), np.cos(bends)], 1)
    first, second = (axis + COIL_PX * np.sin(turn + shift)[:, None] * side for shift in (0, 0.75 * math.pi))
    for step in range(0, len(axis), 2):
        drawn_wrapped(canvas, [tuple(first[step]), tuple(second[step])], 0.35 * tone, 2)
    for is_near in (False, True):
        for strand, shift in ((first, 0.0), (second, 0.75 * math.pi)):
            near = np.cos(turn + shift)
            for step in range(len(axis) - 1):
                if (near[step] > 0) == is_near:
                    shade = tone * (0.75 + 0.6 * float(near[step]))
                    drawn_wrapped(canvas, [tuple(strand[step]), tuple(strand[step + 1])], shade, 4)


def _grained(
    n: int, grains: int, rng: np.random.Generator, rows: Callable[[FloatArray, FloatArray], FloatArray]
) -> FloatArray:
    """Returns rows that are turned another way in every grain; ``rows`` of coordinates in px."""
    _, _, index = cellular(n, max(grains, 3), rng)
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    height = np.zeros((n, n), np.float32)
    for grain in np.unique(index):
        inside = index == grain
        row, column = np.argwhere(inside)[0]
        u, v = (np.mod(c[inside] - o + n / 2, n) - n / 2 for c, o in ((x, column), (y, row)))
        angle = rng.uniform(0, 2 * math.pi)
        c, s = math.cos(angle), math.sin(angle)
        u, v = u + 1.0 * np.sin(v / 29 + angle), v + 1.0 * np.sin(u / 33)
        height[inside] = rows(c * u + s * v, c * v - s * u)
    return height


def salt(n: int, rng: np.random.Generator) -> FloatArray:
    """Great and small atoms by turns in squares, in blocks with steps between, some places empty."""
    table = rng.normal(0, 0.12, 4096) - 1.1 * (rng.random(4096) < 0.015)

    def rows(u: FloatArray, v: FloatArray) -> FloatArray:
        column, row = np.floor(u / SALT_PX), np.floor(v / SALT_PX)
        radius = np.hypot(u / SALT_PX - column - 0.5, v / SALT_PX - row - 0.5)
        great = np.mod(column + row, 2)
        dome = np.sqrt(np.clip(1 - np.square(radius / (0.3 + 0.3 * great)), 0, 1))
        own = table[np.mod(131 * row + column, 4096).astype(int)]
        step = 0.5 * np.floor(2 * np.sin(0.021 * u) + 2 * np.sin(0.013 * v))
        return np.asarray(dome * (0.8 + 0.5 * great + own) + step, np.float32)

    height = _grained(n, n // 190, rng, rows)
    return normalized(periodic_blur(height + 0.6 * shaded(2.5 * periodic_blur(height, 0.7)), 0.5))


def shell(n: int, rng: np.random.Generator) -> FloatArray:
    """Clouds of electrons in rows: four leaves about every kernel, and a halo that neighbours share."""

    def rows(u: FloatArray, v: FloatArray) -> FloatArray:
        column, row = np.floor(u / SHELL_PX), np.floor(v / SHELL_PX)
        a, b = u - SHELL_PX * (column + 0.5), v - SHELL_PX * (row + 0.5)
        radius, odd = np.hypot(a, b), np.mod(column + row, 2)
        leaves = np.abs((a * a - b * b) * (1 - odd) + 2 * a * b * odd) / 16 * np.exp(-np.square(radius / 4.6))
        ring = np.exp(-np.square((radius - 8.6) / 1.3))
        return np.asarray(1.2 * leaves + 0.8 * np.exp(-np.square(radius / 1.3)) + 0.35 * ring, np.float32)

    height = _grained(n, n // 220, rng, rows)
    return normalized(periodic_blur(height, 0.5) + 0.15 * fractal(n, 1.6, rng, lowest=n / 40))


def sea(n: int, rng: np.random.Generator) -> FloatArray:
    """The electrons of a metal: waves that run out from every flaw and along steps, and cross."""
    flaws = np.zeros((n, n), np.float32)
    row, column = rng.integers(0, n, (2, n * n // 2600))
    flaws[row, column] = 1.0
    radius = np.hypot(np.fft.rfftfreq(n, 1 / n)[None], np.fft.fftfreq(n, 1 / n)[:, None])
    narrow = np.exp(-np.square((radius / (n / 9.0) - 1) / 0.09))
    spectrum = np.fft.rfft2(flaws) * narrow
    waves = normalized(np.fft.irfft2(spectrum, s=(n, n)).astype(np.float32))
    pits = periodic_blur(flaws, 1.8)
    step = warped(banded(n, n / 150, rng), 3.0, rng)
    along = np.cos(14 * step) * np.exp(-np.square(step / 0.5)) + 0.8 * np.tanh(9 * step)
    return normalized(np.tanh(0.8 * waves) + 0.7 * along - 2.5 * pits / pits.max())


def ice(n: int, rng: np.random.Generator) -> FloatArray:
    """Cages of water: rings of six, an atom at every corner, bonds between; here and there one is broken."""
    table = rng.random(4096)

    def rows(u: FloatArray, v: FloatArray) -> FloatArray:
        k = 4 * math.pi / (math.sqrt(3) * ICE_PX)
        ways = [(math.cos(a), math.sin(a)) for a in (0, 2 * math.pi / 3, 4 * math.pi / 3)]
        total = sum(np.cos(k * (x * u + y * v)) for x, y in ways)
        atoms, bonds = np.exp(-(total + 1.5) / 0.12), np.exp(-np.square((total + 1.1) / 0.3))
        own = table[np.mod(131 * np.floor(v / 5) + np.floor(u / 5), 4096).astype(int)]
        filled = np.exp(-np.square((3 - total) / 0.9)) * (own > 0.93)
        return np.asarray(1.2 * atoms + 0.55 * bonds + filled, np.float32)

    height = warped(_grained(n, n // 150, rng, rows), 2.2, rng)
    lit = height * np.clip(1 + 0.35 * fractal(n, 1.6, rng, lowest=6), 0.2, 2)
    return normalized(periodic_blur(lit + 0.4 * shaded(2.0 * lit), 0.5))


def dipole(n: int, rng: np.random.Generator) -> FloatArray:
    """Molecules of water: a great ball with two small ones at an angle, tumbling over each other."""

    def bent(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size, near = rng.uniform(0.75, 1.15), rng.uniform(0.2, 1.0)
        height, cover = np.zeros_like(u + v), np.zeros_like(u + v)
        for x, y, radius, tone in ((0.0, 0.0, 4.0, 0.6), (2.7, 3.0, 2.4, 1.5), (2.7, -3.0, 2.4, 1.5)):
            away = np.hypot(u - size * x, v - size * y) / (size * radius)
            seen = np.clip(4 * (1.02 - away), 0, 1)
            height = height * (1 - seen) + seen * (
                tone * near + 0.9 * np.sqrt(np.clip(1 - away**2, 0, 1)) - 0.6
            )
            cover = np.maximum(cover, seen)
        return height, cover

    ground = -0.8 + 0.2 * fractal(n, 1.2, rng, lowest=n / 24)
    height = stamped(ground.astype(np.float32), n * n // 150, 9, bent, rng)
    return normalized(periodic_blur(height + 0.5 * shaded(1.4 * height), 0.5))


def strings(n: int, rng: np.random.Generator) -> FloatArray:
    """What binds a nucleus: three lights, tubes of glow from each to where they meet, a seething dark."""
    canvas = np.zeros((2 * n, 2 * n), np.float32)
    lights = np.zeros((2 * n, 2 * n), np.float32)
    for _ in range(n * n // 700):
        x, y, turn, tone = rng.uniform((0, 0, 0, 0.4), (n, n, 2 * math.pi, 1.1))
        for arm in range(3):
            angle, reach = turn + arm * 2.1 + rng.normal(0, 0.3), rng.uniform(6, 12)
            along = np.linspace(0, 1, 9)
            sway = 1.6 * np.sin(math.pi * along * rng.uniform(1.5, 3.5)) * rng.choice([-1, 1])
            path = np.stack(
                [
                    x + reach * along * math.cos(angle) - sway * math.sin(angle),
                    y + reach * along * math.sin(angle) + sway * math.cos(angle),
                ],
                1,
            )
            drawn_wrapped(canvas, [tuple(place) for place in path], tone, 4)
            drawn_wrapped(lights, [tuple(path[-1]), (path[-1][0] + 0.1, path[-1][1])], 1.2 * tone, 9)
    tubes = area_down(canvas, n, n)
    glow = periodic_blur(tubes, 0.7) + 1.5 * periodic_blur(tubes, 2.5)
    return normalized(glow + 2.2 * periodic_blur(area_down(lights, n, n), 0.9) + 0.2 * banded(n, n / 7, rng))


ENDING_MAKERS: dict[str, Callable[[int, np.random.Generator], FloatArray]] = {
    "helix": helix,
    "salt": salt,
    "shell": shell,
    "sea": sea,
    "ice": ice,
    "dipole": dipole,
    "strings": strings,
}
