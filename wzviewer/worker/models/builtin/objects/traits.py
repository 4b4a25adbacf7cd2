"""What builders say about looks: colours, marks, tints; and small vector helpers."""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.types import DoubleArray

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Mark:
    """A coloured ellipsoid painted on a material, mirrored at x = 0; softness relative to its size."""

    centre: Vector
    radii: Vector
    color: Vector
    soft: float = 0.06
    ragged: float = 0.05

    def row(self) -> list[float]:
        """Returns its columns of a material."""
        return [*self.centre, *self.radii, self.soft, self.ragged, *self.color]


@dataclass(frozen=True)
class Tint:
    """What a prompt's adjectives ask for: a linear colour, a pattern word, a substance word."""

    color: Vector | None = None
    pattern: str = ""
    substance: str = ""


def vector(p: DoubleArray) -> Vector:
    """Returns a point as a tuple."""
    return float(p[0]), float(p[1]), float(p[2])


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
