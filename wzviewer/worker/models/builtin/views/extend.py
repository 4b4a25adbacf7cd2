"""A picture with depth continued over parts of it that are not known: sky, ground and texture go on.

`outpaint` pads a whole frame; here the known part may have any shape, as when a camera has moved on at
the same scale and sees the border of what there is.
"""

from collections.abc import Callable

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.exemplar import FillTask, fill
from wzviewer.worker.models.builtin.views.layers import Surface
from wzviewer.worker.models.builtin.views.outpaint import OUTSIDE_RULE, copied_sky
from wzviewer.worker.models.builtin.views.smoothing import blur

ORIGIN_INSET_PX = 48  # how far inside the known part the search for a pixel beyond its border begins
SKY_SIGMA_PX = 20.0
GROUND_SIGMA_PX = 12.0


def extended(
    frame: Surface, known: BoolArray, axis: DepthAxis, seed: int, check: Callable[[], None] | None = None
) -> Surface:
    """Returns the picture with its unknown part painted, at the depth that the known part suggests.

    Args:
        frame: the picture; whatever is in its unknown part is ignored.
        known: (h, w) bool, some of it true.
        axis: the depth coordinate.
        seed: of the candidate search.
        check: called now and then; may raise `Cancelled`.
    """
    ground, origin = _continued_ground(frame, known), _origins(known)
    label = _likely_sky(frame.sky & known, origin)
    far = float(np.median(frame.shift[frame.sky & known])) if (frame.sky & known).any() else 0.0
    guess = np.where(label, np.float32(far), ground)
    picture = np.where(known[..., None], frame.image, np.float32(0)).astype(np.float32, copy=False)
    logs = axis.log_of(np.where(known, frame.shift, guess)), axis.log_of(guess)
    task = FillTask(picture, known, ~known, picture, known, *logs, origin)
    image, copied_from = fill(task, OUTSIDE_RULE, seed, check)
    sky = copied_sky(frame.sky, copied_from, known, label)
    shift = np.where(known, frame.shift, np.where(sky, np.float32(far), ground)).astype(
        np.float32, copy=False
    )
    relief = np.where(known, frame.relief, axis.relief_of(shift)).astype(np.float32, copy=False)
    return Surface(image, shift, relief, sky)


def _continued_ground(frame: Surface, known: BoolArray) -> FloatArray:
    """The shift (h, w) of all but the sky: the nearest that is known, smooth beyond the border."""
    solid = known & ~frame.sky
    if not solid.any():
        return np.zeros_like(frame.shift)
    place = _nearest(solid)
    nearest = frame.shift[place[..., 0], place[..., 1]]
    return np.where(solid, frame.shift, blur(nearest, GROUND_SIGMA_PX)).astype(np.float32, copy=False)


def _likely_sky(sky: BoolArray, origin: IntArray) -> BoolArray:
    """Guesses where the sky goes on (h, w): where it is at the nearest place well inside what is known."""
    there = sky[origin[..., 0], origin[..., 1]].astype(np.float32)
    return np.asarray(blur(there, SKY_SIGMA_PX) > 0.5)


def _origins(known: BoolArray) -> IntArray:
    """For every pixel (h, w, 2), row and column of a known one near it, well inside the border."""
    window = np.ones((2 * ORIGIN_INSET_PX + 1,) * 2, np.uint8)
    inner = cv2.erode(known.astype(np.uint8), window, borderValue=1) > 0
    return _nearest(inner if inner.any() else known)


def _nearest(mask: BoolArray) -> IntArray:
    """For every pixel (h, w, 2), row and column of the nearest one of a mask."""
    far = 1 - mask.astype(np.uint8)
    _, labels = cv2.distanceTransformWithLabels(far, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    rows, columns = np.nonzero(mask)
    place = np.zeros((int(labels.max()) + 1, 2), np.int32)
    place[labels[rows, columns]] = np.stack([rows, columns], -1)
    return np.ascontiguousarray(place[labels])
