"""The sky's outline at full size: thin things that stick out into it are given back to what they grow from.

    mask -> local colour of the sure sky -> unlike it, thin, and grown from the ground: ground
                                         -> like it, at the very border: sky
         -> every colour of the sure sky -> found in it and hardly elsewhere, beside it: sky

A mask that was found at half size loses petal tips, twigs and antennas; left in the sky they stay behind
when the camera moves.  A bright cloud between petals that counts as ground moves along with them.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray, IntArray

UNIT_HEIGHT = 720.0  # the lengths below are for a picture of this height
SURE_PX, REACH_PX, THIN_PX, SKIRT_PX, FRINGE_PX, HALO_PX = 10, 60, 24, 4, 40, 4
SPREAD = (9.0, 5.0, 5.0)  # of the sky's own colour, 8-bit Lab, at the least
UNLIKE, LIKE, OUTLIER, BLURRED = 3.2, 1.6, 2.5, 2.3  # Mahalanobis distances
CLEARLY = 1.5
EDGE_PX, CALM_SPREAD = 6, (2.5, 2.0, 2.0)  # the same where the sky itself is even
APART, ADDED_APART = 4.0, 2.0  # distances from that; of what is sky by its colour alone
SAME, ALLOWED = 2.0, 0.2  # distance and belief with which the sky spreads
SHRINK = 4  # the colour model is smooth
CLOUD_ROUNDS, CLOUD_STEP_PX = 4, 24  # how far the sky spreads over colours that are its own
CLOUD_ODDS, CLOUD_SHARE = 8.0, 1e-4  # of a colour: sky to ground, and the least of all the sky
BINS = (16, 64, 64)  # of L, a, b


def regrow(mask: BoolArray, image: ByteArray) -> BoolArray:
    """Corrects a sky mask along its border.

    Args:
        mask: (h, w) True where sky.
        image: (h, w, 3) u8 RGB.

    Returns:
        (h, w) mask without the thin things that stand out from the sky around them and touch the ground.
    """
    if not mask.any() or mask.all():
        return mask
    unit = mask.shape[0] / UNIT_HEIGHT
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB).astype(np.float32)
    distance = unlike_sky(lab, mask, unit)
    grown = _grown(mask, mask & (distance > UNLIKE), unit)
    near = _distance_to(~mask | grown) <= HALO_PX * unit
    grown |= _joined(
        mask & near & (distance > BLURRED), ~mask | grown
    )  # the blurred edge stays with its thing
    mask = mask & ~grown
    ground = unlike_sky(lab, ~mask, unit)
    like = ~mask & ~grown & (distance < LIKE) & (ground > distance)
    away = _distance_to(mask)
    skirt = like & ((away <= SKIRT_PX * unit) | ((away <= FRINGE_PX * unit) & (ground > distance + CLEARLY)))
    calm = mask
    mask = with_clouds(np.asarray(mask | _joined(skirt, mask), bool), image)
    return mask & ~_fringe(lab, mask, unit, mask & ~calm)


def _fringe(lab: FloatArray, mask: BoolArray, unit: float, added: BoolArray) -> BoolArray:
    """What stands out from a calm sky beside the ground: a sunlit edge in haze stayed behind as a line."""
    sure = _eroded(mask, EDGE_PX * unit)
    if not sure.any():
        return sure
    apart = _distance(lab, sure, 2 * EDGE_PX * unit, CALM_SPREAD) > np.where(added, ADDED_APART, APART)
    return _joined(mask & apart & (_distance_to(~mask) <= EDGE_PX * unit), ~mask)


def with_clouds(mask: BoolArray, image: ByteArray) -> BoolArray:
    """Adds what lies beside a sky and has a colour that is found in the sky, and hardly on the ground.

    A white cloud low beside a flower is unlike the blue around it, but not unlike the sky as a whole.  Where
    the ground has the same colour (a white house, snow) nothing is added.

    Args:
        mask: (h, w) True where sky.
        image: (h, w, 3) u8 RGB.
    """
    unit = mask.shape[0] / UNIT_HEIGHT
    sure = _eroded(mask, SURE_PX * unit)
    if not sure.any():
        return mask
    bins = _color_bins(image)
    found = _shares(bins, sure)
    for _ in range(CLOUD_ROUNDS):
        away = _distance_to(mask)
        ground = away > CLOUD_STEP_PX * unit
        if not ground.any():
            break
        own = (found > CLOUD_SHARE) & (found > CLOUD_ODDS * _shares(bins, ground))
        added = _joined(own[bins] & ~mask & ~ground, mask)
        if not added.any():
            break
        mask = mask | added
    return mask


def _color_bins(image: ByteArray) -> IntArray:
    """(h, w) number of the bin of Lab that each pixel falls into."""
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB)
    light, a, b = (lab[..., k].astype(np.int32) * BINS[k] // 256 for k in range(3))
    return np.asarray((light * BINS[1] + a) * BINS[2] + b, np.int32)


def _shares(bins: IntArray, mask: BoolArray) -> FloatArray:
    """Share of the masked pixels in each bin, blurred by one bin."""
    count = np.bincount(bins[mask], minlength=int(np.prod(BINS))).reshape(BINS).astype(np.float32)
    for k in range(3):
        before, after = (np.roll(count, step, k) for step in (1, -1))
        count = 0.25 * before + 0.5 * count + 0.25 * after
    return np.asarray(count.ravel() / max(int(np.count_nonzero(mask)), 1), np.float32)


def spread(sky: BoolArray, image: ByteArray, belief: FloatArray) -> BoolArray:
    """Extends a sky mask over what has its colour and is not denied by the network.

    Args:
        sky: (h, w).
        image: (h, w, 3) u8 RGB.
        belief: (h, w) the network's probability of sky.
    """
    if not sky.any() or sky.all():
        return sky
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB).astype(np.float32)
    same = unlike_sky(lab, sky, sky.shape[0] / UNIT_HEIGHT) < SAME
    return np.asarray(sky | _joined(same & (belief > ALLOWED) & ~sky, sky), bool)


def unlike_sky(lab: FloatArray, mask: BoolArray, unit: float) -> FloatArray:
    """How far each pixel's colour is from the masked colours around it.

    Args:
        lab: (h, w, 3) 8-bit Lab as floats.
        mask: (h, w).
        unit: the picture's height over `UNIT_HEIGHT`.

    Returns:
        (h, w) Mahalanobis distance with diagonal spread; large where nothing of the mask is near.
    """
    sure = _eroded(mask, SURE_PX * unit)
    sure = sure if sure.mean() > 0.2 * mask.mean() else mask
    wide = _distance(lab[::SHRINK, ::SHRINK], sure[::SHRINK, ::SHRINK], 66 * unit / SHRINK)
    wide = cv2.resize(wide, mask.shape[::-1], interpolation=cv2.INTER_NEAREST)
    settled = sure & (wide < OUTLIER)  # what was lost to the mask must not colour it
    return _distance(lab, settled if settled.any() else sure, 22 * unit)


def _distance(
    lab: FloatArray, sure: BoolArray, sigma_px: float, least: tuple[float, float, float] = SPREAD
) -> FloatArray:
    """Mahalanobis distance to the sure colours, weighted by a Gaussian of `sigma_px`."""
    h, w = sure.shape
    size = (max(w // SHRINK, 1), max(h // SHRINK, 1))
    weight = cv2.resize(sure.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    small = cv2.resize(lab * sure[..., None], size, interpolation=cv2.INTER_AREA)
    power = cv2.resize(lab * lab * sure[..., None], size, interpolation=cv2.INTER_AREA)
    mass, first, second = (_wide(m, sigma_px / SHRINK) for m in (weight, small, power))
    mean = first / mass[..., None]
    spread = np.maximum(second / mass[..., None] - mean * mean, 0) + np.square(np.array(least, np.float32))
    mean, spread = (cv2.resize(m, (w, h), interpolation=cv2.INTER_LINEAR) for m in (mean, spread))
    square = (lab - mean) ** 2 / spread
    return np.sqrt(square[..., 0] + square[..., 1] + square[..., 2]).astype(np.float32)


def _wide(v: FloatArray, sigma: float) -> FloatArray:
    """A Gaussian with a faint tail of five times its width, so that it reaches everywhere."""
    tail = cv2.blur(v, (int(10 * sigma) | 1, int(10 * sigma) | 1))
    return np.asarray(cv2.GaussianBlur(v, (0, 0), sigma) + 0.02 * tail + 1e-6, np.float32)


def _grown(mask: BoolArray, unlike: BoolArray, unit: float) -> BoolArray:
    """Of what is unlike the sky: thin components that touch the ground and do not reach far from it."""
    near = _distance_to(~mask) <= REACH_PX * unit
    candidate = (unlike & near).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(candidate, connectivity=8)
    touching = labels[(_distance_to(~mask) <= 2.5) & (labels > 0)]
    thick = _eroded(candidate > 0, THIN_PX * unit / 2)
    area = stats[:, cv2.CC_STAT_AREA]
    keep = np.bincount(touching, minlength=count) > 0
    keep &= np.bincount(labels[thick], minlength=count) < 0.04 * area
    keep &= area >= 6
    keep[0] = False
    return np.asarray(keep[labels], bool)


def _joined(part: BoolArray, body: BoolArray) -> BoolArray:
    """The components of `part` that touch `body`."""
    count, labels = cv2.connectedComponents(part.astype(np.uint8), connectivity=4)
    keep = np.bincount(labels[(_distance_to(body) <= 1.5) & part], minlength=count) > 0
    return np.asarray(keep[labels] & part, bool)


def _eroded(mask: BoolArray, radius_px: float) -> BoolArray:
    padded = np.pad(mask, 1, mode="edge").astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] > radius_px, bool)


def _distance_to(mask: BoolArray) -> FloatArray:
    """(h, w) px to the nearest pixel of the mask."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
