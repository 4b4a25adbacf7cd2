"""Which surfels a frame needs.  No OpenGL here, so it may run on any thread.

::

    LevelState (what has arrived of a level) ──┐
    camera ────────────────────────────────────┼─ select ──► Selection: runs of surfels, Eq. 3 per level
                                               │               └─ order ──► Ordered: nearest first

Cost follows what is visible: a level is looked at chunk by chunk only when the box around it may be
seen, a chunk's surfels only when its own may, and a cover of Eq. 3 is kept only where it acts.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Modulation
from wzviewer.core.reference import Focus, focus_of
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray
from wzviewer.gl.cull import (
    EXTENT_SIGMAS,
    ChunkBounds,
    chunk_radii_px,
    clipped,
    fades_in,
    in_frustum,
    log_ratio,
    may_cover,
    unmodulated,
    view_slabs,
    weightless,
)
from wzviewer.gl.order import Run, UIntArray, order_places


@dataclass(frozen=True, eq=False)
class SurfelSet:
    """Surfels that have arrived: the exact ones of a level, or a merged form of them.

    Attributes:
        surfels: in the level's frame.
        bounds: of its chunks.
        first_records: (chunks,) record number of each chunk.
        chunk_surfels: surfels per chunk.
        cell_px: native pixels along a side of what was merged into one; 1 for the exact ones.
    """

    surfels: Surfels
    bounds: ChunkBounds
    first_records: IntArray
    chunk_surfels: int
    cell_px: int = 1

    @cached_property
    def columns(self) -> FloatArray:
        """(3, n) float32, the means as columns (for the keys)."""
        return np.ascontiguousarray(self.surfels.means.T)

    @cached_property
    def hull(self) -> ChunkBounds:
        """One box around all."""
        return self.bounds.hull()

    def spans(self, chunks: IntArray, kinds: IntArray) -> list[tuple[slice, int, int]]:
        """Joins chunks, ascending, to (surfels, first record, kind) of consecutive records and one kind."""
        if not len(chunks):
            return []
        records = self.first_records[chunks]
        split = (np.diff(chunks) != 1) | (np.diff(records) != self.chunk_surfels) | (np.diff(kinds) != 0)
        firsts = np.concatenate([[0], np.flatnonzero(split) + 1])
        lasts = np.concatenate([firsts[1:], [len(chunks)]]) - 1
        size, total = self.chunk_surfels, len(self.surfels)
        starts, stops = chunks[firsts] * size, np.minimum((chunks[lasts] + 1) * size, total)
        pieces = [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]
        return list(zip(pieces, records[firsts].tolist(), kinds[firsts].tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class LevelState:
    """A level that is drawn.

    Attributes:
        level: its description.
        sets: its exact surfels, then merged forms of growing cells that have arrived.
        modulation: its parent and covers among the levels that are drawn.
        native_row: (4,) ``(g, base)`` of its own camera about its anchor.
    """

    level: Level
    sets: tuple[SurfelSet, ...]
    modulation: Modulation
    native_row: DoubleArray

    @classmethod
    def of(cls, level: Level, sets: tuple[SurfelSet, ...], modulation: Modulation) -> "LevelState":
        """Returns the state of a level."""
        native_row = AnchoredView.expand(level.camera, level.frame).rows[2]
        return cls(level, sets, modulation, native_row)


@dataclass(frozen=True)
class Choice:
    """What decides the selection, beside the scene and the camera.

    Attributes:
        modulated: whether Eq. 3 applies.
        culling: False keeps every chunk.
        spacing_px: merged surfels are taken where theirs are at most this far apart on the screen.
        contribution_min: surfels whose opacity times area, px^2, is less may be left out.
        margin_px: chunks this far outside the image are kept too, for a camera that moves on.
        point_limit_px: surfels of chunks with larger footprints are marked big.
    """

    modulated: bool = True
    culling: bool = True
    spacing_px: float = 0.0
    contribution_min: float = 0.0
    margin_px: float = 0.0
    point_limit_px: float = np.inf


@dataclass(frozen=True, eq=False)
class SeenLevel:
    """The part of a level that may contribute to a view.

    Attributes:
        runs: its surfels.
        modulation: with the covers that act there, or None where w = 1 is certain.
        radius_px: bound of the footprint radii.
        num_chunks: chunks kept.
    """

    runs: tuple[Run, ...]
    modulation: Modulation | None
    radius_px: float
    num_chunks: int


@dataclass(frozen=True, eq=False)
class Selection:
    """What to draw for a camera, unordered.

    Attributes:
        camera: that it is for.
        focus: of the view.
        views: the camera about each level's anchor, by index of the levels that are seen.
        seen: by level index, ascending.
        num_surfels: surfels of the levels that are drawn, before culling.
        cull_ms: time of the selection.
    """

    camera: Camera
    focus: Focus
    views: Mapping[int, AnchoredView]
    seen: Mapping[int, SeenLevel]
    num_surfels: int
    cull_ms: float

    @cached_property
    def runs(self) -> list[Run]:
        """All runs, in scene order: level by level, and by index within a level."""
        return [run for level in self.seen.values() for run in level.runs]

    @property
    def num_selected(self) -> int:
        """Surfels of all runs."""
        return sum(len(run) for run in self.runs)

    @property
    def num_chunks(self) -> int:
        """Chunks that were kept."""
        return sum(level.num_chunks for level in self.seen.values())

    @property
    def radius_px(self) -> float:
        """Bound of the footprint radii."""
        return max((level.radius_px for level in self.seen.values()), default=0.0)

    @property
    def is_unit_weight(self) -> bool:
        """Whether w = 1 is certain for every surfel."""
        return all(level.modulation is None for level in self.seen.values())

    def ordered(self) -> "Ordered":
        """Sorts all runs."""
        began = time.perf_counter()
        places = order_places(self.runs, self.focus)
        return Ordered(self, places, 1e3 * (time.perf_counter() - began))


@dataclass(frozen=True, eq=False)
class Ordered:
    """A selection and its exact order.

    Attributes:
        selection: what is drawn.
        places: (n,) places in the concatenated runs, nearest first.
        sort_ms: time of keys and sort.
    """

    selection: Selection
    places: UIntArray
    sort_ms: float

    def records(self) -> UIntArray:
        """Record numbers, nearest first, (n,) uint32."""
        runs = self.selection.runs
        if not runs:
            return self.places
        return np.concatenate([run.records() for run in runs])[self.places]


def select(states: Mapping[int, LevelState], camera: Camera, choice: Choice) -> Selection:
    """Chooses the surfels that may contribute to a view.

    Args:
        states: of the levels that are drawn, by level index, ascending.
        camera: the rendering camera.
        choice: what decides.
    """
    began = time.perf_counter()
    views = {i: AnchoredView.expand(camera, state.level.frame) for i, state in states.items()}
    focus = focus_of(camera, [state.level.frame for state in states.values()])
    size_px = (camera.width, camera.height)
    seen = {i: _see(state, views[i], size_px, choice) for i, state in states.items()}
    seen = {i: level for i, level in seen.items() if level.num_chunks}
    total = sum(len(state.sets[0].surfels) for state in states.values())
    kept = {i: views[i] for i in seen}
    return Selection(camera, focus, kept, seen, total, 1e3 * (time.perf_counter() - began))


def _see(state: LevelState, view: AnchoredView, size_px: tuple[int, int], choice: Choice) -> SeenLevel:
    if not choice.culling:
        return _everything(state, view, choice)
    hull = state.sets[0].hull
    if not _may_be_seen(hull, view, size_px, state.modulation, choice):
        return SeenLevel((), None, 0.0, 0)
    chosen = _choose_set(state, view, size_px, choice)
    kept = in_frustum(chosen.bounds, view, size_px, choice.margin_px)
    slabs = view_slabs(chosen.bounds, view, size_px, choice.margin_px)
    part = clipped(chosen.bounds, slabs)
    modulation = state.modulation
    if choice.modulated:
        modulation = _acting(modulation, part.take(kept), view)
        for region in (part, slabs):
            kept = kept & ~weightless(region, view, modulation)
    radii = chunk_radii_px(part, view)
    kept = kept & (2.0 * np.pi * (radii / EXTENT_SIGMAS) ** 2 >= choice.contribution_min)
    chunks = np.flatnonzero(kept).astype(np.int32)
    plain = np.ones(len(chunks), bool)
    if choice.modulated:
        plain = unmodulated(part.take(chunks), view, modulation, state.native_row)
    return _seen(state, chosen, chunks, radii[chunks], plain, view, modulation, choice)


def _may_be_seen(
    hull: ChunkBounds, view: AnchoredView, size_px: tuple[int, int], modulation: Modulation, choice: Choice
) -> bool:
    """Looks at the box around a level: cheap, and enough for most levels of a deep or wide tree."""
    if choice.modulated and not fades_in(hull, view, modulation)[0]:
        return False
    return bool(in_frustum(hull, view, size_px, choice.margin_px)[0])


def _acting(modulation: Modulation, kept: ChunkBounds, view: AnchoredView) -> Modulation:
    """Leaves out covers that take nothing from the kept chunks."""
    if not modulation.covers or not len(kept):
        return modulation
    hull = kept.hull()
    near = [c for c in modulation.covers if may_cover(hull, view, c)[0]]
    return replace(modulation, covers=tuple(c for c in near if may_cover(kept, view, c).any()))


def _choose_set(state: LevelState, view: AnchoredView, size_px: tuple[int, int], choice: Choice) -> SurfelSet:
    """The coarsest form whose surfels are near enough to each other on the screen."""
    if choice.spacing_px <= 0.0 or len(state.sets) == 1:
        return state.sets[0]
    bounds = state.sets[0].bounds
    part = clipped(bounds, view_slabs(bounds, view, size_px)).take(in_frustum(bounds, view, size_px))
    octaves = log_ratio(state.native_row, view.rows[2], part.corners)  # of magnification
    if not octaves.size or not np.isfinite(octaves).all():
        return state.sets[0]
    native_px = 2.0 ** float(octaves.max())
    fitting = [s for s in state.sets if s.cell_px * native_px <= choice.spacing_px]
    return max(fitting, key=lambda s: s.cell_px, default=state.sets[0])


def _everything(state: LevelState, view: AnchoredView, choice: Choice) -> SeenLevel:
    exact = state.sets[0]
    radii = chunk_radii_px(exact.bounds, view)
    chunks = np.arange(len(radii), dtype=np.int32)
    plain = np.full(len(chunks), not choice.modulated)
    return _seen(state, exact, chunks, radii, plain, view, state.modulation, choice)


def _seen(
    state: LevelState,
    chosen: SurfelSet,
    chunks: IntArray,
    radii_px: DoubleArray,
    plain: BoolArray,
    view: AnchoredView,
    modulation: Modulation,
    choice: Choice,
) -> SeenLevel:
    big = 2.0 * radii_px > choice.point_limit_px
    spans = chosen.spans(chunks, (big + 2 * plain).astype(np.int32))
    runs = tuple(
        Run(chosen, piece, view, state.level, record, is_big=bool(kind & 1), is_plain=bool(kind & 2))
        for piece, record, kind in spans
    )
    acting = None if plain.all() else modulation
    return SeenLevel(runs, acting, float(radii_px.max(initial=0.0)), len(chunks))
