"""Builder: butterflies, wings half open, from one drawing of veins and many colourings."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.bodies import Body, Pen, Tint, Vector, linear
from wzviewer.worker.models.builtin.objects.insects import add_antenna, add_eye
from wzviewer.worker.models.builtin.objects.patterns import CHITIN, HAIR, PLAIN, WING

# Right wings, drawing units of one fore wing's length; the root is (0, 0), x outward, y forward.
_FORE = [
    (0.0, 0.025),
    (0.12, 0.13),
    (0.30, 0.285),
    (0.52, 0.455),
    (0.74, 0.60),
    (0.90, 0.665),
    (0.985, 0.655),
    (0.995, 0.58),
    (0.945, 0.45),
    (0.905, 0.30),
    (0.885, 0.15),
    (0.860, 0.00),
    (0.800, -0.085),
    (0.62, -0.105),
    (0.36, -0.095),
    (0.12, -0.06),
]
_HIND = [
    (0.0, 0.01),
    (0.10, 0.085),
    (0.28, 0.135),
    (0.47, 0.125),
    (0.645, 0.045),
    (0.755, -0.095),
    (0.790, -0.26),
    (0.745, -0.43),
    (0.640, -0.575),
    (0.510, -0.665),
    (0.375, -0.690),
    (0.255, -0.635),
    (0.150, -0.50),
    (0.075, -0.33),
    (0.02, -0.14),
]
_FORE_VEINS = [
    [(0.0, 0.02), (0.20, 0.125), (0.40, 0.235), (0.57, 0.325)],
    [(0.0, 0.0), (0.18, 0.055), (0.36, 0.105), (0.53, 0.150)],
    [(0.57, 0.325), (0.525, 0.245), (0.53, 0.150)],
    [(0.30, 0.245), (0.55, 0.43), (0.80, 0.60)],
    [(0.57, 0.325), (0.76, 0.48), (0.93, 0.625)],
    [(0.57, 0.325), (0.76, 0.43), (0.965, 0.53)],
    [(0.548, 0.285), (0.75, 0.365), (0.935, 0.42)],
    [(0.525, 0.235), (0.72, 0.28), (0.905, 0.30)],
    [(0.53, 0.150), (0.71, 0.195), (0.885, 0.19)],
    [(0.45, 0.128), (0.66, 0.095), (0.865, 0.06)],
    [(0.28, 0.085), (0.55, 0.005), (0.81, -0.07)],
    [(0.0, 0.0), (0.25, -0.045), (0.50, -0.075), (0.75, -0.095)],
]
_HIND_VEINS = [
    [(0.0, 0.01), (0.18, 0.05), (0.34, 0.02), (0.43, -0.04)],
    [(0.0, 0.0), (0.09, -0.10), (0.19, -0.22), (0.30, -0.31)],
    [(0.43, -0.04), (0.40, -0.18), (0.30, -0.31)],
    [(0.20, 0.055), (0.42, 0.07), (0.62, 0.06)],
    [(0.43, -0.04), (0.58, -0.04), (0.74, -0.075)],
    [(0.425, -0.09), (0.60, -0.15), (0.785, -0.25)],
    [(0.405, -0.165), (0.57, -0.28), (0.75, -0.42)],
    [(0.365, -0.24), (0.50, -0.40), (0.645, -0.57)],
    [(0.30, -0.31), (0.40, -0.49), (0.505, -0.665)],
    [(0.22, -0.25), (0.29, -0.45), (0.36, -0.685)],
    [(0.05, -0.06), (0.13, -0.30), (0.235, -0.60)],
]
_FORE_WINDOW = baking.Window((0.50, 0.28), 0.56)
_HIND_WINDOW = baking.Window((0.40, -0.28), 0.47)


@dataclass(frozen=True)
class Coloring:
    """One species' wings: ground, margin, vein and border width, how much white, paling outward."""

    ground: Vector
    margin: Vector
    vein: float
    border: float
    dots: float
    paling: float
    sheen: float = 0.25
    metal: float = 0.0


MONARCH = Coloring(linear(232, 112, 18), linear(26, 19, 17), 0.013, 0.112, 1.0, 0.35)
MORPHO = Coloring(linear(20, 96, 214), linear(17, 15, 20), 0.0045, 0.105, 0.8, 0.25, 0.5, 0.25)
CABBAGE = Coloring(linear(240, 238, 220), linear(92, 90, 82), 0.003, 0.022, 0.0, -0.1)


def butterfly(rng: np.random.Generator, tint: Tint) -> Body:
    """A monarch; a tint recolours the ground and keeps the black veins and border."""
    coloring = MONARCH
    if tint.color is not None:
        coloring = Coloring(tint.color, MONARCH.margin, 0.008, 0.112, 1.0, 0.3)
    return _butterfly(rng, coloring)


def morpho(rng: np.random.Generator, tint: Tint) -> Body:
    """A blue morpho."""
    return _butterfly(rng, MORPHO)


def cabbage_white(rng: np.random.Generator, tint: Tint) -> Body:
    """A white with grey tips."""
    return _butterfly(rng, CABBAGE)


def _butterfly(rng: np.random.Generator, coloring: Coloring) -> Body:
    pen = Pen(rng)
    membrane = pen.material(
        WING,
        coloring.ground,
        coloring.margin,
        rough=0.5,
        metal=coloring.metal,
        wrap=0.12,
        thin=0.6,
        coat=0.4,
        coat_rough=0.42,
        sheen=coloring.sheen,
        wavelength=0.0050,
        free=(coloring.vein, coloring.border, coloring.dots, coloring.paling),
    )
    fore = pen.texture(*_fore_texture())
    hind = pen.texture(*_hind_texture())
    for side in (-1.0, 1.0):
        raise_fore = np.radians(33.0 + rng.normal(0, 2.5))
        raise_hind = np.radians(22.0 + rng.normal(0, 2.0))
        _wing(
            pen,
            side,
            (0.030, 0.085, 0.165),
            raise_fore,
            np.radians(3),
            0.60,
            fore,
            membrane,
            _FORE_WINDOW,
            0.95,
        )
        _wing(
            pen,
            side,
            (0.030, 0.025, 0.150),
            raise_hind,
            np.radians(-2),
            0.60,
            hind,
            membrane,
            _HIND_WINDOW,
            0.92,
        )
    _trunk(pen)
    return pen.body(tilt_deg=(22.0, 46.0), yaw_deg=68.0)


def _wing(
    pen: Pen,
    side: float,
    root: Vector,
    lift: float,
    sweep: float,
    length: float,
    texture: int,
    material: int,
    window: baking.Window,
    reach: float,
) -> None:
    """Hinges a drawing at its root: raised by `lift`, turned forward by `sweep`, cupped a little."""
    forward = np.array([-side * np.sin(sweep), np.cos(sweep), 0.10])
    forward /= np.linalg.norm(forward)
    outward = np.array([side * np.cos(sweep) * np.cos(lift), np.sin(sweep) * np.cos(lift), np.sin(lift)])
    outward -= (outward @ forward) * forward
    outward /= np.linalg.norm(outward)
    normal = np.cross(outward, forward) * side  # a mirrored frame serves the left wings
    axes = np.stack([outward, forward, normal])
    u, v = window.uv([(0.0, 0.0)])[0]
    half = length * window.half
    centre = np.array([side * root[0], root[1], root[2]]) - half * (u * outward + v * forward)
    bend = (-0.75, -0.55, 0.25, 0.0)
    drop = bend[0] * (half * u) ** 2 + bend[1] * (half * v) ** 2 + bend[2] * half * half * u * v
    centre = centre - drop * normal
    pen.card(
        (float(centre[0]), float(centre[1]), float(centre[2])),
        axes,
        half,
        0.0045,
        bend,
        texture,
        material,
        (0, 0),
        1.15 * reach,
        (u, v),
    )


def _trunk(pen: Pen) -> None:
    """Furry thorax, tapering abdomen, head with eyes, clubbed antennae, four standing legs."""
    dark = pen.material(
        CHITIN,
        linear(30, 23, 21),
        linear(64, 46, 36),
        rough=0.55,
        wrap=0.35,
        sheen=0.3,
        wavelength=0.02,
        relief=0.05,
    )
    horn = pen.material(
        CHITIN,
        linear(28, 22, 20),
        linear(56, 40, 30),
        rough=0.4,
        coat=0.4,
        coat_rough=0.2,
        wavelength=0.012,
        relief=0.03,
    )
    fur = pen.material(HAIR, linear(98, 80, 64), linear(30, 24, 22), rough=0.5, wrap=0.5, sheen=0.3)
    white = pen.material(PLAIN, linear(225, 220, 208), rough=0.7)
    trunk = pen.group()
    pen.ellipsoid((0, 0.065, 0.150), (0.044, 0.085, 0.046), dark, group=trunk, blend=0.03)
    for k in range(8):  # abdominal rings
        t = k / 7
        r = 0.036 * np.sqrt(max(1 - (1.02 * t - 0.25) ** 2, 0.02))
        pen.ellipsoid(
            (0, -0.045 - 0.285 * t, 0.140 - 0.055 * t * t), (r, 0.034, r), dark, group=trunk, blend=0.012
        )
    pen.ellipsoid((0, 0.170, 0.148), (0.034, 0.032, 0.031), dark, group=trunk, blend=0.015)
    fuzz(pen, (0, 0.065, 0.150), (0.044, 0.085, 0.046), 170, 0.060, fur)
    fuzz(pen, (0, 0.165, 0.150), (0.034, 0.032, 0.031), 40, 0.028, fur)
    for side in (-1.0, 1.0):
        add_eye(pen, (side * 0.029, 0.182, 0.150), 0.0185, (side, 0.3, 0.2))
        add_antenna(
            pen, side, ((0.012, 0.195, 0.168), (0.075, 0.36, 0.245), (0.185, 0.475, 0.235)), 0.0052, 9, horn
        )
        for x, y in ((0.020, 0.135), (0.026, 0.110), (0.020, 0.005)):
            pen.ellipsoid((side * x, y, 0.186), (0.005, 0.006, 0.003), white)
        for y, reach in ((0.10, 0.16), (0.03, 0.02)):
            knee = (side * 0.075, y + 0.6 * (reach - y) + 0.02, 0.085)
            pen.cone((side * 0.025, y, 0.115), knee, 0.009, 0.007, horn)
            pen.tube(
                (knee, (side * 0.095, reach, 0.04), (side * 0.105, reach + 0.03, 0.004)), 0.006, 0.0035, horn
            )


def fuzz(pen: Pen, centre: Vector, radii: Vector, count: int, length: float, hair: int) -> None:
    """Hairs all over an ellipsoid's upper side, combed backwards."""
    for _ in range(count):
        d = pen.rng.normal(size=3)
        d[2] = abs(d[2]) - 0.2
        d /= np.linalg.norm(d)
        base = np.asarray(centre) + 0.97 * d * radii
        out = d / np.asarray(radii)
        out /= np.linalg.norm(out)
        reach = length * pen.rng.uniform(0.6, 1.1)
        middle, tip = base + 0.5 * reach * out, base + reach * (0.65 * out + np.array([0, -0.75, 0.1]))
        points = tuple((float(p[0]), float(p[1]), float(p[2])) for p in (base, middle, tip))
        pen.tube(points, 0.0024, 0.0008, hair, shadow=False)  # type: ignore[arg-type]


@lru_cache(maxsize=1)
def _fore_texture() -> tuple[FloatArray, FloatArray]:
    """Bakes the fore wing; the monarch's black apex joins its veins, two rows of dots its margin."""
    extra = np.array(
        [[0.875, 0.575], [0.80, 0.515], [0.855, 0.49], [0.715, 0.475], [0.775, 0.445], [0.86, 0.415]]
    )
    return _bake(_FORE, _FORE_VEINS, _FORE_WINDOW, (0.90, 0.66, 0.36), extra, 0.50)


@lru_cache(maxsize=1)
def _hind_texture() -> tuple[FloatArray, FloatArray]:
    return _bake(_HIND, _HIND_VEINS, _HIND_WINDOW, (9.0, 9.0, 0.0), np.zeros((0, 2)), 0.42)


def _bake(
    outline: baking.Points,
    veins: list[baking.Points],
    window: baking.Window,
    apex: Vector,
    extra: DoubleArray,
    from_root: float,
) -> tuple[FloatArray, FloatArray]:
    """Returns the outline's distance and the channels: veins, dots, distance from the root (0..1)."""
    flat = baking.outline_distance(baking.closed_curve(outline), window)
    vein = baking.line_distance([baking.open_curve(v) for v in veins], window)
    v, u = baking.texel_grid()
    (ax, ay), (rx, ry) = window.uv([apex[:2]])[0], window.uv([(0.0, 0.0)])[0]
    vein = np.minimum(vein, np.maximum(np.hypot(u - ax, 1.25 * (v - ay)) - apex[2] / window.half, -0.05))
    shade = np.hypot(u - rx, v - ry) * window.half
    rows = [baking.inset_points(flat, depth / window.half, 0.042 / window.half) for depth in (0.018, 0.046)]
    rows[1] = rows[1][::1] + 0.0
    points = np.concatenate(rows)
    radii = np.concatenate([np.full(len(rows[0]), 0.0075), np.full(len(rows[1]), 0.0105)]) / window.half
    reach = np.hypot(points[:, 0] - rx, points[:, 1] - ry) * window.half
    # The margin only: not the leading edge near the root, not the edge along the body.
    keep = (reach > from_root) & _outer(points, (rx, ry), window)
    points = np.concatenate([points[keep], window.uv(extra)]) if len(extra) else points[keep]
    radii = np.concatenate([radii[keep], np.full(len(extra), 0.026 / window.half)])
    dots = baking.dot_distance(points, radii)
    return flat, np.stack([vein, dots, np.clip(shade, 0, 1)]).astype(np.float32)


def _outer(points: DoubleArray, root: tuple[float, float], window: baking.Window) -> DoubleArray:
    """Tells which points lie on the outward half of the outline."""
    x = (points[:, 0] - root[0]) * window.half
    y = (points[:, 1] - root[1]) * window.half
    return np.asarray((x > 0.30) & (y < 0.80 * x + 0.02) | (x > 0.86))
