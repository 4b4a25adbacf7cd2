"""How large a thing is drawn: its natural size, what a pixel is worth there, and what is still seen.

A picture has no scale of its own.  A landscape is taken as seen from eye height above level ground
(Hoiem, Efros, Hebert 2008): what stands on a row of the ground as far below the horizon as the eye is
high.  Only the order of depths counts.  Indoors the usual distance of a room counts as much.  A close-up
says nothing: there, sizes are the prompt's.

Truth would make a robin in a wide view a dot, and what is read of a picture may be off by four.  So a size
is drawn between the usual share of the view and the natural one, never below a third of the usual, and
deeper views are smaller worlds.  What is smaller than a hand is asked for to be looked at: a butterfly on
a petal fills the view as ever.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.words import USUAL_SIZE

NATURAL_M: dict[str, float] = {
    "ladybug": 0.008,
    "beetle": 0.025,
    "butterfly": 0.09,
    "blue morpho": 0.13,
    "cabbage white": 0.055,
    "bee": 0.015,
    "ant": 0.01,
    "spider": 0.03,
    "bird": 0.14,
    "sparrow": 0.15,
    "blue tit": 0.12,
    "cardinal": 0.22,
    "canary": 0.13,
    "crow": 0.47,
    "fish": 0.25,
    "goldfish": 0.15,
    "clownfish": 0.10,
    "trout": 0.40,
    "lizard": 0.18,
    "gecko": 0.20,
    "cat": 0.50,
    "snail": 0.05,
    "conch shell": 0.20,
    "starfish": 0.20,
    "mushroom": 0.12,
    "flower": 0.05,
    "sunflower": 0.25,
    "poppy": 0.07,
    "cherry blossom": 0.035,
    "leaf": 0.08,
    "maple leaf": 0.12,
    "acorn": 0.03,
    "feather": 0.15,
    "pebble": 0.08,
    "water drop": 0.01,
    "crystal": 0.15,
    "coin": 0.025,
    "key": 0.07,
    "lego brick": 0.032,
}
"""The longest side of each object, metres."""

HAND_M = 0.1  # what is smaller has its usual size in any view: beside a person it would not be seen
LEAST_OF_USUAL = 0.35  # of the usual size, unless it is asked for smaller
LEAST_SHARE = 0.06  # of a view's height: less is a speck
_EYE_M = {"landscape": 2.4, "indoor": 1.6}  # over land often from a rise
_ROOM_M = 2.0  # metres a unit of depth (the median depth) where there is no horizon
_BELOW = 0.03  # of the height: rows closer to the horizon say little
_TRUTH = 0.65  # 1 draws natural sizes, 0 the usual share of the view


@dataclass(frozen=True, eq=False)
class Ruler:
    """Metres in a world unit by depth; beyond its ends as at its ends.

    Attributes:
        depth: (n,) ascending, world units.
        metres: (n,) in a world unit there.
    """

    depth: DoubleArray
    metres: DoubleArray

    def __call__(self, depth: DoubleArray) -> DoubleArray:
        """Returns metres in a world unit at depths; nan where those are."""
        return np.asarray(np.interp(depth, self.depth, self.metres))

    @classmethod
    def of(cls, depth: DoubleArray, sky: BoolArray | None, focal_px: float, kind: str) -> "Ruler | None":
        """Reads a photograph.

        Args:
            depth: (h, w) world units.
            sky: (h, w); None if there is none.
            focal_px: its focal length.
            kind: "landscape", "macro" or "indoor".

        Returns:
            None if it says nothing about its scale.
        """
        if kind not in _EYE_M:
            return None
        z = np.array(depth, np.float64)
        z[~np.isfinite(z) if sky is None else ~np.isfinite(z) | sky.astype(bool)] = np.nan
        horizon = _horizon(z.shape, sky)
        rows = np.arange(int(horizon + _BELOW * len(z)) + 1, len(z))
        rows = rows[np.isfinite(z[rows]).sum(1) > 0.2 * z.shape[1]]
        if len(rows) < 8:
            return None
        along = np.minimum.accumulate(np.nanmedian(z[rows], axis=1))  # ground comes nearer downwards
        metres = _EYE_M[kind] * focal_px / ((rows + 0.5 - horizon) * along)
        if kind == "indoor":
            metres = np.sqrt(metres * _ROOM_M)
        return cls(along[::-1].copy(), metres[::-1].copy())


def _horizon(shape: tuple[int, ...], sky: BoolArray | None) -> float:
    """Returns the row of the horizon: the middle of a level camera, or what of the sky lies lower."""
    middle = 0.5 * shape[0]
    if sky is None:
        return middle
    rows = np.flatnonzero(np.asarray(sky, bool).mean(1) > 0.3)
    return float(max(middle, rows.max() + 1)) if len(rows) else middle


def metres_at(metres_per_px: FloatArray | None, shape: tuple[int, int], x: float, y: float) -> float | None:
    """Returns what a pixel is worth at one of them; None if unknown.

    Args:
        metres_per_px: (any, any) over the view; nan where nothing stands.
        shape: (h, w) of the view.
        x: px.
        y: px.
    """
    if metres_per_px is None or not np.isfinite(metres_per_px).any():
        return None
    gh, gw = metres_per_px.shape
    row, column = int(np.clip(y / shape[0] * gh, 0, gh - 1)), int(np.clip(x / shape[1] * gw, 0, gw - 1))
    near = metres_per_px[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
    known = near[np.isfinite(near)]
    return float(np.median(known if len(known) else metres_per_px[np.isfinite(metres_per_px)]))


def share_of(name: str, size: float, metres: float | None, shape: tuple[int, int]) -> float:
    """Returns how wide a thing is drawn, as a share of the view's width.

    Args:
        name: of the object.
        size: what the prompt asks for, as a share; `USUAL_SIZE` if it does not say.
        metres: in a pixel where it stands; None if unknown.
        shape: (h, w) of the view.
    """
    natural = NATURAL_M.get(name.removesuffix(" in flight"))
    if metres is None or natural is None or natural < HAND_M:
        return size
    h, w = shape
    true = natural / (metres * w)
    drawn = USUAL_SIZE * float(np.clip((true / USUAL_SIZE) ** _TRUTH, LEAST_OF_USUAL, 1.0))
    word = size / USUAL_SIZE  # "giant" is larger than its like, "tiny" smaller
    return min(drawn * word * word, size) if word > 1 else max(drawn * word, LEAST_SHARE * h / w)


def coarse(values: DoubleArray) -> FloatArray:
    """Returns a map (h, w) at a size that `metres_at` needs, medians of what is known."""
    h, w = values.shape
    rows, columns = max(h // 24, 1), max(w // 24, 1)
    known = np.isfinite(values)
    total = cv2.resize(np.where(known, values, 0.0), (columns, rows), interpolation=cv2.INTER_AREA)
    count = cv2.resize(known.astype(np.float64), (columns, rows), interpolation=cv2.INTER_AREA)
    with np.errstate(all="ignore"):
        return np.where(count > 0.25, total / count, np.nan).astype(np.float32)
