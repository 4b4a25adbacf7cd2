"""The tiles: one procedural texture per isotropic material, seamless, a millimetre of the world each.

A tile is luminance seen in raking light, not a height map: zero mean, unit deviation.  Sizes of features are
chosen for an enlargement by eight, which can add only what is finer than about 16 px.
"""

import math
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.endings import ENDING_MAKERS
from wzviewer.worker.models.builtin.detail.matter import MATTER_MAKERS
from wzviewer.worker.models.builtin.detail.measures import area_down
from wzviewer.worker.models.builtin.detail.noise import (
    cellular,
    drawn_wrapped,
    fractal,
    normalized,
    periodic_blur,
    ridged,
    shaded,
    stamped,
    warped,
)

TileMaker = Callable[[int, np.random.Generator], FloatArray]


def foliage(n: int, rng: np.random.Generator) -> FloatArray:
    """A tree's leaves from afar, a few px each, in clumps: nearer ones hide others and are lighter.

    Leaves larger than a coarse pixel would be taken back by consistency, all but their outlines.
    """
    clumps = fractal(n, 1.5, rng, lowest=10)
    count = n * n // 13
    nearness = iter(np.linspace(-1.0, 1.0, count))

    def leaf(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        length, width, near = rng.uniform(3.2, 6.2), rng.uniform(1.4, 2.8), next(nearness)
        side = np.abs(v) / (width * np.clip(1 - np.square(u / length), 0, 1) ** 0.8 + 0.05)
        own = 0.7 * near + rng.normal(0, 0.55)
        rib = 0.25 * np.exp(-np.square(v / 0.6)) - 0.3 * np.sign(v) * np.minimum(np.abs(v), 1)
        return own + rib - 0.3 * side, np.clip(2.0 * (1.05 - side), 0, 1) * (np.abs(u) < length)

    tone = stamped(np.full((n, n), -1.5, np.float32), count, 7, leaf, rng)
    return normalized(periodic_blur(tone + 0.4 * clumps, 0.5))


def venation(n: int, rng: np.random.Generator) -> FloatArray:
    """The net of veins in a leaf or petal: three hierarchies of cell borders, raised and lit."""
    height = 0.35 * fractal(n, 1.6, rng, lowest=10)
    for cells, width, weight in ((n // 84, 4.5, 1.0), (n // 34, 2.6, 0.7), (n // 14, 1.5, 0.45)):
        first, second, _ = cellular(n, cells, rng)
        vein = np.exp(-(((second - first) / width) ** 2))
        height += weight * warped(vein, 5.0, rng)
    return normalized(0.35 * height + 1.5 * shaded(2.2 * height) + 0.1 * fractal(n, 0.9, rng, lowest=40))


def cell(n: int, rng: np.random.Generator) -> FloatArray:
    """Plant cells: pale rounded rooms of differing tone in darker walls, with a kernel and with beads."""
    first, second, index = cellular(n, n // 22, rng)
    count = index.max() + 1
    wall = np.minimum((second - first) / 3.2, 1)
    tone = rng.normal(0, 0.24, count).astype(np.float32)[index]
    own = rng.uniform(1.8, 3.4, count).astype(np.float32)[index]
    kernel = np.clip(own + 0.5 - first, 0, 1) * (0.55 - 1.1 * np.exp(-np.square(first / (0.4 * own))))
    bead, _, grain = cellular(n, n // 5, rng)
    along = np.exp(-np.square((second - first - 6.0) / 3.0))
    beads = along * np.clip(2.2 - bead, 0, 1) * (rng.random(grain.max() + 1) < 0.6)[grain]
    height = warped((wall - 0.02 * first - 0.7 * kernel - 0.5 * beads).astype(np.float32), 2.0, rng)
    return normalized(
        height + warped(tone, 2.0, rng) + 0.5 * shaded(2 * height) + 0.1 * fractal(n, 1.2, rng, lowest=12)
    )


def cornea(n: int, rng: np.random.Generator) -> FloatArray:
    """A wet skin of flat cells, paved close: pale thin borders, hardly a tone of their own, no relief."""
    first, second, index = cellular(n, n // 13, rng)
    border = np.exp(-np.square((second - first) / 1.5)).astype(np.float32)
    tone = rng.normal(0, 0.22, index.max() + 1).astype(np.float32)[index]
    flat = warped(border + tone - 0.02 * first, 1.5, rng)
    return normalized(periodic_blur(flat, 0.5) + 0.15 * fractal(n, 1.4, rng, lowest=10))


def floret(n: int, rng: np.random.Generator) -> FloatArray:
    """The velvet of a flower's disc: papillae packed close, each a small lit dome, in soft swellings."""
    height = 1.2 * fractal(n, 1.6, rng, lowest=14)
    for cells, weight in ((n // 9, 1.0), (n // 6, 0.5)):
        first, _, index = cellular(n, cells, rng)
        tall = rng.uniform(0.5, 1.2, index.max() + 1).astype(np.float32)[index]
        height += weight * tall * np.sqrt(np.clip(1 - np.square(first / (0.62 * n / cells)), 0, 1))
    height = warped(height, 1.5, rng)
    return normalized(periodic_blur(0.4 * height + 1.2 * shaded(1.6 * height), 0.6))


def granite(n: int, rng: np.random.Generator) -> FloatArray:
    """Crystals of two sizes: a tone each, dark borders, straight twins in some, and dark specks."""
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    total = np.zeros((n, n), np.float32)
    for cells, weight, width in ((n // 20, 1.0, 1.5), (n // 10, 0.45, 1.0)):
        first, second, index = cellular(n, cells, rng, stretch=rng.uniform(0.8, 1.25))
        count = index.max() + 1
        tone = rng.choice([-1.0, -0.2, 0.3, 1.0], count, p=[0.2, 0.3, 0.3, 0.2]) + rng.normal(0, 0.2, count)
        angle = rng.uniform(0, math.pi, count)
        turns = np.round(n / rng.uniform(4, 9, count) * np.stack([np.cos(angle), np.sin(angle)]))
        twin = np.sin(2 * math.pi / n * (turns[0][index] * x + turns[1][index] * y))
        striped = (rng.random(count) < 0.35)[index] * np.tanh(2 * twin)
        border = np.exp(-np.square((second - first) / width))
        total += weight * warped((tone[index] + 0.3 * striped - 1.1 * border).astype(np.float32), 0.8, rng)
    distance, _, index = cellular(n, n // 16, rng)
    radius = np.maximum(rng.normal(-0.5, 2.2, index.max() + 1), 0).astype(np.float32)[index]  # most are none
    return normalized(periodic_blur(total, 0.5) - 1.3 * np.clip(radius - distance, 0, 1))


def grit(n: int, rng: np.random.Generator) -> FloatArray:
    """Plaster near: grains of sand of many sizes, some angular, half sunk in a chalky ground with pits."""
    ground = 0.35 * fractal(n, 1.1, rng, lowest=n / 30) + 0.3 * ridged(n, 3, n // 40, rng)

    def grain(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size, corners, turn = 1.5 + 6.0 * rng.random() ** 2, rng.integers(3, 7), rng.uniform(0, 6.3)
        angle = np.arctan2(v, u)
        radius = np.hypot(u, v) / (size * (1 + 0.12 * np.cos(corners * angle + turn)))
        facet = 0.12 * np.round(1.5 * np.cos(angle + turn)) * radius
        height = rng.normal(0.5, 0.7) + 0.9 * np.sqrt(np.clip(1 - radius**2, 0, 1)) + facet
        return height, np.clip(5 * (1.02 - radius), 0, 1)

    height = stamped(ground.astype(np.float32), n * n // 160, 8, grain, rng)
    return normalized(periodic_blur(0.7 * height + 1.2 * shaded(1.3 * height), 0.5))


def rock(n: int, rng: np.random.Generator) -> FloatArray:
    """Broken stone: facets of all sizes, each lit by its own tilt, weathered by a fine grain."""
    total = 0.5 * fractal(n, 0.9, rng, lowest=20)
    for cells, weight in ((n // 26, 0.7), (n // 14, 0.8), (n // 8, 0.6)):
        first, second, index = cellular(n, cells, rng, stretch=1.4)
        tilt = rng.normal(0, 1, index.max() + 1).astype(np.float32)[index]
        edge = shaded(0.7 * np.minimum(second - first, 3))
        some = (rng.random(index.max() + 1) < 0.6).astype(np.float32)[index]  # the rest lies flat
        total += weight * warped(some * tilt + 0.5 * edge, 2.5, rng, slope=1.2)
    rough = ridged(n, 3, n // 40, rng)
    return normalized(periodic_blur(total + 0.6 * shaded(1.2 * rough), 0.5))


def stone(n: int, rng: np.random.Generator) -> FloatArray:
    """Weathered stone near: a pitted, ridged relief in raking light, with grains of other minerals in it."""
    height = 0.8 * ridged(n, 3, n // 46, rng) + fractal(n, 1.4, rng, lowest=12)
    pits, _, index = cellular(n, n // 18, rng)
    deep = np.maximum(rng.normal(-0.3, 1.0, index.max() + 1), 0).astype(np.float32)[index]
    height = warped((height - 1.4 * deep * np.exp(-np.square(pits / 4.0))).astype(np.float32), 3.0, rng)
    first, second, index = cellular(n, n // 12, rng, stretch=1.2)
    tone = rng.choice([0.0, 1.0, -1.0], index.max() + 1, p=[0.7, 0.18, 0.12]).astype(np.float32)[index]
    mineral = warped(tone * np.minimum((second - first) / 2, 1), 1.5, rng)
    return normalized(periodic_blur(1.3 * shaded(1.1 * height) + 0.25 * height + 0.55 * mineral, 0.5))


def sand(n: int, rng: np.random.Generator) -> FloatArray:
    """Grains of uneven size, each a small lit dome with its own tone, some fallen together."""
    total = np.zeros((n, n), np.float32)
    for cells, radius, weight in ((n // 13, 10.0, 0.8), (n // 8, 6.5, 0.8)):
        first, _, index = cellular(n, cells, rng)
        size = rng.uniform(0.5, 1.1, index.max() + 1).astype(np.float32)[index] * radius
        tone = rng.normal(0, 0.45, index.max() + 1).astype(np.float32)[index]
        dome = np.sqrt(np.maximum(1 - (first / size) ** 2, 0))
        total += weight * warped(
            1.6 * shaded(2.5 * dome) + tone * np.minimum(2 * dome, 1), 3.0, rng, slope=1.2
        )
    return normalized(periodic_blur(total, 0.6) + 0.4 * fractal(n, 0.9, rng, lowest=12))


def skin(n: int, rng: np.random.Generator) -> FloatArray:
    """Skin or leather: small plates between creases, with pores, lit."""
    first, second, _ = cellular(n, n // 17, rng)
    crease = np.minimum((second - first) / 5.0, 1) ** 0.7
    pores, _, _ = cellular(n, n // 40, rng)
    height = (
        warped(crease, 3.0, rng)
        - 0.8 * np.exp(-((pores / 2.2) ** 2))
        + 0.25 * fractal(n, 1.5, rng, lowest=10)
    )
    return normalized(shaded(1.6 * height) + 0.25 * height)


def plaster(n: int, rng: np.random.Generator) -> FloatArray:
    """Plaster, paper, paint: a shallow grain in raking light."""
    height: FloatArray = fractal(n, 1.1, rng, lowest=16) + np.float32(0.5) * ridged(n, 3, n // 26, rng)
    return normalized(shaded(1.2 * height) + 0.08 * height)


def ripple(n: int, rng: np.random.Generator) -> FloatArray:
    """Water: crossing wavelets, flattened like perspective flattens them."""
    swell = 0.5 * fractal(n, 1.7, rng, stretch=0.45, lowest=8)
    height = (ridged(n, 3, n // 70, rng, stretch=0.4) + swell).astype(np.float32)
    return normalized(periodic_blur(shaded(2.2 * height, 100.0) + 0.2 * height, 0.8))


def interlaced(n: int, pitch_px: int) -> tuple[FloatArray, FloatArray, Callable[[FloatArray], FloatArray]]:
    """A plain weave: where each pixel lies across and along the thread on top, in widths from its middle.

    Args:
        n: edge of the tile, px.
        pitch_px: width of a thread.

    Returns:
        Two ``(n, n)``, and what spreads a number of each thread, ``(2, n / pitch)``, over its pixels.
    """
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    column, row = (x // pitch_px).astype(int), (y // pitch_px).astype(int)
    middle = 0.5 - 0.5 / pitch_px
    u, v = x / pitch_px - column - middle, y / pitch_px - row - middle
    warp_on_top = (column + row) % 2 == 0

    def of_threads(values: FloatArray) -> FloatArray:
        return np.where(warp_on_top, values[0][column], values[1][row])

    return np.where(warp_on_top, u, v), np.where(warp_on_top, v, u), of_threads


def weave(n: int, rng: np.random.Generator) -> FloatArray:
    """Cloth: plain weave of threads 8 px wide, of uneven tone, with the twist of their yarn."""
    across, along, of_threads = interlaced(n, 8)
    thread = np.sqrt(np.clip(1 - (1.9 * across) ** 2, 0, 1)) * (0.7 + 0.5 * np.cos(math.pi * along))
    twist = 0.1 * np.sin(2 * math.pi * (along + 0.8 * across) * 4)
    tones = rng.normal(0, 0.1, (2, n // 8)).astype(np.float32)
    height = (thread + twist + of_threads(tones)).astype(np.float32)
    lit = height + 0.5 * shaded(2 * periodic_blur(height, 0.7))
    return normalized(warped(lit.astype(np.float32), 1.8, rng) + 0.15 * fractal(n, 0.6, rng, lowest=30))


def yarn(n: int, rng: np.random.Generator) -> FloatArray:
    """Cloth near: twisted threads 16 px wide, over and under each other, their fibres and some that stray."""
    across, along, of_threads = interlaced(n, 16)
    thread = np.sqrt(np.clip(1 - (1.9 * across) ** 2, 0, 1)) * (0.75 + 0.4 * np.cos(math.pi * along))
    phase = rng.uniform(0, 6.3, (2, n // 16)).astype(np.float32)
    bent = of_threads(phase) + 1.5 * fractal(n, 1.2, rng, lowest=n / 20)
    fibres = np.sin(2 * math.pi * 3 * (along + 1.1 * across) + bent)
    strays = np.zeros((2 * n, 2 * n), np.float32)
    for _ in range(n * n // 2200):
        start, angle = rng.uniform(0, n, 2), rng.uniform(0, 2 * math.pi)
        bends = angle + np.cumsum(rng.normal(0, 0.25, 6))
        path = start + np.cumsum(5 * np.stack([np.cos(bends), np.sin(bends)], 1), 0)
        drawn_wrapped(strays, [tuple(place) for place in path], 1.0, 1)
    height = (thread + 0.22 * fibres * (thread > 0.2)).astype(np.float32) + 0.5 * area_down(strays, n, n)
    lit = warped((height + 0.6 * shaded(2 * periodic_blur(height, 0.6))).astype(np.float32), 2.5, rng)
    return normalized(lit + 0.1 * fractal(n, 0.6, rng, lowest=30))


def scales(n: int, rng: np.random.Generator) -> FloatArray:
    """Overlapping scales in offset rows, the upper over the lower, each with its own tone and a dark rim."""
    size = 16
    canvas = np.zeros((n, n), np.float32)
    for row in range(n // size + 1, -2, -1):
        shift = size // 2 if row % 2 else 0
        for column in range(-1, n // size + 1):
            tone = 0.5 + 0.4 * math.sin(12.9898 * (column % (n // size)) + 78.233 * (row % (n // size)))
            centre = (column * size + shift, row * size)
            for radius, shade in (
                (12, -0.7),
                (11, 0.25 * tone),
                (8, 0.25 * tone + 0.25),
                (4, 0.25 * tone + 0.4),
            ):
                cv2.circle(canvas, centre, radius, shade, -1, cv2.LINE_AA)
    return normalized(warped(periodic_blur(canvas, 0.8), 2.5, rng) + 0.1 * fractal(n, 0.6, rng, lowest=30))


def facet(n: int, rng: np.random.Generator) -> FloatArray:
    """Cleaved crystal: planes with a tone each, sharp steps between, and straight terraces on them."""
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    total = np.zeros((n, n), np.float32)
    for cells, weight in ((n // 30, 1.0), (n // 15, 0.7), (n // 8, 0.4)):
        first, second, index = cellular(n, cells, rng, stretch=1.8)
        tilt = rng.normal(0, 1, index.max() + 1).astype(np.float32)[index]
        step = np.exp(-np.square((second - first) / 1.2))
        angle = rng.uniform(0, 2 * math.pi, index.max() + 1)
        waves = np.round(n / 11 * np.stack([np.cos(angle), np.sin(angle)]))  # whole, or the tile had a seam
        phase = (waves[0][index] * x + waves[1][index] * y) / n
        terraces = (phase - np.floor(phase)) * (rng.random(index.max() + 1) < 0.5)[index]  # half are plain
        total += weight * (0.7 * tilt - 0.8 * step + 0.45 * terraces).astype(np.float32)
    return normalized(periodic_blur(warped(total, 0.7, rng, slope=1.2), 0.6))


def plankton(n: int, rng: np.random.Generator) -> FloatArray:
    """Water very near: a few motes adrift, some clear and some pale, small chains and rings among them."""
    ground = 0.08 * fractal(n, 1.4, rng, lowest=10)

    def mote(u: FloatArray, v: FloatArray) -> tuple[Any, Any]:
        size, kind = 0.8 + 4.5 * rng.random() ** 3, rng.random()
        radius = np.hypot(u, v)
        if kind < 0.12:
            beads = np.exp(-np.square(np.mod(u + 1.6, 3.2) - 1.6) - np.square(v)) * (np.abs(u) < 9)
            return 1.5, beads
        soft = np.clip((size - radius) / (0.4 + 0.5 * kind * size) + 0.4, 0, 1)
        ring = np.exp(-np.square(radius - size)) if size > 2.4 and kind < 0.5 else 0.0
        return rng.uniform(0.8, 1.8) * (1.3 - 0.6 * kind), np.maximum(0.6 * soft, ring)

    return normalized(stamped(ground.astype(np.float32), n * n // 620, 10, mote, rng))


def polish(n: int, rng: np.random.Generator) -> FloatArray:
    """A polished surface: hairlines in all directions over a faint unevenness."""
    lines = np.zeros((2 * n, 2 * n), np.float32)
    for _ in range(n * n // 400):
        x, y, angle, length = rng.uniform((0, 0, 0, 30), (n, n, math.pi, 110))
        reach = (length * math.cos(angle), length * math.sin(angle))
        drawn_wrapped(lines, [(x, y), (x + reach[0], y + reach[1])], rng.normal(0, 1), 1)
    hairs = normalized(warped(area_down(lines, n, n), 3.0, rng))
    return normalized(hairs + 0.8 * fractal(n, 1.2, rng, lowest=20))


def cast(n: int, rng: np.random.Generator) -> FloatArray:
    """Cast metal, worn to a soft gloss: low bumps and pits that shine, and hairlines here and there."""
    height = 0.7 * fractal(n, 2.2, rng, lowest=12)
    for cells, width, weight in ((n // 17, 5.0, 1.0), (n // 11, 3.4, 0.5)):
        first, _, index = cellular(n, cells, rng)
        own = rng.normal(0, 0.8, index.max() + 1).astype(np.float32)[index]
        height += weight * warped((own * np.exp(-np.square(first / width))).astype(np.float32), 2.0, rng)
    scratches = np.zeros((2 * n, 2 * n), np.float32)
    for _ in range(n * n // 4000):
        x, y, angle, length = rng.uniform((0, 0, 0, 20), (n, n, math.pi, 90))
        end = (x + length * math.cos(angle), y + length * math.sin(angle))
        drawn_wrapped(scratches, [(x, y), end], rng.normal(0, 1), 1)
    lit = normalized(shaded(1.6 * periodic_blur(height, 0.8)))
    gloss = np.clip(lit - 0.9, 0, 2.5) ** 2
    return normalized(periodic_blur(0.5 * lit + gloss, 0.5) + 1.1 * area_down(scratches, n, n))


def alloy(n: int, rng: np.random.Generator) -> FloatArray:
    """Metal or glaze, etched: straight-sided grains, each with its own tone, and fine dark borders."""
    first, second, index = cellular(n, n // 18, rng)
    tone = rng.normal(0, 0.8, index.max() + 1).astype(np.float32)[index]
    border = np.exp(-np.square((second - first) / 1.1)).astype(np.float32)
    return normalized(periodic_blur(tone - 1.4 * border, 0.6) + 0.1 * fractal(n, 0.9, rng, lowest=30))


def droplet(n: int, rng: np.random.Generator) -> FloatArray:
    """Mist: little balls of water, each with a light above, a glow below and a thin dark rim."""
    total = 0.2 * fractal(n, 1.4, rng, lowest=8)
    for cells, radius in ((n // 34, 8.0), (n // 20, 4.6), (n // 12, 2.6)):
        first, _, index = cellular(n, cells, rng)
        own = rng.random(index.max() + 1).astype(np.float32)
        size = (radius * (0.55 + 0.6 * own))[index]
        inside = np.clip(1 - np.square(first / size), 0, 1)
        rim = np.exp(-np.square((first - size) / 0.9))
        total += (own < 0.45)[index] * (0.9 * shaded(3.0 * inside) + 1.3 * np.sqrt(inside) - 0.5 * rim)
    return normalized(periodic_blur(total.astype(np.float32), 0.5))


def frost(n: int, rng: np.random.Generator) -> FloatArray:
    """Ice in the air: six-sided plates over each other, with bright rims and a star within."""
    canvas = np.zeros((2 * n, 2 * n), np.float32)
    for _ in range(n * n // 420):
        x, y, radius, turn = rng.uniform((0, 0, 4, 0), (n, n, 13, math.pi / 3))
        tone = rng.normal(0, 0.5)
        spokes = [turn + k * math.pi / 3 for k in range(6)]
        corners = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in spokes]
        drawn_wrapped(canvas, corners, tone, 0)
        drawn_wrapped(canvas, [*corners, corners[0]], tone + 1.2, 2)
        for corner in corners[:3]:
            drawn_wrapped(canvas, [corner, (2 * x - corner[0], 2 * y - corner[1])], tone + 0.4, 2)
    return normalized(periodic_blur(area_down(canvas, n, n), 0.5))


TILE_MAKERS: dict[str, TileMaker] = {
    "foliage": foliage,
    "venation": venation,
    "cell": cell,
    "floret": floret,
    "cornea": cornea,
    "granite": granite,
    "rock": rock,
    "sand": sand,
    "stone": stone,
    "grit": grit,
    "skin": skin,
    "plaster": plaster,
    "ripple": ripple,
    "weave": weave,
    "yarn": yarn,
    "scales": scales,
    "facet": facet,
    "plankton": plankton,
    "polish": polish,
    "cast": cast,
    "alloy": alloy,
    "droplet": droplet,
    "frost": frost,
    **MATTER_MAKERS,
    **ENDING_MAKERS,
}
