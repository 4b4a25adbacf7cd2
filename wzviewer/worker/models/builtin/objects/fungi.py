"""Builder: a fly agaric with a young one beside it.  z up; about 1 high."""

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, Vector, linear
from wzviewer.worker.models.builtin.objects.patterns import CAP, FIBRE, GILLS, HIDE

_UP = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])


def mushroom(rng: np.random.Generator, tint: Tint) -> Body:
    """A red cap with white warts on a ringed stem; the tint colours the cap, plain leaves out the warts."""
    pen = Pen(rng)
    color = tint.color or linear(206, 24, 10)
    warts = 0.0 if tint.pattern == "plain" else 0.62
    _one(pen, (0.0, 0.0), 1.0, 0.36, color, warts)
    side = float(rng.choice([-1.0, 1.0]))
    _one(pen, (0.16, side * 0.42), 0.50, 0.17, color, warts)
    return pen.body(tilt_deg=(68.0, 80.0), yaw_deg=20.0)


def _one(pen: Pen, at: tuple[float, float], high: float, wide: float, color: Vector, warts: float) -> None:
    x, y = at
    lean = pen.rng.normal(0, 0.03, 2)
    skin = pen.material(
        CAP, color, linear(240, 232, 210), rough=0.36, wrap=0.25, coat=0.55, coat_rough=0.16,
        wavelength=0.27 * wide,
        free=(warts, wide),
    )  # fmt: skip
    flesh = pen.material(
        FIBRE,
        linear(236, 228, 206),
        linear(206, 188, 150),
        rough=0.65,
        wrap=0.35,
        relief=0.03,
        wavelength=0.05 * high,
        free=(6.0, 0.55),
    )
    blades = pen.material(GILLS, linear(240, 232, 212), rough=0.7, wrap=0.3, free=(90.0,))
    rough = pen.material(
        HIDE,
        linear(228, 216, 190),
        linear(176, 150, 108),
        rough=0.8,
        wrap=0.3,
        wavelength=0.035 * high,
        free=(0.3, 0.5, 0.1, 0.6, 0.25),
    )
    top = 0.70 * high
    stem = pen.group()
    axes = _UP.copy()
    pen.loft(
        [
            (0.10 * high, 0.0, 0.115 * high, 0.115 * high, 0.115 * high),
            (0.25 * high, 0.0, 0.082 * high, 0.082 * high, 0.082 * high),
            (0.55 * high, 0.0, 0.068 * high, 0.068 * high, 0.068 * high),
            (top + 0.06 * high, 0.0, 0.062 * high, 0.062 * high, 0.062 * high),
        ],
        flesh, centre=(x, y, 0.0), axes=axes, group=stem, blend=0.05 * high,
    )  # fmt: skip
    pen.ellipsoid(
        (x, y, 0.085 * high), (0.135 * high, 0.135 * high, 0.10 * high), rough, group=stem, blend=0.05 * high
    )
    frill = pen.group()
    pen.dome(
        (x, y, 0.52 * high),
        (0.125 * high, 0.125 * high, 0.085 * high),
        -0.012 * high,
        flesh,
        edge=0.015 * high,
        group=frill,
    )
    cap = pen.group()
    cx, cy = x + float(lean[0]), y + float(lean[1])
    # Thinned from below by a flat ellipsoid that leaves the gills.
    pen.dome((cx, cy, top), (wide, wide, 0.70 * wide), -0.055 * wide, skin, edge=0.09 * wide, group=cap)
    pen.ellipsoid((cx, cy, top - 0.11 * wide), (0.93 * wide, 0.93 * wide, 0.17 * wide), blades, group=cap)
    pen.rows[-1][1] = 1.0
