"""Levels on the wire and in files: taken apart into packed arrays, and put together again."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.messages import Json
from wzviewer.core.packing import PACKED_DTYPES, Packed, check_packed, pack, unpack
from wzviewer.core.records import header_fields
from wzviewer.core.scene import PHOTO, Level
from wzviewer.core.surfels import SURFEL_SHAPES, Surfels
from wzviewer.core.types import FloatArray

CHUNK_SURFELS = 1 << 14  # four times as many at once take seventeen times as long: fresh memory for each step
UNPACKED_SURFELS = 1 << 14  # at once: what stays in the cache is unpacked in half the time
MAX_SURFELS = 64 << 20  # of one level
COVERAGE = "coverage"  # u8 on the wire and in the file: 1/255 of a feathered border is invisible
MAP_PREFIX = "map:"

Arrays = dict[str, NDArray[Any]]


def surfel_arrays(surfels: Surfels) -> Arrays:
    """Packs surfels for the wire or the file."""
    coverage = np.rint(surfels.coverage * 255.0).astype(np.uint8)
    return {**pack(surfels), COVERAGE: coverage}


def surfels_of(arrays: Arrays, camera: Camera, frame: LevelFrame) -> Surfels:
    """Restores surfels; s_native follows from the position and C_i (Eq. 1).

    Raises:
        ValueError: when an array is missing or malformed.
    """
    packed: Packed = {k: arrays[k] for k in PACKED_DTYPES if k in arrays}
    check_packed(packed)
    coverage = arrays.get(COVERAGE)
    if coverage is None or coverage.dtype != np.uint8 or coverage.shape != (len(packed["means"]),):
        raise ValueError("surfel array 'coverage' is missing or malformed")
    view, total = AnchoredView.expand(camera, frame), len(coverage)
    if total <= UNPACKED_SURFELS:
        return _unpacked(packed, coverage, view)
    joined = {k: np.empty((total, *s), np.float32) for k, s in SURFEL_SHAPES.items()}
    for start in range(0, total, UNPACKED_SURFELS):
        part = slice(start, start + UNPACKED_SURFELS)
        piece = _unpacked({k: v[part] for k, v in packed.items()}, coverage[part], view)
        for name, array in piece.arrays().items():
            joined[name][part] = array
    return Surfels(**joined)


def _unpacked(packed: Packed, coverage: NDArray[Any], view: AnchoredView) -> Surfels:
    native = np.exp2(view.log_scale(packed["means"]))
    return unpack(packed, native, coverage.astype(np.float32) / np.float32(255.0))


def finished(surfels: Surfels, camera: Camera, frame: LevelFrame) -> Surfels:
    """Returns surfels as they will be after the wire or the file: what a commit freezes."""
    return surfels_of(surfel_arrays(surfels), camera, frame)


def replay_arrays(level: Level) -> Arrays:
    """All arrays of a finished level, for `ReplayLevel`."""
    maps = {MAP_PREFIX + k: v for k, v in level.maps.items()}
    return {**surfel_arrays(level.surfels), "image": level.image, "relief": level.relief, **maps}


def level_of(header: Json, arrays: Arrays, surfels: Surfels | None = None) -> Level:
    """Restores a level from its header and arrays.

    Raises:
        ValueError: when the header or an array is malformed.
    """
    fields = header_fields(header)
    image, relief = arrays.get("image"), arrays.get("relief")
    if image is None or image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise ValueError("level has no image")
    if relief is None or relief.dtype != np.float32 or relief.shape != image.shape[:2]:
        raise ValueError("level has no relief of the image's size")
    if surfels is None:
        surfels = surfels_of(arrays, fields["camera"], fields["frame"])
    maps = {k.removeprefix(MAP_PREFIX): v for k, v in arrays.items() if k.startswith(MAP_PREFIX)}
    if PHOTO in maps and not _is_finer(maps[PHOTO], image):
        raise ValueError("the photograph does not fit its level")
    return Level(surfels=surfels, image=image, relief=relief, maps=maps, **fields)


def _is_finer(photo: NDArray[Any], image: NDArray[Any]) -> bool:
    is_picture = photo.dtype == np.uint8 and photo.ndim == 3 and photo.shape[2] == 3
    return is_picture and all(a >= b for a, b in zip(photo.shape, image.shape, strict=True))


class LevelAssembly:
    """Puts a level together from `LevelBegun`, chunks and `LevelCommitted`.

    Each chunk goes at once to where it stays: joining a million surfels at the end would cost a frame.
    """

    def __init__(self) -> None:
        self._level: Level | None = None
        self._arrays: dict[str, FloatArray] = {}
        self._count = self._total = 0

    def begin(self, header: Json, arrays: Arrays) -> None:
        """Takes the header and the preview's image and relief."""
        self._level = level_of(header, arrays, Surfels.empty())
        self._count = self._total = 0

    def add(self, start: int, total: int, arrays: Arrays) -> bool:
        """Takes a chunk; returns whether the revision is complete.

        Raises:
            ValueError: when chunks come out of order or exceed the total.
        """
        level = self._require()
        if start == 0:
            self._count, self._total = 0, total
        surfels = surfels_of(arrays, level.camera, level.frame)
        end = start + len(surfels)
        if start != self._count or end > total or total != self._total or total > MAX_SURFELS:
            raise ValueError(f"chunk at {start} of {total} is out of order")
        if start == 0:
            self._arrays = {k: np.empty((total, *s), np.float32) for k, s in SURFEL_SHAPES.items()}
        for name, array in surfels.arrays().items():
            self._arrays[name][start:end] = array
        self._count = end
        if end < total:
            return False
        self._level, self._arrays = level.with_surfels(Surfels(**self._arrays)), {}
        return True

    def level(self) -> Level:
        """The last complete revision."""
        return self._require()

    def finish(self, header: Json, arrays: Arrays) -> Level:
        """Returns the final level."""
        return replace(level_of(header, arrays, self._require().surfels))

    def _require(self) -> Level:
        if self._level is None:
            raise ValueError("a level was not begun")
        return self._level
