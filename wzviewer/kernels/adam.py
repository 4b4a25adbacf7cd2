"""Adam (Kingma and Ba, 2015)."""

import numba
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import BLOCK, FLAGS, ONE

BETA_1, BETA_2, EPSILON = 0.5, 0.99, 1e-15


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def adam_step(
    values: FloatArray,
    gradients: FloatArray,
    first: FloatArray,
    second: FloatArray,
    rate: float,
    bias_1: float,
    bias_2: float,
) -> None:
    """One step in place; all arrays are flat, ``bias_i`` = 1 - beta_i^t."""
    step, root, eps = np.float32(rate / bias_1), np.float32(1.0 / bias_2), np.float32(EPSILON)
    b1, b2 = np.float32(BETA_1), np.float32(BETA_2)
    n = values.size
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        for i in range(block * BLOCK, min((block + 1) * BLOCK, n)):
            g = gradients[i]
            m = b1 * first[i] + (ONE - b1) * g
            v = b2 * second[i] + (ONE - b2) * g * g
            first[i] = m
            second[i] = v
            values[i] -= step * m / (np.sqrt(root * v) + eps)
