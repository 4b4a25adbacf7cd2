"""Makes a coarse depth map follow the picture: smooth inside, planes per segment, steps at edges.

A depth edge is one step between two plateaus: what lies between them would be torn into a tent when
the camera moves, so every pixel of the transition is given to one side (`snap_steps`).
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, DoubleArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.depth.sky import smooth_like

TOUCH_SHARE = 0.3  # of a pixel's change of depth: by less, what it now lies beside is nearer or farther


def segment(
    image: FloatArray,
    width_px: int = 272,
    sigma: float = 0.8,
    threshold: float = 160.0,
    smallest_px: int = 60,
) -> IntArray:
    """Graph segments (Felzenszwalb and Huttenlocher), found at a reduced size.

    Args:
        image: (h, w, 3) sRGB 0..1.
        width_px: longer side at which the graph is cut.
        sigma: blur before cutting, px at that size.
        threshold: the algorithm's k: larger means larger segments.
        smallest_px: area of the smallest segment.

    Returns:
        (h, w) labels 0..n-1.
    """
    h, w = image.shape[:2]
    shrink = min(1.0, width_px / max(h, w))
    size = (max(round(w * shrink), 1), max(round(h * shrink), 1))
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    pixels = np.ascontiguousarray((np.clip(small, 0, 1) * 255).astype(np.uint8))
    cutter = cv2.ximgproc.segmentation.createGraphSegmentation(sigma, threshold, smallest_px)
    labels = cutter.processImage(pixels).astype(np.int32)
    return np.asarray(cv2.resize(labels, (w, h), interpolation=cv2.INTER_NEAREST), np.int32)


def smooth_disparity(disparity: FloatArray, sky: FloatArray, half: ByteArray) -> FloatArray:
    """Edge-aware smoothing that never mixes the sky in.

    Args:
        disparity: (h, w) at any size.
        sky: (h, w) soft mask at the half size.
        half: (h, w, 3) u8 RGB.
    """
    d = cv2.resize(disparity, half.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    weight = ((1 - sky) ** 2 * (sky < 0.5) + 1e-4).astype(np.float32)
    smooth = smooth_like(half, d * weight, 60, 9) / np.maximum(smooth_like(half, weight, 60, 9), 1e-6)
    return smooth.astype(np.float32)


def segment_planes(d: FloatArray, sky: BoolArray, labels: IntArray, trust: float = 0.75) -> FloatArray:
    """Pulls each segment towards its own plane in disparity where the plane fits.

    Args:
        d: (h, w) disparity whose 98th percentile is about 1.
        sky: (h, w).
        labels: (h, w) segments.
        trust: largest share of the plane.

    Returns:
        (h, w); three rounds of reweighted least squares, clipped to each segment's own range.
    """
    h, w = d.shape
    flat, value, n = labels.ravel(), d.ravel().astype(np.float64), int(labels.max()) + 1
    y, x = (g.ravel().astype(np.float64) for g in np.mgrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j])
    edge = cv2.morphologyEx(d, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)).ravel()
    base = np.where(sky.ravel(), 1e-4, 1 / (1 + (edge / 0.06) ** 2))
    weight = base
    for _ in range(3):
        plane = _fit_planes(flat, n, x, y, value, weight)
        weight = base / (1 + ((value - plane) / 0.05) ** 2)
    low = np.full(n, np.inf)
    high = np.full(n, -np.inf)
    np.minimum.at(low, flat, value)
    np.maximum.at(high, flat, value)
    plane = np.clip(plane, low[flat], high[flat])
    share = trust * np.exp(-(((value - plane) / 0.10) ** 2))
    return (value + share * (plane - value)).reshape(h, w).astype(np.float32)


def _fit_planes(
    flat: IntArray, n: int, x: DoubleArray, y: DoubleArray, value: DoubleArray, weight: DoubleArray
) -> DoubleArray:
    """Weighted plane of every segment, evaluated at its pixels; lightly damped towards its mean."""

    def total(v: DoubleArray) -> DoubleArray:
        return np.asarray(np.bincount(flat, v, minlength=n))

    mass = total(weight) + 1e-9
    mx, my, mv = total(weight * x) / mass, total(weight * y) / mass, total(weight * value) / mass
    dx, dy, dv = x - mx[flat], y - my[flat], value - mv[flat]
    damp = 1e-5 * mass + 1e-12
    xx, yy, xy = total(weight * dx * dx) + damp, total(weight * dy * dy) + damp, total(weight * dx * dy)
    xv, yv = total(weight * dx * dv), total(weight * dy * dv)
    det = np.maximum(xx * yy - xy * xy, 1e-24)
    slope_x, slope_y = (yy * xv - xy * yv) / det, (xx * yv - xy * xv) / det
    return mv[flat] + slope_x[flat] * dx + slope_y[flat] * dy


def extend_under(d: FloatArray, hidden: BoolArray) -> FloatArray:
    """Continues `d` into the hidden part (Gaussians of 4, then 25 px), so filters meet no cliff there."""
    known = (~hidden).astype(np.float32)
    filled = d * known
    result, mass = filled + 0.0, known.copy()
    for sigma in (4.0, 25.0):
        near = cv2.GaussianBlur(known, (0, 0), sigma)
        guess = cv2.GaussianBlur(filled, (0, 0), sigma) / np.maximum(near, 1e-6)
        take = (mass == 0) & (near > 1e-4)
        result[take], mass[take] = guess[take], 1
    floor = float(np.percentile(d[~hidden], 10)) if (~hidden).any() else 0.0
    result[mass == 0] = floor
    return result


def snap_steps(
    value: FloatArray,
    lab: FloatArray,
    radius_px: int,
    jump: FloatArray | float,
    slack: float,
    floor: float = 0.1,
) -> FloatArray:
    """Gives every pixel of a depth step to one of its two sides, by colour.

    Args:
        value: (h, w) disparity or parallax.
        lab: (h, w, 3) colour whose Euclidean distance means something (8-bit Lab as floats).
        radius_px: half the width of the transitions to be sharpened.
        jump: (h, w) or one number; smaller differences within the radius are slopes, left alone.
        slack: how far a continued plane may go from the nearest pixel of its side (a side may itself
            be two things, whose common plane would be neither).
        floor: share of the way from far to near up to which a pixel is at the far side's own depth.  Where
            that is many times farther, a tenth of the way in parallax is most of the way in depth.

    Returns:
        (h, w): in each transition the continued plane of the near or of the far side, nothing between.
    """
    kernel = np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)
    high, low = cv2.dilate(value, kernel), cv2.erode(value, kernel)
    band = (high - low) > jump
    if not band.any():
        return value
    rows, columns = np.flatnonzero(band.any(1)), np.flatnonzero(band.any(0))
    pad = 2 * radius_px + 3
    here = (
        slice(max(int(rows[0]) - pad, 0), int(rows[-1]) + pad + 1),
        slice(max(int(columns[0]) - pad, 0), int(columns[-1]) + pad + 1),
    )
    result = value.copy()
    result[here] = _snap_window(
        value[here], lab[here], radius_px, (band[here], high[here], low[here]), slack, floor
    )
    return result


def without_islands(snapped: FloatArray, value: FloatArray, jump: float) -> FloatArray:
    """Gives pixels back that went to a side which they do not touch: colour alone makes no surface.

    A pale spot of a petal has the colour of the sky beside it; as sky it would be a hole in the petal.

    Args:
        snapped: (h, w) from `snap_steps`.
        value: (h, w) as it was.
        jump: by how much a pixel changes that changes sides.
    """
    result, limit = snapped, jump
    while (change := np.abs(result - value)).max() > limit:
        result = np.where(_is_island(result, change, change > limit), value, result)
        limit *= 8  # beside a step there may be another one that is many times as high
    return result.astype(np.float32)


def _is_island(value: FloatArray, change: FloatArray, moved: BoolArray) -> BoolArray:
    """Tells which of the moved pixels (h, w) lie in pieces that touch nothing of their new depth."""
    _, labels = cv2.connectedComponents(moved.astype(np.uint8), connectivity=4)
    joined = np.zeros(int(labels.max()) + 1, np.bool_)
    for axis in (0, 1):
        for step in (1, -1):
            beside, free = np.roll(value, step, axis), ~np.roll(moved, step, axis)
            meets = moved & free & (np.abs(beside - value) < TOUCH_SHARE * change)
            joined[np.unique(labels[meets])] = True
    return np.asarray(moved & ~joined[labels])


def _snap_window(
    value: FloatArray,
    lab: FloatArray,
    radius_px: int,
    found: tuple[BoolArray, FloatArray, FloatArray],
    slack: float,
    floor: float,
) -> FloatArray:
    band, high, low = found
    reach = np.maximum(high - low, 1e-9)
    t = np.where(band, (value - low) / reach, 0.5).astype(np.float32)
    near = _Side.of(band & (t > 0.88), value, lab, radius_px)
    far = _Side.of(band & (t < 0.12), value, lab, radius_px, band & (t < 1.2 * floor))
    spread = ((near.color - far.color) ** 2).sum(2)
    distances = ((lab - far.color) ** 2).sum(2) - ((lab - near.color) ** 2).sum(2)
    odds = cv2.GaussianBlur(distances / (0.25 * spread + 60) + 3.5 * (t - 0.5), (0, 0), 1.0)
    # a side of which nothing is in reach gives the pixel to the other
    odds = np.where(near.absent, -1, np.where(far.absent, 1, odds))
    snapped = np.where(odds > 0, near.plane_within(slack), far.plane_within(slack))
    # what lies on its plateau already keeps its own value
    settled = ((odds > 0) & (t > 0.9)) | ((odds <= 0) & (t < floor)) | (near.absent & far.absent)
    result = np.where(band & ~settled, snapped, value).astype(np.float32)
    touched = cv2.dilate(band.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return np.where(touched, cv2.medianBlur(result, 5), result)


@dataclass(frozen=True)
class _Side:
    """One side of the steps, as each pixel sees it through a window.

    Attributes:
        plane: (h, w) the side's weighted plane, continued to the pixel.
        closest: (h, w) value of the nearest pixel of the side.
        color: (h, w, 3) its mean colour.
        absent: (h, w) nothing of it is in the window.
    """

    plane: FloatArray
    closest: FloatArray
    color: FloatArray
    absent: BoolArray

    def plane_within(self, slack: float) -> FloatArray:
        """The plane, kept near the closest pixel."""
        return np.asarray(np.clip(self.plane, self.closest - slack, self.closest + slack))

    @staticmethod
    def of(
        side: BoolArray,
        value: FloatArray,
        lab: FloatArray,
        radius_px: int,
        flat: BoolArray | None = None,  # the pixels of the side that are beyond its slope, if not all are
    ) -> "_Side":
        h, w = value.shape
        step = 2 if radius_px >= 8 and min(h, w) > 16 else 1  # wide windows need no full resolution
        reach = (4 * radius_px) // step // 2 * 2 + 1
        window = (reach, reach)
        mask, v = side[::step, ::step].astype(np.float64), value[::step, ::step].astype(np.float64)
        mass = cv2.blur(mask, window)
        absent = mass < 0.5 / reach**2
        safe = np.where(absent, 1.0, mass)
        y, x = np.mgrid[: v.shape[0], : v.shape[1]].astype(np.float64)

        def mean(v: DoubleArray) -> DoubleArray:
            return np.asarray(cv2.blur(v * mask, window)) / safe

        middle = float(np.median(v))
        v = v - middle
        mx, my, mv = mean(x), mean(y), mean(v)
        damp = (0.05 * radius_px**2 + 0.5) / step**2  # a thin side has no slope of its own
        xx, yy, xy = mean(x * x) - mx * mx + damp, mean(y * y) - my * my + damp, mean(x * y) - mx * my
        xv, yv = mean(x * v) - mx * mv, mean(y * v) - my * mv
        det = np.maximum(xx * yy - xy * xy, 1e-9)
        plane = mv + ((yy * xv - xy * yv) * (x - mx) + (xx * yv - xy * xv) * (y - my)) / det + middle
        color = cv2.blur(lab[::step, ::step] * mask[..., None].astype(np.float32), window)
        color = color / safe[..., None].astype(np.float32)
        plane, color, gone = (
            cv2.resize(m, (w, h), interpolation=cv2.INTER_LINEAR) if step > 1 else m
            for m in (plane.astype(np.float32), color.astype(np.float32), absent.astype(np.float32))
        )
        plateau = side if flat is None or not flat.any() else flat
        return _Side(plane, _closest(plateau, value), color, gone > 0.1)


def _closest(side: BoolArray, value: FloatArray) -> FloatArray:
    """(h, w) value of the nearest pixel of the side; unchanged where there is none."""
    if not side.any():
        return value
    _, labels = cv2.distanceTransformWithLabels(
        (~side).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_label = np.zeros(int(labels.max()) + 1, np.float32)
    of_label[labels[side]] = value[side]
    return of_label[labels]


def resize_steps(value: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Resizes (h, w) to (width, height): linear on slopes, nearest at steps, so that steps stay steps."""
    if value.shape[1::-1] == size:
        return value
    smooth = cv2.resize(value, size, interpolation=cv2.INTER_LINEAR)
    blocks = cv2.resize(value, size, interpolation=cv2.INTER_NEAREST)
    kernel = np.ones((3, 3), np.uint8)
    jump = cv2.morphologyEx(value, cv2.MORPH_GRADIENT, kernel)
    limit = 0.05 * float(np.percentile(np.abs(value), 98)) + 1e-9
    step = cv2.resize((jump > limit).astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    return np.where(step, blocks, smooth).astype(np.float32)
