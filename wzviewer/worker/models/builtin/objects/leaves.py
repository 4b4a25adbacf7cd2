"""Builders: leaves, a feather and an acorn, as they lie on the ground.  y forward, z up; about 1 long."""

from functools import lru_cache

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, Vector, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import FIBRE, HIDE, LEAF, VANE
from wzviewer.worker.models.builtin.objects.sheets import drawn

_WINDOW = baking.Window((0.0, 0.0), 0.5)
_MAPLE = (
    (0.0, -0.30), (0.10, -0.33), (0.20, -0.37), (0.19, -0.28), (0.34, -0.26), (0.30, -0.18),
    (0.42, -0.10), (0.36, -0.05),
    (0.47, 0.10), (0.35, 0.07), (0.33, 0.14), (0.22, 0.05), (0.17, 0.03), (0.20, 0.20), (0.25, 0.29),
    (0.16, 0.27),
    (0.12, 0.33), (0.09, 0.30), (0.0, 0.47),
)  # fmt: skip


def leaf(rng: np.random.Generator, tint: Tint) -> Body:
    """An ovate, toothed leaf; the tint colours it."""
    color = tint.color or linear(86, 138, 38)
    return _leaf(
        rng, _ovate(), color, linear(176, 190, 104) if tint.color is None else shaded(color, 1.6), 0.0
    )


def maple_leaf(rng: np.random.Generator, tint: Tint) -> Body:
    """A maple leaf in autumn."""
    color = tint.color or linear(226, 128, 20)
    turn = 0.75 if tint.color is None else 0.0
    return _leaf(
        rng, _maple(), color, linear(240, 200, 110) if tint.color is None else shaded(color, 1.5), turn
    )


def _leaf(
    rng: np.random.Generator, baked: tuple[FloatArray, FloatArray], color: Vector, vein: Vector, turn: float
) -> Body:
    pen = Pen(rng)
    blade = pen.material(
        LEAF, color, vein, rough=0.45, wrap=0.3, thin=0.7, coat=0.30, coat_rough=0.22, wavelength=0.012,

        free=(turn, 0.55),
    )  # fmt: skip
    stalk = pen.material(
        FIBRE, vein, shaded(color, 0.8), rough=0.5, wrap=0.3, relief=0.03, wavelength=0.012, free=(6.0, 0.5)
    )
    texture = pen.texture(*baked)
    lean = float(rng.uniform(-0.25, 0.25))
    pen.card((0, 0.06, 0.075), np.eye(3), 0.5, 0.006, (0.30, -0.34, lean, 0.10), texture, blade, (0, 0), 1.1)
    foot = -0.34 * 0.36**2
    pen.tube(((0, -0.27, 0.07 + foot), (0.01, -0.42, 0.03), (0.05, -0.56, 0.012)), 0.011, 0.013, stalk)
    return pen.body(tilt_deg=(18.0, 46.0), yaw_deg=52.0)


@lru_cache(maxsize=1)
def _ovate() -> tuple[FloatArray, FloatArray]:
    """A beech-like leaf: fourteen side veins that bend towards the tip, a tooth at the end of each."""
    t = np.linspace(0, 1, 240)
    width = 0.235 * np.sin(np.pi * t**0.80) ** 0.9 * (1 - 0.15 * t)
    tooth = 0.010 * ((t * 15) % 1.0) * np.sin(np.pi * t)
    y = 0.46 * (2 * t - 1) + 0.0
    right = np.stack([width + tooth, y + 0.5 * tooth], 1)
    ring = np.concatenate([right, right[-2:0:-1] * [-1, 1]])
    veins = []
    for side in (-1.0, 1.0):
        for k in range(1, 14):
            start = -0.40 + 0.058 * k + (0.012 if side > 0 else -0.012)
            reach = float(np.interp(start + 0.10, y, width)) * 0.96
            veins.append(
                np.array([[0.0, start], [side * 0.55 * reach, start + 0.055], [side * reach, start + 0.135]])
            )
    return _bake(ring, [np.array([[0.0, -0.46], [0.0, 0.0], [0.0, 0.455]])], veins)


@lru_cache(maxsize=1)
def _maple() -> tuple[FloatArray, FloatArray]:
    """Five pointed lobes, a main vein into each."""
    right = np.asarray(_MAPLE)
    ring = np.concatenate([right, right[-2:0:-1] * [-1, 1]])
    tips = [(0.0, 0.47), (0.46, 0.10), (-0.46, 0.10), (0.19, -0.36), (-0.19, -0.36)]
    mains = [np.array([[0.0, -0.30], [0.45 * x, -0.30 + 0.5 * (z + 0.30)], [x, z]]) for x, z in tips]
    veins = []
    for x, z in tips[:3]:
        d = np.array([x, z + 0.30]) / np.hypot(x, z + 0.30)
        n = np.array([-d[1], d[0]])
        for k in range(1, 7):
            for side in (-1.0, 1.0):
                base = np.array([0.0, -0.30]) + d * 0.115 * k
                veins.append(
                    np.stack([base, base + 0.06 * d + side * 0.05 * n, base + 0.13 * d + side * 0.10 * n])
                )
    return _bake(_denser(ring), mains, veins)


def _denser(ring: DoubleArray) -> DoubleArray:
    """Returns the polygon with its sides bowed inwards a little, as between a maple's teeth."""
    after = np.roll(ring, -1, 0)
    middle = 0.5 * (ring + after) * 0.985
    return np.stack([ring, middle], 1).reshape(-1, 2)


def _bake(
    ring: DoubleArray, mains: list[DoubleArray], sides: list[DoubleArray]
) -> tuple[FloatArray, FloatArray]:
    flat = baking.outline_distance(ring, _WINDOW, 2)
    main = baking.line_distance([baking.open_curve([tuple(p) for p in v]) for v in mains], _WINDOW, 2)
    side = baking.line_distance([baking.open_curve([tuple(p) for p in v]) for v in sides], _WINDOW, 2)
    return flat, np.stack([main, np.minimum(side, main), flat]).astype(np.float32)


def feather(rng: np.random.Generator, tint: Tint) -> Body:
    """A barred flight feather that curls up from the ground."""
    pen = Pen(rng)
    color = tint.color or linear(196, 172, 138)
    second = shaded(tint.color, 0.35) if tint.color else linear(72, 52, 38)
    vane = pen.material(
        VANE, color, second, rough=0.6, wrap=0.4, thin=0.5, sheen=0.2, wavelength=0.0075,
        free=(0.155, 0.0 if tint.pattern == "plain" else 0.9, -0.30), sheet=True,
    )  # fmt: skip
    quill = pen.material(
        FIBRE,
        linear(226, 214, 186),
        linear(196, 176, 140),
        rough=0.35,
        coat=0.5,
        coat_rough=0.15,
        relief=0.03,
        wavelength=0.006,
        free=(9.0, 0.4),
    )
    outline = (
        (-0.012, -0.42), (-0.075, -0.36), (-0.085, -0.22), (-0.092, 0.0), (-0.088, 0.22), (-0.062, 0.38),
        (-0.015, 0.475),
        (0.02, 0.48), (0.055, 0.40), (0.066, 0.22), (0.062, 0.0), (0.056, -0.20), (0.062, -0.34),
        (0.012, -0.42),
    )  # fmt: skip
    texture = pen.texture(drawn(outline), None)
    half = 0.90 / 2 * 1.12
    bend = (-0.9, 0.18, 0.10, 0.0)
    pen.card((0, 0.03, 0.020), np.eye(3), half, 0.005, bend, texture, vane, (0, 0), 1.05, (0, 0))
    pen.tube(((0, -0.56, 0.078), (0, -0.26, 0.020), (0, 0.02, 0.020)), 0.0115, 0.0080, quill)
    pen.tube(((0, 0.02, 0.020), (0, 0.25, 0.026), (0.004, 0.49, 0.060)), 0.0080, 0.0018, quill)
    return pen.body(lift=-0.012, tilt_deg=(14.0, 42.0), yaw_deg=40.0)


def acorn(rng: np.random.Generator, tint: Tint) -> Body:
    """An acorn on its side, in its cup."""
    pen = Pen(rng)
    color = tint.color or linear(162, 102, 44)
    nut = pen.material(
        FIBRE,
        color,
        shaded(color, 0.55),
        rough=0.32,
        wrap=0.2,
        coat=0.85,
        coat_rough=0.10,
        relief=0.012,
        wavelength=0.035,
        free=(9.0, 0.30),
    )
    cup = pen.material(
        HIDE,
        linear(128, 104, 74),
        linear(88, 68, 46),
        rough=0.75,
        wrap=0.25,
        wavelength=0.048,
        free=(0.30, 0.5, 0.1, 1.0, 0.55),
    )
    stalk = pen.material(
        FIBRE,
        linear(112, 90, 58),
        linear(80, 62, 40),
        rough=0.7,
        relief=0.03,
        wavelength=0.02,
        free=(6.0, 0.5),
    )
    turn = np.radians(-8.0)
    axes = np.array([[1, 0, 0], [0, np.sin(turn), -np.cos(turn)], [0, np.cos(turn), np.sin(turn)]])
    body = pen.group()
    pen.ellipsoid((0, 0.09, 0.235), (0.215, 0.215, 0.345), nut, axes=axes, group=body, blend=0.02)
    pen.ellipsoid((0, 0.425, 0.198), (0.026, 0.026, 0.050), nut, axes=axes, group=body, blend=0.04)
    back = -axes
    pen.dome(
        (0, -0.075, 0.252),
        (0.262, 0.262, 0.240),
        -0.055,
        cup,
        edge=0.05,
        axes=np.stack([axes[0], axes[1], back[2]]),
    )
    pen.tube(((0, -0.30, 0.275), (0.01, -0.40, 0.29), (0.05, -0.47, 0.25)), 0.034, 0.022, stalk)
    return pen.body(tilt_deg=(52.0, 72.0), yaw_deg=14.0)
