"""Trees, forests on the hills, stones, the land itself."""

import numpy as np
from numpy.typing import ArrayLike

from meadow.ground import ground_height, path_share
from meadow.noise import noise_field, smooth_ramp
from meadow.sheets import Mesh, add_tube, frame_about
from meadow.world import FAR, FOLIAGE, GROUND, NEAR, STONE, WOOD, DoubleArray, Generator


def leaf_diamonds(
    centres: DoubleArray, normals: DoubleArray, size: DoubleArray, rng: Generator
) -> DoubleArray:
    """Small rhombic leaves, (n, 2, 2, 3), roughly facing `normals` (n, 3)."""
    n = len(centres)
    facing = frame_about(normals + rng.normal(0, 0.55, (n, 3)))
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
    points = leaf_diamonds(place.reshape(-1, 3), out.reshape(-1, 3), size.ravel(), rng)
    soft = out.reshape(-1, 3) + rng.normal(0, 0.30, (n * leaves, 3))
    soft /= np.linalg.norm(soft, axis=-1, keepdims=True)
    tint = np.repeat(colors, leaves, 0) * rng.normal(1, 0.14, (n * leaves, 1))
    tint = tint * rng.normal(1, 0.05, (n * leaves, 3))
    mesh.add(points, np.clip(tint, 0.004, 0.6)[:, None, None], FOLIAGE,
             np.clip(openness, 0.08, 1).reshape(-1, 1, 1), normals=soft[:, None, None])  # fmt: skip


def add_tree(mesh: Mesh, x: float, z: float, height: float, color: ArrayLike, rng: Generator,
          spread: float = 0.36, balls: int = 54, leaves: int = 800) -> None:  # fmt: skip
    """A broad-leaved tree: trunk, limbs, and balls of foliage at the limbs' ends."""
    foot = np.array([x, float(ground_height(x, z)) - 0.02, z])
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
    add_tube(mesh, foot + (heart - foot) * t + bow, 0.026 * height * (1.25 - t[:, 0]) ** 1.2 + 0.006 * height,
          [0.085, 0.062, 0.042], WOOD, 0.35 + 0.3 * (1 - t[:, 0]))  # fmt: skip
    for k in range(0, balls, 3):
        start = foot + (heart - foot) * rng.uniform(0.45, 0.9)
        knee = 0.5 * (start + balls_at[k]) - [0, 0.05 * height, 0]
        line = (1 - t) ** 2 * start + 2 * t * (1 - t) * knee + t**2 * balls_at[k]
        add_tube(mesh, line, 0.014 * height * (1.1 - t[:, 0]), [0.075, 0.055, 0.038], WOOD, 0.45, 5)
    colors = 1.2 * np.asarray(color) * rng.normal(1, 0.15, (balls, 1)) * rng.normal(1, 0.05, (balls, 3))
    _crowns(mesh, balls_at, radii, colors, leaves, 0.092, rng, heart)


def add_forest(mesh: Mesh, count: int, z_low: float, z_high: float, size: float, leaves: int, cover: float,
            rng: Generator) -> None:  # fmt: skip
    """Far woods: crowns in drifts on the hills."""
    z = rng.uniform(z_low, z_high, 6 * count)
    x = z * rng.uniform(-0.60, 0.60, 6 * count)
    wooded = noise_field(x, z * 0.7, 0.11, 63.0 + z_low, 3) + rng.normal(0, 0.02, len(x))
    keep = np.argsort(-wooded, kind="stable")[: int(count * cover)]
    stray = rng.choice(len(x), int(count * (1 - cover)), replace=False)
    pick = np.concatenate([keep, stray])
    x, z = x[pick], z[pick]
    radii = size * rng.uniform(0.55, 1.15, len(x))
    centres = np.stack([x, ground_height(x, z) + 0.70 * radii, z], -1)
    hue = (
        np.array([0.040, 0.072, 0.022]) * rng.normal(1, 0.18, (len(x), 1)) * rng.normal(1, 0.10, (len(x), 3))
    )
    _crowns(mesh, centres, radii, np.clip(hue, 0.008, 1), leaves, 0.26, rng)


def add_stone(mesh: Mesh, x: float, z: float, radius: float, rng: Generator) -> None:
    """A weathered stone, half sunk."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 40), np.linspace(0, 2 * np.pi, 64), indexing="ij")
    out = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    seed = rng.uniform(0, 90)
    lump = noise_field(out[..., 0] + 0.7 * out[..., 1] + 9, out[..., 2] - 0.6 * out[..., 1] + 9, 1.6, seed, 5)
    # Flattening the lumps at two levels gives the broken faces of a field stone.
    faceted = 0.55 * np.minimum(lump, 0.54) + 0.45 * lump
    shape = out * (0.55 + 0.9 * faceted)[..., None] * np.array([1.15, 0.72, 0.95]) * radius
    centre = np.array([x, float(ground_height(x, z)) + 0.15 * radius, z])
    openness = 0.25 + 0.75 * np.clip((out[..., 1] + 0.5) / 1.0, 0, 1)
    mesh.add(
        (centre + shape)[None], np.array([0.24, 0.225, 0.20]) * rng.normal(1, 0.12), STONE, openness[None]
    )


def add_land(mesh: Mesh) -> None:
    """The ground as one sheet, finer where it is near, coloured by what grows on it."""
    z = np.geomspace(NEAR, FAR, 820)[:, None]
    slope = np.linspace(-0.66, 0.66, 620)[None, :]
    x = slope * z
    z = np.broadcast_to(z, x.shape)
    y = ground_height(x, z)
    patch = noise_field(x, z, 0.35, 5.0)[..., None]
    litter = np.array([0.085, 0.066, 0.034]) * (1 - patch) + np.array([0.070, 0.085, 0.026]) * patch
    sward = np.array([0.105, 0.150, 0.036]) * (1 - patch) + np.array([0.190, 0.195, 0.060]) * patch
    far = smooth_ramp(4.0, 14.0, z)[..., None]
    color = litter * (1 - far) + sward * far
    plots = noise_field(
        np.floor(x * 0.16 + 0.8 * noise_field(x, z, 0.05, 71.0, 2)), np.floor(z * 0.35), 1.37, 77.0, 1
    )
    field_tint = np.stack(
        [0.115 + 0.24 * smooth_ramp(0.55, 0.8, plots), 0.165 + 0.12 * plots, 0.045 + 0.05 * plots], -1
    )
    farm = (smooth_ramp(21.0, 24.5, z) * (1 - 0.5 * smooth_ramp(38, 50, z)))[..., None]
    color = color * (1 - farm) + field_tint * farm
    path = path_share(x, z)[..., None]
    color = color * (1 - path) + np.array([0.270, 0.205, 0.135]) * path
    near_shade = 0.42 + 0.58 * np.maximum(smooth_ramp(5.0, 12.0, z), path[..., 0])
    mesh.add(np.stack([x, y, z], -1)[None], color, GROUND, near_shade[None])
