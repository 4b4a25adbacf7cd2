"""Builder: fishes, one form in many colours.  y forward, z up; about 1 long with the tail."""

from dataclasses import dataclass

import numpy as np

from wzviewer.worker.models.builtin.objects.bodies import Body, Mark, Pen, Tint, Vector, linear, shaded
from wzviewer.worker.models.builtin.objects.patterns import FIN, FISH, PLAIN
from wzviewer.worker.models.builtin.objects.sheets import Outline, place_card

WHITE, BLACK = linear(238, 234, 226), linear(24, 24, 28)

# Outlines in (y, z); the ray root of each fin follows.
_TAIL: Outline = ((-0.29, 0.335), (-0.36, 0.36), (-0.50, 0.475), (-0.585, 0.50), (-0.545, 0.40),
    (-0.515, 0.285),
                  (-0.545, 0.17), (-0.585, 0.075), (-0.50, 0.095), (-0.36, 0.215),
                  (-0.29, 0.245))  # fmt: skip
_DORSAL: Outline = ((0.17, 0.42), (0.14, 0.50), (0.07, 0.575), (0.00, 0.55), (-0.09, 0.505), (-0.175, 0.485),
                    (-0.235, 0.435), (-0.215, 0.365), (-0.05, 0.38))  # fmt: skip
_ANAL: Outline = (
    (-0.04, 0.135),
    (-0.085, 0.055),
    (-0.155, 0.030),
    (-0.195, 0.085),
    (-0.235, 0.155),
    (-0.22, 0.21),
    (-0.10, 0.18),
)
_PELVIC: Outline = ((0.12, 0.115), (0.075, 0.045), (0.02, 0.0), (0.005, 0.06), (0.035, 0.115))
_PECTORAL: Outline = (
    (0.0, 0.025),
    (-0.09, 0.075),
    (-0.17, 0.072),
    (-0.20, 0.02),
    (-0.165, -0.045),
    (-0.09, -0.062),
    (0.0, -0.025),
)


@dataclass(frozen=True)
class Scales:
    """Colours of flank, back and fins, the fins' edge, and what is painted on the body."""

    flank: Vector
    back: Vector
    fins: Vector
    edge: Vector
    marks: tuple[Mark, ...] = ()
    metal: float = 0.25
    dark: float = 0.30


def _bar(y: float, half: float, color: Vector, lean: float = 0.0) -> Mark:
    return Mark((0.0, y, 0.29 + lean), (0.5, half, 0.42), color, 0.12, 0.10)


PERCH = Scales(
    linear(150, 162, 120), linear(56, 74, 48), linear(222, 92, 36), linear(168, 40, 22),
    tuple(_bar(y, 0.030, linear(50, 62, 44), 0.14) for y in (0.17, 0.05, -0.07, -0.18)), 0.35,
)  # fmt: skip
GOLDFISH = Scales(
    linear(240, 118, 20), linear(226, 78, 10), linear(246, 140, 60), linear(250, 190, 130), (), 0.30, 0.22
)
CLOWNFISH = Scales(
    linear(240, 102, 14), linear(226, 80, 8), linear(240, 108, 18), BLACK,
    (
        _bar(0.215, 0.060, BLACK), _bar(0.215, 0.047, WHITE),
        _bar(-0.045, 0.070, BLACK), _bar(-0.045, 0.056, WHITE),
        _bar(-0.255, 0.045, BLACK), _bar(-0.255, 0.032, WHITE),
    ),
    0.05, 0.12,
)  # fmt: skip
TROUT = Scales(linear(188, 176, 150), linear(92, 94, 68), linear(176, 132, 96), linear(120, 80, 60),
               (Mark((0.0, 0.0, 0.30), (0.4, 0.60, 0.05), linear(214, 120, 112), 0.5, 0.3),),
               0.35)  # fmt: skip


def fish(rng: np.random.Generator, tint: Tint) -> Body:
    """A perch with red fins; a tint makes it a plain fish of that colour."""
    return _fish(rng, PERCH if tint.color is None else _plain(tint))


def goldfish(rng: np.random.Generator, tint: Tint) -> Body:
    """A goldfish."""
    return _fish(rng, GOLDFISH if tint.color is None else _plain(tint))


def clownfish(rng: np.random.Generator, tint: Tint) -> Body:
    """A clownfish with its three white bands."""
    return _fish(rng, CLOWNFISH)


def trout(rng: np.random.Generator, tint: Tint) -> Body:
    """A trout, rosy along its side."""
    return _fish(rng, TROUT if tint.color is None else _plain(tint))


def _plain(tint: Tint) -> Scales:
    color = tint.color or GOLDFISH.flank
    bars = tuple(_bar(y, 0.030, shaded(color, 0.25)) for y in (0.17, 0.05, -0.07, -0.18))
    return Scales(
        color,
        shaded(color, 0.45),
        shaded(color, 0.85),
        shaded(color, 0.4),
        bars if tint.pattern == "striped" else (),
    )


def _fish(rng: np.random.Generator, scales: Scales) -> Body:
    pen = Pen(rng)
    skin = pen.material(
        FISH, scales.flank, scales.back, rough=0.32, metal=scales.metal, wrap=0.2, coat=0.75, coat_rough=0.11,
        wavelength=0.026, free=(0.245, scales.dark, 0.85), marks=scales.marks,
    )  # fmt: skip
    bend = float(rng.uniform(-0.10, 0.10))
    pen.loft(
        [
            (-0.345, 0.290, 0.010, 0.046, 0.046),
            (-0.28, 0.290, 0.026, 0.050, 0.050),
            (-0.15, 0.288, 0.056, 0.095, 0.105),
            (0.00, 0.283, 0.086, 0.148, 0.160),
            (0.13, 0.278, 0.098, 0.158, 0.170),
            (0.25, 0.278, 0.090, 0.128, 0.138),
            (0.35, 0.272, 0.068, 0.088, 0.088),
            (0.415, 0.262, 0.044, 0.050, 0.047),
            (0.448, 0.256, 0.020, 0.022, 0.021),
            (0.455, 0.255, 0.004, 0.004, 0.004),
        ],
        skin,
        sway=lambda y: bend * np.minimum(y - 0.1, 0) ** 2,
    )
    shift = bend * 0.45**2
    sail = pen.material(
        FIN, scales.fins, scales.edge, rough=0.4, wrap=0.3, thin=0.8, coat=0.3, coat_rough=0.2,
        free=(7.0, 0.62, 0.95), sheet=True,
    )  # fmt: skip
    _fin(pen, _TAIL, (-0.20, 0.29), x=shift, bend=0.6 * bend, material=sail)
    _fin(pen, _DORSAL, (0.02, 0.12), material=sail)
    _fin(pen, _ANAL, (-0.09, 0.36), material=sail)
    for side in (-1.0, 1.0):
        _fin(pen, _PELVIC, (0.12, 0.20), x=side * 0.030, lean=side * 0.25, material=sail)
        _pectoral(pen, side, sail)
        _face(pen, side)
    mouth = pen.material(PLAIN, shaded(scales.back, 0.25), rough=0.6)
    for side in (-1.0, 1.0):
        pen.tube(
            ((0, 0.462, 0.252), (side * 0.040, 0.440, 0.238), (side * 0.050, 0.395, 0.229)),
            0.0055,
            0.003,
            mouth,
        )
    return pen.body(tilt_deg=(76.0, 86.0), yaw_deg=-14.0)


def _face(pen: Pen, side: float) -> None:
    """A round eye: golden iris, black pupil."""
    eye = pen.material(
        PLAIN, linear(214, 178, 92), rough=0.3, coat=1.0, coat_rough=0.04,
        marks=(Mark((0.092, 0.345, 0.3145), (0.05, 0.0175, 0.0175), linear(10, 9, 10), 0.06, 0.0),),
    )  # fmt: skip
    pen.ellipsoid((side * 0.0605, 0.345, 0.314), (0.019, 0.031, 0.031), eye)


def _fin(
    pen: Pen, outline: Outline, root: tuple[float, float], *, material: int,
    x: float = 0.0, bend: float = 0.0, lean: float = 0.0,
) -> None:  # fmt: skip
    """A fin in the plane of y and z at x, leaning outwards by `lean`."""
    axes = np.array([[0.0, 1.0, 0.0], [-np.sin(lean), 0.0, np.cos(lean)], [np.cos(lean), 0.0, np.sin(lean)]])
    place_card(pen, outline, root, axes, 0.007, material, (x, 0.0, 0.0), (bend, 0.0, 0.0, 0.0))


def _pectoral(pen: Pen, side: float, material: int) -> None:
    """The fin behind the gills, spread from the flank."""
    spread = 0.55 + pen.rng.uniform(-0.12, 0.12)
    axes = np.array(
        [
            [-side * np.sin(spread), np.cos(spread), 0.0],
            [0.0, 0.0, 1.0],
            [side * np.cos(spread), np.sin(spread), 0.0],
        ]
    )
    place_card(
        pen, _PECTORAL, (0.03, 0.0), axes, 0.007, material, (side * 0.088, 0.175, 0.215), (0.5, 0.3, 0.0, 0.0)
    )
