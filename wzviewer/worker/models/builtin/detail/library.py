"""The library of tiles: made when first needed, kept in memory as int8, and on disk where that is allowed."""

import os
import tempfile
from pathlib import Path

import numpy as np
import platformdirs

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.noise import normalized, periodic_blur
from wzviewer.worker.models.builtin.detail.octaves import CLUMPED, OCTAVES, SPARSE, SPECTRA, evened
from wzviewer.worker.models.builtin.detail.tiles import TILE_MAKERS

TILE_PX = 768
VERSION = 22  # raise it whenever a tile changes
INT8_PER_DEVIATION = 36.0  # +-3.5 deviations fit


class TileLibrary:
    """Seamless ``(768, 768)`` textures by material name; all of them together take 7 MB.

    Args:
        folder: where tiles are kept between runs; by default the user's cache folder.  A folder that cannot
            be
            read or written is no error: the tiles are then made again.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder
        self._tiles: dict[str, np.ndarray] = {}

    def tile(self, name: str) -> np.ndarray:
        """Returns the int8 tile, 36 steps per deviation; do not write to it.

        Raises:
            KeyError: there is no such tile.
        """
        if name not in self._tiles:
            self._tiles[name] = self._load(name)
        return self._tiles[name]

    def _load(self, name: str) -> np.ndarray:
        maker = TILE_MAKERS[name]
        path = self._path(name)
        stored = _read(path)
        if stored is None:
            rng = np.random.default_rng([VERSION, *name.encode()])
            stored = quantized(evened_tile(name, maker(TILE_PX, rng)))
            _write(path, stored)
        return stored

    def _path(self, name: str) -> Path:
        folder = self._folder or Path(platformdirs.user_cache_dir("wzviewer")) / "tiles"
        return folder / f"{name}-{TILE_PX}-v{VERSION}.npy"


def evened_tile(name: str, tile: FloatArray) -> FloatArray:
    """Returns the tile with its octaves in the proportion that the material calls for, see `evened`."""
    evenness = 0.0 if name in SPARSE else CLUMPED if name in SPECTRA else 1.0
    return evened(tile, SPECTRA.get(name, OCTAVES), evenness=evenness, blur=periodic_blur)


def quantized(tile: FloatArray) -> np.ndarray:
    """Returns the tile as int8."""
    return np.clip(np.round(normalized(tile) * INT8_PER_DEVIATION), -127, 127).astype(np.int8)


def _read(path: Path) -> np.ndarray | None:
    try:
        tile = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    return tile if tile.dtype == np.int8 and tile.shape == (TILE_PX, TILE_PX) else None


def _write(path: Path, tile: np.ndarray) -> None:
    """Writes whole or not at all; another process may be doing the same."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                np.save(file, tile, allow_pickle=False)
            os.replace(temporary, path)
        except OSError:
            Path(temporary).unlink(missing_ok=True)
    except OSError:
        return
