"""The sky is calm and open to the top: what lies behind crisp edges is not sky.

Clouds have soft edges; petals, hills in haze and white walls have crisp ones all around.  From the top and
the sides of the picture, through calm sky only, every part of the true sky can be reached.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray

LEAST_EDGE, EDGE_OVER_CALM = 1.8, 2.0  # grey levels of fine detail that make an edge crisp
PASS_PX, FRINGE_PX, DEEP_PX = 9, 11, 26  # of a picture 360 px tall: closed gaps, width of an edge, of a thing
LARGEST_WINDOW = 0.05  # of the picture
SURE_SKY = 0.72  # the network's mean belief in a part that may stay although it is cut off


def fine_detail(full: ByteArray, size: tuple[int, int]) -> FloatArray:
    """(height, width) local energy of detail finer than clouds have, in grey levels."""
    luma = cv2.cvtColor(full, cv2.COLOR_RGB2GRAY).astype(np.float32)
    unit = full.shape[0] / 720
    band = cv2.GaussianBlur(luma, (0, 0), 0.8 * unit) - cv2.GaussianBlur(luma, (0, 0), 1.8 * unit)
    power = cv2.resize(band * band, size, interpolation=cv2.INTER_AREA)
    return np.sqrt(np.maximum(cv2.GaussianBlur(power, (0, 0), 2.5 * unit), 0)).astype(np.float32)


def cut_off(sky: BoolArray, detail: FloatArray, belief: FloatArray) -> BoolArray:
    """The parts of a sky mask that no calm way joins to the border of the picture.

    Args:
        sky: (h, w).
        detail: (h, w) of `fine_detail`.
        belief: (h, w) the network's probability of sky.

    Returns:
        (h, w) True where the mask is to be withdrawn.
    """
    if not sky.any():
        return sky
    unit = sky.shape[0] / 360
    quiet = float(np.percentile(detail[sky], 30))
    calm = (sky & (detail < max(LEAST_EDGE, EDGE_OVER_CALM * quiet))).astype(np.uint8)
    calm = cv2.morphologyEx(calm, cv2.MORPH_OPEN, _disc(PASS_PX * unit / 2))
    _, labels = cv2.connectedComponents(calm, connectivity=4)
    reached = np.isin(labels, np.unique(labels[0][labels[0] > 0]))
    if not reached.any():  # windows
        return sky if sky.mean() < LARGEST_WINDOW else np.zeros_like(sky)
    open_sky = cv2.dilate(reached.astype(np.uint8), _disc(FRINGE_PX * unit)) > 0
    count, parts = cv2.connectedComponents((sky & ~open_sky).astype(np.uint8), connectivity=4)
    size = np.maximum(np.bincount(parts.ravel(), minlength=count), 1)
    away = cv2.distanceTransform((~reached).astype(np.uint8), cv2.DIST_L2, 5)
    reach = np.zeros(count, np.float32)
    np.maximum.at(reach, parts.ravel(), away.ravel())
    beside_ground = cv2.dilate((~sky).astype(np.uint8), _disc(2)) > 0
    closed = (np.bincount(parts.ravel(), belief.ravel(), minlength=count) / size < SURE_SKY) & (
        reach > DEEP_PX * unit
    )
    closed &= np.bincount(parts[beside_ground], minlength=count) > 0  # birds stay in the sky
    closed[0] = False
    withdrawn = closed[parts]
    # the fringe of the open part does not reach over the edge that closes the other
    beside = cv2.dilate(withdrawn.astype(np.uint8), _disc(FRINGE_PX * unit)) > 0
    near = cv2.dilate(reached.astype(np.uint8), _disc(0.4 * FRINGE_PX * unit)) > 0
    return np.asarray(withdrawn | (sky & beside & ~near), bool)


def _disc(radius_px: float) -> ByteArray:
    side = 2 * max(round(radius_px), 1) + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)), np.uint8)
