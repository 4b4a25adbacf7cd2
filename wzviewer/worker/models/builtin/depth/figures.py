"""Small things that stand on the ground: people, posts, flowers in a meadow.

The network's map is too coarse for them: they get the slope of the ground that they cover, and seen from
aside they lie on it.  What is unlike all the ground around it, slim and upright stands where its foot is.

    picture -> distance of each colour from the colours around it -> pieces that stand out
            -> slim, upright, whole -> as far away as their feet
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray, IntArray

UNIT_HEIGHT = 360.0  # lengths below are for a picture of this height
AROUND_PX = 37  # side of the window, twice: its surroundings
SPREAD = (60.0, 9.0, 9.0)  # least variance of 8-bit Lab
ROUNDS, OUTLIER = 3, 2.4  # what is unlike the ground does not describe it
LEVELS = (2.0, 2.4, 2.8, 3.3)  # distances beyond which pieces are looked for: things that touch come apart
UNLIKE, SURE_SHARE = 3.0, 0.25  # how much of a figure is beyond a distance that is not by chance
HEAD, HEAD_SHARE, HEAD_WIDTH = 1.5, 0.25, 0.6  # what it carries may be less unlike; of its height and width
NECK_PX = 5  # between a head and its body
MOST_WIDTH = 0.8  # from its middle, of its usual width
LEAST_AREA, MOST_AREA = 40.0, 0.015  # px, share of the picture
LEAST_HEIGHT_PX = 14
TILT_DEG = 25.0  # from the vertical
SLIM, SOLID = (1.5, 4.5), 0.55  # ratio of axes, a stem is a part; share of its ellipse
FOOT_SHARE = 0.15  # of the height
ABOVE_PX, RISEN = 6, 0.25  # just above a figure, of its own rise: that much says that something stands there


def find_figures(image: ByteArray, hidden: BoolArray) -> IntArray:
    """Finds what stands out from all around it, slim and upright.

    Args:
        image: (h, w, 3) u8 RGB, a few hundred px high.
        hidden: (h, w) bool, the sky, which is no surrounding.

    Returns:
        (h, w) i32: 0 where there is none, else the number of the figure.
    """
    unlike = unlike_surroundings(image, hidden)
    unlike[hidden] = 0
    figures = np.zeros(hidden.shape, np.int32)
    for level in LEVELS:
        pieces, stats, standing = _standing_pieces(unlike, level)
        standing[np.unique(pieces[figures > 0])] = False
        for k in np.flatnonzero(standing):
            _draw(figures, int(figures.max()) + 1, pieces == k, stats[k], unlike > HEAD)
    return figures


def _standing_pieces(unlike: FloatArray, level: float) -> tuple[IntArray, IntArray, BoolArray]:
    """Pieces (h, w) of what is beyond a level, their boxes and areas (n, 5), and which of them stand (n,)."""
    unit = len(unlike) / UNIT_HEIGHT
    out = (unlike > level).astype(np.uint8)
    out = cv2.morphologyEx(out, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    out = cv2.morphologyEx(out, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3)))
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(out, connectivity=4)
    area = stats[:, cv2.CC_STAT_AREA]
    standing = _slim(pieces) & (stats[:, cv2.CC_STAT_HEIGHT] > LEAST_HEIGHT_PX * unit)
    standing &= (area > LEAST_AREA * unit**2) & (area < MOST_AREA * unlike.size)
    standing &= stats[:, 1] + stats[:, 3] < len(unlike) - 2  # whole, not cut off by the frame
    standing &= np.bincount(pieces[unlike > UNLIKE], minlength=len(area)) > SURE_SHARE * area
    standing[0] = False
    return np.asarray(pieces, np.int32), np.asarray(stats, np.int32), standing


def unlike_surroundings(image: ByteArray, hidden: BoolArray) -> FloatArray:
    """Mahalanobis distance (h, w) of each colour from those around it, without outliers."""
    h, w = hidden.shape
    unit = h / UNIT_HEIGHT
    lab = cv2.cvtColor(cv2.GaussianBlur(image, (0, 0), unit), cv2.COLOR_RGB2LAB).astype(np.float32)
    size = (max(w // 2, 1), max(h // 2, 1))
    small, seen = (
        cv2.resize(v, size, interpolation=cv2.INTER_AREA) for v in (lab, 1 - hidden.astype(np.float32))
    )
    side = (round(AROUND_PX * unit) | 1, round(AROUND_PX * unit / 2) | 1)
    weight = seen
    for _ in range(ROUNDS):
        mass = _around(weight, side)[..., None] + np.float32(1e-4)
        mean = _around(small * weight[..., None], side) / mass
        square = _around(small * small * weight[..., None], side) / mass
        spread = np.maximum(square - mean * mean, 0) + np.array(SPREAD, np.float32)
        weight = seen / (1 + (((small - mean) ** 2 / spread).sum(2) / OUTLIER**2) ** 2)
    mean, spread = (cv2.resize(v, (w, h), interpolation=cv2.INTER_LINEAR) for v in (mean, spread))
    return np.sqrt(((lab - mean) ** 2 / spread).sum(2)).astype(np.float32)


def _around(value: FloatArray, side: tuple[int, int]) -> FloatArray:
    return np.asarray(cv2.blur(cv2.blur(value, side), side), np.float32)


def _slim(pieces: IntArray) -> BoolArray:
    """Tells which pieces (n,) of a label map are long, upright and filled."""
    y, x = np.nonzero(pieces)
    label, count = pieces[y, x], int(pieces.max()) + 1
    area = np.maximum(np.bincount(label, minlength=count), 1)
    dx, dy = (v - (np.bincount(label, v, minlength=count) / area)[label] for v in (x, y))
    xx, yy, xy = (np.bincount(label, v, minlength=count) / area for v in (dx * dx, dy * dy, dx * dy))
    xx, yy = xx + 1 / 12, yy + 1 / 12
    root = np.sqrt((xx - yy) ** 2 + 4 * xy * xy)
    long, short = (xx + yy + root) / 2, np.maximum((xx + yy - root) / 2, 1 / 12)
    tilt = np.degrees(0.5 * np.arctan2(2 * xy, yy - xx))
    filled = area / (4 * np.pi * np.sqrt(long * short))
    return np.asarray(
        (np.abs(tilt) < TILT_DEG)
        & (long > SLIM[0] ** 2 * short)
        & (long < SLIM[1] ** 2 * short)
        & (filled > SOLID)
    )


def _draw(figures: IntArray, number: int, body: BoolArray, box: IntArray, unlike: BoolArray) -> None:
    """Draws one figure (h, w) with what touches it from above, and without what sticks out far."""
    left, top, width, height = (int(v) for v in box[:4])
    above = min(round(HEAD_SHARE * height), top)
    here = np.s_[top - above : top + height, left : left + width]
    usual = float(np.median(body[here][above:].sum(1)))
    middle = float(np.median(np.nonzero(body[here])[1]))
    candidate = body[here] & (np.abs(np.arange(width) - middle) <= MOST_WIDTH * usual)
    head = unlike[here][:above] & (np.abs(np.arange(width) - middle) <= HEAD_WIDTH * usual)
    candidate[:above] |= head
    neck = candidate[: above + NECK_PX].astype(np.uint8)
    candidate[: above + NECK_PX] = cv2.morphologyEx(neck, cv2.MORPH_CLOSE, np.ones((NECK_PX,) * 2, np.uint8))
    _, labels = cv2.connectedComponents(candidate.astype(np.uint8), connectivity=4)
    largest = int(np.argmax(np.bincount(labels[candidate], minlength=1))) if candidate.any() else -1
    figures[here][labels == largest] = number


def stand_figures(d: FloatArray, figures: IntArray, lying: FloatArray | None = None) -> FloatArray:
    """Lays every figure as far away as its foot; never farther than it is.

    A figure that goes on above in something that stands is a part of that: a stem below its flower.

    Args:
        d: (h, w) disparity.
        figures: (h, w) of `find_figures`.
        lying: (h, w) disparity before anything was made to stand, or None.
    """
    result, lying = d.copy(), d if lying is None else lying
    for number in range(1, int(figures.max()) + 1):
        rows = np.flatnonzero((figures == number).any(1))
        if not len(rows):
            continue
        part = np.s_[rows[0] : rows[-1] + 1]
        where = figures[part] == number
        foot = where.copy()
        foot[: round((1 - FOOT_SHARE) * len(where))] = False
        near = float(np.median(d[part][foot]))
        top = np.flatnonzero(where[0])
        above = np.s_[max(rows[0] - ABOVE_PX, 0) : rows[0] + 1, top[len(top) // 2]]
        if np.mean(d[above] - lying[above]) < RISEN * (near - float(np.mean(lying[above]))):
            result[part][where] = np.maximum(d[part][where], near)
    return result
