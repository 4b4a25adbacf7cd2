"""Compositing front to back: colour, transmittance and the median surfel.

Alpha of a fragment is ``min(o G, 0.99)``, nothing below 1/255; then the Eq. 3 weight w makes it
``1 - (1 - alpha)^w`` or ``alpha w``; then the pixel blends, as long as its transmittance is >= 1e-4.

Each kernel writes at most four arrays: with more, LLVM's run-time alias checks grow until it gives up
vectorising the row of eight pixels (measured four times slower).
"""

import numba
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import FloatArray
from wzviewer.kernels.binning import TILE, Indices, Offsets, pixel_span
from wzviewer.kernels.elementary import CUT, FLAGS, HALF, MAX, ONE, STOP, ZERO, exp2, log2

Medians = NDArray[np.int32]
NONE = np.int32(-1)
CHECK_EVERY = 16  # surfels between two looks whether a tile is saturated


@numba.njit(fastmath=FLAGS)
def brightest(plane: FloatArray, y0: int, x0: int) -> np.float32:
    """Largest transmittance in a tile."""
    top = ZERO
    for y in range(y0, y0 + TILE):
        for x in range(x0, x0 + TILE):
            top = max(top, plane[y, x])
    return top


@numba.njit(fastmath=FLAGS)
def row_span(projected: FloatArray, i: int, y0: int) -> tuple[np.int64, np.int64]:
    """Rows of tile row y0 that the surfel reaches: [first, last)."""
    low, high = pixel_span(projected[i, 1], projected[i, 7], y0 + TILE)
    return max(low, np.int64(y0)), high + 1


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def composite(
    projected: FloatArray,
    colors: FloatArray,
    weights: FloatArray,
    linear: bool,
    starts: Offsets,
    members: Indices,
    background: FloatArray,
    red: FloatArray,
    green: FloatArray,
    blue: FloatArray,
    through: FloatArray,
) -> None:
    """Writes the image over a background, and the transmittance.

    Args:
        projected: (n, 8) from `projection.project_range`.
        colors: (n, 3).
        weights: (n,) Eq. 3 weights.
        linear: Eq. 2 as printed instead of the power law.
        starts: (tiles + 1,) from `binning.bin_tiles`.
        members: (pairs,) from `binning.bin_tiles`.
        background: (3,).
        red: (H, W) written; H and W are multiples of 8.
        green: (H, W) written.
        blue: (H, W) written.
        through: (H, W) written: transmittance T.
    """
    columns = red.shape[1] // TILE
    for tile_row in numba.prange(red.shape[0] // TILE):
        y0 = tile_row * TILE
        red[y0 : y0 + TILE] = ZERO
        green[y0 : y0 + TILE] = ZERO
        blue[y0 : y0 + TILE] = ZERO
        through[y0 : y0 + TILE] = ONE
        for column in range(columns):
            x0, tile = column * TILE, tile_row * columns + column
            start = starts[tile]
            for at in range(start, starts[tile + 1]):
                if (at - start) % CHECK_EVERY == CHECK_EVERY - 1 and brightest(through, y0, x0) < STOP:
                    break
                i = members[at]
                a, b, c, o = projected[i, 2], projected[i, 3], projected[i, 4], projected[i, 5]
                r, g, bl = colors[i, 0], colors[i, 1], colors[i, 2]
                left = np.float32(x0) + HALF - projected[i, 0]
                first, last = row_span(projected, i, y0)
                # Two loops, for a power of 1 needs neither exponent nor logarithm, and most weights are 1;
                # chosen within the row, both would be computed for every pixel.
                if linear or weights[i] == ONE:
                    times = weights[i]
                    for y in range(first, last):
                        dy = np.float32(y) + HALF - projected[i, 1]
                        flat, slope = -c * dy * dy, -b * dy
                        for k in range(TILE):
                            dx = left + np.float32(k)
                            alpha = min(o * exp2(min(flat + (slope - a * dx) * dx, ZERO)), MAX)
                            t = through[y, x0 + k]
                            w = t * times * (alpha if (alpha >= CUT) & (t >= STOP) else ZERO)
                            red[y, x0 + k] += w * r
                            green[y, x0 + k] += w * g
                            blue[y, x0 + k] += w * bl
                            through[y, x0 + k] = t - w
                else:
                    power = weights[i]
                    for y in range(first, last):
                        dy = np.float32(y) + HALF - projected[i, 1]
                        flat, slope = -c * dy * dy, -b * dy
                        for k in range(TILE):
                            dx = left + np.float32(k)
                            alpha = min(o * exp2(min(flat + (slope - a * dx) * dx, ZERO)), MAX)
                            t = through[y, x0 + k]
                            faded = ONE - exp2(power * log2(ONE - alpha))
                            w = t * (faded if (alpha >= CUT) & (t >= STOP) else ZERO)
                            red[y, x0 + k] += w * r
                            green[y, x0 + k] += w * g
                            blue[y, x0 + k] += w * bl
                            through[y, x0 + k] = t - w
        for y in range(y0, y0 + TILE):
            for x in range(red.shape[1]):
                red[y, x] += through[y, x] * background[0]
                green[y, x] += through[y, x] * background[1]
                blue[y, x] += through[y, x] * background[2]


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def median_index(
    projected: FloatArray,
    weights: FloatArray,
    linear: bool,
    starts: Offsets,
    members: Indices,
    index: Medians,
    through: FloatArray,
) -> None:
    """Writes the surfel at which the transmittance crosses 0.5.

    Args:
        projected: (n, 8) from `projection.project_range`.
        weights: (n,) Eq. 3 weights.
        linear: Eq. 2 as printed instead of the power law.
        starts: (tiles + 1,) from `binning.bin_tiles`.
        members: (pairs,) from `binning.bin_tiles`.
        index: (H, W) int32, written: row of ``projected``, -1 where ``through`` ends above 0.5.
        through: (H, W) written: transmittance, only as far as 0.5 is crossed.
    """
    columns = index.shape[1] // TILE
    for tile_row in numba.prange(index.shape[0] // TILE):
        y0 = tile_row * TILE
        index[y0 : y0 + TILE] = NONE
        through[y0 : y0 + TILE] = ONE
        for column in range(columns):
            x0, tile = column * TILE, tile_row * columns + column
            start = starts[tile]
            for at in range(start, starts[tile + 1]):
                if (at - start) % CHECK_EVERY == CHECK_EVERY - 1 and brightest(through, y0, x0) <= HALF:
                    break
                i = members[at]
                here = np.int32(i)
                a, b, c, o = projected[i, 2], projected[i, 3], projected[i, 4], projected[i, 5]
                left = np.float32(x0) + HALF - projected[i, 0]
                times = weights[i] if linear else ONE
                power = ONE if linear else weights[i]
                first, last = row_span(projected, i, y0)
                for y in range(first, last):
                    dy = np.float32(y) + HALF - projected[i, 1]
                    flat, slope = -c * dy * dy, -b * dy
                    for k in range(TILE):
                        dx = left + np.float32(k)
                        alpha = min(o * exp2(min(flat + (slope - a * dx) * dx, ZERO)), MAX)
                        t = through[y, x0 + k]
                        faded = ONE - exp2(power * log2(ONE - alpha))
                        faded = alpha if power == ONE else faded
                        after = t - t * times * (faded if alpha >= CUT else ZERO)
                        crosses = (t > HALF) & (after <= HALF)
                        index[y, x0 + k] = here if crosses else index[y, x0 + k]
                        through[y, x0 + k] = after


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def put_over(behind: FloatArray, through: FloatArray, image: FloatArray) -> None:
    """Adds what shines through an image (3, H, W) of a picture (3, H, W) behind it."""
    for y in numba.prange(through.shape[0]):
        for c in range(3):
            for x in range(through.shape[1]):
                image[c, y, x] += through[y, x] * behind[c, y, x]
