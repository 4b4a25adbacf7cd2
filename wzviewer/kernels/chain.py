"""From the conic back to quaternion, log scale and the opacity variable.

The optimiser's variables are q (any length), log s, and x with o = clip(0.51 tanh x + 0.5), so that a
surfel can become fully opaque or nearly vanish and still come back.
"""

import numba
import numpy as np

from wzviewer.core.constants import OPACITY_MAX, OPACITY_MIN
from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import BLOCK, HALF, LOG2_E, ONE, ORDERED_FLAGS, TWO, ZERO, exp2
from wzviewer.kernels.projection import jacobian, tangents

OPACITY_GAIN = 0.51
_GAIN = np.float32(OPACITY_GAIN)
_LOW, _HIGH = np.float32(OPACITY_MIN), np.float32(OPACITY_MAX)
_TANH_MAX = np.float32(9.0)
_TO_NATURAL = ONE / LOG2_E


def opacity_variable(opacities: FloatArray) -> FloatArray:
    """Inverse of the opacity activation: o (n,) -> x (n,), |tanh x| at most 0.985."""
    centred = (opacities.astype(np.float64) - 0.5) / OPACITY_GAIN
    return np.arctanh(np.clip(centred, -0.985, 0.985)).astype(np.float32)


@numba.njit(fastmath=ORDERED_FLAGS)
def _tanh(x: np.float32) -> np.float32:
    x = min(max(x, -_TANH_MAX), _TANH_MAX)
    return ONE - TWO / (exp2(TWO * LOG2_E * x) + ONE)


@numba.njit(fastmath=ORDERED_FLAGS)
def activate_range(
    log_scales: FloatArray, x: FloatArray, scales: FloatArray, opacities: FloatArray, first: int, last: int
) -> None:
    """Writes scales (n, 2) = exp(log_scales) and opacities (n,) = clip(0.51 tanh x + 0.5), from first on."""
    for i in range(first, last):
        scales[i, 0] = exp2(LOG2_E * log_scales[i, 0])
        scales[i, 1] = exp2(LOG2_E * log_scales[i, 1])
        opacities[i] = min(max(_GAIN * _tanh(x[i]) + HALF, _LOW), _HIGH)


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=ORDERED_FLAGS)
def activate(log_scales: FloatArray, x: FloatArray, scales: FloatArray, opacities: FloatArray) -> None:
    """`activate_range` of all."""
    n = x.size
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        activate_range(log_scales, x, scales, opacities, block * BLOCK, min((block + 1) * BLOCK, n))


@numba.njit(fastmath=ORDERED_FLAGS)
def _quat_gradient(
    quats: FloatArray,
    i: int,
    a0: np.float32,
    a1: np.float32,
    a2: np.float32,
    b0: np.float32,
    b1: np.float32,
    b2: np.float32,
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """dL/dq from dL/dt1 = a and dL/dt2 = b; q / |q| differentiated too."""
    w, x, y, z = quats[i, 0], quats[i, 1], quats[i, 2], quats[i, 3]
    k = ONE / np.sqrt(max(w * w + x * x + y * y + z * z, np.float32(1e-30)))
    w, x, y, z = k * w, k * x, k * y, k * z
    dw = TWO * (a1 * z - a2 * y - b0 * z + b2 * x)
    dx = TWO * (a1 * y + a2 * z + b0 * y - TWO * b1 * x + b2 * w)
    dy = TWO * (-TWO * a0 * y + a1 * x - a2 * w + b0 * x + b2 * z)
    dz = TWO * (-TWO * a0 * z + a1 * w + a2 * x - b0 * w - TWO * b1 * z + b2 * y)
    along = dw * w + dx * x + dy * y + dz * z
    return k * (dw - along * w), k * (dx - along * x), k * (dy - along * y), k * (dz - along * z)


@numba.njit(fastmath=ORDERED_FLAGS)
def chain_range(
    means: FloatArray,
    quats: FloatArray,
    scales: FloatArray,
    x: FloatArray,
    view: FloatArray,
    projected: FloatArray,
    conic_gradients: FloatArray,
    first: int,
    last: int,
    d_quats: FloatArray,
    d_log_scales: FloatArray,
    d_x: FloatArray,
) -> None:
    """Writes dL/d(q, log s, x) of surfels [first, last), and zeroes their ``conic_gradients``.

    Args:
        means: (n, 3).
        quats: (n, 4) wxyz, any length.
        scales: (n, 2), activated.
        x: (n,) opacity variable.
        view: (13,) from `projection.view_vector`.
        projected: (n, 8) from `projection.project_range` of the same parameters.
        conic_gradients: (2, n, 4) from `backward.accumulate`.
        first: surfel.
        last: surfel.
        d_quats: (m, 4) float32, written from the start.
        d_log_scales: (m, 2) float32, written.
        d_x: (m,) float32, written.
    """
    for i in range(first, last):
        g_a = conic_gradients[0, i, 0] + conic_gradients[1, i, 0]
        g_b = HALF * (conic_gradients[0, i, 1] + conic_gradients[1, i, 1])
        g_c = conic_gradients[0, i, 2] + conic_gradients[1, i, 2]
        g_o = conic_gradients[0, i, 3] + conic_gradients[1, i, 3]
        for k in range(4):
            conic_gradients[0, i, k] = ZERO
            conic_gradients[1, i, k] = ZERO
        if g_a == ZERO and g_b == ZERO and g_c == ZERO and g_o == ZERO:  # unseen from here
            d_quats[i - first, :] = ZERO
            d_log_scales[i - first, :] = ZERO
            d_x[i - first] = ZERO
            continue
        # K in natural units; dL/dCov = -K [[g_a, g_b], [g_b, g_c]] K
        a = TWO * _TO_NATURAL * projected[i, 2]
        b = _TO_NATURAL * projected[i, 3]
        c = TWO * _TO_NATURAL * projected[i, 4]
        h00, h01 = g_a * a + g_b * b, g_a * b + g_b * c
        h10, h11 = g_b * a + g_c * b, g_b * b + g_c * c
        s00, s01, s11 = -(a * h00 + b * h10), -(a * h01 + b * h11), -(b * h01 + c * h11)
        _, _, _, w00, w01, w02, w10, w11, w12 = jacobian(means, view, i)
        t0, t1, t2, r0, r1, r2 = tangents(quats, i)
        s1, s2 = scales[i, 0], scales[i, 1]
        px, py = s1 * (w00 * t0 + w01 * t1 + w02 * t2), s1 * (w10 * t0 + w11 * t1 + w12 * t2)
        qx, qy = s2 * (w00 * r0 + w01 * r1 + w02 * r2), s2 * (w10 * r0 + w11 * r1 + w12 * r2)
        d_px, d_py = TWO * (s00 * px + s01 * py), TWO * (s01 * px + s11 * py)
        d_qx, d_qy = TWO * (s00 * qx + s01 * qy), TWO * (s01 * qx + s11 * qy)
        dw, dx, dy, dz = _quat_gradient(
            quats,
            i,
            s1 * (w00 * d_px + w10 * d_py),
            s1 * (w01 * d_px + w11 * d_py),
            s1 * (w02 * d_px + w12 * d_py),
            s2 * (w00 * d_qx + w10 * d_qy),
            s2 * (w01 * d_qx + w11 * d_qy),
            s2 * (w02 * d_qx + w12 * d_qy),
        )
        th = _tanh(x[i])
        d_quats[i - first, 0] = dw
        d_quats[i - first, 1] = dx
        d_quats[i - first, 2] = dy
        d_quats[i - first, 3] = dz
        d_log_scales[i - first, 0] = px * d_px + py * d_py
        d_log_scales[i - first, 1] = qx * d_qx + qy * d_qy
        d_x[i - first] = g_o * _GAIN * (ONE - th * th)
