"""The CPU side of a frame: which surfels are drawn, in which order.  No OpenGL here.

`Prepared` depends on the scene and the camera alone, so it is kept while both stay, and may be made
on another thread than the one that draws.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Modulation
from wzviewer.core.reference import Focus, focus_of
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray, IntArray
from wzviewer.gl.cull import (
    ChunkBounds,
    chunk_radii_px,
    clipped,
    in_frustum,
    unmodulated,
    view_slabs,
    weightless,
)
from wzviewer.gl.order import Run, UIntArray, order_runs


@dataclass(frozen=True, eq=False)
class LevelState:
    """A level that is complete on the GPU.

    Attributes:
        level: its description.
        surfels: the version that is on the GPU.
        bounds: of its chunks.
        columns: (3, n) float32, the means as columns (for the keys).
        first_records: (chunks,) record number of each chunk.
        modulation: its parent and covers among the levels that are drawn.
        chunk_surfels: surfels per chunk.
    """

    level: Level
    surfels: Surfels
    bounds: ChunkBounds
    columns: FloatArray
    first_records: IntArray
    modulation: Modulation
    chunk_surfels: int

    @classmethod
    def measure(
        cls, level: Level, surfels: Surfels, records: IntArray, modulation: Modulation, chunk_surfels: int
    ) -> "LevelState":
        """Measures the chunks of a level's surfels."""
        bounds = ChunkBounds.of_surfels(surfels, chunk_surfels)
        columns = np.ascontiguousarray(surfels.means.T)
        return cls(level, surfels, bounds, columns, records, modulation, chunk_surfels)

    def moved(self, level: Level, records: IntArray, modulation: Modulation) -> "LevelState":
        """Returns the same surfels with new records and covers."""
        return replace(self, level=level, first_records=records, modulation=modulation)

    def run(self, first_chunk: int, last_chunk: int, view: AnchoredView, stride: int = 1) -> Run:
        """Returns chunks first..last (inclusive, consecutive records) as one run."""
        start = first_chunk * self.chunk_surfels
        stop = min((last_chunk + 1) * self.chunk_surfels, len(self.surfels))
        skipped = -start % stride  # which surfels are drawn must not depend on what was culled
        record = int(self.first_records[first_chunk]) + skipped
        columns = self.columns[:, start + skipped : stop : stride]
        return Run(columns, view, self.level.frame, record, self.level.index, start + skipped, stride)

    def runs(self, chunks: IntArray, view: AnchoredView, stride: int = 1) -> list[Run]:
        """Joins chunks, ascending, into runs of consecutive records."""
        if not len(chunks):
            return []
        records = self.first_records[chunks]
        breaks = np.flatnonzero((np.diff(chunks) != 1) | (np.diff(records) != self.chunk_surfels)) + 1
        return [self.run(int(part[0]), int(part[-1]), view, stride) for part in np.split(chunks, breaks)]


@dataclass(frozen=True, eq=False)
class Prepared:
    """What to draw for a camera.

    Attributes:
        views: the camera about each level's anchor, by level index.
        runs: surviving surfels, in scene order.
        order: (n,) record numbers, nearest first.
        radius_px: bound of the footprint radii.
        is_unit_weight: whether w = 1 is certain for all of them.
        num_chunks: chunks that survived.
        num_surfels: surfels before culling.
        cull_ms: time of the culling.
        sort_ms: time of keys and sort.
    """

    views: Mapping[int, AnchoredView]
    runs: list[Run]
    order: UIntArray
    radius_px: float
    is_unit_weight: bool
    num_chunks: int
    num_surfels: int
    cull_ms: float
    sort_ms: float


@dataclass(frozen=True, eq=False)
class SeenChunks:
    """Chunks of a level that may contribute to a view.

    Attributes:
        chunks: (k,) int32, ascending.
        radius_px: bound of the footprint radii.
        is_unit_weight: whether w = 1 is certain for all of them.
    """

    chunks: IntArray
    radius_px: float
    is_unit_weight: bool

    @classmethod
    def of_level(
        cls, state: LevelState, view: AnchoredView, size_px: tuple[int, int], modulated: bool, growth: float
    ) -> "SeenChunks":
        """Culls by frustum and by weight."""
        bounds = replace(state.bounds, sigmas=state.bounds.sigmas * np.float32(growth))
        keep = in_frustum(bounds, view, size_px)
        slabs = view_slabs(bounds, view, size_px)
        part = clipped(bounds, slabs)
        if modulated:
            for region in (part, slabs):
                keep = keep & ~weightless(region, view, state.modulation)
        radii = chunk_radii_px(part, view)[keep]
        sure = not modulated or bool(unmodulated(part, view, state.modulation)[keep].all())
        return cls(np.flatnonzero(keep).astype(np.int32), float(radii.max(initial=0.0)), sure)

    @classmethod
    def all_of(cls, state: LevelState, view: AnchoredView, modulated: bool) -> "SeenChunks":
        """Culls nothing."""
        radii = chunk_radii_px(state.bounds, view)
        return cls(np.arange(len(radii), dtype=np.int32), float(radii.max(initial=0.0)), not modulated)


def growth_of(stride: int) -> float:
    """How much larger footprints have to be where one in `stride` is drawn."""
    return float(np.sqrt(stride))


def prepare(
    states: Mapping[int, LevelState],
    camera: Camera,
    modulated: bool = True,
    culling: bool = True,
    stride: int = 1,
) -> Prepared:
    """Culls and orders.

    Args:
        states: of the levels that are drawn, by level index, ascending.
        camera: the rendering camera.
        modulated: whether Eq. 3 applies.
        culling: False keeps every chunk.
        stride: keeps one surfel in so many, grown by its square root.
    """
    began = time.perf_counter()
    views = {i: AnchoredView.expand(camera, state.level.frame) for i, state in states.items()}
    size_px = (camera.width, camera.height)
    seen = {
        i: SeenChunks.of_level(state, views[i], size_px, modulated, growth_of(stride))
        if culling
        else SeenChunks.all_of(state, views[i], modulated)
        for i, state in states.items()
    }
    runs = [run for i, state in states.items() for run in state.runs(seen[i].chunks, views[i], stride)]
    culled = time.perf_counter()
    order = order_runs(runs, _focus(states, camera))
    sorted_at = time.perf_counter()
    return Prepared(
        views=views,
        runs=runs,
        order=order,
        radius_px=max((level.radius_px for level in seen.values()), default=0.0),
        is_unit_weight=all(level.is_unit_weight for level in seen.values()),
        num_chunks=sum(len(level.chunks) for level in seen.values()),
        num_surfels=sum(len(state.surfels) for state in states.values()),
        cull_ms=1e3 * (culled - began),
        sort_ms=1e3 * (sorted_at - culled),
    )


def _focus(states: Mapping[int, LevelState], camera: Camera) -> Focus:
    return focus_of(camera, [state.level.frame for state in states.values()])
