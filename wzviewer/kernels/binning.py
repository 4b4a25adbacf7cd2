"""Front-to-back order, and lists of surfels per 8x8 tile that keep it.

The order is cut into eight runs; each counts and later writes its own share of every tile's list, so
no two threads touch the same element and the lists do not depend on the number of threads.  Both walks
read one word a surfel, the span of tiles that it touches, which is computed first and brought into
depth order once: reading the projected rows at random, twice, took most of the time (62 ms for 783 k
surfels on two cores; now 24).
"""

import numba
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.reference import DEPTH_QUANTUM
from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import BLOCK, FLAGS, HALF, ZERO
from wzviewer.kernels.projection import is_near, row_norms

TILE = 8  # px: one AVX register wide
RUNS = 8
STEPS = np.float32(1.0 / DEPTH_QUANTUM)
NOWHERE = np.uint64(0xFFFFFFFFFFFFFFFF)  # the span of a surfel that touches no tile
SIXTEEN_BITS = np.uint64(0xFFFF)
GROWN = np.float32(2.0)  # so many times as large may surfels become while they are optimised

Keys = NDArray[np.uint64]
Indices = NDArray[np.uint32]
Spans = NDArray[np.uint64]  # first and last tile column, first and last tile row: 16 bits each
Offsets = NDArray[np.int64]


def front_to_back(
    means: FloatArray, scales: FloatArray, packed: FloatArray, depth_row: FloatArray, width: int, height: int
) -> tuple[Indices, Offsets]:
    """Orders what a camera may see of one set, even of surfels that have grown since.

    Args:
        means: (n, 3).
        scales: (n, 2).
        packed: (13,) from `projection.view_vector`.
        depth_row: (4,) from `core.reference.depth_row`.
        width: image width, px.
        height: image height, px.

    Returns:
        (m,) uint32 nearest first, ties by index; and (k,) the blocks of `BLOCK` surfels that hold them.
    """
    keys = np.empty(len(means), np.uint64)
    counts = np.zeros(-(-len(means) // BLOCK), np.int64)
    _keys_in_view(means, scales, packed, depth_row, width, height, keys, counts)
    blocks = np.flatnonzero(counts)
    runs = [keys[b * BLOCK : b * BLOCK + counts[b]] for b in blocks]
    return sorted_indices(np.concatenate([keys[:0], *runs])), blocks


@numba.njit(cache=True, nogil=True, parallel=True)
def _keys_in_view(
    means: FloatArray,
    scales: FloatArray,
    packed: FloatArray,
    depth_row: FloatArray,
    width: int,
    height: int,
    keys: Keys,
    counts: Offsets,
) -> None:
    """Writes the keys of each block from its start on, and how many."""
    nx, ny, ng = row_norms(packed)
    size = (np.float32(width), np.float32(height))
    for block in numba.prange(counts.size):
        at = block * BLOCK
        for i in range(block * BLOCK, min((block + 1) * BLOCK, means.shape[0])):
            if is_near(means, scales, packed, size[0], size[1], nx, ny, ng, GROWN, i):
                keys[at] = np.uint64(depth_bits(means, depth_row, i)) << np.uint64(32) | np.uint64(i)
                at += 1
        counts[block] = at - block * BLOCK


def sorted_indices(keys: Keys) -> Indices:
    """Sorts packed keys in place and returns their indices, (m,) uint32."""
    keys.sort()
    return keys.astype(np.uint32)  # the lower half


def visible_keys(projected: FloatArray, bits: Indices, keys: Keys) -> int:
    """Packs (depth, row) of the visible surfels; returns how many.

    Args:
        projected: (n, 8) from `projection.project_range`.
        bits: (n,) uint32 from `depth_bits`.
        keys: (>= n,) uint64, written from the start.
    """
    starts = np.zeros(-(-len(projected) // BLOCK) + 1, np.int64)
    _count_visible(projected, starts[1:])
    np.cumsum(starts, out=starts)
    _write_keys(projected, bits, starts, keys)
    return int(starts[-1])


@numba.njit
def depth_bits(means: FloatArray, depth_row: FloatArray, i: int) -> np.uint32:
    """Bits that sort as the depth of a surfel in steps does.

    Without fast-math: the same roundings as `gl.order.relative_depths`, so both orders are equal.
    """
    depth = depth_row[0] * means[i, 0]
    depth += depth_row[1] * means[i, 1]
    depth += depth_row[2] * means[i, 2]
    depth += depth_row[3]
    steps = np.float32(np.rint(depth * STEPS) + ZERO)  # -0 would sort below +0
    bits = steps.view(np.int32)
    # flip negatives whole and positives by sign: unsigned order is then float order
    flip = np.int32(bits >> np.int32(31)) | np.int32(-2147483648)
    return np.uint32(bits ^ flip)


@numba.njit(cache=True, nogil=True, parallel=True)
def _count_visible(projected: FloatArray, counts: Offsets) -> None:
    for block in numba.prange(counts.size):
        count = 0
        for i in range(block * BLOCK, min((block + 1) * BLOCK, projected.shape[0])):
            count += projected[i, 6] >= ZERO
        counts[block] = count


@numba.njit(cache=True, nogil=True, parallel=True)
def _write_keys(projected: FloatArray, bits: Indices, starts: Offsets, keys: Keys) -> None:
    for block in numba.prange(starts.size - 1):
        at = starts[block]
        for i in range(block * BLOCK, min((block + 1) * BLOCK, projected.shape[0])):
            if projected[i, 6] >= ZERO:
                keys[at] = np.uint64(bits[i]) << np.uint64(32) | np.uint64(i)
                at += 1


@numba.njit(fastmath=FLAGS)
def pixel_span(centre: np.float32, half: np.float32, size: int) -> tuple[np.int64, np.int64]:
    """Returns the first and last pixel whose centre lies within ``half`` of ``centre``."""
    limit = np.float32(size)
    low = np.ceil(max(centre - half - HALF, ZERO))
    high = np.floor(min(centre + half - HALF, limit - np.float32(1.0)))
    return np.int64(low), np.int64(high)


@numba.njit(fastmath=FLAGS)
def span_range(projected: FloatArray, width: int, height: int, spans: Spans, first: int, last: int) -> None:
    """Writes which tiles the surfels [first, last) touch, (n,)."""
    for i in range(first, last):
        spans[i] = NOWHERE
        if projected[i, 6] >= ZERO:
            x0, x1 = pixel_span(projected[i, 0], projected[i, 6], width)
            y0, y1 = pixel_span(projected[i, 1], projected[i, 7], height)
            if x1 >= x0 and y1 >= y0:
                columns = np.uint64(x0 // TILE) | np.uint64(x1 // TILE) << np.uint64(16)
                rows = np.uint64(y0 // TILE) | np.uint64(y1 // TILE) << np.uint64(16)
                spans[i] = columns | rows << np.uint64(32)


@numba.njit(cache=True, nogil=True, parallel=True)
def _tile_spans(projected: FloatArray, width: int, height: int, spans: Spans) -> None:
    n = projected.shape[0]
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        span_range(projected, width, height, spans, block * BLOCK, min((block + 1) * BLOCK, n))


@numba.njit(cache=True, nogil=True, parallel=True)
def _in_order(spans: Spans, order: Indices, ordered: Spans) -> None:
    for block in numba.prange((order.size + BLOCK - 1) // BLOCK):
        for at in range(block * BLOCK, min((block + 1) * BLOCK, order.size)):
            ordered[at] = spans[order[at]]


@numba.njit
def unpack_span(span: np.uint64) -> tuple[np.int64, np.int64, np.int64, np.int64]:
    """Returns first and last tile column, first and last tile row."""
    return (
        np.int64(span & SIXTEEN_BITS),
        np.int64(span >> np.uint64(16) & SIXTEEN_BITS),
        np.int64(span >> np.uint64(32) & SIXTEEN_BITS),
        np.int64(span >> np.uint64(48)),
    )


@numba.njit(cache=True, nogil=True, parallel=True)
def _count(ordered: Spans, columns: int, counts: Offsets) -> None:
    for run in numba.prange(RUNS):
        counts[run, :] = 0
        for at in range(run * ordered.size // RUNS, (run + 1) * ordered.size // RUNS):
            if ordered[at] != NOWHERE:
                x0, x1, y0, y1 = unpack_span(ordered[at])
                for y in range(y0, y1 + 1):
                    for x in range(x0, x1 + 1):
                        counts[run, y * columns + x] += 1


@numba.njit(cache=True, nogil=True)
def _to_offsets(counts: Offsets, starts: Offsets) -> None:
    total = 0
    for tile in range(counts.shape[1]):
        starts[tile] = total
        for run in range(RUNS):
            here = counts[run, tile]
            counts[run, tile] = total
            total += here
    starts[counts.shape[1]] = total


@numba.njit(cache=True, nogil=True, parallel=True)
def _fill(ordered: Spans, order: Indices, columns: int, cursors: Offsets, members: Indices) -> None:
    for run in numba.prange(RUNS):
        for at in range(run * ordered.size // RUNS, (run + 1) * ordered.size // RUNS):
            if ordered[at] != NOWHERE:
                x0, x1, y0, y1 = unpack_span(ordered[at])
                for y in range(y0, y1 + 1):
                    for x in range(x0, x1 + 1):
                        cursor = cursors[run, y * columns + x]
                        members[cursor] = order[at]
                        cursors[run, y * columns + x] = cursor + 1


def bin_tiles(projected: FloatArray, order: Indices, width: int, height: int) -> tuple[Offsets, Indices]:
    """Lists the surfels that touch each 8x8 tile, front to back.

    Args:
        projected: (n, 8) from `projection.project_range`.
        order: (m,) uint32, front to back.
        width: image width, px, at most 8 * 65535.
        height: image height, px, at most 8 * 65535.

    Returns:
        starts (tiles + 1,) int64, tiles row-major, and members (pairs,) uint32.
    """
    spans = np.empty(len(projected), np.uint64)
    _tile_spans(projected, width, height, spans)
    return bin_spans(spans, order, width, height)


def bin_spans(spans: Spans, order: Indices, width: int, height: int) -> tuple[Offsets, Indices]:
    """`bin_tiles` from (n,) spans that `span_range` wrote; of surfels not in the order they may be stale."""
    columns, rows = -(-width // TILE), -(-height // TILE)
    ordered = np.empty(len(order), np.uint64)
    _in_order(spans, order, ordered)
    counts, starts = np.empty((RUNS, columns * rows), np.int64), np.empty(columns * rows + 1, np.int64)
    _count(ordered, columns, counts)
    _to_offsets(counts, starts)
    members = np.empty(int(starts[-1]), np.uint32)
    _fill(ordered, order, columns, counts, members)
    return starts, members
