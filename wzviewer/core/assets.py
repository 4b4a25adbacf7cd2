"""Where the bundled demo picture lies, in a checkout and in an installed wheel."""

from pathlib import Path

import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.errors import InputError

FOLDERS = (Path(__file__).parents[1] / "assets", Path(__file__).parents[2] / "assets")


def demo_picture() -> Path:
    """The demo photograph, 1088x720.

    Raises:
        InputError: when the installation is incomplete.
    """
    return _find("meadow.png")


def demo_truth() -> tuple[FloatArray, BoolArray]:
    """True depth (h, w) float32 of the demo picture, median 1, and its sky (h, w) bool."""
    with np.load(_find("meadow_depth.npz"), allow_pickle=False) as data:
        return data["depth"].astype(np.float32), data["sky"].astype(bool)


def _find(name: str) -> Path:
    for folder in FOLDERS:
        if (folder / name).is_file():
            return folder / name
    raise InputError(name, "is missing from the installation", "Install wzviewer again.")
