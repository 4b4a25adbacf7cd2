"""Pictures whose depth is told by focus: a sharp thing before a blurred ground.

Focus is the ratio of fine to coarse detail; the gate opens only where a good share of the
picture is decidedly blurred and there is no sky to explain it.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.depth.sky import smooth_like


def focus_ratio(full: ByteArray, size: tuple[int, int], sky: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Sharpness 0..1 and the weight of each reading.

    Args:
        full: (h, w, 3) u8 RGB at the full size.
        size: width, height of the answer, about a quarter.
        sky: (height, width) there.

    Returns:
        Ratio of fine to coarse detail over its 92nd percentile, and coarse energy where it can be
        read (0 elsewhere); both (height, width).
    """
    fine, coarse = _bands(full)
    ratio, weight = _ratio(fine, coarse, size, (3.0, 4.0))
    weight = np.where(sky, 0, weight).astype(np.float32)
    return np.clip(ratio / _top(ratio, weight), 0, 2).astype(np.float32), weight


def local_ratio(full: ByteArray, size: tuple[int, int]) -> FloatArray:
    """The same ratio (height, width) over a third of the distance: less sure, and close to the edges."""
    fine, coarse = _bands(full)
    top = _top(*_ratio(fine, coarse, size, (3.0, 4.0)))
    return np.clip(_ratio(fine, coarse, size, (1.2, 2.0))[0] / top, 0, 2).astype(np.float32)


def _bands(full: ByteArray) -> tuple[FloatArray, FloatArray]:
    """Fine and coarse detail of a picture, (h, w) grey levels."""
    luma = cv2.cvtColor(full, cv2.COLOR_RGB2GRAY).astype(np.float32)
    smooth = [cv2.GaussianBlur(luma, (0, 0), sigma) for sigma in (0.7, 1.6, 3.0, 7.0)]
    return (smooth[0] - smooth[1]).astype(np.float32), (smooth[2] - smooth[3]).astype(np.float32)


def _ratio(
    fine: FloatArray, coarse: FloatArray, size: tuple[int, int], sigmas: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Local energy of fine over coarse detail, and that of the coarse where it can be read, else 0."""
    energies = []
    for band, sigma in zip((fine, coarse), sigmas, strict=True):
        power = cv2.resize(band * band, size, interpolation=cv2.INTER_AREA)
        energies.append(np.sqrt(np.maximum(cv2.GaussianBlur(power, (0, 0), sigma), 0)))
    ratio = energies[0] / (energies[1] + 0.5)
    return ratio.astype(np.float32), np.where(energies[1] > 2.5, energies[1], 0).astype(np.float32)


def _top(ratio: FloatArray, weight: FloatArray) -> float:
    """What counts as sharp in a picture."""
    readable = ratio[weight > 0]
    return max(float(np.percentile(readable, 92)), 1e-6) if readable.size else 1.0


def macro_gate(ratio: FloatArray, weight: FloatArray, sky: BoolArray) -> float:
    """How surely (0..1) this is a close-up with a blurred ground."""
    readable = weight > 0
    if readable.mean() < 0.05:
        return 0.0
    blurred = float((ratio[readable] < 0.22).mean())
    return float(np.clip((blurred - 0.18) / 0.08, 0, 1) * np.clip((0.06 - sky.mean()) / 0.03, 0, 1))


def focus_disparity(
    ratio: FloatArray, weight: FloatArray, local: FloatArray, quarter: ByteArray
) -> FloatArray:
    """Disparity 0..1 of a close-up: the thing in focus is near as a whole, its middle nearest.

    Args:
        ratio: of `focus_ratio`.
        weight: likewise.
        local: of `local_ratio`.
        quarter: (h, w, 3) u8 RGB at their size.
    """
    sharp, crisp = _sharpness(ratio), _sharpness(local)
    broad, _ = _around(sharp, weight, 9)
    close, mass = _around(sharp, weight, 4)
    confidence = np.maximum(weight, 0.02).astype(np.float32)
    alike = smooth_like(quarter, sharp * confidence, 300, 8) / smooth_like(quarter, confidence, 300, 8)
    thing = thing_in_focus(crisp, (close < 0.22) & (mass > 2), alike, quarter)
    whole = smooth_like(quarter, thing.astype(np.float32), 3, 12)
    inside = cv2.distanceTransform(thing.astype(np.uint8), cv2.DIST_L2, 5)
    dome = cv2.GaussianBlur(np.sqrt(inside / max(float(inside.max()), 1e-6)), (0, 0), 3)
    relief = np.clip(broad, 0, 1) * whole
    behind = np.clip(alike, 0, 1) * (1 - whole)  # the less blurred, the less far behind
    return (0.45 + 0.22 * whole + 0.14 * (relief + behind) + 0.16 * dome).astype(np.float32)


def _sharpness(ratio: FloatArray) -> FloatArray:
    """0..1 from a ratio of details."""
    return np.clip((ratio - 0.12) / 0.45, 0, 1).astype(np.float32)


def _around(sharp: FloatArray, weight: FloatArray, sigma: float) -> tuple[FloatArray, FloatArray]:
    """Weighted mean sharpness around each pixel, and the mean weight."""
    mass = cv2.GaussianBlur(weight, (0, 0), sigma)
    return cv2.GaussianBlur(sharp * weight, (0, 0), sigma) / (mass + 0.3), mass


def thing_in_focus(crisp: FloatArray, blurred: BoolArray, alike: FloatArray, quarter: ByteArray) -> BoolArray:
    """The whole thing of which parts are in focus: a petal that leaves the focal plane belongs to its flower.

    The dark ground between two sharp petals is as sharp as they are if looked at from afar: so it is told
    close to the edges what is sharp, and then by colour what goes with it.

    Args:
        crisp: (h, w) sharpness 0..1, close to the edges.
        blurred: (h, w) where detail can be read around a pixel and is not sharp.
        alike: (h, w) sharpness 0..1 of what has the same colour and is connected.
        quarter: (h, w, 3) u8 RGB.

    Returns:
        (h, w), by GrabCut from the sharp parts; the sharp parts alone where there is nothing to cut.
    """
    unit = quarter.shape[0] / 180
    seed = _large_parts(cv2.GaussianBlur(crisp, (0, 0), 1) > 0.6)
    seed = _large_parts(cv2.erode(seed.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    if not 0.005 < seed.mean() < 0.6:
        return seed
    away = cv2.distanceTransform((~seed).astype(np.uint8), cv2.DIST_L2, 5) / unit
    ground = blurred & (away > 8)
    if not ground.any():
        return seed
    likely = (alike > 0.45) | ((away < 36) & (_color_odds(quarter, seed, ground) > 4))
    labels = np.where(likely, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[ground], labels[seed] = cv2.GC_BGD, cv2.GC_FGD
    cv2.setRNGSeed(0)  # its k-means draws from OpenCV's global generator
    pixels = np.ascontiguousarray(quarter[..., ::-1])
    cv2.grabCut(pixels, labels, None, np.zeros((1, 65)), np.zeros((1, 65)), 4, cv2.GC_INIT_WITH_MASK)
    cut = (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)
    smooth = cv2.medianBlur(cut.astype(np.uint8), 5) > 0
    _, parts = cv2.connectedComponents((smooth | seed).astype(np.uint8), connectivity=4)
    return np.asarray(np.isin(parts, np.unique(parts[seed])), bool)


def _color_odds(quarter: ByteArray, thing: BoolArray, ground: BoolArray) -> FloatArray:
    """How much more often each pixel's colour (h, w) is found in a thing than in its ground."""
    bins = (quarter // 16).astype(np.int32) @ np.array([256, 16, 1], np.int32)
    counts = []
    for mask in (thing, ground):
        count = np.bincount(bins[mask], minlength=4096).astype(np.float32).reshape(16, 16, 16)
        for k in range(3):
            count = 0.5 * count + 0.25 * (np.roll(count, 1, k) + np.roll(count, -1, k))
        counts.append(count.ravel() / np.float32(mask.sum()))
    return np.asarray(((counts[0] + 1e-5) / (counts[1] + 1e-5))[bins], np.float32)


def _large_parts(mask: BoolArray) -> BoolArray:
    """Components of at least a sixth of the largest one."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    keep = area * 6 >= max(int(area.max()), 1)
    return np.asarray(keep[labels], bool)
