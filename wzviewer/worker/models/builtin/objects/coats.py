"""How fur lies on a body: away from the nose and down, along limbs and tail; how long it is where."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, DoubleArray
from wzviewer.worker.models.builtin.objects.bodies import Body
from wzviewer.worker.models.builtin.objects.patterns import FUR
from wzviewer.worker.models.builtin.objects.primitives import BEZIER, CONE, ELLIPSOID

LENGTH, LIFT, WIDTH = 21, 22, 23  # columns of a fur material: of a hair, how steeply it stands, its width
_LIMB_RADIUS = 0.08  # of a body length: along what is thinner hairs follow its axis
_WEIGHT_DOWN = 0.35  # of gravity beside the way from the nose
_FACE = 0.45  # body lengths from the nose, within which hairs are shorter
_SHORTEST = 0.15  # of their length, at the nose
_LEAST_RADII = 0.8  # of a part's radius: so long hairs on it are at most

LongArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Coat:
    """The fur of one body.

    Attributes:
        primitives: (n, 36) rows of all its parts.
        lengths: (n,) longest hair on each part, body lengths; 0 where it has no fur.
        lifts: (n,) slope of hairs against the skin at their roots.
        widths: (n,) hair width, body lengths.
        nose: (3,) where it all begins.
    """

    primitives: DoubleArray
    lengths: DoubleArray
    lifts: DoubleArray
    widths: DoubleArray
    nose: DoubleArray

    @classmethod
    def of(cls, body: Body) -> "Coat":
        """Reads a body's materials."""
        P = body.primitives
        M = body.materials[P[:, 3].astype(int)]
        lengths = np.where(M[:, 0] == FUR, np.minimum(M[:, LENGTH], _LEAST_RADII * _slimness(P)), 0.0)
        return cls(P, lengths, M[:, LIFT], M[:, WIDTH], np.asarray(body.nose, np.float64))

    @property
    def furry(self) -> BoolArray:
        """(n,) which parts wear it."""
        return self.lengths > 0

    def length_at(self, points: DoubleArray, part: LongArray) -> DoubleArray:
        """Returns hair lengths (n,) at object points (n, 3) of parts (n,)."""
        far = np.linalg.norm(points - self.nose, axis=1)
        return self.lengths[part] * np.clip(_SHORTEST + far / _FACE, 0.0, 1.0)

    def lie(self, points: DoubleArray, normals: DoubleArray) -> DoubleArray:
        """Returns unit directions (n, 3) in the skin that hairs lie along, of object points and normals."""
        way = points - self.nose
        way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
        way[:, 2] -= _WEIGHT_DOWN
        for row in self.primitives[self._limbs()]:
            close = np.flatnonzero(((points - row[30:33]) ** 2).sum(1) < (1.5 * row[33]) ** 2)
            axis, near = _along(row, points[close])
            way[close] += near[:, None] * (axis - way[close])
        tangent = way - (way * normals).sum(1, keepdims=True) * normals
        return np.asarray(tangent / np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-6))

    def _limbs(self) -> BoolArray:
        P = self.primitives
        radius = np.where(P[:, 0] == CONE, P[:, 17:19].max(1), P[:, 25:27].max(1))
        return np.asarray(self.furry & np.isin(P[:, 0], (CONE, BEZIER)) & (radius < _LIMB_RADIUS))


def _slimness(P: DoubleArray) -> DoubleArray:
    """Returns about the smallest radius of each part (n,)."""
    slim = 0.5 * P[:, 33]
    slim = np.where(P[:, 0] == ELLIPSOID, P[:, 16:19].min(1), slim)
    slim = np.where(P[:, 0] == CONE, P[:, 17:19].mean(1), slim)
    return np.where(P[:, 0] == BEZIER, P[:, 25:27].mean(1), slim)


def _along(row: DoubleArray, points: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Returns a limb's direction beside points (n, 3), and how much they are its own (n,): 1 on its skin."""
    t = np.linspace(0, 1, 17)[:, None]
    if row[0] == CONE:
        curve, radii = row[4:7] + t * row[16] * row[13:16], row[17] + t[:, 0] * (row[18] - row[17])
    else:
        a, b, c = row[16:19], row[19:22], row[22:25]
        curve = (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c
        radii = row[25] + t[:, 0] * (row[26] - row[25])
    axis = np.gradient(curve, axis=0)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    far = ((points[:, None] - curve) ** 2).sum(2)
    step = ((curve[1:] - curve[:-1]) ** 2).sum(1).mean()
    share = np.exp(-(far - far.min(1, keepdims=True)) / step)
    share /= share.sum(1, keepdims=True)
    away = np.sqrt(far.min(1)) / np.maximum(share @ radii, 1e-9)
    near = np.clip((1.7 - away) / 0.6, 0.0, 1.0)
    return share @ axis, near * near * (3 - 2 * near)
