"""Merged forms of finished levels, made on a thread of their own while frames go on."""

import queue
import threading
from collections.abc import Iterator

from wzviewer.core.merging import merged
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels

MERGED_CELLS_PX = (2, 4)  # native pixels along a side of what becomes one surfel

Forms = tuple[Surfels, ...]


class MergeQueue:
    """A thread that merges one level after the other."""

    def __init__(self) -> None:
        self._asked: dict[int, Surfels] = {}  # the surfels are held, so their identity stays theirs
        self._jobs: queue.SimpleQueue[Level | None] = queue.SimpleQueue()
        self._done: queue.SimpleQueue[tuple[Level, Forms]] = queue.SimpleQueue()
        self._pending = 0
        self._thread: threading.Thread | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a level was asked for that has not come back."""
        return self._pending > 0

    def ask(self, level: Level) -> None:
        """Queues a level, unless this version of it was asked for before."""
        if self._asked.get(level.index) is level.surfels:
            return
        self._asked[level.index] = level.surfels
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="merging", daemon=True)
            self._thread.start()
        self._pending += 1
        self._jobs.put(level)

    def finished(self) -> Iterator[tuple[Level, Forms]]:
        """Yields levels with their merged forms, finest first, as they come."""
        while not self._done.empty():
            self._pending -= 1
            yield self._done.get()

    def wait(self) -> None:
        """Waits until a level comes back, if one is under way."""
        if self.is_busy:
            level, forms = self._done.get()
            self._done.put((level, forms))

    def close(self) -> None:
        """Ends the thread after the level that it is at."""
        if self._thread is not None:
            self._jobs.put(None)
            self._thread.join()
        self._thread = None

    def _work(self) -> None:
        while (level := self._jobs.get()) is not None:
            forms = (merged(level.surfels, level.camera, level.frame, cell) for cell in MERGED_CELLS_PX)
            self._done.put((level, tuple(forms)))
