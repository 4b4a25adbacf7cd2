"""Things that stand on the ground stand up.

The network hedges: what stands gets a part of the ground's slope, so a house leans back like its lawn.
Three things tell them apart in each segment: the share of the ground's slope that it has, the network's
opinion of what stands, and foreshortening: seen from the side, the texture of the ground is pressed flat, so
its edges run across, and a wall's or a person's do not.  What stands gets no slope, and the map is put
together again from its slopes:

    min  sum w_y (d'_y - k d_y)^2 + w_x (d'_x - d_x)^2 + hold (d' - d)^2

with k the segment's share after the decision.  `w` breaks where a standing thing ends above and beside,
never where it meets the ground below; `hold` is firm on the ground.
"""

import cv2
import numpy as np
from numba import njit

from wzviewer.core.types import BoolArray, ByteArray, DoubleArray, FloatArray, IntArray

STANDS, LIES = 0.70, 0.92  # shares of the ground's slope: below the one and above the other it is sure
LEAST_SLOPE = 0.35  # ground disparity over the picture's height; flatter is no ground seen from above
HOLD_GROUND, HOLD_STANDING, HOLD_STIFF = 0.05, 0.00006, 0.0003
OPEN_EDGE, SAME_KIND_EDGE = 0.001, 0.35  # weights across segment borders
WIDE = (0.38, 0.29)  # height over width below which a segment lies rather than stands
TALL, SLIM_BONUS = (1.2, 1.8), 0.25  # and above which less of a hint is enough
OPINION, VETO = 0.6, 0.08  # how far the network's opinion moves the decision; brown huts look like earth
PRESSED, PRESSED_SLACK = 0.6, 0.15  # the same for each e-fold of foreshortening, beyond a slack
STIFF = 10.0  # under the sky, weight of a slope inside what stands: its sides may bend before it leans
SWEEPS, OVER_RELAXATION = 80, 1.85


def stand_up(
    d: FloatArray,
    sky: BoolArray,
    labels: IntArray,
    stands: FloatArray | None = None,
    image: ByteArray | None = None,
    apart: BoolArray | None = None,
) -> FloatArray:
    """Removes the ground's slope from what stands.

    Args:
        d: (h, w) disparity whose 98th percentile is about 1.
        sky: (h, w).
        labels: (h, w) segments 0..n-1.
        stands: the network's probability that a pixel belongs to something upright, any size.
        image: (h, w, 3) u8 RGB, for its foreshortening.
        apart: (h, w) bool, what stands for another reason and is left on the ground here.

    Returns:
        (h, w); `d` itself where no ground is seen from above.
    """
    h, w = d.shape
    size = (max(w // 2, 2), max(h // 2, 2))
    small = cv2.resize(d, size, interpolation=cv2.INTER_AREA)
    hidden = cv2.resize(sky.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    parts = cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST)
    share = slope_shares(small, hidden, parts)
    if share is None:
        return d
    opinion = np.full_like(small, 0.5) if stands is None else _opinion(_at(stands, size), hidden, parts)
    texture = np.zeros_like(small) if image is None else unpressed(image, parts)
    kept = _decided(share, OPINION * np.maximum(opinion - 0.5, -VETO) + texture, tall_shapes(parts))
    if apart is not None:
        kept = np.maximum(kept, _at(apart.astype(np.float32), size))
    change = _reassembled(small, hidden, parts, kept) - small
    change[hidden] = 0
    return (d + cv2.resize(change, (w, h), interpolation=cv2.INTER_LINEAR)).astype(np.float32)


def slope_shares(d: FloatArray, sky: BoolArray, labels: IntArray) -> FloatArray | None:
    """(h, w) mean slope of each pixel's segment over the ground's; None where there is no ground."""
    h = d.shape[0]
    slope = cv2.Sobel(cv2.GaussianBlur(d, (0, 0), 1.0), cv2.CV_32F, 0, 1) / 8 * h
    sure = ~(cv2.dilate(sky.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
    mean = _per_segment(slope, sky, labels)
    lower = sure & (np.arange(h)[:, None] > h // 3)
    if lower.mean() < 0.1:
        return None
    ground = float(np.percentile(mean[lower], 75))
    return None if ground < LEAST_SLOPE else (mean / ground).astype(np.float32)


def _per_segment(value: FloatArray, sky: BoolArray, labels: IntArray) -> FloatArray:
    """(h, w) mean of each pixel's segment, away from its border (where the steps are), sky and lower edge."""
    sure = ~(cv2.dilate(sky.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
    inner = cv2.morphologyEx(labels.astype(np.float32), cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) == 0
    weight = (sure + np.float32(1e-3)) * (inner + np.float32(0.01))
    weight[-max(len(value) // 12, 1) :] *= 0.01  # the network's map flattens there
    count = int(labels.max()) + 1
    mass = np.bincount(labels.ravel(), weight.ravel(), minlength=count) + 1e-9
    mean = np.bincount(labels.ravel(), (value * weight).ravel(), minlength=count) / mass
    return np.asarray(mean[labels], np.float32)


def _opinion(stands: FloatArray, sky: BoolArray, labels: IntArray) -> FloatArray:
    """(h, w) the network's probability per segment, taken relative to that of the foreground."""
    ground = float(np.median(stands[2 * len(stands) // 3 :]))
    doubt = 0.5 - np.clip(ground + 0.12, 0.35, 0.55)
    return np.asarray(_per_segment(stands, sky, labels) + np.float32(doubt), np.float32)


def unpressed(image: ByteArray, labels: IntArray) -> FloatArray:
    """How much less foreshortened each segment's texture is than the foreground's, as a share of its slope.

    Args:
        image: (h, w, 3) u8 RGB.
        labels: segments, any size.

    Returns:
        At the size of the labels, >= 0: blades of grass stand in a lawn, which lies all the same.
    """
    luma = cv2.GaussianBlur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32), (0, 0), 0.7)
    across, down = cv2.Sobel(luma, cv2.CV_32F, 1, 0), cv2.Sobel(luma, cv2.CV_32F, 0, 1)
    inner = cv2.morphologyEx(labels.astype(np.float32), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) == 0
    weight = inner + np.float32(0.05)
    sums = []
    for gradient in (across, down):
        size = cv2.resize(np.abs(gradient), labels.shape[::-1], interpolation=cv2.INTER_AREA)
        sums.append(np.bincount(labels.ravel(), (size * weight).ravel()))
    mass = np.bincount(labels.ravel(), weight.ravel()) + 1e-6
    ratio = np.log((sums[0] + 2 * mass) / (sums[1] + 2 * mass)).astype(np.float32)[labels]
    ground = max(float(np.median(ratio[2 * len(ratio) // 3 :])), -0.5)
    return (PRESSED * np.clip(ratio - ground - PRESSED_SLACK, 0, 0.8)).astype(np.float32)


def _decided(share: FloatArray, evidence: FloatArray, tallness: FloatArray) -> FloatArray:
    """The share of its slope that a pixel keeps: 0 stands, 1 lies (or faces down, or is a step)."""
    slim = np.clip((tallness - TALL[0]) / (TALL[1] - TALL[0]), 0, 1)
    hinted = np.clip((1 - share) / 0.1, 0, 1)  # a path that runs away from the eye is slim as well
    hint = SLIM_BONUS * slim * hinted + evidence
    t = np.clip((LIES - share + hint) / (LIES - STANDS), 0, 1)
    kept = 1 - t * t * (3 - 2 * t)
    flat = np.clip((WIDE[0] - tallness) / (WIDE[0] - WIDE[1]), 0, 1)
    return np.where(share < -0.2, 1, np.maximum(kept, flat)).astype(np.float32)


def _at(value: FloatArray, size: tuple[int, int]) -> FloatArray:
    return np.asarray(cv2.resize(value, size, interpolation=cv2.INTER_LINEAR), np.float32)


def tall_shapes(labels: IntArray) -> FloatArray:
    """(h, w) height over width (standard deviations) of each pixel's segment."""
    h, w = labels.shape
    count = int(labels.max()) + 1
    y, x = np.mgrid[:h, :w].astype(np.float64)
    flat = labels.ravel()
    mass = np.maximum(np.bincount(flat, minlength=count), 1)

    def spread(v: DoubleArray) -> DoubleArray:
        mean = np.bincount(flat, v.ravel(), minlength=count) / mass
        return np.asarray(np.bincount(flat, ((v - mean[labels]) ** 2).ravel(), minlength=count) / mass)

    return np.sqrt((spread(y) + 1.0) / (spread(x) + 1.0))[labels].astype(np.float32)


def _reassembled(d: FloatArray, sky: BoolArray, labels: IntArray, kept: FloatArray) -> FloatArray:
    """Solves for the map with the kept slopes."""
    down, across = np.diff(d, axis=0), np.diff(d, axis=1)
    border_y, border_x = labels[1:] != labels[:-1], labels[:, 1:] != labels[:, :-1]
    similar_y = np.abs(kept[1:] - kept[:-1]) < 0.35
    similar_x = np.abs(kept[:, 1:] - kept[:, :-1]) < 0.35
    foot = kept[1:] > kept[:-1]  # what is below lies, what is above stands: they touch
    weight_y = np.where(border_y & ~foot, np.where(similar_y, SAME_KIND_EDGE, OPEN_EDGE), 1.0)
    weight_x = np.where(border_x, np.where(similar_x, SAME_KIND_EDGE, OPEN_EDGE), 1.0)
    weight_y[sky[1:] | sky[:-1]] = 0
    weight_x[sky[:, 1:] | sky[:, :-1]] = 0
    share = np.minimum(kept[1:], kept[:-1])
    outdoors = bool(sky.any())  # in a room also seats and tables are taken for standing
    stiff = STIFF if outdoors else 1.0
    weight_y *= np.where(border_y & ~foot, 1.0, 1.0 + (stiff - 1.0) * (1.0 - share))
    target_y = np.where(down > 0, share * down, down)
    loose = HOLD_STIFF if outdoors else HOLD_STANDING
    hold = loose + (HOLD_GROUND - loose) * kept
    hold[sky] = 1.0
    arrays = (d, target_y, across, weight_y, weight_x, hold)
    solved = np.ascontiguousarray(d, np.float32).copy()
    _relax(*(np.ascontiguousarray(a, np.float32) for a in arrays), solved)
    return solved


@njit(cache=True, nogil=True)
def _relax(
    d: FloatArray,
    target_y: FloatArray,
    target_x: FloatArray,
    weight_y: FloatArray,
    weight_x: FloatArray,
    hold: FloatArray,
    solved: FloatArray,
) -> None:
    """Relaxation of the normal equations column by column, in place: slopes are stiff along columns."""
    h, w = d.shape
    below = np.empty(h, np.float32)  # a column's elimination: coefficient and right-hand side
    right = np.empty(h, np.float32)
    for _ in range(SWEEPS):
        for j in range(w):
            for i in range(h):
                mass = hold[i, j]
                total = hold[i, j] * d[i, j]
                if j > 0:
                    mass += weight_x[i, j - 1]
                    total += weight_x[i, j - 1] * (solved[i, j - 1] + target_x[i, j - 1])
                if j + 1 < w:
                    mass += weight_x[i, j]
                    total += weight_x[i, j] * (solved[i, j + 1] - target_x[i, j])
                if i + 1 < h:
                    mass += weight_y[i, j]
                    total -= weight_y[i, j] * target_y[i, j]
                if i > 0:
                    a = weight_y[i - 1, j]
                    mass += a * (1 - below[i - 1])
                    total += a * (target_y[i - 1, j] + right[i - 1])
                below[i] = weight_y[i, j] / mass if i + 1 < h else np.float32(0)
                right[i] = total / mass
            value = np.float32(0)
            for i in range(h - 1, -1, -1):
                value = right[i] + below[i] * value
                solved[i, j] += np.float32(OVER_RELAXATION) * (value - solved[i, j])
