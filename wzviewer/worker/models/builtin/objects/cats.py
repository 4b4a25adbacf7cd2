"""Builder: a sitting cat.  y forward, z up; about 0.9 high."""

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Mark, Pen, Tint, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import FUR, HAIR, PLAIN

WHITE = linear(236, 228, 216)


def cat(rng: np.random.Generator, tint: Tint) -> Body:
    """A ginger tabby with a white bib, sitting; the tint colours its coat, plain leaves out the stripes."""
    pen = Pen(rng)
    color = tint.color or linear(214, 138, 66)
    stripes = (
        0.0 if tint.pattern == "plain" or (tint.color is not None and tint.pattern != "striped") else 0.75
    )
    bib = (
        Mark((0.0, 0.27, 0.43), (0.085, 0.12, 0.15), WHITE, 0.14, 0.10),
        Mark((0.0, 0.315, 0.640), (0.062, 0.065, 0.045), WHITE, 0.16, 0.08),
        Mark((0.075, 0.22, 0.02), (0.085, 0.11, 0.085), WHITE, 0.12, 0.08),
    )
    second = shaded(color, 0.42)
    coat = pen.material(
        FUR,
        color,
        second,
        rough=0.75,
        wrap=0.4,
        sheen=0.35,
        f0=0.01,
        wavelength=0.0075,
        relief=0.040,
        free=(9.0, 0.17, stripes, 0.115, 0.055, 0.42, 2.2e-4),
        marks=bib,
    )
    inner = pen.material(
        FUR,
        linear(228, 176, 162),
        shaded(color, 0.8),
        rough=0.7,
        wrap=0.5,
        f0=0.01,
        wavelength=0.006,
        relief=0.02,
        free=(4.0, 0.12, 0.0, 0.1, 0.03, 0.3, 2.2e-4),
    )
    body = pen.group()
    pen.ellipsoid((0, -0.13, 0.215), (0.205, 0.215, 0.205), coat, group=body, blend=0.12)
    pen.ellipsoid((0, 0.00, 0.340), (0.165, 0.190, 0.220), coat, group=body, blend=0.14)
    pen.ellipsoid((0, 0.105, 0.435), (0.132, 0.125, 0.165), coat, group=body, blend=0.12)
    pen.cone((0, 0.11, 0.52), (0, 0.165, 0.64), 0.100, 0.090, coat, group=body, blend=0.08)
    for side in (-1.0, 1.0):
        pen.ellipsoid((side * 0.145, -0.055, 0.155), (0.080, 0.165, 0.150), coat, group=body, blend=0.06)
        pen.ellipsoid((side * 0.165, 0.10, 0.038), (0.048, 0.105, 0.040), coat, group=body, blend=0.05)
        pen.cone(
            (side * 0.075, 0.150, 0.40),
            (side * 0.072, 0.185, 0.075),
            0.066,
            0.042,
            coat,
            group=body,
            blend=0.05,
        )
        pen.ellipsoid((side * 0.072, 0.215, 0.036), (0.048, 0.066, 0.038), coat, group=body, blend=0.03)
        for k in (-1, 0, 1):
            pen.ellipsoid(
                (side * 0.072 + 0.024 * k, 0.262, 0.026), (0.015, 0.022, 0.020), coat, group=body, blend=0.012
            )
    turn = float(rng.choice([-1.0, 1.0]))
    pen.tube(
        ((turn * 0.06, -0.30, 0.07), (turn * 0.36, -0.22, 0.02), (turn * 0.30, 0.10, 0.045)),
        0.048,
        0.040,
        coat,
        group=body,
        blend=0.05,
    )
    pen.tube(
        ((turn * 0.30, 0.10, 0.045), (turn * 0.26, 0.22, 0.05), (turn * 0.16, 0.30, 0.045)),
        0.040,
        0.026,
        coat,
        group=body,
        blend=0.03,
    )
    _head(pen, coat, inner)
    return pen.body(tilt_deg=(76.0, 85.0), yaw_deg=-42.0, nose=(0.0, 0.330, 0.683))


def _head(pen: Pen, coat: int, inner: int) -> None:
    """A round head: muzzle, nose, slit eyes, ears with pink insides, whiskers."""
    nose = pen.material(PLAIN, linear(206, 118, 112), rough=0.5, coat=0.5, coat_rough=0.2)
    hair = pen.material(HAIR, linear(244, 240, 232), linear(220, 214, 204), rough=0.4, wrap=0.4)
    dark = pen.material(PLAIN, linear(48, 30, 26), rough=0.6)
    head = pen.group()
    pen.ellipsoid((0, 0.185, 0.700), (0.132, 0.122, 0.115), coat, group=head, blend=0.06)
    pen.ellipsoid((0, 0.270, 0.668), (0.070, 0.062, 0.055), coat, group=head, blend=0.05)
    pen.ellipsoid((0, 0.262, 0.628), (0.046, 0.044, 0.030), coat, group=head, blend=0.03)
    pen.ellipsoid((0, 0.326, 0.683), (0.0165, 0.012, 0.0125), nose, group=pen.group())
    iris = linear(150, 168, 52)
    for side in (-1.0, 1.0):
        pen.ellipsoid((side * 0.028, 0.303, 0.648), (0.034, 0.030, 0.026), coat, group=head, blend=0.02)
        pen.ellipsoid((side * 0.085, 0.195, 0.665), (0.066, 0.075, 0.060), coat, group=head, blend=0.06)
        tip = (side * 0.118, 0.155, 0.870)
        pen.cone((side * 0.080, 0.160, 0.765), tip, 0.062, 0.010, coat, group=head, blend=0.03)
        pen.cone(
            (side * 0.083, 0.190, 0.765), (side * 0.112, 0.172, 0.845), 0.044, 0.008, inner, group=pen.group()
        )
        pupil = Mark((0.0585, 0.300, 0.722), (0.0075, 0.05, 0.0210), linear(8, 8, 8), 0.12, 0.0)
        eye = pen.material(PLAIN, iris, rough=0.25, coat=1.0, coat_rough=0.03, marks=(pupil,))
        pen.ellipsoid((side * 0.0555, 0.272, 0.722), (0.0275, 0.024, 0.0235), eye)
        pen.tube(
            ((side * 0.026, 0.2870, 0.716), (side * 0.055, 0.303, 0.7495), (side * 0.089, 0.268, 0.732)),
            0.0065,
            0.004,
            dark,
        )
        pen.tube(
            ((0, 0.330, 0.668), (side * 0.012, 0.334, 0.648), (side * 0.036, 0.322, 0.643)),
            0.0038,
            0.0022,
            dark,
        )
        for k in range(5):
            root = (side * (0.034 + 0.004 * k), 0.322 - 0.003 * k, 0.655 - 0.007 * k)
            spread = 0.05 - 0.025 * k
            tip = (side * (0.235 + 0.01 * (k % 3)), 0.335 - 0.02 * k, 0.665 + spread)
            middle = (side * 0.13, 0.37, 0.670 + 0.7 * spread)
            pen.tube((root, middle, tip), 0.0016, 0.0006, hair, shadow=False)
