"""Paint the bundled picture: a meadow with a flower near, trees and hills far, and its true depth.

    plants, stones, hills            camera                  sun
    -> sheets of triangles  -> visibility buffer   +   two shadow maps
                                     |
                           shade every sample (shadow, occlusion, translucency, haze)
                                     |
       clouds marched per pixel  ->  mean of the samples, tone curve  ->  meadow.png
                                     depth of the surface that most samples see  ->  meadow_depth.npz

Run `python assets/make_meadow.py`. Axes of the world: x right, y up, z away from the camera.
"""

import argparse
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numba import njit, prange
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float32]
DoubleArray = NDArray[np.float64]
Generator = np.random.Generator

WIDTH, HEIGHT, FOCAL_PX = 1088, 720, 1024.0
SKY_DEPTH = 36.7
EYE_HEIGHT = 0.70
PITCH = np.radians(5.0)  # the camera looks this far down
SUN = np.array([0.85, 0.45, -0.16]) / np.linalg.norm([0.85, 0.45, -0.16])
NEAR, FAR = 0.80, 58.0

GROUND, GRASS, PETAL, FLORET, LEAF, FOLIAGE, WOOD, STONE = range(8)
# Ranges of hills: distance, reach along the view, least height, noise seed,
# peaks (x / z, height, width in x / z).
RANGES = (
    (27.0, 6.0, 0.25, 21.0, ((0.24, 0.9, 0.12), (-0.42, 1.1, 0.14))),
    (38.0, 5.5, 0.7, 33.0, ((0.44, 3.0, 0.17), (-0.10, 2.0, 0.12), (-0.55, 2.6, 0.14))),
    (51.0, 6.0, 1.8, 47.0, ((0.07, 3.6, 0.13), (0.24, 2.6, 0.10), (0.54, 4.2, 0.16), (-0.33, 3.6, 0.16))),
)
# Columns: share of light that passes through, strength and exponent of the highlight,
# wrap of the diffuse term.
MATERIALS = np.array(
    [
        [0.00, 0.00, 8.0, 0.10],
        [0.42, 0.16, 24.0, 0.10],
        [0.40, 0.03, 14.0, 0.04],
        [0.15, 0.05, 16.0, 0.20],
        [0.30, 0.14, 22.0, 0.10],
        [0.30, 0.02, 12.0, 0.25],
        [0.08, 0.04, 12.0, 0.10],
        [0.00, 0.05, 18.0, 0.05],
    ],
    dtype=np.float32,
)


# ---------------------------------------------------------------- noise
@njit(nogil=True)  # no cache on disk: this file runs both as a script and as a module
def _hash(x: int, y: int, z: int) -> float:
    n = np.uint32(x) * np.uint32(0x8DA6B343) ^ np.uint32(y) * np.uint32(0xD8163841)
    n ^= np.uint32(z) * np.uint32(0xCB1AB31F)
    n = (n ^ (n >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    n = (n ^ (n >> np.uint32(12))) * np.uint32(0x297A2D39)
    n ^= n >> np.uint32(15)
    return float(n & np.uint32(0xFFFFFF)) / 16777216.0


@njit(nogil=True)
def _noise(x: float, y: float, z: float) -> float:
    """Value noise in [0, 1] with quintic interpolation."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    a, b, c = x - i, y - j, z - k
    a = a * a * a * (a * (a * 6 - 15) + 10)
    b = b * b * b * (b * (b * 6 - 15) + 10)
    c = c * c * c * (c * (c * 6 - 15) + 10)
    total = 0.0
    for dk in range(2):
        for dj in range(2):
            row = _hash(i, j + dj, k + dk) * (1 - a) + _hash(i + 1, j + dj, k + dk) * a
            total += row * (b if dj else 1 - b) * (c if dk else 1 - c)
    return total


@njit(nogil=True)
def _fbm(x: float, y: float, z: float, octaves: int) -> float:
    total, weight, norm = 0.0, 0.5, 0.0
    for _ in range(octaves):
        total += weight * _noise(x, y, z)
        norm += weight
        x, y, z = 2.03 * x + 17.1, 2.01 * y + 5.7, 1.98 * z + 9.3
        weight *= 0.5
    return total / norm


@njit(nogil=True)
def _fbm_map(x: DoubleArray, z: DoubleArray, seed: float, octaves: int) -> DoubleArray:
    out = np.empty(x.size)
    for i in range(x.size):
        out[i] = _fbm(x[i], seed, z[i], octaves)
    return out


def _field(x: ArrayLike, z: ArrayLike, frequency: float, seed: float, octaves: int = 4) -> DoubleArray:
    """Fractal noise in [0, 1] over the plane, of the broadcast shape of `x` and `z`."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    flat = _fbm_map(np.ascontiguousarray(x.ravel() * frequency), z.ravel() * frequency, seed, octaves)
    return np.asarray(flat, np.float64).reshape(x.shape)


def _ramp(low: float, high: float, x: ArrayLike) -> DoubleArray:
    t = np.clip((np.asarray(x, np.float64) - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t), np.float64)


# ---------------------------------------------------------------- the lie of the land
def _path_x(z: ArrayLike) -> DoubleArray:
    z = np.asarray(z, np.float64)
    return 0.34 + 0.085 * z + 0.36 * np.sin(0.55 * z - 0.7) * _ramp(1.0, 5.0, z)


def _path_share(x: ArrayLike, z: ArrayLike) -> DoubleArray:
    """How much a place belongs to the footpath, 0 to 1."""
    ragged = 0.22 * (_field(x, z, 3.0, 3.3) - 0.5)
    off = np.abs(np.asarray(x) - _path_x(z)) + ragged
    wide = 0.10 + 0.035 * np.minimum(z, 12.0)
    return (1 - _ramp(0.35, 1.1, off / wide)) * (1 - _ramp(18.0, 22.0, z)) * _ramp(2.7, 3.4, z)


def _ground(x: ArrayLike, z: ArrayLike) -> DoubleArray:
    """Height of the land at (x, z)."""
    x, z = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(z, np.float64))
    rise = 0.10 * (_field(x, z, 0.5, 1.5) - 0.5) * _ramp(1.0, 4.0, z) + 0.45 * (
        _field(x, z, 0.13, 8.2) - 0.5
    ) * _ramp(4.0, 14.0, z)
    rise = rise + 0.011 * np.maximum(z - 5.0, 0.0) - 0.035 * _path_share(x, z)
    for middle, reach, base, seed, peaks in RANGES:
        crest = np.full(x.shape, base)
        for slope, tall, wide in peaks:
            crest = crest + tall * np.exp(-(((x / np.maximum(z, 1.0) - slope) / wide) ** 2))
        rough = 0.45 + 1.10 * _field(x, z * 0.6, 5.5 / middle, seed, 6)
        rise = rise + crest * rough * np.exp(-(((z - middle) / reach) ** 2))
    return rise


# ---------------------------------------------------------------- sheets of triangles
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


def _frame(axis: ArrayLike) -> DoubleArray:
    """Rows: two unit vectors across `axis`, then `axis` itself. Shape (..., 3, 3)."""
    along: DoubleArray = np.asarray(axis, np.float64)
    along = along / np.linalg.norm(along, axis=-1, keepdims=True)
    helper = np.where(np.abs(along[..., 1:2]) < 0.95, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    side = np.cross(helper, along)
    side = side / np.linalg.norm(side, axis=-1, keepdims=True)
    return np.stack([side, np.cross(along, side), along], axis=-2)


def _tube(mesh: Mesh, line: DoubleArray, radius: ArrayLike, color: ArrayLike, material: int = WOOD,
          openness: ArrayLike = 1.0, sides: int = 8) -> None:  # fmt: skip
    """A tube along `line` (n, 3) with `radius` broadcast to (n,)."""
    frames = _frame(np.gradient(line, axis=0))
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    ring = np.cos(angle)[:, None] * frames[:, None, 0] + np.sin(angle)[:, None] * frames[:, None, 1]
    reach = np.broadcast_to(np.asarray(radius, np.float64), (len(line),))
    points = line[:, None] + ring * reach[:, None, None]
    shade = np.broadcast_to(np.asarray(openness), (len(line),))[None, :, None]
    mesh.add(points[None], color, material, shade, normals=ring[None])


def _blades(mesh: Mesh, roots: DoubleArray, height: DoubleArray, half_width: DoubleArray, bend: DoubleArray,
            colors: DoubleArray, rng: Generator, segments: int, creased: bool) -> None:  # fmt: skip
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


def _leaf(mesh: Mesh, root: ArrayLike, heading: ArrayLike, length: float, half_width: float, droop: float,
          color: ArrayLike, rng: Generator, teeth: float = 0.0, openness: float = 0.85) -> None:  # fmt: skip
    """One broad leaf with a sunken midrib, a wavy rim and, if wished, teeth."""
    t, v = np.meshgrid(np.linspace(0, 1, 44), np.linspace(-1, 1, 25), indexing="ij")
    shape = np.sin(np.pi * t**0.8) ** 0.75 * (0.35 + 0.9 * t) / 1.05 + 0.05 * (1 - t)
    shape = shape * (1 + teeth * (np.abs((t * 7.5) % 1 - 0.5) - 0.25))
    side, _, axis = _frame(np.asarray(heading, np.float64))
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


# ---------------------------------------------------------------- flowers
@dataclass(frozen=True)
class Bloom:
    """What a kind of flower looks like. Lengths are shares of the radius of its head."""

    petals: int
    half_width: float
    color: tuple[float, float, float]
    base: tuple[float, float, float]
    disc: float
    disc_color: tuple[float, float, float]
    lift: float = 0.10
    droop: float = 0.16
    notch: float = 0.018
    layers: int = 2


DAISY = Bloom(21, 0.135, (0.60, 0.58, 0.545), (0.50, 0.51, 0.22), 0.33, (0.80, 0.40, 0.02))
POPPY = Bloom(
    5, 0.62, (0.72, 0.035, 0.012), (0.16, 0.008, 0.01), 0.13, (0.02, 0.025, 0.012), 0.75, 0.55, 0.03
)
CORNFLOWER = Bloom(11, 0.17, (0.10, 0.13, 0.62), (0.14, 0.08, 0.42), 0.20, (0.14, 0.05, 0.36), 0.4, 0.2, 0.09)
BUTTERCUP = Bloom(
    5, 0.50, (0.86, 0.60, 0.02), (0.78, 0.50, 0.02), 0.24, (0.70, 0.52, 0.04), 0.6, 0.35, 0.01, 1
)


def _petal_points(bloom: Bloom, n: int, a: int, b: int, rng: Generator, layer: int) -> DoubleArray:
    """A ring of petals about the z axis, radius 1: (n, a, b, 3)."""
    t = np.linspace(0, 1, a)[None, :, None]
    v = np.linspace(-1, 1, b)[None, None, :]
    one = (n, 1, 1)
    length = (1 - 0.75 * bloom.disc) * rng.normal(1.0 - 0.05 * layer, 0.045, one)
    notch = bloom.notch * np.cos(2.6 * np.pi * v + rng.normal(0, 0.5, one)) * _ramp(0.8, 1, t)
    radius = 0.75 * bloom.disc + length * t * (1 - 0.065 * v**2 + notch)
    tip = np.sqrt(np.clip(1 - (np.clip(t - 0.70, 0, 1) / 0.30) ** 2 * 0.80, 0, 1))
    width = bloom.half_width * (0.34 + 0.66 * _ramp(0.0, 0.55, t)) * tip * rng.normal(1.0, 0.08, one)
    sway = rng.normal(0, 0.05, one) * t**2
    lift = bloom.lift * rng.normal(1, 0.25, one) * t - bloom.droop * rng.normal(1, 0.35, one) * t**2.4
    camber = -width * rng.normal(0.30, 0.20, one) * v**2 * (0.5 + t)
    furrow = -0.085 * width * sum(np.exp(-(((v - c) / 0.13) ** 2)) for c in (-0.36, 0.36))
    ripple = 0.05 * width * np.sin(7 * t + 3 * v + rng.uniform(0, 6, one)) * t
    twist = rng.normal(0, 0.30, one) * t * v * width
    curl = rng.normal(0.02, 0.07, one) * np.clip(t - 0.55, 0, 1) ** 2 * 4
    z = lift + curl + camber + furrow * (1 - t**4) + ripple + twist
    z = z - 0.035 * layer + rng.normal(0, 0.010, one) * t
    angle = (np.arange(n) + 0.5 * layer + rng.normal(0, 0.13, n)) * 2 * np.pi / n
    across = sway + width * v
    cos, sin = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    return np.stack([radius * cos - across * sin, radius * sin + across * cos, z + 0 * radius], -1)


def _florets(mesh: Mesh, centre: DoubleArray, frame: DoubleArray, radius: float, bloom: Bloom, count: int,
             rng: Generator) -> None:  # fmt: skip
    """The disc of a near daisy: florets on the golden-angle spiral, open at the rim, buds inside."""
    k = np.arange(count) + 0.5
    share = np.sqrt(k / count)
    angle = k * np.pi * (3 - np.sqrt(5.0))
    reach = bloom.disc * 0.98
    dome = 0.115 * np.sqrt(np.clip(1.02 - share**2, 0, 1)) - 0.035 * np.exp(-((share / 0.28) ** 2))
    seat = np.stack([reach * share * np.cos(angle), reach * share * np.sin(angle), dome], -1)
    out = np.stack([np.cos(angle) * share * 0.9, np.sin(angle) * share * 0.9, np.ones(count)], -1)
    basis = _frame(out)
    opened = _ramp(0.45, 0.72, share + rng.normal(0, 0.06, count))[:, None, None]
    size = reach * 1.02 / np.sqrt(count) * rng.normal(1.0, 0.07, count)[:, None, None]
    row = np.array([0, 1, 2, 3, 4, 5, 6])
    bud_r = np.array([0.75, 0.95, 1.0, 0.88, 0.62, 0.3, 0.0])[row][None, :, None]
    bud_z = np.array([-1.0, 0.0, 0.7, 1.2, 1.5, 1.62, 1.66])[row][None, :, None]
    tube_r = np.array([0.6, 0.62, 0.68, 0.80, 1.05, 0.50, 0.28])[row][None, :, None]
    tube_z = np.array([-1.0, 0.4, 1.2, 1.8, 2.1, 1.75, 0.9])[row][None, :, None]
    phi = np.linspace(0, 2 * np.pi, 16)[None, None, :]
    lobes = 1 + opened * 0.20 * np.cos(5 * phi + angle[:, None, None]) * (row[None, :, None] == 4)
    ring = size * (bud_r * (1 - opened) + tube_r * opened) * lobes
    rise = size * (bud_z * (1 - opened) + tube_z * opened)
    local = (
        seat[:, None, None] + (ring * np.cos(phi))[..., None] * basis[:, None, None, 0]
        + (ring * np.sin(phi))[..., None] * basis[:, None, None, 1]
        + (rise + 0 * phi)[..., None] * basis[:, None, None, 2]
    )  # fmt: skip
    tint = np.asarray(bloom.disc_color) * rng.normal(1.0, 0.10, (count, 1, 1, 1))
    young = np.array([0.54, 0.41, 0.03])
    fresh = np.exp(-((share / 0.42) ** 2))[:, None, None, None]
    color = tint * (1 - 0.75 * fresh) + young * 0.75 * fresh
    throat = np.array([0.40, 0.55, 0.8, 1.0, 1.12, 0.55, 0.22])[None, :, None, None]
    bud = np.array([0.35, 0.6, 0.9, 1.0, 1.1, 1.1, 1.1])[None, :, None, None]
    color = color * np.where(opened[..., None] > 0.5, throat, bud)
    openness = np.array([0.15, 0.4, 0.75, 1.0, 1.0, 0.5, 0.2])[None, :, None]
    mesh.add(centre + radius * local @ frame, np.clip(color, 0, 0.95), FLORET, openness)


def _head(mesh: Mesh, centre: ArrayLike, axis: ArrayLike, radius: float, bloom: Bloom, detail: int,
          rng: Generator) -> None:  # fmt: skip
    """A flower head facing `axis`. `detail` 2 is the near flower, 1 a middle one, 0 a far one."""
    centre = np.asarray(centre, np.float64)
    frame = _frame(axis)
    a, b = ((4, 3), (12, 9), (48, 27))[detail]
    for layer in range(bloom.layers if detail else 1):
        count = bloom.petals - 6 * layer if bloom.petals > 8 else bloom.petals
        local = _petal_points(bloom, count, a, b, rng, layer)
        t = np.linspace(0, 1, a)[None, :, None, None]
        hue = rng.normal(1.0, 0.035, (count, 1, 1, 3)) * rng.normal(1.0, 0.05, (count, 1, 1, 1))
        base = 1 - _ramp(0.02, 0.30, t)
        color = (np.asarray(bloom.color) * (1 - base) + np.asarray(bloom.base) * base) * hue
        openness = (0.55 + 0.45 * _ramp(0.0, 0.35, t[..., 0])) * (1.0 - 0.12 * layer)
        mesh.add(centre + radius * local @ frame, np.clip(color, 0, 0.93), PETAL, openness)
    if detail == 2:
        _florets(mesh, centre, frame, radius, bloom, 340, rng)
        r, phi = np.meshgrid(np.linspace(0.40, 0.04, 8), np.linspace(0, 2 * np.pi, 40), indexing="ij")
        cup = np.stack([r * np.cos(phi), r * np.sin(phi), -0.055 - 0.25 * (0.4 - r)], -1)
        mesh.add((centre + radius * cup @ frame)[None], [0.17, 0.21, 0.060], WOOD, 0.8)
    r, phi = np.meshgrid(
        np.linspace(1, 0, 5 + 3 * detail), np.linspace(0, 2 * np.pi, 9 + 8 * detail), indexing="ij"
    )
    rise = 0.10 * np.sqrt(np.clip(1.0 - r**2, 0, 1)) - (0.03 if detail == 2 else 0.0)
    dome = np.stack([bloom.disc * r * np.cos(phi), bloom.disc * r * np.sin(phi), rise], -1)
    tone = 0.25 if detail == 2 else 0.9
    mesh.add((centre + radius * dome @ frame)[None], np.asarray(bloom.disc_color) * tone, FLORET, 0.9)


def _flower(mesh: Mesh, root: ArrayLike, height: float, axis: ArrayLike, radius: float, bloom: Bloom,
            detail: int, rng: Generator, head: ArrayLike | None = None) -> None:  # fmt: skip
    """A flower on a curved stem that rises from `root` to its head."""
    root = np.asarray(root, np.float64)
    axis = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    lean = rng.normal(0, 0.10, 3) * [1, 0, 1] * height
    top = root + np.array([lean[0], height, lean[2]]) if head is None else np.asarray(head, np.float64)
    t = np.linspace(0, 1, (5, 10, 36)[detail])[:, None]
    knee = root + (top - root) * [0.25, 0.75, 0.25] - 0.18 * height * axis
    line = (1 - t) ** 2 * root + 2 * t * (1 - t) * knee + t**2 * (top - 0.03 * radius * axis)
    thick = max(0.024 * radius + 0.0022, 0.0006 * top[2]) * (1.15 - 0.25 * t[:, 0])
    thick = thick * (1 + 0.8 * np.clip((t[:, 0] - 0.96) / 0.04, 0, 1))
    green = np.array([0.115, 0.165, 0.040]) * rng.normal(1, 0.1)
    _tube(mesh, line, thick, green, WOOD, 0.25 + 0.75 * t[:, 0], (4, 6, 14)[detail])
    _head(mesh, top, axis, radius, bloom, detail, rng)


# ---------------------------------------------------------------- trees, stones, land
def _diamonds(centres: DoubleArray, normals: DoubleArray, size: DoubleArray, rng: Generator) -> DoubleArray:
    """Small rhombic leaves, (n, 2, 2, 3), roughly facing `normals` (n, 3)."""
    n = len(centres)
    facing = _frame(normals + rng.normal(0, 0.55, (n, 3)))
    turn = rng.uniform(0, 2 * np.pi, n)[:, None]
    one = np.cos(turn) * facing[:, 0] + np.sin(turn) * facing[:, 1]
    two = 0.62 * (np.cos(turn) * facing[:, 1] - np.sin(turn) * facing[:, 0])
    step = np.stack([np.stack([-one, -two], 1), np.stack([two, one], 1)], 1) * size[:, None, None, None]
    return centres[:, None, None] + step


def _crowns(mesh: Mesh, centres: DoubleArray, radii: DoubleArray, colors: DoubleArray, leaves: int,
            leaf_size: float, rng: Generator, heart: DoubleArray | None = None) -> None:  # fmt: skip
    """Clumps of foliage: `leaves` rhombs in the outer shell of every ball.

    Args:
        mesh: Receives the leaves.
        centres: (n, 3).
        radii: (n,).
        colors: (n, 3).
        leaves: Number for each ball.
        leaf_size: Half length of a leaf as a share of the ball's radius.
        rng: Random source.
        heart: Centre of the whole crown; leaves that point towards it are darker.
    """
    n = len(centres)
    out = rng.normal(0, 1, (n, leaves, 3))
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    shell = rng.uniform(0, 1, (n, leaves, 1)) ** 0.4
    place = centres[:, None] + out * shell * radii[:, None, None] * [1.0, 0.78, 1.0]
    openness = 0.30 + 0.35 * shell[..., 0] + 0.35 * np.clip(out[..., 1], -0.6, 1)
    if heart is not None:
        away = place - heart
        away /= np.linalg.norm(away, axis=-1, keepdims=True)
        openness = openness * (0.62 + 0.38 * np.clip((out * away).sum(-1), -1, 1))
        out = 0.7 * out + 0.6 * away
    size = leaf_size * radii[:, None] * rng.uniform(0.6, 1.3, (n, leaves))
    points = _diamonds(place.reshape(-1, 3), out.reshape(-1, 3), size.ravel(), rng)
    soft = out.reshape(-1, 3) + rng.normal(0, 0.30, (n * leaves, 3))
    soft /= np.linalg.norm(soft, axis=-1, keepdims=True)
    tint = np.repeat(colors, leaves, 0) * rng.normal(1, 0.14, (n * leaves, 1))
    tint = tint * rng.normal(1, 0.05, (n * leaves, 3))
    mesh.add(points, np.clip(tint, 0.004, 0.6)[:, None, None], FOLIAGE,
             np.clip(openness, 0.08, 1).reshape(-1, 1, 1), normals=soft[:, None, None])  # fmt: skip


def _tree(mesh: Mesh, x: float, z: float, height: float, color: ArrayLike, rng: Generator,
          spread: float = 0.36, balls: int = 54, leaves: int = 800) -> None:  # fmt: skip
    """A broad-leaved tree: trunk, limbs, and balls of foliage at the limbs' ends."""
    foot = np.array([x, float(_ground(x, z)) - 0.02, z])
    heart = foot + np.array([0.02, 0.57, 0.0]) * height
    out = rng.normal(0, 1, (balls, 3))
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    out[:, 1] = np.where(out[:, 1] < -0.75, -0.8 * out[:, 1], out[:, 1])
    reach = np.array([spread, 0.36, spread]) * height
    balls_at = heart + out * reach * rng.uniform(0.15, 1.0, (balls, 1)) ** 0.45
    balls_at = heart + (balls_at - heart) * rng.uniform(0.78, 1.0, (balls, 1))
    radii = height * rng.uniform(0.055, 0.130, balls) * (1.15 - 0.35 * np.clip(out[:, 1], 0, 1))
    t = np.linspace(0, 1, 14)[:, None]
    bow = np.sin(np.pi * t) * rng.normal(0, 0.02, 3) * height
    _tube(mesh, foot + (heart - foot) * t + bow, 0.026 * height * (1.25 - t[:, 0]) ** 1.2 + 0.006 * height,
          [0.085, 0.062, 0.042], WOOD, 0.35 + 0.3 * (1 - t[:, 0]))  # fmt: skip
    for k in range(0, balls, 3):
        start = foot + (heart - foot) * rng.uniform(0.45, 0.9)
        knee = 0.5 * (start + balls_at[k]) - [0, 0.05 * height, 0]
        line = (1 - t) ** 2 * start + 2 * t * (1 - t) * knee + t**2 * balls_at[k]
        _tube(mesh, line, 0.014 * height * (1.1 - t[:, 0]), [0.075, 0.055, 0.038], WOOD, 0.45, 5)
    colors = 1.2 * np.asarray(color) * rng.normal(1, 0.15, (balls, 1)) * rng.normal(1, 0.05, (balls, 3))
    _crowns(mesh, balls_at, radii, colors, leaves, 0.092, rng, heart)


def _forest(mesh: Mesh, count: int, z_low: float, z_high: float, size: float, leaves: int, cover: float,
            rng: Generator) -> None:  # fmt: skip
    """Far woods: crowns in drifts on the hills."""
    z = rng.uniform(z_low, z_high, 6 * count)
    x = z * rng.uniform(-0.60, 0.60, 6 * count)
    wooded = _field(x, z * 0.7, 0.11, 63.0 + z_low, 3) + rng.normal(0, 0.02, len(x))
    keep = np.argsort(-wooded, kind="stable")[: int(count * cover)]
    stray = rng.choice(len(x), int(count * (1 - cover)), replace=False)
    pick = np.concatenate([keep, stray])
    x, z = x[pick], z[pick]
    radii = size * rng.uniform(0.55, 1.15, len(x))
    centres = np.stack([x, _ground(x, z) + 0.70 * radii, z], -1)
    hue = (
        np.array([0.040, 0.072, 0.022]) * rng.normal(1, 0.18, (len(x), 1)) * rng.normal(1, 0.10, (len(x), 3))
    )
    _crowns(mesh, centres, radii, np.clip(hue, 0.008, 1), leaves, 0.26, rng)


def _stone(mesh: Mesh, x: float, z: float, radius: float, rng: Generator) -> None:
    """A weathered stone, half sunk."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 40), np.linspace(0, 2 * np.pi, 64), indexing="ij")
    out = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    seed = rng.uniform(0, 90)
    lump = _field(out[..., 0] + 0.7 * out[..., 1] + 9, out[..., 2] - 0.6 * out[..., 1] + 9, 1.6, seed, 5)
    # Flattening the lumps at two levels gives the broken faces of a field stone.
    faceted = 0.55 * np.minimum(lump, 0.54) + 0.45 * lump
    shape = out * (0.55 + 0.9 * faceted)[..., None] * np.array([1.15, 0.72, 0.95]) * radius
    centre = np.array([x, float(_ground(x, z)) + 0.15 * radius, z])
    openness = 0.25 + 0.75 * np.clip((out[..., 1] + 0.5) / 1.0, 0, 1)
    mesh.add(
        (centre + shape)[None], np.array([0.24, 0.225, 0.20]) * rng.normal(1, 0.12), STONE, openness[None]
    )


def _land(mesh: Mesh) -> None:
    """The ground as one sheet, finer where it is near, coloured by what grows on it."""
    z = np.geomspace(NEAR, FAR, 820)[:, None]
    slope = np.linspace(-0.66, 0.66, 620)[None, :]
    x = slope * z
    z = np.broadcast_to(z, x.shape)
    y = _ground(x, z)
    patch = _field(x, z, 0.35, 5.0)[..., None]
    litter = np.array([0.085, 0.066, 0.034]) * (1 - patch) + np.array([0.070, 0.085, 0.026]) * patch
    sward = np.array([0.105, 0.150, 0.036]) * (1 - patch) + np.array([0.190, 0.195, 0.060]) * patch
    far = _ramp(4.0, 14.0, z)[..., None]
    color = litter * (1 - far) + sward * far
    plots = _field(np.floor(x * 0.16 + 0.8 * _field(x, z, 0.05, 71.0, 2)), np.floor(z * 0.35), 1.37, 77.0, 1)
    field_tint = np.stack(
        [0.115 + 0.24 * _ramp(0.55, 0.8, plots), 0.165 + 0.12 * plots, 0.045 + 0.05 * plots], -1
    )
    farm = (_ramp(21.0, 24.5, z) * (1 - 0.5 * _ramp(38, 50, z)))[..., None]
    color = color * (1 - farm) + field_tint * farm
    path = _path_share(x, z)[..., None]
    color = color * (1 - path) + np.array([0.270, 0.205, 0.135]) * path
    near_shade = 0.42 + 0.58 * np.maximum(_ramp(5.0, 12.0, z), path[..., 0])
    mesh.add(np.stack([x, y, z], -1)[None], color, GROUND, near_shade[None])


# ---------------------------------------------------------------- what stands where
def _grass(mesh: Mesh, rng: Generator) -> None:
    """Blades in every distance; density falls as they shrink on the picture."""
    for z_low, z_high, count, segments, creased in (
        (1.02, 2.6, 13000, 9, True),
        (2.6, 7.0, 40000, 6, False),
        (7.0, 16.0, 62000, 4, False),
        (16.0, 25.0, 42000, 3, False),
    ):
        z = z_low * (z_high / z_low) ** (rng.uniform(0, 1, count) ** 0.92)
        x = z * rng.uniform(-0.62, 0.66, count)
        clump = _field(x, z, 1.9, 11.0, 3) + 0.6 * _field(x, z, 6.0, 13.0, 2) - 0.3
        path = _path_share(x, z)
        keep = (rng.uniform(0, 1, count) > 0.97 * path) & (clump + rng.normal(0, 0.12, count) > 0.36)
        keep &= ~((z < 1.46) & (np.abs(x - 0.03) < 0.13))  # the broad leaves stand free
        x, z, clump, path = x[keep], z[keep], clump[keep], path[keep]
        n = len(x)
        height = (0.11 + 0.24 * np.clip(clump, 0, 1)) * rng.lognormal(0, 0.30, n) * (1 - 0.7 * path)
        beside = np.abs(x - _path_x(z)) / (0.3 + 0.05 * z)
        height = height * (1 - 0.45 * np.exp(-(beside**2)) * _ramp(2.4, 3.4, z))
        height = height * (1 - 0.42 * _ramp(5.0, 20.0, z)) * (0.55 + 0.45 * _ramp(1.0, 1.9, z))
        width = np.clip(rng.lognormal(np.log(0.0036), 0.42, n), 0.0015, 0.0072) * (
            1 + 0.10 * np.maximum(z - 3, 0) ** 0.9
        )
        hue = np.clip(_field(x, z, 0.7, 19.0, 3) + rng.normal(0, 0.16, n), 0, 1)[:, None]
        fresh = np.array([0.082, 0.170, 0.030]) * (1 - hue) + np.array([0.185, 0.212, 0.046]) * hue
        dry = (rng.uniform(0, 1, n) < 0.10 + 0.10 * _ramp(3, 12, z))[:, None]
        tip = np.where(dry, [0.46, 0.36, 0.17], fresh * [1.15, 1.12, 1.0]) * rng.normal(1, 0.12, (n, 1))
        foot = np.where(dry, [0.26, 0.22, 0.09], fresh * [0.75, 0.72, 0.8]) * rng.normal(1, 0.10, (n, 1))
        colors = np.clip(np.stack([foot, tip], 1), 0.01, 0.7)
        roots = np.stack([x, _ground(x, z) - 0.004, z], -1)
        bend = np.clip(rng.gamma(2.4, 0.20, n), 0.03, 1.15)
        _blades(mesh, roots, np.clip(height, 0.03, 0.52), width, bend, colors, rng, segments, creased)


def _seed_heads(mesh: Mesh, count: int, rng: Generator) -> None:
    """Tall thin grasses whose loose panicles catch the light."""
    z = 2.4 * (14.0 / 2.4) ** rng.uniform(0, 1, count)
    x = z * rng.uniform(-0.60, 0.62, count)
    for k in np.flatnonzero(_path_share(x, z) < 0.2):
        foot = np.array([x[k], float(_ground(x[k], z[k])), z[k]])
        height = rng.uniform(0.34, 0.58) * (1 - 0.3 * float(_ramp(5, 14, z[k])))
        lean = rng.normal(0, 0.10, 3) * [1, 0, 1] + [-0.03, 0, 0]
        t = np.linspace(0, 1, 12)[:, None]
        line = foot + t * [0, height, 0] + t**2.5 * lean
        straw = np.array([0.42, 0.34, 0.17]) * rng.normal(1, 0.1) * (1, 1 - 0.1 * rng.uniform(), 1)
        _tube(mesh, line, 0.0013 + 0.0003 * z[k], straw * [0.75, 0.9, 0.6], WOOD, 0.2 + 0.8 * t[:, 0], 4)
        n = 34
        up = rng.uniform(0.70, 1.0, n)
        place = foot + up[:, None] * [0, height, 0] + (up**2.5)[:, None] * lean
        place = place + rng.normal(0, 0.011, (n, 3)) * (1.25 - up[:, None]) * 3
        facing = rng.normal(0, 1, (n, 3)) * [1, 0.3, 1]
        grain = _diamonds(place, facing, 0.0045 * rng.uniform(0.6, 1.2, n) * (1 + 0.05 * z[k]), rng)
        mesh.add(grain, straw, FOLIAGE, 1.0)


def _drift(mesh: Mesh, bloom: Bloom, count: int, z_low: float, z_high: float, seed: float, height: float,
           radius: float, rng: Generator) -> None:  # fmt: skip
    """Flowers of one kind, gathered in drifts off the path."""
    z = z_low * (z_high / z_low) ** rng.uniform(0, 1, 8 * count)
    x = z * rng.uniform(-0.60, 0.60, 8 * count)
    wish = _field(x, z, 0.55, seed, 3) + rng.normal(0, 0.05, len(x)) - _path_share(x, z)
    # Nothing may stand before or right behind the near flower.
    wish = wish - 2.0 * ((z < 3.4) & (x / z < -0.02) & (x / z > -0.42))
    for k in np.argsort(-wish, kind="stable")[:count]:
        root = np.array([x[k], float(_ground(x[k], z[k])), z[k]])
        axis = rng.normal([0.30, 1.0, -0.55], [0.35, 0.2, 0.35])
        tall = height * rng.uniform(0.75, 1.25) * (1 - 0.35 * float(_ramp(5, 20, z[k])))
        size = radius * rng.uniform(0.75, 1.15) * (1 + 0.02 * z[k])
        _flower(mesh, root, tall, axis, size, bloom, 1 if z[k] < 4.5 else 0, rng)


def _place(px: float, py: float, z: float) -> DoubleArray:
    """World point at depth `z` seen at the pixel (px, py) of the full picture."""
    right, down = (px - WIDTH / 2) / FOCAL_PX * z, (py - HEIGHT / 2) / FOCAL_PX * z
    return np.array([right, EYE_HEIGHT - down * np.cos(PITCH) - z * np.sin(PITCH),
                     z * np.cos(PITCH) - down * np.sin(PITCH)])  # fmt: skip


def _foreground(mesh: Mesh, rng: Generator) -> None:
    """The near daisy with its leaves, its companions, and the stones."""
    hero = _place(322, 292, 0.93)
    foot = np.array([hero[0] + 0.075, 0.0, 1.0])
    _flower(mesh, foot, 0.0, [0.26, 0.40, -0.88], 0.157, DAISY, 2, rng, head=hero)
    green = np.array([0.095, 0.165, 0.035])
    for share, heading, length in ((0.56, (0.75, 0.80, 0.30), 0.14), (0.40, (-0.9, 0.4, -0.35), 0.16),
                                   (0.66, (-0.6, 0.65, -0.2), 0.08)):  # fmt: skip
        at = foot + (hero - foot) * share + [0.012, 0, 0]
        _leaf(mesh, at, heading, length, 0.21 * length, 0.40, green * rng.normal(1.0, 0.08), rng, 0.55)
    at = _place(556, 640, 1.34)
    for heading, length, width in (
        ((0.55, 0.55, -0.35), 0.30, 0.070),
        ((-0.85, 0.55, -0.25), 0.24, 0.055),
        ((0.16, 0.85, 0.45), 0.27, 0.068),
        ((0.95, 0.3, 0.25), 0.22, 0.05),
    ):
        _leaf(mesh, at - [0, 0.10, 0], heading, length, width, 0.42, green * [1.1, 1.05, 1.0], rng)
    for px, py, z, radius, axis in (
        (806, 418, 1.95, 0.135, (0.10, 0.62, -0.75)),
        (952, 492, 1.75, 0.120, (0.45, 0.75, -0.45)),
        (92, 470, 1.85, 0.125, (0.35, 0.85, -0.40)),
        (486, 474, 2.30, 0.115, (0.25, 0.80, -0.55)),
    ):
        head = _place(px, py, z)
        root = [head[0] + rng.normal(0, 0.06), float(_ground(head[0], head[2])), head[2] + 0.03]
        _flower(mesh, root, 0.0, axis, radius, DAISY, 2 if z < 2.0 else 1, rng, head=head)
    for px, py, z, radius, axis in ((1010, 352, 2.35, 0.125, (-0.1, 0.75, -0.55)),
                                    (890, 404, 3.0, 0.125, (0.3, 0.7, -0.5)),
                                    (640, 402, 3.3, 0.12, (0.2, 0.6, -0.7))):  # fmt: skip
        head = _place(px, py, z)
        root = [head[0] + rng.normal(0, 0.05), float(_ground(head[0], head[2])), head[2]]
        _flower(mesh, root, 0.0, axis, radius, POPPY, 1, rng, head=head)
    for x, z, radius in ((1.32, 3.7, 0.13), (1.10, 3.5, 0.05), (0.62, 4.6, 0.06), (0.52, 4.9, 0.10),
                         (1.55, 5.2, 0.09), (-1.9, 6.5, 0.16), (1.9, 7.0, 0.14)):  # fmt: skip
        _stone(mesh, x, z, radius, rng)


def _scene(seed: int) -> tuple[FloatArray, NDArray[np.int32], NDArray[np.int8]]:
    mesh = Mesh()
    for k, make in enumerate((_foreground, _grass, _flowers, _woods)):
        make(mesh, np.random.default_rng((seed, k)))
    _land(mesh)
    return np.concatenate(mesh.vertices), np.concatenate(mesh.triangles), np.concatenate(mesh.materials)


def _flowers(mesh: Mesh, rng: Generator) -> None:
    """Drifts of flowers up to the trees, and the seed heads among them."""
    _seed_heads(mesh, 330, rng)
    _drift(mesh, DAISY, 95, 2.6, 14.0, 90.0, 0.30, 0.062, rng)
    _drift(mesh, POPPY, 85, 3.0, 20.0, 94.0, 0.34, 0.070, rng)
    _drift(mesh, CORNFLOWER, 75, 2.2, 13.0, 97.0, 0.30, 0.045, rng)
    _drift(mesh, BUTTERCUP, 170, 1.9, 16.0, 99.0, 0.24, 0.026, rng)


def _woods(mesh: Mesh, rng: Generator) -> None:
    """Single trees at the edge of the meadow and woods on the hills."""
    for x, z, height, color, spread in (
        (4.60, 14.8, 2.95, (0.080, 0.120, 0.030), 0.38),
        (6.2, 16.0, 2.05, (0.066, 0.108, 0.030), 0.36),
        (1.75, 18.8, 1.65, (0.088, 0.120, 0.032), 0.36),
        (2.75, 20.0, 2.05, (0.060, 0.100, 0.030), 0.34),
        (0.4, 22.0, 1.30, (0.070, 0.108, 0.034), 0.40),
        (-7.9, 16.5, 1.95, (0.074, 0.112, 0.030), 0.38),
        (-8.6, 18.0, 2.1, (0.060, 0.100, 0.028), 0.36),
        (-3.0, 22.0, 1.10, (0.080, 0.115, 0.035), 0.42),
        (10.2, 19.0, 1.6, (0.090, 0.118, 0.030), 0.40),
    ):
        _tree(mesh, x, z, height, color, rng, spread)
    _forest(mesh, 150, 20.5, 24.0, 0.30, 260, 0.75, rng)
    _forest(mesh, 900, 24.0, 32.0, 0.29, 150, 0.88, rng)
    _forest(mesh, 4200, 33.0, 43.0, 0.27, 70, 0.97, rng)
    _forest(mesh, 9000, 45.0, 53.0, 0.25, 32, 1.0, rng)


# ---------------------------------------------------------------- visibility
@njit(nogil=True)
def _rasterize(
    screen: FloatArray, triangles: NDArray[np.int32], nearness: FloatArray, index: NDArray[np.int32]
) -> None:
    """Keep for every sample the triangle of greatest nearness (column 2 of `screen`, linear there)."""
    rows, columns = nearness.shape
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t]
        wa, wb, wc = screen[a, 2], screen[b, 2], screen[c, 2]
        if not (wa > -1e29 and wb > -1e29 and wc > -1e29):
            continue
        xa, ya = float(screen[a, 0]), float(screen[a, 1])
        xb, yb = float(screen[b, 0]), float(screen[b, 1])
        xc, yc = float(screen[c, 0]), float(screen[c, 1])
        left = max(0, int(np.ceil(min(xa, xb, xc) - 0.5)))
        right = min(columns - 1, int(np.floor(max(xa, xb, xc) - 0.5)))
        top = max(0, int(np.ceil(min(ya, yb, yc) - 0.5)))
        bottom = min(rows - 1, int(np.floor(max(ya, yb, yc) - 0.5)))
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area == 0.0 or left > right or top > bottom:
            continue
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                u = ((xb - x - 0.5) * (yc - y - 0.5) - (xc - x - 0.5) * (yb - y - 0.5)) / area
                v = ((xc - x - 0.5) * (ya - y - 0.5) - (xa - x - 0.5) * (yc - y - 0.5)) / area
                s = 1.0 - u - v
                if u >= 0.0 and v >= 0.0 and s >= 0.0:
                    near = u * wa + v * wb + s * wc
                    if near > nearness[y, x]:
                        nearness[y, x] = near
                        index[y, x] = t


def _project(points: FloatArray, width: int, height: int, samples: int) -> FloatArray:
    """(n, 3): sample coordinates and inverse depth; behind the camera the third is -1e30."""
    focal = FOCAL_PX * width / WIDTH * samples
    p = points.astype(np.float64) - [0.0, EYE_HEIGHT, 0.0]
    depth = p[:, 2] * np.cos(PITCH) - p[:, 1] * np.sin(PITCH)
    down = -p[:, 1] * np.cos(PITCH) - p[:, 2] * np.sin(PITCH)
    safe = np.maximum(depth, 0.3)
    x = focal * p[:, 0] / safe + width * samples / 2
    y = focal * down / safe + height * samples / 2
    return np.stack([x, y, np.where(depth > 0.3, 1 / safe, -1e30)], -1).astype(np.float32)


@dataclass(frozen=True)
class Shadow:
    """Height towards the sun of what it meets first, seen from the sun over three nested regions."""

    maps: FloatArray  # (3, s, s)
    axes: DoubleArray  # (3, 3): two axes across the sun's direction, and the direction
    windows: DoubleArray  # (3, 3): least x, least y, texels for a unit


def _sun_view(vertices: FloatArray, triangles: NDArray[np.int32], texels: int) -> Shadow:
    axes = _frame(SUN)
    seen = vertices[:, :3].astype(np.float64) @ axes.T
    maps = np.full((3, texels, texels), -1e30, np.float32)
    windows = np.empty((3, 3))
    z, slope = vertices[:, 2], vertices[:, 0] / vertices[:, 2]
    for k, limit in enumerate((2.1, 7.5, 200.0)):
        inside = seen[(z < limit) & (np.abs(slope) < 0.60)]
        low, high = inside[:, :2].min(0), inside[:, :2].max(0)
        windows[k] = low[0], low[1], texels / (high - low).max()
        screen = np.empty((len(seen), 3), np.float32)
        screen[:, :2] = (seen[:, :2] - low) * windows[k, 2]
        screen[:, 2] = seen[:, 2]
        _rasterize(screen, triangles, maps[k], np.empty((texels, texels), np.int32))
    return Shadow(maps, axes, windows)


# ---------------------------------------------------------------- light
@njit(nogil=True)
def _sunlight(p: DoubleArray, depth: float, turn: float, maps: FloatArray, axes: DoubleArray,
              windows: DoubleArray) -> float:  # fmt: skip
    """Share of the sun's disc seen from `p`: five taps, turned by `turn` so that samples differ."""
    k = 0 if depth < 1.95 else (1 if depth < 7.0 else 2)
    s = maps.shape[1]
    x = (axes[0, 0] * p[0] + axes[0, 1] * p[1] + axes[0, 2] * p[2] - windows[k, 0]) * windows[k, 2]
    y = (axes[1, 0] * p[0] + axes[1, 1] * p[1] + axes[1, 2] * p[2] - windows[k, 1]) * windows[k, 2]
    h = axes[2, 0] * p[0] + axes[2, 1] * p[1] + axes[2, 2] * p[2]
    reach = max(1.2, 0.0022 * depth * windows[k, 2])
    bias = 0.0012 + 2.2 * reach / windows[k, 2]
    lit = 0.0
    for tap in range(5):
        angle = turn + 2.4 * tap
        r = reach * np.sqrt((tap + 0.5) / 5.0)
        i, j = int(np.floor(y + r * np.sin(angle))), int(np.floor(x + r * np.cos(angle)))
        if i < 0 or j < 0 or i >= s or j >= s or maps[k, i, j] <= h + bias:
            lit += 0.2
    return lit


@njit(nogil=True)
def _crevice(row: int, column: int, depth: float, turn: float, reach: float, nearness: FloatArray) -> float:
    """Screen-space ambient occlusion, 0 open to 1 closed, from six neighbours."""
    rows, columns = nearness.shape
    total = 0.0
    for tap in range(6):
        angle = turn + 2.4 * tap
        r = reach * ((tap + 0.5) / 6.0)
        i, j = row + int(r * np.sin(angle)), column + int(r * np.cos(angle))
        if i < 0 or j < 0 or i >= rows or j >= columns or nearness[i, j] <= 0:
            continue
        ahead = (depth - 1.0 / nearness[i, j]) / depth
        if ahead > 0.0015:
            total += min(1.0, ahead * 60.0) / (1.0 + (ahead * 14.0) ** 2)
    return total / 6.0


@njit(nogil=True)
def _pattern(material: int, u: float, v: float, p: DoubleArray, depth: float, color: DoubleArray) -> None:
    """Fine texture, applied to `color` in place."""
    k = np.floor(u / 2.0)
    s = u - 2.0 * k
    gain = 1.0
    if material == PETAL:
        gain += 0.20 * (_noise(v * 7.0 + 40, s * 2.0, k) - 0.5)
        gain += 0.24 * (_noise(v * 17.0 + 90, s * 3.0, k) - 0.5)
        gain += 0.08 * (_noise(v * 12.0, s * 30.0, k) - 0.5)
    elif material == GRASS:
        gain += 0.30 * (_noise(v * 3.5 + 20, s * 9.0, k) - 0.5)
        gain += 0.18 * (_noise(v * 9.0 + 50, s * 3.0, k) - 0.5)
        if abs(v) < 0.14:
            gain *= 1.16
    elif material == LEAF:
        phase = (s - 0.32 * abs(v)) * 9.87
        vein = abs(phase - np.floor(phase + 0.5))
        thin = max(0.0, 1.0 - vein / 0.055) * 0.8 + max(0.0, 1.0 - abs(v) / 0.07)
        net = _noise(p[0] * 330, p[1] * 330, p[2] * 330)
        gain = 0.93 + 0.25 * (_fbm(p[0] * 30, p[1] * 30, p[2] * 30, 3) - 0.5) + 0.18 * (net - 0.5)
        color[0] += 0.050 * thin
        color[1] += 0.055 * thin
        color[2] += 0.022 * thin
    elif material == GROUND:
        if depth < 16.0:
            coarse = _fbm(p[0] * 16, 3.0, p[2] * 16, 3)
            fine = _fbm(p[0] * 90, 7.0, p[2] * 90, 2)
            gain = 1.0 + 0.9 * (coarse - 0.5) + 1.1 * (fine - 0.5)
        else:
            gain = 1.0 + 0.7 * (_fbm(p[0] * 7, p[1] * 7, p[2] * 3, 4) - 0.5)
    elif material == STONE:
        grain = _fbm(p[0] * 140, p[1] * 140, p[2] * 140, 3)
        gain = 0.8 + 0.55 * (_fbm(p[0] * 26, p[1] * 26, p[2] * 26, 4) - 0.35) + 0.55 * (grain - 0.5)
        lichen = _fbm(p[0] * 40 + 9, p[1] * 40, p[2] * 40, 3) - 0.56
        if lichen > 0:
            lichen = min(1.0, lichen * 9.0)
            color[0] += lichen * (0.30 - color[0])
            color[1] += lichen * (0.29 - color[1])
            color[2] += lichen * (0.17 - color[2])
    elif material == WOOD:
        gain = 1.0 + 0.45 * (_noise(v * 5.0 + 30, s * 30.0, k) - 0.5)
    elif material == FLORET:
        gain = 1.0 + 0.25 * (_noise(p[0] * 700, p[1] * 700, p[2] * 700) - 0.5)
    for c in range(3):
        color[c] = max(0.002, color[c] * gain)


@njit(nogil=True)
def _roughen(p: DoubleArray, normal: DoubleArray) -> None:
    """Tilt the normal of near ground by its crumbs and pebbles, in place."""
    e = 0.002
    here = _fbm(p[0] * 55, 1.0, p[2] * 55, 3)
    normal[0] -= 0.020 * (_fbm((p[0] + e) * 55, 1.0, p[2] * 55, 3) - here) / e
    normal[2] -= 0.020 * (_fbm(p[0] * 55, 1.0, (p[2] + e) * 55, 3) - here) / e
    normal /= np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)


@njit(nogil=True)
def _haze(x: float, y: float, z: float, out: DoubleArray) -> None:
    """Colour of the clear air towards the unit vector (x, y, z)."""
    up = max(y, 0.0)
    t = 1.0 - np.exp(-up * 5.2)
    warm = max(0.0, SUN[0] * x + SUN[2] * z) ** 2 * np.exp(-up * 6.0)
    low = (0.92 + 0.16 * warm, 0.95 + 0.04 * warm, 0.97 - 0.12 * warm)
    high = (0.085, 0.28, 0.80)
    for c in range(3):
        out[c] = low[c] * (1 - t) + high[c] * t


@njit(nogil=True)
def _tone(x: float) -> float:
    """Filmic curve (Narkowicz's fit of ACES), display-linear in 0..1."""
    x *= 0.64
    return min(1.0, max(0.0, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)))


@njit(nogil=True)
def _dot(a: DoubleArray, b: DoubleArray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(nogil=True)
def _blend(vertices: FloatArray, screen: FloatArray, triangle: NDArray[np.int32], i: int, j: int,
           out: DoubleArray) -> None:  # fmt: skip
    """Mean of the corners' normal, colour, (u, v) and openness, in perspective, into `out` (9,)."""
    a, b, c = triangle
    xa, ya, xb, yb = screen[a, 0], screen[a, 1], screen[b, 0], screen[b, 1]
    xc, yc = screen[c, 0], screen[c, 1]
    u = ((xb - j - 0.5) * (yc - i - 0.5) - (xc - j - 0.5) * (yb - i - 0.5)) * screen[a, 2]
    v = ((xc - j - 0.5) * (ya - i - 0.5) - (xa - j - 0.5) * (yc - i - 0.5)) * screen[b, 2]
    w = ((xa - j - 0.5) * (yb - i - 0.5) - (xb - j - 0.5) * (ya - i - 0.5)) * screen[c, 2]
    norm = u + v + w
    for k in range(9):
        out[k] = (u * vertices[a, 3 + k] + v * vertices[b, 3 + k] + w * vertices[c, 3 + k]) / norm
    size = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2) + 1e-9
    for k in range(3):
        out[k] /= size


@njit(nogil=True)
def _light(normal: DoubleArray, view: DoubleArray, color: DoubleArray, row: FloatArray, openness: float,
           sun: float, closed: float, out: DoubleArray) -> None:  # fmt: skip
    """Light that leaves a point towards the camera.

    Args:
        normal: Unit, facing the camera.
        view: Unit, towards the camera.
        color: Reflectance.
        row: Its row of `MATERIALS`.
        openness: Share of sky that its own plant leaves open.
        sun: Share of the sun's disc seen.
        closed: Ambient occlusion on the picture.
        out: Receives linear RGB.
    """
    facing = _dot(normal, SUN)
    wrap = row[3]
    front = max(0.0, (facing + wrap) / (1.0 + wrap))
    back = max(0.0, -facing)
    hx, hy, hz = SUN[0] + view[0], SUN[1] + view[1], SUN[2] + view[2]
    size = np.sqrt(hx * hx + hy * hy + hz * hz) + 1e-9
    shine = max(0.0, (normal[0] * hx + normal[1] * hy + normal[2] * hz) / size) ** row[2] * row[1] * sun
    rim = (1.0 - max(0.0, _dot(normal, view))) ** 4 * row[1] * 0.5
    open_air = openness * (1.0 - 0.85 * closed)
    dome = 0.5 + 0.5 * normal[1]
    sun_rgb = (3.95, 3.12, 2.12)
    sky_rgb = (0.60, 0.76, 1.05)
    bounce_rgb = (0.26, 0.27, 0.10)
    through_rgb = (1.00, 1.02, 0.50)
    white = min(color[0], color[1], color[2]) / (max(color[0], color[1], color[2]) + 1e-6)
    for c in range(3):
        pass_through = through_rgb[c] * (1 - white) + white
        direct = sun * sun_rgb[c] * (front * (1 - 0.5 * row[0]) + back * row[0] * 1.7 * pass_through)
        # Light that the leaves let through reaches even what stands in their shadow.
        stray = (1.0 - sun) * 0.16 * row[0] * sun_rgb[c] * pass_through * openness
        ambient = open_air * (sky_rgb[c] * dome + bounce_rgb[c] * (1.0 - dome) + 0.10)
        out[c] = color[c] * (direct + stray + ambient)
        out[c] += shine * sun_rgb[c] * 0.8 + rim * sky_rgb[c] * open_air


@njit(nogil=True, parallel=True)
def _shade(vertices: FloatArray, triangles: NDArray[np.int32], materials: NDArray[np.int8],
           screen: FloatArray, nearness: FloatArray, index: NDArray[np.int32], sky: FloatArray,
           samples: int, maps: FloatArray, axes: DoubleArray,
           windows: DoubleArray) -> FloatArray:  # fmt: skip
    """Mean display-linear colour of every pixel, (h, w, 3)."""
    height, width = sky.shape[:2]
    picture = np.zeros((height, width, 3), np.float32)
    focal = FOCAL_PX * width / WIDTH * samples
    reach = 30.0 * width / WIDTH * samples
    cos, sin = np.cos(PITCH), np.sin(PITCH)
    for y in prange(height):
        p, view, out, air, mixed = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(9)
        normal, color = mixed[:3], mixed[3:6]
        for x in range(width):
            total = np.zeros(3)
            for sub in range(samples * samples):
                i, j = y * samples + sub // samples, x * samples + sub % samples
                t = index[i, j]
                if t < 0:
                    for c in range(3):
                        total[c] += _tone(sky[y, x, c])
                    continue
                _blend(vertices, screen, triangles[t], i, j, mixed)
                depth = 1.0 / nearness[i, j]
                vx = (j + 0.5 - width * samples / 2) / focal
                vy = (i + 0.5 - height * samples / 2) / focal
                view[0], view[1], view[2] = -vx, vy * cos + sin, vy * sin - cos
                for c in range(3):
                    p[c] = -view[c] * depth
                p[1] += EYE_HEIGHT
                view /= np.sqrt(_dot(view, view))
                material = materials[t]
                if material != FOLIAGE and _dot(normal, view) < 0:
                    normal *= -1.0
                if material == GROUND and depth < 9.0:
                    _roughen(p, normal)
                _pattern(material, mixed[6], mixed[7], p, depth, color)
                turn = 6.2832 * _hash(i, j, 5)
                sun = _sunlight(p, depth, turn, maps, axes, windows)
                closed = _crevice(i, j, depth, turn, reach, nearness)
                _light(normal, view, color, MATERIALS[material], mixed[8], sun, closed, out)
                clear = np.exp(-((depth * 0.0205) ** 1.7))
                _haze(-view[0], max(-view[1], 0.02), -view[2], air)
                for c in range(3):
                    total[c] += _tone(out[c] * clear + 0.88 * air[c] * (1.0 - clear) * (0.96, 1.0, 1.07)[c])
            for c in range(3):
                picture[y, x, c] = total[c] / (samples * samples)
    return picture


# ---------------------------------------------------------------- sky
@njit(nogil=True)
def _cloud(x: float, y: float, z: float, octaves: int) -> float:
    """Density of the cumulus layer between heights 1 and 2: flat bases, heaped tops."""
    h = y - 1.0
    if h <= 0.0 or h >= 1.0:
        return 0.0
    cover = _fbm(x * 0.42 + 14.3, 2.0, z * 0.34 + 3.7, 4)
    top = (cover - 0.535) * 4.2
    if top + 0.42 < h:
        return 0.0
    heap = _fbm(x * 2.1, y * 2.4, z * 1.9, octaves) - 0.5
    return max(0.0, min(1.0, h * 12.0 + 0.2) * (min(top, 0.75) - h + 1.35 * heap)) * 16.0


@njit(nogil=True, parallel=True)
def _sky(width: int, height: int) -> FloatArray:
    """Linear colour of the sky behind every pixel, (h, w, 3), clouds marched through their layer."""
    out = np.zeros((height, width, 3), np.float32)
    focal = FOCAL_PX * width / WIDTH
    cos, sin = np.cos(PITCH), np.sin(PITCH)
    for i in prange(height):
        air = np.empty(3)
        for j in range(width):
            vx, vy = (j + 0.5 - width / 2) / focal, (i + 0.5 - height / 2) / focal
            n = np.sqrt(vx * vx + vy * vy + 1)
            dx, dy, dz = vx / n, (-vy * cos - sin) / n, (-vy * sin + cos) / n
            _haze(dx, dy, dz, air)
            out[i, j] = air
            if dy < 0.012:
                continue
            clear, r, g, b, steps = 1.0, 0.0, 0.0, 0.0, 110
            step = min(1.0 / dy, 26.0) / steps
            for k in range(steps):
                t = 1.0 / dy + (k + 0.5) * step
                x, y, z = dx * t, dy * t, dz * t
                density = _cloud(x, y, z, 5) * min(1.0, max(0.0, (17.0 - t) / 7.0))
                if density <= 0.0:
                    continue
                shadow = 0.0
                for m in range(1, 5):
                    s = 0.05 * m * m
                    shadow += _cloud(x + SUN[0] * s, y + SUN[1] * s, z + SUN[2] * s, 3) * 0.05 * (2 * m - 1)
                lit = np.exp(-1.5 * shadow) * 0.75 + 0.25 * np.exp(-0.3 * shadow)
                passed = np.exp(-density * min(step, 0.12) * 2.2)
                kept = clear * (1.0 - passed)
                far = 1.0 - np.exp(-((t * 0.055) ** 1.5))
                body_r, body_g, body_b = 0.56 + 1.35 * lit, 0.64 + 1.17 * lit, 0.77 + 0.93 * lit
                r += kept * (body_r * (1 - far) + 1.0 * air[0] * far)
                g += kept * (body_g * (1 - far) + 1.0 * air[1] * far)
                b += kept * (body_b * (1 - far) + 1.0 * air[2] * far)
                clear *= passed
                if clear < 0.01:
                    break
            out[i, j, 0] = air[0] * clear + r
            out[i, j, 1] = air[1] * clear + g
            out[i, j, 2] = air[2] * clear + b
    return out


# ---------------------------------------------------------------- the picture
@njit(nogil=True)
def _settle(nearness: FloatArray, height: int, width: int, samples: int) -> FloatArray:
    """Depth of the surface that most samples of a pixel see (0: the sky), never a mean of two surfaces."""
    out = np.zeros((height, width), np.float32)
    n = samples * samples
    values = np.empty(n)
    for y in range(height):
        for x in range(width):
            for k in range(n):
                values[k] = nearness[y * samples + k // samples, x * samples + k % samples]
            best, chosen = 0, 0.0
            ordered = np.sort(values)
            start = 0
            for k in range(n):
                while ordered[k] - ordered[start] > 0.03 * ordered[k]:
                    start += 1
                if k - start + 1 >= best:
                    best, chosen = k - start + 1, ordered[(k + start) // 2]
            out[y, x] = 1.0 / chosen if chosen > 0 else 0.0
    return out


def render_meadow(
    width: int, height: int, samples: int, seed: int
) -> tuple[NDArray[np.uint8], FloatArray, NDArray[np.bool_]]:
    """Render the meadow.

    Args:
        width: Pixels; the focal length is 1024/1088 of it.
        height: Pixels.
        samples: Samples of a pixel along each side.
        seed: Of every random choice.

    Returns:
        Picture (h, w, 3); depth along the view axis (h, w), median of what is not sky = 1, sky = 36.7;
        sky (h, w).
    """
    vertices, triangles, materials = _scene(seed)
    screen = _project(vertices[:, :3], width, height, samples)
    nearness = np.zeros((height * samples, width * samples), np.float32)
    index = np.full(nearness.shape, -1, np.int32)
    _rasterize(screen, triangles, nearness, index)
    shadow = _sun_view(vertices, triangles, 4096 if height > 300 else 2048)
    sky_color = _sky(width, height)
    picture = _shade(vertices, triangles, materials, screen, nearness, index, sky_color, samples,
                     shadow.maps, shadow.axes, shadow.windows)  # fmt: skip
    depth = _settle(nearness, height, width, samples)
    sky = depth == 0
    depth = np.where(sky, SKY_DEPTH, depth / np.median(depth[~sky])).astype(np.float32)
    return _encode(picture), depth, sky


def _encode(linear: FloatArray) -> NDArray[np.uint8]:
    """Grade a little (warm lights, cool shadows), then sRGB."""
    luma = linear @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    graded = luma[..., None] + 1.06 * (linear - luma[..., None])
    graded = graded * (1 + (luma[..., None] - 0.4) * np.array([0.035, 0.0, -0.05]))
    graded = np.clip(graded, 0, 1)
    coded = np.where(graded <= 0.0031308, 12.92 * graded, 1.055 * graded ** (1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * coded), np.uint8)


def _rounded(depth: FloatArray) -> FloatArray:
    """Keep 14 bits of the mantissa (3e-5 of the depth): the rest would only be noise to compress."""
    drop = np.uint32(23 - 14)
    bits = depth.view(np.uint32) + np.uint32(1 << 8)
    return (bits >> drop << drop).view(np.float32)


def _png(picture: NDArray[np.uint8]) -> bytes:
    """An 8-bit RGB PNG; each row takes the filter with the least sum of absolute differences."""
    height, width, _ = picture.shape
    now = picture.reshape(height, -1).astype(np.int16)
    above = np.vstack([np.zeros_like(now[:1]), now[:-1]])
    left = np.pad(now, ((0, 0), (3, 0)))[:, :-3]
    corner = np.pad(above, ((0, 0), (3, 0)))[:, :-3]
    guess = left + above - corner
    pa, pb, pc = np.abs(guess - left), np.abs(guess - above), np.abs(guess - corner)
    paeth = np.where((pa <= pb) & (pa <= pc), left, np.where(pb <= pc, above, corner))
    rows = np.stack([now - g for g in (0 * now, left, above, (left + above) >> 1, paeth)]).astype(np.uint8)
    cost = np.abs(rows.astype(np.int8).astype(np.int32)).sum(-1)
    body = b"".join(bytes([k]) + rows[k, y].tobytes() for y, k in enumerate(cost.argmin(0)))

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = (
        chunk(b"IHDR", head),
        chunk(b"sRGB", b"\0"),
        chunk(b"IDAT", zlib.compress(body, 9)),
        chunk(b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def main() -> None:
    """Render and write the two files."""
    parser = argparse.ArgumentParser(description="Render the bundled meadow picture and its depth.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the two files")
    parser.add_argument("--size", default=f"{WIDTH}x{HEIGHT}")
    parser.add_argument("--samples", type=int, default=4, help="along each side of a pixel")
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    width, height = (int(part) for part in options.size.split("x"))
    picture, depth, sky = render_meadow(width, height, options.samples, options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "meadow.png").write_bytes(_png(picture))
    np.savez_compressed(options.out / "meadow_depth.npz", depth=_rounded(depth), sky=sky)


if __name__ == "__main__":
    main()
