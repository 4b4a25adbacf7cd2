"""Pictures whose depth is told by focus: a sharp thing before a blurred ground.

Focus is the ratio of fine to coarse detail; the gate opens only where a good share of the
picture is decidedly blurred and there is no sky to explain it.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.depth.refine import segment
from wzviewer.worker.models.builtin.depth.sky import smooth_like

THING_THRESHOLD = 600.0  # graph segments as large as whole flowers


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
    """Disparity 0..1 of a close-up: sharp is near, and the middle of a sharp thing nearest.

    Args:
        ratio: of `focus_ratio`.
        weight: likewise.
        quarter: (h, w, 3) u8 RGB at their size.
    """
    sharp = np.clip((ratio - 0.12) / 0.45, 0, 1).astype(np.float32)
    smooth = smooth_like(quarter, sharp * weight, 300, 12)
    smooth /= np.maximum(smooth_like(quarter, weight, 300, 12), 1e-4)
    # a petal without texture of its own takes the reading of the thing that it belongs to
    labels = segment(
        (quarter / np.float32(255)).astype(np.float32), max(quarter.shape), 0.8, THING_THRESHOLD, 60
    )
    mass = np.bincount(labels.ravel(), weight.ravel()) + 1e-3
    thing = (np.bincount(labels.ravel(), (sharp * weight).ravel()) / mass).astype(np.float32)[labels]
    known = (mass[labels] > 1).astype(np.float32)
    whole = smooth + 0.65 * known * (thing - smooth)
    sharp = smooth_like(quarter, whole.astype(np.float32), 4, 12)
    low, high = np.percentile(sharp, (3, 97))
    sharp = np.clip((sharp - low) / max(float(high - low), 1e-6), 0, 1).astype(np.float32)
    inside = cv2.distanceTransform((sharp > 0.45).astype(np.uint8), cv2.DIST_L2, 5)
    dome = np.sqrt(inside / max(float(inside.max()), 1e-6))
    return (0.22 + 0.58 * sharp + 0.2 * dome).astype(np.float32)
