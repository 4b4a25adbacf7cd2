"""Adam (Kingma and Ba, 2015)."""

import numba
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.kernels.elementary import FLAGS, ONE

BETA_1, BETA_2, EPSILON = 0.5, 0.99, 1e-15


@numba.njit(fastmath=FLAGS)
def adam_range(
    values: FloatArray,
    gradients: FloatArray,
    first: FloatArray,
    second: FloatArray,
    step: np.float32,
    root: np.float32,
) -> None:
    """One step in place; all arrays are flat.

    Args:
        values: (n,).
        gradients: (n,).
        first: (n,) moment.
        second: (n,) moment.
        step: rate / (1 - beta_1^t).
        root: 1 / (1 - beta_2^t).
    """
    eps, b1, b2 = np.float32(EPSILON), np.float32(BETA_1), np.float32(BETA_2)
    for i in range(values.size):
        g = gradients[i]
        m = b1 * first[i] + (ONE - b1) * g
        v = b2 * second[i] + (ONE - b2) * g * g
        first[i] = m
        second[i] = v
        values[i] -= step * m / (np.sqrt(root * v) + eps)
