"""What lies behind and beside everything else: one coarse, smooth layer at the farthest depth.

An orbit of 20 degrees looks past the pad, and through gaps that no front was continued under.  A blurred
continuation of the background is seen there instead of nothing, and finer levels inherit it.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.models.builtin.views.outpaint import Canvas
from wzviewer.worker.models.builtin.views.smoothing import push_pull

STRIDE_PX = 16  # of a pixel of the backdrop
REACH = 1.0  # of the frame, on each side: 46 degrees for the sky
SKY_SHARE = 0.1  # of a row, down to which the sky is its background
HORIZON_CELLS = 6  # of the backdrop, over which sky passes into ground
BEHIND = 0.02  # relative depth behind the farthest


def backdrop(canvas: Canvas, axis: DepthAxis) -> Layer:
    """Returns the layer behind a padded frame; it needs no search and takes a hundredth of a second.

    Args:
        canvas: the padded frame.
        axis: the depth coordinate.
    """
    rows, columns = (int(np.count_nonzero(canvas.inside.any(axis=k))) for k in (1, 0))
    reach = [round(REACH * side / STRIDE_PX) for side in (columns, rows)]
    shape = (-(-rows // STRIDE_PX) + 2 * reach[1], -(-columns // STRIDE_PX) + 2 * reach[0])
    offset = (-reach[0] * STRIDE_PX, -reach[1] * STRIDE_PX)
    image = _background_colors(canvas, shape, offset)
    farthest = np.full(shape, canvas.surface.relief.max(), np.float32)
    return Layer(image, axis.behind(farthest, BEHIND), np.ones(shape, np.bool_), offset, STRIDE_PX)


def _background_colors(canvas: Canvas, shape: tuple[int, int], offset: tuple[int, int]) -> FloatArray:
    """The colours of the background, continued smoothly, (h, w, 3): the sky above, the ground below it."""
    sky = canvas.surface.sky
    ground = _continued(canvas, _farther_half(canvas), shape, offset)
    if not sky.any():
        return ground
    rows = np.flatnonzero(sky.mean(axis=1) > SKY_SHARE)
    horizon_px = (rows[-1] if len(rows) else 0) - canvas.pad_px[1] - offset[1]
    below = np.clip(np.arange(shape[0]) + 0.5 - horizon_px / STRIDE_PX, 0, HORIZON_CELLS) / HORIZON_CELLS
    share = (below * below * (3 - 2 * below)).astype(np.float32, copy=False)[:, None, None]
    return share * ground + (1 - share) * _continued(canvas, sky, shape, offset)


def _continued(
    canvas: Canvas, part: BoolArray, shape: tuple[int, int], offset: tuple[int, int]
) -> FloatArray:
    """The colours of one part of a canvas (H, W), continued smoothly, (h, w, 3)."""
    weights = part.astype(np.float32)
    size = tuple(-(-side // STRIDE_PX) for side in weights.shape[::-1])
    share = cv2.resize(weights, size, interpolation=cv2.INTER_AREA)
    colors = cv2.resize(canvas.surface.image * weights[..., None], size, interpolation=cv2.INTER_AREA)
    colors /= np.maximum(share, 1e-6)[..., None]
    left = (-offset[0] - canvas.pad_px[0]) // STRIDE_PX
    top = (-offset[1] - canvas.pad_px[1]) // STRIDE_PX
    image, known = np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32)
    place = np.s_[top : top + size[1], left : left + size[0]]
    image[place], known[place] = colors, np.minimum(4.0 * share, 1.0)
    return np.clip(push_pull(image, known), 0.0, 1.0)


def _farther_half(canvas: Canvas) -> BoolArray:
    """The farther half of every row, (H, W): what is near would be a stain behind itself."""
    shift = canvas.surface.shift
    return np.asarray(shift <= np.median(shift, axis=1, keepdims=True))
