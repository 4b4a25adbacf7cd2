"""Where the sky is: the network's opinion, colour rules that may add to it, and a crisp contour.

    network logit -> + smooth pale or blue regions that touch the top -> + blue top rule
                  -> GrabCut outline -> edge-aware smoothing -> spread by colour (outline)
                  -> without what crisp edges cut off (calm) -> full size -> thin things back (outline)

The rules never act alone: a white ceiling has the colour of a cloud.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.depth.calm import cut_off, fine_detail
from wzviewer.worker.models.builtin.depth.outline import regrow, spread

LOGIT_LIMIT = 6.0


@dataclass(frozen=True)
class Sky:
    """A soft and a hard sky map of one picture."""

    soft: FloatArray  # (h, w) 0..1 at the half size
    mask: BoolArray  # (h, w) at the full size


def sigmoid(x: FloatArray | DoubleArray) -> FloatArray:
    """The logistic function, safe for large arguments."""
    return (0.5 * (1 + np.tanh(0.5 * x))).astype(np.float32)


def fuse_sky(logit: FloatArray, quarter: FloatArray) -> FloatArray:
    """Sky probability from the network and the rules.

    Args:
        logit: (h, w) the network's, at the quarter size.
        quarter: (h, w, 3) the picture there, sRGB 0..1.

    Returns:
        (h, w) 0..1.
    """
    lab = cv2.cvtColor(quarter, cv2.COLOR_RGB2LAB)
    logit = np.clip(logit, -LOGIT_LIMIT, LOGIT_LIMIT)
    logit = logit + 2.2 * _supported(colored_like_sky(lab), sigmoid(logit))
    logit = logit + _blue_top(lab, sigmoid(logit))
    return sigmoid(_outline(logit, quarter))


def colored_like_sky(lab: FloatArray) -> BoolArray:
    """Smooth blue, pale or warm regions that hang from the top edge.

    Args:
        lab: (h, w, 3) CIE Lab, L in 0..100.
    """
    light, a, b = lab[..., 0], lab[..., 1], lab[..., 2]
    chroma = np.hypot(a, b)
    blue = sigmoid(-(b + 4) / 3) * sigmoid((light - 30) / 6)
    pale = sigmoid((light - 69) / 4) * sigmoid((14 - chroma) / 3)
    warm = 0.7 * sigmoid((light - 62) / 4) * sigmoid((b - 8) / 3) * sigmoid((a + 6) / 3)
    score = np.maximum(np.maximum(blue, pale), warm) - sigmoid((-a - 10) / 2)
    mean = cv2.GaussianBlur(light, (0, 0), 2)
    texture = np.sqrt(np.maximum(cv2.GaussianBlur(light * light, (0, 0), 2) - mean * mean, 0)) * 2.55
    rows = np.linspace(1.5, 0.1, light.shape[0], dtype=np.float32)[:, None].clip(0, 1)
    score = score * np.exp(-(np.maximum(texture - 2, 0) ** 2) / 25) * rows
    mask = cv2.morphologyEx((score > 0.3).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return _hanging(mask)


def _hanging(mask: ByteArray) -> BoolArray:
    """Components that touch the top over 8 % of the width and cover 1.2 % of the picture."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    touching = np.bincount(labels[0], minlength=count)
    keep = (touching > 0.08 * mask.shape[1]) & (stats[:, cv2.CC_STAT_AREA] > 0.012 * mask.size)
    keep[0] = False
    return np.asarray(keep[labels], bool)


def _supported(mask: BoolArray, probability: FloatArray) -> FloatArray:
    """Keeps the components of which the network believes at least half."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    size = np.bincount(labels.ravel(), minlength=count)
    belief = np.bincount(labels.ravel(), probability.ravel(), minlength=count) / np.maximum(size, 1)
    keep = belief > 0.5
    keep[0] = False
    return keep[labels].astype(np.float32)


def _blue_top(lab: FloatArray, probability: FloatArray) -> FloatArray:
    """Logits to add where a picture is blue along its top and the network half agrees."""
    h = lab.shape[0]
    light, a, b = lab[..., 0], lab[..., 1], lab[..., 2]
    blue = sigmoid(-(b + 4) / 4) * (light > 24) * (a > -10)
    believed = float(probability[: max(h // 13, 1)].mean())
    if float(blue[: max(h // 8, 1)].mean()) < 0.6 or believed < 0.12:
        return np.zeros((1, 1), np.float32)
    y = np.linspace(0, 1, h, dtype=np.float32)[:, None]
    ramp = np.clip((0.65 - y) / 0.25, 0, 1)
    return (3.5 * min((believed - 0.12) / 0.12, 1.0) * blue * ramp).astype(np.float32)


def _outline(logit: FloatArray, quarter: FloatArray) -> FloatArray:
    """Pulls the border between sure sky and sure ground to the colour edge (two GrabCut rounds)."""
    p = sigmoid(logit)
    sure, never = p > 0.9, p < 0.04
    if (p > 0.85).mean() < 0.03 or (p < 0.08).mean() < 0.05:
        return logit
    rows = np.flatnonzero((p > 0.5).any(1))
    never[rows.max() + max(p.shape[0] // 6, 1) :] = True
    never &= ~sure
    labels = np.where(p > 0.5, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    labels[sure], labels[never] = cv2.GC_FGD, cv2.GC_BGD
    cv2.setRNGSeed(0)  # its k-means draws from OpenCV's global generator
    pixels = np.ascontiguousarray((quarter[..., ::-1] * 255).astype(np.uint8))
    background, foreground = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(pixels, labels, None, background, foreground, 2, cv2.GC_INIT_WITH_MASK)
    inside = (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)
    return (0.7 * logit + np.where(inside, 1.6, -1.6)).astype(np.float32)


def smooth_like(guide: ByteArray, value: FloatArray, strength: float, color_sigma: float) -> FloatArray:
    """Fast global smoother: `value` (h, w) made smooth except across edges of `guide` (h, w, 3) u8."""
    value = np.ascontiguousarray(value, np.float32)
    return np.asarray(cv2.ximgproc.fastGlobalSmootherFilter(guide, value, strength, color_sigma), np.float32)


def contour(
    probability: FloatArray, half: ByteArray, full: ByteArray, belief: FloatArray | None = None
) -> Sky:
    """Turns a coarse probability into a mask that follows the picture's edges.

    Args:
        probability: (h, w) at any size.
        half: (h, w, 3) u8 RGB, the picture at half size.
        full: the same at full size.
        belief: (h, w) the network's own probability where the rules have changed it.
    """
    k = _at(probability, half)
    if float(k.max()) < 0.5:
        return Sky(np.zeros_like(k), np.zeros(full.shape[:2], bool))
    sure = (2 * k - 1) ** 2 + 0.02
    share = smooth_like(half, k * sure, 500, 7) / np.maximum(smooth_like(half, sure, 500, 7), 1e-6)
    share = np.clip(share, 0, 1)
    doubted = k if belief is None else _at(belief, half)
    share[spread(share > 0.5, half, doubted) & (share <= 0.5)] = 0.75
    share[cut_off(share > 0.5, fine_detail(full, half.shape[1::-1]), doubted)] = 0
    p = tidy(share.astype(np.float32))
    fine = cv2.resize(p, full.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    fine = smooth_like(full, fine, 12, 9)
    mask = cv2.medianBlur((fine > 0.5).astype(np.uint8), 5) > 0
    mask = regrow(_without_specks(mask), full)
    return Sky(p.astype(np.float32), _without_specks(mask))


def _at(value: FloatArray, image: ByteArray) -> FloatArray:
    return np.asarray(cv2.resize(value, image.shape[1::-1], interpolation=cv2.INTER_LINEAR), np.float32)


def tidy(p: FloatArray) -> FloatArray:
    """Drops sky specks (bright windows, gaps in leaves) and gives islands that hang in the sky back to it."""
    p = p.copy()
    count, labels, stats, _ = cv2.connectedComponentsWithStats((p > 0.5).astype(np.uint8), connectivity=4)
    area, detached = stats[:, cv2.CC_STAT_AREA], stats[:, cv2.CC_STAT_TOP] > 0
    specks = area < np.where(detached, 0.01, 0.0015) * p.size
    specks[0] = False
    p[specks[labels]] = 0.0
    count, labels, stats, _ = cv2.connectedComponentsWithStats((p <= 0.5).astype(np.uint8), connectivity=4)
    mean = np.bincount(labels.ravel(), p.ravel(), minlength=count) / np.maximum(
        np.bincount(labels.ravel()), 1
    )
    left, right = stats[:, cv2.CC_STAT_LEFT], stats[:, cv2.CC_STAT_LEFT] + stats[:, cv2.CC_STAT_WIDTH]
    below = stats[:, cv2.CC_STAT_TOP] + stats[:, cv2.CC_STAT_HEIGHT]
    area = stats[:, cv2.CC_STAT_AREA]
    island = (left > 0) & (right < p.shape[1]) & (below < p.shape[0]) & (area < 0.06 * p.size)
    island &= (area < 0.001 * p.size) | (mean > 0.12)
    island[0] = False
    p[island[labels]] = 1.0
    return p


def _without_specks(mask: BoolArray) -> BoolArray:
    """Removes sky components and holes in it below a thousandth of the picture."""
    mask = mask.copy()
    for value in (1, 0):
        _, labels, stats, _ = cv2.connectedComponentsWithStats(
            (mask == value).astype(np.uint8), connectivity=4
        )
        small = stats[:, cv2.CC_STAT_AREA] < 0.001 * mask.size
        small[0] = False
        mask[small[labels]] = not value
    return mask
