"""Where hairs are rooted: one in each cell of object space that a coat's surface passes through."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import strands
from wzviewer.worker.models.builtin.objects.coats import Coat
from wzviewer.worker.models.builtin.objects.pose import Pose

LongArray = NDArray[np.int64]

_COVER = 6.0  # hairs that lie over each other
_WIDE_PX = (1.1, 2.3)  # a hair, where the coat is far away and in a close-up
_LONG_PX = 600.0  # no longer than this and `_SLENDER` widths
_SLENDER = 12.0
_WIDEST_PX = 100.0  # a hair so wide is a surface of its own
_LEAST_PX = 4.0  # hairs shorter than this are not drawn


@dataclass(frozen=True, eq=False)
class Skin:
    """Points of a marched coat.

    Attributes:
        points: (n, 3) in object space.
        normals: (n, 3) in object space.
        part: (n,) primitives.
        color: (n, 3) float32 linear radiance, not premultiplied.
        foot_px: side of what a point stands for.
    """

    points: DoubleArray
    normals: DoubleArray
    part: LongArray
    color: FloatArray
    foot_px: float


@dataclass(frozen=True, eq=False)
class Roots:
    """Where hairs are rooted.

    Attributes:
        points: (n, 3) in object space.
        normals: (n, 3) in object space.
        part: (n,) primitives.
        color: (n, 3) float32 linear radiance of the skin there.
        length: (n,) body lengths.
        chance: (n, 5) numbers in [0, 1), each hair's own.
    """

    points: DoubleArray
    normals: DoubleArray
    part: LongArray
    color: FloatArray
    length: DoubleArray
    chance: DoubleArray


def width_px(coat: Coat, px: float) -> float:
    """Returns how wide the hairs are that a level shows; px is a pixel in body lengths."""
    long_px = float(coat.lengths.max()) / px
    shown = float(np.clip(0.7 + 0.012 * long_px, *_WIDE_PX))
    return max(shown, float(coat.widths[coat.furry].max()) / px)


def is_shown(coat: Coat, px: float) -> bool:
    """Tells whether hairs are drawn: not where there are none, nor where they would be dots or walls."""
    if not coat.furry.any():
        return False
    return float(coat.lengths.max()) > _LEAST_PX * px and width_px(coat, px) < _WIDEST_PX


def margin_px(coat: Coat, px: float) -> float:
    """Returns how far from its root a hair is drawn, px."""
    return min(reach_px(coat, px), 0.6 * _LONG_PX)


def reach_px(coat: Coat, px: float) -> float:
    """Returns the longest hair, px."""
    return min(float(coat.lengths.max()) / px, max(_LONG_PX, _SLENDER * width_px(coat, px)))


def rooted(coat: Coat, pose: Pose, skins: list[Skin], seed: int) -> Roots:
    """Sows a coat: the same root at the same place, whatever the view."""
    px = 1.0 / pose.size_px
    wide, reach = width_px(coat, px), reach_px(coat, px)
    parts = [_sown(coat, pose, skin, wide, reach, seed) for skin in skins]
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    cells, points, normals, part, color, length, away = columns
    if not len(points):
        return Roots(points, normals, part, color, length, np.zeros((0, 5)))
    low = cells.min(0)
    span = cells.max(0) - low + 1
    key = ((cells[:, 0] - low[0]) * span[1] + cells[:, 1] - low[1]) * span[2] + cells[:, 2] - low[2]
    order = np.lexsort((away, key))
    first = order[np.concatenate([[True], np.diff(key[order]) != 0])]
    chance = np.stack([_numbers(cells[first], seed + k) for k in range(5)], 1)
    # Short hairs need more of them; the lattice is as fine as those do.
    kept = _numbers(cells[first], seed + 9) < np.minimum(
        1.0, _shortest(coat, px, reach) * px / np.minimum(length[first], reach * px)
    )
    chosen = first[kept]
    return Roots(points[chosen], normals[chosen], part[chosen], color[chosen], length[chosen], chance[kept])


def _shortest(coat: Coat, px: float, reach: float) -> float:
    """Returns the length, px, that the lattice is made for."""
    return max(0.25 * reach, _LEAST_PX)


def _sown(coat: Coat, pose: Pose, skin: Skin, wide: float, reach: float, seed: int) -> tuple[np.ndarray, ...]:
    px = 1.0 / pose.size_px
    spacing = np.sqrt(0.6 * wide * _shortest(coat, px, reach) / _COVER) * px
    lam = float(2.0 ** (np.floor(2 * np.log2(spacing)) / 2))  # the same for views that hardly differ
    n = len(skin.points)
    cells, roots, away = np.zeros((n, 3), np.int64), np.zeros((n, 3)), np.zeros(n)
    flat = pose.camera_from_object[:2] - np.outer(pose.ray, pose.camera_from_object[2])
    strands.sow(skin.points, skin.normals, lam, seed, flat * pose.size_px, skin.foot_px, cells, roots, away)
    there = np.isfinite(away)
    part, points = skin.part[there], roots[there]
    length = coat.length_at(points, part)
    return cells[there], points, skin.normals[there], part, skin.color[there], length, away[there]


def _numbers(cells: LongArray, salt: int) -> DoubleArray:
    """Returns a pseudo-random number in [0, 1) of each cell (n, 3)."""
    h = (cells * np.array([73856093, 19349663, 83492791])).sum(1) ^ (salt * 668265263)
    for factor in (1274126177, 2246822519):
        h = ((h ^ (h >> 15)) * factor) & 0xFFFFFFFF
    return np.asarray((h ^ (h >> 16)) / 4294967296.0, np.float64)
