"""Which surface a body lies on where the depth steps: the front one, with room, near where it is wanted.

The middle of a view is often on or beside the edge of a petal.  A plane through both sides of the edge
would lead from the petal into the hill behind it, and the petal would hide half of what lies on that hill.
A surface is what hangs together at a distance from every step: a narrow bridge joins nothing.  Heights are
logarithms of distance times the focal length: a pixel of height is a pixel of the picture at any distance.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects.placement import Support

_THUMB_PX = 136
_STEP = 4.5  # px of height a px: steeper is no surface, it parts two
_STEEP = 3.0  # px of height a px: steeper is no place to lie on, once a place has to be looked for
_JUMP = 0.08  # of the body's width, within three pixels of the thumbnail: less is roughness
_BAND = 0.4  # of the body's width: what is steep for longer is a slope
_REACH = 0.18  # of the view's width: farther is not where the user looks
_AROUND = 0.28  # of the body's width: its trunk, to each side
_WELL = 0.20  # of the body's width to the edge: the trunk is on it, legs may hang over
_ROOM = (0.13, 0.07)  # what will do
_FRONT = 0.20  # of the body's width: what is farther off is behind
_BEHIND, _APART = 0.6, 1.0  # of the body's width: behind without doubt; past a sharp edge
_SPECK = 0.05  # of the body's width: no surface is so small
_HOLD = 0.9  # of the body's width: its own surface is what hangs together with its middle in there


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The surfaces of a view, of a thumbnail (h, w), as they are around one pixel.

    Attributes:
        height: (h, w) float32 picture px, + = farther.
        clear: (h, w) float32, how far the next step, unknown place or sky is, px of the view.
        away: (h, w) float32, how far the pixel is, px of the view.
        pitch: px of the view in one of the thumbnail.
    """

    height: FloatArray
    clear: FloatArray
    away: FloatArray
    pitch: float

    @classmethod
    def of(
        cls, support: Support, centre: tuple[float, float], width_px: float, steep: float = _STEP
    ) -> "Surfaces":
        """Parts a view where it is steep, for a body of a width at a pixel (x, y)."""
        h, w = support.relief.shape
        pitch = max(w / _THUMB_PX, 1.0)
        size = (max(round(w / pitch), 4), max(round(h / pitch), 4))
        height = cv2.resize(heights(support), size, interpolation=cv2.INTER_NEAREST)
        free = np.isfinite(height)
        height = cv2.medianBlur(np.where(free, height, 0).astype(np.float32), 5)  # specks are noise
        window = np.ones((3, 3), np.uint8)
        rise = cv2.dilate(height, window) - cv2.erode(height, window)
        least = max(steep * 2 * pitch, _JUMP * width_px)
        k = max(round(_BAND * width_px / pitch), 3) | 1
        slope = cv2.morphologyEx(rise, cv2.MORPH_OPEN, np.ones((k, k), np.uint8))
        free &= (rise <= least) | (rise - slope <= 0.5 * least)
        if support.sky is not None:
            free &= cv2.resize(support.sky.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) == 0
        framed = cv2.copyMakeBorder(free.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)  # no edge there
        clear = cv2.distanceTransform(framed, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
        y, x = np.mgrid[: size[1], : size[0]].astype(np.float32)
        away = np.hypot((x + 0.5) * pitch - centre[0], (y + 0.5) * pitch - centre[1])
        return cls(height, np.asarray(clear * pitch, np.float32), away.astype(np.float32), pitch)

    def is_whole(self, radius_px: float) -> bool:
        """Tells whether there is no step around the pixel."""
        return bool(self.clear[self.away <= max(radius_px, self.pitch)].min(initial=np.inf) > 0)

    def parts(self, room_px: float, reach_px: float) -> list[BoolArray]:
        """Returns (h, w) of each surface, where a body has room on it and within reach."""
        roomy = (self.clear >= max(room_px, 0.5 * self.pitch)) & (self.away <= reach_px)
        count, label = cv2.connectedComponents(roomy.astype(np.uint8), connectivity=4)
        return [np.asarray(label == k) for k in range(1, count)]

    def nearest(self, part: BoolArray) -> tuple[int, int]:
        """Returns the (row, column) of a part that is the closest to the pixel."""
        row, column = np.unravel_index(int(np.argmin(np.where(part, self.away, np.inf))), part.shape)
        return int(row), int(column)


def heights(support: Support) -> FloatArray:
    """Returns (h, w) float32 log distance in px: a slope of 1 is one of 45 degrees at any distance."""
    with np.errstate(invalid="ignore"):
        distance = np.maximum(1.0 + support.relief / support.focal_px, 1e-3)
    return (support.focal_px * np.log(distance)).astype(np.float32)


def on_front(support: Support, centre: tuple[float, float], width_px: float) -> tuple[float, float]:
    """Returns where a body goes that was wanted at a pixel: there, or beside the edge it would lie across.

    The front surface comes first; what is behind it, away from the edge, if the front is too narrow; and
    the pixel itself if there is no place close by.

    Args:
        support: relief of the view.
        centre: (x, y) px, the middle of the body.
        width_px: of the body.
    """
    if Surfaces.of(support, centre, width_px).is_whole(_AROUND * width_px):
        return centre
    surfaces = Surfaces.of(support, centre, width_px, _STEEP)
    for room in _ROOM:
        parts = surfaces.parts(room * width_px, _REACH * support.relief.shape[1])
        if not parts:
            continue
        tops = [float(surfaces.height[surfaces.nearest(part)]) for part in parts]
        front = [part for part, top in zip(parts, tops, strict=True) if top <= min(tops) + _FRONT * width_px]
        short = np.maximum(_WELL * width_px - surfaces.clear, 0)
        cost = np.where(np.any(front, axis=0), surfaces.away + 1.5 * short, np.inf)
        y, x = np.unravel_index(int(np.argmin(cost)), cost.shape)
        if surfaces.away[y, x] <= surfaces.pitch:
            return centre
        return float((x + 0.5) * surfaces.pitch), float((y + 0.5) * surfaces.pitch)
    return centre


def beyond(support: Support, centre: tuple[float, float], width_px: float) -> FloatArray:
    """Returns (h, w) 0..1 how much another surface lies behind the one at a pixel, past a step.

    Soft where the depth falls softly: the edge of what curls away is nowhere, and a sharp end of a shadow
    would draw one.

    Args:
        support: relief of the view.
        centre: (x, y) px, on the surface that the body lies on.
        width_px: of the body.
    """
    h, w = support.relief.shape
    surfaces = Surfaces.of(support, centre, width_px)
    parts = surfaces.parts(_ROOM[-1] * width_px, _HOLD * width_px)
    if surfaces.is_whole(_HOLD * width_px) or not parts:
        return np.zeros((h, w), np.float32)
    own = min(parts, key=lambda part: float(surfaces.away[surfaces.nearest(part)]))
    k = 2 * round(_ROOM[-1] * width_px / surfaces.pitch) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (k, k))
    own = (cv2.dilate(own.astype(np.uint8), disc) > 0) & (surfaces.clear > 0)
    reached = cv2.distanceTransformWithLabels(
        (~own).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )[1]
    edge = np.zeros(int(reached.max()) + 1, np.float32)
    edge[reached[own]] = surfaces.height[own]
    # At full size, so that a sharp edge is met to the pixel.
    level = cv2.resize(edge[reached], (w, h), interpolation=cv2.INTER_LINEAR)
    other = cv2.resize((~own).astype(np.uint8), (w, h), interpolation=cv2.INTER_NEAREST) > 0
    depth = np.nan_to_num((heights(support) - level) / np.float32(width_px))
    share = np.where(other, np.clip((depth - _FRONT) / (_BEHIND - _FRONT), 0, 1), 0).astype(np.float32)
    k = round(_SPECK * width_px) | 1
    share = cv2.morphologyEx(share, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (k, k)))
    soft = cv2.GaussianBlur(share, (0, 0), max(0.3 * _SPECK * width_px, 0.6))
    return np.where(other & (depth > _APART), share, soft).astype(np.float32)
