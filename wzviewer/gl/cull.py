"""Which chunks of a level can contribute to a frame: pure functions over their boxes.

A chunk is skipped when all its footprints lie outside the image, or when Eq. 3 gives every point of
its box weight 0.  Both tests look at the eight corners only, and are exact bounds: D(u) is affine,
and a log ratio of two such depths is quasi-linear, so its extremes over a box are at corners; the
image of a box in front of a camera is the hull of its corners' images.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from wzviewer.core.anchor import DEPTH_FLOOR, AnchoredView
from wzviewer.core.constants import ALPHA_CUT, LOW_PASS_PX2
from wzviewer.core.opacity import Cover, Modulation
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray

EXTENT_SIGMAS = float(np.sqrt(2.0 * np.log(1.0 / ALPHA_CUT)))  # of the most opaque surfel
MARGIN_PX = 1.0  # rounding of float32 at the border


@dataclass(frozen=True, eq=False)
class ChunkBounds:
    """Boxes of the chunks of one level.

    Attributes:
        corners: (c, 8, 3) float64, of the boxes around the means, local.
        sigmas: (c,) largest standard deviation, local.
        coverage: (c,) largest stored coverage.
        coverage_min: (c,) smallest stored coverage.
    """

    corners: DoubleArray
    sigmas: FloatArray
    coverage: FloatArray
    coverage_min: FloatArray

    @classmethod
    def of_surfels(cls, surfels: Surfels, chunk_surfels: int) -> "ChunkBounds":
        """Measures consecutive chunks of a level."""
        starts = np.arange(0, len(surfels), chunk_surfels)
        low = np.minimum.reduceat(surfels.means, starts, axis=0).astype(np.float64)
        high = np.maximum.reduceat(surfels.means, starts, axis=0).astype(np.float64)
        sigmas = np.maximum.reduceat(surfels.scales.max(1), starts)
        most, least = (ufunc.reduceat(surfels.coverage, starts) for ufunc in (np.maximum, np.minimum))
        return cls(box_corners(low, high), sigmas, most, least)

    @classmethod
    def joined(cls, parts: "Sequence[ChunkBounds]") -> "ChunkBounds":
        """Joins bounds in order."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))

    def take(self, chunks: IntArray | BoolArray) -> "ChunkBounds":
        """Returns some chunks."""
        return ChunkBounds(*(getattr(self, f.name)[chunks] for f in fields(self)))

    def hull(self) -> "ChunkBounds":
        """Returns one chunk that holds all."""
        box = box_corners(self.corners.min((0, 1))[None], self.corners.max((0, 1))[None])
        return ChunkBounds(
            box, *(np.array([m]) for m in (self.sigmas.max(), self.coverage.max(), self.coverage_min.min()))
        )

    def __len__(self) -> int:
        return len(self.corners)


def box_corners(low: DoubleArray, high: DoubleArray) -> DoubleArray:
    """Corners (c, 8, 3) of boxes; the first is the lowest, the last the highest."""
    pick = np.array([[(k >> axis) & 1 for axis in range(3)] for k in range(8)], bool)
    return np.where(pick, high[:, None], low[:, None])


def every(test: BoolArray) -> BoolArray:
    """Whether a test holds at all corners, (c, 8) -> (c,)."""
    return np.asarray(test.all(axis=1))


def depths(view_row: DoubleArray, corners: DoubleArray) -> DoubleArray:
    """D(u) of corners (..., 3) for a ``(g, base)`` row."""
    return 1.0 + corners @ view_row[:3]


def chunk_radii_px(bounds: ChunkBounds, view: AnchoredView) -> DoubleArray:
    """Upper bound of the footprint radius in each chunk, px, (c,); inf where one reaches the camera."""
    side = view.side
    D: DoubleArray = side * depths(view.rows[2], bounds.corners)
    nearest = np.maximum(D.min(1), DEPTH_FLOOR)
    g = np.linalg.norm(view.rows[2, :3])
    stretch = np.zeros(len(bounds))
    for row in view.rows[:2]:  # |d p / d u| <= (|gx| + |q| |g|) / D
        q = np.abs(bounds.corners @ row[:3] / np.maximum(D, DEPTH_FLOOR)).max(1)
        stretch += ((np.linalg.norm(row[:3]) + q * g) / nearest) ** 2
    radius = EXTENT_SIGMAS * np.sqrt(bounds.sigmas.astype(np.float64) ** 2 * stretch + LOW_PASS_PX2)
    return np.where(D.min(1) > DEPTH_FLOOR, radius, np.inf)


def in_frustum(
    bounds: ChunkBounds, view: AnchoredView, size_px: tuple[int, int], margin_px: float = 0.0
) -> BoolArray:
    """Whether a chunk may touch the image widened by a margin, (c,)."""
    side = view.side
    D = depths(view.rows[2], bounds.corners)
    back: BoolArray = np.less_equal(side * D, DEPTH_FLOOR)
    behind, crossing = every(back), ~every(~back)
    radius = chunk_radii_px(bounds, view) + MARGIN_PX + margin_px
    outside: BoolArray = np.zeros(len(bounds), bool)
    for row, size in zip(view.rows[:2], size_px, strict=True):
        at = bounds.corners @ row[:3] / np.where(crossing[:, None], 1.0, D) + row[3]
        outside = outside | every(at < -radius[:, None]) | every(at > size + radius[:, None])
    return ~behind & (crossing | ~outside)


def view_slabs(
    bounds: ChunkBounds, view: AnchoredView, size_px: tuple[int, int], margin_px: float = 0.0
) -> ChunkBounds:
    """The part of space, at the depths of each box, where its surfels can touch the image.

    Deep in a zoom a chunk of an ancestor is far larger than the view, and only what is in view decides
    whether a child covers it.  A slab is the frustum, widened by the chunk's radius, between two depths:
    convex, so the tests at eight corners hold for it as for a box.  A box that reaches the camera stays.
    """
    radius = chunk_radii_px(bounds, view) + MARGIN_PX + margin_px
    whole = np.isfinite(radius)
    reach = np.where(whole, radius, 0.0)[:, None, None]
    D = depths(view.rows[2], bounds.corners)
    ends = np.stack([D.min(1), D.max(1)], 1)[:, :, None]  # (c, 2, 1)
    right, bottom = np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1])
    x_px = right * size_px[0] + (2 * right - 1) * reach - view.rows[0, 3]
    y_px = bottom * size_px[1] + (2 * bottom - 1) * reach - view.rows[1, 3]
    sides = np.stack([x_px * ends, y_px * ends, ends - 1.0 + 0.0 * x_px], -1)  # (c, 2, 4, 3)
    points = (sides @ np.linalg.inv(view.rows[:, :3]).T).reshape(len(bounds), 8, 3)
    return replace(bounds, corners=np.where(whole[:, None, None], points, bounds.corners))


def clipped(bounds: ChunkBounds, slabs: ChunkBounds) -> ChunkBounds:
    """Shrinks each box to the box around its part in the slab; one that has no such part stays."""
    low = np.maximum(bounds.corners.min(1), slabs.corners.min(1))
    high = np.minimum(bounds.corners.max(1), slabs.corners.max(1))
    meets = (low <= high).all(1)[:, None, None]
    return replace(bounds, corners=np.where(meets, box_corners(low, high), bounds.corners))


def log_ratio(upper: DoubleArray, lower: DoubleArray, corners: DoubleArray) -> DoubleArray:
    """log2 of the ratio of two pixel scales at corners, (c, 8); nan where one is undefined."""
    D_upper, D_lower = depths(upper, corners), depths(lower, corners)
    good = (D_upper > DEPTH_FLOOR) & (D_lower > DEPTH_FLOOR)
    ratio = np.where(good, D_upper, np.nan) / np.where(good, D_lower, np.nan)
    return upper[3] - lower[3] + np.log2(ratio)


def fades_in(bounds: ChunkBounds, view: AnchoredView, modulation: Modulation) -> BoolArray:
    """Whether t of the level itself may be above 0 in a chunk, (c,): False far above its own scale."""
    nothing: BoolArray = np.array(bounds.coverage <= 0.0)
    if view.depth > 0.0 and modulation.parent_rows is not None:
        nothing = nothing | every(log_ratio(view.rows[2], modulation.parent_rows, bounds.corners) >= 0.0)
    return ~nothing


def weightless(bounds: ChunkBounds, view: AnchoredView, modulation: Modulation) -> BoolArray:
    """Whether w = 0 is certain for a whole chunk, (c,)."""
    nothing: BoolArray = ~fades_in(bounds, view, modulation)
    if view.depth > 0.0:
        for cover in modulation.covers:
            nothing = nothing | _covered(bounds, view, cover)
    return nothing


def unmodulated(
    bounds: ChunkBounds, view: AnchoredView, modulation: Modulation, native_row: DoubleArray
) -> BoolArray:
    """Whether w = 1 is certain for a whole chunk, (c,): faded in, wholly inside, nothing over it.

    Args:
        bounds: of the chunks.
        view: the rendering camera about the level's anchor.
        modulation: of the level; covers that do nothing here may have been left out.
        native_row: (4,) ``(g, base)`` of the level's own camera.
    """
    whole: BoolArray = np.array(bounds.coverage_min >= 1.0) & (view.depth > 0.0)
    if modulation.parent_rows is not None:
        whole = whole & every(log_ratio(view.rows[2], native_row, bounds.corners) <= 0.0)
    return whole & np.all([~may_cover(bounds, view, cover) for cover in modulation.covers], axis=0)


def may_cover(bounds: ChunkBounds, view: AnchoredView, cover: Cover) -> BoolArray:
    """Whether m t of a cover may be above 0 somewhere in a chunk, (c,)."""
    if view.depth <= 0.0:
        return np.ones(len(bounds), bool)
    idle = every(log_ratio(view.rows[2], cover.parent_rows, bounds.corners) >= 0.0)
    side = cover.view.side
    D = side * depths(cover.view.rows[2], bounds.corners)
    behind, before = every(D <= DEPTH_FLOOR), every(D > DEPTH_FLOOR)
    outside: BoolArray = np.zeros(len(bounds), bool)
    for row, size in zip(cover.view.rows[:2], cover.size_px[:2], strict=True):
        at = bounds.corners @ row[:3] / np.where(before[:, None], side * D, 1.0) + row[3]
        outside = outside | every(at <= 0.0) | every(at >= size)
    return ~(idle | behind | (before & outside))


def _covered(bounds: ChunkBounds, view: AnchoredView, cover: Cover) -> BoolArray:
    """Whether m = 1 and t = 1 of a cover hold in a whole chunk."""
    if cover.view.depth <= 0.0:
        return np.zeros(len(bounds), bool)
    finer = every(log_ratio(view.rows[2], cover.view.rows[2], bounds.corners) <= 0.0)
    D = depths(cover.view.rows[2], bounds.corners)
    inside = every(D > DEPTH_FLOOR)
    width, height, feather = cover.size_px
    for row, size in zip(cover.view.rows[:2], (width, height), strict=True):
        at = bounds.corners @ row[:3] / np.where(D > DEPTH_FLOOR, D, np.inf) + row[3]
        inside = inside & every((at >= feather) & (at <= size - feather))
    return finer & inside
