"""The exact back-to-front order of the surfels of a frame: pure functions, no OpenGL.

The key of a surfel is `core.reference`'s: the depth of its centre relative to the frame's focus, in
the focus's pixels, so that a x8^12 zoom still tells neighbours apart.  Keys are float32 bits packed
above the index, so one sort of uint64 is exact and total: equal depths go by index, lower in front.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.reference import DEPTH_QUANTUM, Focus, depth_row
from wzviewer.core.types import FloatArray

UIntArray = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class Run:
    """Consecutive surfels of one level that survived culling.

    Attributes:
        columns: (3, n) float32, means as columns.
        view: the rendering camera about the level's anchor.
        frame: the level's frame.
        first_record: where the run starts in the surfel buffer.
        level: index of the level.
        first_surfel: where the run starts in the level.
        stride: records and surfels advance by this much.
    """

    columns: FloatArray
    view: AnchoredView
    frame: LevelFrame
    first_record: int
    level: int
    first_surfel: int
    stride: int = 1

    def __len__(self) -> int:
        return self.columns.shape[1]

    def records(self) -> UIntArray:
        """Record numbers, (n,)."""
        stop = self.first_record + self.stride * len(self)
        return np.arange(self.first_record, stop, self.stride, dtype=np.uint32)


def relative_depths(columns: FloatArray, view: AnchoredView, frame: LevelFrame, focus: Focus) -> FloatArray:
    """Depth behind the focus in the focus's pixels, quantised, (n,) float32.

    Args:
        columns: (3, n) means of one level as columns.
        view: the rendering camera about the level's anchor.
        frame: the level's frame.
        focus: of the rendered view.
    """
    row = depth_row(view, frame, focus)
    depth = row[0] * columns[0]
    depth += row[1] * columns[1]
    depth += row[2] * columns[2]
    depth += row[3]
    depth *= np.float32(1.0 / DEPTH_QUANTUM)
    np.rint(depth, out=depth)
    depth += np.float32(0.0)  # -0 would sort below +0
    return depth


def sortable_bits(values: FloatArray) -> UIntArray:
    """Maps float32 (n,) to uint32 that sort alike."""
    bits = values.view(np.uint32)
    sign = (bits >> np.uint32(31)).astype(bool)
    return bits ^ np.where(sign, np.uint32(0xFFFFFFFF), np.uint32(0x80000000))


def front_to_back(depth: FloatArray) -> UIntArray:
    """Indices (n,) by increasing depth; ties by index."""
    keys = sortable_bits(depth).astype(np.uint64) << np.uint64(32)
    keys |= np.arange(len(depth), dtype=np.uint64)
    keys.sort()
    return keys.astype(np.uint32)


def order_runs(runs: Sequence[Run], focus: Focus) -> UIntArray:
    """Record numbers of all runs, nearest first, (n,) uint32.

    Args:
        runs: in scene order: level by level, and by index within a level (this settles ties).
        focus: of the rendered view.
    """
    total = sum(len(run) for run in runs)
    depth, records = np.empty(total, np.float32), np.empty(total, np.uint32)
    start = 0
    for run in runs:
        piece = slice(start, start + len(run))
        depth[piece] = relative_depths(run.columns, run.view, run.frame, focus)
        records[piece] = run.records()
        start += len(run)
    return records[front_to_back(depth)]
