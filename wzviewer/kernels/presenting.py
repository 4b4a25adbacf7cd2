"""A finished image for the outside: interleaved, or as bytes over a background (twin of present.frag)."""

import numba
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import ByteArray, FloatArray, IntArray
from wzviewer.kernels.elementary import FLAGS, HALF, ONE, ZERO

PixelArray = NDArray[np.uint32]  # four bytes in one number
LaneArray = NDArray[np.uint64]  # four bytes, each with room for a product

_WHITE = np.float32(255.0)
_STEPS = 128  # between two pixels: a byte times this fits into 16 bits
_BITS = np.uint64(7)
_BYTES = np.uint64(0x00FF00FF00FF00FF)
_HALVES = np.uint64(0x0040004000400040)


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def interleave(color: FloatArray, through: FloatArray, out: FloatArray) -> None:
    """Writes premultiplied colour and coverage, (h, w, 4), from planes (3, H, W) and (H, W)."""
    for y in numba.prange(out.shape[0]):
        for x in range(out.shape[1]):
            out[y, x, 0] = color[0, y, x]
            out[y, x, 1] = color[1, y, x]
            out[y, x, 2] = color[2, y, x]
            out[y, x, 3] = ONE - through[y, x]


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def present(
    color: FloatArray, through: FloatArray, background: FloatArray, closed: float, out: ByteArray
) -> None:
    """Writes display colour and alpha, (h, w, 4) uint8.

    Args:
        color: (3, H, W) premultiplied.
        through: (H, W) transmittance.
        background: (4,) straight.
        closed: coverage from which a surface counts as closed; 1: as rendered.
        out: (h, w, 4) written.
    """
    full = np.float32(closed)
    for y in numba.prange(out.shape[0]):
        for x in range(out.shape[1]):
            alpha = ONE - through[y, x]
            gain = min(ONE / max(alpha, full), ONE / full)
            behind = (ONE - gain * alpha) * background[3]
            for k in range(3):
                value = gain * color[k, y, x] + behind * background[k]
                out[y, x, k] = np.uint8(min(max(value, ZERO), ONE) * _WHITE + HALF)
            out[y, x, 3] = np.uint8(min(max(gain * alpha + behind, ZERO), ONE) * _WHITE + HALF)


@numba.njit(cache=True, nogil=True)
def fit(picture: PixelArray, out: PixelArray, is_bottom_first: bool, is_bgra: bool) -> None:
    """Enlarges a picture between its pixels (bilinear, edges kept), as a texture with GL_LINEAR would be.

    Four channels go as one number, so one thread is as fast as several that wait for each other.

    Args:
        picture: (h, w) RGBA bytes.
        out: (H, W) written; at most 1 of 255 off for each of the two directions.
        is_bottom_first: write the last row first.
        is_bgra: swap red and blue.
    """
    height, width = out.shape
    columns, column_parts = np.empty(width, np.int32), np.empty(width, np.uint64)
    rows, row_parts = np.empty(height, np.int32), np.empty(height, np.uint64)
    _places(picture.shape[1], columns, column_parts)
    _places(picture.shape[0], rows, row_parts)
    blended = np.empty(picture.shape[1] + 1, np.uint64)
    for y in range(height):
        _blend_rows(picture, rows[y], row_parts[y], blended, is_bgra)
        _stretch_row(blended, columns, column_parts, out[height - 1 - y if is_bottom_first else y])


@numba.njit(cache=True, nogil=True)
def _places(count: int, at: IntArray, parts: LaneArray) -> None:
    """Where each of a row of new pixels falls among ``count`` old ones: the one before it, and how far on."""
    for k in range(len(at)):
        place = min(max((k + 0.5) * count / len(at) - 0.5, 0.0), count - 1.0)
        at[k] = int(place)
        parts[k] = np.uint64(int((place - at[k]) * _STEPS + 0.5))


@numba.njit(cache=True, nogil=True)
def _blend_rows(picture: PixelArray, row: int, part: int, blended: LaneArray, is_bgra: bool) -> None:
    below = min(row + 1, picture.shape[0] - 1)
    for x in range(picture.shape[1]):
        blended[x] = _mixed(_lanes(picture[row, x]), _lanes(picture[below, x]), part)
    if is_bgra:
        for x in range(picture.shape[1]):
            blended[x] = _swapped(blended[x])
    blended[-1] = blended[-2]


@numba.njit(cache=True, nogil=True)
def _stretch_row(blended: LaneArray, columns: IntArray, parts: LaneArray, out: PixelArray) -> None:
    for x in range(len(out)):
        left = columns[x]
        out[x] = _pixel(_mixed(blended[left], blended[left + 1], parts[x]))


@numba.njit(cache=True, nogil=True)
def _mixed(first: int, second: int, part: int) -> int:
    kept = np.uint64(_STEPS) - part
    return ((first * kept + second * part + _HALVES) >> _BITS) & _BYTES  # type: ignore[return-value]


@numba.njit(cache=True, nogil=True)
def _lanes(pixel: int) -> int:
    wide = np.uint64(pixel)
    low = (wide & np.uint64(0xFF)) | ((wide & np.uint64(0xFF00)) << np.uint64(8))
    high = ((wide & np.uint64(0xFF0000)) << np.uint64(16)) | ((wide & np.uint64(0xFF000000)) << np.uint64(24))
    return low | high  # type: ignore[return-value]


@numba.njit(cache=True, nogil=True)
def _swapped(lanes: int) -> int:
    """Red for blue."""
    others = lanes & np.uint64(0xFFFF0000FFFF0000)
    red, blue = lanes & np.uint64(0xFF), (lanes >> np.uint64(32)) & np.uint64(0xFF)
    return others | (red << np.uint64(32)) | blue  # type: ignore[return-value]


@numba.njit(cache=True, nogil=True)
def _pixel(lanes: int) -> int:
    low = (lanes & np.uint64(0xFF)) | ((lanes >> np.uint64(8)) & np.uint64(0xFF00))
    third, fourth = lanes >> np.uint64(16), lanes >> np.uint64(24)
    high = (third & np.uint64(0xFF0000)) | (fourth & np.uint64(0xFF000000))
    return np.uint32(low | high)  # type: ignore[return-value]
