"""Rims: the bands along contours, which the description's window takes for rough regions of their own."""

import math
from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.clusters import GRID_PX, Region, window_px
from wzviewer.worker.models.builtin.detail.measures import drawn_not_lettered, luma

MOST_TONES, MOST_RADIUS = 0.4, 3.0
"""A rim has the tones of the contour's two sides and none between, and is no wider than the window that made
it, of which this is in deviations."""
LIGHTNESS_WEIGHT = 0.5  # light and shade are of one thing
BETTER = 0.7
"""What takes a place is so much nearer to it in colour than its own region: a rail or a lake has its own."""
LAB_PER_PX, FARTHEST_PX = 0.6, 26.0
"""What a grid pixel of distance counts, in CIELAB: a rim belongs to what touches it."""
LAB_PER_ROUGHNESS = 1.5
"""What roughness counts: in doubt a rim is of the smoother side, where nothing will be laid on."""
MEDIAN_PX = 5  # of the grid


def without_rims(
    image: FloatArray, labels: ByteArray, regions: tuple[Region, ...]
) -> tuple[ByteArray, tuple[Region, ...]]:
    """Returns labels and regions in which what lies along a contour is of what lies beside it, by its colour.

    Else a flower before the sky wears a band that is rougher than both, and stone or fur would grow there;
    and where white petals meet a yellow disc the mixture is as green as leaves.

    Args:
        image: ``(h, w, 3)`` in 0..1.
        labels: ``(h, w)`` u8, index into `regions`.
        regions: statistics per label; those that stay keep theirs but for their share.
    """
    if len(regions) < 2 or min(labels.shape) < 4 * GRID_PX:
        return labels, regions
    size = (labels.shape[1] // GRID_PX, labels.shape[0] // GRID_PX)
    small = cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST)
    tones = cv2.resize(drawn_not_lettered(luma(image) * np.float32(255)), size, interpolation=cv2.INTER_AREA)
    lab = _plain_lab(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
    masks = [small == index for index in range(len(regions))]
    most_px = MOST_RADIUS * window_px(*labels.shape[::-1]) / GRID_PX
    rims = [_thin_pieces(mask, tones, most_px) for mask in masks]
    away = np.stack([_colour_distance(lab, region) for region in regions])
    reach = np.stack([_reach(m & ~rim, region) for m, rim, region in zip(masks, rims, regions, strict=True)])
    owner = np.argmin(away + reach, 0)
    here, there = (np.take_along_axis(away, which[None].astype(np.intp), 0)[0] for which in (small, owner))
    merged = np.where(np.any(rims, axis=0) & (there < BETTER * here), owner, small).astype(np.uint8)
    large = cv2.resize(merged, labels.shape[::-1], interpolation=cv2.INTER_NEAREST)
    shares = np.bincount(large.ravel(), minlength=len(regions)) / large.size
    return large, tuple(replace(region, share=float(s)) for region, s in zip(regions, shares, strict=True))


def _thin_pieces(mask: BoolArray, tones: FloatArray, most_px: float) -> BoolArray:
    """Returns the pieces of a region that are thin and have two tones."""
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    inside = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    radius = np.zeros(count, np.float32)
    np.maximum.at(radius, pieces[mask], inside[mask])
    mean = np.bincount(pieces.ravel(), tones.ravel(), count) / np.maximum(stats[:, cv2.CC_STAT_AREA], 1)
    thin = (radius < most_px) & (mean < MOST_TONES)
    thin[0] = False
    found: BoolArray = thin[pieces]
    return found


def _colour_distance(lab: FloatArray, region: Region) -> FloatArray:
    mean = np.array([region.lightness, region.green_red, region.blue_yellow], np.float32)
    return np.linalg.norm((lab - mean) * np.array([LIGHTNESS_WEIGHT, 1, 1], np.float32), axis=2)


def _reach(core: BoolArray, region: Region) -> FloatArray:
    """Returns what distance and roughness count against a region, in CIELAB; far away it is infinite."""
    if not core.any():
        return np.full(core.shape, np.inf, np.float32)
    away = cv2.distanceTransform((~core).astype(np.uint8), cv2.DIST_L2, 3)
    rough = np.float32(LAB_PER_ROUGHNESS * math.log1p(region.fine))
    return np.where(away > FARTHEST_PX, np.float32(np.inf), np.float32(LAB_PER_PX) * away + rough)


def _plain_lab(image: FloatArray) -> FloatArray:
    """Returns CIELAB without mixtures: of two sides of a contour the median takes one."""
    rgb = np.round(image.clip(0, 1) * 255).astype(np.uint8)
    plain = cv2.medianBlur(rgb, MEDIAN_PX).astype(np.float32) * np.float32(1 / 255)
    return cv2.cvtColor(plain, cv2.COLOR_RGB2LAB)
