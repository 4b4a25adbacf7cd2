"""Front-to-back order, and lists of surfels per 8x8 tile that keep it.

The order is cut into eight runs; each counts and later writes its own share of every tile's list, so
no two threads touch the same element and the lists do not depend on the number of threads.
"""

import numba
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import FLAGS, HALF, ZERO

TILE = 8  # px: one AVX register wide
RUNS = 8

Keys = NDArray[np.uint64]
Indices = NDArray[np.uint32]
Offsets = NDArray[np.int64]


def front_to_back(projected: FloatArray, depths: FloatArray, offset: float, gain: float) -> Indices:
    """Returns the visible surfels of one part, nearest first, ties by index; (m,) uint32."""
    keys = np.empty(len(projected), np.uint64)
    count = depth_keys(projected, depths, offset, gain, 0, keys)
    return sorted_indices(keys[:count])


def sorted_indices(keys: Keys) -> Indices:
    """Sorts packed keys in place and returns their indices, (m,) uint32."""
    keys.sort()
    return (keys & np.uint64(0xFFFFFFFF)).astype(np.uint32)


@numba.njit(cache=True, nogil=True, fastmath=FLAGS)
def depth_keys(
    projected: FloatArray, depths: FloatArray, offset: float, gain: float, first: int, keys: Keys
) -> int:
    """Packs (float32(offset + gain depth), first + index) of the visible surfels; returns how many.

    Args:
        projected: (n, 8) from `projection.project`.
        depths: (n,) depth from the anchor, the part's own unit.
        offset: depth of the anchor from the common focus, float64.
        gain: the part's unit in the common unit, float64.
        first: index of the part's first surfel.
        keys: (>= n,) uint64, written from the start.
    """
    count = 0
    for i in range(projected.shape[0]):
        if projected[i, 6] >= ZERO:
            bits = np.float32(offset + gain * np.float64(depths[i])).view(np.int32)
            # flip negatives whole and positives by sign: unsigned order is then float order
            flip = np.int32(bits >> np.int32(31)) | np.int32(-2147483648)
            high = np.uint64(np.uint32(bits ^ flip))
            keys[count] = (high << np.uint64(32)) | np.uint64(first + i)
            count += 1
    return count


@numba.njit(fastmath=FLAGS)
def pixel_span(centre: np.float32, half: np.float32, size: int) -> tuple[np.int64, np.int64]:
    """Returns the first and last pixel whose centre lies within ``half`` of ``centre``."""
    limit = np.float32(size)
    low = np.ceil(max(centre - half - HALF, ZERO))
    high = np.floor(min(centre + half - HALF, limit - np.float32(1.0)))
    return np.int64(low), np.int64(high)


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def _count(
    projected: FloatArray, order: Indices, width: int, height: int, columns: int, counts: Offsets
) -> None:
    for run in numba.prange(RUNS):
        counts[run, :] = 0
        for at in range(run * order.size // RUNS, (run + 1) * order.size // RUNS):
            i = order[at]
            if projected[i, 6] >= ZERO:
                x0, x1 = pixel_span(projected[i, 0], projected[i, 6], width)
                y0, y1 = pixel_span(projected[i, 1], projected[i, 7], height)
                if x1 >= x0 and y1 >= y0:
                    for ty in range(y0 // TILE, y1 // TILE + 1):
                        for tx in range(x0 // TILE, x1 // TILE + 1):
                            counts[run, ty * columns + tx] += 1


@numba.njit(cache=True, nogil=True, fastmath=FLAGS)
def _to_offsets(counts: Offsets, starts: Offsets) -> None:
    total = 0
    for tile in range(counts.shape[1]):
        starts[tile] = total
        for run in range(RUNS):
            here = counts[run, tile]
            counts[run, tile] = total
            total += here
    starts[counts.shape[1]] = total


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def _fill(
    projected: FloatArray,
    order: Indices,
    width: int,
    height: int,
    columns: int,
    counts: Offsets,
    members: Indices,
) -> None:
    for run in numba.prange(RUNS):
        for at in range(run * order.size // RUNS, (run + 1) * order.size // RUNS):
            i = order[at]
            if projected[i, 6] >= ZERO:
                x0, x1 = pixel_span(projected[i, 0], projected[i, 6], width)
                y0, y1 = pixel_span(projected[i, 1], projected[i, 7], height)
                if x1 >= x0 and y1 >= y0:
                    for ty in range(y0 // TILE, y1 // TILE + 1):
                        for tx in range(x0 // TILE, x1 // TILE + 1):
                            members[counts[run, ty * columns + tx]] = i
                            counts[run, ty * columns + tx] += 1


def bin_tiles(projected: FloatArray, order: Indices, width: int, height: int) -> tuple[Offsets, Indices]:
    """Lists the surfels that touch each 8x8 tile, front to back.

    Args:
        projected: (n, 8) from `projection.project`.
        order: (m,) uint32, front to back.
        width: image width, px.
        height: image height, px.

    Returns:
        starts (tiles + 1,) int64, tiles row-major, and members (pairs,) uint32.
    """
    columns, rows = -(-width // TILE), -(-height // TILE)
    counts = np.empty((RUNS, columns * rows), np.int64)
    starts = np.empty(columns * rows + 1, np.int64)
    _count(projected, order, width, height, columns, counts)
    _to_offsets(counts, starts)
    members = np.empty(int(starts[-1]), np.uint32)
    _fill(projected, order, width, height, columns, counts, members)
    return starts, members
