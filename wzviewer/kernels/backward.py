"""The gradient of the composited image, walked front to back with nothing stored.

With g = dL/d image, S starts as g . image.  Behind the current fragment lies what remains of S once
its own part w (g . c) is taken out, so ``dL/d alpha = T (g . c) - S / (1 - alpha)``.

The tile rows form at most eight bands, each one task; a surfel never reaches further than the next
band (`HALF_HEIGHT_MAX_PX`), so two gradient buffers, for even and odd bands, need no lock.
"""

import numba
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.kernels.binning import TILE, Indices, Offsets
from wzviewer.kernels.elementary import CUT, FLAGS, HALF, MAX, ONE, STOP, ZERO, exp2
from wzviewer.kernels.forward import CHECK_EVERY, brightest, row_span

BAND_ROWS = 15  # tile rows of a band at least: 120 px
BANDS_MAX = 8
HALF_HEIGHT_MAX_PX = 56.0  # a surfel then spans at most 15 tile rows


@numba.njit(cache=True, nogil=True, parallel=True, fastmath=FLAGS)
def accumulate(
    projected: FloatArray,
    colors: FloatArray,
    starts: Offsets,
    members: Indices,
    image: FloatArray,
    gradient: FloatArray,
    behind: FloatArray,
    through: FloatArray,
    conic_gradients: FloatArray,
) -> None:
    """Adds dL/d(A, B, C, o) of every surfel, K = (A, B, C) being the conic in natural units.

    Args:
        projected: (n, 8) from `projection.project_range`.
        colors: (n, 3).
        starts: (tiles + 1,) from `binning.bin_tiles`.
        members: (pairs,) from `binning.bin_tiles`.
        image: (3, H, W) the composited image, background included.
        gradient: (3, H, W) dL/d image; 0 outside of the true image.
        behind: (H, W) scratch: S.
        through: (H, W) scratch: T.
        conic_gradients: (2, n, 4) float32, added to; their sum is the gradient.
    """
    tile_rows, columns = behind.shape[0] // TILE, behind.shape[1] // TILE
    bands = min(max(tile_rows // BAND_ROWS, 1), BANDS_MAX)
    red, green, blue = gradient[0], gradient[1], gradient[2]
    for band in numba.prange(bands):
        for tile_row in range(band * tile_rows // bands, (band + 1) * tile_rows // bands):
            y0 = tile_row * TILE
            for y in range(y0, y0 + TILE):
                for x in range(behind.shape[1]):
                    light = red[y, x] * image[0, y, x] + green[y, x] * image[1, y, x]
                    behind[y, x] = light + blue[y, x] * image[2, y, x]
                    through[y, x] = ONE
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
                    g_a, g_b, g_c, g_o = ZERO, ZERO, ZERO, ZERO
                    first, last = row_span(projected, i, y0)
                    for y in range(first, last):
                        dy = np.float32(y) + HALF - projected[i, 1]
                        flat, slope = -c * dy * dy, -b * dy
                        m0, m1, m2 = ZERO, ZERO, ZERO
                        for k in range(TILE):
                            dx = left + np.float32(k)
                            full = o * exp2(min(flat + (slope - a * dx) * dx, ZERO))
                            t = through[y, x0 + k]
                            live = (full >= CUT) & (t >= STOP)
                            alpha = min(full, MAX) if live else ZERO
                            towards = red[y, x0 + k] * r + green[y, x0 + k] * g + blue[y, x0 + k] * bl
                            w = t * alpha
                            s = behind[y, x0 + k] - w * towards
                            d_alpha = t * towards - s / (ONE - alpha)
                            q = d_alpha * alpha if full < MAX else ZERO  # dL/d log(o G)
                            m0 += q
                            m1 += q * dx
                            m2 += q * dx * dx
                            behind[y, x0 + k] = s
                            through[y, x0 + k] = t - w
                        g_a -= HALF * m2
                        g_b -= dy * m1
                        g_c -= HALF * dy * dy * m0
                        g_o += m0
                    conic_gradients[band & 1, i, 0] += g_a
                    conic_gradients[band & 1, i, 1] += g_b
                    conic_gradients[band & 1, i, 2] += g_c
                    conic_gradients[band & 1, i, 3] += g_o / o
