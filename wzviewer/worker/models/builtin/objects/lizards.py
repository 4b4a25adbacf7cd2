"""Builders: a wall lizard and a gecko, seen from above.  y forward, z up; about 1 long, half of it tail."""

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Mark, Pen, Tint, Vector, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, HIDE, PLAIN


def lizard(rng: np.random.Generator, tint: Tint) -> Body:
    """A green wall lizard; the tint colours it."""
    color = tint.color or linear(112, 142, 52)
    return _lizard(rng, color, shaded(color, 0.30) if tint.color else linear(44, 46, 26), 1.0, 0.0)


def gecko(rng: np.random.Generator, tint: Tint) -> Body:
    """A gecko: broad head, big eyes, round toe pads, spotted."""
    color = tint.color or linear(222, 186, 122)
    return _lizard(rng, color, shaded(color, 0.4) if tint.color else linear(132, 84, 52), 1.25, 1.0)


def _lizard(rng: np.random.Generator, color: Vector, second: Vector, broad: float, pads: float) -> Body:
    pen = Pen(rng)
    flank = Mark((0.085, 0.1, 0.075), (0.022, 0.36, 0.020), shaded(color, 0.35), 0.35, 0.5)
    scales = pen.material(
        HIDE, color, second, rough=0.48, wrap=0.25, coat=0.30, coat_rough=0.22, wavelength=0.0125,
        free=(0.16, 0.9, 0.085, 1.15, 0.38), marks=(flank,),
    )  # fmt: skip
    plates = pen.material(
        HIDE, color, second, rough=0.42, wrap=0.25, coat=0.45, coat_rough=0.18, wavelength=0.038,
        free=(0.05, 0.55, 0.05, 1.4, 0.45),
    )  # fmt: skip
    phase = float(rng.uniform(-0.4, 0.4))
    side = float(rng.choice([-1.0, 1.0]))

    def sway(y: np.ndarray) -> np.ndarray:
        return side * (0.055 * np.sin(6.2 * (y - 0.1) + phase) + 0.42 * np.maximum(-0.18 - y, 0) ** 1.7)

    group = pen.group()
    pen.loft(
        [
            (-0.80, 0.014, 0.004, 0.004, 0.004),
            (-0.60, 0.020, 0.014, 0.014, 0.014),
            (-0.35, 0.036, 0.030, 0.028, 0.026),
            (-0.14, 0.060, 0.052, 0.044, 0.040),
            (-0.03, 0.066, 0.070 * broad, 0.052, 0.046),
            (0.12, 0.070, 0.092 * broad, 0.062, 0.052),
            (0.26, 0.074, 0.080 * broad, 0.058, 0.050),
            (0.36, 0.082, 0.058 * broad, 0.048, 0.044),
            (0.42, 0.088, 0.050 * broad, 0.044, 0.042),
        ],
        scales,
        sway=sway,
        group=group,
        blend=0.035,
    )
    x = float(sway(np.array([0.42]))[0])
    turn = side * 0.25
    _head(pen, x, turn, broad, plates, group)
    for s in (-1.0, 1.0):
        fore, hind = float(sway(np.array([0.29]))[0]), float(sway(np.array([-0.04]))[0])
        reach = 0.03 * s * side
        _limb(
            pen,
            (fore + s * 0.06, 0.29, 0.075),
            (fore + s * 0.185, 0.265 + reach, 0.105),
            (fore + s * 0.215, 0.385 + reach, 0.022),
            0.026,
            scales,
            group,
            pads,
        )
        _limb(
            pen,
            (hind + s * 0.05, -0.03, 0.065),
            (hind + s * 0.20, 0.045 - reach, 0.110),
            (hind + s * 0.245, -0.09 - reach, 0.022),
            0.034,
            scales,
            group,
            pads,
        )
    return pen.body(tilt_deg=(22.0, 46.0), yaw_deg=24.0)


def _head(pen: Pen, x: float, turn: float, broad: float, skin: int, group: int) -> None:
    """A wedge of plates, bulging eyes, ear holes and the line of the mouth."""
    axes = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1.0]])
    centre = (x, 0.42, 0.088)
    pen.loft(
        [
            (-0.03, 0.0, 0.048 * broad, 0.040, 0.040),
            (0.04, 0.004, 0.066 * broad, 0.052, 0.044),
            (0.10, 0.000, 0.056 * broad, 0.046, 0.038),
            (0.16, -0.010, 0.036 * broad, 0.030, 0.026),
            (0.20, -0.016, 0.018 * broad, 0.016, 0.014),
            (0.212, -0.018, 0.004, 0.004, 0.004),
        ],
        skin,
        centre=centre,
        axes=axes,
        group=group,
        blend=0.03,
    )
    eye = pen.material(PLAIN, linear(30, 20, 12), rough=0.2, coat=1.0, coat_rough=0.04)
    dark = pen.material(CHITIN, linear(36, 30, 22), rough=0.6, wavelength=0.02)
    for side in (-1.0, 1.0):

        def at(a: float, b: float, c: float, side: float = side) -> Vector:
            p = np.asarray(centre) + side * a * axes[0] + b * axes[1] + c * axes[2]
            return float(p[0]), float(p[1]), float(p[2])

        r = 0.0165 * broad**1.5
        pen.ellipsoid(
            at(0.046 * broad, 0.092, 0.022), (1.25 * r, 1.5 * r, 1.15 * r), skin, group=group, blend=0.012
        )
        pen.ellipsoid(at(0.053 * broad, 0.094, 0.025), (r, r, r), eye)
        pen.ellipsoid(at(0.062 * broad, 0.022, 0.004), (0.008, 0.012, 0.014), dark)
        pen.ellipsoid(at(0.010, 0.203, -0.010), (0.004, 0.004, 0.004), dark)


def _limb(
    pen: Pen, root: Vector, elbow: Vector, hand: Vector, thick: float, skin: int, group: int, pads: float
) -> None:
    """Upper and lower limb and five spread toes."""
    jitter = pen.rng.normal(0, 0.012, 3)
    elbow = (elbow[0], elbow[1] + float(jitter[0]), elbow[2])
    hand = (hand[0], hand[1] + float(jitter[1]), hand[2])
    pen.cone(root, elbow, thick, 0.74 * thick, skin, group=group, blend=0.03)
    pen.cone(elbow, hand, 0.74 * thick, 0.48 * thick, skin, group=group, blend=0.02)
    ahead = np.arctan2(hand[1] - elbow[1], hand[0] - elbow[0])
    for k in range(5):
        angle = ahead + (k - 2) * 0.42
        length = (0.055, 0.072, 0.082, 0.075, 0.055)[k] * thick / 0.028
        tip = (hand[0] + length * float(np.cos(angle)), hand[1] + length * float(np.sin(angle)), 0.008)
        middle = ((hand[0] + tip[0]) / 2, (hand[1] + tip[1]) / 2, 0.026)
        pen.tube((hand, middle, tip), 0.26 * thick, 0.14 * thick, skin, group=group, blend=0.012)
        if pads > 0:
            pen.ellipsoid(tip, (0.011, 0.011, 0.006), skin, group=group, blend=0.006)
