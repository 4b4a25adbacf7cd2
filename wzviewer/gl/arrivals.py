"""What of a scene has arrived, and so is drawn: the viewer's replica of the log of levels.

A level is drawn when all its surfels have arrived; until then its parent shows through, and a level
that is replaced keeps its former version.  Merged forms of a finished level are made in the background
and arrive in the same way; until then the preview of the level, itself merged for a camera that moves,
stands in for them, or the exact surfels where there was none.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from wzviewer.core.constants import MAX_LEVELS
from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.gl.merging import MERGED_CELLS_PX, MergeQueue
from wzviewer.gl.pages import PAGE_SURFELS, Pages
from wzviewer.gl.visible import LevelState, LevelStates, SurfelSet, own_view

PREVIEW_SHARE = 0.5  # of a revision's surfels: a preview with more of them would save nothing
PREVIEW_CELLS_PX = MERGED_CELLS_PX[1:]  # a preview is what the finest cells would give


@dataclass(frozen=True, eq=False)
class Preview:
    """An early revision of a level in the making.

    Attributes:
        level: with few surfels.
        is_bare: whether what was asked for is not in it yet.
    """

    level: Level
    is_bare: bool

    def followed_by(self, level: Level) -> "Preview":
        """The newest preview once a further revision has arrived."""
        is_small = len(level.surfels) * PREVIEW_SHARE < len(self.level.surfels)
        return Preview(level, is_bare=False) if is_small else self


class Arrivals:
    """Keeps `Pages` up to a scene.

    Args:
        pages: where surfels go.

    Attributes:
        states: of the levels that are drawn, by index, ascending; another object after a change.
        version: grows with every change of the states.
    """

    def __init__(self, pages: Pages) -> None:
        self._pages = pages
        self._levels: dict[int, Level] = {}  # whose surfels have arrived
        self._previews: dict[int, Preview] = {}  # of levels that were seen in the making
        self._scene: Scene | None = None  # held: a new one must not get its address
        self._synced: tuple[int, ...] = ()
        self._tree: tuple[Any, ...] = ()
        self.states = LevelStates()
        self.version = 0

    def sync(self, scene: Scene, budget_bytes: int | None, merges: MergeQueue | None) -> bool:
        """Takes over what is new in a scene; costs nothing when nothing changed.

        Args:
            scene: to be drawn.
            budget_bytes: take about this much at most; None takes everything.
            merges: makes merged forms; None does without.

        Returns:
            Whether everything has arrived.
        """
        if self._scene is not scene:
            self._open(scene)
        if self._synced[:1] != (scene.revision,):
            self._stage(scene)
        self._pages.upload(budget_bytes)
        self._adopt_news(scene)
        if merges is not None:
            if self._stage_previews(merges):  # whole, before a frame has to draw all of the revision
                self._pages.upload(None)
                self._adopt_news(scene)
            merges.collect(len(scene))
            self._stage_merged(scene, merges)
        return self._pages.is_complete

    def merge(self, indices: Iterable[int], merges: MergeQueue) -> None:
        """Waits for merged forms of levels that are drawn, and takes them over."""
        levels = [self.states[index].level for index in indices]
        for level in levels:
            merges.ask(level)
        while merges.is_busy:
            merges.wait()
            merges.collect(MAX_LEVELS)
        for level in levels:
            self._stage_forms(level, merges)
        self._pages.upload(None)
        if self._scene is not None and self._synced[1:] != (self._pages.generation,):
            self._synced = (self._synced[0], self._pages.generation)
            self._adopt(self._scene)

    def _open(self, scene: Scene) -> None:
        """Begins another document: levels of the last one must not stand in for its levels."""
        for index in list(self._levels):
            if index >= len(scene) or scene[index].surfels is not self._levels[index].surfels:
                self._remove(index)
        self._scene, self._synced = scene, ()

    def _stage(self, scene: Scene) -> None:
        for level in scene:
            if len(level.surfels) and self._pages.latest((level.index, 0)) is not level.surfels:
                slot = level.index  # of the block texture, <= 255
                self._pages.stage((level.index, 0), level.surfels, slot, own_view(level))
        for index in {index for index, _ in self._pages.names()}:
            if index >= len(scene) or not len(scene[index].surfels):
                self._remove(index)

    def _remove(self, index: int) -> None:
        for name in [name for name in self._pages.names() if name[0] == index]:
            self._pages.remove(name)
        self._levels.pop(index, None)
        self._previews.pop(index, None)

    def _adopt_news(self, scene: Scene) -> None:
        synced = (scene.revision, self._pages.generation)
        if synced != self._synced:
            self._synced = synced
            self._adopt(scene)

    def _stage_previews(self, merges: MergeQueue) -> bool:
        """Lets previews stand in for merged forms, which are made when a level is finished."""
        staged = False
        for index, preview in self._previews.items():
            level, early = self._levels[index], preview.level
            is_shown = level.surfels is early.surfels
            is_refined = len(early.surfels) < PREVIEW_SHARE * len(level.surfels)
            if preview.is_bare or not (is_shown or is_refined):
                continue
            if is_shown:
                merges.ask(early, PREVIEW_CELLS_PX)
            coarser = merges.forms(early)
            sets = (early.surfels, *coarser) if coarser or is_refined else ()
            for detail, surfels in enumerate(sets, start=1):
                if self._pages.latest((index, detail)) is None:
                    self._pages.stage((index, detail), surfels, index, own_view(level))
                    staged = True
        return staged

    def _stage_merged(self, scene: Scene, merges: MergeQueue) -> None:
        """Asks for the merged forms of finished levels that are drawn, and queues those that are done."""
        for level in scene:
            if scene.is_committed(level.index) and self._levels.get(level.index) is level:
                merges.ask(level)
                self._stage_forms(level, merges)
                if merges.forms(level):
                    self._previews.pop(level.index, None)

    def _stage_forms(self, level: Level, merges: MergeQueue) -> None:
        for detail, surfels in enumerate(merges.forms(level), start=1):
            if len(surfels) and self._pages.latest((level.index, detail)) is not surfels:
                self._pages.stage((level.index, detail), surfels, level.index, own_view(level))

    def _adopt(self, scene: Scene) -> None:
        """Takes what has arrived as the levels that are drawn."""
        for level in scene:
            if self._pages.shown((level.index, 0)) is level.surfels:
                if not scene.is_committed(level.index):
                    self._note_preview(level)
                if self._levels.get(level.index) is not level:
                    self._drop_merged(level.index)
                self._levels[level.index] = level
        self.version += 1
        drawn = self._replica(scene)
        visible = drawn.visible()
        tree = tuple(_place(drawn[i]) for i in visible)
        same = tree == self._tree  # a level in the making is often replaced, and seldom moves
        laws = {i: self.states[i].modulation if same else modulation(drawn, i) for i in visible}
        self._tree = tree
        self.states = LevelStates({i: LevelState.of(drawn[i], self._sets(i), laws[i]) for i in visible})

    def _note_preview(self, level: Level) -> None:
        before = self._levels.get(level.index)
        if before is None and level.parent is not None:  # that of E_0 is flat
            self._previews[level.index] = Preview(level, is_bare=bool(level.prompt))
        elif before is not level and (preview := self._previews.get(level.index)) is not None:
            if before is preview.level:
                self._previews[level.index] = preview.followed_by(level)

    def _drop_merged(self, index: int) -> None:
        former = self._levels.get(index)
        if former is not None and former.surfels is not self._pages.shown((index, 0)):
            for detail in range(1, len(MERGED_CELLS_PX) + 1):
                self._pages.remove((index, detail))

    def _replica(self, scene: Scene) -> Scene:
        """The scene with levels that have not arrived hidden, and replaced ones in their old state."""
        replica = Scene()
        for level in scene:
            replica.append(self._levels.get(level.index, level))
            if level.index not in self._levels or level.index in scene.hidden:
                replica.hide(level.index)
        return replica

    def _sets(self, index: int) -> tuple[SurfelSet, ...]:
        former = {id(s.surfels): s for s in self.states[index].sets} if index in self.states else {}
        sets = []
        for detail, cell_px in enumerate((1, *MERGED_CELLS_PX)):
            surfels = self._pages.shown((index, detail))
            if surfels is None:
                break
            records = self._pages.first_records((index, detail))
            kept = former.get(id(surfels))
            if kept is None or (kept.first_records != records).any():
                kept = SurfelSet(
                    surfels,
                    self._pages.bounds((index, detail)),
                    records,
                    PAGE_SURFELS,
                    cell_px,
                    own_view(self._levels[index]),
                )
            sets.append(kept)
        return tuple(sets)


def _place(level: Level) -> tuple[object, ...]:
    """What the modulation of a level and of those around it depends on."""
    frame = level.frame
    anchor = (frame.origin.tobytes(), frame.axes.tobytes(), frame.unit)
    return (level.index, level.parent, level.camera.key, *anchor)
