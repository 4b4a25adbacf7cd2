"""Eq. 3 with coverage for the surfels of one level: twin of `core.opacity.weights` and of opacity.glsl.

``texels`` is what `core.opacity.Modulation.texels` returns and the shaders read from a texture.
"""

import numba
import numpy as np

from wzviewer.core.anchor import DEPTH_FLOOR
from wzviewer.core.constants import WEIGHT_MIN
from wzviewer.core.opacity import LOG_SPAN_MIN, VARIANCE_PX2
from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import HALF, LOW_PASS, ONE, SAFE_FLAGS, TWO, ZERO, exp2, log2
from wzviewer.kernels.projection import CULLED

THREE = np.float32(3.0)
_VARIANCE = np.float32(VARIANCE_PX2)
_FLOOR = np.float32(DEPTH_FLOOR)
_SPAN_MIN = np.float32(LOG_SPAN_MIN)
_WEIGHT_MIN = np.float32(WEIGHT_MIN)
_NEARLY_ONE = np.float32(1.0 - 1e-5)  # compositing is quicker without a weight
_HEAD, _COVER = 2, 5  # texels


@numba.njit(fastmath=SAFE_FLAGS)
def _dot(row: FloatArray, means: FloatArray, i: int) -> np.float32:
    return row[0] * means[i, 0] + row[1] * means[i, 1] + row[2] * means[i, 2]


@numba.njit(fastmath=SAFE_FLAGS)
def _log_scale(row: FloatArray, means: FloatArray, i: int, side: np.float32) -> np.float32:
    """log2 of Eq. 1's d / f over the unit, from a (g, base) row."""
    return row[3] + log2(max(side * (ONE + _dot(row, means, i)), _FLOOR))


@numba.njit(fastmath=SAFE_FLAGS)
def _ramp(top: np.float32, here: np.float32, low: np.float32) -> np.float32:
    """t: 0 at the parent's log scale (top), 1 at the child's (low)."""
    return min(max((top - here) / max(top - low, _SPAN_MIN), ZERO), ONE)


@numba.njit(fastmath=SAFE_FLAGS)
def _compensation(octaves: np.float32) -> np.float32:
    """`core.opacity.compensation`, from log2 of the magnification of what a surfel stands for."""
    area = exp2(TWO * min(octaves, ZERO))
    return area * (_VARIANCE + LOW_PASS) / (_VARIANCE * area + LOW_PASS)


@numba.njit(fastmath=SAFE_FLAGS)
def _share(cover: FloatArray, means: FloatArray, i: int, render: np.float32) -> np.float32:
    """M t of a cover, (5, 4) texels, at a surfel."""
    D = ONE + _dot(cover[2], means, i)
    if cover[4, 3] * D <= _FLOOR:
        return ZERO  # behind the cover's camera
    x = _dot(cover[0], means, i) / D + cover[0, 3]
    y = _dot(cover[1], means, i) / D + cover[1, 3]
    border = min(min(x, cover[4, 0] - x), min(y, cover[4, 1] - y))
    s = min(max(border / cover[4, 2], ZERO), ONE)
    if s <= ZERO:
        return ZERO
    top, low = _log_scale(cover[3], means, i, ONE), _log_scale(cover[2], means, i, cover[4, 3])
    return s * s * (THREE - TWO * s) * _ramp(top, render, low)


@numba.njit(fastmath=SAFE_FLAGS)
def weigh_range(
    means: FloatArray,
    native_scales: FloatArray,
    coverage: FloatArray,
    view: FloatArray,
    texels: FloatArray,
    weights: FloatArray,
    projected: FloatArray,
    first: int,
    last: int,
    row: int,
) -> None:
    """Writes the weight w of surfels [first, last) from ``row`` on, and culls those that have none.

    Args:
        means: (n, 3) local positions.
        native_scales: (n,) s_native over the level's unit.
        coverage: (n,) product of m over the level and its ancestors.
        view: (13,) from `projection.view_vector`.
        texels: (2 + 5 covers, 4) from `Modulation.texels`.
        weights: (rows,) written, in [0, 1].
        projected: (rows, 8) from `projection.project_range`; half extents turn negative where w is 0.
        first: surfel.
        last: surfel.
        row: of the first surfel.
    """
    view_row, covers = view[8:12], np.int64(texels[1, 0] + HALF)
    has_parent = texels[1, 1] > HALF
    for i in range(first, last):
        at = row + i - first
        if projected[at, 6] < ZERO:
            weights[at] = ZERO
            continue
        render = _log_scale(view_row, means, i, view[12])
        w = coverage[i]
        if has_parent:
            native = log2(native_scales[i])
            w *= _ramp(_log_scale(texels[0], means, i, ONE), render, native)
            w *= _compensation(native + texels[1, 3] - render)
        for k in range(covers):
            if w <= ZERO:
                break
            start = _HEAD + k * _COVER
            w *= ONE - _share(texels[start : start + _COVER], means, i, render)
        weights[at] = min(max(w, ZERO), ONE) if w < _NEARLY_ONE else ONE
        projected[at, 6] = projected[at, 6] if w >= _WEIGHT_MIN else CULLED
