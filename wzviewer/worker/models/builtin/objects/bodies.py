"""Bodies: what a builder makes (flat arrays) and the small pen it draws with."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.patterns import MATERIAL
from wzviewer.worker.models.builtin.objects.primitives import (
    BEZIER,
    BOX,
    CARD,
    CONE,
    CYLINDER,
    DOME,
    ELLIPSOID,
    ROW,
)

Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Body:
    """An object, ready to be marched.

    Attributes:
        primitives: (n, 36) float64, see `primitives`.
        materials: (m, 24) float64, see `patterns`.
        outlines: (k, s, s) float32 signed distances on [-1, 1]^2.
        cards: (k, c, s, s) float32 further distances of cards.
        tilt_deg: smallest and largest angle between the view and the support's normal.
        yaw_deg: heading in the image, counted from right towards the back.
        refractive: True for clear bodies, composited by bending the background.
    """

    primitives: DoubleArray
    materials: DoubleArray
    outlines: FloatArray
    cards: FloatArray
    tilt_deg: tuple[float, float] = (28.0, 55.0)
    yaw_deg: float = 35.0
    refractive: bool = False


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
    ) -> None:
        """Adds the part of an ellipsoid above local z = cut, its edge rounded."""
        row = self._row(DOME, centre, material, group, blend, None)
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
    ) -> None:
        """Adds a box with rounded edges."""
        row = self._row(BOX, centre, material, group, blend, None)
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
    ) -> None:
        """Adds an upright capped cylinder."""
        row = self._row(CYLINDER, centre, material, group, blend, None)
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

    def texture(self, outline: FloatArray, channels: FloatArray) -> int:
        """Adds a baked outline (s, s) and its channels (c, s, s); returns its index."""
        self.outlines.append(outline)
        self.cards.append(channels)
        return len(self.outlines) - 1

    def body(self, **looks: object) -> Body:
        """Returns what was drawn."""
        rows = np.asarray(self.rows)
        rows = np.ascontiguousarray(rows[np.argsort(rows[:, 29], kind="stable")])
        outlines = np.stack(self.outlines) if self.outlines else np.ones((1, 4, 4), np.float32)
        cards = np.stack(self.cards) if self.cards else np.ones((1, 3, 4, 4), np.float32)
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


Builder = Callable[[np.random.Generator, "Tint"], Body]


@dataclass(frozen=True)
class Tint:
    """What a prompt's adjectives ask for: a linear colour, a pattern word, a substance word."""

    color: Vector | None = None
    pattern: str = ""
    substance: str = ""


def axes_along(direction: DoubleArray) -> DoubleArray:
    """Returns (3, 3) rows: an orthonormal frame whose z is along `direction`."""
    z = direction / max(float(np.linalg.norm(direction)), 1e-12)
    helper = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def linear(red: int, green: int, blue: int) -> Vector:
    """Returns the linear albedo of an sRGB colour 0..255."""
    values = [c / 255 for c in (red, green, blue)]
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in values)
    return r, g, b


def shaded(color: Vector, gain: float) -> Vector:
    """Returns a colour made lighter or darker."""
    return min(color[0] * gain, 1.0), min(color[1] * gain, 1.0), min(color[2] * gain, 1.0)
