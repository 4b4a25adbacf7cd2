"""Builder: small perching birds, one form in many plumages.  y forward, z up; length 1 with the tail."""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import (
    Body,
    Builder,
    Mark,
    Pen,
    Tint,
    Vector,
    linear,
    shaded,
)
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, FUR, HIDE, PLAIN, PLUMES
from wzviewer.worker.models.builtin.objects.wings import spread_wing

WHITE, BLACK = linear(236, 232, 222), linear(30, 28, 30)
_BELLY = ((0.0, -0.02, 0.20), (0.19, 0.26, 0.135))
_BREAST = ((0.0, 0.235, 0.415), (0.150, 0.150, 0.185))
_FACE = ((0.0, 0.350, 0.535), (0.125, 0.105, 0.085))
_CROWN = ((0.0, 0.255, 0.685), (0.12, 0.145, 0.075))
_CHEEK = ((0.115, 0.255, 0.535), (0.055, 0.068, 0.042))
_BIB = ((0.0, 0.345, 0.465), (0.075, 0.075, 0.065))
_HOOD = ((0.0, 0.280, 0.585), (0.16, 0.165, 0.125))


@dataclass(frozen=True)
class Plumage:
    """Colours of back, wing, wing edges, tail and bill, and what is painted on the body."""

    back: Vector
    wing: Vector
    edge: Vector
    tail: Vector
    bill: Vector
    marks: tuple[Mark, ...]


ROBIN = Plumage(
    linear(112, 96, 74),
    linear(104, 86, 64),
    linear(148, 122, 84),
    linear(96, 78, 58),
    linear(52, 44, 40),
    (
        Mark(*_BELLY, WHITE, 0.16, 0.10),
        Mark((0.0, 0.235, 0.43), (0.172, 0.168, 0.222), linear(138, 140, 142), 0.10, 0.06),
        Mark(*_BREAST, linear(226, 92, 22), 0.07, 0.06),
        Mark(*_FACE, linear(224, 88, 22), 0.07, 0.06),
    ),
)
SPARROW = Plumage(
    linear(134, 96, 62),
    linear(126, 82, 48),
    linear(206, 174, 130),
    linear(104, 82, 62),
    linear(58, 50, 46),
    (
        Mark((0.0, 0.08, 0.26), (0.19, 0.30, 0.19), linear(196, 186, 172), 0.16, 0.10),
        Mark(*_CHEEK, linear(214, 208, 198), 0.10, 0.06),
        Mark(*_CROWN, linear(124, 66, 34), 0.08, 0.06),
        Mark(*_BIB, BLACK, 0.10, 0.10),
    ),
)
BLUE_TIT = Plumage(
    linear(112, 140, 92),
    linear(62, 106, 168),
    linear(206, 220, 230),
    linear(70, 112, 168),
    linear(46, 44, 48),
    (
        Mark((0.0, 0.13, 0.30), (0.18, 0.30, 0.22), linear(238, 206, 62), 0.10, 0.06),
        Mark(*_HOOD, WHITE, 0.06, 0.04),
        Mark((0.0, 0.33, 0.575), (0.135, 0.125, 0.014), linear(28, 34, 66), 0.5, 0.3),
        Mark((0.0, 0.29, 0.467), (0.13, 0.13, 0.026), linear(28, 34, 66), 0.3, 0.2),
        Mark(*_CROWN, linear(58, 112, 188), 0.06, 0.04),
    ),
)
CARDINAL = Plumage(
    linear(196, 28, 24),
    linear(158, 30, 28),
    linear(204, 60, 50),
    linear(160, 26, 26),
    linear(236, 108, 44),
    (Mark((0.0, 0.355, 0.525), (0.085, 0.055, 0.060), BLACK, 0.08, 0.08),),
)
CROW = Plumage(
    linear(42, 42, 50), linear(40, 40, 50), linear(66, 68, 84), linear(38, 38, 46), linear(36, 34, 36), ()
)


_FLOCK = {
    "bird": ROBIN,
    "sparrow": SPARROW,
    "blue tit": BLUE_TIT,
    "cardinal": CARDINAL,
    "crow": CROW,
}


def robin(rng: np.random.Generator, tint: Tint) -> Body:
    """A European robin; a tint colours all but the belly, as in a canary."""
    return _bird(rng, ROBIN if tint.color is None else _plain(tint.color))


def sparrow(rng: np.random.Generator, tint: Tint) -> Body:
    """A house sparrow."""
    return _bird(rng, SPARROW if tint.color is None else _plain(tint.color))


def blue_tit(rng: np.random.Generator, tint: Tint) -> Body:
    """A blue tit."""
    return _bird(rng, BLUE_TIT if tint.color is None else _plain(tint.color))


def cardinal(rng: np.random.Generator, tint: Tint) -> Body:
    """A red cardinal with its crest."""
    return _bird(rng, CARDINAL if tint.color is None else _plain(tint.color), crest=True)


def crow(rng: np.random.Generator, tint: Tint) -> Body:
    """A crow, heavier of bill."""
    return _bird(rng, CROW if tint.color is None else _plain(tint.color), bill=1.5)


def canary(rng: np.random.Generator, tint: Tint) -> Body:
    """A canary."""
    return _bird(rng, _plain(tint.color or linear(244, 206, 40)))


def _plain(color: Vector) -> Plumage:
    belly = Mark(*_BELLY, shaded(color, 1.35), 0.2, 0.1)
    return Plumage(
        color, shaded(color, 0.72), shaded(color, 1.25), shaded(color, 0.62), linear(216, 150, 110), (belly,)
    )


def in_flight(name: str) -> Builder:
    """Returns the builder of a bird of `nouns` with its wings spread."""
    plumage = _FLOCK[name]

    def build(rng: np.random.Generator, tint: Tint) -> Body:
        worn = plumage if tint.color is None else _plain(tint.color)
        return _bird(rng, worn, name == "cardinal", 1.5 if name == "crow" else 1.0, flies=True)

    return build


def _bird(
    rng: np.random.Generator, plumage: Plumage, crest: bool = False, bill: float = 1.0, flies: bool = False
) -> Body:
    pen = Pen(rng)
    down = pen.material(
        FUR, plumage.back, rough=0.72, wrap=0.35, sheen=0.25, wavelength=0.0058, relief=0.020,
        free=(2.4, 0.12, 0.0, 0.1, 0.036, 0.35, 4e-4), f0=0.015, marks=plumage.marks,
    )  # fmt: skip
    group = pen.group()
    axes, sloping, falling = (_pitched(angle) for angle in (30.0, 40.0, 62.0))  # as the plumage lies
    pen.ellipsoid((0, 0.035, 0.335), (0.158, 0.265, 0.165), down, group=group, blend=0.10, axes=axes)
    pen.ellipsoid((0, 0.145, 0.375), (0.152, 0.165, 0.165), down, group=group, blend=0.10, axes=falling)
    pen.cone((0, -0.10, 0.29), (0, -0.30, 0.225), 0.105, 0.042, down, group=group, blend=0.09)
    pen.ellipsoid((0, 0.255, 0.560), (0.112, 0.122, 0.122), down, group=group, blend=0.10, axes=sloping)
    pen.ellipsoid((0, 0.335, 0.545), (0.060, 0.058, 0.058), down, group=group, blend=0.07, axes=falling)
    if crest:
        pen.cone((0, 0.26, 0.62), (0, 0.15, 0.765), 0.075, 0.010, down, group=group, blend=0.08)
    for side in (-1.0, 1.0):
        if flies:
            spread_wing(pen, side, (side * 0.10, 0.10, 0.43), plumage.wing, plumage.edge)
        else:
            pen.cone(
                (side * 0.07, 0.0, 0.25),
                (side * 0.072, -0.035, 0.155),
                0.065,
                0.022,
                down,
                group=group,
                blend=0.05,
            )
            _wing(pen, side, plumage)
            _leg(pen, side)
    _head(pen, plumage, bill)
    _tail(pen, plumage)
    if flies:
        return pen.body(tilt_deg=(38.0, 58.0), yaw_deg=28.0, nose=(0.0, 0.40, 0.545))
    return pen.body(tilt_deg=(74.0, 84.0), yaw_deg=-16.0, nose=(0.0, 0.40, 0.545))


def _pitched(degrees: float) -> DoubleArray:
    """Returns axes whose y is raised from forward."""
    c, s = float(np.cos(np.radians(degrees))), float(np.sin(np.radians(degrees)))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def _head(pen: Pen, plumage: Plumage, bill: float) -> None:
    """Eyes with a pale ring, and a bill of two halves."""
    horn = pen.material(
        CHITIN,
        plumage.bill,
        shaded(plumage.bill, 1.5),
        rough=0.4,
        coat=0.5,
        coat_rough=0.2,
        wavelength=0.02,
        relief=0.02,
    )
    glass = pen.material(PLAIN, linear(22, 17, 15), rough=0.2, coat=1.0, coat_rough=0.03)
    ring = pen.material(
        HIDE, shaded(plumage.bill, 0.9), rough=0.7, wavelength=0.006, free=(0.1, 0, 1, 1, 0.2)
    )
    pen.cone((0, 0.365, 0.556), (0, 0.365 + 0.088 * bill, 0.540), 0.026 * bill, 0.005, horn)
    pen.cone((0, 0.360, 0.534), (0, 0.355 + 0.080 * bill, 0.531), 0.019 * bill, 0.005, horn)
    for side in (-1.0, 1.0):
        pen.ellipsoid((side * 0.088, 0.305, 0.585), (0.021, 0.025, 0.025), glass)
        pen.ellipsoid((side * 0.083, 0.305, 0.585), (0.020, 0.031, 0.031), ring)


def _wing(pen: Pen, side: float, plumage: Plumage) -> None:
    """A folded wing: a flat body along the flank, its feathers painted by the list."""
    table = pen.texture(_wing_feathers(), None)
    quills = pen.material(
        PLUMES, plumage.wing, plumage.edge, rough=0.6, wrap=0.25, sheen=0.15, wavelength=0.0042,
        free=(table, len(_WING)),
    )  # fmt: skip
    back = np.array([0.0, -0.90, -0.436])
    axes = np.stack([[side, 0.0, 0.0], back, [0.0, -0.436, 0.90]])
    pen.loft(
        [
            (-0.27, 0.02, 0.004, 0.02, 0.02),
            (-0.22, 0.02, 0.034, 0.085, 0.075),
            (-0.08, 0.01, 0.044, 0.105, 0.110),
            (0.08, 0.00, 0.036, 0.088, 0.098),
            (0.22, -0.012, 0.024, 0.052, 0.056),
            (0.36, -0.030, 0.006, 0.010, 0.012),
        ],
        quills,
        centre=(side * 0.138, 0.005, 0.365),
        axes=axes,
    )


def _feathers() -> list[tuple[float, float, float, float, float, float, float]]:
    """Feathers of a folded wing, the uppermost first: root, tip, half width, tone, pale edge."""
    rows = []
    for line, (start, end, n) in enumerate(((-0.27, -0.165, 5), (-0.22, -0.105, 6), (-0.175, -0.035, 7))):
        for k in range(n):
            z = 0.095 - 0.185 * k / (n - 1)
            rows.append(
                (start, 0.8 * z, end - 0.012 * k, z, 0.125 / n + 0.006, 1.05, 0.55 if line == 2 else 0.25)
            )
    for k in range(3):
        rows.append((-0.12, 0.06 - 0.02 * k, 0.09 + 0.045 * k, 0.062 - 0.024 * k, 0.030, 0.92, 0.8))
    for k in range(6):
        rows.append((-0.10, 0.01 - 0.014 * k, 0.145 + 0.012 * k, 0.018 - 0.020 * k, 0.017, 0.80, 0.6))
    for k in range(6):
        rows.append((-0.02, -0.03 - 0.004 * k, 0.37 - 0.030 * k, -0.022 - 0.010 * k, 0.014, 0.62, 0.5))
    rows.append((-0.35, 0.0, 0.5, -0.05, 0.3, 0.7, 0.0))
    return rows


_WING = _feathers()


def _wing_feathers() -> FloatArray:
    return _table(np.asarray(_WING))


def _table(rows: DoubleArray) -> FloatArray:
    sheet = np.zeros((baking.SIZE, baking.SIZE), np.float32)
    sheet[: len(rows), : rows.shape[1]] = rows
    return sheet


def _tail(pen: Pen, plumage: Plumage) -> None:
    """Two fans of narrow feathers, seen from the side as one blade."""
    quill = pen.material(
        FUR,
        plumage.tail,
        shaded(plumage.tail, 0.5),
        rough=0.6,
        wrap=0.2,
        wavelength=0.006,
        relief=0.05,
        free=(8.0, 0.22),
    )
    for k, (x, drop) in enumerate(
        ((0.0, 0.0), (0.022, 0.006), (-0.022, 0.006), (0.045, 0.014), (-0.045, 0.014))
    ):
        tip = np.array([1.5 * x, -0.575 + 0.02 * (k // 2), 0.118 - drop])
        root = np.array([0.4 * x, -0.22, 0.238 - drop])
        along = (tip - root) / np.linalg.norm(tip - root)
        across = np.array([1.0, 0.0, 0.0]) - along[0] * along
        across /= np.linalg.norm(across)
        axes = np.stack([across, along, np.cross(across, along)])
        half = float(np.linalg.norm(tip - root)) / 2
        middle = (root + tip) / 2
        pen.loft(
            [(-half, 0, 0.022, 0.016, 0.014), (0.6 * half, 0, 0.032, 0.009, 0.009),
            (0.93 * half, 0, 0.024, 0.006, 0.006), (half, 0, 0.004, 0.003, 0.003)],
            quill,
            centre=(float(middle[0]), float(middle[1]), float(middle[2])),
            axes=axes,
        )  # fmt: skip


def _leg(pen: Pen, side: float) -> None:
    """A scaly shank and four toes, three of them forward."""
    skin = pen.material(
        HIDE,
        linear(126, 84, 58),
        linear(90, 56, 38),
        rough=0.5,
        coat=0.25,
        coat_rough=0.25,
        wavelength=0.010,
        free=(0.10, 0.4, 0.05, 0.7, 0.25),
    )
    x, foot = side * 0.072, 0.012 + pen.rng.uniform(-0.03, 0.03)
    group = pen.group()
    pen.cone((x, -0.035, 0.165), (x, foot - 0.012, 0.018), 0.013, 0.011, skin, group=group, blend=0.012)
    for turn, length in ((-0.5, 0.085), (0.0, 0.105), (0.5, 0.085), (3.14, 0.075)):
        dx, dy = float(np.sin(turn)), float(np.cos(turn))
        base = (x, foot - 0.01, 0.016)
        knuckle = (x + 0.55 * length * dx, foot + 0.55 * length * dy, 0.019)
        tip = (x + length * dx, foot + length * dy, 0.004)
        pen.tube((base, knuckle, tip), 0.0095, 0.0045, skin, group=group, blend=0.008)
