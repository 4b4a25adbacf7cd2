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
_SPINY: Outline = ((0.195, 0.40), (0.185, 0.475), (0.165, 0.510), (0.150, 0.503), (0.125, 0.553),
                   (0.108, 0.540), (0.080, 0.578), (0.062, 0.560), (0.034, 0.580), (0.015, 0.556),
                   (-0.014, 0.558), (-0.030, 0.530), (-0.058, 0.516), (-0.070, 0.482), (-0.095, 0.440),
                   (-0.080, 0.37), (0.05, 0.38))  # fmt: skip
_SOFT: Outline = ((-0.095, 0.425), (-0.112, 0.500), (-0.150, 0.522), (-0.195, 0.508), (-0.238, 0.468),
                  (-0.262, 0.425), (-0.245, 0.385), (-0.225, 0.345), (-0.12, 0.37))  # fmt: skip
_ANAL: Outline = (
    (-0.04, 0.135),
    (-0.085, 0.055),
    (-0.155, 0.030),
    (-0.195, 0.085),
    (-0.235, 0.155),
    (-0.22, 0.21),
    (-0.10, 0.18),
)
_NOSTRIL = Mark((0.045, 0.408, 0.296), (0.05, 0.0055, 0.0042), linear(20, 18, 14), 0.4, 0.1)
_PELVIC: Outline = ((0.12, 0.115), (0.075, 0.040), (0.02, -0.012), (0.005, 0.06), (0.035, 0.115))
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
    """Colours of flank, back and fins, the fins' edge, and what is painted on the body.

    `pale` tells how white the belly is; `sail` colours the fins of back and breast, if they differ.
    A spiny fish has two fins on its back, the first of them on spines.
    """

    flank: Vector
    back: Vector
    fins: Vector
    edge: Vector
    marks: tuple[Mark, ...] = ()
    metal: float = 0.25
    dark: float = 0.30
    pale: float = 0.55
    sail: Vector | None = None
    spiny: bool = False


def _bar(y: float, half: float, color: Vector, lean: float = 0.0) -> Mark:
    return Mark((0.0, y, 0.29 + lean), (0.5, half, 0.42), color, 0.12, 0.10)


def _wedge(y: float, color: Vector, half: float = 0.030) -> Mark:
    """A bar that is broad on the back and runs out on the flank."""
    return Mark((0.0, y, 0.45), (0.5, half, 0.245), color, 0.42, 0.22)


PERCH = Scales(
    linear(146, 148, 92), linear(52, 62, 36), linear(206, 84, 40), linear(150, 48, 26),
    tuple(_wedge(y, linear(40, 48, 30), half) for y, half in
          ((0.19, 0.030), (0.115, 0.018), (0.045, 0.028), (-0.055, 0.026), (-0.15, 0.024), (-0.235, 0.016))),
    0.30, 0.30, 0.85, linear(116, 112, 78), True,
)  # fmt: skip
GOLDFISH = Scales(
    linear(240, 118, 20),
    linear(226, 78, 10),
    linear(246, 140, 60),
    linear(250, 190, 130),
    (),
    0.30,
    0.22,
    0.40,
)
CLOWNFISH = Scales(
    linear(240, 102, 14), linear(226, 80, 8), linear(240, 108, 18), BLACK,
    (
        _bar(0.215, 0.060, BLACK), _bar(0.215, 0.047, WHITE),
        _bar(-0.045, 0.070, BLACK), _bar(-0.045, 0.056, WHITE),
        _bar(-0.255, 0.045, BLACK), _bar(-0.255, 0.032, WHITE),
    ),
    0.05, 0.12, 0.15, None, True,
)  # fmt: skip
TROUT = Scales(linear(188, 176, 150), linear(92, 94, 68), linear(176, 132, 96), linear(120, 80, 60),
               (Mark((0.0, 0.0, 0.30), (0.4, 0.60, 0.05), linear(214, 120, 112), 0.5, 0.3),),
               0.35, 0.30, 0.80)  # fmt: skip


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
    bars = tuple(_wedge(y, shaded(color, 0.25)) for y in (0.17, 0.05, -0.07, -0.18))
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
        FISH, scales.flank, scales.back, rough=0.32, metal=scales.metal, wrap=0.2, coat=0.65, coat_rough=0.13,
        wavelength=0.024, free=(0.245, scales.dark, 0.92, scales.pale), marks=(*scales.marks, _NOSTRIL),
    )  # fmt: skip
    bend = float(rng.uniform(-0.10, 0.10))
    pen.loft(
        [
            (-0.400, 0.290, 0.002, 0.008, 0.008),
            (-0.385, 0.290, 0.004, 0.026, 0.026),
            (-0.365, 0.290, 0.007, 0.039, 0.039),
            (-0.340, 0.290, 0.012, 0.046, 0.046),
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
    root = Mark((0.0, -0.315, 0.290), (0.5, 0.085, 0.085), scales.flank, 0.75, 0.25)
    webs = (scales.sail, shaded(scales.sail, 0.7)) if scales.sail else (scales.fins, scales.edge)
    red, web = (
        pen.material(
            FIN, color, edge, rough=0.4, wrap=0.3, thin=0.8, coat=0.3, coat_rough=0.2,
            free=(10.0, 0.74, 0.95), sheet=True, marks=(root,),
        )
        for color, edge in ((scales.fins, scales.edge), webs)
    )  # fmt: skip
    _fin(pen, _TAIL, (-0.20, 0.29), x=shift, bend=0.6 * bend, material=red)
    if scales.spiny:
        _fin(pen, _SPINY, (0.06, 0.02), material=web)
        _fin(pen, _SOFT, (-0.10, 0.12), material=web)
    else:
        _fin(pen, _DORSAL, (0.02, 0.12), material=web)
    _fin(pen, _ANAL, (-0.09, 0.36), material=red)
    for side in (-1.0, 1.0):
        _fin(pen, _PELVIC, (0.12, 0.20), x=side * 0.030, lean=side * 0.25, material=red)
        _pectoral(pen, side, web)
        _face(pen, side, scales)
    mouth = pen.material(PLAIN, shaded(scales.flank, 0.22), rough=0.6)
    for side in (-1.0, 1.0):
        pen.tube(
            ((0, 0.462, 0.252), (side * 0.040, 0.440, 0.238), (side * 0.050, 0.395, 0.229)),
            0.0036,
            0.0022,
            mouth,
        )
    return pen.body(tilt_deg=(76.0, 86.0), yaw_deg=-14.0)


def _face(pen: Pen, side: float, scales: Scales) -> None:
    """A round eye in a dark rim: bronze iris, darker above, a large pupil, the light in it."""
    at = 0.0925
    eye = pen.material(
        PLAIN, linear(158, 118, 50), rough=0.25, coat=1.0, coat_rough=0.03,
        marks=(
            Mark((at, 0.345, 0.338), (0.05, 0.040, 0.014), linear(70, 62, 34), 0.6, 0.3),
            Mark((at, 0.346, 0.3135), (0.05, 0.0178, 0.0172), linear(168, 142, 78), 0.12, 0.05),
            Mark((at, 0.346, 0.3135), (0.05, 0.0158, 0.0152), linear(8, 8, 10), 0.08, 0.03),
            Mark((at, 0.353, 0.3215), (0.05, 0.0040, 0.0034), linear(232, 236, 240), 0.5, 0.0),
        ),
    )  # fmt: skip
    rim = pen.material(PLAIN, shaded(scales.back, 0.5), rough=0.4, coat=0.4, coat_rough=0.15)
    pen.ellipsoid((side * 0.0575, 0.345, 0.314), (0.018, 0.0335, 0.0325), rim)
    pen.ellipsoid((side * 0.0605, 0.345, 0.314), (0.0185, 0.0285, 0.0275), eye)


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
