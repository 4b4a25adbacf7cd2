"""What a step of the optimiser does to each surfel, in two passes over the blocks that a view sees.

::

    look        log s, x ──► s, o ──► projected rows ──► spans of tiles
                                                             │ bin, composite, loss, accumulate
    descend     q, log s, x ◄── Adam ◄── chain ◄── dL/d conic

Each block of 4096 surfels goes through all of a pass at once, while it is in the cache: as a kernel for
each arrow the two took 1.4 times as long.  Surfels out of view stay as they are, their moments too.
"""

import numba
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.kernels.adam import adam_range
from wzviewer.kernels.binning import Offsets, Spans, span_range
from wzviewer.kernels.chain import activate_range, chain_range
from wzviewer.kernels.elementary import BLOCK, ZERO
from wzviewer.kernels.projection import project_range


@numba.njit(cache=True, nogil=True, parallel=True)
def look(
    means: FloatArray,
    quats: FloatArray,
    log_scales: FloatArray,
    x: FloatArray,
    view: FloatArray,
    width: int,
    height: int,
    half_height_max: float,
    blocks: Offsets,
    scales: FloatArray,
    opacities: FloatArray,
    projected: FloatArray,
    spans: Spans,
) -> None:
    """Activates and projects.

    Args:
        means: (n, 3) local positions.
        quats: (n, 4) wxyz, any length.
        log_scales: (n, 2).
        x: (n,) opacity variable.
        view: (13,) from `projection.view_vector`.
        width: image width, px.
        height: image height, px.
        half_height_max: limit of the half extent in y, px.
        blocks: (k,) of the surfels, from `binning.front_to_back`; of all others nothing is written.
        scales: (n, 2) written.
        opacities: (n,) written.
        projected: (n, 8) written, see `projection`.
        spans: (n,) written, see `binning`.
    """
    n = x.size
    for k in numba.prange(blocks.size):
        first, last = blocks[k] * BLOCK, min((blocks[k] + 1) * BLOCK, n)
        activate_range(log_scales, x, scales, opacities, first, last)
        project_range(
            means,
            quats,
            scales,
            opacities,
            view,
            width,
            height,
            half_height_max,
            projected,
            first,
            last,
            first,
        )
        span_range(projected, width, height, spans, first, last)


@numba.njit(cache=True, nogil=True, parallel=True)
def descend(
    means: FloatArray,
    quats: FloatArray,
    log_scales: FloatArray,
    x: FloatArray,
    view: FloatArray,
    scales: FloatArray,
    projected: FloatArray,
    conic_gradients: FloatArray,
    blocks: Offsets,
    kept: BoolArray,
    steps: FloatArray,
    root: np.float32,
    quat_moments: FloatArray,
    scale_moments: FloatArray,
    x_moments: FloatArray,
) -> None:
    """Moves q, log s and x down the gradient, in place, and zeroes ``conic_gradients``.

    Args:
        means: (n, 3).
        quats: (n, 4) wxyz, any length.
        log_scales: (n, 2).
        x: (n,) opacity variable.
        view: (13,) from `projection.view_vector`.
        scales: (n, 2) from `look`.
        projected: (n, 8) from `look`.
        conic_gradients: (2, n, 4) from `backward.accumulate`.
        blocks: (k,) of the surfels that move.
        kept: (n,) those among them that do not.
        steps: (3,) rates of q, log s and x, over 1 - beta_1^t.
        root: 1 / (1 - beta_2^t).
        quat_moments: (2, n, 4) of Adam.
        scale_moments: (2, n, 2).
        x_moments: (2, n).
    """
    n = x.size
    for k in numba.prange(blocks.size):
        first, last = blocks[k] * BLOCK, min((blocks[k] + 1) * BLOCK, n)
        slopes = np.empty((last - first, 4), np.float32), np.empty((last - first, 2), np.float32)
        x_slopes = np.empty(last - first, np.float32)
        surfels = (means, quats, scales, x, view, projected, conic_gradients)
        chain_range(*surfels, first, last, slopes[0], slopes[1], x_slopes)
        for i in range(first, last):
            if kept[i]:
                slopes[0][i - first, :] = ZERO
                slopes[1][i - first, :] = ZERO
                x_slopes[i - first] = ZERO
        m, v = quat_moments[0, first:last], quat_moments[1, first:last]
        flat = (slopes[0].reshape(-1), m.reshape(-1), v.reshape(-1))
        adam_range(quats[first:last].reshape(-1), *flat, steps[0], root)
        m, v = scale_moments[0, first:last], scale_moments[1, first:last]
        flat = (slopes[1].reshape(-1), m.reshape(-1), v.reshape(-1))
        adam_range(log_scales[first:last].reshape(-1), *flat, steps[1], root)
        m, v = x_moments[0, first:last], x_moments[1, first:last]
        adam_range(x[first:last], x_slopes, m, v, steps[2], root)


@numba.njit(cache=True, nogil=True, parallel=True)
def gradients(
    means: FloatArray,
    quats: FloatArray,
    scales: FloatArray,
    x: FloatArray,
    view: FloatArray,
    projected: FloatArray,
    conic_gradients: FloatArray,
    d_quats: FloatArray,
    d_log_scales: FloatArray,
    d_x: FloatArray,
) -> None:
    """Writes dL/d(q, log s, x) (n, 4), (n, 2) and (n,) instead of following it; arguments as of `descend`."""
    n = x.size
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min((block + 1) * BLOCK, n)
        out = (d_quats[first:last], d_log_scales[first:last], d_x[first:last])
        chain_range(means, quats, scales, x, view, projected, conic_gradients, first, last, *out)


@numba.njit(cache=True, nogil=True)
def add_lacking(
    projected: FloatArray,
    order: Offsets,
    image: FloatArray,
    target: FloatArray,
    mask: FloatArray,
    width: int,
    height: int,
    colors: FloatArray,
) -> None:
    """Adds to the colour of the nearest surfel centred in each pixel what the pixel lacks, within [0, 1].

    Args:
        projected: (n, 8) from `look`.
        order: (m,) uint32, front to back.
        image: (3, H, W) as it is.
        target: (3, H, W) as it should be.
        mask: (H, W) 0 where that is unknown.
        width: true image width, px.
        height: true image height, px.
        colors: (n, 3) changed.
    """
    owned = np.zeros((height, width), np.bool_)
    for i in order:
        x, y = projected[i, 0], projected[i, 1]
        if x < ZERO or y < ZERO or x >= width or y >= height:
            continue
        row, column = int(y), int(x)
        if owned[row, column]:
            continue
        owned[row, column] = True
        if mask[row, column] > ZERO:
            for k in range(3):
                lacking = target[k, row, column] - image[k, row, column]
                colors[i, k] = min(max(colors[i, k] + lacking, ZERO), np.float32(1.0))
