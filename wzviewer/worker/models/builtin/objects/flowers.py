"""Builders: flowers, a disc of florets in a ring of petals.  z up; about 1 across."""

from dataclasses import dataclass

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, Vector, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import FIBRE, FLORETS, FUR, PETAL
from wzviewer.worker.models.builtin.objects.sheets import Outline, drawn

# Petals, root at (0, 0), tip at y = 1; x is half as wide again as drawn.
_STRAP: Outline = ((-0.05, 0.0), (-0.105, 0.30), (-0.130, 0.62), (-0.105, 0.90), (-0.045, 0.985),
    (0.0, 0.955),
                   (0.05, 0.99), (0.11, 0.89), (0.130, 0.62), (0.100, 0.30), (0.05, 0.0))  # fmt: skip
_FLAME: Outline = ((-0.05, 0.0), (-0.125, 0.25), (-0.165, 0.50), (-0.120, 0.78), (-0.03, 0.985), (0.0, 1.0),
                   (0.03, 0.985), (0.125, 0.76), (0.160, 0.50), (0.120, 0.25), (0.05, 0.0))  # fmt: skip
_FAN: Outline = ((-0.106, 0.0), (-0.396, 0.30), (-0.66, 0.62), (-0.62, 0.88), (-0.33, 1.0), (0.0, 0.965),
    (0.29, 1.0),
                 (0.607, 0.90), (0.66, 0.62), (0.396, 0.30), (0.106, 0.0))  # fmt: skip
_HEART: Outline = ((-0.073, 0.0), (-0.268, 0.35), (-0.439, 0.68), (-0.39, 0.90), (-0.195, 0.985),
    (0.0, 0.90), (0.195, 0.985),
                   (0.403, 0.90), (0.439, 0.68), (0.268, 0.35), (0.073, 0.0))  # fmt: skip


@dataclass(frozen=True)
class Bloom:
    """One species: petal form and colours, number of petals and rings, the disc."""

    outline: Outline
    petal: Vector
    root: Vector
    petals: int
    rings: int
    disc: float
    dome: float
    bud: Vector
    heart: Vector
    length: float
    cup: float
    reach: float = 0.12
    folds: float = 0.5


DAISY = Bloom(
    _STRAP,
    linear(240, 238, 230),
    linear(206, 208, 150),
    19,
    2,
    0.150,
    0.085,
    linear(232, 168, 22),
    linear(206, 178, 40),
    0.345,
    0.10,
)
SUNFLOWER = Bloom(
    _FLAME,
    linear(250, 190, 14),
    linear(214, 116, 8),
    17,
    2,
    0.245,
    0.075,
    linear(112, 62, 22),
    linear(74, 66, 30),
    0.285,
    0.16,
    0.22,
)
POPPY = Bloom(
    _FAN,
    linear(222, 26, 12),
    linear(26, 12, 16),
    4,
    1,
    0.060,
    0.09,
    linear(58, 66, 44),
    linear(92, 104, 60),
    0.440,
    0.55,
    0.16,
    1.0,
)
BLOSSOM = Bloom(
    _HEART,
    linear(250, 206, 214),
    linear(220, 96, 130),
    5,
    1,
    0.060,
    0.05,
    linear(236, 190, 60),
    linear(150, 160, 60),
    0.420,
    0.35,
    0.14,
    0.6,
)


def daisy(rng: np.random.Generator, tint: Tint) -> Body:
    """A daisy; the tint colours its petals."""
    return _flower(rng, tint, DAISY)


def sunflower(rng: np.random.Generator, tint: Tint) -> Body:
    """A sunflower's head."""
    return _flower(rng, tint, SUNFLOWER)


def poppy(rng: np.random.Generator, tint: Tint) -> Body:
    """A poppy."""
    return _flower(rng, tint, POPPY)


def blossom(rng: np.random.Generator, tint: Tint) -> Body:
    """A cherry blossom."""
    return _flower(rng, tint, BLOSSOM)


def _flower(rng: np.random.Generator, tint: Tint, bloom: Bloom) -> Body:
    pen = Pen(rng)
    color = tint.color or bloom.petal
    root = shaded(tint.color, 0.55) if tint.color and bloom.root != POPPY.root else bloom.root
    skin = pen.material(
        PETAL, color, root, rough=0.55, wrap=0.42, thin=0.75, sheen=0.25, coat=0.06, coat_rough=0.3,
        wavelength=0.0045,
        free=(bloom.reach, bloom.folds),
    )  # fmt: skip
    buds = pen.material(
        FLORETS, bloom.bud, bloom.heart, rough=0.65, wrap=0.3,
        wavelength=0.0205 if bloom.disc > 0.1 else 0.013,
        free=(0.48 * bloom.disc,),
    )  # fmt: skip
    green = pen.material(
        FIBRE,
        linear(86, 122, 44),
        linear(120, 146, 70),
        rough=0.6,
        wrap=0.3,
        relief=0.03,
        wavelength=0.02,
        free=(5.0, 0.5),
    )
    z = 0.115
    pen.dome((0, 0, z - 0.010), (bloom.disc, bloom.disc, bloom.dome), -0.030, buds, edge=0.02)
    pen.ellipsoid((0, 0, 0.055), (1.05 * bloom.disc + 0.02, 1.05 * bloom.disc + 0.02, 0.062), green)
    texture = pen.texture(drawn(bloom.outline), None)
    for ring in range(bloom.rings):
        for k in range(bloom.petals):
            angle = 2 * np.pi * (k + 0.5 * ring) / bloom.petals + rng.normal(0, 0.22 / bloom.petals)
            _petal(pen, bloom, texture, skin, float(angle), z - 0.018 - 0.014 * ring - 0.006 * (k % 2), ring)
    if bloom.disc < 0.1:
        _stamens(pen, bloom, z)
    return pen.body(tilt_deg=(14.0, 42.0), yaw_deg=70.0)


def _petal(pen: Pen, bloom: Bloom, texture: int, skin: int, angle: float, z: float, ring: int) -> None:
    """A petal that leaves the disc at `angle`: raised, drooping at its tip, twisted a little."""
    rng = pen.rng
    lift = bloom.cup * (1 - 0.35 * ring) + rng.normal(0, 0.05)
    twist = rng.normal(0, 0.10)
    out = np.array([np.cos(angle), np.sin(angle), 0.0])
    along = np.array([out[0] * np.cos(lift), out[1] * np.cos(lift), np.sin(lift)])
    flat = np.array([-out[1], out[0], 0.0])
    normal = np.cross(flat, along)
    across = np.cos(twist) * flat + np.sin(twist) * normal
    axes = np.stack([across, along, np.cross(across, along)])
    length = bloom.length * (1 + rng.normal(0, 0.045)) * (1 - 0.06 * ring)
    points = np.asarray(bloom.outline)
    half = float(np.ptp(points, axis=0).max()) / 2 * 1.12
    start = 0.80 * bloom.disc * out + [0, 0, z]
    place = start + length * 0.5 * along
    size = length * half
    droop = -0.55 - 0.35 * rng.random()
    bend = (
        0.9 * (1 if bloom.cup < 0.3 else 0.4),
        droop * (1 if bloom.cup < 0.3 else -0.6),
        rng.normal(0, 0.25),
        0.0,
    )
    pen.card(
        (float(place[0]), float(place[1]), float(place[2])), axes, size, 0.0055, bend, texture, skin, (0.0,
        0.0),
        1.1, (0.0, -0.5 / half),
    )  # fmt: skip


def _stamens(pen: Pen, bloom: Bloom, z: float) -> None:
    """Threads with dusty heads around the pistil."""
    thread = pen.material(
        FIBRE, bloom.root, shaded(bloom.root, 1.4), rough=0.6, relief=0.03, wavelength=0.01, free=(4.0, 0.4)
    )
    head = pen.material(
        FUR, shaded(bloom.bud, 1.1), rough=0.8, wavelength=0.004, relief=0.06, free=(1.0, 0.3)
    )
    for k in range(22):
        angle = 2.4 * k + pen.rng.normal(0, 0.1)
        far = 0.08 + 0.05 * pen.rng.random()
        tip = (
            far * float(np.cos(angle)),
            far * float(np.sin(angle)),
            z + 0.05 + 0.05 * float(pen.rng.random()),
        )
        root = (0.25 * tip[0], 0.25 * tip[1], z)
        pen.tube(
            (root, (0.6 * tip[0], 0.6 * tip[1], 0.75 * z + 0.25 * tip[2] + 0.02), tip), 0.003, 0.0022, thread
        )
        pen.ellipsoid(tip, (0.0095, 0.0075, 0.007), head)
