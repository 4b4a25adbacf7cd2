"""Scale-aware opacity modulation, Eq. 1-3 of the paper, on a tree and without a seam.

A *pixel scale* is the world length that one pixel covers at a depth, ``d / sqrt(fx fy)`` (Eq. 1).
Every surfel remembers the pixel scale it was created at and is fully visible there; it fades
linearly in log scale towards the scales of its parent and its children (Eq. 3).

Beyond the paper, a child covers only its camera's image::

    m    1 inside the child's image, 0 at and beyond its border, smooth between; of the point alone
    t    log interpolation from the parent's pixel scale (0) to the child's (1)
    u    what a level may use: u = u_parent m t, 1 at the root
    w    weight = u * product over its children of (1 - m t); of overlapping siblings the newer first,
         but for plain detail, which stays behind finer ones (`scene.siblings_before`)

On a chain with m = 1 this is Eq. 3; on any tree the weights at a point sum to 1.  Scales decrease
down the tree, so t of a level above 0 means t = 1 for its ancestors: ``u`` needs one t, and the
product of the m along the ancestors is stored with the surfel (`Surfels.coverage`).

Where a level fades in it is seen below its own resolution.  Its footprints shrink as their number in a
pixel grows, so its optical depth there stays, but for the low-pass: that widens small footprints, at the
scale of a parent x8 coarser to five times their area, and a child would begin five times too fast.  With
the transmittance blend the exponent takes that back (`compensation`), relative to the level's own scale:
the optical depth is then t times what it is there, and the same for merged surfels.  The linear blend
leaves this out, as the paper does.

The GLSL twin is ``shaders/include/opacity.glsl``; ``tests/gl/test_opacity_parity.py`` compares them.
All scales here are log2 over the level's unit, so 8^12 stays far from the limits of float32.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import (
    COVERAGE_FEATHER,
    FEATHER_MIN_PX,
    LOW_PASS_PX2,
    PARENT_REACH_PX,
    SURFEL_SIGMA_PX,
)
from wzviewer.core.types import DoubleArray, FloatArray

LOG_SPAN_MIN = 0.05  # of a parent-child ramp, log2
EXTENSION_OCTAVES = 0.1  # of the ramp of a level that is as coarse as its parent
LARGE_CELL = 1e4  # log2 of one that is wider than any pixel
VARIANCE_PX2 = SURFEL_SIGMA_PX**2  # of a surfel at its native scale, before the low-pass


def opacity_weight(
    render: FloatArray, native: FloatArray, parent: FloatArray, child: FloatArray
) -> FloatArray:
    """Factor alpha that multiplies a surfel's opacity, Eq. 3 as printed (one parent, one child).

    Args:
        render: (n,) pixel scale at the current camera, world units per pixel.
        native: (n,) at the camera that created the surfel.
        parent: (n,) at the camera of the coarser level; inf when there is none.
        child: (n,) at the camera of the finer level; 0 when there is none.

    Returns:
        (n,) weight in [0, 1].

    Example:
        Half-way in log scale between two levels, both share the pixel equally (Prop. 1):

        >>> coarse, fine = np.float32([8e-3]), np.float32([1e-3])
        >>> between = np.sqrt(coarse * fine)
        >>> w_coarse = opacity_weight(between, coarse, np.float32([np.inf]), fine)
        >>> w_fine = opacity_weight(between, fine, coarse, np.float32([0.0]))
        >>> (w_coarse + w_fine).round(5).tolist(), w_fine.round(5).tolist()
        ([1.0], [0.5])
    """
    up = np.where(np.isinf(parent), np.float32(1.0), _ramp(parent, render, native))
    down = np.where(child <= 0.0, np.float32(1.0), np.float32(1.0) - _ramp(native, render, child))
    return np.clip(np.minimum(up, down), 0.0, 1.0).astype(np.float32)


def _ramp(upper: FloatArray, render: FloatArray, lower: FloatArray) -> FloatArray:
    tiny = np.float32(1e-37)
    top, here, low = (np.log(np.clip(x, tiny, np.float32(3e38))) for x in (upper, render, lower))
    return np.clip((top - here) / np.maximum(top - low, np.float32(1e-6)), 0.0, 1.0)


def edge_coverage(points_px: FloatArray, width: int, height: int, feather_px: float) -> FloatArray:
    """m: 1 well inside an image, smoothstep to 0 at its border, 0 outside and where undefined.

    Args:
        points_px: (n, 2) image positions, px; nan is outside.
        width: image width, px.
        height: image height, px.
        feather_px: width of the transition inside the border.

    Returns:
        (n,) float32 in [0, 1].
    """
    x, y = points_px[:, 0], points_px[:, 1]
    inside = np.minimum(np.minimum(x, width - x), np.minimum(y, height - y))
    s = np.clip(np.nan_to_num(inside, nan=-1.0) / np.float32(feather_px), 0.0, 1.0)
    return (s * s * (3.0 - 2.0 * s)).astype(np.float32)


def feather_px(camera: Camera) -> float:
    """Width of the transition inside a child's border, px of its camera.

    A pixel of the parent is eight wide here, and the parent fades by whole surfels: a transition narrower
    than a few of them leaks.  What is left of the parent inside the border reaches further in than the
    transition, and a very small image has to keep a middle of its own.
    """
    shorter = min(camera.width, camera.height)
    return max(COVERAGE_FEATHER * shorter, min(FEATHER_MIN_PX, 0.5 * shorter - PARENT_REACH_PX))


def ramp_start(parent: Camera, camera: Camera, frame: LevelFrame) -> Camera:
    """The camera whose pixel scale is the beginning of a level's ramp: its parent's, or a coarser one.

    An extension continues the picture at its parent's own scale, and has to be there at that scale: its
    ramp is a short one before it.

    Args:
        parent: camera of the parent.
        camera: camera of the level.
        frame: of the level.
    """
    octaves = np.log2(frame.unit_seen_by(parent)) - np.log2(frame.unit_seen_by(camera))
    if not octaves < EXTENSION_OCTAVES:  # nan: the anchor is behind a camera
        return parent
    factor = 2.0 ** (octaves - EXTENSION_OCTAVES)
    return parent.zoomed(parent.width / 2, parent.height / 2, factor)


@dataclass(frozen=True, eq=False)
class Cover:
    """A level that takes a share out of another one: a child, or a sibling that comes before an ancestor.

    Attributes:
        view: its camera, expanded about the covered level's anchor.
        parent_rows: (4,) ``(g, base)`` of its parent's camera about the same anchor.
        size_px: (width, height, feather) of its image.
    """

    view: AnchoredView
    parent_rows: DoubleArray
    size_px: tuple[float, float, float]

    @classmethod
    def expand(cls, camera: Camera, parent: Camera, frame: LevelFrame) -> "Cover":
        """Expands a covering camera and its parent's about a frame's anchor."""
        size_px = (float(camera.width), float(camera.height), feather_px(camera))
        return cls(AnchoredView.expand(camera, frame), AnchoredView.expand(parent, frame).rows[2], size_px)

    def texels(self) -> FloatArray:
        """Returns (5, 4) float32 for shaders and kernels: camera, parent, (w, h, feather, side)."""
        size = np.array([[*self.size_px, self.view.side]])
        return np.concatenate([self.view.rows, self.parent_rows[None], size]).astype(np.float32)

    def share(self, means: FloatArray, render: FloatArray) -> FloatArray:
        """M t at local points: (n, 3) and their log2 render scales (n,) -> (n,)."""
        width, height, feather = self.size_px
        m = edge_coverage(self.view.project(means), int(width), int(height), feather)
        top = scale_of_row(self.parent_rows, means)
        return m * log_ramp(top, render, self.view.log_scale(means))


@dataclass(frozen=True, eq=False)
class Modulation:
    """All that Eq. 3 needs for one level, in that level's frame.

    Attributes:
        parent_rows: (4,) ``(g, base)`` of the parent's camera, or None at the root.
        covers: children, and siblings that come before the level or an ancestor.
        cell_px: native pixels along a side of what one surfel stands for; more than 1 when merged, and less
            for a view that is asked at a finer scale than it has (`AnchoredView.finer`).
    """

    parent_rows: DoubleArray | None
    covers: tuple[Cover, ...]
    cell_px: float = 1.0

    def texels(self, compensated: bool = True) -> FloatArray:
        """Returns (2 + 5 covers, 4) float32: parent, (covers, has a parent, 1, cell), then the covers.

        Args:
            compensated: whether weights are multiplied by `compensation`; if not, the cell, log2, is so
                large that it is 1.
        """
        parent = np.zeros(4) if self.parent_rows is None else self.parent_rows
        cell = np.log2(self.cell_px) if compensated else LARGE_CELL
        counts = [len(self.covers), float(self.parent_rows is not None), 1.0, cell]
        head = np.array([parent, counts], np.float32)
        return np.concatenate([head, *(cover.texels() for cover in self.covers)])


def scale_of_row(row: DoubleArray, means: FloatArray) -> FloatArray:
    """log2 pixel scale at local points from a ``(g, base)`` row; (n,) float32."""
    D = np.float32(1.0) + means @ row[:3].astype(np.float32)
    return np.float32(row[3]) + np.log2(np.maximum(D, np.float32(1e-6)))


def log_ramp(top: FloatArray, here: FloatArray, low: FloatArray) -> FloatArray:
    """t: 0 at the parent's log scale (top), 1 at the child's (low); (n,) float32."""
    return np.clip((top - here) / np.maximum(top - low, np.float32(LOG_SPAN_MIN)), 0.0, 1.0)


def compensation(native: FloatArray, render: FloatArray, cell_px: float = 1.0) -> FloatArray:
    """By how much the low-pass widens a footprint at its native scale, over how much it does here.

    Args:
        native: (n,) log2 of s_native over the level's unit.
        render: (n,) log2 pixel scale at the rendering camera over the same.
        cell_px: native pixels along a side of what one surfel stands for.

    Returns:
        (n,) ``(v + lp) m^2 / (v m^2 + lp)`` with m the magnification, at most 1, v the variance of a
        surfel in native pixels and lp that of the low-pass.
    """
    octaves = np.minimum(native + np.float32(np.log2(cell_px)) - render, np.float32(0.0))
    area = np.exp2(np.float32(2.0) * octaves)
    v, low_pass = np.float32(VARIANCE_PX2), np.float32(LOW_PASS_PX2)
    return area * (v + low_pass) / (v * area + low_pass)


def weights(
    means: FloatArray,
    native_scales: FloatArray,
    coverage: FloatArray,
    view: AnchoredView,
    modulation: Modulation,
    compensated: bool = False,
) -> FloatArray:
    """Weight w of every surfel of a level (Eq. 3 with coverage).

    Args:
        means: (n, 3) local positions.
        native_scales: (n,) s_native over the level's unit.
        coverage: (n,) product of m over the level and its ancestors.
        view: the rendering camera about the level's anchor.
        modulation: the level's parent and covers.
        compensated: multiply by `compensation`: the exponents of the transmittance blend.

    Returns:
        (n,) float32 in [0, 1].
    """
    render = view.log_scale(means)
    w = coverage.astype(np.float32)
    if modulation.parent_rows is not None:
        top, native = scale_of_row(modulation.parent_rows, means), np.log2(native_scales)
        w = w * log_ramp(top, render, native)
        w = w * compensation(native, render, modulation.cell_px) if compensated else w
    for cover in modulation.covers:
        w = w * (np.float32(1.0) - cover.share(means, render))
    return np.clip(w, 0.0, 1.0).astype(np.float32)


def stored_coverage(means: FloatArray, frame: LevelFrame, cameras: Sequence[Camera]) -> FloatArray:
    """Product of m over a level and its ancestors (root excluded), at local points (n, 3) -> (n,)."""
    product = np.ones(len(means), np.float32)
    for camera in cameras:
        points_px = AnchoredView.expand(camera, frame).project(means)
        product *= edge_coverage(points_px, camera.width, camera.height, feather_px(camera))
    return product
