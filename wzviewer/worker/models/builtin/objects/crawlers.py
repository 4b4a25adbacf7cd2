"""Builders: bee, ant, spider.  y forward, z up; body about 1 long."""

from functools import lru_cache

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import Body, Mark, Pen, Tint, linear, shaded
from wzviewer.worker.models.builtin.objects.butterflies import fuzz
from wzviewer.worker.models.builtin.objects.insects import BLACK, BROWN_BLACK, add_antenna, add_eye, add_leg
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, FUR, HAIR, MEMBRANE, PLAIN

_WING = [
    (0.0, 0.0),
    (-0.10, 0.16),
    (-0.125, 0.42),
    (-0.09, 0.68),
    (-0.02, 0.80),
    (0.07, 0.74),
    (0.115, 0.52),
    (0.10, 0.26),
    (0.03, 0.05),
]
_VEINS = [
    [(0.0, 0.0), (0.055, 0.30), (0.075, 0.70)],
    [(0.0, 0.02), (0.00, 0.32), (0.01, 0.58)],
    [(-0.01, 0.05), (-0.06, 0.30), (-0.075, 0.50)],
    [(0.045, 0.30), (0.0, 0.34), (-0.06, 0.34)],
    [(0.062, 0.52), (0.01, 0.56), (-0.08, 0.50)],
    [(0.01, 0.56), (0.0, 0.66), (-0.03, 0.72)],
    [(0.0, 0.0), (0.095, 0.28), (0.112, 0.52)],
]
_WINDOW = baking.Window((0.0, 0.40), 0.46)


def bee(rng: np.random.Generator, tint: Tint) -> Body:
    """A honey bee, furry in front, banded behind, wings half spread."""
    pen = Pen(rng)
    gold = tint.color or linear(222, 150, 34)
    dark = linear(44, 30, 22)
    coat = pen.material(
        FUR,
        shaded(gold, 0.8),
        dark,
        rough=0.75,
        wrap=0.5,
        sheen=0.5,
        wavelength=0.010,
        relief=0.07,
        free=(2.0, 0.25, 0.0, 0.1, 0.085, 1.3, 6e-4),
        f0=0.01,
    )
    rings = pen.material(
        FUR, gold, linear(34, 22, 16), rough=0.40, wrap=0.3, sheen=0.25, coat=0.45, coat_rough=0.14,
        wavelength=0.006,
        relief=0.035, free=(4.0, 0.14, 1.0, 0.104, 0.024, 0.5, 5e-4),
    )  # fmt: skip
    black = pen.material(
        CHITIN, BLACK, BROWN_BLACK, rough=0.4, coat=0.6, coat_rough=0.14, wavelength=0.014, relief=0.05
    )
    hair = pen.material(HAIR, shaded(gold, 1.1), linear(120, 84, 40), rough=0.5, wrap=0.6, sheen=0.4)
    pen.ellipsoid((0, 0.13, 0.27), (0.150, 0.165, 0.150), coat)
    tail = pen.group()
    pen.ellipsoid((0, -0.19, 0.235), (0.150, 0.235, 0.140), rings, group=tail, blend=0.05)
    pen.cone((0, -0.30, 0.215), (0, -0.46, 0.165), 0.105, 0.018, rings, group=tail, blend=0.06)
    pen.ellipsoid((0, 0.325, 0.245), (0.108, 0.072, 0.098), black)
    fuzz(pen, (0, 0.33, 0.25), (0.10, 0.07, 0.10), 30, 0.04, hair)
    bristle = pen.material(HAIR, linear(110, 84, 50), linear(52, 40, 28), rough=0.45, wrap=0.4)
    sheet = pen.texture(*_wing())
    clear = pen.material(
        MEMBRANE,
        linear(206, 196, 172),
        linear(60, 40, 24),
        rough=0.2,
        coat=1.0,
        coat_rough=0.06,
        free=(0.014, 0.20),
        sheet=True,
    )
    for side in (-1.0, 1.0):
        add_eye(pen, (side * 0.088, 0.335, 0.262), 0.048, (side, 0.35, 0.2))
        add_antenna(
            pen, side, ((0.03, 0.39, 0.27), (0.07, 0.47, 0.31), (0.10, 0.55, 0.235)), 0.0105, 9, black
        )
        for root, knee, ankle, foot in (
            ((0.09, 0.20, 0.16), (0.21, 0.30, 0.15), (0.25, 0.39, 0.05), (0.27, 0.46, 0.010)),
            ((0.10, 0.11, 0.15), (0.27, 0.10, 0.16), (0.345, 0.08, 0.05), (0.39, 0.09, 0.010)),
            ((0.10, 0.03, 0.15), (0.26, -0.14, 0.17), (0.315, -0.28, 0.05), (0.34, -0.37, 0.010)),
        ):
            add_leg(pen, side, (root, knee, ankle, foot), (0.032, 0.030, 0.018), black, bristle)
        for scale, turn, y, lift in ((0.72, 0.80, 0.15, 0.33), (0.50, 1.05, 0.08, 0.24)):
            _place_wing(
                pen,
                side,
                scale,
                turn + float(rng.normal(0, 0.05)),
                (side * 0.085, y, 0.375),
                lift,
                sheet,
                clear,
            )
    return pen.body(tilt_deg=(34.0, 54.0), yaw_deg=36.0, nose=(0.0, 0.42, 0.25))


def _place_wing(
    pen: Pen,
    side: float,
    scale: float,
    turn: float,
    root: tuple[float, float, float],
    lift: float,
    sheet: int,
    material: int,
) -> None:
    """Hinges a wing: `turn` back from outward, raised by `lift`."""
    along = np.array([side * np.cos(turn) * np.cos(lift), -np.sin(turn) * np.cos(lift), np.sin(lift)])
    front = np.array([side * np.sin(turn), np.cos(turn), 0.0])
    axes = np.stack([front, along, np.cross(front, along)])
    place = np.asarray(root) + scale * 0.40 * along
    pen.card(
        (float(place[0]), float(place[1]), float(place[2])), axes, 0.46 * scale, 0.004, (0.35, -0.10, 0.1,
        0.0), sheet,
        material, (0, 0), 1.1, (0.0, -0.87),
    )  # fmt: skip


@lru_cache(maxsize=1)
def _wing() -> tuple[FloatArray, FloatArray]:
    outline = baking.outline_distance(baking.closed_curve(_WING), _WINDOW, 2)
    veins = np.minimum(
        baking.line_distance([baking.open_curve(v) for v in _VEINS], _WINDOW, 2), np.abs(outline) + 0.004
    )
    return outline, np.stack([veins, outline, outline]).astype(np.float32)


def ant(rng: np.random.Generator, tint: Tint) -> Body:
    """A wood ant: three parts, a waist, elbowed feelers, long legs."""
    pen = Pen(rng)
    front = tint.color or linear(158, 58, 26)
    rear = shaded(tint.color, 0.5) if tint.color else linear(48, 26, 20)
    skin = pen.material(
        CHITIN,
        front,
        shaded(front, 0.5),
        rough=0.52,
        wrap=0.25,
        coat=0.30,
        coat_rough=0.24,
        wavelength=0.008,
        relief=0.09,
    )
    shiny = pen.material(
        CHITIN, rear, shaded(rear, 0.6), rough=0.42, coat=0.55, coat_rough=0.17, wavelength=0.009, relief=0.05
    )
    limb = pen.material(
        CHITIN, shaded(front, 0.62), shaded(front, 0.3), rough=0.5, coat=0.3, coat_rough=0.25,
        wavelength=0.008, relief=0.08,
    )  # fmt: skip
    hair = pen.material(HAIR, linear(170, 132, 84), linear(96, 70, 44), rough=0.45, wrap=0.4)
    head, trunk, tail = pen.group(), pen.group(), pen.group()
    pen.ellipsoid((0, 0.395, 0.250), (0.092, 0.120, 0.086), skin, group=head, blend=0.03)
    for side in (-1.0, 1.0):  # the back of the head has two lobes
        pen.ellipsoid((side * 0.048, 0.345, 0.262), (0.066, 0.076, 0.080), skin, group=head, blend=0.03)
    pen.ellipsoid((0, 0.465, 0.238), (0.075, 0.055, 0.055), skin, group=head, blend=0.04)
    pen.ellipsoid((0, 0.175, 0.262), (0.068, 0.105, 0.078), skin, group=trunk, blend=0.05)
    pen.ellipsoid((0, 0.055, 0.240), (0.054, 0.105, 0.064), skin, group=trunk, blend=0.05)
    pen.cone((0, 0.26, 0.262), (0, 0.30, 0.26), 0.036, 0.030, skin, group=trunk, blend=0.02)
    pen.ellipsoid((0, -0.085, 0.235), (0.034, 0.026, 0.055), skin, group=trunk, blend=0.025)
    pen.cone((0, -0.03, 0.215), (0, -0.15, 0.215), 0.022, 0.022, skin, group=trunk, blend=0.02)
    pen.ellipsoid((0, -0.315, 0.245), (0.142, 0.185, 0.128), shiny, group=tail, blend=0.03)
    pen.cone((0, -0.40, 0.235), (0, -0.50, 0.205), 0.08, 0.018, shiny, group=tail, blend=0.05)
    for y in (-0.23, -0.31, -0.39):  # rings of the abdomen stand out a little
        r = 0.99 * float(np.sqrt(max(1 - ((y + 0.315) / 0.185) ** 2, 0)))
        pen.torus(
            (0, y, 0.245),
            0.136 * r,
            0.006,
            shiny,
            axes=np.array([[1, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]),
            group=tail,
            blend=0.02,
        )
    for side in (-1.0, 1.0):
        add_eye(pen, (side * 0.096, 0.40, 0.285), 0.024, (side, 0.2, 0.4))
        pen.tube(
            ((side * 0.045, 0.50, 0.232), (side * 0.075, 0.575, 0.225), (side * 0.008, 0.590, 0.220)),
            0.020,
            0.007,
            skin,
        )
        pen.cone((side * 0.035, 0.475, 0.275), (side * 0.155, 0.545, 0.355), 0.009, 0.010, limb)
        add_antenna(
            pen, side, ((0.155, 0.545, 0.355), (0.20, 0.66, 0.36), (0.16, 0.77, 0.285)), 0.0095, 10, limb
        )
        for root, knee, ankle, foot in (
            ((0.04, 0.20, 0.20), (0.20, 0.335, 0.34), (0.325, 0.46, 0.05), (0.365, 0.56, 0.010)),
            ((0.04, 0.12, 0.19), (0.25, 0.10, 0.36), (0.43, 0.06, 0.05), (0.50, 0.06, 0.010)),
            ((0.04, 0.05, 0.19), (0.22, -0.14, 0.37), (0.37, -0.37, 0.05), (0.42, -0.50, 0.010)),
        ):
            add_leg(pen, side, (root, knee, ankle, foot), (0.025, 0.0165, 0.012), limb, hair)
    for centre, radii, count in (
        ((0, -0.315, 0.245), (0.142, 0.185, 0.128), 46),
        ((0, 0.385, 0.255), (0.108, 0.125, 0.090), 22),
        ((0, 0.175, 0.262), (0.068, 0.105, 0.078), 18),
    ):
        fuzz(pen, centre, radii, count, 0.040, hair)
    return pen.body(tilt_deg=(38.0, 58.0), yaw_deg=30.0)


def spider(rng: np.random.Generator, tint: Tint) -> Body:
    """A garden spider with a white cross on its back and eight ringed legs."""
    pen = Pen(rng)
    brown = tint.color or linear(186, 128, 68)
    dark, pale = shaded(brown, 0.28), linear(236, 224, 196)
    cross = tuple(
        Mark((0.0, y, 0.42), (0.018, 0.032, 0.14), pale, 0.25, 0.2) for y in (-0.10, -0.18, -0.26, -0.34)
    )
    arms = (Mark((0.05, -0.15, 0.42), (0.034, 0.020, 0.14), pale, 0.25, 0.2),)
    folium = Mark((0.0, -0.28, 0.36), (0.115, 0.22, 0.16), dark, 0.25, 0.22)
    back = pen.material(
        FUR,
        brown,
        dark,
        rough=0.6,
        wrap=0.35,
        sheen=0.25,
        coat=0.2,
        coat_rough=0.25,
        wavelength=0.010,
        relief=0.05,
        free=(2.0, 0.25, 0.0, 0.1, 0.042, 0.9, 5e-4),
        marks=(folium, *cross, *arms),
    )
    shield = pen.material(
        FUR,
        shaded(brown, 0.75),
        dark,
        rough=0.6,
        wrap=0.35,
        sheen=0.3,
        wavelength=0.010,
        relief=0.05,
        free=(3.0, 0.25, 0.0, 0.1, 0.03, 0.7, 5e-4),
    )
    rings = pen.material(
        FUR,
        shaded(brown, 0.95),
        dark,
        rough=0.6,
        wrap=0.35,
        sheen=0.3,
        wavelength=0.007,
        relief=0.05,
        free=(4.0, 0.2, 0.95, 0.105, 0.03, 0.9, 5e-4),
    )
    hair = pen.material(HAIR, linear(120, 90, 56), linear(52, 38, 26), rough=0.45, wrap=0.4)
    glass = pen.material(PLAIN, linear(16, 12, 12), rough=0.2, coat=1.0, coat_rough=0.04)
    tail = pen.group()
    pen.ellipsoid((0, -0.23, 0.265), (0.185, 0.235, 0.175), back, group=tail, blend=0.04)
    pen.ellipsoid((0, -0.12, 0.285), (0.165, 0.13, 0.150), back, group=tail, blend=0.06)
    front = pen.group()
    pen.ellipsoid((0, 0.10, 0.205), (0.120, 0.135, 0.085), shield, group=front, blend=0.04)
    pen.ellipsoid((0, 0.215, 0.215), (0.072, 0.075, 0.070), shield, group=front, blend=0.05)
    for side in (-1.0, 1.0):
        for x, y, z, r in (
            (0.016, 0.280, 0.255, 0.013),
            (0.014, 0.288, 0.222, 0.011),
            (0.050, 0.262, 0.238, 0.010),
            (0.056, 0.245, 0.215, 0.009),
        ):
            pen.ellipsoid((side * x, y, z), (r, r, r), glass)
        pen.cone((side * 0.028, 0.275, 0.18), (side * 0.032, 0.30, 0.10), 0.032, 0.020, shield)
        pen.tube(
            ((side * 0.05, 0.25, 0.17), (side * 0.09, 0.37, 0.20), (side * 0.06, 0.41, 0.07)),
            0.018,
            0.014,
            rings,
        )
        for angle, span in ((1.12, 0.78), (0.48, 0.66), (-0.22, 0.60), (-0.98, 0.80)):
            _spider_leg(pen, side, angle + float(rng.normal(0, 0.05)), span, rings, hair)
    fuzz(pen, (0, -0.23, 0.265), (0.185, 0.235, 0.175), 80, 0.040, hair)
    return pen.body(tilt_deg=(28.0, 50.0), yaw_deg=50.0, nose=(0.0, 0.30, 0.22))


def _spider_leg(pen: Pen, side: float, angle: float, span: float, skin: int, hair: int) -> None:
    """Femur up, tibia down, a thin foot; `angle` from outward towards the front."""
    out = np.array([side * np.cos(angle), np.sin(angle), 0.0])
    root = np.array([0.0, 0.10, 0.19]) + 0.10 * out * [1.0, 0.8, 1.0]
    at = [
        root,
        root + 0.30 * span * out + [0, 0, 0.20],
        root + 0.66 * span * out + [0, 0, 0.06],
        root + span * out,
    ]
    at[3][2] = 0.008
    group = pen.group()
    for a, b, r0, r1 in ((0, 1, 0.032, 0.026), (1, 2, 0.025, 0.017), (2, 3, 0.016, 0.008)):
        start, end = (tuple(float(v) for v in at[k]) for k in (a, b))
        pen.cone(start, end, r0, r1, skin, group=group, blend=0.015)  # type: ignore[arg-type]
    for _ in range(10):
        t = pen.rng.uniform(0.1, 0.95)
        base = at[1] + t * (at[2] - at[1])
        away = pen.rng.normal(size=3)
        away /= np.linalg.norm(away)
        points = tuple(tuple(float(v) for v in base + s * 0.05 * away) for s in (0.2, 0.6, 1.0))
        pen.tube(points, 0.0016, 0.0005, hair, shadow=False)  # type: ignore[arg-type]
