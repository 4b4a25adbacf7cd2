"""Merged forms of finished levels, made on a thread of their own while frames go on."""

import contextlib
import logging
import os
import queue
import sys
import threading

from wzviewer.core.merging import merged
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels

MERGED_CELLS_PX = (2, 4)  # native pixels along a side of what becomes one surfel

NICE = 19

Forms = tuple[Surfels, ...]

LOG = logging.getLogger(__name__)


class MergeQueue:
    """A thread that merges one level after the other; it keeps what it made for whoever draws."""

    def __init__(self) -> None:
        self._asked: dict[int, Surfels] = {}  # the surfels are held, so their identity stays theirs
        self._made: dict[int, tuple[Surfels, Forms]] = {}
        self._jobs: queue.SimpleQueue[tuple[Level, tuple[int, ...]] | None] = queue.SimpleQueue()
        self._done: queue.SimpleQueue[tuple[Level, Forms]] = queue.SimpleQueue()
        self._pending = 0
        self._closing = False
        self._thread: threading.Thread | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a level was asked for that `collect` has not brought back."""
        return self._pending > 0

    def ask(self, level: Level, cells_px: tuple[int, ...] = MERGED_CELLS_PX) -> None:
        """Queues a level, unless this version of it was asked for before.

        Args:
            level: to merge.
            cells_px: native pixels along a side of a cell, for each form.
        """
        if self._asked.get(level.index) is level.surfels:
            return
        self._asked[level.index] = level.surfels
        if self._thread is None:
            self._closing = False
            self._thread = threading.Thread(target=self._work, name="merging", daemon=True)
            self._thread.start()
        self._pending += 1
        self._jobs.put((level, cells_px))

    def collect(self, num_levels: int) -> None:
        """Takes back what is done, and forgets levels that are gone.

        Args:
            num_levels: of the scene; those of higher index are gone.
        """
        for index in [i for i in self._asked if i >= num_levels]:
            del self._asked[index]
            self._made.pop(index, None)
        while not self._done.empty():
            self._pending -= 1
            level, forms = self._done.get()
            if self._asked.get(level.index) is level.surfels:  # else it was replaced meanwhile
                self._made[level.index] = (level.surfels, forms)

    def forms(self, level: Level) -> Forms:
        """Merged forms of this version of a level, finest first; none before they have come back."""
        surfels, forms = self._made.get(level.index, (None, ()))
        return forms if surfels is level.surfels else ()

    def wait(self) -> None:
        """Waits until a level comes back, if one is under way."""
        if self.is_busy:
            self._done.put(self._done.get())

    def close(self) -> None:
        """Ends the thread after the level that it is at; those that wait are dropped."""
        self._closing = True
        if self._thread is not None:
            self._jobs.put(None)
            self._thread.join()
        self._thread, self._pending = None, 0
        self._jobs, self._done = queue.SimpleQueue(), queue.SimpleQueue()
        self._asked = {index: surfels for index, (surfels, _) in self._made.items()}

    def _work(self) -> None:
        _step_back()
        while (job := self._jobs.get()) is not None and not self._closing:
            self._done.put((job[0], _forms_of(*job)))


def _step_back() -> None:
    """Lets frames come first where cores are few; elsewhere than on Linux a thread is not as nice."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)


def _forms_of(level: Level, cells_px: tuple[int, ...]) -> Forms:
    """The merged forms, or none where that fails: the exact surfels stand in for them."""
    try:
        forms = (merged(level.surfels, level.camera, level.frame, cell) for cell in cells_px)
        return tuple(forms)
    except Exception:
        LOG.exception("level %d could not be merged; all its surfels are drawn", level.index)
        return ()
