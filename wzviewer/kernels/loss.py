"""0.8 L1 + 0.2 D-SSIM and its gradient (paper, Sec. 3.1; D-SSIM = 1 - mean SSIM).

SSIM (Wang et al., 2004) with an 11-tap Gaussian of sigma 1.5, zero outside of the image, per channel.
Each task is one row of one channel: vertical taps as sums of rows, then horizontal ones.
"""

import numba
import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.kernels.elementary import FLAGS, ONE, TWO, ZERO

L1_SHARE, SSIM_SHARE = 0.8, 0.2
RADIUS = 5
_C1, _C2 = np.float32(0.01**2), np.float32(0.03**2)


def window() -> FloatArray:
    """Returns the (11,) float32 weights of the SSIM window."""
    g = np.exp(-0.5 * (np.arange(-RADIUS, RADIUS + 1) / 1.5) ** 2)
    return (g / g.sum()).astype(np.float32)


@numba.njit(fastmath=FLAGS)
def _horizontal(row: FloatArray, g: FloatArray, x: int) -> float:
    """Blurs a padded row at x; ``row[x + RADIUS]`` is the pixel itself."""
    total = g[RADIUS] * row[x + RADIUS]
    for k in range(RADIUS):
        total += g[k] * (row[x + k] + row[x + 2 * RADIUS - k])
    return total


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def ssim_partials(
    image: FloatArray,
    target: FloatArray,
    mean: FloatArray,
    variance: FloatArray,
    g: FloatArray,
    height: int,
    width: int,
    partials: FloatArray,
    row_sums: DoubleArray,
) -> None:
    """Writes the derivatives of SSIM by the blurs of x, x^2 and x y, and SSIM's row sums.

    Args:
        image: (3, H, W) x.
        target: (3, H, W) y.
        mean: (3, H, W) local mean of the target.
        variance: (3, H, W) local variance of the target.
        g: (11,) window.
        height: true image height, px.
        width: true image width, px.
        partials: (3, 3, H, W) written: [which blur, channel].
        row_sums: (3 height,) float64, written.
    """
    for task in numba.prange(3 * height):
        c, y = task // height, task % height
        m = np.zeros(width + 2 * RADIUS, np.float32)
        mm = np.zeros(width + 2 * RADIUS, np.float32)
        mt = np.zeros(width + 2 * RADIUS, np.float32)
        for k in range(max(0, RADIUS - y), min(2 * RADIUS + 1, height + RADIUS - y)):
            for x in range(width):
                value = image[c, y + k - RADIUS, x]
                m[x + RADIUS] += g[k] * value
                mm[x + RADIUS] += g[k] * value * value
                mt[x + RADIUS] += g[k] * value * target[c, y + k - RADIUS, x]
        total = 0.0
        for x in range(width):
            mu, mu_y = _horizontal(m, g, x), mean[c, y, x]
            var_x = _horizontal(mm, g, x) - mu * mu
            covariance = _horizontal(mt, g, x) - mu * mu_y
            n1, n2 = TWO * mu * mu_y + _C1, TWO * covariance + _C2
            e1, e2 = mu * mu + mu_y * mu_y + _C1, var_x + variance[c, y, x] + _C2
            s = n1 * n2 / (e1 * e2)
            d_var, d_cov = -s / e2, TWO * n1 / (e1 * e2)
            d_mu = TWO * mu_y * n2 / (e1 * e2) - TWO * mu * s / e1
            partials[0, c, y, x] = d_mu - TWO * mu * d_var - mu_y * d_cov
            partials[1, c, y, x] = d_var
            partials[2, c, y, x] = d_cov
            total += s
        row_sums[task] = total


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def loss_gradient(
    image: FloatArray,
    target: FloatArray,
    mask: FloatArray,
    partials: FloatArray,
    g: FloatArray,
    height: int,
    width: int,
    gradient: FloatArray,
    row_sums: DoubleArray,
) -> None:
    """Writes dL/dx of 0.8 mean |x - y| - 0.2 mean SSIM, 0 where the mask is 0, and |x - y| row sums.

    Args:
        image: (3, H, W) x.
        target: (3, H, W) y.
        mask: (H, W) 1 or 0.
        partials: (3, 3, H, W) from `ssim_partials`.
        g: (11,) window.
        height: true image height, px.
        width: true image width, px.
        gradient: (3, H, W) written.
        row_sums: (3 height,) float64, written.
    """
    l1 = np.float32(L1_SHARE / (3 * height * width))
    ssim = np.float32(SSIM_SHARE / (3 * height * width))
    for task in numba.prange(3 * height):
        c, y = task // height, task % height
        d1 = np.zeros(width + 2 * RADIUS, np.float32)
        d2 = np.zeros(width + 2 * RADIUS, np.float32)
        d3 = np.zeros(width + 2 * RADIUS, np.float32)
        for k in range(max(0, RADIUS - y), min(2 * RADIUS + 1, height + RADIUS - y)):
            for x in range(width):
                d1[x + RADIUS] += g[k] * partials[0, c, y + k - RADIUS, x]
                d2[x + RADIUS] += g[k] * partials[1, c, y + k - RADIUS, x]
                d3[x + RADIUS] += g[k] * partials[2, c, y + k - RADIUS, x]
        blurred = np.empty((3, width), np.float32)
        for x in range(width):
            blurred[0, x], blurred[1, x] = _horizontal(d1, g, x), _horizontal(d2, g, x)
            blurred[2, x] = _horizontal(d3, g, x)
        total = 0.0
        for x in range(width):
            value, aim = image[c, y, x], target[c, y, x]
            difference = value - aim
            sign = ONE if difference > ZERO else (-ONE if difference < ZERO else ZERO)
            d_ssim = blurred[0, x] + TWO * value * blurred[1, x] + aim * blurred[2, x]
            gradient[c, y, x] = mask[y, x] * (l1 * sign - ssim * d_ssim)
            total += abs(difference)
        row_sums[task] = total


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def hide_masked(image: FloatArray, target: FloatArray, mask: FloatArray, height: int, width: int) -> None:
    """Puts the target (3, H, W) into the image where the mask (H, W) is 0, so no window bleeds."""
    for task in numba.prange(3 * height):
        c, y = task // height, task % height
        for x in range(width):
            image[c, y, x] = image[c, y, x] if mask[y, x] > ZERO else target[c, y, x]
