"""The frame padded on all sides, so that an orbit of 12 degrees does not meet its border.

Depth first (rims continued and slowly blurred, the ground sloping on), then colour by exemplar fill,
then the sky label of every pad pixel from the pixel that its colour was copied from: otherwise the
skyline of the picture and that of the depth differ, and a wedge shears off in an orbit.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.edges import sharpen_steps
from wzviewer.worker.models.builtin.views.exemplar import FillRule, FillTask, fill
from wzviewer.worker.models.builtin.views.layers import Surface
from wzviewer.worker.models.builtin.views.smoothing import blur, dilated, push_pull

PAD_WIDTH, PAD_HEIGHT = 0.24, 0.22  # of the frame, each side: 12 degrees for the sky
OUTSIDE_RULE = FillRule(radius_px=8, row_cost=0.5, rim_cost=0.05)
ORIGIN_INSET = (0.07, 0.065)  # of height, width: where the search for a pad pixel is centred
BLUR_STACK = ((0.0, 0.0), (12.0, 6.0), (45.0, 16.0), (120.0, 40.0))  # (distance px, sigma px)
SOFT_PX = 90.0  # from the outer border inwards
SKY_STRIP_PX = 41
LABEL_WINDOW_PX = 15
STRAY_PX = 3
GROUND_ROWS = 60
NEAREST = 1.6  # the ground may come at most this much nearer than the 98th percentile


@dataclass(frozen=True)
class Canvas:
    """A padded frame.

    Attributes:
        surface: the canvas; inside the frame it is the frame.
        inside: (h, w) bool, the frame.
        pad_px: (x, y) padding of each side.
    """

    surface: Surface
    inside: BoolArray
    pad_px: tuple[int, int]


def unpadded(frame: Surface) -> Canvas:
    """Returns a canvas without a pad."""
    return Canvas(frame, np.ones(frame.shift.shape, np.bool_), (0, 0))


def outpaint(
    frame: Surface, axis: DepthAxis, gain: float, seed: int, check: Callable[[], None] | None = None
) -> Canvas:
    """Extends a frame on all four sides.

    Args:
        frame: the picture with sharp depth edges.
        axis: the depth coordinate.
        gain: tan of the largest orbit angle.
        seed: of the candidate search.
        check: called now and then; may raise `Cancelled`.
    """
    height, width = frame.shift.shape
    pad = (2 * round(PAD_WIDTH * width / 2), 2 * round(PAD_HEIGHT * height / 2))
    around = ((pad[1], pad[1]), (pad[0], pad[0]))
    inside = np.pad(np.ones((height, width), np.bool_), around)
    ground = _extended_ground(frame, around, axis)
    label = _border_sky(frame.sky, around)
    far = float(np.median(frame.shift[frame.sky])) if frame.sky.any() else 0.0
    guess = np.where(label, np.float32(far), ground)
    image, copied_from = _painted(frame, around, inside, guess, axis, seed, check)
    seen = np.pad(frame.sky, around)
    sky = copied_sky(seen, copied_from, inside, label)
    stray = sky & ~inside & (copied_from[..., 0] >= 0) & ~seen[copied_from[..., 0], copied_from[..., 1]]
    image = _softened(_without(image, stray, sky, inside), inside)
    shift = np.where(sky, np.float32(far), ground)
    shift = np.where(inside, np.pad(frame.shift, around), shift).astype(np.float32, copy=False)
    shift = np.where(inside, shift, sharpen_steps(shift, axis, gain))
    relief = np.where(inside, np.pad(frame.relief, around), axis.relief_of(shift))
    return Canvas(Surface(image, shift, relief.astype(np.float32, copy=False), sky), inside, pad)


def _extended_ground(frame: Surface, around: tuple[tuple[int, int], ...], axis: DepthAxis) -> FloatArray:
    """Returns the shift (H, W) of everything but the sky, continued over the canvas."""
    solid = ~frame.sky
    if not solid.any():
        return np.pad(frame.shift, around, mode="edge")
    shift = push_pull(frame.shift, solid.astype(np.float32))
    extended = np.pad(shift, around, mode="edge")
    extended = _sloped_below(extended, shift, solid, around[0][1])
    high, width = extended.shape
    rows = np.clip(np.arange(high), around[0][0], high - 1 - around[0][1])
    columns = np.clip(np.arange(width), around[1][0], width - 1 - around[1][1])
    distance = np.hypot((np.arange(high) - rows)[:, None], (np.arange(width) - columns)[None])
    near = np.full(1, np.percentile(frame.shift[solid], 98), np.float32)
    ceiling = float((near + axis.step_of(near, NEAREST - 1))[0])
    return np.minimum(_blurred_by_distance(extended, distance.astype(np.float32)), np.float32(ceiling))


def _sloped_below(extended: FloatArray, shift: FloatArray, solid: BoolArray, pad_px: int) -> FloatArray:
    """Continues the slope of the ground under the lower border; shift is affine on a plane."""
    rows = min(GROUND_ROWS, shift.shape[0] - 1)
    whole = solid[-rows - 1 :].all(axis=0)
    if not whole.any():
        return extended
    slope = max(0.0, float(np.median(shift[-1, whole] - shift[-rows - 1, whole])) / rows)
    below = np.zeros(extended.shape[0], np.float32)
    below[-pad_px:] = slope * (1 + np.arange(pad_px))
    return (extended + below[:, None]).astype(np.float32, copy=False)


def _blurred_by_distance(values: FloatArray, distance: FloatArray) -> FloatArray:
    """Blurs (H, W) the more the farther a pixel is from the frame; exact at the frame itself."""
    stack = [values if sigma == 0 else blur(values, sigma) for _, sigma in BLUR_STACK]
    result = stack[-1]
    for k in range(len(BLUR_STACK) - 2, -1, -1):
        start, stop = BLUR_STACK[k][0], BLUR_STACK[k + 1][0]
        share = np.clip((distance - start) / (stop - start), 0, 1)
        mixed = stack[k] + share * (stack[k + 1] - stack[k])
        result = np.where(distance < stop, mixed, result)
    return np.asarray(result, np.float32)


def _border_sky(sky: BoolArray, around: tuple[tuple[int, int], ...]) -> BoolArray:
    """Guesses the sky outside (H, W) by the majority of a strip of the border: a flag is no wall."""
    strip = (SKY_STRIP_PX, SKY_STRIP_PX)
    share = cv2.blur(sky.astype(np.float32), strip, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(np.pad(share, around, mode="edge") > 0.5)


def _painted(
    frame: Surface,
    around: tuple[tuple[int, int], ...],
    inside: BoolArray,
    guess: FloatArray,
    axis: DepthAxis,
    seed: int,
    check: Callable[[], None] | None,
) -> tuple[FloatArray, IntArray]:
    """Returns the painted canvas (H, W, 3) and where each pad pixel was copied from (H, W, 2)."""
    height, width = frame.shift.shape
    picture = np.pad(frame.image, (*around, (0, 0)))
    inset_y, inset_x = round(ORIGIN_INSET[0] * height), round(ORIGIN_INSET[1] * width)
    top, left = around[0][0], around[1][0]
    rows = np.clip(np.arange(inside.shape[0]), top + inset_y, top + height - 1 - inset_y)
    columns = np.clip(np.arange(inside.shape[1]), left + inset_x, left + width - 1 - inset_x)
    origin = np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1).astype(np.int32)
    log_depth = axis.log_of(np.pad(frame.shift, around, mode="edge"))
    task = FillTask(
        picture, inside, ~inside, picture, inside, log_depth, axis.log_of(guess), np.ascontiguousarray(origin)
    )
    return fill(task, OUTSIDE_RULE, seed, check)


def _without(image: FloatArray, stray: BoolArray, sky: BoolArray, inside: BoolArray) -> FloatArray:
    """Lets the sky (h, w, 3) go on where the tip of something was copied into it."""
    if not stray.any():
        return image
    gone = dilated(stray, STRAY_PX) & sky & ~inside
    known = (sky & ~dilated(gone, 1)).astype(np.float32)
    return np.where(gone[..., None], push_pull(image, known), image).astype(np.float32, copy=False)


def _softened(image: FloatArray, inside: BoolArray) -> FloatArray:
    """Lets detail (H, W, 3) fade towards the outer border, where the smooth backdrop begins."""
    y, x = (np.minimum(np.arange(n), n - 1 - np.arange(n)).astype(np.float32) for n in inside.shape)
    share = np.clip(np.minimum(y[:, None], x[None]) / np.float32(SOFT_PX), 0, 1)
    share = np.where(inside, np.float32(1), share * share * (3 - 2 * share))[..., None]
    return np.asarray(share * image + (1 - share) * blur(image, SOFT_PX / 3), np.float32)


def copied_sky(sky: BoolArray, copied_from: IntArray, inside: BoolArray, label: BoolArray) -> BoolArray:
    """Gives each pad pixel the sky label of the pixel it was copied from, without specks."""
    copied = copied_from[..., 0] >= 0
    own = np.where(copied, sky[copied_from[..., 0], copied_from[..., 1]], label)
    own = np.where(inside, sky, own).astype(np.uint8)
    smooth = cv2.medianBlur(own * 255, LABEL_WINDOW_PX) > 127
    return np.asarray(np.where(inside, sky, smooth))
