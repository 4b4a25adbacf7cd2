"""Regions of one look: k-means over colour, roughness and direction, and the statistics of each region."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.measures import (
    blurred,
    dense_rms,
    drawn_not_lettered,
    first_band,
    luma,
    orientation,
    widely_blurred,
)

MAX_REGIONS = 10
GRID_PX = 2  # regions are drawn on a grid this coarse
WINDOW_PX = 6.0
LEAST_CONTOUR = 3.0  # grey levels per px; weaker ones are texture and noise
FULL_SIDE_PX = 900  # pictures with shorter sides are read through a smaller window


@dataclass(frozen=True)
class Region:
    """The statistics of one region; energies in grey levels, colour in CIELAB.

    Attributes:
        share: part of the picture, 0..1.
        lightness: 0..100.
        green_red: a*, negative is green.
        blue_yellow: b*, negative is blue.
        fine: median RMS of the finest octave, sparse edges not counted.
        middle: the same of the next octave.
        wide: the same of the one after.
        coherence: mean, 0 (no direction) to 1.
        centre_y: mean row as a fraction of the height, 0 at the top.
        at_top: part of the picture's top row that is of this region.
        built: part of its contours that run along two axes at right angles: .22 to .30 in what grew or broke,
            .36 and more in what people built.
        calm: tenth percentile of `fine`: the camera's noise, where there is nothing else.
        tones: 1 where it has tones of all kinds, as texture has, 0 where it has two and contours between:
            .65 to .94 in stone, gravel and carpet, .34 to .54 in wrought iron, .17 in sky behind leaves.
    """

    share: float
    lightness: float
    green_red: float
    blue_yellow: float
    fine: float
    middle: float
    wide: float
    coherence: float
    centre_y: float
    at_top: float
    built: float = 0.0
    calm: float = 0.25
    tones: float = 1.0


@dataclass(frozen=True)
class _Maps:
    lab: FloatArray  # (h, w, 3)
    energy: FloatArray  # (h, w, 3): fine, middle, wide
    coherence: FloatArray  # (h, w)
    contours: FloatArray  # (h, w, 2): direction in degrees modulo 90, and strength


def regions_of(image: FloatArray) -> tuple[ByteArray, tuple[Region, ...]]:
    """Returns the label map ``(h, w)`` and the statistics of every label, largest region first.

    Args:
        image: ``(h, w, 3)`` in 0..1, of any size.
    """
    height, width = image.shape[:2]
    maps = _measured(image)
    features = _features(maps)
    centres = _k_means(features.reshape(-1, features.shape[2]), MAX_REGIONS)
    labels = _nearest(features, centres)
    if min(labels.shape) >= 8:
        labels = cv2.medianBlur(labels, 5)
    labels, count = _by_size(labels)
    size = (labels.shape[1], labels.shape[0])
    tones = cv2.resize(drawn_not_lettered(luma(image) * np.float32(255)), size, interpolation=cv2.INTER_AREA)
    masks = [labels == index for index in range(count)]
    regions = tuple(replace(_region(maps, mask), tones=float(tones[mask].mean())) for mask in masks)
    return cv2.resize(labels, (width, height), interpolation=cv2.INTER_NEAREST), regions


def statistics(image: FloatArray, labels: ByteArray, count: int) -> tuple[Region, ...]:
    """Returns the statistics of regions that are known already; ``labels`` is ``(h, w)``."""
    maps = _measured(image)
    size = (maps.coherence.shape[1], maps.coherence.shape[0])
    small = cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST)
    return tuple(_region(maps, small == index) for index in range(count))


def split_off(
    image: FloatArray, labels: ByteArray, regions: tuple[Region, ...], mask: BoolArray
) -> tuple[ByteArray, tuple[Region, ...]]:
    """Returns labels and regions with one region more, the last, where the mask ``(h, w)`` is."""
    found = statistics(image, mask.astype(np.uint8), 2)[1]
    return np.where(mask, len(regions), labels).astype(np.uint8), (*regions, found)


def _measured(image: FloatArray) -> _Maps:
    height, width = image.shape[:2]
    grey = luma(image) * np.float32(255)
    half = cv2.resize(grey, (max(width // 2, 1), max(height // 2, 1)), interpolation=cv2.INTER_AREA)
    quarter = cv2.resize(grey, (max(width // 4, 1), max(height // 4, 1)), interpolation=cv2.INTER_AREA)
    size = (max(width // GRID_PX, 1), max(height // GRID_PX, 1))
    window = window_px(width, height)
    planes = [(grey, window), (half, window), (quarter, window / 2)]
    energy = [
        cv2.resize(dense_rms(first_band(p), s), size, interpolation=cv2.INTER_LINEAR) for p, s in planes
    ]
    coherence = orientation(half, 1.0, 0.8 * window).coherence
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(np.clip(small, 0, 1), cv2.COLOR_RGB2LAB)
    coherence = cv2.resize(coherence, size, interpolation=cv2.INTER_LINEAR)
    return _Maps(lab, np.stack(energy, 2), coherence, _contours(grey, size))


def _contours(grey: FloatArray, size: tuple[int, int]) -> FloatArray:
    smooth = blurred(grey, 0.7)
    x, y = (cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=0.125) for order in ((1, 0), (0, 1)))
    strength, angle = cv2.cartToPolar(x, y, angleInDegrees=True)
    strength *= strength > LEAST_CONTOUR
    pair = np.stack([np.mod(angle, 90), strength], 2)
    return cv2.resize(pair, size, interpolation=cv2.INTER_NEAREST)


def _built(contours: FloatArray) -> float:
    """The best share of contour strength (n, 2) within about 10 degrees of two axes at right angles."""
    counts, _ = np.histogram(contours[:, 0], 18, (0, 90), weights=contours[:, 1])
    kernel = ((0, 1.0), (1, 1.0), (-1, 1.0), (2, 0.5), (-2, 0.5))
    near = sum(weight * np.roll(counts, step) for step, weight in kernel)
    return float(np.max(near) / (counts.sum() + 1e-6))


def window_px(width: int, height: int) -> float:
    """Returns the deviation of the window that features are read through."""
    return WINDOW_PX * min(1.0, max(0.3, max(width, height) / FULL_SIDE_PX))


def _features(maps: _Maps) -> FloatArray:
    rows, columns = maps.coherence.shape
    lab = widely_blurred(maps.lab, window_px(columns * GRID_PX, rows * GRID_PX) / GRID_PX)
    energy = np.log(1 + maps.energy)
    parts = [
        lab[..., 0] / 25,
        lab[..., 1] / 9,
        lab[..., 2] / 9,
        energy[..., 0],
        energy[..., 1],
        energy[..., 2],
    ]
    return np.stack([*parts, 0.8 * maps.coherence], 2).astype(np.float32)


def _k_means(points: FloatArray, count: int) -> FloatArray:
    """Lloyd's algorithm from farthest-point seeds: no randomness, hence the same regions every time."""
    sample = points[:: max(len(points) // 6000, 1)]
    centres = [sample.mean(0)]
    nearest = np.square(sample - centres[0]).sum(1)
    for _ in range(count - 1):
        if nearest.max() < 0.05:
            break
        # the 98th percentile rather than the maximum: outliers are no region
        centres.append(sample[np.argsort(nearest)[int(0.98 * (len(sample) - 1))]])
        nearest = np.minimum(nearest, np.square(sample - centres[-1]).sum(1))
    table = np.stack(centres)
    for _ in range(12):
        owner = np.square(sample[:, None] - table[None]).sum(2).argmin(1)
        table = np.stack(
            [sample[owner == k].mean(0) if (owner == k).any() else table[k] for k in range(len(table))]
        )
    return table


def _nearest(features: FloatArray, centres: FloatArray) -> ByteArray:
    distances = features @ centres.T * -2 + np.square(centres).sum(1)
    return distances.argmin(2).astype(np.uint8)


def _by_size(labels: ByteArray) -> tuple[ByteArray, int]:
    counts = np.bincount(labels.ravel(), minlength=MAX_REGIONS)
    order = np.argsort(-counts, kind="stable")
    table = np.empty(len(counts), np.uint8)
    table[order] = np.arange(len(counts))
    return table[labels], int((counts > 0).sum())


def _region(maps: _Maps, mask: np.ndarray) -> Region:
    if not mask.any():
        return Region(0, 50, 0, 0, 0, 0, 0, 0, 0.5, 0)
    lightness, green_red, blue_yellow = (float(value) for value in maps.lab[mask].mean(0))
    fine, middle, wide = (float(value) for value in np.median(maps.energy[mask], axis=0))
    rows = np.flatnonzero(mask) // mask.shape[1]
    return Region(
        share=float(mask.mean()),
        lightness=lightness,
        green_red=green_red,
        blue_yellow=blue_yellow,
        fine=fine,
        middle=middle,
        wide=wide,
        coherence=float(maps.coherence[mask].mean()),
        centre_y=float(rows.mean() / mask.shape[0]),
        at_top=float(mask[0].mean()),
        built=_built(maps.contours[mask]),
        calm=float(np.percentile(maps.energy[mask, 0], 10)),
    )
