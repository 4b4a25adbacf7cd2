"""Surfel records on the GPU: the pages of `pages` in one growing buffer, each written once."""

import moderngl

from wzviewer.core.surfels import Surfels
from wzviewer.gl.pages import PAGE_BYTES, Pages
from wzviewer.gl.records import pack

GROWTH = 1.25  # capacity beyond the need, so that a preview in pieces does not copy each time


class SurfelBuffer(Pages):
    """Pages of surfel records.

    Attributes:
        buffer: the `moderngl.Buffer`, or None while empty; another object after growth.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        super().__init__()
        self.ctx = ctx
        self.buffer: moderngl.Buffer | None = None

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return self._capacity * PAGE_BYTES

    def release(self) -> None:
        """Frees the GPU memory."""
        if self.buffer is not None:
            self.buffer.release()
        self.buffer = None
        super().release()

    def _write(self, page: int, piece: Surfels, slot: int) -> None:
        assert self.buffer is not None  # taking the page grew it
        self.buffer.write(pack(piece, slot).tobytes(), offset=page * PAGE_BYTES)

    def _grow(self, capacity: int) -> None:
        capacity = max(capacity, int(self._capacity * GROWTH))
        grown = self.ctx.buffer(reserve=capacity * PAGE_BYTES)
        if self.buffer is not None:
            self.ctx.copy_buffer(grown, self.buffer, self._capacity * PAGE_BYTES)
            self.buffer.release()
        self.buffer = grown
        super()._grow(capacity)
        self.generation += 1
