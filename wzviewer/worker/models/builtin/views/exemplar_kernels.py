"""Compiled parts of the exemplar fill: planning the patches and painting them."""

from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, ByteArray, FloatArray, IntArray

FAST = {"reassoc", "contract", "nsz", "arcp"}
GUIDE_STEP_PX = 4
FAR = np.float32(1e30)
LOG_WINDOW = 0.12  # half-width of the depth-sorted candidates
LIST_MIN = 400
RIM_LIMIT_PX = 200.0
JUMP_COST = 6.0  # for not continuing a neighbour's copy
OFFSET_LIMIT = 12.0  # largest brightness shift of a patch, grey levels


class Planes(NamedTuple):
    """The pictures of one fill, each (h, w, ...), colours in 0..255.

    Attributes:
        picture: (h, w, 3) float32, painted in place.
        state: (h, w) uint8: 0 unusable, 1 known, 2 to paint, 3 painted.
        copied_from: (h, w, 2) int32 source pixel, -1 where not painted.
        source: (h, w, 3) float32.
        coarse: (h/4, w/4, 3) float32, the guide.
        coarse_source: (h/4, w/4, 3) float32.
        weight: (h, w) float32, sum of the weights that were pasted.
    """

    picture: FloatArray
    state: ByteArray
    copied_from: IntArray
    source: FloatArray
    coarse: FloatArray
    coarse_source: FloatArray
    weight: FloatArray


class Aims(NamedTuple):
    """Where a patch should come from: log depths (h, w) float32 and rim (h, w, 2) int32."""

    source_log: FloatArray
    target_log: FloatArray
    origin: IntArray


class Places(NamedTuple):
    """Allowed source centres: a map (h, w), a list (n, 2) sorted by log depth, and its depths (n,)."""

    allowed: BoolArray
    listed: IntArray
    depths: FloatArray


class Search(NamedTuple):
    """Numbers of candidates and the costs of `FillRule`."""

    radius: int
    coherent: int
    scattered: int
    refined: int
    seed: int
    depth_cost: float
    row_cost: float
    rim_cost: float
    guide_cost: float


@njit(cache=True, nogil=True)
def plan_centres(pixels: IntArray, target: BoolArray, radius: int) -> IntArray:
    """Takes pixels (n, 2) in order and keeps those that no earlier patch has covered."""
    open_pixel = target.copy()
    kept = np.empty(pixels.shape, np.int32)
    count = 0
    height, width = target.shape
    for i in range(pixels.shape[0]):
        y = pixels[i, 0]
        x = pixels[i, 1]
        if open_pixel[y, x]:
            kept[count, 0] = y
            kept[count, 1] = x
            count += 1
            open_pixel[
                max(0, y - radius) : min(height, y + radius + 1),
                max(0, x - radius) : min(width, x + radius + 1),
            ] = False
    return kept[:count].copy()


@njit(cache=True, nogil=True)
def plan_waves(centres: IntArray, height: int, width: int, radius: int) -> tuple[IntArray, IntArray]:
    """Sorts patches into waves: each waits for the earlier ones that its window overlaps.

    Returns:
        order (n,) int32 of the patches, and (waves + 1,) int32 where each wave starts in it.
    """
    cell = radius + 1
    grid = np.zeros((height // cell + 1, width // cell + 1), np.int32)
    wave = np.empty(centres.shape[0], np.int32)
    last = 0
    for i in range(centres.shape[0]):
        y0 = max(0, (centres[i, 0] - 2 * radius - 1) // cell)
        x0 = max(0, (centres[i, 1] - 2 * radius - 1) // cell)
        y1 = min(grid.shape[0], (centres[i, 0] + 2 * radius + 1) // cell + 1)
        x1 = min(grid.shape[1], (centres[i, 1] + 2 * radius + 1) // cell + 1)
        wave[i] = grid[y0:y1, x0:x1].max() + 1
        grid[centres[i, 0] // cell, centres[i, 1] // cell] = wave[i]
        last = max(last, wave[i])
    starts = np.zeros(last + 2, np.int32)
    for i in range(centres.shape[0]):
        starts[wave[i] + 1] += 1
    starts = np.cumsum(starts).astype(np.int32)
    cursor = starts.copy()
    order = np.empty(centres.shape[0], np.int32)
    for i in range(centres.shape[0]):
        order[cursor[wave[i]]] = i
        cursor[wave[i]] += 1
    return order, starts[1:].copy()


@njit(cache=True, nogil=True, inline="always")
def _draw(random: NDArray[np.uint64]) -> float:
    """Returns the next number in [0, 1) of a 64-bit xorshift, state (1,) uint64."""
    x = random[0]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    random[0] = x
    return float((x * np.uint64(2685821657736338717)) >> np.uint64(40)) / 16777216.0


@njit(cache=True, nogil=True)
def _gather(planes: Planes, y: int, x: int, radius: int, offsets: IntArray, values: FloatArray) -> int:
    """Lists the filled pixels of a window on a checkerboard; returns how many there are."""
    picture, state = planes.picture, planes.state
    count = 0
    for dy in range(-radius, radius + 1):
        v = y + dy
        if v < 0 or v >= picture.shape[0]:
            continue
        for dx in range(-radius + ((dy + radius) & 1), radius + 1, 2):
            u = x + dx
            if u < 0 or u >= picture.shape[1] or (state[v, u] != 1 and state[v, u] != 3):
                continue
            offsets[count, 0] = dy
            offsets[count, 1] = dx
            for c in range(3):
                values[count, c] = picture[v, u, c]
            count += 1
    return count


@njit(cache=True, nogil=True, fastmath=FAST)
def _mismatch(
    source: FloatArray, y: int, x: int, offsets: IntArray, values: FloatArray, count: int, bound: float
) -> float:
    """Mean squared difference over the listed pixels; stops early above ``bound``."""
    total = np.float32(0.0)
    limit = np.float32(bound * 3 * count)
    for start in range(0, count, 16):
        for i in range(start, min(count, start + 16)):
            v = y + offsets[i, 0]
            u = x + offsets[i, 1]
            for c in range(3):
                difference = values[i, c] - source[v, u, c]
                total += difference * difference
        if total > limit:
            return float(FAR)
    return float(total / np.float32(3 * max(count, 1)))


@njit(cache=True, nogil=True, fastmath=FAST)
def _guide_mismatch(planes: Planes, y: int, x: int, v: int, u: int) -> float:
    """Mean squared difference of 3 x 3 coarse pixels around two places."""
    step = GUIDE_STEP_PX
    height, width = planes.coarse.shape[0], planes.coarse.shape[1]
    total = np.float32(0.0)
    for k in range(9):
        dy = k // 3 - 1
        dx = k % 3 - 1
        a = min(max(y // step + dy, 0), height - 1)
        b = min(max(x // step + dx, 0), width - 1)
        p = min(max(v // step + dy, 0), height - 1)
        q = min(max(u // step + dx, 0), width - 1)
        for c in range(3):
            difference = planes.coarse[a, b, c] - planes.coarse_source[p, q, c]
            total += difference * difference
    return float(total / np.float32(27.0))


@njit(cache=True, nogil=True)
def _continued(y: int, x: int, radius: int, planes: Planes, random: NDArray[np.uint64]) -> tuple[int, int]:
    """Proposes the source centre that continues the copy of a random pixel nearby; -1 if that is none."""
    height, width = planes.state.shape
    v = min(max(y + int((2 * _draw(random) - 1) * (radius + 1.5)), 0), height - 1)
    u = min(max(x + int((2 * _draw(random) - 1) * (radius + 1.5)), 0), width - 1)
    if planes.copied_from[v, u, 0] < 0:
        return -1, -1
    return planes.copied_from[v, u, 0] + y - v, planes.copied_from[v, u, 1] + x - u


@njit(cache=True, nogil=True)
def _nearby(y: int, x: int, spread: float, random: NDArray[np.uint64]) -> tuple[int, int]:
    """Proposes a pixel within a square around another."""
    dy = int((2 * _draw(random) - 1) * spread)
    return y + dy, x + int((2 * _draw(random) - 1) * spread)


@njit(cache=True, nogil=True)
def _place_cost(y: int, x: int, v: int, u: int, aims: Aims, search: Search) -> float:
    """Cost of a source centre apart from its colours: depth, height in the picture, distance."""
    dy = abs(v - aims.origin[y, x, 0])
    far = min(RIM_LIMIT_PX, float(dy + abs(u - aims.origin[y, x, 1])))
    depth = abs(aims.source_log[v, u] - aims.target_log[y, x])
    return float(search.depth_cost * depth + search.row_cost * dy + search.rim_cost * far)


@njit(cache=True, nogil=True)
def _choose(
    y: int, x: int, planes: Planes, aims: Aims, places: Places, search: Search
) -> tuple[int, int, float]:
    """Returns the best source centre for one patch and the brightness shift it needs."""
    area = (2 * search.radius + 1) ** 2 // 2 + 1
    offsets = np.empty((area, 2), np.int32)
    values = np.empty((area, 3), np.float32)
    count = _gather(planes, y, x, search.radius, offsets, values)
    random = np.empty(1, np.uint64)
    random[0] = np.uint64((search.seed * 1000003 + y * 65599 + x + 1) * 7919 + 12345)
    for _ in range(4):
        _draw(random)
    first, last = _depth_slice(places.depths, aims.target_log[y, x])
    scattered = search.coherent + search.scattered
    best_y, best_x, best_cost = -1, -1, float(FAR)
    for i in range(scattered + search.refined):
        if i < search.coherent:
            v, u = _continued(y, x, search.radius, planes, random)
        elif i >= scattered:
            v, u = _nearby(best_y, best_x, max(1.6, 24.0 * 0.85 ** (i - scattered)), random)
        elif i & 1:
            spread = _draw(random)
            v, u = _nearby(aims.origin[y, x, 0], aims.origin[y, x, 1], spread * spread * RIM_LIMIT_PX, random)
        else:
            k = first + int(_draw(random) * (last - first))
            v, u = places.listed[k, 0], places.listed[k, 1]
        if v < 0 or u < 0 or v >= places.allowed.shape[0] or u >= places.allowed.shape[1]:
            continue
        if not places.allowed[v, u]:
            continue
        cost = _place_cost(y, x, v, u, aims, search) + (0.0 if i < search.coherent else JUMP_COST)
        if cost < best_cost and search.guide_cost > 0:
            cost += search.guide_cost * _guide_mismatch(planes, y, x, v, u)
        if cost < best_cost:
            cost += _mismatch(planes.source, v, u, offsets, values, count, best_cost - cost)
        if cost < best_cost:
            best_y, best_x, best_cost = v, u, cost
    return best_y, best_x, _brightness_shift(planes.source, best_y, best_x, offsets, values, count)


@njit(cache=True, nogil=True)
def _depth_slice(depths: FloatArray, wanted: float) -> tuple[int, int]:
    """Returns the part of a sorted list within the depth window, widened to a minimum length."""
    first = int(np.searchsorted(depths, wanted - LOG_WINDOW))
    last = int(np.searchsorted(depths, wanted + LOG_WINDOW))
    lack = LIST_MIN - (last - first)
    if lack > 0:
        first = max(0, first - lack // 2)
        last = min(len(depths), first + LIST_MIN)
        first = max(0, min(first, last - LIST_MIN))
    return first, last


@njit(cache=True, nogil=True)
def _brightness_shift(
    source: FloatArray, y: int, x: int, offsets: IntArray, values: FloatArray, count: int
) -> float:
    """Mean difference to the listed pixels, one number: a shift per channel drifts to green skies."""
    if y < 0 or count == 0:
        return 0.0
    total = np.float32(0.0)
    for i in range(count):
        for c in range(3):
            total += values[i, c] - source[y + offsets[i, 0], x + offsets[i, 1], c]
    return min(max(float(total) / (3 * count), -OFFSET_LIMIT), OFFSET_LIMIT)


@njit(cache=True, nogil=True)
def _paste(y: int, x: int, v: int, u: int, shift: float, planes: Planes, radius: int) -> None:
    """Copies a patch; where patches overlap they are mixed by a weight that is steep at the rim."""
    picture, state, weight = planes.picture, planes.state, planes.weight
    for dy in range(max(-radius, -y), min(radius + 1, picture.shape[0] - y)):
        for dx in range(max(-radius, -x), min(radius + 1, picture.shape[1] - x)):
            kind = state[y + dy, x + dx]
            if kind < 2:
                continue
            inner = np.float32(1.0) - np.float32(max(abs(dy), abs(dx))) / np.float32(radius + 1)
            new_weight = inner * inner * inner
            weight[y + dy, x + dx] += new_weight
            share = new_weight / weight[y + dy, x + dx]
            for c in range(3):
                new = min(max(planes.source[v + dy, u + dx, c] + shift, 0.0), 255.0)
                picture[y + dy, x + dx, c] += share * (new - picture[y + dy, x + dx, c])
            if kind == 2:
                state[y + dy, x + dx] = 3
                planes.copied_from[y + dy, x + dx, 0] = v + dy
                planes.copied_from[y + dy, x + dx, 1] = u + dx


@njit(cache=True, nogil=True, parallel=True)
def paint(
    planes: Planes, aims: Aims, places: Places, search: Search, centres: IntArray, starts: IntArray
) -> None:
    """Paints consecutive waves of patches; within a wave no two windows overlap.

    Args:
        planes: read and painted.
        aims: what each target continues.
        places: where sources may be.
        search: how many candidates, and their costs.
        centres: (n, 2) int32 in wave order.
        starts: (waves + 1,) int32 into ``centres``.
    """
    for wave in range(len(starts) - 1):
        for i in prange(starts[wave], starts[wave + 1]):
            y, x = centres[i, 0], centres[i, 1]
            v, u, shift = _choose(y, x, planes, aims, places, search)
            if v >= 0:
                _paste(y, x, v, u, shift, planes, search.radius)
