"""Endless random scenes with exact inverse depth: what the built-in depth network learns from.

    numbers -> primitives (depth_raytrace) -> sprites -> haze, defocus, exposure, noise -> (colour, disparity)

Disparity is 1/z divided by its 95th percentile; sky has none (mask).  No file is read.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from depth_raytrace import BLOTCHES, CHECKER, MATERIAL_COLUMNS, PLAIN, PLANKS, STRIPES, render
from depth_solids import PLANE, PRIM_COLUMNS
from depth_sprites import SHAPES, Canvas, Sprite
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
Generator = np.random.Generator

GREENS = [(0.25, 0.38, 0.12), (0.36, 0.45, 0.16), (0.16, 0.27, 0.10), (0.45, 0.50, 0.22), (0.12, 0.18, 0.08)]
EARTHS = [(0.45, 0.36, 0.25), (0.33, 0.25, 0.17), (0.62, 0.53, 0.40), (0.74, 0.66, 0.52), (0.24, 0.18, 0.13)]
STONES = [(0.5, 0.5, 0.5), (0.36, 0.37, 0.4), (0.66, 0.64, 0.6), (0.86, 0.85, 0.82), (0.2, 0.2, 0.22)]
PAINTS = [(0.75, 0.2, 0.15), (0.9, 0.7, 0.2), (0.2, 0.35, 0.6), (0.95, 0.93, 0.88), (0.75, 0.5, 0.35)]
WATERS = [(0.2, 0.33, 0.4), (0.35, 0.5, 0.55), (0.15, 0.22, 0.27), (0.5, 0.58, 0.62)]
FLOWERS = [(0.95, 0.75, 0.1), (0.9, 0.35, 0.15), (0.85, 0.3, 0.5), (0.95, 0.95, 0.9), (0.55, 0.35, 0.75)]
SKY_TOPS = [(0.25, 0.45, 0.8), (0.4, 0.6, 0.85), (0.6, 0.7, 0.8), (0.75, 0.78, 0.8), (0.5, 0.5, 0.55),
            (0.35, 0.4, 0.5), (0.55, 0.75, 0.75), (0.92, 0.93, 0.95), (0.2, 0.25, 0.45)]  # fmt: skip
SKY_BOTTOMS = [(0.8, 0.87, 0.93), (0.9, 0.9, 0.9), (0.95, 0.8, 0.65), (0.7, 0.78, 0.85), (0.97, 0.95, 0.9)]


@dataclass
class Scene:
    """What one picture is made of; builders fill it."""

    random: Generator
    width: int
    height: int
    focal: float = 200.0
    eye: tuple[float, float, float] = (0.0, 1.6, 0.0)
    pitch_deg: float = 0.0
    sky: bool = True
    backdrop: float = 0.1  # disparity of what is seen where nothing is, without a sky
    haze: float = 0.0  # distance at which the air takes over; 0 = clear
    defocus: float = 0.0
    focus: float = -1.0  # disparity in focus; negative = the nearest thing
    span: float = 0.0
    relief: FloatArray = field(default_factory=lambda: np.zeros((2, 2), np.float32))
    relief_material: int = 0
    point_light: tuple[float, float, float] | None = None
    prims: list[list[float]] = field(default_factory=list)
    materials: list[list[float]] = field(default_factory=list)
    sprites: list[Callable[[Canvas], None]] = field(default_factory=list)

    def uniform(self, low: float, high: float) -> float:
        """A uniform number."""
        return float(self.random.uniform(low, high))

    def log_uniform(self, low: float, high: float) -> float:
        """A number whose logarithm is uniform."""
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def maybe(self, chance: float) -> bool:
        """True with this chance."""
        return bool(self.random.random() < chance)

    def color(self, palette: list[tuple[float, float, float]]) -> FloatArray:
        """A jittered palette colour, darkened or lightened per object; now and then anything at all."""
        if self.maybe(0.12):
            return self.random.uniform(0.05, 0.95, 3).astype(np.float32)
        pick = np.array(palette[self.random.integers(len(palette))])
        pick = pick * self.uniform(0.55, 1.4) + self.random.normal(0, 0.04, 3)
        return np.clip(pick, 0.02, 1.0).astype(np.float32)

    def material(
        self,
        palette: list[tuple[float, float, float]],
        pattern: int = PLAIN,
        size: float = 1.0,
        glow: float = 0.0,
    ) -> int:
        """Adds a material and returns its row; plain ones get a chance pattern that says nothing of depth."""
        if pattern == PLAIN and self.maybe(0.25):
            pattern, size = (
                int(self.random.choice([STRIPES, CHECKER, BLOTCHES, PLANKS])),
                self.log_uniform(0.05, 2),
            )
        base = self.color(palette)
        second = base * self.uniform(0.6, 1.3) + self.random.normal(0, 0.05, 3)
        third = self.color(palette) if self.maybe(0.6) else base * self.uniform(0.3, 1.5)
        contrast = float(self.random.choice([0.15, 0.5, 1.0, 1.8]))
        row = [*base, *np.clip(second, 0, 1), *np.clip(third, 0, 1), self.log_uniform(0.3, 8), contrast]
        self.materials.append([*row, pattern, size, glow, int(self.random.integers(1 << 20))])
        return len(self.materials) - 1

    def add(
        self,
        kind: int,
        center: tuple[float, float, float],
        half: tuple[float, float, float],
        material: int,
        yaw: float = 0.0,
        porous: float = 0.0,
        grain: float = 3.0,
    ) -> None:
        """Adds a primitive; yaw in radians, `porous` the share of its surface that is air."""
        row = [kind, *center, *half, np.cos(yaw), np.sin(yaw), material, porous, grain]
        self.prims.append([float(v) for v in row])

    def ground(
        self, palette: list[tuple[float, float, float]], pattern: int = PLAIN, size: float = 1.0
    ) -> None:
        """An endless floor at height 0."""
        self.add(PLANE, (0, 0, 0), (1, 1, 1), self.material(palette, pattern, size))

    def spot(self, near: float, far: float, spread: float = 0.8) -> tuple[float, float]:
        """A ground position (x, z) inside the view, log-uniform in distance."""
        z = self.log_uniform(near, far)
        return self.uniform(-spread, spread) * z * self.width / self.focal, z

    def project(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """Pixel and depth of a world point."""
        c, s = np.cos(np.radians(self.pitch_deg)), np.sin(np.radians(self.pitch_deg))
        up, ahead = y - self.eye[1], z - self.eye[2]
        depth = c * ahead - s * up
        down = -c * up - s * ahead
        scale_px = self.focal / max(depth, 1e-3)
        return self.width / 2 + (x - self.eye[0]) * scale_px, self.height / 2 + down * scale_px, depth

    def stand(
        self, shape: str, x: float, z: float, tall: float, palette: list[tuple[float, float, float]]
    ) -> None:
        """A flat sprite standing on the ground."""
        u, v, depth = self.project(x, 0.0, z)
        size = self.focal * tall / max(depth, 1e-3)
        if depth < 0.2 or size < 2 or size > 3 * self.height:
            return
        color, top = self.color(palette), self.color(GREENS if shape == "stem" else palette)
        seed = int(self.random.integers(1 << 30))
        sprite = Sprite(u, v, size, 1 / depth, color, top, seed)
        self.sprites.append(lambda canvas: SHAPES[shape](canvas, sprite))


def fractal(
    random: Generator, h: int, w: int, cells: float, stretch: float = 1.0, ridged: bool = False
) -> FloatArray:
    """Fractal noise (h, w) in about [0, 1] from resized random grids."""
    total, amplitude, mass = np.zeros((h, w), np.float32), 1.0, 0.0
    while cells < min(h, w) and amplitude > 0.02:
        rows, columns = (
            max(int(cells * h / max(h, w)) + 3, 3),
            max(int(cells * w / max(h, w) / stretch) + 3, 3),
        )
        layer = cv2.resize(
            random.random((rows, columns)).astype(np.float32), (w, h), interpolation=cv2.INTER_CUBIC
        )
        total += amplitude * (1 - np.abs(2 * layer - 1) if ridged else layer)
        mass, amplitude, cells = mass + amplitude, amplitude * 0.5, cells * 2
    return total / mass


def sky_colors(scene: Scene) -> FloatArray:
    """A graded sky (h, w, 3), often cloudy."""
    h, w, random = scene.height, scene.width, scene.random
    top, bottom = (np.array(p[random.integers(len(p))], np.float32) for p in (SKY_TOPS, SKY_BOTTOMS))
    top = np.clip(top * scene.uniform(0.6, 1.15) + random.normal(0, 0.03, 3), 0, 1)
    ramp = np.linspace(0, 1 / scene.uniform(0.4, 1.0), h, dtype=np.float32)[:, None, None].clip(0, 1)
    sky = top + (bottom - top) * ramp ** scene.uniform(0.5, 2)
    sky = np.broadcast_to(sky, (h, w, 3)).copy()
    if scene.maybe(0.65):
        cloud = fractal(random, h, w, scene.uniform(2, 6), scene.uniform(1, 3))
        edge, soft = scene.uniform(0.35, 0.65), scene.uniform(0.03, 0.25)
        share = np.clip((cloud - edge) / soft, 0, 1)[..., None] * scene.uniform(0.4, 1)
        white = scene.uniform(0.45, 1.0) * (1 - scene.uniform(0, 0.4) * np.clip((cloud - edge) / 0.3, 0, 1))
        sky = sky * (1 - share) + white[..., None] * share
    return sky.astype(np.float32)


def _backdrop(scene: Scene) -> FloatArray:
    h, w, random = scene.height, scene.width, scene.random
    palettes = [GREENS, EARTHS, STONES, WATERS, PAINTS]
    a, b = (scene.color(palettes[random.integers(len(palettes))]) for _ in range(2))
    mix = fractal(random, h, w, scene.uniform(2, 7))[..., None]
    mix = np.clip((mix - 0.5) * 3 + 0.5, 0, 1)
    image = (a * mix + b * (1 - mix)).astype(np.float32)
    return cv2.GaussianBlur(image, (0, 0), scene.uniform(2, 9))


def trace(scene: Scene) -> tuple[FloatArray, FloatArray, BoolArray, BoolArray]:
    """Colour (h, w, 3), 1/z (h, w), the sky mask and what stands, before any camera effect."""
    h, w, random = scene.height, scene.width, scene.random
    color = sky_colors(scene) if scene.sky else _backdrop(scene)
    disparity, upright = np.zeros((2, h, w), np.float32)
    pitch, roll = np.radians(scene.pitch_deg), np.radians(random.normal(0, 2))
    c, s, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    tilt = np.array([[1, 0, 0], [0, -c, -s], [0, -s, c]]) @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    lens = [scene.focal, w / 2 + random.normal(0, 6), h / 2 + random.normal(0, 6)]
    sun = scene.point_light or (random.normal(), scene.uniform(0.3, 2), random.normal() - 0.3)
    light = [*sun, scene.uniform(0.25, 0.85), 1.0 if scene.point_light else 0.0]
    prims = np.array(scene.prims or np.full((0, PRIM_COLUMNS), 0), np.float32).reshape(-1, PRIM_COLUMNS)
    materials = np.array(scene.materials or [[0] * MATERIAL_COLUMNS], np.float32)
    render(prims, materials, scene.relief, float(scene.span), scene.relief_material, tilt.astype(np.float32),
           np.array(scene.eye, np.float32), np.array(lens, np.float32), np.array(light, np.float32),
           color, disparity, upright)  # fmt: skip
    if not scene.sky:
        disparity[disparity == 0] = scene.backdrop
    canvas = Canvas(color, disparity, upright)
    for sprite in scene.sprites:
        sprite(canvas)
    return color, disparity, disparity <= 0, upright > 0.5
