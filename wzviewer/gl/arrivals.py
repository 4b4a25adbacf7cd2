"""What of a scene has arrived, and so is drawn: the viewer's replica of the log of levels.

A level is drawn when all its surfels have arrived; until then its parent shows through, and a level
that is replaced keeps its former version.  Merged forms of a finished level are made in the background
and arrive in the same way; until then the exact surfels stand in for them.
"""

from collections.abc import Mapping
from typing import Any

from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.gl.merging import MERGED_CELLS_PX, MergeQueue
from wzviewer.gl.pages import PAGE_SURFELS, Pages
from wzviewer.gl.visible import LevelState, SurfelSet


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
        self._synced: tuple[Any, ...] = ()
        self.states: Mapping[int, LevelState] = {}
        self.version = 0

    def sync(self, scene: Scene, budget_bytes: int | None, merges: MergeQueue | None) -> bool:
        """Takes over what is new in a scene; costs nothing when nothing changed.

        Args:
            scene: to be drawn.
            budget_bytes: take about this much at most; None takes everything.
            merges: makes merged forms; None does without.

        Returns:
            Whether every level has arrived.
        """
        if self._synced[:2] != (id(scene), scene.revision):
            self._stage(scene)
        if merges is not None:
            self._stage_merged(scene, merges)
        self._pages.upload(budget_bytes)
        synced = (id(scene), scene.revision, self._pages.generation)
        if synced != self._synced:
            self._synced = synced
            self._adopt(scene)
        return all(self._pages.shown((lv.index, 0)) is lv.surfels for lv in scene if len(lv.surfels))

    def _stage(self, scene: Scene) -> None:
        for level in scene:
            if len(level.surfels) and self._pages.latest((level.index, 0)) is not level.surfels:
                self._pages.stage((level.index, 0), level.surfels, level.index)  # slot = index <= 255
        for index, detail in sorted(self._pages.names()):
            if index >= len(scene) or not len(scene[index].surfels):
                self._pages.remove((index, detail))
                self._levels.pop(index, None)

    def _stage_merged(self, scene: Scene, merges: MergeQueue) -> None:
        """Asks for the merged forms of committed levels, and queues those that are done."""
        for level in scene:
            if scene.is_committed(level.index) and self._levels.get(level.index) is level:
                merges.ask(level)
        for level, forms in merges.finished():
            if self._pages.shown((level.index, 0)) is level.surfels:
                for detail, surfels in enumerate(forms, start=1):
                    self._pages.stage((level.index, detail), surfels, level.index)

    def _adopt(self, scene: Scene) -> None:
        """Takes what has arrived as the levels that are drawn."""
        for level in scene:
            if self._pages.shown((level.index, 0)) is level.surfels:
                if self._levels.get(level.index) is not level:
                    self._drop_merged(level.index)
                self._levels[level.index] = level
        self.version += 1
        drawn = self._replica(scene)
        self.states = {
            i: LevelState.of(drawn[i], self._sets(i), modulation(drawn, i)) for i in drawn.visible()
        }

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
                kept = SurfelSet(surfels, self._pages.bounds((index, detail)), records, PAGE_SURFELS, cell_px)
            sets.append(kept)
        return tuple(sets)
