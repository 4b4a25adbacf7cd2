"""Bodies: what a builder makes (flat arrays) and the small pen it draws with."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import baking
from wzviewer.worker.models.builtin.objects.patterns import MATERIAL, SHEET
from wzviewer.worker.models.builtin.objects.primitives import (
    BEZIER,
    BOX,
    CARD,
    CONE,
    CYLINDER,
    DOME,
    ELLIPSOID,
    LOFT,
    PRISM,
    ROW,
    SPIRAL,
    TORUS,
)
from wzviewer.worker.models.builtin.objects.terms import MARK, MARKS
from wzviewer.worker.models.builtin.objects.traits import (
    Mark,
    Tint,
    Vector,
    axes_along,
    linear,
    shaded,
    vector,
)

__all__ = ["Body", "Builder", "Mark", "Pen", "Tint", "Vector", "axes_along", "linear", "shaded", "vector"]


@dataclass(frozen=True, eq=False)
class Body:
    """An object, ready to be marched.

    Attributes:
        primitives: (n, 36) float64, see `primitives`.
        materials: (m, 128) float64, see `patterns`.
        outlines: (k, s, s) float32 signed distances on [-1, 1]^2.
        cards: (k, c, s, s) float32 further distances of cards.
        tilt_deg: smallest and largest angle between the view and the support's normal.
        yaw_deg: heading in the image, counted from right towards the back.
        turns: whether it may head the other way as well; not if only one side is worth seeing.
        refractive: True for clear bodies, composited by bending the background.
        clear: (r, g, b) share of light that a clear body lets through.
        nose: where its fur begins to lie; hairs point away from there.
    """

    primitives: DoubleArray
    materials: DoubleArray
    outlines: FloatArray
    cards: FloatArray
    tilt_deg: tuple[float, float] = (28.0, 55.0)
    yaw_deg: float = 35.0
    turns: bool = True
    refractive: bool = False
    clear: Vector = (1.0, 1.0, 1.0)
    nose: Vector = (0.0, 0.4, 0.3)


@dataclass
class Pen:
    """Collects primitives and materials; every method that adds a primitive takes object units."""

    rng: np.random.Generator
    rows: list[DoubleArray] = field(default_factory=list)
    materials: list[DoubleArray] = field(default_factory=list)
    outlines: list[FloatArray] = field(default_factory=list)
    cards: list[FloatArray] = field(default_factory=list)
    groups: int = 0

    def group(self) -> int:
        """Returns a new group: surfaces of one group melt into each other."""
        self.groups += 1
        return self.groups

    def material(
        self,
        pattern: int,
        albedo: Vector,
        second: Vector | None = None,
        *,
        rough: float = 0.5,
        metal: float = 0.0,
        wavelength: float = 0.0165,
        wrap: float = 0.2,
        f0: float = 0.04,
        thin: float = 0.0,
        coat: float = 0.0,
        sheen: float = 0.0,
        coat_rough: float = 0.05,
        relief: float = 0.0,
        free: tuple[float, ...] = (),
        sheet: bool = False,
        marks: tuple[Mark, ...] = (),
    ) -> int:
        """Adds a material (columns in `patterns`); returns its index."""
        row = np.zeros(MATERIAL)
        row[:17] = [
            pattern,
            *albedo,
            *(second or albedo),
            rough,
            metal,
            wavelength,
            wrap,
            f0,
            thin,
            coat,
            sheen,
            coat_rough,
            relief,
        ]
        row[17 : 17 + len(free)] = free
        row[SHEET] = float(sheet)
        for k, mark in enumerate(marks):
            row[MARKS + k * MARK : MARKS + (k + 1) * MARK] = [1.0, *mark.row()]
        self.materials.append(row)
        return len(self.materials) - 1

    def ellipsoid(
        self,
        centre: Vector,
        radii: Vector,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
        axes: DoubleArray | None = None,
    ) -> None:
        """Adds an ellipsoid; `axes` are its local axes as rows."""
        row = self._row(ELLIPSOID, centre, material, group, blend, axes)
        row[16:19] = radii
        self._bound(row, np.asarray(centre), max(radii))

    def dome(
        self,
        centre: Vector,
        radii: Vector,
        cut: float,
        material: int,
        *,
        edge: float = 0.02,
        group: int | None = None,
        blend: float = 0.0,
        axes: DoubleArray | None = None,
    ) -> None:
        """Adds the part of an ellipsoid above local z = cut, its edge rounded."""
        row = self._row(DOME, centre, material, group, blend, axes)
        row[16:21] = [*radii, cut, edge]
        self._bound(row, np.asarray(centre), max(radii))

    def cone(
        self,
        start: Vector,
        end: Vector,
        r0: float,
        r1: float,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
    ) -> None:
        """Adds a round cone between two points."""
        a, b = np.asarray(start), np.asarray(end)
        length = float(np.linalg.norm(b - a))
        row = self._row(CONE, start, material, group, blend, axes_along(b - a))
        row[16:19] = [length, r0, r1]
        self._bound(row, (a + b) / 2, length / 2 + max(r0, r1))

    def box(
        self,
        centre: Vector,
        half: Vector,
        rounding: float,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
        axes: DoubleArray | None = None,
    ) -> None:
        """Adds a box with rounded edges."""
        row = self._row(BOX, centre, material, group, blend, axes)
        row[16:20] = [*half, rounding]
        self._bound(row, np.asarray(centre), float(np.linalg.norm(half)))

    def cylinder(
        self,
        centre: Vector,
        radius: float,
        half: float,
        rounding: float,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
        axes: DoubleArray | None = None,
        texture: int = 0,
    ) -> None:
        """Adds a capped cylinder along local z; `texture` may hold a struck relief."""
        row = self._row(CYLINDER, centre, material, group, blend, axes)
        row[28] = texture
        row[16:19] = [radius, half, rounding]
        self._bound(row, np.asarray(centre), float(np.hypot(radius, half)))

    def tube(
        self,
        points: tuple[Vector, Vector, Vector],
        r0: float,
        r1: float,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
        shadow: bool = True,
    ) -> None:
        """Adds a quadratic Bezier tube."""
        control = np.asarray(points)
        row = self._row(BEZIER, points[0], material, group, blend, None)
        row[16:25], row[25:27], row[35] = control.ravel(), (r0, r1), float(shadow)
        centre = (control.min(0) + control.max(0)) / 2
        reach = float(np.linalg.norm(control - centre, axis=1).max())
        self._bound(row, centre, reach + max(r0, r1))

    def card(
        self,
        centre: Vector,
        axes: DoubleArray,
        size: float,
        thickness: float,
        bend: tuple[float, float, float, float],
        texture: int,
        material: int,
        mean: tuple[float, float] = (0.0, 0.0),
        reach: float = 1.0,
        root: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Adds a thin sheet: outline `texture` scaled by `size`, bent by (xx, yy, xy, |x|) terms.

        `mean` and `reach` bound the outline on the card: centre and radius in texture units;
        `root` is where rows of scales begin, in texture units.
        """
        row = self._row(CARD, centre, material, None, 0.0, axes)
        row[16:22] = [size, thickness / 2, *bend]
        row[22:24] = size * root[0], size * root[1]
        row[28], row[34] = texture, 3.0 * size / self.outlines[texture].shape[0]
        middle = np.asarray(centre) + size * (mean[0] * axes[0] + mean[1] * axes[1])
        lift = size * size * (abs(bend[0]) + abs(bend[1]) + abs(bend[2])) + size * abs(bend[3])
        self._bound(row, middle, float(np.hypot(size * reach, 0.6 * lift)) + thickness)

    def loft(
        self,
        stations: Sequence[tuple[float, float, float, float, float]],
        material: int,
        *,
        centre: Vector = (0.0, 0.0, 0.0),
        axes: DoubleArray | None = None,
        sway: Callable[[DoubleArray], DoubleArray] | None = None,
        group: int | None = None,
        blend: float = 0.0,
    ) -> None:
        """Adds a body along local y through stations (y, cz, half width, height above, height below).

        `sway` gives the sections' cx at y; stations are joined by monotone cubics.
        """
        table = np.asarray(sorted(stations), np.float64)
        y = np.linspace(table[0, 0], table[-1, 0], baking.SIZE)
        curves = [PchipInterpolator(table[:, 0], table[:, k])(y) for k in (1, 2, 3, 4)]
        sheet = np.zeros((baking.SIZE, baking.SIZE), np.float32)
        sheet[:5] = np.stack([sway(y) if sway else 0 * y, *curves])
        row = self._row(LOFT, centre, material, group, blend, axes)
        row[16:18], row[28] = (y[0], y[-1]), self.texture(sheet, None)
        row[34] = 2.0 * (y[-1] - y[0]) / baking.SIZE
        low = np.array([(sheet[0] - sheet[2]).min(), y[0], (sheet[1] - sheet[4]).min()])
        high = np.array([(sheet[0] + sheet[2]).max(), y[-1], (sheet[1] + sheet[3]).max()])
        row[18:22] = low[0], high[0], low[2], high[2]
        turned = (np.eye(3) if axes is None else axes).T @ ((low + high) / 2)
        self._bound(row, np.asarray(centre) + turned, float(np.linalg.norm(high - low)) / 2)

    def spiral(
        self,
        radius: float,
        growth: float,
        rise: float,
        tube: float,
        turns: tuple[float, float],
        material: int,
        *,
        centre: Vector = (0.0, 0.0, 0.0),
        axes: DoubleArray | None = None,
        flat: float = 1.0,
        knobs: tuple[float, float] = (0.0, 0.0),
        slant: float = 0.0,
        flare: float = 0.0,
        cut: bool = False,
        group: int | None = None,
        blend: float = 0.0,
    ) -> None:
        """Adds a tube on a logarithmic spiral, turn angles from `turns`; `cut` takes it away instead."""
        row = self._row(SPIRAL, centre, material, group, blend, axes)
        row[1] = float(cut)
        once = float(np.exp(2 * np.pi * growth))
        row[16:28] = [radius, growth, rise, tube, flat, *turns, *knobs, slant, flare, once]
        g = float(np.exp(growth * turns[1]))
        reach = tube * max(flat, 1.0) * g * (1 + knobs[0]) * (1 + max(flare, 0.0))
        middle = np.array([0.0, 0.0, 0.5 * rise * g])
        turned = (np.eye(3) if axes is None else axes).T @ middle
        size = float(np.hypot(radius * g, 0.5 * abs(rise) * g)) + reach
        self._bound(row, np.asarray(centre) + turned, size)

    def prism(
        self,
        foot: Vector,
        axes: DoubleArray,
        radius: float,
        length: float,
        tip: float,
        material: int,
        *,
        group: int | None = None,
        blend: float = 0.0,
    ) -> None:
        """Adds a six-sided crystal from its foot along local z, `tip` of it pointed."""
        half = (length - tip) / 2
        centre = np.asarray(foot) + half * axes[2]
        row = self._row(PRISM, vector(centre), material, group, blend, axes)
        row[16:19] = [radius, half, tip]
        self._bound(row, centre + 0.5 * tip * axes[2], float(np.hypot(1.16 * radius, length / 2)))

    def torus(
        self,
        centre: Vector,
        radius: float,
        tube: float,
        material: int,
        *,
        axes: DoubleArray | None = None,
        group: int | None = None,
        blend: float = 0.0,
    ) -> None:
        """Adds a ring around local z."""
        row = self._row(TORUS, centre, material, group, blend, axes)
        row[16:18] = [radius, tube]
        self._bound(row, np.asarray(centre), radius + tube)

    def texture(self, outline: FloatArray, channels: FloatArray | None = None) -> int:
        """Adds a baked outline (s, s) and its channels (c, s, s); returns its index."""
        self.outlines.append(outline)
        blank = np.zeros((3, 1, 1), np.float32)
        self.cards.append(blank if channels is None else channels)
        return len(self.outlines) - 1

    def body(self, *, lift: float = 0.0, **looks: object) -> Body:
        """Returns what was drawn, raised by `lift` (painted marks are not)."""
        rows = np.asarray(self.rows)
        rows[:, [6, 32]] += lift
        rows[np.ix_(rows[:, 0] == BEZIER, (18, 21, 24))] += lift
        rows = np.ascontiguousarray(rows[np.argsort(rows[:, 29], kind="stable")])
        outlines = np.stack(self.outlines) if self.outlines else np.ones((1, 4, 4), np.float32)
        cards = _stacked(self.cards)
        return Body(rows, np.asarray(self.materials), outlines, cards, **looks)  # type: ignore[arg-type]

    def _row(
        self,
        kind: int,
        centre: Vector,
        material: int,
        group: int | None,
        blend: float,
        axes: DoubleArray | None,
    ) -> DoubleArray:
        row = np.zeros(ROW)
        row[0], row[2], row[3], row[35] = kind, blend, material, 1.0
        row[4:7] = centre
        row[7:16] = (np.eye(3) if axes is None else axes).ravel()
        row[29] = self.group() if group is None else group
        return row

    def _bound(self, row: DoubleArray, centre: DoubleArray, radius: float) -> None:
        row[30:33], row[33] = centre, 1.02 * radius + row[2] + 0.004
        self.rows.append(row)


Builder = Callable[[np.random.Generator, Tint], Body]


def _stacked(cards: list[FloatArray]) -> FloatArray:
    """Returns (k, c, s, s); cards without channels take no memory of their own unless others have some."""
    size = max((c.shape[-1] for c in cards), default=4)
    full = [np.broadcast_to(c, (3, size, size)) if c.shape[-1] == 1 else c for c in cards]
    return np.stack(full) if full else np.ones((1, 3, 4, 4), np.float32)
