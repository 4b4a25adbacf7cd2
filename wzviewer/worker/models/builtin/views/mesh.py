"""Exact views of (image, relief) from cameras that orbit about the anchor: projection and z-buffer.

Positions are in native px relative to the anchor, so nothing here depends on the level: with
t = (anchor - principal point) / f, a pixel at distance d_px from the anchor and relief delta lies at
``((d_px (1 + delta / f) + t delta), delta)`` and a rotated point u' projects to
``anchor + (u'.xy - t u'.z) / (1 + u'.z / f)``.
"""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numba import njit, prange

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray

FAST = {"reassoc", "contract", "nsz", "arcp"}
BANDS = 4  # source strips with a z-buffer each; fixed, so the result does not depend on the threads
EMPTY = np.float32(3e38)
EDGE_SLACK = np.float32(-2e-3)  # float32 positions leave pin holes between triangles without it
NEAR_LIMIT = 0.02  # smallest depth relative to the anchor that is drawn


@dataclass(frozen=True)
class OrbitView:
    """A camera that orbits about the anchor of its level, in px and angles only.

    Attributes:
        rotation: (3, 3) float64, neighbour axes from source axes.
        anchor_px: (2,) float64, image centre, which keeps its place.
        tangent: (2,) float64, (anchor - principal point) / f.
        focal_px: f.
        shift_px: (2,) float64, added to the projected positions.
    """

    rotation: DoubleArray
    anchor_px: DoubleArray
    tangent: DoubleArray
    focal_px: float
    shift_px: DoubleArray = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def of(cls, camera: Camera, rotation: DoubleArray) -> Self:
        """Returns the view of ``camera`` after a rotation of the scene about its anchor."""
        anchor = np.array([camera.width / 2, camera.height / 2])
        tangent = (anchor - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
        return cls(rotation, anchor, tangent, camera.focal_px)

    def shifted(self, x_px: float, y_px: float) -> Self:
        """Returns the same view in an image with this much more on the left and at the top."""
        return replace(self, shift_px=np.array([x_px, y_px], np.float64))

    def parameters(self) -> DoubleArray:
        """Returns rotation, anchor, tangent, 1/f and the shifted anchor, (16,), for compiled code."""
        center = self.anchor_px + self.shift_px
        return np.concatenate(
            [self.rotation.ravel(), self.anchor_px, self.tangent, [1 / self.focal_px], center]
        )


def rotation_of(yaw_deg: float, pitch_deg: float) -> DoubleArray:
    """Returns the rotation (3, 3) of the scene for an orbit: yaw about y, then pitch about x."""
    yaw, pitch = np.deg2rad(yaw_deg), np.deg2rad(pitch_deg)
    about_y = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    about_x = np.array([[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]])
    return np.asarray(about_x @ about_y, np.float64)


@njit(cache=True, nogil=True, inline="always")
def _project(u: float, v: float, relief: float, view: DoubleArray) -> tuple[float, float, float]:
    """Projects one point at (u, v) px from the anchor; x = y = -1e9 behind the camera."""
    tx, ty, inverse_f = view[11], view[12], view[13]
    grow = 1.0 + relief * inverse_f
    x = u * grow + tx * relief
    y = v * grow + ty * relief
    z = view[6] * x + view[7] * y + view[8] * relief
    depth = 1.0 + z * inverse_f
    if depth < NEAR_LIMIT:
        return -1e9, -1e9, z
    rx = view[0] * x + view[1] * y + view[2] * relief
    ry = view[3] * x + view[4] * y + view[5] * relief
    return view[14] + (rx - tx * z) / depth, view[15] + (ry - ty * z) / depth, z


@njit(cache=True, nogil=True, parallel=True)
def project_grid(relief: FloatArray, offset: tuple[int, int], stride: int, view: DoubleArray) -> FloatArray:
    """Projects a grid of pixels with relief (h, w) into a view: x_px, y_px, relief there, (h, w, 3)."""
    height, width = relief.shape
    projected = np.empty((height, width, 3), np.float32)
    for i in prange(height):
        v = offset[1] + (i + 0.5) * stride - view[10]
        for j in range(width):
            u = offset[0] + (j + 0.5) * stride - view[9]
            x, y, z = _project(u, v, np.float64(relief[i, j]), view)
            projected[i, j, 0] = x
            projected[i, j, 1] = y
            projected[i, j, 2] = z
    return projected


@njit(cache=True, nogil=True, parallel=True)
def splat_depth(
    relief: FloatArray,
    mask: BoolArray,
    offset: tuple[int, int],
    views: DoubleArray,
    cell_px: float,
    depth: FloatArray,
) -> None:
    """Keeps the nearest relief of all masked pixels (h, w) in the cells (k, n, m) of k views."""
    for k in prange(views.shape[0]):
        for i in range(relief.shape[0]):
            v = offset[1] + i + 0.5 - views[k, 10]
            for j in range(relief.shape[1]):
                if not mask[i, j]:
                    continue
                x, y, z = _project(offset[0] + j + 0.5 - views[k, 9], v, np.float64(relief[i, j]), views[k])
                a = int(y / cell_px)
                b = int(x / cell_px)
                if x >= 0 and y >= 0 and a < depth.shape[1] and b < depth.shape[2] and z < depth[k, a, b]:
                    depth[k, a, b] = z


@njit(cache=True, nogil=True, parallel=True)
def visible_from(
    relief: FloatArray,
    mask: BoolArray,
    offset: tuple[int, int],
    views: DoubleArray,
    cell_px: float,
    depth: FloatArray,
    slack_px: float,
) -> BoolArray:
    """Finds the masked pixels (h, w) that are not hidden in the cells (k, n, m) of at least one view.

    Args:
        relief: (h, w) float32, native px.
        mask: (h, w) bool, pixels that exist.
        offset: image pixel of the grid's origin.
        views: (k, 16) float64 of `OrbitView.parameters`.
        cell_px: side of a cell.
        depth: (k, n, m) float32 of `splat_depth`.
        slack_px: relief by which a point may lie behind the nearest, plus 1 % of that.
    """
    visible = np.zeros(mask.shape, np.bool_)
    for i in prange(relief.shape[0]):
        for j in range(relief.shape[1]):
            if not mask[i, j]:
                continue
            for k in range(views.shape[0]):
                u = offset[0] + j + 0.5 - views[k, 9]
                x, y, z = _project(u, offset[1] + i + 0.5 - views[k, 10], np.float64(relief[i, j]), views[k])
                a = int(y / cell_px)
                b = int(x / cell_px)
                if x >= 0 and y >= 0 and a < depth.shape[1] and b < depth.shape[2]:
                    if z <= depth[k, a, b] + slack_px + 0.01 * abs(depth[k, a, b]):
                        visible[i, j] = True
                        break
    return visible


@njit(cache=True, nogil=True, parallel=True, fastmath=FAST)
def draw_grid(
    image: FloatArray,
    projected: FloatArray,
    solid: BoolArray,
    tear_px: float,
    color: FloatArray,
    depth: FloatArray,
) -> None:
    """Draws a textured grid into a picture with z-buffer, nearest wins.

    Args:
        image: (h, w, 3) float32.
        projected: (h, w, 3) float32 of `project_grid`.
        solid: (h, w) bool; quads need all four corners.
        tear_px: quads with a longer side in the view are not drawn.
        color: (H, W, 3) float32, updated.
        depth: (H, W) float32, updated; `EMPTY` where nothing is.
    """
    rows = image.shape[0] - 1
    colors = np.empty((BANDS, color.shape[0], color.shape[1], 3), np.float32)
    depths = np.full((BANDS, color.shape[0], color.shape[1]), EMPTY, np.float32)
    for band in prange(BANDS):
        for i in range(rows * band // BANDS, rows * (band + 1) // BANDS):
            for j in range(image.shape[1] - 1):
                if solid[i, j] and solid[i, j + 1] and solid[i + 1, j] and solid[i + 1, j + 1]:
                    if not _torn(projected, i, j, tear_px):
                        _draw_quad(image, projected, i, j, colors[band], depths[band])
    for y in prange(color.shape[0]):
        for x in range(color.shape[1]):
            for band in range(BANDS):
                if depths[band, y, x] < depth[y, x]:
                    depth[y, x] = depths[band, y, x]
                    for c in range(3):
                        color[y, x, c] = colors[band, y, x, c]


@njit(cache=True, nogil=True, fastmath=FAST)
def _torn(projected: FloatArray, i: int, j: int, tear_px: float) -> bool:
    """True if a quad is stretched over a depth step, or partly behind the camera."""
    for axis in range(2):
        a, b = projected[i, j, axis], projected[i, j + 1, axis]
        c, d = projected[i + 1, j, axis], projected[i + 1, j + 1, axis]
        if max(max(a, b), max(c, d)) - min(min(a, b), min(c, d)) > tear_px or a < -1e8:
            return True
    return False


@njit(cache=True, nogil=True, fastmath=FAST)
def _draw_quad(
    image: FloatArray, projected: FloatArray, i: int, j: int, color: FloatArray, depth: FloatArray
) -> None:
    """Draws the two triangles of a quad at every pixel centre that they hold."""
    for half in range(2):
        i1, j1 = (i, j + 1) if half == 0 else (i + 1, j + 1)
        i2, j2 = (i + 1, j + 1) if half == 0 else (i + 1, j)
        x0, y0 = projected[i, j, 0], projected[i, j, 1]
        x1, y1 = projected[i1, j1, 0], projected[i1, j1, 1]
        x2, y2 = projected[i2, j2, 0], projected[i2, j2, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area <= 0:
            continue  # seen from behind
        first_x = max(0, int(np.ceil(min(x0, min(x1, x2)) - 0.5)))
        last_x = min(depth.shape[1] - 1, int(np.floor(max(x0, max(x1, x2)) - 0.5)))
        first_y = max(0, int(np.ceil(min(y0, min(y1, y2)) - 0.5)))
        last_y = min(depth.shape[0] - 1, int(np.floor(max(y0, max(y1, y2)) - 0.5)))
        for y in range(first_y, last_y + 1):
            for x in range(first_x, last_x + 1):
                px = np.float32(x + 0.5)
                py = np.float32(y + 0.5)
                w1 = ((px - x0) * (y2 - y0) - (x2 - x0) * (py - y0)) / area
                w2 = ((x1 - x0) * (py - y0) - (px - x0) * (y1 - y0)) / area
                w0 = 1 - w1 - w2
                if min(w0, min(w1, w2)) < EDGE_SLACK:
                    continue
                z = w0 * projected[i, j, 2] + w1 * projected[i1, j1, 2] + w2 * projected[i2, j2, 2]
                if z < depth[y, x]:
                    depth[y, x] = z
                    for c in range(3):
                        color[y, x, c] = w0 * image[i, j, c] + w1 * image[i1, j1, c] + w2 * image[i2, j2, c]
