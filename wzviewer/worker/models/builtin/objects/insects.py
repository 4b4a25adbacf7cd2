"""Builders: ladybug and ground beetle.  Lengths in body lengths; y forward, z up."""

import numpy as np

from wzviewer.core.types import DoubleArray
from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, Vector, axes_along, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, ELYTRA, EYE, HAIR, PLAIN, PRONOTUM, STRIAE

BLACK = linear(34, 28, 27)
BROWN_BLACK = linear(58, 40, 32)


def ladybug(rng: np.random.Generator, tint: Tint) -> Body:
    """A seven-spot ladybird; the tint colours its wing cases."""
    pen = Pen(rng)
    red = tint.color or linear(214, 26, 12)
    spots = {"": 4.0, "spotted": 4.0}.get(tint.pattern, 0.0)
    shell = pen.material(
        ELYTRA,
        red,
        BLACK,
        rough=0.36,
        wrap=0.22,
        coat=1.0,
        coat_rough=0.09,
        wavelength=0.0165,
        relief=0.14,
        free=(spots, 0.85),
    )
    shield = pen.material(
        PRONOTUM,
        BLACK,
        linear(233, 219, 188),
        rough=0.42,
        wrap=0.2,
        coat=0.85,
        coat_rough=0.12,
        wavelength=0.014,
        relief=0.12,
        free=(1.0,),
    )
    chitin = pen.material(
        CHITIN, BLACK, BROWN_BLACK, rough=0.38, coat=0.7, coat_rough=0.14, wavelength=0.012, relief=0.05
    )
    ivory = pen.material(PLAIN, linear(226, 208, 172), rough=0.5, coat=0.5, coat_rough=0.15)
    hair = pen.material(HAIR, linear(120, 92, 58), linear(60, 44, 30), rough=0.45, wrap=0.4)
    _case(pen, shell, chitin)
    _shield_and_head(pen, shield, chitin, ivory, hair)
    for side in (-1.0, 1.0):
        for root, knee, ankle, foot in (
            ((0.24, 0.20, 0.085), (0.400, 0.345, 0.125), (0.465, 0.440, 0.040), (0.515, 0.500, 0.012)),
            ((0.28, 0.02, 0.085), (0.475, 0.055, 0.130), (0.565, 0.060, 0.038), (0.640, 0.090, 0.012)),
            ((0.26, -0.16, 0.085), (0.455, -0.270, 0.125), (0.535, -0.370, 0.036), (0.590, -0.440, 0.012)),
        ):
            add_leg(pen, side, (root, knee, ankle, foot), (0.037, 0.026, 0.017), chitin, hair)
    return pen.body(tilt_deg=(30.0, 50.0), yaw_deg=33.0)


def beetle(rng: np.random.Generator, tint: Tint) -> Body:
    """A ground beetle with furrowed, metallic wing cases; the tint colours them."""
    pen = Pen(rng)
    green = tint.color or linear(58, 92, 38)
    second = shaded(tint.color, 0.5) if tint.color else linear(116, 66, 30)
    metal = 0.9 if tint.substance == "metal" else 0.35
    shell = pen.material(
        STRIAE,
        green,
        second,
        rough=0.34,
        metal=metal,
        coat=0.9,
        coat_rough=0.12,
        wavelength=0.013,
        relief=0.07,
        free=(18.0,),
    )
    shield = pen.material(
        CHITIN,
        green,
        second,
        rough=0.34,
        metal=metal,
        coat=0.9,
        coat_rough=0.12,
        wavelength=0.012,
        relief=0.12,
    )
    chitin = pen.material(
        CHITIN, BLACK, BROWN_BLACK, rough=0.36, coat=0.8, coat_rough=0.12, wavelength=0.012, relief=0.06
    )
    hair = pen.material(HAIR, linear(110, 84, 50), linear(52, 40, 28), rough=0.45, wrap=0.4)
    pen.dome((0, -0.16, 0.10), (0.225, 0.345, 0.150), -0.045, shell, edge=0.03)
    pen.ellipsoid((0, -0.15, 0.075), (0.20, 0.32, 0.060), chitin)
    thorax = pen.group()
    pen.ellipsoid((0, 0.235, 0.115), (0.155, 0.105, 0.075), shield, group=thorax, blend=0.03)
    pen.ellipsoid((0, 0.19, 0.10), (0.135, 0.10, 0.055), shield, group=thorax, blend=0.03)
    head = pen.group()
    pen.ellipsoid((0, 0.365, 0.105), (0.083, 0.085, 0.056), shield, group=head, blend=0.02)
    pen.ellipsoid((0, 0.43, 0.092), (0.062, 0.05, 0.04), chitin, group=head, blend=0.02)
    for side in (-1.0, 1.0):
        add_eye(pen, (side * 0.076, 0.385, 0.122), 0.025, (side, 0.25, 0.35))
        pen.tube(
            ((side * 0.035, 0.46, 0.09), (side * 0.06, 0.535, 0.085), (side * 0.005, 0.545, 0.08)),
            0.017,
            0.005,
            chitin,
        )
        add_antenna(
            pen, side, ((0.055, 0.435, 0.11), (0.20, 0.54, 0.22), (0.27, 0.72, 0.13)), 0.0085, 11, chitin
        )
        for root, knee, ankle, foot in (
            ((0.10, 0.20, 0.06), (0.265, 0.330, 0.150), (0.345, 0.455, 0.035), (0.385, 0.56, 0.010)),
            ((0.14, 0.04, 0.06), (0.345, 0.020, 0.165), (0.475, -0.045, 0.035), (0.565, -0.08, 0.010)),
            ((0.14, -0.07, 0.06), (0.335, -0.230, 0.165), (0.435, -0.440, 0.035), (0.485, -0.56, 0.010)),
        ):
            add_leg(pen, side, (root, knee, ankle, foot), (0.027, 0.017, 0.012), chitin, hair)
    return pen.body(tilt_deg=(26.0, 50.0), yaw_deg=38.0)


def _case(pen: Pen, shell: int, chitin: int) -> None:
    """The domed wing cases with their flange, over a dark belly."""
    group = pen.group()
    pen.dome((0, -0.07, 0.085), (0.405, 0.435, 0.325), -0.012, shell, edge=0.02, group=group, blend=0.035)
    pen.ellipsoid((0, -0.07, 0.098), (0.418, 0.448, 0.022), shell, group=group, blend=0.035)
    pen.ellipsoid((0, -0.05, 0.085), (0.33, 0.38, 0.06), chitin)


def _shield_and_head(pen: Pen, shield: int, chitin: int, ivory: int, hair: int) -> None:
    group = pen.group()
    pen.ellipsoid((0, 0.325, 0.165), (0.275, 0.135, 0.118), shield, group=group, blend=0.04)
    pen.ellipsoid((0, 0.365, 0.118), (0.255, 0.105, 0.060), shield, group=group, blend=0.04)
    head = pen.group()
    pen.ellipsoid((0, 0.465, 0.125), (0.140, 0.085, 0.075), chitin, group=head, blend=0.03)
    pen.ellipsoid((0, 0.530, 0.095), (0.085, 0.045, 0.040), chitin, group=head, blend=0.03)
    for side in (-1.0, 1.0):
        pen.ellipsoid((side * 0.062, 0.492, 0.178), (0.024, 0.020, 0.014), ivory)
        add_eye(pen, (side * 0.118, 0.478, 0.150), 0.038, (side, 0.45, 0.35))
        pen.tube(
            ((side * 0.05, 0.545, 0.085), (side * 0.06, 0.60, 0.08), (side * 0.035, 0.605, 0.055)),
            0.012,
            0.013,
            chitin,
        )
        add_antenna(
            pen, side, ((0.085, 0.535, 0.13), (0.14, 0.625, 0.205), (0.225, 0.635, 0.150)), 0.0095, 8, chitin
        )
    _fringe(pen, (0, 0.465, 0.125), (0.142, 0.087, 0.077), 70, hair)


def add_eye(pen: Pen, centre: Vector, radius: float, outward: Vector) -> None:
    """A compound eye of about 26 facets across."""
    eye = pen.material(
        EYE,
        linear(26, 17, 14),
        linear(74, 46, 34),
        rough=0.3,
        coat=1.0,
        coat_rough=0.08,
        wavelength=2.6 * radius / 26,
    )
    pen.ellipsoid(centre, (radius, radius, radius * 0.9), eye, axes=axes_along(np.asarray(outward)))


def add_antenna(
    pen: Pen, side: float, points: tuple[Vector, Vector, Vector], radius: float, count: int, material: int
) -> None:
    """Segments along a curve, each a little bulb, the last ones a club."""
    a, b, c = (np.asarray(p) * (side, 1, 1) for p in points)
    t = np.linspace(0, 1, count + 1)[:, None]
    curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c
    group = pen.group()
    for k in range(count):
        swell = 1.0 + (0.9 if k >= count - 3 and count < 10 else 0.0)
        pen.cone(
            _vector(curve[k]),
            _vector(curve[k + 1]),
            0.72 * radius * swell,
            radius * swell,
            material,
            group=group,
            blend=0.006,
        )


def add_leg(
    pen: Pen,
    side: float,
    joints: tuple[Vector, Vector, Vector, Vector],
    radii: Vector,
    material: int,
    hair: int,
) -> None:
    """Femur, tibia, a bent foot of segments with two claws, and bristles; joints vary a little."""
    wobble = pen.rng.normal(0, 0.012, (4, 3)) * [[0.2], [1], [1], [1]]
    wobble[3, 2] = 0.0
    root, knee, ankle, foot = (
        (np.asarray(j) + w) * (side, 1, 1) for j, w in zip(joints, wobble, strict=True)
    )
    ankle[2] = max(ankle[2], 0.03)
    thick, shin, toe = radii
    group = pen.group()
    middle = 0.45 * root + 0.55 * knee
    pen.cone(_vector(root), _vector(middle), thick * 0.8, thick, material, group=group, blend=0.01)
    pen.cone(_vector(middle), _vector(knee), thick, shin, material, group=group, blend=0.01)
    pen.cone(_vector(knee), _vector(ankle), shin * 0.8, toe * 1.05, material, group=group, blend=0.01)
    for k in range(3):
        a, b = ankle + (foot - ankle) * k / 3, ankle + (foot - ankle) * (k + 1) / 3
        pen.cone(_vector(a), _vector(b), 0.45 * toe, 0.72 * toe, material, group=group, blend=0.004)
    ahead = (foot - ankle) / np.linalg.norm(foot - ankle)
    for turn in (-0.5, 0.5):
        out = np.array([ahead[0] - turn * ahead[1], ahead[1] + turn * ahead[0], 0.0])
        tip = foot + 0.030 * out + (0, 0, 0.004 - foot[2])
        pen.tube(
            (_vector(foot), _vector(foot + 0.020 * out + (0, 0, 0.008)), _vector(tip)),
            0.35 * toe,
            0.12 * toe,
            material,
        )
    _bristles(pen, knee, ankle, shin, 12, hair)


def _bristles(pen: Pen, start: DoubleArray, end: DoubleArray, radius: float, count: int, hair: int) -> None:
    """Short hairs standing off a shin."""
    frame = axes_along(end - start)
    for _ in range(count):
        t, angle = pen.rng.uniform(0.15, 1.0), pen.rng.uniform(0, 2 * np.pi)
        out = np.cos(angle) * frame[0] + np.sin(angle) * frame[1]
        base = start + t * (end - start) + out * radius * (0.85 - 0.3 * t)
        length = pen.rng.uniform(0.014, 0.026)
        tip = base + length * (0.75 * out + 0.75 * frame[2])
        pen.tube(
            (_vector(base), _vector(base + 0.55 * length * out), _vector(tip)),
            0.0012,
            0.0004,
            hair,
            shadow=False,
        )


def _fringe(pen: Pen, centre: Vector, radii: Vector, count: int, hair: int) -> None:
    """Hairs on the front of a head."""
    for _ in range(count):
        d = pen.rng.normal(size=3) + np.array([0, 0.9, 0.35])
        d /= np.linalg.norm(d)
        base = np.asarray(centre) + d * radii
        out = d / np.asarray(radii)
        out /= np.linalg.norm(out)
        length = pen.rng.uniform(0.018, 0.034)
        lean = np.array([0, 0.6, -0.1])
        pen.tube(
            (
                _vector(base),
                _vector(base + 0.5 * length * out),
                _vector(base + length * (0.8 * out + lean) * 0.8),
            ),
            0.0011,
            0.0004,
            hair,
            shadow=False,
        )


def _vector(p: DoubleArray) -> Vector:
    return float(p[0]), float(p[1]), float(p[2])
