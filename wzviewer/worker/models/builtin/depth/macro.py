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
    luma = cv2.cvtColor(full, cv2.COLOR_RGB2GRAY).astype(np.float32)
    fine = cv2.GaussianBlur(luma, (0, 0), 0.7) - cv2.GaussianBlur(luma, (0, 0), 1.6)
    coarse = cv2.GaussianBlur(luma, (0, 0), 3) - cv2.GaussianBlur(luma, (0, 0), 7)
    energies = []
    for band, sigma in ((fine, 3.0), (coarse, 4.0)):
        power = cv2.resize(band * band, size, interpolation=cv2.INTER_AREA)
        energies.append(np.sqrt(np.maximum(cv2.GaussianBlur(power, (0, 0), sigma), 0)))
    ratio = energies[0] / (energies[1] + 0.5)
    weight = np.where((energies[1] > 2.5) & ~sky, energies[1], 0).astype(np.float32)
    readable = ratio[weight > 0]
    top = float(np.percentile(readable, 92)) if readable.size else 1.0
    return np.clip(ratio / max(top, 1e-6), 0, 2).astype(np.float32), weight


def macro_gate(ratio: FloatArray, weight: FloatArray, sky: BoolArray) -> float:
    """How surely (0..1) this is a close-up with a blurred ground."""
    readable = weight > 0
    if readable.mean() < 0.05:
        return 0.0
    blurred = float((ratio[readable] < 0.22).mean())
    return float(np.clip((blurred - 0.18) / 0.08, 0, 1) * np.clip((0.06 - sky.mean()) / 0.03, 0, 1))


def focus_disparity(ratio: FloatArray, weight: FloatArray, quarter: ByteArray) -> FloatArray:
    """Disparity 0..1 of a close-up: the thing in focus is near as a whole, its middle nearest.

    Args:
        ratio: of `focus_ratio`.
        weight: likewise.
        quarter: (h, w, 3) u8 RGB at their size.
    """
    sharp = np.clip((ratio - 0.12) / 0.45, 0, 1).astype(np.float32)
    broad, _ = _around(sharp, weight, 9)
    close, mass = _around(sharp, weight, 4)
    thing = thing_in_focus(sharp, (close < 0.22) & (mass > 2), quarter)
    whole = smooth_like(quarter, thing.astype(np.float32), 3, 12)
    inside = cv2.distanceTransform(thing.astype(np.uint8), cv2.DIST_L2, 5)
    dome = cv2.GaussianBlur(np.sqrt(inside / max(float(inside.max()), 1e-6)), (0, 0), 3)
    relief = np.clip(broad, 0, 1) * (0.4 + 0.6 * whole)
    return (0.45 + 0.22 * whole + 0.14 * relief + 0.16 * dome).astype(np.float32)


def _around(sharp: FloatArray, weight: FloatArray, sigma: float) -> tuple[FloatArray, FloatArray]:
    """Weighted mean sharpness around each pixel, and the mean weight."""
    mass = cv2.GaussianBlur(weight, (0, 0), sigma)
    return cv2.GaussianBlur(sharp * weight, (0, 0), sigma) / (mass + 0.3), mass


def thing_in_focus(sharp: FloatArray, blurred: BoolArray, quarter: ByteArray) -> BoolArray:
    """The whole thing of which parts are in focus: a petal that leaves the focal plane belongs to its flower.

    Args:
        sharp: (h, w) sharpness 0..1.
        blurred: (h, w) where detail can be read around a pixel and is not sharp.
        quarter: (h, w, 3) u8 RGB.

    Returns:
        (h, w), by GrabCut from the sharp parts; the sharp parts alone where there is nothing to cut.
    """
    unit = quarter.shape[0] / 180
    seed = _large_parts(cv2.GaussianBlur(sharp, (0, 0), 2) > 0.55)
    if not 0.005 < seed.mean() < 0.6:
        return seed
    away = cv2.distanceTransform((~seed).astype(np.uint8), cv2.DIST_L2, 5) / unit
    labels = np.where((sharp > 0.3) | (away < 8), cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[(blurred & (away > 12)) | (away > 36)] = cv2.GC_BGD
    labels[seed] = cv2.GC_FGD
    if not (labels == cv2.GC_BGD).any():
        return seed
    cv2.setRNGSeed(0)  # its k-means draws from OpenCV's global generator
    pixels = np.ascontiguousarray(quarter[..., ::-1])
    cv2.grabCut(pixels, labels, None, np.zeros((1, 65)), np.zeros((1, 65)), 3, cv2.GC_INIT_WITH_MASK)
    cut = (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)
    smooth = cv2.medianBlur(cut.astype(np.uint8), 5) > 0
    _, parts = cv2.connectedComponents((smooth | seed).astype(np.uint8), connectivity=4)
    return np.asarray(np.isin(parts, np.unique(parts[seed])), bool)


def _large_parts(mask: BoolArray) -> BoolArray:
    """Components of at least a sixth of the largest one."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    keep = area * 6 >= max(int(area.max()), 1)
    return np.asarray(keep[labels], bool)
