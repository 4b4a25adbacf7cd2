"""Hidden sky is calm: the sky that is seen goes on smoothly behind everything, with faint clouds.

::

    sky that is seen ──► backdrop, coarse ──► field: the same, and near the sky that is seen like it
                                                 │
    patches of the picture ──► only what is finer than a cloud, fading towards the rim ──► hidden sky

Patches of a cloudy sky laid side by side are shards with edges; where a camera turned far looks past a
flower, such a shard beside the true sky is seen at once.  One field for all hidden layers and the backdrop
leaves no border between them.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.backdrop import STRIDE_PX
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.models.builtin.views.outpaint import Canvas
from wzviewer.worker.models.builtin.views.smoothing import masked_blur, push_pull

SHRINK = 8  # the large colours are made at this fraction of the resolution
SIGMA_PX = 2.0  # of what counts as large, there
NEAR_PX = 40.0  # from the sky that is seen, within which the field is like it
CLOUD_SHARE, CLOUD_LIMIT = 0.6, 0.025  # of the patches' fine differences, sRGB
RIM_PX = 24.0  # from the rim of a layer, over which they fade


def sky_field(canvas: Canvas, behind: Layer) -> FloatArray | None:
    """Returns the colours of the sky behind everything, (H, W, 3) float32; None without a sky.

    Args:
        canvas: the padded frame.
        behind: its backdrop.
    """
    surface = canvas.surface
    if not surface.sky.any():
        return None
    coarse = _on_canvas(behind, canvas)
    off, share = _shrunk(surface.image - coarse, surface.sky)
    away = SHRINK * cv2.distanceTransform((share < 0.5).astype(np.uint8), cv2.DIST_L2, 5)
    off = off * np.exp(-((away / np.float32(NEAR_PX)) ** 2))[..., None]
    return np.clip(coarse + _grown(off.astype(np.float32), surface.sky), 0, 1).astype(np.float32)


def calm_sky(image: FloatArray, hidden: BoolArray, known: BoolArray, field: FloatArray | None) -> FloatArray:
    """Returns a picture whose hidden sky has the field's colours and only fine differences of its own.

    Args:
        image: (h, w, 3) float32 sRGB in [0, 1], painted with patches.
        hidden: (h, w) bool, the sky that was painted.
        known: (h, w) bool, the sky beside it that stays as it is.
        field: (h, w, 3) of `sky_field`; None changes nothing.
    """
    if field is None or not hidden.any():
        return image
    low, _ = _shrunk(image, known | hidden)
    fine = np.clip(CLOUD_SHARE * (image - _grown(low, hidden)), -CLOUD_LIMIT, CLOUD_LIMIT)
    inside = cv2.distanceTransform((known | hidden).astype(np.uint8), cv2.DIST_L2, 5)
    fine *= np.minimum(inside / np.float32(RIM_PX), 1)[..., None]
    return np.where(hidden[..., None], np.clip(field + fine, 0, 1), image).astype(np.float32)


def _on_canvas(layer: Layer, canvas: Canvas) -> FloatArray:
    """Returns the picture of a coarse layer at the resolution of a canvas, (H, W, 3)."""
    height, width = canvas.inside.shape
    left, top = (-pad - offset for pad, offset in zip(canvas.pad_px, layer.offset_px, strict=True))
    scale = 1.0 / STRIDE_PX
    moves = np.array([[scale, 0, (left + 0.5) * scale - 0.5], [0, scale, (top + 0.5) * scale - 0.5]])
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    size = (width, height)
    picture = cv2.warpAffine(layer.image, moves, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picture, np.float32)


def _shrunk(image: FloatArray, mask: BoolArray) -> tuple[FloatArray, FloatArray]:
    """The large colours of a masked part, continued smoothly, and its share, both at the low resolution."""
    size = tuple(-(-side // SHRINK) for side in mask.shape[::-1])
    share = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    colors = cv2.resize(image * mask[..., None], size, interpolation=cv2.INTER_AREA)
    colors = np.asarray(colors / np.maximum(share, 1e-6)[..., None], np.float32)
    filled = push_pull(colors, np.minimum(4 * share, 1).astype(np.float32))
    return masked_blur(filled, np.ones(share.shape, np.bool_), SIGMA_PX), np.asarray(share, np.float32)


def _grown(colors: FloatArray, like: BoolArray) -> FloatArray:
    """Enlarges to the resolution of a mask (h, w)."""
    return np.asarray(cv2.resize(colors, like.shape[::-1], interpolation=cv2.INTER_CUBIC), np.float32)
