"""What stands where, from the daisy near to the woods afar."""

import numpy as np
from numpy.typing import NDArray

from meadow.flowers import BUTTERCUP, CORNFLOWER, DAISY, POPPY, Bloom, add_flower
from meadow.ground import ground_height, path_share, path_x
from meadow.noise import noise_field, smooth_ramp
from meadow.sheets import Mesh, add_blades, add_leaf, add_tube
from meadow.woods import add_forest, add_land, add_stone, add_tree, leaf_diamonds
from meadow.world import (
    EYE_HEIGHT,
    FOCAL_PX,
    FOLIAGE,
    HEIGHT,
    PITCH,
    WIDTH,
    WOOD,
    DoubleArray,
    FloatArray,
    Generator,
)


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
        clump = noise_field(x, z, 1.9, 11.0, 3) + 0.6 * noise_field(x, z, 6.0, 13.0, 2) - 0.3
        path = path_share(x, z)
        keep = (rng.uniform(0, 1, count) > 0.97 * path) & (clump + rng.normal(0, 0.12, count) > 0.36)
        keep &= ~((z < 1.46) & (np.abs(x - 0.03) < 0.13))  # the broad leaves stand free
        x, z, clump, path = x[keep], z[keep], clump[keep], path[keep]
        n = len(x)
        height = (0.11 + 0.24 * np.clip(clump, 0, 1)) * rng.lognormal(0, 0.30, n) * (1 - 0.7 * path)
        beside = np.abs(x - path_x(z)) / (0.3 + 0.05 * z)
        height = height * (1 - 0.45 * np.exp(-(beside**2)) * smooth_ramp(2.4, 3.4, z))
        height = height * (1 - 0.42 * smooth_ramp(5.0, 20.0, z)) * (0.55 + 0.45 * smooth_ramp(1.0, 1.9, z))
        width = np.clip(rng.lognormal(np.log(0.0036), 0.42, n), 0.0015, 0.0072) * (
            1 + 0.10 * np.maximum(z - 3, 0) ** 0.9
        )
        hue = np.clip(noise_field(x, z, 0.7, 19.0, 3) + rng.normal(0, 0.16, n), 0, 1)[:, None]
        fresh = np.array([0.082, 0.170, 0.030]) * (1 - hue) + np.array([0.185, 0.212, 0.046]) * hue
        dry = (rng.uniform(0, 1, n) < 0.10 + 0.10 * smooth_ramp(3, 12, z))[:, None]
        tip = np.where(dry, [0.46, 0.36, 0.17], fresh * [1.15, 1.12, 1.0]) * rng.normal(1, 0.12, (n, 1))
        foot = np.where(dry, [0.26, 0.22, 0.09], fresh * [0.75, 0.72, 0.8]) * rng.normal(1, 0.10, (n, 1))
        colors = np.clip(np.stack([foot, tip], 1), 0.01, 0.7)
        roots = np.stack([x, ground_height(x, z) - 0.004, z], -1)
        bend = np.clip(rng.gamma(2.4, 0.20, n), 0.03, 1.15)
        add_blades(mesh, roots, np.clip(height, 0.03, 0.52), width, bend, colors, rng, segments, creased)


def _seed_heads(mesh: Mesh, count: int, rng: Generator) -> None:
    """Tall thin grasses whose loose panicles catch the light."""
    z = 2.4 * (14.0 / 2.4) ** rng.uniform(0, 1, count)
    x = z * rng.uniform(-0.60, 0.62, count)
    for k in np.flatnonzero(path_share(x, z) < 0.2):
        foot = np.array([x[k], float(ground_height(x[k], z[k])), z[k]])
        height = rng.uniform(0.34, 0.58) * (1 - 0.3 * float(smooth_ramp(5, 14, z[k])))
        lean = rng.normal(0, 0.10, 3) * [1, 0, 1] + [-0.03, 0, 0]
        t = np.linspace(0, 1, 12)[:, None]
        line = foot + t * [0, height, 0] + t**2.5 * lean
        straw = np.array([0.42, 0.34, 0.17]) * rng.normal(1, 0.1) * (1, 1 - 0.1 * rng.uniform(), 1)
        add_tube(mesh, line, 0.0013 + 0.0003 * z[k], straw * [0.75, 0.9, 0.6], WOOD, 0.2 + 0.8 * t[:, 0], 4)
        n = 34
        up = rng.uniform(0.70, 1.0, n)
        place = foot + up[:, None] * [0, height, 0] + (up**2.5)[:, None] * lean
        place = place + rng.normal(0, 0.011, (n, 3)) * (1.25 - up[:, None]) * 3
        facing = rng.normal(0, 1, (n, 3)) * [1, 0.3, 1]
        grain = leaf_diamonds(place, facing, 0.0045 * rng.uniform(0.6, 1.2, n) * (1 + 0.05 * z[k]), rng)
        mesh.add(grain, straw, FOLIAGE, 1.0)


def _drift(mesh: Mesh, bloom: Bloom, count: int, z_low: float, z_high: float, seed: float, height: float,
           radius: float, rng: Generator) -> None:  # fmt: skip
    """Flowers of one kind, gathered in drifts off the path."""
    z = z_low * (z_high / z_low) ** rng.uniform(0, 1, 8 * count)
    x = z * rng.uniform(-0.60, 0.60, 8 * count)
    wish = noise_field(x, z, 0.55, seed, 3) + rng.normal(0, 0.05, len(x)) - path_share(x, z)
    # Nothing may stand before or right behind the near flower.
    wish = wish - 2.0 * ((z < 3.4) & (x / z < -0.02) & (x / z > -0.42))
    for k in np.argsort(-wish, kind="stable")[:count]:
        root = np.array([x[k], float(ground_height(x[k], z[k])), z[k]])
        axis = rng.normal([0.30, 1.0, -0.55], [0.35, 0.2, 0.35])
        tall = height * rng.uniform(0.75, 1.25) * (1 - 0.35 * float(smooth_ramp(5, 20, z[k])))
        size = radius * rng.uniform(0.75, 1.15) * (1 + 0.02 * z[k])
        add_flower(mesh, root, tall, axis, size, bloom, 1 if z[k] < 4.5 else 0, rng)


def _place(px: float, py: float, z: float) -> DoubleArray:
    """World point at depth `z` seen at the pixel (px, py) of the full picture."""
    right, down = (px - WIDTH / 2) / FOCAL_PX * z, (py - HEIGHT / 2) / FOCAL_PX * z
    return np.array([right, EYE_HEIGHT - down * np.cos(PITCH) - z * np.sin(PITCH),
                     z * np.cos(PITCH) - down * np.sin(PITCH)])  # fmt: skip


def _foreground(mesh: Mesh, rng: Generator) -> None:
    """The near daisy with its leaves, its companions, and the stones."""
    hero = _place(322, 292, 0.93)
    foot = np.array([hero[0] + 0.075, 0.0, 1.0])
    add_flower(mesh, foot, 0.0, [0.26, 0.40, -0.88], 0.157, DAISY, 2, rng, head=hero)
    green = np.array([0.095, 0.165, 0.035])
    for share, heading, length in ((0.56, (0.75, 0.80, 0.30), 0.14), (0.40, (-0.9, 0.4, -0.35), 0.16),
                                   (0.66, (-0.6, 0.65, -0.2), 0.08)):  # fmt: skip
        at = foot + (hero - foot) * share + [0.012, 0, 0]
        add_leaf(mesh, at, heading, length, 0.21 * length, 0.40, green * rng.normal(1.0, 0.08), rng, 0.55)
    at = _place(556, 640, 1.34)
    for heading, length, width in (
        ((0.55, 0.55, -0.35), 0.30, 0.070),
        ((-0.85, 0.55, -0.25), 0.24, 0.055),
        ((0.16, 0.85, 0.45), 0.27, 0.068),
        ((0.95, 0.3, 0.25), 0.22, 0.05),
    ):
        add_leaf(mesh, at - [0, 0.10, 0], heading, length, width, 0.42, green * [1.1, 1.05, 1.0], rng)
    for px, py, z, radius, axis in (
        (806, 418, 1.95, 0.135, (0.10, 0.62, -0.75)),
        (952, 492, 1.75, 0.120, (0.45, 0.75, -0.45)),
        (92, 470, 1.85, 0.125, (0.35, 0.85, -0.40)),
        (486, 474, 2.30, 0.115, (0.25, 0.80, -0.55)),
    ):
        head = _place(px, py, z)
        root = [head[0] + rng.normal(0, 0.06), float(ground_height(head[0], head[2])), head[2] + 0.03]
        add_flower(mesh, root, 0.0, axis, radius, DAISY, 2 if z < 2.0 else 1, rng, head=head)
    for px, py, z, radius, axis in ((1010, 352, 2.35, 0.125, (-0.1, 0.75, -0.55)),
                                    (890, 404, 3.0, 0.125, (0.3, 0.7, -0.5)),
                                    (640, 402, 3.3, 0.12, (0.2, 0.6, -0.7))):  # fmt: skip
        head = _place(px, py, z)
        root = [head[0] + rng.normal(0, 0.05), float(ground_height(head[0], head[2])), head[2]]
        add_flower(mesh, root, 0.0, axis, radius, POPPY, 1, rng, head=head)
    for x, z, radius in ((1.32, 3.7, 0.13), (1.10, 3.5, 0.05), (0.62, 4.6, 0.06), (0.52, 4.9, 0.10),
                         (1.55, 5.2, 0.09), (-1.9, 6.5, 0.16), (1.9, 7.0, 0.14)):  # fmt: skip
        add_stone(mesh, x, z, radius, rng)


def meadow_mesh(seed: int) -> tuple[FloatArray, NDArray[np.int32], NDArray[np.int8]]:
    """Vertices (v, k), triangles (t, 3) and materials (t,) of everything that stands on the meadow."""
    mesh = Mesh()
    for k, make in enumerate((_foreground, _grass, _flowers, _woods)):
        make(mesh, np.random.default_rng((seed, k)))
    add_land(mesh)
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
        add_tree(mesh, x, z, height, color, rng, spread)
    add_forest(mesh, 150, 20.5, 24.0, 0.30, 260, 0.75, rng)
    add_forest(mesh, 900, 24.0, 32.0, 0.29, 150, 0.88, rng)
    add_forest(mesh, 4200, 33.0, 43.0, 0.27, 70, 0.97, rng)
    add_forest(mesh, 9000, 45.0, 53.0, 0.25, 32, 1.0, rng)
