"""Where the layers end: their colours and depths go on, soft and coarse, farther under what is in front.

The layers reach as far as an orbit of 12 degrees looks under an edge.  A camera turned farther saw their
ragged ends there, and between them the backdrop, flat and of another colour.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.layers import BEHIND, CONTEXT_STEP, Layer, Surface, behind_front
from wzviewer.worker.models.builtin.views.smoothing import dilated, masked_blur, push_pull

STRIDE_PX = 4
FARTHER = 0.2  # tan of the orbit beyond that of the layers: 23 degrees in all
OVERLAP = 5  # cells, behind the ends of the layers
SOFT = 2.0  # cells


def underlay(
    front: Surface,
    layer: Surface,
    painted: BoolArray,
    kept: BoolArray,
    offset_px: tuple[int, int],
    axis: DepthAxis,
) -> Layer:
    """Returns the continuation of a layer, behind it.

    Args:
        front: what is seen from the source camera, on a canvas.
        layer: the first layer behind it.
        painted: (h, w) bool, where it has been painted.
        kept: (h, w) bool, of that, what is kept as it is.
        offset_px: image pixel of the canvas origin.
        axis: the depth coordinate.
    """
    size = tuple(side // STRIDE_PX for side in painted.shape[::-1])
    solid = (painted & ~layer.sky).astype(np.float32)
    share = cv2.resize(solid, size, interpolation=cv2.INTER_AREA)
    colors, far = (_pooled(v, solid, share, size) for v in (layer.image, layer.shift))
    rows = np.arange(size[1]) * STRIDE_PX
    columns = np.arange(size[0]) * STRIDE_PX
    near, sky, own = (v[rows][:, columns] for v in (front.shift, layer.sky & painted, kept & ~layer.sky))
    wanted = _within_reach(own, sky, near, far, axis)
    window = np.ones((2 * STRIDE_PX + 1,) * 2, np.uint8)
    farthest = np.asarray(cv2.dilate(front.relief, window), np.float32)[rows][:, columns]
    relief, hidden = behind_front(axis.behind(axis.relief_of(far), BEHIND), farthest, axis)
    return Layer(colors, relief, wanted & hidden, offset_px, STRIDE_PX)


def _pooled(values: FloatArray, solid: FloatArray, share: FloatArray, size: tuple[int, ...]) -> FloatArray:
    """Means of what is solid in each cell, (h, w) or (h, w, 3), continued smoothly over the others."""
    flat = values.ndim == 2
    total = cv2.resize(values * (solid if flat else solid[..., None]), size, interpolation=cv2.INTER_AREA)
    mean = (total / np.maximum(share if flat else share[..., None], 1e-6)).astype(np.float32, copy=False)
    filled = push_pull(mean, np.minimum(4 * share, 1).astype(np.float32, copy=False))
    return masked_blur(filled, np.ones(share.shape, np.bool_), SOFT)


def _within_reach(
    known: BoolArray, sky: BoolArray, near: FloatArray, far: FloatArray, axis: DepthAxis
) -> BoolArray:
    """Cells (h, w) under what is nearer, as far from the layer as the orbit goes on, and not beside a sky."""
    if not known.any():
        return known
    away, from_sky = (
        cv2.distanceTransform((~part).astype(np.uint8), cv2.DIST_L2, 5) if part.any() else np.float32(np.inf)
        for part in (known, sky)
    )
    under = near > far + axis.step_of(far, CONTEXT_STEP)
    reach = FARTHER * (near - far) / STRIDE_PX + 1
    inside = dilated(~known, OVERLAP) | ~known
    return np.asarray(under & inside & (away <= reach) & (away < from_sky))
