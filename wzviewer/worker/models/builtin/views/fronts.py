"""Which hidden pixels an orbit can uncover, and what lies there: fronts that grow from depth edges.

At every edge the far surface is continued under the near one, as far as the orbit can look under it.
The nearest edge wins.  A front carries the depth of the rim it started from and never enters
anything that is not nearer than that.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.edges import STEP_PX
from wzviewer.worker.models.builtin.views.smoothing import disc

REACH_PX = 150.0  # farthest continuation at deep levels, where the parent lies behind
REACH_SHARE = 0.18  # of the base focal length: the same at level 0
REACH_GAIN = 1.1
SEED_STEP = 0.03  # relative depth of a jump between two pixels that is no slope
ENTER_STEP = 0.01
REACH_MARGIN_PX = 4.0
SKY_WINDOW_PX = 60
SKY_MARGIN_PX = 12.0
SKY_GAP_PX = 6  # thinner gaps between leaves do not lower the horizon
SKY_RAISE_PX = 70.0
ISLAND_SHARE = 0.01  # of the picture: a smaller piece of sky is a gap in something
ISLAND_REACH_PX = 60.0


@dataclass(frozen=True)
class Fronts:
    """The continued far surfaces.

    Attributes:
        reached: (h, w) bool, pixels under which something is continued.
        shift: (h, w) float32, depth of the rim where the front started; the input where not reached.
        origin: (h, w, 2) int32, row and column of that rim pixel; the pixel itself where not reached.
    """

    reached: BoolArray
    shift: FloatArray
    origin: IntArray


def grow_fronts(
    shift: FloatArray, axis: DepthAxis, gain: float, allowed: BoolArray, sky: BoolArray
) -> Fronts:
    """Continues the far side of every depth edge under its near side.

    Args:
        shift: (h, w) float32, px.
        axis: the depth coordinate.
        gain: tan of the largest orbit angle.
        allowed: (h, w) bool, where fronts may go.
        sky: (h, w) bool; its fronts stop below the horizon.
    """
    limit = np.maximum(STEP_PX / gain, axis.step_of(shift, SEED_STEP)).astype(np.float32)
    enter = axis.step_of(shift, ENTER_STEP)
    main_sky = _main_sky(sky)
    stops = _sky_stops(shift, main_sky, gain)
    most = np.float32(REACH_SHARE * axis.base_px if axis.wide else REACH_PX)
    origin, reach = _seed(shift, limit, allowed, np.float32(gain), most)
    _limit(reach, origin, sky & ~main_sky, np.float32(ISLAND_REACH_PX))
    _spread(shift, enter, allowed, sky, stops, origin, reach, np.float32(gain), most)
    reached, told = _told(shift, origin)
    return Fronts(reached, told, origin)


def _main_sky(sky: BoolArray) -> BoolArray:
    """Returns the sky (h, w) without its islands: gaps between leaves say nothing about the horizon."""
    count, label, stats, _ = cv2.connectedComponentsWithStats(sky.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] > ISLAND_SHARE * sky.size
    large |= stats[:, cv2.CC_STAT_TOP] == 0
    large[0] = False
    return np.asarray(large[label]) if count > 1 else sky


def _sky_stops(shift: FloatArray, sky: BoolArray, gain: float) -> FloatArray:
    """Returns the lowest row (w,) that the sky may be continued to.

    Without a limit sky shows between leaves near the ground; a single horizon for the whole picture
    leaves the gap between two houses open; so: the lowest sky within 60 columns, and what the orbit
    can see over the edge there.
    """
    height, width = sky.shape
    open_sky = cv2.morphologyEx(sky.astype(np.uint8), cv2.MORPH_OPEN, disc(SKY_GAP_PX), borderValue=1) > 0
    sky = open_sky if open_sky.any() else sky
    columns = sky.any(axis=0)
    if not columns.any():
        return np.zeros(width, np.float32)
    lowest = np.where(columns, height - 1 - sky[::-1].argmax(axis=0), 0)
    below = np.minimum(lowest + 3, height - 1)
    jump = shift[below, np.arange(width)] - shift[lowest, np.arange(width)]
    usual = float(np.median(jump[columns]))  # a tall flower before the sky is no horizon
    raised = np.where(columns, np.clip(REACH_GAIN * gain * np.minimum(jump, usual), 0, SKY_RAISE_PX), 0)
    floor = np.percentile(lowest[columns], 75)
    stops = np.maximum(_window_max(lowest, SKY_WINDOW_PX), floor)
    return (stops + SKY_MARGIN_PX + _window_max(raised, SKY_WINDOW_PX // 3)).astype(np.float32)


def _window_max(values: NDArray[Any], radius: int) -> NDArray[Any]:
    """Returns the running maximum (n,) over 2 r + 1 entries."""
    padded = np.pad(values, radius, mode="edge")
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * radius + 1).max(axis=1))


@njit(cache=True, nogil=True)
def _seed(
    shift: FloatArray, limit: FloatArray, allowed: BoolArray, gain: np.float32, most: np.float32
) -> tuple[IntArray, FloatArray]:
    """Returns origin (h, w, 2), -1 where none, and reach (h, w) of the near pixels of every edge."""
    height, width = shift.shape
    origin = np.full((height, width, 2), -1, np.int32)
    reach = np.zeros((height, width), np.float32)
    for y in range(height):
        for x in range(width):
            if not allowed[y, x]:
                continue
            deepest = np.float32(0.0)
            for k in range(4):
                v = y + (k == 0) - (k == 1)
                u = x + (k == 2) - (k == 3)
                if v < 0 or u < 0 or v >= height or u >= width:
                    continue
                drop = shift[y, x] - shift[v, u]
                if drop > limit[v, u] and drop > deepest:
                    deepest = drop
                    origin[y, x, 0] = v
                    origin[y, x, 1] = u
            if deepest > 0:
                reach[y, x] = min(most, REACH_GAIN * gain * deepest + REACH_MARGIN_PX)
    return origin, reach


@njit(cache=True, nogil=True)
def _told(shift: FloatArray, origin: IntArray) -> tuple[BoolArray, FloatArray]:
    """Returns where origins (h, w, 2) are set and the shift there (h, w); sets the others to themselves."""
    reached, told = np.zeros(shift.shape, np.bool_), shift.copy()
    for y in range(shift.shape[0]):
        for x in range(shift.shape[1]):
            if origin[y, x, 0] >= 0:
                reached[y, x] = True
                told[y, x] = shift[origin[y, x, 0], origin[y, x, 1]]
            else:
                origin[y, x, 0], origin[y, x, 1] = y, x
    return reached, told


@njit(cache=True, nogil=True)
def _limit(reach: FloatArray, origin: IntArray, where: BoolArray, most: np.float32) -> None:
    """Limits the reach (h, w) of the seeds whose rim lies in a region."""
    for y in range(reach.shape[0]):
        for x in range(reach.shape[1]):
            if origin[y, x, 0] >= 0 and where[origin[y, x, 0], origin[y, x, 1]]:
                reach[y, x] = min(reach[y, x], most)


@njit(cache=True, nogil=True)
def _spread(
    shift: FloatArray,
    enter: FloatArray,
    allowed: BoolArray,
    sky: BoolArray,
    stops: FloatArray,
    origin: IntArray,
    reach: FloatArray,
    gain: np.float32,
    most: np.float32,
) -> None:
    """Spreads seeds breadth first; a pixel is taken over by a rim that is at least 0.5 px closer.

    The reach grows where the front runs under something still nearer, which moves away faster.
    """
    height, width = shift.shape
    capacity = height * width + 1
    queue = np.empty(capacity, np.int32)
    waiting = np.zeros((height, width), np.bool_)
    head = 0
    tail = 0
    for y in range(height):
        for x in range(width):
            if origin[y, x, 0] >= 0:
                queue[tail] = y * width + x
                waiting[y, x] = True
                tail += 1
    while head != tail:
        y = queue[head] // width
        x = queue[head] % width
        head = (head + 1) % capacity
        waiting[y, x] = False
        row = origin[y, x, 0]
        column = origin[y, x, 1]
        rim = shift[row, column]
        for k in range(9):
            v = y + k // 3 - 1
            u = x + k % 3 - 1
            if v < 0 or u < 0 or v >= height or u >= width or not allowed[v, u]:
                continue
            if shift[v, u] <= rim + enter[row, column] or (sky[row, column] and v > stops[u]):
                continue
            far = np.sqrt(np.float32((v - row) ** 2 + (u - column) ** 2))
            own = reach[y, x]
            if not sky[row, column]:
                own = max(own, min(most, REACH_GAIN * gain * (shift[v, u] - rim) + REACH_MARGIN_PX))
            if far > own:
                continue
            if origin[v, u, 0] >= 0:
                old = np.sqrt(np.float32((v - origin[v, u, 0]) ** 2 + (u - origin[v, u, 1]) ** 2))
                if far >= old - 0.5:
                    continue
            origin[v, u, 0] = row
            origin[v, u, 1] = column
            reach[v, u] = own
            if not waiting[v, u]:
                waiting[v, u] = True
                queue[tail] = v * width + u
                tail = (tail + 1) % capacity
