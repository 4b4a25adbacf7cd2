"""Views, covers and modulations of many levels, one below the other in arrays (for `cull`)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Cover, Modulation
from wzviewer.core.types import DoubleArray, IntArray

Index = NDArray[Any]  # of rows: integers or a mask


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames of levels (n), stacked.

    Attributes:
        origins: (n, 3) float64.
        axes: (n, 3, 3) float64.
        units: (n,) float64.
    """

    origins: DoubleArray
    axes: DoubleArray
    units: DoubleArray

    @classmethod
    def stack(cls, frames: Sequence[LevelFrame]) -> "Frames":
        """Stacks frames."""
        origins, axes = [f.origin for f in frames], [f.axes for f in frames]
        units = np.array([f.unit for f in frames])
        return cls(np.array(origins).reshape(-1, 3), np.array(axes).reshape(-1, 3, 3), units)


@dataclass(frozen=True, eq=False)
class Views:
    """What `AnchoredView` is for one anchor, for many (n).

    Attributes:
        rows: (n, 3, 4) float64.
        depth: (n,) float64, world units.
    """

    rows: DoubleArray
    depth: DoubleArray

    @classmethod
    def expand(cls, camera: Camera, frames: Frames) -> "Views":
        """Expands a camera about anchors (`AnchoredView.expand`, for all at once)."""
        a = camera.to_camera(frames.origins)
        M = camera.rotation @ np.swapaxes(frames.axes, 1, 2)
        z = np.where(np.abs(a[:, 2]) > 1e-300, a[:, 2], 1e-300)
        r = frames.units / z
        rows = np.empty((len(r), 3, 4))
        for axis, (focal, centre) in enumerate(((camera.fx, camera.cx), (camera.fy, camera.cy))):
            q = a[:, axis] / z
            rows[:, axis, :3] = (focal * r)[:, None] * (M[:, axis] - q[:, None] * M[:, 2])
            rows[:, axis, 3] = focal * q + centre
        rows[:, 2, :3] = r[:, None] * M[:, 2]
        rows[:, 2, 3] = np.log2(np.abs(z) / (camera.focal_px * frames.units))
        return cls(rows, a[:, 2])

    def finer(self, factor: float) -> "Views":
        """Returns the views with pixel scales as of ``factor`` times the resolution."""
        if factor == 1.0:
            return self
        rows = self.rows.copy()
        rows[:, 2, 3] -= np.log2(factor)
        return Views(rows, self.depth)

    @property
    def side(self) -> DoubleArray:
        """+1 where the anchor lies in front of the camera, -1 behind, (n,)."""
        return np.where(self.depth > 0.0, 1.0, -1.0)

    def take(self, index: Index) -> "Views":
        """Returns some views."""
        return Views(self.rows[index], self.depth[index])


@dataclass(frozen=True, eq=False)
class Covers:
    """What `Cover` is for one, for many (n): one for each chunk that they are compared with.

    Attributes:
        view: their cameras.
        parent_rows: (n, 4).
        size_px: (n, 3) width, height, feather.
    """

    view: Views
    parent_rows: DoubleArray
    size_px: DoubleArray

    @classmethod
    def stack(cls, covers: Sequence[Cover]) -> "Covers":
        """Stacks covers."""
        rows = np.array([c.view.rows for c in covers]).reshape(-1, 3, 4)
        parents = np.array([c.parent_rows for c in covers]).reshape(-1, 4)
        sizes = np.array([c.size_px for c in covers]).reshape(-1, 3)
        return cls(Views(rows, np.array([c.view.depth for c in covers])), parents, sizes)

    def take(self, index: Index) -> "Covers":
        """Returns some covers."""
        return Covers(self.view.take(index), self.parent_rows[index], self.size_px[index])


@dataclass(frozen=True, eq=False)
class Acting:
    """What `Modulation` is for the chunks of one level, for chunks (c) of many.

    Attributes:
        parent_rows: (c, 4); nan where there is no parent.
        chunks: (p,) places of chunks: a pair of a chunk and a cover that may act there.
        covers: (p) of the pairs.
    """

    parent_rows: DoubleArray
    chunks: IntArray
    covers: Covers

    @classmethod
    def of(cls, modulation: "Modulation | Acting", num_chunks: int) -> "Acting":
        """Returns the modulation of one level for all its chunks, and another as it is."""
        if isinstance(modulation, Acting):
            return modulation
        row = np.full(4, np.nan) if modulation.parent_rows is None else modulation.parent_rows
        covers, count = Covers.stack(modulation.covers), len(modulation.covers)
        chunks = np.repeat(np.arange(num_chunks, dtype=np.int32), count)
        covers = covers.take(np.tile(np.arange(count, dtype=np.int32), num_chunks))
        return cls(np.tile(row, (num_chunks, 1)), chunks, covers)
