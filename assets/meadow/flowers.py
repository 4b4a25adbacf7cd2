"""Flowers: petals in whorls, florets on a disc in a spiral of sunflowers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from meadow.noise import smooth_ramp
from meadow.sheets import Mesh, add_tube, frame_about
from meadow.world import FLORET, PETAL, WOOD, DoubleArray, Generator


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
    notch = bloom.notch * np.cos(2.6 * np.pi * v + rng.normal(0, 0.5, one)) * smooth_ramp(0.8, 1, t)
    radius = 0.75 * bloom.disc + length * t * (1 - 0.065 * v**2 + notch)
    tip = np.sqrt(np.clip(1 - (np.clip(t - 0.70, 0, 1) / 0.30) ** 2 * 0.80, 0, 1))
    width = bloom.half_width * (0.34 + 0.66 * smooth_ramp(0.0, 0.55, t)) * tip * rng.normal(1.0, 0.08, one)
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
    basis = frame_about(out)
    opened = smooth_ramp(0.45, 0.72, share + rng.normal(0, 0.06, count))[:, None, None]
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
    frame = frame_about(axis)
    a, b = ((4, 3), (12, 9), (48, 27))[detail]
    for layer in range(bloom.layers if detail else 1):
        count = bloom.petals - 6 * layer if bloom.petals > 8 else bloom.petals
        local = _petal_points(bloom, count, a, b, rng, layer)
        t = np.linspace(0, 1, a)[None, :, None, None]
        hue = rng.normal(1.0, 0.035, (count, 1, 1, 3)) * rng.normal(1.0, 0.05, (count, 1, 1, 1))
        base = 1 - smooth_ramp(0.02, 0.30, t)
        color = (np.asarray(bloom.color) * (1 - base) + np.asarray(bloom.base) * base) * hue
        openness = (0.55 + 0.45 * smooth_ramp(0.0, 0.35, t[..., 0])) * (1.0 - 0.12 * layer)
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


def add_flower(mesh: Mesh, root: ArrayLike, height: float, axis: ArrayLike, radius: float, bloom: Bloom,
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
    add_tube(mesh, line, thick, green, WOOD, 0.25 + 0.75 * t[:, 0], (4, 6, 14)[detail])
    _head(mesh, top, axis, radius, bloom, detail, rng)
