"""Looking behind the picture: what is drawn, and false colours for levels, depth and coverage."""

import colorsys
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from wzviewer.core.reference import Blend
from wzviewer.core.types import ByteArray, DoubleArray, FloatArray, IntArray

Mode = Literal["picture", "levels", "depth", "coverage"]
MODES: tuple[tuple[Mode, str], ...] = (
    ("picture", "Picture"),
    ("levels", "Levels"),
    ("depth", "Depth"),
    ("coverage", "Coverage"),
)
MEANINGS: dict[Mode, str] = {
    "picture": "",
    "levels": "A colour for each.",
    "depth": "Near is bright.",
    "coverage": "Pink is a hole.",
}
# From near to far, and from nothing to all; even steps of lightness.
RAMP = np.array([(253, 231, 150), (240, 150, 90), (190, 80, 110), (110, 55, 130), (35, 30, 75)], np.float64)
HOLE = np.array((255, 60, 160), np.float64)
FULL = np.array((70, 84, 108), np.float64)
CLOSED = 0.9  # see `RenderSettings.closed_coverage`
TINT = 0.6  # of a level's colour over the picture's own brightness
GOLDEN = 0.381966  # of the circle of hues, so that neighbours differ most
FIRST_HUE = 0.09
OUTLIERS = 2.0  # percent at either end of the depths


@dataclass(frozen=True)
class Look:
    """How the scene is drawn.

    Attributes:
        mode: the picture, or false colours.
        modulation: whether levels hand over by Eq. 3; off draws all at full weight.
        blend: exact partition, or Eq. 2 of the paper.
        merged: whether surfels below the pixel's size are merged.
        skips_faint: whether surfels too small to see are left out.
    """

    mode: Mode = "picture"
    modulation: bool = True
    blend: Blend = "transmittance"
    merged: bool = True
    skips_faint: bool = False


class Readable(Protocol):
    """A frame that can be read back; `gl.frame.Frame`."""

    def read_color8(self) -> ByteArray:
        """Colour, (h, w, 3) uint8."""
        ...

    def read_depth(self) -> DoubleArray:
        """Median depth, (h, w); nan where undefined."""
        ...

    def read_level(self) -> IntArray:
        """Level of the median surfel, (h, w); -1 where undefined."""
        ...

    def read_coverage(self) -> FloatArray:
        """1 - transmittance, (h, w)."""
        ...


def false_colors(frame: Readable, mode: Mode) -> ByteArray:
    """Returns a frame in the colours of a mode, (h, w, 3) uint8."""
    if mode == "levels":
        return tinted(frame.read_color8(), frame.read_level())
    if mode == "depth":
        return depth_colors(frame.read_depth())
    if mode == "coverage":
        return coverage_colors(frame.read_coverage())
    return frame.read_color8()


def level_color(index: int) -> tuple[float, float, float]:
    """Returns the colour of a level, 0 to 1."""
    return colorsys.hsv_to_rgb((FIRST_HUE + GOLDEN * index) % 1.0, 0.72, 0.95)


def tinted(colors: ByteArray, levels: IntArray) -> ByteArray:
    """Returns a picture (h, w, 3) in which each pixel has the hue of its level (h, w); -1 is dark."""
    count = int(levels.max(initial=-1)) + 1
    palette = np.array([*(level_color(i) for i in range(count)), (0.0, 0.0, 0.0)]) * 255.0
    luma = colors.astype(np.float64) @ np.array((0.299, 0.587, 0.114))
    tint = palette[levels] * (0.35 + 0.65 * luma[..., None] / 255.0)
    mixed = TINT * tint + (1.0 - TINT) * luma[..., None]
    return np.rint(np.where(levels[..., None] < 0, 0.0, mixed)).astype(np.uint8)


def depth_colors(depth: DoubleArray) -> ByteArray:
    """Returns depths (h, w) from light (near) to dark (far); even in log depth, nan is black."""
    seen = np.isfinite(depth) & (depth > 0)
    if not seen.any():
        return np.zeros((*depth.shape, 3), np.uint8)
    log_depth = np.log(np.where(seen, depth, 1.0))
    near, far = np.percentile(log_depth[seen], (OUTLIERS, 100.0 - OUTLIERS))
    share = np.clip((log_depth - near) / max(far - near, 1e-12), 0.0, 1.0)
    return np.where(seen[..., None], ramp(share), 0).astype(np.uint8)


def coverage_colors(coverage: FloatArray) -> ByteArray:
    """Returns coverages (h, w) from bright (a hole) to dark (closed, as far as it is presented so)."""
    open_share = 1.0 - np.clip(coverage.astype(np.float64) / CLOSED, 0.0, 1.0)[..., None]
    return np.rint(FULL + (HOLE - FULL) * open_share**0.6).astype(np.uint8)


def ramp(share: DoubleArray) -> ByteArray:
    """Returns colours of shares in [0, 1], (..., 3) uint8."""
    at = share * (len(RAMP) - 1)
    low = np.clip(np.floor(at).astype(int), 0, len(RAMP) - 2)
    part = (at - low)[..., None]
    return np.rint(RAMP[low] * (1.0 - part) + RAMP[low + 1] * part).astype(np.uint8)
