"""Builders of plain things: a brick, a pebble, a drop of water."""

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import PLASTIC, STONE, WATER


def brick(rng: np.random.Generator, tint: Tint) -> Body:
    """A toy brick of two by four studs, which bear no print."""
    pen = Pen(rng)
    color = tint.color or linear(196, 20, 16)
    plastic = pen.material(PLASTIC, color, rough=0.42, wrap=0.12, coat=0.75, coat_rough=0.13, relief=0.01)
    half_x, half_y, height, pitch = 0.25, 0.50, 0.30, 0.25
    group = pen.group()
    pen.box((0, 0, height / 2), (half_x, half_y, height / 2), 0.010, plastic, group=group, blend=0.006)
    for x in (-0.5, 0.5):
        for y in (-1.5, -0.5, 0.5, 1.5):
            pen.cylinder(
                (x * pitch, y * pitch, height + 0.020), 0.076, 0.040, 0.010, plastic, group=group, blend=0.006
            )
    return pen.body(tilt_deg=(42.0, 62.0), yaw_deg=32.0)


def pebble(rng: np.random.Generator, tint: Tint) -> Body:
    """A rounded stone: a few ellipsoids melted together."""
    pen = Pen(rng)
    color = tint.color or linear(*(int(v) for v in rng.integers(116, 150, 1).repeat(3) - (0, 6, 16)))
    stone = pen.material(
        STONE, color, shaded(color, 0.62), rough=0.75, wrap=0.12, coat=0.10, coat_rough=0.35, wavelength=0.016
    )
    group = pen.group()
    pen.ellipsoid((0, 0, 0.215), (0.33, 0.42, 0.22), stone, group=group, blend=0.16)
    for _ in range(3):
        x, y = rng.uniform(-0.18, 0.18), rng.uniform(-0.28, 0.28)
        radii = tuple(float(v) for v in rng.uniform((0.18, 0.22, 0.13), (0.25, 0.30, 0.19)))
        pen.ellipsoid((x, y, 0.20 + rng.uniform(0, 0.06)), radii, stone, group=group, blend=0.16)  # type: ignore[arg-type]
    return pen.body(tilt_deg=(40.0, 66.0), yaw_deg=20.0)


def drop(rng: np.random.Generator, tint: Tint) -> Body:
    """A drop of water with three or four droplets beside it; clear, so the background bends in it."""
    pen = Pen(rng)
    water = pen.material(WATER, (0.0, 0.0, 0.0), rough=0.04, wrap=0.0, f0=0.02, coat=1.0, coat_rough=0.05)
    group = pen.group()
    pen.dome((0, 0, 0.0), (0.30, 0.28, 0.185), 0.004, water, edge=0.02, group=group, blend=0.10)
    pen.dome((0.10, 0.06, 0.0), (0.22, 0.24, 0.150), 0.004, water, edge=0.02, group=group, blend=0.10)
    for angle in rng.uniform(0, 2 * np.pi) + np.array([0.0, 1.7, 2.9, 4.6]):
        far, r = rng.uniform(0.42, 0.60), rng.uniform(0.030, 0.095)
        pen.dome(
            (far * np.cos(angle), far * np.sin(angle), 0.0),
            (r, r * rng.uniform(0.85, 1.1), 0.6 * r),
            0.002,
            water,
            edge=0.008,
        )
    return pen.body(tilt_deg=(0.0, 58.0), yaw_deg=20.0, refractive=True)
