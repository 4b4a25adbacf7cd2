"""Draws surfels of several levels on the CPU: the steps of a frame over arrays that are kept.

::

    begin(capacity)
    add(surfels, view, depth row, weights)*     project, weigh, key: rows in the order of the calls
    sort()                                      nearest first
    draw(background)                            bin, composite  ──► planes of colour, transmittance
    median()                                    of what was drawn     ──► places

A place counts through everything that was added.  Rows are what may be seen of it, in the same order, so
ties in depth go by (call, index).
"""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray, IntArray
from wzviewer.kernels import binning, forward, projection
from wzviewer.kernels.footprints import BY_CAMERAS, GIVEN, PLAIN, Places, in_view, look, splat, tasks_of

VIEW_MAX = 1e30  # of a number in the view vector; beyond it the camera sits in the anchor plane
_INPUTS = ("means", "quats", "scales", "opacities", "colors", "native_scales", "coverage")
_NOTHING = np.empty(0, np.float32)
_NO_TEXELS = np.zeros((2, 4), np.float32)
_ROOM = 1.25  # capacity beyond the need


@dataclass(frozen=True, eq=False)
class Planes:
    """An image on whole tiles, H >= h and W >= w; overwritten by the next frame.

    Attributes:
        color: (3, H, W) float32, over the background.
        through: (H, W) float32, transmittance.
    """

    color: FloatArray
    through: FloatArray


class Splatter:
    """The arrays of a frame, reused by the next one: fresh memory would cost a page fault each 4 KB."""

    def __init__(self) -> None:
        self._count = self._num_keys = self._num_places = 0
        self._first_rows: list[Places] = []  # of the tasks
        self._moved: list[Places] = []  # place less row, of the surfels of each task
        self._linear = False
        self._order = np.empty(0, np.uint32)
        self._size = (0, 0)
        self._lists: tuple[binning.Offsets, binning.Indices] | None = None
        self._planes = Planes(np.empty((3, 0, 0), np.float32), np.empty((0, 0), np.float32))
        self._reserve(0)

    @property
    def num_bytes(self) -> int:
        """Memory of the arrays, bytes."""
        arrays = (self._rows, self._colors, self._weights, self._bits, self._keys, self._planes.color)
        return sum(a.nbytes for a in arrays) + self._planes.through.nbytes

    @property
    def num_drawn(self) -> int:
        """Surfels of the frame that may be seen."""
        return self._num_keys

    def begin(self, capacity: int, width: int, height: int) -> None:
        """Starts a frame.

        Args:
            capacity: surfels that will be added.
            width: image width, px.
            height: image height, px.
        """
        self._count = self._num_keys = self._num_places = 0
        self._first_rows, self._moved = [], []
        self._size, self._lists = (width, height), None
        if capacity > len(self._rows):
            self._reserve(int(capacity * _ROOM))

    def add(
        self,
        surfels: Surfels,
        view: AnchoredView,
        depth_row: FloatArray,
        pieces: list[tuple[slice, int]] | None = None,
        texels: FloatArray | None = None,
        weights: FloatArray | None = None,
        contribution_min: float = 0.0,
    ) -> None:
        """Projects surfels of one level.

        Args:
            surfels: (n) in the level's frame.
            view: the camera about the level's anchor.
            depth_row: (4,) from `core.reference.depth_row`.
            pieces: of the surfels, each with where its weights come from (`footprints`); None: all, by
                what else is given.
            texels: from `Modulation.texels`, to find weights.
            weights: (n,) Eq. 3 weights, if they are known; neither these nor texels: 1.
            contribution_min: surfels whose opacity times area, px^2, is less are left out.
        """
        kind = BY_CAMERAS if texels is not None else PLAIN if weights is None else GIVEN
        pieces = [(slice(0, len(surfels)), kind)] if pieces is None else pieces
        packed, arrays = projection.view_vector(view), surfels.arrays()
        all_tasks = tasks_of(pieces, self._num_places)
        self._num_places += sum(piece.stop - piece.start for piece, _ in pieces)
        seen = np.zeros(len(all_tasks), bool)
        if np.all(np.abs(packed) < VIEW_MAX):
            look(arrays["means"], arrays["scales"], all_tasks, packed, *self._size, seen)
        tasks, moved = in_view(all_tasks, seen, self._count)
        self._count += int((tasks[:, 1] - tasks[:, 0]).sum())
        self._first_rows.append(tasks[:, 2])
        self._moved.append(moved)
        given = _NOTHING if weights is None else np.ascontiguousarray(weights, np.float32)
        covers = _NO_TEXELS if texels is None else texels
        out = (self._rows, self._colors, self._weights, self._bits)
        where = (packed, covers, depth_row, *self._size, contribution_min)
        splat(*(arrays[name] for name in _INPUTS), given, tasks, *where, *out)

    def sort(self) -> binning.Indices:
        """Orders the rows that may be seen, nearest first, (m,) uint32."""
        rows, bits = self._rows[: self._count], self._bits[: self._count]
        self._num_keys = binning.visible_keys(rows, bits, self._keys)
        self._order = binning.sorted_indices(self._keys[: self._num_keys])
        return self._order

    def draw(self, background: tuple[float, float, float], linear: bool) -> Planes:
        """Composites what was added and sorted.

        Args:
            background: sRGB colour behind everything.
            linear: Eq. 2 as printed instead of the power law.
        """
        width, height = self._size
        rows = self._rows[: self._count]
        self._lists, self._linear = binning.bin_tiles(rows, self._order, width, height), linear
        planes = self._tiled(width, height)
        behind = np.asarray(background, np.float32)
        weights, colors = self._weights[: self._count], self._colors[: self._count]
        forward.composite(rows, colors, weights, linear, *self._lists, behind, *planes.color, planes.through)
        return planes

    def median(self) -> IntArray:
        """Place of the surfel at which transmittance crosses 1/2, (h, w) int32; -1 where none; after `draw`.

        Places count through what was added, in the order of the calls.

        Raises:
            ValueError: before `draw`.
        """
        if self._lists is None:
            raise ValueError("draw the frame before asking for its median")
        width, height = self._size
        index = np.empty(self._planes.through.shape, np.int32)
        laws = (self._weights[: self._count], self._linear)
        through = np.empty(index.shape, np.float32)
        forward.median_index(self._rows[: self._count], *laws, *self._lists, index, through)
        return self._places_of(index[:height, :width])

    def _places_of(self, rows: IntArray) -> IntArray:
        """Maps rows, (h, w), to places; -1 stays."""
        found = rows >= 0
        if not found.any():
            return rows.copy()
        first_rows, moved = np.concatenate(self._first_rows), np.concatenate(self._moved)
        task = np.searchsorted(first_rows, np.where(found, rows, 0), side="right") - 1
        return np.where(found, rows + moved[task], -1).astype(np.int32)

    def _reserve(self, capacity: int) -> None:
        self._rows = np.empty((capacity, 8), np.float32)
        self._colors = np.empty((capacity, 3), np.float32)
        self._weights = np.empty(capacity, np.float32)
        self._bits = np.empty(capacity, np.uint32)
        self._keys = np.empty(capacity, np.uint64)

    def _tiled(self, width: int, height: int) -> Planes:
        t = binning.TILE
        shape = (-(-height // t) * t, -(-width // t) * t)
        if self._planes.through.shape != shape:
            self._planes = Planes(np.empty((3, *shape), np.float32), np.empty(shape, np.float32))
        return self._planes


def warm_up() -> None:
    """Compiles every kernel of a frame, or loads it from the cache, on a few surfels."""
    from wzviewer.core.anchor import LevelFrame
    from wzviewer.core.camera import Camera
    from wzviewer.core.opacity import Modulation
    from wzviewer.core.reference import depth_row, focus_of
    from wzviewer.kernels import presenting

    camera = Camera.initial(8, 8)
    frame = LevelFrame.of_camera(camera, 1.0)
    view, splatter = AnchoredView.expand(camera, frame), Splatter()
    row, texels = depth_row(view, frame, focus_of(camera, [frame])), Modulation(None, ()).texels()
    splatter.begin(4, 8, 8)
    splatter.add(Surfels.empty(4), view, row, None, texels, None, 1.0)
    splatter.sort()
    planes = splatter.draw((0.0, 0.0, 0.0), False)
    splatter.median()
    presenting.interleave(planes.color, planes.through, np.empty((8, 8, 4), np.float32))
    presenting.present(
        planes.color, planes.through, np.zeros(4, np.float32), 1.0, np.empty((8, 8, 4), np.uint8)
    )
    small, large = np.zeros((4, 4), np.uint32), np.empty((8, 8), np.uint32)
    presenting.fit(small, large, False, True)
