"""Which chunks of a level can contribute to a frame: pure functions over their boxes.

A chunk is skipped when all its footprints lie outside the image, or when Eq. 3 gives every point of
its box weight 0.  Both tests look at the eight corners only, and are exact bounds: D(u) is affine,
and a log ratio of two such depths is quasi-linear, so its extremes over a box are at corners; the
image of a box in front of a camera is the hull of its corners' images.

The chunks may be of one level, with its view and its covers, or of many levels, each with its own
(`stacks`): a tree of a hundred levels then costs a few array operations, not a
hundred times as many.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import DEPTH_FLOOR, AnchoredView
from wzviewer.core.constants import ALPHA_CUT, LOW_PASS_PX2
from wzviewer.core.opacity import LOG_SPAN_MIN, Cover, Modulation
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray
from wzviewer.gl.stacks import Acting, Covers, Index, Views

IndexArray = NDArray[np.int64]

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
        spreads: (c,) largest standard deviation over D in the level's own view; inf where unknown.
        own_g: (c, 3) gradient of that D.
    """

    corners: DoubleArray
    sigmas: FloatArray
    coverage: FloatArray
    coverage_min: FloatArray
    spreads: DoubleArray
    own_g: DoubleArray

    @classmethod
    def of_surfels(
        cls, surfels: Surfels, chunk_surfels: int, maker: AnchoredView | None = None
    ) -> "ChunkBounds":
        """Measures consecutive chunks of a level.

        Args:
            surfels: of the level.
            chunk_surfels: per chunk.
            maker: the level's own camera, in whose image its surfels are near to each other.
        """
        starts = np.arange(0, len(surfels), chunk_surfels)
        corners = around(surfels.means, starts, maker)
        sigmas = np.maximum(surfels.scales[:, 0], surfels.scales[:, 1])  # a tenth of the time of max(1)
        most, least = (ufunc.reduceat(surfels.coverage, starts) for ufunc in (np.maximum, np.minimum))
        spreads, own_g = np.full(len(starts), np.inf), np.zeros((len(starts), 3))
        if maker is not None:
            own_g[:] = maker.rows[2, :3]
            D = 1.0 + surfels.means @ maker.rows[2, :3]
            spreads = np.maximum.reduceat(np.where(D > DEPTH_FLOOR, sigmas / D, np.inf), starts)
        return cls(corners, np.maximum.reduceat(sigmas, starts), most, least, spreads, own_g)

    @classmethod
    def joined(cls, parts: "Sequence[ChunkBounds]") -> "ChunkBounds":
        """Joins bounds in order."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))

    def take(self, chunks: Index) -> "ChunkBounds":
        """Returns some chunks."""
        return ChunkBounds(*(getattr(self, f.name)[chunks] for f in fields(self)))

    def hull(self, maker: AnchoredView | None = None) -> "ChunkBounds":
        """Returns one chunk that holds all."""
        box = around(self.corners.reshape(-1, 3), np.zeros(1, np.int64), maker)
        return ChunkBounds(
            box,
            self.sigmas.max(keepdims=True),
            self.coverage.max(keepdims=True),
            self.coverage_min.min(keepdims=True),
            self.spreads.max(keepdims=True),
            self.own_g[:1],
        )

    def __len__(self) -> int:
        return len(self.corners)


def box_corners(low: DoubleArray, high: DoubleArray) -> DoubleArray:
    """Corners (c, 8, 3) of boxes; the first is the lowest, the last the highest."""
    pick = np.array([[(k >> axis) & 1 for axis in range(3)] for k in range(8)], bool)
    return np.where(pick, high[:, None], low[:, None])


def around(points: FloatArray | DoubleArray, starts: IndexArray, maker: AnchoredView | None) -> DoubleArray:
    """Corners (c, 8, 3) of convex bodies around runs of points (n, 3) that begin at ``starts`` (c,).

    The body of a run is the part of its maker's view between two depths that frames its points: what
    lies on the same pixels at many depths, as a background does, fits a wedge where a box would be as
    wide as the whole image.  Where a point is not in front of the maker, or without one, it is a box.
    """
    columns = points.T.astype(np.float64)
    if maker is None:
        return _boxes(columns, starts)
    x, y, z = maker.rows[:, :3] @ columns
    D = 1.0 + z
    seen = np.minimum.reduceat(D, starts) > DEPTH_FLOOR
    per_D = 1.0 / np.where(D > DEPTH_FLOOR, D, 1.0)
    wedges = _boxes(np.stack([x * per_D, y * per_D, D]), starts)
    D = wedges[..., 2:]
    sides = np.concatenate([wedges[..., :2] * D, D - 1.0], -1)
    corners = sides @ np.linalg.inv(maker.rows[:, :3]).T
    return corners if seen.all() else np.where(seen[:, None, None], corners, _boxes(columns, starts))


def _boxes(columns: DoubleArray, starts: IndexArray) -> DoubleArray:
    """Corners (c, 8, 3) of boxes around runs of points, given as columns (3, n)."""
    low, high = (ufunc.reduceat(columns, starts, axis=1).T for ufunc in (np.minimum, np.maximum))
    return box_corners(low, high)


def every(test: BoolArray) -> BoolArray:
    """Whether a test holds at all corners, (c, 8) -> (c,)."""
    return np.asarray(test.all(axis=1))


def along(row: DoubleArray, corners: DoubleArray) -> DoubleArray:
    """``g . u`` at corners (c, 8, 3), (c, 8), for one row (4,) of a view, or one for each box (c, 4)."""
    x, y, z = (corners[..., axis] * row[..., axis, None] for axis in range(3))
    return np.asarray(x + y + z)


def depths(view_row: DoubleArray, corners: DoubleArray) -> DoubleArray:
    """D(u) of corners (c, 8, 3), (c, 8), for ``(g, base)`` rows (4,) or (c, 4)."""
    return 1.0 + along(view_row, corners)


def column(value: float | DoubleArray) -> DoubleArray:
    """One number, or one for each box, beside its corners: (1,) or (c, 1)."""
    return np.asarray(value)[..., None]


def _at(view: AnchoredView | Views, chunks: IntArray) -> AnchoredView | Views:
    return view.take(chunks) if isinstance(view, Views) else view


def chunk_radii_px(bounds: ChunkBounds, view: AnchoredView | Views) -> DoubleArray:
    """Upper bound of the footprint radius in each chunk, px, (c,); inf where one reaches the camera."""
    D = column(view.side) * depths(view.rows[..., 2, :], bounds.corners)
    nearest = np.maximum(D.min(1), DEPTH_FLOOR)
    own_D = 1.0 + along(bounds.own_g, bounds.corners)
    # sigma / D: of the largest and the nearest, or, as distance grows with depth in any view, by spreads
    known = np.isfinite(bounds.spreads) & (own_D > DEPTH_FLOOR).all(1)
    tallest = np.where(known, bounds.spreads, 1.0) * (own_D / np.maximum(D, DEPTH_FLOOR)).max(1)
    tallest = np.where(known, tallest, np.inf)
    tallest = np.minimum(tallest, bounds.sigmas / nearest)
    g = np.linalg.norm(view.rows[..., 2, :3], axis=-1)
    stretch = np.zeros(len(bounds))
    for axis in range(2):  # |d p / d u| <= (|gx| + |q| |g|) / D
        row = view.rows[..., axis, :]
        q = np.abs(along(row, bounds.corners) / np.maximum(D, DEPTH_FLOOR)).max(1)
        stretch += (np.linalg.norm(row[..., :3], axis=-1) + q * g) ** 2
    radius = EXTENT_SIGMAS * np.sqrt(tallest**2 * stretch + LOW_PASS_PX2)
    return np.where(D.min(1) > DEPTH_FLOOR, radius, np.inf)


def in_frustum(
    bounds: ChunkBounds, view: AnchoredView | Views, size_px: tuple[int, int], margin_px: float = 0.0
) -> BoolArray:
    """Whether a chunk may touch the image widened by a margin, (c,)."""
    D = depths(view.rows[..., 2, :], bounds.corners)
    back: BoolArray = np.less_equal(column(view.side) * D, DEPTH_FLOOR)
    behind, crossing = every(back), ~every(~back)
    radius = chunk_radii_px(bounds, view) + MARGIN_PX + margin_px
    outside: BoolArray = np.zeros(len(bounds), bool)
    for axis, size in enumerate(size_px):
        row = view.rows[..., axis, :]
        at = along(row, bounds.corners) / np.where(crossing[:, None], 1.0, D) + row[..., 3, None]
        outside = outside | every(at < -radius[:, None]) | every(at > size + radius[:, None])
    return ~behind & (crossing | ~outside)


def view_slabs(
    bounds: ChunkBounds, view: AnchoredView | Views, size_px: tuple[int, int], margin_px: float = 0.0
) -> ChunkBounds:
    """The part of space, at the depths of each box, where its surfels can touch the image.

    Deep in a zoom a chunk of an ancestor is far larger than the view, and only what is in view decides
    whether a child covers it.  A slab is the frustum, widened by the chunk's radius, between two depths:
    convex, so the tests at eight corners hold for it as for a box.  A box that reaches the camera stays.
    """
    radius = chunk_radii_px(bounds, view) + MARGIN_PX + margin_px
    whole = np.isfinite(radius)
    reach = np.where(whole, radius, 0.0)[:, None, None]
    D = depths(view.rows[..., 2, :], bounds.corners)
    ends = np.stack([D.min(1), D.max(1)], 1)[:, :, None]  # (c, 2, 1)
    right, bottom = np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1])
    x_px = right * size_px[0] + (2 * right - 1) * reach - column(column(view.rows[..., 0, 3]))
    y_px = bottom * size_px[1] + (2 * bottom - 1) * reach - column(column(view.rows[..., 1, 3]))
    sides = np.stack([x_px * ends, y_px * ends, ends - 1.0 + 0.0 * x_px], -1)  # (c, 2, 4, 3)
    inverse = np.swapaxes(np.linalg.inv(view.rows[..., :3]), -1, -2)
    points = sides.reshape(len(bounds), 8, 3) @ inverse
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
    return np.asarray(upper[..., 3, None] - lower[..., 3, None] + np.log2(ratio))


def fades_in(bounds: ChunkBounds, view: AnchoredView | Views, parent_rows: DoubleArray | None) -> BoolArray:
    """Whether t of the level itself may be above 0 in a chunk, (c,): False far above its own scale."""
    nothing: BoolArray = np.array(bounds.coverage <= 0.0)
    if parent_rows is not None:
        above = every(log_ratio(view.rows[..., 2, :], parent_rows, bounds.corners) >= 0.0)
        nothing = nothing | (above & np.greater(view.depth, 0.0))
    return ~nothing


def weightless(bounds: ChunkBounds, view: AnchoredView | Views, modulation: Modulation | Acting) -> BoolArray:
    """Whether w = 0 is certain for a whole chunk, (c,)."""
    nothing = ~fades_in(bounds, view, modulation.parent_rows)
    pairs = Acting.of(modulation, len(bounds))
    hidden = _covered(bounds.take(pairs.chunks), _at(view, pairs.chunks), pairs.covers)
    nothing[pairs.chunks[hidden]] = True
    return nothing


def unmodulated(
    bounds: ChunkBounds,
    view: AnchoredView | Views,
    modulation: Modulation | Acting,
    native_rows: DoubleArray,
) -> BoolArray:
    """Whether w = 1 is certain for a whole chunk, (c,): faded in, wholly inside, nothing over it.

    Args:
        bounds: of the chunks.
        view: the rendering camera about the level's anchor, or one for each chunk.
        modulation: of the level, or of each chunk; covers that do nothing here may have been left out.
        native_rows: (4,) or (c, 4) ``(g, base)`` of the level's own camera.
    """
    whole: BoolArray = np.array(bounds.coverage_min >= 1.0) & np.greater(view.depth, 0.0)
    if modulation.parent_rows is not None:
        is_root = np.isnan(modulation.parent_rows[..., 0])
        whole = whole & (is_root | _ramp_ends(bounds, view, modulation.parent_rows, native_rows))
    pairs = Acting.of(modulation, len(bounds))
    acts = may_cover(bounds.take(pairs.chunks), _at(view, pairs.chunks), pairs.covers)
    whole[pairs.chunks[acts]] = False
    return whole


def may_cover(bounds: ChunkBounds, view: AnchoredView | Views, cover: Cover | Covers) -> BoolArray:
    """Whether m t of a cover, or of one for each chunk, may be above 0 somewhere in a chunk, (c,)."""
    idle = every(log_ratio(view.rows[..., 2, :], cover.parent_rows, bounds.corners) >= 0.0)
    rows, sizes = cover.view.rows, np.asarray(cover.size_px)
    signed = depths(rows[..., 2, :], bounds.corners)
    D = column(cover.view.side) * signed
    behind, before = every(D <= DEPTH_FLOOR), every(D > DEPTH_FLOOR)
    outside: BoolArray = np.zeros(len(bounds), bool)
    for axis in range(2):
        row = rows[..., axis, :]
        at = along(row, bounds.corners) / np.where(before[:, None], signed, 1.0) + row[..., 3, None]
        outside = outside | every(at <= 0.0) | every(at >= sizes[..., axis, None])
    return ~(idle | behind | (before & outside)) | np.less_equal(view.depth, 0.0)


def _ramp_ends(
    bounds: ChunkBounds, view: AnchoredView | Views, top: DoubleArray, low: DoubleArray
) -> BoolArray:
    """Whether t = 1 is certain for a ramp from the scale of one row to that of another."""
    here = view.rows[..., 2, :]
    finer = every(log_ratio(here, low, bounds.corners) <= 0.0)
    # An extension at its parent's own scale has a ramp of its own length, and t = 1 later.
    return finer & every(log_ratio(here, top, bounds.corners) <= -LOG_SPAN_MIN)


def _covered(bounds: ChunkBounds, view: AnchoredView | Views, cover: Cover | Covers) -> BoolArray:
    """Whether m = 1 and t = 1 of a cover hold in a whole chunk."""
    rows, sizes = cover.view.rows, np.asarray(cover.size_px)
    D = depths(rows[..., 2, :], bounds.corners)
    inside = every(D > DEPTH_FLOOR) & np.greater(cover.view.depth, 0.0) & np.greater(view.depth, 0.0)
    feather = sizes[..., 2, None]
    for axis in range(2):
        row = rows[..., axis, :]
        at = along(row, bounds.corners) / np.where(D > DEPTH_FLOOR, D, np.inf) + row[..., 3, None]
        inside = inside & every((at >= feather) & (at <= sizes[..., axis, None] - feather))
    return inside & _ramp_ends(bounds, view, cover.parent_rows, rows[..., 2, :])
