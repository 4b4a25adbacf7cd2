"""Closed-form registration of an estimate to a target: one slope, one offset per segment.

    target = slope * estimate + offset[segment] + noise

A single global slope and offset is biased as soon as offsets differ between things (they correlate
with depth), and no later shift repairs a wrong slope.  The fixed-effects estimator takes the slope
from differences *inside* segments, so it never sees the offsets.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray

ROUNDS = 10
FEWEST_PIXELS = 20  # of a segment that may have an offset of its own


@dataclass(frozen=True)
class FixedEffects:
    """Result of `fixed_effects`.

    Attributes:
        slope: common to all segments.
        offsets: (n,) per label; unseen segments borrow from those that they touch.
        global_slope, global_offset: of the plain robust line, for comparison and as a guard.
    """

    slope: float
    offsets: DoubleArray
    global_slope: float
    global_offset: float

    def predict(self, estimate: FloatArray, labels: IntArray) -> DoubleArray:
        """(h, w) registered values."""
        return np.asarray(self.slope * estimate.astype(np.float64) + self.offsets[labels])


def robust_line(e: DoubleArray, t: DoubleArray) -> tuple[float, float]:
    """Slope and offset of t over e, (n,) each, by iteratively reweighted least squares."""
    middle, spread = np.median(t), 3 * np.median(np.abs(t - np.median(t)))
    weight = 1 / (1 + ((t - middle) / (spread + 1e-9)) ** 2)
    slope, offset = 0.0, float(middle)
    for _ in range(ROUNDS):
        mass = weight.sum()
        me, mt = (weight * e).sum() / mass, (weight * t).sum() / mass
        variance = (weight * (e - me) ** 2).sum()
        slope = float((weight * (e - me) * (t - mt)).sum() / variance) if variance > 1e-12 * mass else 0.0
        offset = float(mt - slope * me)
        weight = _cauchy(t - slope * e - offset)
    return slope, offset


def fixed_effects(
    estimate: FloatArray, target: FloatArray, labels: IntArray, visible: BoolArray
) -> FixedEffects:
    """Registers an estimate segment by segment.

    Args:
        estimate: (h, w).
        target: (h, w).
        labels: (h, w) segments 0..n-1.
        visible: (h, w) where the target is defined and not near a step.

    Returns:
        The fit; slope 0 and offset 0 where nothing is visible.
    """
    n = int(labels.max()) + 1
    if np.count_nonzero(visible) < 3:
        return FixedEffects(0.0, np.zeros(n), 0.0, 0.0)
    e, t = estimate[visible].astype(np.float64), target[visible].astype(np.float64)
    where = labels[visible]
    line = robust_line(e, t)
    slope = _guarded(_inner_slope(e, t, where, n), line[0])
    offsets = segment_medians(t - slope * e, where, n)
    offsets = borrow(offsets, labels, line[1] if line[0] == slope else float(np.median(t - slope * e)))
    return FixedEffects(slope, offsets, *line)


def _inner_slope(e: DoubleArray, t: DoubleArray, where: IntArray, n: int) -> float:
    """Slope from differences to the weighted mean of each segment."""

    def means(w: DoubleArray, v: DoubleArray) -> DoubleArray:
        mass = np.maximum(np.bincount(where, w, minlength=n), 1e-12)
        return np.asarray((np.bincount(where, w * v, minlength=n) / mass)[where])

    start = t - _medians(t, where, n)[where]
    weight, slope = _cauchy(start), 0.0
    for _ in range(ROUNDS):
        de, dt = e - means(weight, e), t - means(weight, t)
        variance = (weight * de * de).sum()
        if variance <= 1e-12 * weight.sum():
            return 0.0
        slope = float((weight * de * dt).sum() / variance)
        residual = t - slope * e
        weight = _cauchy(residual - means(weight, residual))
    return slope


def _cauchy(residual: DoubleArray) -> DoubleArray:
    """Weights 1 / (1 + (r / 2s)^2) with s from the median."""
    deviation = 1.4826 * float(np.median(np.abs(residual))) + 1e-9
    return np.asarray(1 / (1 + (residual / (2 * deviation)) ** 2))


def _guarded(slope: float, plain: float) -> float:
    """The plain slope where the inner one is absurd, nothing where both are."""
    if slope > 0 and (plain <= 0 or plain / 3 <= slope <= 3 * plain):
        return slope
    if plain > 0:
        return plain
    return 0.0


def _medians(v: DoubleArray, where: IntArray, n: int) -> DoubleArray:
    values = np.full(n, np.nan)
    present = np.unique(where)
    values[present] = ndimage.median(v, where, present)
    return values


def segment_medians(v: DoubleArray, where: IntArray, n: int) -> DoubleArray:
    """(n,) median of `v` per label, nan below `FEWEST_PIXELS`."""
    values = _medians(v, where, n)
    values[np.bincount(where, minlength=n) < FEWEST_PIXELS] = np.nan
    return values


def borrow(offsets: DoubleArray, labels: IntArray, default: float) -> DoubleArray:
    """Fills nan offsets with the median over the border with segments that have one, outwards."""
    offsets = offsets.copy()
    if not np.isfinite(offsets).any():
        return np.full_like(offsets, default)
    sides = [(labels[:, 1:], labels[:, :-1]), (labels[1:], labels[:-1])]
    a = np.concatenate([s[0].ravel() for s in sides] + [s[1].ravel() for s in sides])
    b = np.concatenate([s[1].ravel() for s in sides] + [s[0].ravel() for s in sides])
    a, b = a[a != b], b[a != b]
    while True:
        edge = np.isnan(offsets[a]) & np.isfinite(offsets[b])
        if not edge.any():
            break
        found = np.unique(a[edge])
        offsets[found] = ndimage.median(offsets[b[edge]], a[edge], found)
    offsets[np.isnan(offsets)] = default
    return offsets
