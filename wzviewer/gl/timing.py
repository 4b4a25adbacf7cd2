"""How long the GPU itself works on a frame: the CPU only hands the work over, and goes on."""

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl


class FrameTimer:
    """Times frames with timer queries, and reads each one a frame later, so that nothing waits.

    Args:
        ctx: to measure in.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self._queries = [ctx.query(time=True) for _ in range(2)]
        self._frames = 0

    @property
    def seconds(self) -> float:
        """What the frame before the last one took, s; 0 before there is one."""
        if self._frames < 2:
            return 0.0
        return 1e-9 * float(self._queries[self._frames % 2].elapsed)

    @contextmanager
    def frame(self) -> Iterator[None]:
        """Measures what is drawn inside."""
        with self._queries[self._frames % 2]:
            yield
        self._frames += 1
