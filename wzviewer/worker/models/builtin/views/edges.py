"""Depth edges of a picture made usable: one step instead of a slope, at the place of the colour edge.

A depth map from a network crosses from one surface to the next over several pixels and a few pixels
off.  A lifted slope tears into cracks, and pixels on the wrong side of a step stay behind when the
camera moves.  Four passes mend it; all of them leave a map without steps bit-identical.
"""

import cv2
import numpy as np
from numba import njit, prange

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.smoothing import blur, dilated

SLOPE_WINDOWS_PX = (7, 5, 5)
SLOPE_PX_PER_PX = 3.0  # image shift per pixel above which a slope is meant to be a step
STEP_PX = 3.0  # image shift at the largest orbit that makes a hole worth filling
FRINGE_STEP_PX = 6.0  # the same for moving pixels across the edge
RELATIVE_STEP = 0.04
RELATIVE_FRINGE_STEP = 0.08
WEAK_SHARE = 0.5  # of the steepness of a step: a slope that may belong to one
SURE_SHARE, SURE_PIXELS = 0.2, 24  # of a slope, at least, that is steep for sure, to make all of it a step
EVEN_RADIUS_PX = 12  # native px over which a step that is none becomes a slope
EVEN_STEP = 0.06  # relative depth of the largest of these
SNAP_RADIUS_PX = 4
COARSE_RADIUS_PX, COARSE_FRINGE_PX = 8, 6  # at deep levels: their picture is as soft as the level before
CONTRAST = 0.14  # colour distance of the two sides above which colour decides
FRINGE_PX = 2
MIXED_SHARE = 0.12  # share of the near colour from which on a pixel belongs to the near side


def clean_edges(shift: FloatArray, image: FloatArray, axis: DepthAxis, gain: float) -> FloatArray:
    """Makes depth steps sharp and moves them to the colour edge.

    Args:
        shift: (h, w) float32, `DepthAxis` shift, px.
        image: (h, w, 3) float32 sRGB in [0, 1].
        axis: the depth coordinate.
        gain: tan of the largest orbit angle; gain x shift is image motion in px.

    Returns:
        (h, w) float32: the shift, changed only within a few pixels of a step.
    """
    sharp = whole_steps(shift, axis, gain)
    if not has_steps(sharp, axis, gain):
        return shift
    radius, fringe = (SNAP_RADIUS_PX, FRINGE_PX) if axis.wide else (COARSE_RADIUS_PX, COARSE_FRINGE_PX)
    snapped, mixed, clear = snap_to_colour(sharp, image, axis, gain, radius)
    wider = widen_near_side(snapped, axis, gain, ~clear)
    return widen_near_side(wider, axis, gain, clear & mixed, fringe)


def even_small_steps(relief: FloatArray, axis: DepthAxis, gain: float) -> FloatArray:
    """Makes slopes of the steps that are no larger than the errors of the photograph's depth.

    Beside the photograph's own pixels they are hardly seen; magnified they tear a surface into shreds.

    Args:
        relief: (h, w) float32, native px.
        axis: the depth coordinate.
        gain: tan of the largest orbit angle.

    Returns:
        (h, w) float32: the relief, changed only near such steps, and only while depth errors count.
    """
    if not axis.photographed:
        return relief
    noise = np.float32(EVEN_STEP) * (relief + np.float32(axis.focal_px))
    apart = _jumps(relief)
    small = (apart > STEP_PX / gain) & (apart <= noise)
    return _evened(relief, dilated(small, EVEN_RADIUS_PX), noise, EVEN_RADIUS_PX) if small.any() else relief


def _jumps(values: FloatArray) -> FloatArray:
    """Returns the largest difference (h, w) to the next pixel to the right or below."""
    jumps = np.zeros_like(values)
    jumps[:, :-1] = np.abs(np.diff(values, axis=1))
    jumps[:-1] = np.maximum(jumps[:-1], np.abs(np.diff(values, axis=0)))
    return jumps


@njit(cache=True, nogil=True, parallel=True)
def _evened(relief: FloatArray, where: BoolArray, noise: FloatArray, radius: int) -> FloatArray:
    """Gives the marked pixels (h, w) the mean of those around that differ by no more than the noise."""
    even = relief.copy()
    for y in prange(relief.shape[0]):
        for x in range(relief.shape[1]):
            if not where[y, x]:
                continue
            own, limit = relief[y, x], noise[y, x]
            total, count = 0.0, 0
            for v in range(max(0, y - radius), min(relief.shape[0], y + radius + 1)):
                for u in range(max(0, x - radius), min(relief.shape[1], x + radius + 1)):
                    if abs(relief[v, u] - own) <= max(limit, noise[v, u]):
                        total += relief[v, u] - own
                        count += 1
            even[y, x] = own + np.float32(total / count)
    return even


def has_steps(shift: FloatArray, axis: DepthAxis, gain: float) -> bool:
    """True if any two neighbours differ enough to open a hole within the orbit."""
    return bool(_steps(shift, axis, gain).any())


def _steps(shift: FloatArray, axis: DepthAxis, gain: float) -> BoolArray:
    """Tells which pixels (h, w) differ enough from the next one, to the right or below, to open a hole."""
    steps = np.zeros(shift.shape, np.bool_)
    for low, high, here in (
        (shift[:, :-1], shift[:, 1:], steps[:, :-1]),
        (shift[:-1], shift[1:], steps[:-1]),
    ):
        far = np.minimum(low, high)
        here |= np.maximum(low, high) - far > np.maximum(STEP_PX / gain, axis.step_of(far, RELATIVE_STEP))
    return steps


def _extremes(shift: FloatArray, window_px: int) -> tuple[FloatArray, FloatArray]:
    """Returns the farthest and nearest shift of a square window, each (h, w)."""
    window = np.ones((window_px, window_px), np.uint8)
    return (
        np.asarray(cv2.erode(shift, window), np.float32),
        np.asarray(cv2.dilate(shift, window), np.float32),
    )


def sharpen_steps(shift: FloatArray, axis: DepthAxis, gain: float, steep: float = 1.0) -> FloatArray:
    """Moves every pixel of a steep slope (h, w) to the closer of the two plateaus it connects.

    Args:
        shift: (h, w) float32, px.
        axis: the depth coordinate.
        gain: tan of the largest orbit angle.
        steep: of the steepness of a step, how much is steep.
    """
    sharp = shift
    for window_px in SLOPE_WINDOWS_PX:
        far, near = _extremes(sharp, window_px)
        limit = np.maximum(SLOPE_PX_PER_PX * window_px / gain, axis.step_of(far, RELATIVE_STEP))
        limit = np.float32(steep) * limit
        plateau = np.where(sharp > 0.5 * (near + far), near, far)
        sharp = np.where(near - far > limit, plateau, sharp)
    return np.asarray(sharp, np.float32)


def whole_steps(shift: FloatArray, axis: DepthAxis, gain: float) -> FloatArray:
    """Makes steps of slopes (h, w) that are steep enough on the whole, and leaves the others as they are.

    A slope about the limit would become a step only here and there: seen from aside, scraps that stick
    out of a surface, and larger ones at the next level.  So weak slopes go the way of the strong ones
    that they are joined to (as in Canny, 1986), if those are more than a few.
    """
    strong, weak = (sharpen_steps(shift, axis, gain, share) for share in (1.0, WEAK_SHARE))
    moved = (weak != shift).astype(np.uint8)
    _, labels = cv2.connectedComponents(cv2.dilate(moved, np.ones((3, 3), np.uint8)), connectivity=8)
    count = np.bincount(labels[moved > 0], minlength=labels.max() + 1)
    sure = np.bincount(labels[strong != shift], minlength=len(count))
    is_step = sure >= np.maximum(SURE_SHARE * count, SURE_PIXELS)
    is_step[0] = False
    return np.asarray(np.where(is_step[labels], weak, shift), np.float32)


def snap_to_colour(
    shift: FloatArray, image: FloatArray, axis: DepthAxis, gain: float, radius: int = SNAP_RADIUS_PX
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Gives pixels beside a step to the side whose colour they have.

    The colours of the two sides are local means of pixels a radius inside either side; a pixel in
    between is their mixture with a share alpha of the near one, the simplest matting model.

    Returns:
        The shift, where a pixel holds some of the near colour, and where the two colours differ
        enough to tell, each (h, w).
    """
    far, near = _extremes(shift, 2 * radius + 5)
    limit = np.maximum(FRINGE_STEP_PX / gain, axis.step_of(far, RELATIVE_FRINGE_STEP))
    # A slope without a step has no sides: colour would tear it where it is steep.
    band = (near - far > limit) & dilated(_steps(shift, axis, gain), radius + 2)
    is_near = band & (shift > 0.5 * (near + far))
    near_core = is_near & ~dilated(band & ~is_near, radius - 1)
    far_core = band & ~is_near & ~dilated(is_near, radius - 1)
    near_mean, near_weight = _side_mean(image, shift, near_core, radius)
    far_mean, far_weight = _side_mean(image, shift, far_core, radius)
    share, sure = _mixture_share(image, near_mean[..., :3], far_mean[..., :3])
    sure &= (near_weight > 0.02) & (far_weight > 0.02)
    undecided = band & ~near_core & ~far_core & sure
    score = np.where(undecided, share, is_near.astype(np.float32)).astype(np.float32, copy=False)
    even = (radius - 1, radius - 1)
    wins_near = cv2.blur(score, even) > 0.5
    moved = undecided & (wins_near != is_near)
    side = np.where(wins_near, near_mean[..., 3], far_mean[..., 3])
    mixed = share > MIXED_SHARE
    if not axis.wide:  # beside an edge a magnified picture may be brighter than both
        mixed = cv2.blur(_unlike(image, near_mean[..., :3], far_mean[..., :3]), even) > MIXED_SHARE
    return np.where(moved, side, shift).astype(np.float32, copy=False), np.asarray(mixed), sure


def _side_mean(
    image: FloatArray, shift: FloatArray, core: BoolArray, radius: int
) -> tuple[FloatArray, FloatArray]:
    """Returns the local mean of (r, g, b, shift) over a core, (h, w, 4), and its weight (h, w)."""
    weight = core.astype(np.float32)
    values = np.dstack([image, shift, np.ones_like(shift)]) * weight[..., None]
    sums = blur(values, radius)
    return (sums[..., :4] / np.maximum(sums[..., 4:], 1e-6)).astype(np.float32, copy=False), sums[..., 4]


def _mixture_share(
    image: FloatArray, near_color: FloatArray, far_color: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Returns the share of the near colour in each pixel (h, w), clipped to [0, 1], and where it is sure."""
    axis_color = near_color - far_color
    contrast = np.sqrt((axis_color**2).sum(-1))
    share = ((image - far_color) * axis_color).sum(-1) / np.maximum(contrast**2, 1e-6)
    return np.clip(share, 0, 1).astype(np.float32, copy=False), contrast > CONTRAST


def _unlike(image: FloatArray, near_color: FloatArray, far_color: FloatArray) -> FloatArray:
    """Returns how much each pixel (h, w) differs from the far colour, over what the near one does."""
    away, whole = (np.sqrt(((c - far_color) ** 2).sum(-1)) for c in (image, near_color))
    return np.asarray(away / np.maximum(whole, 1e-3), np.float32)


def widen_near_side(
    shift: FloatArray, axis: DepthAxis, gain: float, allowed: BoolArray, radius_px: int = 1
) -> FloatArray:
    """Lets the near side of each step grow by a few allowed pixels, so that mixed colours move with it."""
    widened = shift
    for _ in range(radius_px):
        near = _extremes(widened, 3)[1]
        limit = np.maximum(FRINGE_STEP_PX / gain, axis.step_of(widened, RELATIVE_FRINGE_STEP))
        widened = np.where(allowed & (near - widened > limit), near, widened)
    return np.asarray(widened, np.float32)
