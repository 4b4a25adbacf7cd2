"""The lining of a picture: its own colours, softly, just behind it.

Between surfels as sharp as a pixel some light of what lies behind comes through: seen from closer than they
were made for, a bright sky behind a dark leaf draws a grid on it.  With a lining it is the leaf that comes
through.
"""

from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.objects.parts import Part
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.standing import OPAQUE, out_of_sight

STRIDE = 2  # native px: its surfels lie where four pixels meet
SIGMA_PX = 0.6  # of its own pixels: little more than what it lines, or it would look out beside an edge
REACH_PX = 3  # of a footprint: it is behind all that is seen within
JUST_PX = 0.5  # native px behind that
STEP_PX = 24.0  # native px of depth within reach: an edge, beside which it would look out
_NOTHING = np.float32(1e6)  # native px behind a part, where it ends: an edge
_HIDDEN_PX = 6  # around a hidden surfel: it may be one of a coarser level


def with_lining(draft: Draft) -> Draft:
    """Returns a draft with more layers, wherever its layers or hidden surfels lie behind its picture."""
    image = draft.image if draft.ground is None else draft.ground
    needed = _something_behind(draft) & ~draft.sky & ~out_of_sight(draft, draft.relief)
    ground = lining(image, draft.relief, needed)
    made = [layer for layer in (ground, *map(_part_lining, draft.parts)) if layer.mask.any()]
    return replace(draft, layers=(*draft.layers, *made)) if made else draft


def _part_lining(part: Part) -> Layer:
    """Returns the lining of a part of an object, on the same cells as that of the picture."""
    x, y = (-n % STRIDE for n in part.offset_px)
    color, alpha, relief = (a[y:, x:] for a in (part.color, part.alpha, part.relief))
    known = np.isfinite(relief)
    layer = lining(color, np.where(known, relief, _NOTHING), known & (alpha >= OPAQUE))
    return replace(layer, offset_px=(part.offset_px[0] + x, part.offset_px[1] + y))


def _something_behind(draft: Draft) -> BoolArray:
    """Tells which pixels (h, w) of a draft hide anything."""
    h, w = draft.relief.shape
    behind = np.zeros((h, w), np.uint8)
    view = AnchoredView.expand(draft.camera, draft.frame)
    column, row = np.floor(view.project(draft.hidden.means)).astype(np.int64).T
    inside = (column >= 0) & (column < w) & (row >= 0) & (row < h)
    behind[row[inside], column[inside]] = 1
    behind = cv2.dilate(behind, np.ones((2 * _HIDDEN_PX + 1,) * 2, np.uint8)).astype(np.uint8)
    for layer in draft.layers:
        y, x = np.nonzero(layer.mask)
        x, y = x * layer.stride + layer.offset_px[0], y * layer.stride + layer.offset_px[1]
        for down in range(layer.stride):
            for right in range(layer.stride):
                at = np.clip(y + down, 0, h - 1), np.clip(x + right, 0, w - 1)
                behind[at] = 1
    return np.asarray(behind > 0)


def lining(image: FloatArray, relief: FloatArray, needed: BoolArray) -> Layer:
    """Returns a layer at half the resolution, behind a picture.

    Args:
        image: (h, w, 3) float32 sRGB.
        relief: (h, w) float32 native px; finite.
        needed: (h, w) bool, where something else is behind.
    """
    h, w = (n // STRIDE for n in relief.shape)
    window = np.ones((2 * REACH_PX + 1,) * 2, np.uint8)
    farthest, nearest = cv2.dilate(relief, window), cv2.erode(relief, window)
    inside = needed & (farthest - nearest < STEP_PX)
    cells = _pooled(inside, h, w).all(axis=2)
    behind = _pooled(farthest, h, w).max(axis=2) + np.float32(JUST_PX)
    soft = cv2.resize(image[: h * STRIDE, : w * STRIDE], (w, h), interpolation=cv2.INTER_AREA)
    return Layer(soft, np.asarray(behind, np.float32), np.asarray(cells), (0, 0), STRIDE, SIGMA_PX)


def _pooled(picture: FloatArray | BoolArray, h: int, w: int) -> FloatArray | BoolArray:
    """Returns (h, w, 4) the pixels of each cell."""
    cells = picture[: h * STRIDE, : w * STRIDE].reshape(h, STRIDE, w, STRIDE)
    return cells.transpose(0, 2, 1, 3).reshape(h, w, STRIDE * STRIDE)
