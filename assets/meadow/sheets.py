"""Sheets of triangles: tubes, blades of grass, leaves."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meadow.world import GRASS, LEAF, WOOD, DoubleArray, FloatArray, Generator


@dataclass
class Mesh:
    """Triangles under construction.

    A vertex holds position, normal, colour, (u, v) and openness to the sky.
    """

    vertices: list[FloatArray] = field(default_factory=list)
    triangles: list[NDArray[np.int32]] = field(default_factory=list)
    materials: list[NDArray[np.int8]] = field(default_factory=list)
    count: int = 0

    def add(
        self,
        points: DoubleArray,
        colors: ArrayLike,
        material: int,
        openness: ArrayLike = 1.0,
        normals: ArrayLike | None = None,
        v_range: tuple[float, float] = (-1.0, 1.0),
    ) -> None:
        """Add `n` sheets, each a grid of `a` by `b` points.

        Args:
            points: (n, a, b, 3).
            colors: Linear RGB, broadcast to the shape of `points`.
            material: A row of `MATERIALS`.
            openness: Broadcast to (n, a, b).
            normals: Broadcast to the shape of `points`; by default from the grid.
            v_range: Values of the second texture coordinate at the two ends of the last grid axis.
        """
        n, a, b, _ = points.shape
        vertices = np.empty((n, a, b, 12), np.float32)
        vertices[..., :3] = points
        vertices[..., 3:6] = _grid_normals(points) if normals is None else normals
        vertices[..., 6:9] = colors
        vertices[..., 9] = np.linspace(0, 1, a)[:, None] + 2.0 * (np.arange(n) % 61)[:, None, None]
        vertices[..., 10] = np.linspace(*v_range, b)
        vertices[..., 11] = openness
        index = (self.count + np.arange(n * a * b, dtype=np.int32)).reshape(n, a, b)
        p, q, r, s = index[:, :-1, :-1], index[:, :-1, 1:], index[:, 1:, :-1], index[:, 1:, 1:]
        triangles = np.stack([np.stack([p, q, s], -1), np.stack([p, s, r], -1)], -2).reshape(-1, 3)
        self.vertices.append(vertices.reshape(-1, 12))
        self.triangles.append(triangles.astype(np.int32))
        self.materials.append(np.full(len(triangles), material, np.int8))
        self.count += n * a * b


def _grid_normals(points: DoubleArray) -> DoubleArray:
    along = np.gradient(points, axis=1)
    across = np.gradient(points, axis=2)
    normal = np.cross(along, across)
    # At a pinched end the grid has no area: borrow the normal of the neighbouring ring.
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal / np.maximum(length, 1e-12)


def frame_about(axis: ArrayLike) -> DoubleArray:
    """Rows: two unit vectors across `axis`, then `axis` itself. Shape (..., 3, 3)."""
    along: DoubleArray = np.asarray(axis, np.float64)
    along = along / np.linalg.norm(along, axis=-1, keepdims=True)
    helper = np.where(np.abs(along[..., 1:2]) < 0.95, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    side = np.cross(helper, along)
    side = side / np.linalg.norm(side, axis=-1, keepdims=True)
    return np.stack([side, np.cross(along, side), along], axis=-2)


def add_tube(mesh: Mesh, line: DoubleArray, radius: ArrayLike, color: ArrayLike, material: int = WOOD,
          openness: ArrayLike = 1.0, sides: int = 8) -> None:  # fmt: skip
    """A tube along `line` (n, 3) with `radius` broadcast to (n,)."""
    frames = frame_about(np.gradient(line, axis=0))
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    ring = np.cos(angle)[:, None] * frames[:, None, 0] + np.sin(angle)[:, None] * frames[:, None, 1]
    reach = np.broadcast_to(np.asarray(radius, np.float64), (len(line),))
    points = line[:, None] + ring * reach[:, None, None]
    shade = np.broadcast_to(np.asarray(openness), (len(line),))[None, :, None]
    mesh.add(points[None], color, material, shade, normals=ring[None])


def add_blades(mesh: Mesh, roots: DoubleArray, height: DoubleArray, half_width: DoubleArray,
               bend: DoubleArray, colors: DoubleArray, rng: Generator, segments: int,
               creased: bool) -> None:  # fmt: skip
    """Grass: each blade rises from its root and leans over in a curve.

    Args:
        mesh: Receives the blades.
        roots: (n, 3).
        height: (n,) length of the blade.
        half_width: (n,).
        bend: (n,) 0 upright, 1 bowed to the horizontal.
        colors: (n, 2, 3) at the foot and at the tip.
        rng: Random source.
        segments: Pieces along the blade.
        creased: Fold the blade along its middle.
    """
    n = len(roots)
    t = np.linspace(0, 1, segments + 1)[None, :]
    heading = rng.uniform(0, 2 * np.pi, n)
    wind = np.stack([np.cos(heading) - 0.35, np.zeros(n), np.sin(heading) + 0.1], -1)
    lift = height[:, None] * (t - 0.42 * bend[:, None] * t**2.4)
    lean = height[:, None] * bend[:, None] * (0.25 * t + 0.6 * t**2)
    middle = roots[:, None] + lift[..., None] * [0, 1, 0] + lean[..., None] * wind[:, None]
    twist = heading[:, None] + np.pi / 2 + rng.normal(0, 0.5, (n, 1)) + rng.normal(0, 0.7, (n, 1)) * t
    side = np.stack([np.cos(twist), np.zeros_like(twist), np.sin(twist)], -1)
    width = half_width[:, None] * (0.65 + 0.9 * t - 0.4 * t**2) * np.sqrt(np.clip(1 - t**2.2, 0, 1))
    v = np.array([-1.0, 0.0, 1.0] if creased else [-1.0, 1.0])
    points = middle[:, :, None] + (side * width[..., None])[:, :, None] * v[:, None]
    if creased:
        points[:, :, 1] -= wind[:, None] * (0.55 * width)[..., None]
    blend = (t**1.2)[..., None]
    color = colors[:, None, 0] * (1 - blend) + colors[:, None, 1] * blend
    shaded = np.clip(0.8 * height, 0.02, 0.20)[:, None]
    openness = 0.13 + 0.87 * np.clip(lift / shaded, 0, 1) ** 1.3
    mesh.add(points, color[:, :, None], GRASS, openness[:, :, None])


def add_leaf(mesh: Mesh, root: ArrayLike, heading: ArrayLike, length: float, half_width: float, droop: float,
          color: ArrayLike, rng: Generator, teeth: float = 0.0, openness: float = 0.85) -> None:  # fmt: skip
    """One broad leaf with a sunken midrib, a wavy rim and, if wished, teeth."""
    t, v = np.meshgrid(np.linspace(0, 1, 44), np.linspace(-1, 1, 25), indexing="ij")
    shape = np.sin(np.pi * t**0.8) ** 0.75 * (0.35 + 0.9 * t) / 1.05 + 0.05 * (1 - t)
    shape = shape * (1 + teeth * (np.abs((t * 7.5) % 1 - 0.5) - 0.25))
    side, _, axis = frame_about(np.asarray(heading, np.float64))
    up = np.cross(axis, side)
    up = up if up[1] > 0 else -up
    phase = rng.uniform(0, 6, 3)
    wave = 0.10 * np.sin(9 * t + phase[0]) * v + 0.07 * np.sin(15 * t + phase[1]) * np.abs(v) ** 2
    lift = length * (0.28 * t - droop * t**2) + half_width * (0.34 * np.abs(v) ** 1.2 + wave) * shape
    lift = lift + half_width * 0.018 * np.cos((t * 1.0 - 0.32 * np.abs(v)) * 62) * shape * np.abs(v)
    points = (
        np.asarray(root) + axis * (length * (t - 0.12 * droop * t**2))[..., None]
        + side * (half_width * v * shape)[..., None] + up * lift[..., None]
    )  # fmt: skip
    mesh.add(points[None], color, LEAF, openness)
