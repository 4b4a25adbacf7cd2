"""Background layers: the hidden surfaces behind every depth edge, with depth and colour.

The depth of a layer is the depth of the rims around it, blended; its colour is an exemplar fill that
takes the far side of the edges as context and the whole original picture as source.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.edges import RELATIVE_STEP
from wzviewer.worker.models.builtin.views.exemplar import FillRule, FillTask, fill
from wzviewer.worker.models.builtin.views.fronts import Fronts, grow_fronts
from wzviewer.worker.models.builtin.views.smoothing import dilated, masked_blur, push_pull

FRINGE_PX = 2  # the layer overlaps the far side by this much
CONTEXT_PX = 25
CONTEXT_STEP = 0.10  # relative depth by which a pixel must be nearer than the layer to be foreground
RIM_PX = 9
HARMONIC_SHARE = 0.4
RIM_BLUR_PX = 3.0
DEPTH_FREEDOM = 0.2  # relative depth that smoothing may move a layer away from its rim
FIRST_RULE = FillRule()
DEEPER_RULE = FillRule(scattered=64, guide_cost=0.0)  # small regions: no large shapes to guide
BEHIND = 0.004  # relative depth margin behind the front
SKY_STEP = 0.5  # relative inverse depth by which a point may be nearer than the sky and still be it
PUSH_LIMIT = 0.1  # log depth beyond which a layer pixel is dropped instead of pushed back


@dataclass(frozen=True)
class Layer:
    """Pixels that are hidden, or outside the frame, in the source view.

    Attributes:
        image: (h, w, 3) float32 sRGB in [0, 1].
        relief: (h, w) float32, native px of the level, + farther; finite.
        mask: (h, w) bool, the pixels that become surfels.
        offset_px: (x0, y0): layer pixel (row i, column j) covers image pixels from
            (y0 + i stride, x0 + j stride); negative outside the frame.
        stride: side of a layer pixel in native px.
        sigma_px: standard deviation of its surfels, in its own pixels.
    """

    image: FloatArray
    relief: FloatArray
    mask: BoolArray
    offset_px: tuple[int, int]
    stride: int = 1
    sigma_px: float = 0.75  # not optimised: softer than the front, and closed


@dataclass(frozen=True)
class Surface:
    """A picture with depth on one canvas.

    Attributes:
        image: (h, w, 3) float32 sRGB in [0, 1].
        shift: (h, w) float32, `DepthAxis` shift, px.
        relief: (h, w) float32, native px.
        sky: (h, w) bool.
    """

    image: FloatArray
    shift: FloatArray
    relief: FloatArray
    sky: BoolArray


@dataclass(frozen=True)
class Original:
    """The photographed part of a canvas, the only source of patches.

    Attributes:
        image: (h, w, 3) float32 sRGB in [0, 1].
        log_depth: (h, w) float32, `DepthAxis.log_of`.
        usable: (h, w) bool.
        sky: (h, w) bool.
    """

    image: FloatArray
    log_depth: FloatArray
    usable: BoolArray
    sky: BoolArray

    def from_sky(self, copied_from: IntArray) -> BoolArray:
        """Tells which pixels (h, w) were copied (h, w, 2) from the sky: on what is nearer they are shards."""
        return np.asarray((copied_from[..., 0] >= 0) & self.sky[copied_from[..., 0], copied_from[..., 1]])


def background_layer(
    front: Surface,
    original: Original,
    allowed: BoolArray,
    axis: DepthAxis,
    gain: float,
    seed: int,
    check: Callable[[], None] | None = None,
    rule: FillRule = FIRST_RULE,
) -> tuple[Surface, BoolArray]:
    """Makes the layer behind all depth edges of a surface.

    Args:
        front: what the layer lies behind.
        original: where patches come from.
        allowed: (h, w) bool, where hidden pixels are wanted.
        axis: the depth coordinate.
        gain: tan of the largest orbit angle.
        seed: of the candidate search.
        check: called now and then; may raise `Cancelled`.
        rule: of the fill.

    Returns:
        The front with the layer in its place, and the layer's pixels (h, w) bool; none if there is no edge.
    """
    fronts = grow_fronts(front.shift, axis, gain, allowed, front.sky)
    if not fronts.reached.any():
        return front, fronts.reached
    rim_shift = push_pull(fronts.shift, fronts.reached.astype(np.float32))
    nearer = front.shift > rim_shift + axis.step_of(rim_shift, CONTEXT_STEP)
    level = front.shift <= rim_shift + axis.step_of(rim_shift, RELATIVE_STEP)
    fringe = dilated(fronts.reached, FRINGE_PX) & ~fronts.reached & level & allowed
    mask = fronts.reached | fringe
    known = dilated(mask, CONTEXT_PX) & ~mask & ~nearer
    is_sky = front.sky[fronts.origin[..., 0], fronts.origin[..., 1]] & mask
    shift = _layer_shift(fronts, mask, known, is_sky, front, axis)
    relief, hidden = behind_front(axis.relief_of(shift), front.relief, axis)
    task = FillTask(
        front.image,
        known,
        mask,
        original.image,
        original.usable,
        original.log_depth,
        axis.log_of(shift),
        fronts.origin,
    )
    image, copied_from = fill(task, rule, seed, check)
    hidden &= is_sky | ~original.from_sky(copied_from)
    relief = np.where(mask, relief, front.relief)
    shift = np.where(mask, axis.shift_of(relief), front.shift)
    return Surface(image, shift, relief, np.where(mask, is_sky, front.sky)), mask & hidden


def _layer_shift(
    fronts: Fronts, mask: BoolArray, known: BoolArray, is_sky: BoolArray, front: Surface, axis: DepthAxis
) -> FloatArray:
    """Blends rim depths into one surface (h, w); the sky stays exactly where it is."""
    ground = mask & ~is_sky
    if not ground.any():
        return fronts.shift
    rims = (known & ~front.sky & dilated(ground, RIM_PX)) | (ground & ~fronts.reached)
    harmonic = push_pull(front.shift, rims.astype(np.float32)) if rims.any() else fronts.shift
    local = masked_blur(fronts.shift, ground, RIM_BLUR_PX)
    blend = HARMONIC_SHARE * harmonic + (1 - HARMONIC_SHARE) * local
    freedom = _freedom(fronts.shift, axis)
    blend = np.clip(blend, fronts.shift - freedom, fronts.shift + freedom)
    return np.where(ground & fronts.reached, blend, fronts.shift).astype(np.float32, copy=False)


def _freedom(shift: FloatArray, axis: DepthAxis) -> FloatArray:
    """Returns how far smoothing may move each pixel (h, w), px of shift."""
    if axis.wide:
        return axis.step_of(shift, DEPTH_FREEDOM)
    return np.full_like(shift, DEPTH_FREEDOM * axis.base_px)


def far_as_sky(shift: FloatArray, sky: FloatArray, axis: DepthAxis) -> BoolArray:
    """Tells where a depth is that of the sky (h, w): averaged or carried back from aside, it is not even.

    Args:
        shift: (h, w) float32, px, what is asked about.
        sky: (1,) float32, px, of the sky.
        axis: the depth coordinate.
    """
    return np.asarray(shift <= sky + axis.step_of(sky, SKY_STEP))


def behind_front(
    relief: FloatArray, front_relief: FloatArray, axis: DepthAxis
) -> tuple[FloatArray, BoolArray]:
    """Pushes a layer (h, w) behind everything that the source camera sees within one pixel.

    Returns:
        The relief and where it may stay: a surfel reaches into the neighbouring pixels, so one that
        is far in front of a neighbour would show in the source view.
    """
    own = np.maximum(relief, axis.behind(front_relief, BEHIND))
    farthest = np.asarray(cv2.dilate(front_relief, np.ones((3, 3), np.uint8)), np.float32)
    pushed = np.maximum(own, axis.behind(farthest, BEHIND))
    return pushed, axis.within(own, pushed, PUSH_LIMIT)
