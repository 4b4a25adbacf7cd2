"""Surfel records on the GPU: one growing buffer in pages, written once.

A page holds the records of one chunk (`PAGE_SURFELS` consecutive surfels of one level).  A level
that is staged is packed and uploaded page by page, as much as a frame's budget allows; it is shown
when its last page has arrived, and only then are the pages of the version before it given back.
Pages of other levels are never touched.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import moderngl
import numpy as np

from wzviewer.core.surfels import Surfels
from wzviewer.core.types import IntArray
from wzviewer.gl.records import RECORD_BYTES, pack

PAGE_SURFELS = 16384
PAGE_BYTES = PAGE_SURFELS * RECORD_BYTES
GROWTH = 1.25  # capacity beyond the need, so that a preview in pieces does not copy each time


@dataclass(eq=False)
class _Version:
    """One version of a level's surfels and the pages that hold it."""

    surfels: Surfels
    slot: int
    pages: list[int] = field(default_factory=list)

    @property
    def num_pages(self) -> int:
        return -(-len(self.surfels) // PAGE_SURFELS)

    def piece(self, page: int) -> Surfels:
        return self.surfels.take(slice(page * PAGE_SURFELS, (page + 1) * PAGE_SURFELS))


class SurfelBuffer:
    """Pages of surfel records.

    Attributes:
        buffer: the `moderngl.Buffer`, or None while empty; another object after growth.
        generation: grows when what is shown changes.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self.buffer: moderngl.Buffer | None = None
        self.generation = 0
        self._capacity = 0
        self._free: list[int] = []
        self._shown: dict[int, _Version] = {}
        self._staged: dict[int, _Version] = {}

    @property
    def capacity_surfels(self) -> int:
        """Records that fit into the pages that exist."""
        return self._capacity * PAGE_SURFELS

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return self._capacity * PAGE_BYTES

    def levels(self) -> Iterable[int]:
        """Indices of the levels that are shown or staged."""
        return self._shown.keys() | self._staged.keys()

    def shown(self, index: int) -> Surfels | None:
        """Surfels of the version that is complete on the GPU, or None."""
        version = self._shown.get(index)
        return version.surfels if version else None

    def latest(self, index: int) -> Surfels | None:
        """Surfels of the newest version, complete or not."""
        version = self._staged.get(index) or self._shown.get(index)
        return version.surfels if version else None

    def first_records(self, index: int) -> IntArray:
        """Record number at which each chunk of a shown level starts, (chunks,) int32."""
        return np.array(self._shown[index].pages, np.int32) * np.int32(PAGE_SURFELS)

    def stage(self, index: int, surfels: Surfels, slot: int) -> None:
        """Queues a level, or the next version of one, for `upload`."""
        self._drop(self._staged.pop(index, None))
        self._staged[index] = _Version(surfels, slot)

    def remove(self, index: int) -> None:
        """Gives the pages of a level back."""
        self._drop(self._staged.pop(index, None))
        if (version := self._shown.pop(index, None)) is not None:
            self._drop(version)
            self.generation += 1

    def upload(self, budget_bytes: int | None = None) -> int:
        """Packs and writes staged pages, at least one, until the budget is spent.

        Args:
            budget_bytes: None writes everything.

        Returns:
            Bytes written.
        """
        written = 0
        for index, version in list(self._staged.items()):
            while len(version.pages) < version.num_pages:
                if budget_bytes is not None and written and written + PAGE_BYTES > budget_bytes:
                    return written
                written += self._write_next(version)
            self._show(index)
        return written

    def release(self) -> None:
        """Frees the GPU memory."""
        if self.buffer is not None:
            self.buffer.release()
        self.buffer, self._capacity = None, 0
        self._free, self._shown, self._staged = [], {}, {}

    def _write_next(self, version: _Version) -> int:
        page = self._take_page(version.num_pages - len(version.pages))
        data = pack(version.piece(len(version.pages)), version.slot).tobytes()
        assert self.buffer is not None  # _take_page grew it
        self.buffer.write(data, offset=page * PAGE_BYTES)
        version.pages.append(page)
        return len(data)

    def _show(self, index: int) -> None:
        self._drop(self._shown.get(index))
        self._shown[index] = self._staged.pop(index)
        self.generation += 1

    def _drop(self, version: _Version | None) -> None:
        if version is not None:
            self._free = sorted(self._free + version.pages, reverse=True)

    def _take_page(self, num_wanted: int) -> int:
        if not self._free:
            self._grow(self._capacity + num_wanted)
        return self._free.pop()

    def _grow(self, num_pages: int) -> None:
        capacity = max(num_pages, int(self._capacity * GROWTH))
        grown = self.ctx.buffer(reserve=capacity * PAGE_BYTES)
        if self.buffer is not None:
            self.ctx.copy_buffer(grown, self.buffer, self._capacity * PAGE_BYTES)
            self.buffer.release()
        self.buffer = grown
        self._free = list(range(capacity - 1, self._capacity - 1, -1)) + self._free
        self._capacity = capacity
        self.generation += 1
