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
from wzviewer.gl.cull import ChunkBounds, chunk_radii_px, in_frustum, unmodulated, weightless
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

    def run(self, first_chunk: int, last_chunk: int, view: AnchoredView) -> Run:
        """Returns chunks first..last (inclusive, consecutive records) as one run."""
        start = first_chunk * self.chunk_surfels
        stop = min((last_chunk + 1) * self.chunk_surfels, len(self.surfels))
        record = int(self.first_records[first_chunk])
        columns = self.columns[:, start:stop]
        return Run(columns, view, self.level.frame, record, self.level.index, start)

    def runs(self, chunks: IntArray, view: AnchoredView) -> list[Run]:
        """Joins chunks, ascending, into runs of consecutive records."""
        if not len(chunks):
            return []
        records = self.first_records[chunks]
        breaks = np.flatnonzero((np.diff(chunks) != 1) | (np.diff(records) != self.chunk_surfels)) + 1
        return [self.run(int(part[0]), int(part[-1]), view) for part in np.split(chunks, breaks)]


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


def visible_chunks(
    state: LevelState, view: AnchoredView, size_px: tuple[int, int], modulated: bool
) -> IntArray:
    """Chunks of a level that may contribute, ascending, (k,) int32."""
    keep = in_frustum(state.bounds, view, size_px)
    if modulated:
        keep &= ~weightless(state.bounds, view, state.modulation)
    return np.flatnonzero(keep).astype(np.int32)


def prepare(
    states: Mapping[int, LevelState], camera: Camera, modulated: bool = True, culling: bool = True
) -> Prepared:
    """Culls and orders.

    Args:
        states: of the levels that are drawn, by level index, ascending.
        camera: the rendering camera.
        modulated: whether Eq. 3 applies.
        culling: False keeps every chunk.
    """
    began = time.perf_counter()
    views = {i: AnchoredView.expand(camera, state.level.frame) for i, state in states.items()}
    runs, radius, num_chunks, is_unit = [], 0.0, 0, True
    for i, state in states.items():
        chunks = np.arange(len(state.bounds), dtype=np.int32)
        if culling:
            chunks = visible_chunks(state, views[i], (camera.width, camera.height), modulated)
        runs += state.runs(chunks, views[i])
        radius = max(radius, float(chunk_radii_px(state.bounds, views[i])[chunks].max(initial=0.0)))
        num_chunks += len(chunks)
        is_unit &= not modulated or bool(unmodulated(state.bounds, views[i], state.modulation)[chunks].all())
    culled = time.perf_counter()
    order = order_runs(runs, _focus(states, camera))
    sorted_at = time.perf_counter()
    num_surfels = sum(len(state.surfels) for state in states.values())
    times = (1e3 * (culled - began), 1e3 * (sorted_at - culled))
    return Prepared(views, runs, order, radius, is_unit, num_chunks, num_surfels, *times)


def _focus(states: Mapping[int, LevelState], camera: Camera) -> Focus:
    return focus_of(camera, [state.level.frame for state in states.values()])
