"""Flat things of the training scenes: depth-tested polygons with a little shading and texture."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]


@dataclass
class Canvas:
    """Colour (h, w, 3), disparity and what stands (h, w) while sprites are pasted, nearest wins."""

    color: FloatArray
    disparity: FloatArray
    upright: FloatArray
    rough: float = 0.3

    def paste(
        self, polygons: list[FloatArray], disparity: float, color: FloatArray, dome: float = 0.0
    ) -> None:
        """Fills polygons (k, 2) px with a top-down shaded colour where nothing nearer stands."""
        h, w = self.disparity.shape
        everything = np.concatenate(polygons)
        low = np.maximum(np.floor(everything.min(0)).astype(int), 0)
        high = np.minimum(np.ceil(everything.max(0)).astype(int) + 1, [w, h])
        if (high <= low).any():
            return
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), np.uint8)
        cv2.fillPoly(mask, [np.round((p - low) * 8).astype(np.int32) for p in polygons], 1, shift=3)
        here = (slice(low[1], high[1]), slice(low[0], high[0]))
        rise = cv2.distanceTransform(mask, cv2.DIST_L2, 3) if dome > 0 else np.zeros(mask.shape, np.float32)
        depth_here = disparity * (1 + dome * rise / (rise.max() + 1e-6))
        front = (mask > 0) & (depth_here > self.disparity[here])
        ramp = np.linspace(1.15, 0.75, mask.shape[0], dtype=np.float32)[:, None, None]
        ramp = ramp * (1 + self.rough * _grain(mask.shape, int(everything.sum())))[..., None]
        self.color[here][front] = (color * ramp)[front]
        self.disparity[here][front] = depth_here[front]
        self.upright[here][front] = 1.0


_GRAINS = np.random.default_rng(5).random((4, 96, 96)).astype(np.float32) - 0.5


def _grain(shape: tuple[int, ...], seed: int) -> FloatArray:
    """(h, w) texture in [-1, 1] of a cell size that the seed picks."""
    tile, cells = _GRAINS[seed % 4], 4 + seed % 23
    part = tile[:cells, :cells]
    return 2 * cv2.resize(part, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR)


def _wobbly(
    u: float, v: float, rx: float, ry: float, seed: int, rough: float = 0.2, turn: float = 0.0
) -> FloatArray:
    random = np.random.default_rng(seed)
    a = np.linspace(0, 2 * np.pi, 28, endpoint=False)
    radius = 1 + rough * sum(
        random.normal() / k * np.cos(k * a + random.uniform(0, 6.3)) for k in (2, 3, 5, 7)
    )
    x, y = rx * radius * np.cos(a), ry * radius * np.sin(a)
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([u + c * x - s * y, v + s * x + c * y], 1).astype(np.float32)


def _blade(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, _, seed = sprite
    random = np.random.default_rng(seed)
    bend, width = random.normal(0, 0.3) * size, max(0.03 * size, 0.7)
    shape = [[u - width, v], [u + width, v], [u + bend * 0.4 + width, v - 0.6 * size], [u + bend, v - size]]
    canvas.paste([np.array(shape, np.float32)], disparity, color)


def _flower(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    _blade(canvas, sprite._replace(color=top * 0.7))
    head = size * random.uniform(0.12, 0.3)
    petals = int(random.integers(5, 14))
    turn = random.uniform(0, 6.3)
    squash = random.uniform(0.5, 1)
    for k in range(petals):
        a = turn + 2 * np.pi * k / petals
        at = (u + 0.6 * head * np.cos(a), v - size + 0.6 * head * squash * np.sin(a))
        petal = _wobbly(*at, 0.5 * head, 0.25 * head, seed + k, 0.05, a)
        canvas.paste([petal], disparity * 1.01, color * random.uniform(0.8, 1.1))
    heart = _wobbly(u, v - size, 0.35 * head, 0.35 * head * squash, seed, 0.05)
    canvas.paste([heart], disparity * 1.02, top * random.uniform(0.3, 1.0))
    if random.random() < 0.6:
        leaf = _wobbly(u + 0.15 * size, v - 0.4 * size, 0.2 * size, 0.08 * size, seed, 0.1, random.normal())
        canvas.paste([leaf], disparity * 0.99, top)


def _person(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, top, seed = sprite
    w = 0.13 * size
    legs = np.array(
        [[u - w, v], [u - w, v - 0.5 * size], [u + w, v - 0.5 * size], [u + 0.8 * w, v]], np.float32
    )
    canvas.paste([legs], disparity, color * 0.6)
    canvas.paste([_wobbly(u, v - 0.66 * size, 1.2 * w, 0.2 * size, seed, 0.06)], disparity, top)
    canvas.paste([_wobbly(u, v - 0.92 * size, 0.6 * w, 0.08 * size, seed, 0.03)], disparity, color)


def _animal(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, top, seed = sprite
    side = 1 if seed % 2 else -1
    for k in (-0.5, -0.35, 0.35, 0.5):
        x = u + k * size
        leg = [[x - 0.05 * size, v], [x - 0.05 * size, v - 0.5 * size], [x + 0.05 * size, v - 0.5 * size],
               [x + 0.04 * size, v]]  # fmt: skip
        canvas.paste([np.array(leg, np.float32)], disparity, color * 0.7)
    canvas.paste([_wobbly(u, v - 0.6 * size, 0.65 * size, 0.28 * size, seed, 0.08)], disparity, color, 0.02)
    head = _wobbly(u + side * 0.75 * size, v - 0.8 * size, 0.2 * size, 0.16 * size, seed, 0.1)
    canvas.paste([head], disparity, top * 0.8)


def _blob(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, _, seed = sprite
    random = np.random.default_rng(seed)
    body = _wobbly(
        u, v, size, size * random.uniform(0.4, 1.2), seed, random.uniform(0.05, 0.35), random.normal()
    )
    canvas.paste([body], disparity, color, random.uniform(0, 0.25))


def _bloom(canvas: Canvas, sprite: "Sprite") -> None:
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    petals, squash, turn = int(random.integers(5, 16)), random.uniform(0.45, 1), random.uniform(0, 6.3)
    stem = np.array(
        [[u - 0.05 * size, v], [u + 0.05 * size, v], [u + random.normal() * size, v + 3 * size]], np.float32
    )
    canvas.paste([stem], disparity * 0.95, top)
    for k in range(petals):
        a = turn + 2 * np.pi * k / petals
        at = (u + 0.55 * size * np.cos(a), v + 0.55 * size * squash * np.sin(a))
        petal = _wobbly(
            *at,
            0.5 * size,
            random.uniform(0.15, 0.3) * size,
            seed + k,
            0.08,
            np.arctan2(squash * np.sin(a), np.cos(a)),
        )
        near = disparity * (1 + 0.06 * squash * np.sin(a))
        canvas.paste([petal], near, color * random.uniform(0.6, 1.15), 0.02)
    canvas.paste(
        [_wobbly(u, v, 0.3 * size, 0.3 * size * squash, seed, 0.05)], disparity * 1.08, top * 0.6, 0.06
    )


def _robed(canvas: Canvas, sprite: "Sprite") -> None:
    """A figure in a long coat."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    foot, shoulder = random.uniform(0.1, 0.2) * size, random.uniform(0.08, 0.13) * size
    coat = [[u - foot, v], [u - shoulder, v - 0.8 * size], [u + shoulder, v - 0.8 * size], [u + foot, v]]
    canvas.paste([np.array(coat, np.float32)], disparity, color)
    arm = _wobbly(u + shoulder, v - 0.6 * size, 0.05 * size, 0.2 * size, seed, 0.05, random.normal() * 0.3)
    canvas.paste([arm], disparity * 1.001, color * 0.85)
    canvas.paste([_wobbly(u, v - 0.89 * size, 0.07 * size, 0.1 * size, seed, 0.04)], disparity, top)


def _pole(canvas: Canvas, sprite: "Sprite") -> None:
    """A thin upright with something at its top."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    w = max(random.uniform(0.006, 0.03) * size, 0.6)
    lean = random.normal() * 0.02 * size
    post = [[u - w, v], [u - w + lean, v - size], [u + w + lean, v - size], [u + w, v]]
    canvas.paste([np.array(post, np.float32)], disparity, color)
    if random.random() < 0.5:
        sign = _wobbly(u + lean, v - size, 5 * w, random.uniform(2, 6) * w, seed, 0.05)
        canvas.paste([sign], disparity * 1.001, top)


def _shrub(canvas: Canvas, sprite: "Sprite") -> None:
    """A heap of leaf clusters on the ground: a bush or a whole tree, every part upright."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    stalk = random.uniform(0, 0.4) * size
    if stalk > 0.1 * size:
        trunk = [[u - 0.03 * size, v], [u - 0.02 * size, v - stalk - 0.1 * size],
                 [u + 0.02 * size, v - stalk - 0.1 * size], [u + 0.03 * size, v]]  # fmt: skip
        canvas.paste([np.array(trunk, np.float32)], disparity, color * 0.5)
    wide = random.uniform(0.25, 0.55) * size
    for k in range(int(random.integers(8, 26))):
        a, r = random.uniform(0, 6.3), np.sqrt(random.random())
        high = 0.5 * (size - stalk)
        at = (u + wide * r * np.cos(a), v - stalk - high + high * r * np.sin(a))
        part = _wobbly(*at, 0.3 * wide, 0.3 * wide, seed + k, 0.35)
        shade = random.uniform(0.5, 1.2) * (1.2 - 0.4 * (at[1] - v + size) / size)
        canvas.paste([part], disparity * (1 + 0.01 * random.random()), (color if k % 3 else top) * shade)


def _branch(canvas: Canvas, sprite: "Sprite") -> None:
    """Leaves hanging into the picture from its top or a side; (u, v) is where it begins."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    turn = np.arctan2(canvas.disparity.shape[0] / 2 - v, canvas.disparity.shape[1] / 2 - u)
    turn += random.normal() * 0.5
    leaf = random.uniform(0.03, 0.12) * size
    for k in range(int(random.integers(30, 140))):
        t = random.random() ** 0.7
        side = random.normal() * 0.3 * size * (1.1 - t)
        at = (
            u + t * size * np.cos(turn) - side * np.sin(turn),
            v + t * size * np.sin(turn) + side * np.cos(turn),
        )
        blade = _wobbly(*at, leaf, leaf * random.uniform(0.3, 0.9), seed + k, 0.2, random.uniform(0, 6.3))
        canvas.paste(
            [blade],
            disparity * random.uniform(0.95, 1.05),
            (color if k % 2 else top) * random.uniform(0.5, 1.2),
        )


def _daisy(canvas: Canvas, sprite: "Sprite") -> None:
    """A large flower of many petals in one or two rings, on a stem, with leaves; one thing in depth."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    squash, turn, tilt = random.uniform(0.35, 1), random.uniform(0, 6.3), random.normal() * 0.3
    bend = random.normal() * size
    stem = [[u - 0.06 * size, v], [u + 0.06 * size, v], [u + bend + 0.08 * size, v + 5 * size],
            [u + bend - 0.08 * size, v + 5 * size]]  # fmt: skip
    canvas.paste([np.array(stem, np.float32)], disparity * 0.97, top)
    for k in range(int(random.integers(0, 4))):
        at = (u + bend * 0.4 + random.normal() * 0.4 * size, v + random.uniform(1.2, 4) * size)
        leaf = _wobbly(*at, random.uniform(0.4, 1.2) * size, random.uniform(0.12, 0.35) * size, seed + k, 0.1,
                       random.normal())  # fmt: skip
        canvas.paste([leaf], disparity * 0.97, top * random.uniform(0.6, 1.2), 0.01)
    for ring in range(int(random.integers(1, 3))):
        petals, narrow = int(random.integers(8, 30)), random.uniform(0.06, 0.16)
        for k in range(petals):
            a = turn + 2 * np.pi * (k + 0.5 * ring + 0.2 * random.normal()) / petals
            long = random.uniform(0.75, 1.05) * (1 - 0.2 * ring)
            x, y = np.cos(a), squash * np.sin(a) + tilt * np.cos(a) * 0.3
            at = (u + 0.6 * size * long * x, v + 0.6 * size * long * y)
            reach = 0.45 * size * long * np.hypot(x, y)
            petal = _wobbly(*at, reach, narrow * size, seed + k, 0.04, np.arctan2(y, x))
            canvas.paste([petal], disparity * (1 + 0.02 * ring + 0.05 * y), color * random.uniform(0.7, 1.1))
    heart = random.uniform(0.2, 0.5) * size
    canvas.paste([_wobbly(u, v, heart, heart * max(squash, 0.5), seed, 0.04)], disparity * 1.06,
                 top * random.uniform(0.4, 1.2), 0.04)  # fmt: skip


def _wheel(canvas: Canvas, sprite: "Sprite") -> None:
    """A ring with spokes standing on the ground: the holes show what is behind."""
    u, v, size, disparity, color, top, seed = sprite
    random = np.random.default_rng(seed)
    r, squash = 0.5 * size, random.uniform(0.4, 1)
    a = np.linspace(0, 2 * np.pi, 40)
    outer = np.stack([u + squash * r * np.cos(a), v - r + r * np.sin(a)], 1)
    inner = np.stack([u + 0.86 * squash * r * np.cos(a), v - r + 0.86 * r * np.sin(a)], 1)
    canvas.paste([outer.astype(np.float32), inner.astype(np.float32)], disparity, color * 0.6)
    for _ in range(int(random.integers(4, 14))):
        b = random.uniform(0, 6.3)
        x, y, w = squash * r * np.cos(b), r * np.sin(b), max(0.008 * size, 0.5)
        spoke = [[u - w, v - r], [u + x, v - r + y], [u + w, v - r]]
        canvas.paste([np.array(spoke, np.float32)], disparity * 0.999, top)


class Sprite(NamedTuple):
    """A flat thing: foot or middle (px), size (px), disparity, two colours, seed."""

    u: float
    v: float
    size: float
    disparity: float
    color: FloatArray
    top: FloatArray
    seed: int


SHAPES: dict[str, Callable[[Canvas, Sprite], None]] = {
    "stem": _blade, "flower": _flower, "person": _person, "animal": _animal, "blob": _blob, "bloom": _bloom,
    "robed": _robed, "pole": _pole, "shrub": _shrub, "branch": _branch, "daisy": _daisy, "wheel": _wheel,
}  # fmt: skip
