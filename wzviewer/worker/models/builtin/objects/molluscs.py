"""Builders: a conch shell and a garden snail.  y forward, z up; about 1 long."""

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, HIDE, PLAIN, SHELL


def conch(rng: np.random.Generator, tint: Tint) -> Body:
    """A sea snail's shell, its knobbed spire to one side, its rosy mouth open to the viewer."""
    pen = Pen(rng)
    color = tint.color or linear(236, 214, 178)
    second = shaded(tint.color, 0.45) if tint.color else linear(172, 98, 52)
    outside = pen.material(
        SHELL, color, second, rough=0.5, wrap=0.25, coat=0.35, coat_rough=0.18, wavelength=0.02,
        free=(2.0, 0.30, 0.8, 0.005, 1.0),
    )  # fmt: skip
    lip = pen.material(
        SHELL, linear(244, 168, 142), linear(250, 206, 184), rough=0.3, wrap=0.4, coat=0.6, coat_rough=0.14,
        free=(1.0, 0.5, 0.0, 0.02, 0.0),
    )  # fmt: skip
    # The axis lies along y, the spire backwards; the mouth opens upwards and to the viewer's side.
    roll = -0.9 + float(rng.uniform(-0.15, 0.15))
    axes = np.array([[np.cos(roll), 0.0, np.sin(roll)], [np.sin(roll), 0.0, -np.cos(roll)], [0.0, 1.0, 0.0]])
    group = pen.group()

    def whorls(
        radius: float, tube: float, turns: tuple[float, float], material: int, *,
        flat: float, knobs: float, flare: float, cut: bool,
    ) -> None:  # fmt: skip
        pen.spiral(
            radius, 0.075, 0.56, tube, turns, material, centre=(0.0, -0.60, 0.255), axes=axes, group=group,
            flat=flat, knobs=(knobs, 8.0), slant=0.32, flare=flare, blend=0.02, cut=cut,
        )  # fmt: skip

    whorls(0.095, 0.135, (-26.0, 1.2), outside, flat=1.9, knobs=0.32, flare=0.25, cut=False)
    pen.cone((0.0, 0.10, 0.25), (0.03, 0.50, 0.20), 0.085, 0.028, outside, group=group, blend=0.10)
    # The mouth is a long slit along the axis: a round one makes a bowl of it.
    whorls(0.14, 0.07, (-1.5, 2.2), lip, flat=2.6, knobs=0.0, flare=0.3, cut=True)
    return pen.body(lift=0.065, tilt_deg=(48.0, 66.0), yaw_deg=150.0, turns=False)


def snail(rng: np.random.Generator, tint: Tint) -> Body:
    """A garden snail on its way."""
    pen = Pen(rng)
    color = tint.color or linear(214, 176, 118)
    second = shaded(tint.color, 0.3) if tint.color else linear(84, 50, 28)
    house = pen.material(
        SHELL, color, second, rough=0.42, wrap=0.25, coat=0.55, coat_rough=0.14, wavelength=0.02,
        free=(3.0, 0.9, 0.45, 0.018, 0.0),
    )  # fmt: skip
    skin = pen.material(
        HIDE, linear(142, 122, 98), linear(96, 80, 62), rough=0.42, wrap=0.45, coat=0.7, coat_rough=0.14,
        wavelength=0.018,
        free=(0.16, 0.5, 0.3, 1.8, 0.30),
    )  # fmt: skip
    # It grows over the top and down to the mouth, which lies on the foot.
    axes = np.array([[0.0, 0.985, 0.174], [0.0, 0.174, -0.985], [-1.0, 0.0, 0.0]])
    group = pen.group()
    pen.spiral(
        0.187, 0.088, 0.10, 0.1435, (-24.0, 0.75), house, centre=(0.05, -0.07, 0.315), axes=axes, flat=1.05,
        slant=0.2, group=group, blend=0.012,
    )  # fmt: skip
    pen.ellipsoid((0.030, -0.07, 0.315), (0.050, 0.030, 0.030), house, group=group, blend=0.012)  # the pole
    _slug(pen, skin, float(rng.uniform(-0.06, 0.06)))
    return pen.body(tilt_deg=(70.0, 82.0), yaw_deg=-12.0)


def _slug(pen: Pen, skin: int, bend: float) -> None:
    """The foot, the raised head, four tentacles with eyes on the longer two."""
    group = pen.group()
    pen.loft(
        [
            (-0.52, 0.020, 0.006, 0.006, 0.018),
            (-0.40, 0.028, 0.055, 0.028, 0.026),
            (-0.15, 0.050, 0.100, 0.070, 0.048),
            (0.10, 0.058, 0.105, 0.085, 0.056),
            (0.28, 0.070, 0.088, 0.088, 0.068),
            (0.40, 0.092, 0.066, 0.070, 0.078),
            (0.47, 0.100, 0.040, 0.045, 0.060),
            (0.495, 0.095, 0.010, 0.012, 0.020),
        ],
        skin,
        sway=lambda y: bend * np.sin(5 * y),
        group=group,
        blend=0.03,
    )
    eye = pen.material(PLAIN, linear(26, 20, 18), rough=0.3, coat=1.0, coat_rough=0.06)
    for side in (-1.0, 1.0):
        tip = (side * 0.085 + bend, 0.56 + pen.rng.uniform(-0.03, 0.03), 0.285 + pen.rng.uniform(-0.02, 0.02))
        pen.tube(
            ((side * 0.03, 0.43, 0.14), (side * 0.05, 0.47, 0.22), tip),
            0.022,
            0.010,
            skin,
            group=group,
            blend=0.025,
        )
        pen.ellipsoid(tip, (0.0165, 0.0165, 0.0165), skin, group=group, blend=0.008)
        pen.ellipsoid((tip[0], tip[1] + 0.009, tip[2] + 0.006), (0.009, 0.009, 0.009), eye)
        pen.tube(
            ((side * 0.025, 0.47, 0.085), (side * 0.04, 0.51, 0.08), (side * 0.05, 0.535, 0.06)),
            0.013,
            0.007,
            skin,
            group=group,
            blend=0.02,
        )
    collar = pen.material(
        CHITIN, linear(186, 160, 122), linear(140, 116, 84), rough=0.5, coat=0.4, coat_rough=0.2
    )
    pen.cone((-0.02, 0.06, 0.125), (0.0, 0.12, 0.13), 0.085, 0.07, collar)
