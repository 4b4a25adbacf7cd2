"""Builders: coin, key, crystal, starfish.  z up; about 1 long."""

from functools import lru_cache, partial

import cv2
import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, axes_along, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import CRYSTAL, HIDE, METAL

_PROFILE = [
    (-0.30, -0.62), (-0.26, -0.40), (-0.36, -0.25), (-0.46, 0.0), (-0.44, 0.28), (-0.28, 0.52),
    (-0.02, 0.60), (0.20, 0.50),
    (0.31, 0.32), (0.34, 0.18), (0.33, 0.10), (0.445, -0.06), (0.425, -0.10), (0.36, -0.12),
    (0.375, -0.20), (0.345, -0.24),
    (0.365, -0.29), (0.33, -0.37), (0.22, -0.40), (0.12, -0.37), (0.10, -0.48), (0.20, -0.64),
]  # fmt: skip


def _curl(amount: float, y: DoubleArray) -> DoubleArray:
    return amount * y * y


def coin(rng: np.random.Generator, tint: Tint) -> Body:
    """A worn gold coin with a head in profile; copper and silver by their words."""
    pen = Pen(rng)
    color = tint.color or linear(222, 168, 66)
    metal = pen.material(
        METAL,
        color,
        shaded(color, 0.22),
        rough=0.30,
        metal=1.0,
        wrap=0.05,
        relief=0.026,
        free=(0.75, 0.46, 120.0),
    )
    face = pen.texture(np.ones((baking.SIZE, baking.SIZE), np.float32), _struck())
    spin = float(rng.uniform(-0.4, 0.4))
    axes = np.array([[np.cos(spin), np.sin(spin), 0], [-np.sin(spin), np.cos(spin), 0], [0, 0, 1.0]])
    pen.cylinder((0, 0, 0.026), 0.47, 0.030, 0.010, metal, axes=axes, texture=face)
    return pen.body(tilt_deg=(22.0, 46.0), yaw_deg=90.0)


@lru_cache(maxsize=1)
def _struck() -> FloatArray:
    """The height of the face, 0..1: rim, beads, a head, laurels behind it."""
    n = baking.SIZE
    v, u = baking.texel_grid()
    r = np.hypot(u, v)
    rim = np.clip((r - 0.905) / 0.03, 0, 1)
    angle = np.arctan2(v, u)
    beads = np.clip(1 - np.hypot((r - 0.845) / 0.026, np.sin(36 * angle) / 1.05), 0, 1) ** 0.5
    window = baking.Window((0.0, 0.0), 1.0)
    head = baking.outline_distance(baking.closed_curve(_PROFILE), window, 2)
    inside = np.clip(-head / 0.16, 0, 1)
    height = 0.85 * np.sqrt(np.clip(inside * (2 - inside), 0, 1))
    locks = np.sin(24 * np.hypot(u + 0.05, v - 0.10) + 5 * np.sin(3 * angle))
    hair = np.clip((-0.02 - u + 0.35 * v) / 0.10, 0, 1) * (v > -0.2)
    height = height + 0.10 * locks * hair * (inside > 0.1)
    for x, y, a in ((0.06, 0.16, 0.055), (0.20, 0.10, 0.035)):  # ear and eye
        height -= 0.22 * np.exp(-(((u - x + 0.05) / a) ** 2 + ((v - y + 0.08) / (0.8 * a)) ** 2))
    for k in range(22):  # letters that say nothing, around the edge
        turn = 0.55 + k * 0.17
        for j in range(2):
            a = turn + 0.035 * (j + (k * 7 % 3) * 0.3)
            x, y = 0.70 * np.cos(a), 0.70 * np.sin(a)
            along = np.abs((u - x) * np.cos(a) + (v - y) * np.sin(a)) - 0.055
            across = np.abs(-(u - x) * np.sin(a) + (v - y) * np.cos(a)) - 0.008
            height = np.maximum(
                height, 0.5 * np.clip(1 - np.maximum(along, across) / 0.015, 0, 1) * (head > 0.05)
            )
    relief = np.maximum(np.maximum(rim, 0.7 * beads), np.clip(height, 0, 1))
    soft = cv2.GaussianBlur(relief.astype(np.float32), (0, 0), n / 384)
    return np.stack([soft, soft, soft])


def key(rng: np.random.Generator, tint: Tint) -> Body:
    """An old key: three rings for a bow, a collared shaft, a bit with wards."""
    pen = Pen(rng)
    color = tint.color or linear(196, 150, 74)
    brass = pen.material(METAL, color, shaded(color, 0.16), rough=0.34, metal=1.0, wrap=0.05, free=(0.85,))
    group, z = pen.group(), 0.048
    for x, y in ((0.0, -0.435), (-0.095, -0.315), (0.095, -0.315)):
        pen.torus((x, y, z), 0.088, 0.026, brass, group=group, blend=0.03)
    lying = axes_along(np.array([0.0, 1.0, 0.0]))
    pen.cylinder((0, 0.13, z), 0.034, 0.36, 0.010, brass, group=group, blend=0.02, axes=lying)
    for y, r, half in (
        (-0.205, 0.054, 0.016),
        (-0.165, 0.044, 0.012),
        (0.20, 0.042, 0.010),
        (0.475, 0.040, 0.012),
    ):
        pen.cylinder((0, y, z), r, half, 0.007, brass, group=group, blend=0.012, axes=lying)
    side = float(rng.choice([-1.0, 1.0]))
    pen.box((side * 0.115, 0.385, z), (0.095, 0.085, 0.020), 0.006, brass, group=group, blend=0.012)
    for x, y, a, b in (
        (0.18, 0.385, 0.045, 0.014),
        (0.115, 0.470, 0.014, 0.040),
        (0.145, 0.315, 0.022, 0.026),
    ):
        pen.box((side * x, y, z), (a, b, 0.05), 0.003, brass, group=group, blend=0.004)
        pen.rows[-1][1] = 1.0
    return pen.body(tilt_deg=(24.0, 48.0), yaw_deg=38.0)


def crystal(rng: np.random.Generator, tint: Tint) -> Body:
    """A cluster of amethyst points."""
    pen = Pen(rng)
    color = tint.color or linear(150, 84, 214)
    stone = pen.material(
        CRYSTAL,
        shaded(color, 0.40),
        linear(214, 200, 222),
        rough=0.14,
        wrap=0.3,
        f0=0.06,
        coat=1.0,
        coat_rough=0.03,
        relief=0.0,
        free=(0.35,),
    )
    pen.prism((0, 0, 0.0), axes_along(np.array([0.04, 0.03, 1.0])), 0.145, 1.0, 0.20, stone)
    for k in range(7):
        angle = 0.7 + 2 * np.pi * k / 7 + rng.normal(0, 0.12)
        lean = 0.34 + 0.22 * (k % 2) + rng.normal(0, 0.05)
        length, r = (0.52 if k % 2 else 0.70) * rng.uniform(0.85, 1.15), rng.uniform(0.072, 0.115)
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        axes = axes_along(np.array([out[0] * np.sin(lean), out[1] * np.sin(lean), np.cos(lean)]))
        foot = 0.12 * out + [0, 0, 0.065]
        pen.prism((float(foot[0]), float(foot[1]), float(foot[2])), axes, r, length, 1.7 * r, stone)
    return pen.body(
        tilt_deg=(66.0, 78.0),
        yaw_deg=20.0,
        refractive=True,
        clear=tuple(0.25 + 0.75 * float(c) for c in color),
    )


def starfish(rng: np.random.Generator, tint: Tint) -> Body:
    """A starfish: five tapering arms, their ridges beset with knobs."""
    pen = Pen(rng)
    color = tint.color or linear(226, 98, 36)
    skin = pen.material(
        HIDE, color, shaded(color, 0.55), rough=0.6, wrap=0.35, coat=0.3, coat_rough=0.25, wavelength=0.026,
        free=(0.30, 0.6, 0.25, 1.0, 0.38),
    )  # fmt: skip
    knob = pen.material(
        HIDE,
        linear(250, 214, 168),
        shaded(color, 1.4),
        rough=0.5,
        wrap=0.4,
        coat=0.35,
        coat_rough=0.2,
        wavelength=0.010,
        free=(0.15, 0.4, 0.02, 1.0, 0.2),
    )
    group = pen.group()
    pen.ellipsoid((0, 0, 0.055), (0.165, 0.165, 0.082), skin, group=group, blend=0.08)
    for k in range(5):
        angle = 2 * np.pi * k / 5 + 0.3 + rng.normal(0, 0.06)
        curl = rng.normal(0, 0.13)
        axes = np.array(
            [[-np.sin(angle), np.cos(angle), 0.0], [np.cos(angle), np.sin(angle), 0.0], [0, 0, 1.0]]
        )
        pen.loft(
            [(0.0, 0.05, 0.130, 0.080, 0.055), (0.18, 0.045, 0.098, 0.070, 0.048),
            (0.36, 0.036, 0.062, 0.052, 0.038), (0.47, 0.028, 0.036, 0.032, 0.026),
            (0.52, 0.026, 0.008, 0.008, 0.008)],
            skin, axes=axes, sway=partial(_curl, 2 * curl), group=group, blend=0.07,

        )  # fmt: skip
        for j in range(9):
            t = 0.05 + 0.05 * j
            for row in (-1, 0, 1):
                if row and j > 6:
                    continue
                off = row * (0.055 - 0.006 * j) + 2 * curl * t * t
                high = float(
                    np.interp(t, [0, 0.18, 0.36, 0.47, 0.52], [0.130, 0.115, 0.088, 0.060, 0.034])
                ) - 0.020 * abs(row)
                p = off * axes[0] + t * axes[1] + [0, 0, high]
                r = 0.015 * (1 - 0.06 * j) * (1.15 if row == 0 else 0.9)
                pen.ellipsoid(
                    (float(p[0]), float(p[1]), float(p[2])), (r, r, r), knob, group=group, blend=0.012
                )
    return pen.body(lift=0.045, tilt_deg=(16.0, 40.0), yaw_deg=60.0)
