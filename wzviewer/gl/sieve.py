"""Which chunks of all levels a view needs, in a few array operations over all of them.

::

    LevelTable ── hulls in the frustum? ──► Region.of: chunks in the frustum ──► modulate: chunks of some
    (once a scene)                                                               weight, and their covers
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.reference import Focus, focus_of
from wzviewer.core.types import BoolArray, DoubleArray, IntArray
from wzviewer.gl.cull import (
    ChunkBounds,
    box_corners,
    chunk_radii_px,
    clipped,
    in_frustum,
    may_cover,
    unmodulated,
    view_slabs,
    weightless,
)
from wzviewer.gl.stacks import Acting, Covers, Frames, Index, Views

if TYPE_CHECKING:
    from wzviewer.gl.visible import LevelState, SurfelSet


@dataclass(frozen=True, eq=False)
class LevelTable:
    """Levels (n) in arrays.

    Attributes:
        states: of the levels.
        frames: of the levels.
        hulls: a box around each.
        parent_rows: (n, 4); nan at the root.
        native_rows: (n, 4).
        covers: of all levels (m), level by level.
        covered: (m,) level of each cover.
        ranks: (m,) place of each cover among those of its level.
    """

    states: Sequence["LevelState"]
    frames: Frames
    hulls: ChunkBounds
    parent_rows: DoubleArray
    native_rows: DoubleArray
    covers: Covers
    covered: IntArray
    ranks: IntArray

    @classmethod
    def of(cls, states: Sequence["LevelState"]) -> "LevelTable":
        """Stacks levels, one at least."""
        covers = [state.modulation.covers for state in states]
        counts = [len(each) for each in covers]
        parents = [state.modulation.parent_rows for state in states]
        return cls(
            states,
            Frames.stack([state.level.frame for state in states]),
            ChunkBounds.joined([state.sets[0].hull for state in states]),
            np.array([np.full(4, np.nan) if row is None else row for row in parents]),
            np.array([state.native_row for state in states]),
            Covers.stack([cover for each in covers for cover in each]),
            np.repeat(np.arange(len(states), dtype=np.int32), counts),
            np.concatenate([np.arange(n, dtype=np.int32) for n in counts]),
        )

    def focus(self, camera: Camera, depths: DoubleArray) -> Focus:
        """`core.reference.focus_of`, from the depths of the anchors (n,)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            octaves = np.log2(depths / camera.focal_px / self.frames.units)
        off = np.where(depths > 0.0, np.abs(octaves).round(6), np.inf)
        nearest = self.states[int(np.argmin(off))].level.frame
        return focus_of(camera, [nearest])


@dataclass(frozen=True, eq=False)
class Region:
    """Chunks (c) of several levels that may touch the image, level by level.

    Attributes:
        owners: (c,) place of the level in the table.
        chunks: (c,) chunk of its set.
        views: the camera about each chunk's anchor.
        parts: the box around what each chunk has in view.
        slabs: see `cull.view_slabs`.
        radii_px: (c,) bound of the footprint radii.
    """

    owners: IntArray
    chunks: IntArray
    views: Views
    parts: ChunkBounds
    slabs: ChunkBounds
    radii_px: DoubleArray

    @classmethod
    def of(
        cls, sets: Mapping[int, "SurfelSet"], views: Views, size_px: tuple[int, int], margin_px: float
    ) -> "Region":
        """Finds them in sets, by place in the table; one set at least.

        Args:
            sets: what to look at.
            views: of all levels of the table.
            size_px: (width, height) of the image.
            margin_px: width of a border around it that counts as in view.
        """
        counts = [len(each.bounds) for each in sets.values()]
        owners = np.repeat(np.array(list(sets), np.int32), counts)
        chunks = np.concatenate([np.arange(n, dtype=np.int32) for n in counts])
        bounds = ChunkBounds.joined([each.bounds for each in sets.values()])
        near = in_frustum(bounds, views.take(owners), size_px, margin_px)
        owners, bounds = owners[near], bounds.take(near)
        seen_by = views.take(owners)
        slabs = view_slabs(bounds, seen_by, size_px, margin_px)
        parts = clipped(bounds, slabs)
        return cls(owners, chunks[near], seen_by, parts, slabs, chunk_radii_px(parts, seen_by))

    def take(self, kept: BoolArray) -> "Region":
        """Returns some of the chunks."""
        parts = (self.views.take(kept), self.parts.take(kept), self.slabs.take(kept))
        return Region(self.owners[kept], self.chunks[kept], *parts, self.radii_px[kept])


def modulate(table: LevelTable, region: Region) -> tuple[Region, BoolArray, IntArray]:
    """Drops chunks to which Eq. 3 gives no weight.

    Returns:
        The other chunks (c), whether w = 1 is certain for them (c,), and the covers that act on one of
        them (k,), as places in the table.
    """
    parents, pairs = table.parent_rows[region.owners], _pairs(table, region)
    acting = Acting(parents, pairs[:, 0], table.covers.take(pairs[:, 1]))
    kept = ~weightless(region.parts, region.views, acting) & ~weightless(region.slabs, region.views, acting)
    plain = unmodulated(region.parts, region.views, acting, table.native_rows[region.owners])
    return region.take(kept), plain[kept], np.unique(pairs[kept[pairs[:, 0]], 1])


def _pairs(table: LevelTable, region: Region) -> IntArray:
    """(chunk, cover), (p, 2), where the cover may take something from the chunk."""
    levels, starts, counts = np.unique(region.owners, return_index=True, return_counts=True)
    covers = np.flatnonzero(np.isin(table.covered, levels))
    if not len(covers):
        return np.empty((0, 2), np.int32)
    near = np.searchsorted(levels, table.covered[covers])
    some = may_cover(
        _hulls(region, starts).take(near), region.views.take(starts[near]), table.covers.take(covers)
    )
    covers, near = covers[some], near[some]
    sizes = counts[near]  # each cover meets all chunks of its level
    chunks = np.arange(sizes.sum()) + np.repeat(starts[near] - np.cumsum(sizes) + sizes, sizes)
    covers = np.repeat(covers, sizes)
    acts = may_cover(region.parts.take(chunks), region.views.take(chunks), table.covers.take(covers))
    return np.stack([chunks[acts], covers[acts]], 1).astype(np.int32)


def _hulls(region: Region, starts: Index) -> ChunkBounds:
    """A box around what each level has in view; a level's first chunk stands for the rest of it."""
    corners = region.parts.corners
    low, high = (
        f.reduceat(g, starts) for f, g in ((np.minimum, corners.min(1)), (np.maximum, corners.max(1)))
    )
    return replace(region.parts.take(starts), corners=box_corners(low, high))
