"""Surfels to screen: centre, conic and extent (the perspective expanded about the anchor).

Row i of ``projected`` (n, 8) float32::

    0 1    centre, px
    2 3 4  conic K = (U U^T + 0.02 I)^-1 in units of log2: alpha = o 2^-(a dx^2 + b dx dy + c dy^2)
    5      opacity o
    6 7    half extents of alpha >= 1/255, px; negative when the surfel is culled

with U = W [s1 t1, s2 t2], t1 and t2 the first columns of R(q), and W = d p_px / d u exact at the centre.
"""

import numba
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.constants import ALPHA_CUT
from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import CUT, LOG2_E, LOW_PASS, ONE, SAFE_FLAGS, TWO, ZERO, log2

CULLED = np.float32(-1e6)
VIEW_SIZE = 13  # gx gy g of `AnchoredView` with their constants (12), sign of a.z

_DEPTH_FLOOR = np.float32(1e-6)  # of D(u), as in `AnchoredView`
_FOOTPRINT_MAX = np.float32(1e18)  # px; its square still fits float32
_CENTRE_MAX = np.float32(1e18)  # px
_MARGIN = np.float32(0.01)  # the cut decides, never the box
_TWO_LN_2 = np.float32(2.0 * np.log(2.0))
_REACH = np.float32(1.01 * np.sqrt(2.0 * np.log(1.0 / ALPHA_CUT)))  # sigmas, of the most opaque surfel
_LOW_PASS_REACH_PX = np.float32(1.0)  # more than sqrt(2 ln 255 x 0.02)
_PI_LOG2_E = np.float32(np.pi * np.log2(np.e))
_HALF_LOG2_E = np.float32(0.5) * LOG2_E


def view_vector(view: AnchoredView) -> FloatArray:
    """Packs a view into (13,) float32 for the kernels."""
    packed = np.empty(VIEW_SIZE, np.float32)
    packed[:12] = view.rows.ravel()
    packed[12] = np.copysign(1.0, view.depth)
    return packed


@numba.njit(fastmath=SAFE_FLAGS)
def tangents(quats: FloatArray, i: int) -> tuple[np.float32, ...]:
    """Returns the first two columns of R(q / |q|)."""
    w, x, y, z = quats[i, 0], quats[i, 1], quats[i, 2], quats[i, 3]
    k = TWO / max(w * w + x * x + y * y + z * z, np.float32(1e-30))
    return (
        ONE - k * (y * y + z * z),
        k * (x * y + w * z),
        k * (x * z - w * y),
        k * (x * y - w * z),
        ONE - k * (x * x + z * z),
        k * (y * z + w * x),
    )


@numba.njit(fastmath=SAFE_FLAGS)
def jacobian(means: FloatArray, view: FloatArray, i: int) -> tuple[np.float32, ...]:
    """Returns the centre (x, y), D with the sign of the depth, and W = d p_px / d u row by row."""
    u0, u1, u2 = means[i, 0], means[i, 1], means[i, 2]
    D = ONE + view[8] * u0 + view[9] * u1 + view[10] * u2
    front = D * view[12]
    k = ONE / (D if front > _DEPTH_FLOOR else ONE)
    x = k * (view[0] * u0 + view[1] * u1 + view[2] * u2)
    y = k * (view[4] * u0 + view[5] * u1 + view[6] * u2)
    return (
        x + view[3],
        y + view[7],
        front,
        k * (view[0] - x * view[8]),
        k * (view[1] - x * view[9]),
        k * (view[2] - x * view[10]),
        k * (view[4] - y * view[8]),
        k * (view[5] - y * view[9]),
        k * (view[6] - y * view[10]),
    )


@numba.njit(fastmath=SAFE_FLAGS)
def row_norms(view: FloatArray) -> tuple[np.float32, np.float32, np.float32]:
    """Returns |gx|, |gy| and |g| of a view."""
    return (
        np.sqrt(view[0] * view[0] + view[1] * view[1] + view[2] * view[2]),
        np.sqrt(view[4] * view[4] + view[5] * view[5] + view[6] * view[6]),
        np.sqrt(view[8] * view[8] + view[9] * view[9] + view[10] * view[10]),
    )


@numba.njit(fastmath=SAFE_FLAGS, error_model="numpy")
def may_be_seen(
    means: FloatArray, scales: FloatArray, view: FloatArray, width: int, height: int, first: int, last: int
) -> bool:
    """Whether a surfel of [first, last) may touch the image, by a bound that is cheap and never too small.

    A footprint reaches at most ``EXTENT sigma |d p / d u|``, and ``|d p / d u| <= (|gx| + |q| |g|) / D``.
    """
    w_px, h_px = np.float32(width), np.float32(height)
    nx, ny, ng = row_norms(view)
    seen = 0
    for i in range(first, last):
        seen += is_near(means, scales, view, w_px, h_px, nx, ny, ng, ONE, i)
    return seen > 0


@numba.njit(fastmath=SAFE_FLAGS, error_model="numpy")
def is_near(
    means: FloatArray,
    scales: FloatArray,
    view: FloatArray,
    w_px: np.float32,
    h_px: np.float32,
    nx: np.float32,
    ny: np.float32,
    ng: np.float32,
    grown: np.float32,
    i: int,
) -> bool:
    """Whether a surfel, so many times as large, may touch the image; the norms are |gx|, |gy| and |g|."""
    u0, u1, u2 = means[i, 0], means[i, 1], means[i, 2]
    D = ONE + view[8] * u0 + view[9] * u1 + view[10] * u2
    front = D * view[12]
    k = ONE / (D if front > _DEPTH_FLOOR else ONE)
    qx = k * (view[0] * u0 + view[1] * u1 + view[2] * u2)
    qy = k * (view[4] * u0 + view[5] * u1 + view[6] * u2)
    reach = _REACH * grown * max(scales[i, 0], scales[i, 1]) * abs(k)
    x, y = qx + view[3], qy + view[7]
    # the larger of the distances beyond the borders, against the reach and the low-pass
    beyond_x = max(-x, x - w_px) - reach * (nx + abs(qx) * ng)
    beyond_y = max(-y, y - h_px) - reach * (ny + abs(qy) * ng)
    return (front > _DEPTH_FLOOR) & (max(beyond_x, beyond_y) < _LOW_PASS_REACH_PX)


@numba.njit(fastmath=SAFE_FLAGS, error_model="numpy")
def project_range(
    means: FloatArray,
    quats: FloatArray,
    scales: FloatArray,
    opacities: FloatArray,
    view: FloatArray,
    width: int,
    height: int,
    half_height_max: float,
    projected: FloatArray,
    first: int,
    last: int,
    row: int,
) -> None:
    """Projects surfels [first, last) to the rows from ``row`` on.

    Args:
        means: (n, 3) local positions.
        quats: (n, 4) wxyz, any length.
        scales: (n, 2) local units.
        opacities: (n,).
        view: (13,) from `view_vector`.
        width: image width, px.
        height: image height, px.
        half_height_max: limit of the half extent in y, px.
        projected: (rows, 8) float32, written; see the module docstring.
        first: surfel.
        last: surfel.
        row: of the first surfel.
    """
    w_px, h_px, reach_max = np.float32(width), np.float32(height), np.float32(half_height_max)
    for i in range(first, last):
        x, y, front, w00, w01, w02, w10, w11, w12 = jacobian(means, view, i)
        a0, a1, a2, b0, b1, b2 = tangents(quats, i)
        s1, s2, o = scales[i, 0], scales[i, 1], opacities[i]
        px = s1 * (w00 * a0 + w01 * a1 + w02 * a2)
        py = s1 * (w10 * a0 + w11 * a1 + w12 * a2)
        qx = s2 * (w00 * b0 + w01 * b1 + w02 * b2)
        qy = s2 * (w10 * b0 + w11 * b1 + w12 * b2)
        xx, xy, yy = px * px + qx * qx + LOW_PASS, px * py + qx * qy, py * py + qy * qy + LOW_PASS
        big = max(max(abs(px), abs(py)), max(abs(qx), abs(qy)))
        # det(U U^T + l I) without the cancellation of xx yy - xy^2, over big^2, so that it fits float32
        per = ONE / max(big, ONE)
        cross = (px * per) * qy - (py * per) * qx
        det = cross * cross + (LOW_PASS * per) * ((xx + yy - LOW_PASS) * per)
        reach = _TWO_LN_2 * log2(max(o / CUT, ONE))
        hx = np.sqrt(reach * xx) + _MARGIN
        hy = min(np.sqrt(reach * yy) + _MARGIN, reach_max)
        seen = (front > _DEPTH_FLOOR) & (o > CUT) & (big < _FOOTPRINT_MAX)
        seen &= (abs(x) < _CENTRE_MAX) & (abs(y) < _CENTRE_MAX)
        seen &= (x + hx > ZERO) & (x - hx < w_px) & (y + hy > ZERO) & (y - hy < h_px)
        k, per = (_HALF_LOG2_E if seen else ZERO) / (det if seen else ONE), per * per
        projected[row + i - first, 0] = x if seen else CULLED
        projected[row + i - first, 1] = y if seen else CULLED
        projected[row + i - first, 2] = k * (per * yy) if seen else ZERO
        projected[row + i - first, 3] = -TWO * k * (per * xy) if seen else ZERO
        projected[row + i - first, 4] = k * (per * xx) if seen else ZERO
        projected[row + i - first, 5] = o if seen else ZERO
        projected[row + i - first, 6] = hx if seen else CULLED
        projected[row + i - first, 7] = hy if seen else CULLED


@numba.njit(fastmath=SAFE_FLAGS)
def drop_small(projected: FloatArray, contribution_min: float, first: int, last: int) -> None:
    """Culls rows [first, last) whose opacity times the integral of their Gaussian, px^2, is too little."""
    limit = np.float32(contribution_min)
    for i in range(first, last):
        a, b, c = projected[i, 2], projected[i, 3], projected[i, 4]
        root = np.sqrt(max(a * c - b * b / (TWO * TWO), ZERO))  # of det K, times log2(e) / 2
        small = projected[i, 5] * _PI_LOG2_E < limit * root
        projected[i, 6] = CULLED if small else projected[i, 6]
