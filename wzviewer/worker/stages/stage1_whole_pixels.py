"""O on the parent's own pixels: what a zoom shows, shrunk, shall be what was there.

::

    parent's pixels   |   |   |   |   |   |        the grid covers the view with whole ones;
    the view             [           ]             what is made of it is cut to the view in the end
    the grid          [               ]

A view that begins within a pixel of the parent would see two halves of its pixels mixed, by half a pixel a
blur of their contours: measured, a village's first zoom, begun at .6 of a pixel, was 33 dB from its parent.
Only a zoom has the parent's pixels; from aside there are none to keep.
"""

import math

import cv2
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import ByteArray, FloatArray

WHOLE_PX = 1e-3  # this close to a whole pixel it is one
HALF_STEP = np.float32(0.5 / 255)  # 8 bits tell no more


def is_zoom(camera: Camera, parent: Camera) -> bool:
    """Whether a camera sees a part of what another sees, from the same place, straight and evenly."""
    even = math.isclose(camera.fx * parent.fy, camera.fy * parent.fx, rel_tol=1e-6)
    return even and np.allclose(camera.camera_from_world, parent.camera_from_world, rtol=0, atol=1e-12)


def whole_pixels(camera: Camera, parent: Camera) -> tuple[Camera, tuple[int, int, int, int]]:
    """Returns the camera that sees all of the parent's pixels that a zoomed camera sees a part of.

    Args:
        camera: of a zoom.
        parent: its parent's.

    Returns:
        The camera, at most a pixel of the parent larger each way, to half a pixel of its own; and its
        ``(left, top, columns, rows)`` among the parent's pixels, which may lie outside its image.
    """
    x = _span(camera.cx, camera.width, parent.cx, parent.fx / camera.fx)
    y = _span(camera.cy, camera.height, parent.cy, parent.fy / camera.fy)
    centre = (camera.cx + x[2], camera.cy + y[2])
    grid = Camera(camera.camera_from_world, camera.fx, camera.fy, *centre, x[3], y[3])
    return grid, (x[0], y[0], x[1], y[1])


def _span(centre: float, size: int, parent_centre: float, step: float) -> tuple[int, int, int, int]:
    """First pixel of the parent and how many, the camera's own pixels before the view, and in all."""
    start = parent_centre - step * centre
    first, last = math.floor(start + WHOLE_PX), math.ceil(start + step * size - WHOLE_PX)
    before = max(round((start - first) / step), 0)
    return first, last - first, before, max(round((last - first) / step), before + size)


def on_whole_pixels(image: ByteArray, pixels: tuple[int, int, int, int], rendered: FloatArray) -> FloatArray:
    """Returns what was rendered of the parent's pixels, as its image has them, to a step of its 8 bits.

    Args:
        image: ``(h, w, 3)`` of the parent.
        pixels: ``(left, top, columns, rows)`` of `whole_pixels`.
        rendered: ``(rows, columns, 3)`` in 0..1; it is smoother than 8 bits, and it has what lies outside.
    """
    left, top, columns, rows = pixels
    height, width = image.shape[:2]
    x0, x1, y0, y1 = max(left, 0), min(left + columns, width), max(top, 0), min(top + rows, height)
    if x1 <= x0 or y1 <= y0:
        return rendered
    result = rendered.copy()
    known = image[y0:y1, x0:x1].astype(np.float32) / np.float32(255)
    inner = result[y0 - top : y1 - top, x0 - left : x1 - left]
    inner[:] = np.clip(inner, known - HALF_STEP, known + HALF_STEP)
    return result


def cut(plane: np.ndarray, grid: Camera, camera: Camera) -> np.ndarray:
    """Returns the part of a grid's plane, ``(H, W)`` or ``(H, W, c)``, that the view shows."""
    left, top = round(grid.cx - camera.cx), round(grid.cy - camera.cy)
    return np.ascontiguousarray(plane[top : top + camera.height, left : left + camera.width])


def spread_over(plane: FloatArray, grid: Camera, camera: Camera, width: int, height: int) -> FloatArray:
    """Returns a plane of the view, ``(h, w)``, resampled for ``width`` x ``height`` pixels of the grid."""
    rows, columns = plane.shape[:2]
    if grid is camera:
        return cv2.resize(plane, (width, height), interpolation=cv2.INTER_LINEAR)
    x, y = (grid.width / width) * columns / camera.width, (grid.height / height) * rows / camera.height
    left = -(grid.cx - camera.cx) * columns / camera.width
    top = -(grid.cy - camera.cy) * rows / camera.height
    plane_from_grid = np.array([[x, 0.0, left + 0.5 * x - 0.5], [0.0, y, top + 0.5 * y - 0.5]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(
        plane, plane_from_grid, (width, height), flags=flags, borderMode=cv2.BORDER_REPLICATE
    )
