"""Which surfels a frame needs.  No OpenGL here, so it may run on any thread.

::

    LevelState (what has arrived of a level) ──┐
    camera ────────────────────────────────────┼─ select ──► Selection: runs of surfels, Eq. 3 per level
                                               │               └─ order ──► Ordered: nearest first

Cost follows what is visible: a level is looked at chunk by chunk only when the box around it may be
seen, a chunk's surfels only when its own may, and a cover of Eq. 3 is kept only where it acts.  Each of
these steps is taken for all levels at once.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Modulation
from wzviewer.core.reference import Focus
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray
from wzviewer.gl.cull import EXTENT_SIGMAS, ChunkBounds, chunk_radii_px, fades_in, in_frustum, log_ratio
from wzviewer.gl.merging import MERGED_CELLS_PX
from wzviewer.gl.order import Run, UIntArray, order_places
from wzviewer.gl.sieve import LevelTable, Region, modulate
from wzviewer.gl.stacks import Views


@dataclass(frozen=True, eq=False)
class SurfelSet:
    """Surfels that have arrived: the exact ones of a level, or a merged form of them.

    Attributes:
        surfels: in the level's frame.
        bounds: of its chunks.
        first_records: (chunks,) record number of each chunk.
        chunk_surfels: surfels per chunk.
        cell_px: native pixels along a side of what was merged into one; 1 for the exact ones.
        maker: the level's own camera about its anchor, for tight bounds.
    """

    surfels: Surfels
    bounds: ChunkBounds
    first_records: IntArray
    chunk_surfels: int
    cell_px: int = 1
    maker: AnchoredView | None = None

    @cached_property
    def columns(self) -> FloatArray:
        """(3, n) float32, the means as columns (for the keys)."""
        return np.ascontiguousarray(self.surfels.means.T)

    @cached_property
    def hull(self) -> ChunkBounds:
        """One box around all."""
        return self.bounds.hull(self.maker)

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
        return cls(level, sets, modulation, own_view(level).rows[2])


def own_view(level: Level) -> AnchoredView:
    """The camera that made a level, about its anchor."""
    return AnchoredView.expand(level.camera, level.frame)


class LevelStates(dict[int, LevelState]):
    """States by level index, ascending, and what all selections from them share."""

    @cached_property
    def table(self) -> LevelTable:
        """The levels, stacked."""
        return LevelTable.of(list(self.values()))


@dataclass(frozen=True)
class Choice:
    """What decides the selection, beside the scene and the camera.

    Attributes:
        modulated: whether Eq. 3 applies.
        culling: False keeps every chunk.
        spacing_px: merged surfels are taken where theirs are at most this far apart on the screen.
        root_spacing_px: the same for levels without a parent, if it is more: those never fade in.
        contribution_min: surfels whose opacity times area, px^2, is less may be left out.
        finer: pixels along a side that one of the camera's stands for: Eq. 3 is asked at their scale.
        margin_px: chunks this far outside the image are kept too, for a camera that moves on.
        point_limit_px: surfels of chunks with larger footprints are marked big.
    """

    modulated: bool = True
    culling: bool = True
    spacing_px: float = 0.0
    root_spacing_px: float = 0.0
    contribution_min: float = 0.0
    finer: float = 1.0
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
        unmerged: levels that stand in for merged forms of theirs that have not been made.
    """

    camera: Camera
    focus: Focus
    views: Mapping[int, AnchoredView]
    seen: Mapping[int, SeenLevel]
    num_surfels: int
    cull_ms: float
    unmerged: frozenset[int] = frozenset()

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
    focus, seen = Focus(1.0, camera.pixel_scale(1.0)), dict[int, SeenLevel]()
    unmerged = frozenset[int]()
    if states:
        table = (states if isinstance(states, LevelStates) else LevelStates(states)).table
        views = Views.expand(camera, table.frames).finer(choice.finer)
        focus = table.focus(camera, views.depth)
        if choice.culling:
            seen, unmerged = _see(table, views, camera, choice)
        else:
            seen = _everything(table, camera, choice)
    total = sum(len(state.sets[0].surfels) for state in states.values())
    kept = {i: level.runs[0].view for i, level in seen.items()}
    cull_ms = 1e3 * (time.perf_counter() - began)
    return Selection(camera, focus, kept, seen, total, cull_ms, unmerged & frozenset(seen))


def _see(
    table: LevelTable, views: Views, camera: Camera, choice: Choice
) -> tuple[dict[int, SeenLevel], frozenset[int]]:
    """What is seen of each level, and which levels want merged forms that are not there."""
    size_px = (camera.width, camera.height)
    levels = np.flatnonzero(_may_be_seen(table, views, size_px, choice)).tolist()
    sets = {owner: table.states[owner].sets[0] for owner in levels}
    if not sets:
        return {}, frozenset()
    sets, unmerged = _choose_sets(table, views, sets, size_px, choice)
    region = Region.of(sets, views, size_px, choice.margin_px)
    region = region.take(2.0 * np.pi * (region.radii_px / EXTENT_SIGMAS) ** 2 >= choice.contribution_min)
    plain, covers = np.ones(len(region.owners), bool), np.empty(0, np.int32)
    if choice.modulated:
        region, plain, covers = modulate(table, region)
    ends = np.searchsorted(region.owners, [*levels, len(table.states)]).tolist()
    seen = {}
    for owner, first, last in zip(levels, ends[:-1], ends[1:], strict=True):
        if first < last:
            here, state = slice(first, last), table.states[owner]
            part = (region.chunks[here], region.radii_px[here], plain[here])
            modulation = _of_covers(table, owner, covers, sets[owner].cell_px / choice.finer)
            seen[state.level.index] = _seen(state, sets[owner], *part, camera, modulation, choice)
    return seen, unmerged


def _may_be_seen(table: LevelTable, views: Views, size_px: tuple[int, int], choice: Choice) -> BoolArray:
    """Looks at the boxes around levels: cheap, and enough for most levels of a deep or wide tree."""
    near = in_frustum(table.hulls, views, size_px, choice.margin_px)
    return near & fades_in(table.hulls, views, table.parent_rows) if choice.modulated else near


def _of_covers(table: LevelTable, owner: int, covers: IntArray, cell_px: float) -> Modulation:
    """The modulation of a level, less the covers that act nowhere."""
    modulation = table.states[owner].modulation
    ranks = table.ranks[covers[table.covered[covers] == owner]].tolist()
    return Modulation(modulation.parent_rows, tuple(modulation.covers[k] for k in ranks), cell_px)


def _choose_sets(
    table: LevelTable,
    views: Views,
    exact: Mapping[int, SurfelSet],
    size_px: tuple[int, int],
    choice: Choice,
) -> tuple[dict[int, SurfelSet], frozenset[int]]:
    """The coarsest forms whose surfels are near enough to each other on the screen.

    Returns:
        The form of each level by its place, and the levels of which a coarser one would do.
    """
    chosen, unmerged = dict(exact), set()
    spacings_px = _spacings_px(table, views, exact, choice)
    if not spacings_px:
        return chosen, frozenset()
    region = Region.of({owner: exact[owner] for owner in spacings_px}, views, size_px, 0.0)
    native = table.native_rows[region.owners]
    octaves = log_ratio(native, region.views.rows[:, 2], region.parts.corners).max(1)  # of magnification
    most = np.full(len(table.states), -np.inf)
    np.maximum.at(most, region.owners, np.where(np.isnan(octaves), np.inf, octaves))  # nan: no merging
    for owner, spacing_px in spacings_px.items():
        sets = table.states[owner].sets if np.isfinite(most[owner]) else ()
        fitting = [s for s in sets if s.cell_px * 2.0 ** most[owner] <= spacing_px]
        chosen[owner] = max(fitting, key=lambda s: s.cell_px, default=exact[owner])
        wanted = [cell for cell in MERGED_CELLS_PX if cell * 2.0 ** most[owner] <= spacing_px]
        if sets and max(wanted, default=1) > chosen[owner].cell_px:
            unmerged.add(table.states[owner].level.index)
    return chosen, frozenset(unmerged)


def _spacings_px(
    table: LevelTable, views: Views, exact: Mapping[int, SurfelSet], choice: Choice
) -> dict[int, float]:
    """Spacing that merged surfels may have, of levels that may be seen small enough for the finest of them.

    Seen at its own scale, as most often, a level is ruled out by the box around it.
    """
    found = {}
    for owner in exact:
        is_root = table.states[owner].level.parent is None
        spacing_px = max(choice.spacing_px, choice.root_spacing_px if is_root else 0.0)
        found[owner] = choice.finer * spacing_px  # as the views see it
    if not any(found.values()):
        return {}
    least = log_ratio(table.native_rows, views.rows[:, 2], table.hulls.corners).min(1)  # nan: may be
    finest = float(min(MERGED_CELLS_PX))
    return {
        owner: spacing_px
        for owner, spacing_px in found.items()
        if spacing_px > 0.0 and not finest * 2.0 ** least[owner] > spacing_px
    }


def _everything(table: LevelTable, camera: Camera, choice: Choice) -> dict[int, SeenLevel]:
    seen = {}
    for state in table.states:
        exact = state.sets[0]
        radii = chunk_radii_px(exact.bounds, AnchoredView.expand(camera, state.level.frame))
        chunks = np.arange(len(radii), dtype=np.int32)
        plain = np.full(len(chunks), not choice.modulated)
        modulation = replace(state.modulation, cell_px=exact.cell_px / choice.finer)
        seen[state.level.index] = _seen(state, exact, chunks, radii, plain, camera, modulation, choice)
    return seen


def _seen(
    state: LevelState,
    chosen: SurfelSet,
    chunks: IntArray,
    radii_px: DoubleArray,
    plain: BoolArray,
    camera: Camera,
    modulation: Modulation,
    choice: Choice,
) -> SeenLevel:
    view = AnchoredView.expand(camera, state.level.frame).finer(choice.finer)
    big = 2.0 * radii_px > choice.point_limit_px
    spans = chosen.spans(chunks, (big + 2 * plain).astype(np.int32))
    runs = tuple(
        Run(chosen, piece, view, state.level, record, is_big=bool(kind & 1), is_plain=bool(kind & 2))
        for piece, record, kind in spans
    )
    acting = None if plain.all() else modulation
    return SeenLevel(runs, acting, float(radii_px.max(initial=0.0)), len(chunks))
