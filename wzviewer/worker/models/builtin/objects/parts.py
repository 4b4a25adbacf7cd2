"""A body taken apart into sheets of surfels: what is seen, what it hides of itself, and its flanks.

    picture = wings over limbs over trunk over what was there before
              each with its coverage: a mixed pixel is no surface of mixed colour
              each also where the one before hides it
    flanks    what none of them shows, from rays beside the view

A pixel that holds a hair and the ground behind it becomes two surfels; seen from aside they part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.placement import Plane

LEAST = 0.04  # coverage of a pixel, below which it holds nothing of a part
_SHEER = 0.7  # through what covers less, what is behind is seen well enough to be told
_GROWN = 3  # px that a soft outline reaches beyond what rays met


@dataclass(frozen=True, eq=False)
class Part:
    """Pixels of an object that become surfels, cut to where they are.

    Attributes:
        color: (h, w, 3) float32 sRGB, not premultiplied.
        alpha: (h, w) float32 coverage.
        relief: (h, w) float32 native px about the level's anchor; nan where there is nothing.
        offset_px: (x, y) image pixel of the first array element.
    """

    color: FloatArray
    alpha: FloatArray
    relief: FloatArray
    offset_px: tuple[int, int]

    def shifted(self, change: FloatArray) -> "Part":
        """Returns the part in a picture whose colours have changed by (h, w, 3)."""
        (x, y), (h, w) = self.offset_px, self.alpha.shape
        return replace(self, color=np.clip(self.color + change[y : y + h, x : x + w], 0, 1))


@dataclass(frozen=True, eq=False)
class Flanks:
    """Points of a body that its own view does not see.

    Attributes:
        corners: (3, n, 3) image x, image y and relief, px: of each point, and of it moved by either axis
            of its footprint.
        color: (n, 3) float32 sRGB.
        alpha: (n,) float32 coverage.
    """

    corners: DoubleArray
    color: FloatArray
    alpha: FloatArray

    def shifted(self, change: FloatArray) -> "Flanks":
        """Returns the flanks in a picture whose colours have changed by (h, w, 3)."""
        column, row = np.floor(self.corners[0, :, :2]).astype(np.int64).T
        return replace(self, color=np.clip(self.color + change[row, column], 0, 1))


@dataclass(frozen=True, eq=False)
class Depths:
    """From marched relief to that of the level: sheared onto the support, moved into contact.

    Attributes:
        lift: what is added, a plane of the image.
        at: relief about which distances are scaled.
        share: by how much.
        contact: (h, w) float32, what brought the body into contact.
    """

    lift: Plane
    at: float
    share: float
    contact: FloatArray

    def __call__(self, x: DoubleArray, y: DoubleArray, marched: DoubleArray | FloatArray) -> DoubleArray:
        """Returns the level's relief of points at image (x, y), px."""
        h, w = self.contact.shape
        rows, columns = (np.clip(np.floor(v), 0, n - 1).astype(np.int64) for v, n in ((y, h), (x, w)))
        moved = marched + self.lift(x, y) - self.at
        return np.asarray(self.at + self.share * moved + self.contact[rows, columns], np.float64)

    def of_image(self, marched: FloatArray) -> FloatArray:
        """Returns the level's relief of a marched one (h, w)."""
        y, x = np.mgrid[0 : marched.shape[0], 0 : marched.shape[1]]
        return self(x + 0.5, y + 0.5, marched).astype(np.float32)

    def in_contact(self, marched: FloatArray, settled: FloatArray, reach_px: float) -> "Depths":
        """Returns these depths, such that a marched relief (h, w) becomes the settled one where both are."""
        gap = settled - self.of_image(marched)
        known = np.isfinite(gap)
        if not known.any():
            return self
        weight = known.astype(np.float32)
        sigma = max(reach_px, 1.0)
        around = cv2.GaussianBlur(np.where(known, gap, 0).astype(np.float32), (0, 0), sigma)
        share = cv2.GaussianBlur(weight, (0, 0), sigma)
        middle = float(np.median(gap[known]))
        smooth = (around + 1e-4 * middle) / (share + 1e-4)
        moved = self.contact + np.where(known, gap, smooth)
        return Depths(self.lift, self.at, self.share, moved.astype(np.float32))


@dataclass(frozen=True, eq=False)
class Pane:
    """A part that is to be taken out of a picture.

    Attributes:
        picture: (h, w, 3) sRGB with it, and without what is in front of it.
        alpha: (h, w) its coverage.
        marched: (h, w) its relief in the object's own view; nan where there is nothing.
        is_sheer: whether what is behind it is seen through it well enough to be told.
    """

    picture: FloatArray
    alpha: FloatArray
    marched: FloatArray
    is_sheer: bool = False


def parts_of(panes: Sequence[Pane], under: FloatArray, depths: Depths) -> tuple[tuple[Part, ...], FloatArray]:
    """Returns parts and a ground (h, w, 3) that, over each other, are the picture of the last pane.

    The ground is `under`, but where a colour that no wing can have would be needed to show the picture.

    Args:
        panes: from behind to the front.
        under: (h, w, 3) sRGB without any of them.
        depths: from marched relief to the level's.
    """
    parts: tuple[Part, ...] = ()
    picture = panes[-1].picture
    for pane, below in zip(reversed(panes), [*(p.picture for p in reversed(panes[:-1])), under], strict=True):
        color = _uncovered(picture, below, pane.alpha)
        parts = (*_cropped(color, pane.alpha, depths.of_image(pane.marched)), *parts)
        seen = _uncovered(picture, color, 1 - pane.alpha)
        through = pane.alpha < (_SHEER if pane.is_sheer else LEAST)
        picture = np.where(through[..., None], seen, below)
    return parts, picture.astype(np.float32)


def _uncovered(picture: FloatArray, under: FloatArray, alpha: FloatArray) -> FloatArray:
    """Returns the colour (h, w, 3) that, over `under` with this coverage, is nearest to the picture."""
    share = np.maximum(alpha, LEAST)[..., None]
    return np.asarray(np.clip(under + (picture - under) / share, 0, 1), np.float32)


def _cropped(color: FloatArray, alpha: FloatArray, relief: FloatArray) -> tuple[Part, ...]:
    """Returns a part cut to the pixels it covers; none if there are none."""
    relief = _grown(relief)
    there = (alpha >= LEAST) & np.isfinite(relief)
    if not there.any():
        return ()
    rows, columns = np.flatnonzero(there.any(1)), np.flatnonzero(there.any(0))
    cut = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    kept = np.where(there, relief, np.float32(np.nan))
    color, alpha, relief = (np.ascontiguousarray(a[cut], np.float32) for a in (color, alpha, kept))
    return (Part(color, alpha, relief, (int(columns[0]), int(rows[0]))),)


def _grown(relief: FloatArray) -> FloatArray:
    """Continues a relief (h, w) beyond its outline, with the nearest of what is beside."""
    for _ in range(_GROWN):
        known = np.isfinite(relief)
        near = cv2.erode(np.where(known, relief, np.float32(1e30)), np.ones((3, 3), np.uint8))
        relief = np.where(known, relief, np.where(near < 1e29, near, np.float32(np.nan)))
    return np.asarray(relief, np.float32)


def solid(parts: tuple[Part, ...], shape: tuple[int, int], least: float) -> tuple[BoolArray, FloatArray]:
    """Returns where parts cover (h, w) by at least a share, and the nearest relief there; nan elsewhere."""
    nearest = np.full(shape, np.inf, np.float32)
    for part in parts:
        h, w = part.alpha.shape
        x, y = part.offset_px
        here = nearest[y : y + h, x : x + w]
        own = np.where(part.alpha >= least, part.relief, np.float32(np.inf))
        np.fmin(here, own, out=here)
    covered = np.isfinite(nearest)
    return covered, np.where(covered, nearest, np.float32(np.nan))
