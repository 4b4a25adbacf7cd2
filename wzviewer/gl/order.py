"""The exact back-to-front order of the surfels of a frame: pure functions, no OpenGL.

The key of a surfel is `core.reference`'s: the depth of its centre relative to the frame's focus, in
the focus's pixels, so that a x8^12 zoom still tells neighbours apart.  Keys are float32 bits packed
above the index, so one sort of uint64 is exact and total: equal depths go by index, lower in front.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.reference import DEPTH_QUANTUM, Focus, depth_row, setback
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray

if TYPE_CHECKING:
    from wzviewer.gl.visible import SurfelSet

UIntArray = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class Run:
    """Consecutive surfels of one set that survived culling.

    Attributes:
        source: the set.
        piece: where the run lies in it.
        view: the rendering camera about the level's anchor.
        level: that the set belongs to.
        first_record: where the run starts in the surfel buffer.
        is_big: whether footprints may be too large for points.
        is_plain: whether Eq. 3 is certain to give all of them w = 1.
    """

    source: "SurfelSet"
    piece: slice
    view: AnchoredView
    level: Level
    first_record: int
    is_big: bool = False
    is_plain: bool = False

    def __len__(self) -> int:
        return int(self.piece.stop - self.piece.start)

    @property
    def columns(self) -> FloatArray:
        """(3, n) float32, means as columns."""
        return self.source.columns[:, self.piece]

    @property
    def surfels(self) -> Surfels:
        """The surfels, (n)."""
        return self.source.surfels.take(self.piece)

    @property
    def frame(self) -> LevelFrame:
        """The level's frame."""
        return self.level.frame

    def depth_row(self, focus: Focus) -> FloatArray:
        """Returns `core.reference.depth_row` of the run, (4,) float32."""
        return depth_row(self.view, self.frame, focus, setback(self.level.camera))

    def records(self) -> UIntArray:
        """Record numbers, (n,)."""
        return np.arange(self.first_record, self.first_record + len(self), dtype=np.uint32)


def relative_depths(columns: FloatArray, row: FloatArray) -> FloatArray:
    """Depth behind the focus in the focus's pixels, quantised, (n,) float32.

    Args:
        columns: (3, n) means of one level as columns.
        row: (4,) float32, `Run.depth_row`.
    """
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


def order_places(runs: Sequence[Run], focus: Focus) -> UIntArray:
    """Places in the concatenated runs, nearest first, (n,) uint32.

    Args:
        runs: in scene order: level by level, and by index within a level (this settles ties).
        focus: of the rendered view.
    """
    depth = np.empty(sum(len(run) for run in runs), np.float32)
    start = 0
    for run in runs:
        depth[start : start + len(run)] = relative_depths(run.columns, run.depth_row(focus))
        start += len(run)
    return front_to_back(depth)


def order_runs(runs: Sequence[Run], focus: Focus) -> UIntArray:
    """Record numbers of all runs, nearest first, (n,) uint32; see `order_places`."""
    if not runs:
        return np.empty(0, np.uint32)
    return np.concatenate([run.records() for run in runs])[order_places(runs, focus)]
