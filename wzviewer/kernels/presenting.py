"""A finished image for the outside: interleaved, or as bytes over a background (twin of present.frag)."""

import numba
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.kernels.elementary import FLAGS, HALF, ONE, ZERO

_WHITE = np.float32(255.0)


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
