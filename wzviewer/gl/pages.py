"""Which surfels have arrived: levels in pages, taken over a frame's worth at a time.

A page is one chunk: `PAGE_SURFELS` consecutive surfels of one set.  A set is the exact surfels of a
level or one of its merged forms, and is named ``(level, detail)``.  A set that is staged is written
page by page, as much as a frame's budget allows; it is shown when its last page has arrived, and only
then does the version before it retire.  Its pages are not written again before `reclaim`: an order
made earlier may still be drawn.  Pages of other sets are never touched.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import IntArray
from wzviewer.gl.cull import ChunkBounds
from wzviewer.gl.records import RECORD_BYTES

PAGE_SURFELS = 16384
PAGE_BYTES = PAGE_SURFELS * RECORD_BYTES

SetName = tuple[int, int]  # (level, detail)


@dataclass(eq=False)
class Version:
    """One version of a set and the pages that hold it.

    Attributes:
        surfels: of the set.
        slot: row of its level in the block texture.
        maker: the level's own camera about its anchor.
        pages: written so far.
        bounds: of the chunks written so far.
    """

    surfels: Surfels
    slot: int
    maker: AnchoredView | None = None
    pages: list[int] = field(default_factory=list)
    bounds: list[ChunkBounds] = field(default_factory=list)

    @property
    def num_pages(self) -> int:
        """Pages of the whole set."""
        return -(-len(self.surfels) // PAGE_SURFELS)

    def next_piece(self) -> Surfels:
        """The surfels of the next page."""
        start = len(self.pages) * PAGE_SURFELS
        return self.surfels.take(slice(start, start + PAGE_SURFELS))


class Pages:
    """Page numbers of all sets.  Subclasses write the pages somewhere.

    Attributes:
        generation: grows when what is shown changes.
    """

    def __init__(self) -> None:
        self.generation = 0
        self._capacity = 0
        self._free: list[int] = []
        self._retired: list[int] = []
        self._shown: dict[SetName, Version] = {}
        self._staged: dict[SetName, Version] = {}

    @property
    def capacity_surfels(self) -> int:
        """Records that fit into the pages that exist."""
        return self._capacity * PAGE_SURFELS

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return 0

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to write."""
        return not self._staged

    def names(self) -> Iterable[SetName]:
        """Sets that are shown or staged."""
        return self._shown.keys() | self._staged.keys()

    def shown(self, name: SetName) -> Surfels | None:
        """Surfels of the version that is complete, or None."""
        version = self._shown.get(name)
        return version.surfels if version else None

    def latest(self, name: SetName) -> Surfels | None:
        """Surfels of the newest version, complete or not."""
        version = self._staged.get(name) or self._shown.get(name)
        return version.surfels if version else None

    def bounds(self, name: SetName) -> ChunkBounds:
        """Bounds of the chunks of a shown set."""
        version = self._shown[name]
        version.bounds = [ChunkBounds.joined(version.bounds)]
        return version.bounds[0]

    def first_records(self, name: SetName) -> IntArray:
        """Record number at which each chunk of a shown set starts, (chunks,) int32."""
        return np.array(self._shown[name].pages, np.int32) * np.int32(PAGE_SURFELS)

    def stage(self, name: SetName, surfels: Surfels, slot: int, maker: AnchoredView | None = None) -> None:
        """Queues a set, or the next version of one, for `upload`.

        Args:
            name: of the set.
            surfels: of the set.
            slot: row of its level in the block texture.
            maker: the level's own camera about its anchor, for tight bounds.
        """
        self._free_pages(self._staged.pop(name, None))
        self._staged[name] = Version(surfels, slot, maker)

    def remove(self, name: SetName) -> None:
        """Retires the pages of a set."""
        self._free_pages(self._staged.pop(name, None))
        if (version := self._shown.pop(name, None)) is not None:
            self._retired += version.pages
            self.generation += 1

    def upload(self, budget_bytes: int | None = None) -> int:
        """Writes staged pages, at least one, until the budget is spent.

        Args:
            budget_bytes: None writes everything.

        Returns:
            Bytes written.
        """
        written = 0
        for name, version in list(self._staged.items()):
            while len(version.pages) < version.num_pages:
                if budget_bytes is not None and written and written + PAGE_BYTES > budget_bytes:
                    return written
                written += self._write_next(version)
            self._show(name)
        return written

    def reclaim(self) -> None:
        """Gives retired pages back: no order refers to them any more."""
        self._free = sorted(self._free + self._retired, reverse=True)
        self._retired = []

    def release(self) -> None:
        """Forgets everything."""
        self._capacity = 0
        self._free, self._retired, self._shown, self._staged = [], [], {}, {}

    def _write_next(self, version: Version) -> int:
        page, piece = self._take_page(), version.next_piece()
        self._write(page, piece, version.slot)
        version.pages.append(page)
        version.bounds.append(ChunkBounds.of_surfels(piece, PAGE_SURFELS, version.maker))
        return len(piece) * RECORD_BYTES

    def _write(self, page: int, piece: Surfels, slot: int) -> None:
        """Takes a page over; nothing to do where surfels are drawn from the scene's own arrays."""

    def _show(self, name: SetName) -> None:
        if (version := self._shown.get(name)) is not None:
            self._retired += version.pages
        self._shown[name] = self._staged.pop(name)
        self.generation += 1

    def _free_pages(self, version: Version | None) -> None:
        """Gives the pages of a version back that was never shown."""
        if version is not None:
            self._free = sorted(self._free + version.pages, reverse=True)

    def _take_page(self) -> int:
        if not self._free:  # room for all that waits: each growth copies what is there
            awaited = sum(version.num_pages - len(version.pages) for version in self._staged.values())
            self._grow(self._capacity + awaited)
        return self._free.pop()

    def _grow(self, capacity: int) -> None:
        self._free = list(range(capacity - 1, self._capacity - 1, -1)) + self._free
        self._capacity = capacity
