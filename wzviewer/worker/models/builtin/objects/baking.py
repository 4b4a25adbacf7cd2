"""Outlines, veins and dots drawn once and baked as signed distances on [-1, 1]^2."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.interpolate import splev, splprep

from wzviewer.core.types import DoubleArray, FloatArray

SIZE = 384  # texels a side: a wing of half a body length has texels of .0015
_FINE = 4  # masks are drawn finer, so that distances are exact to an eighth of a texel; 2 costs a quarter

Points = list[tuple[float, float]]


@dataclass(frozen=True)
class Window:
    """Which part of the drawing the texture shows: its centre and half side in drawing units."""

    centre: tuple[float, float]
    half: float

    def uv(self, points: Points | DoubleArray) -> DoubleArray:
        """Returns texture coordinates in [-1, 1]."""
        return (np.asarray(points, np.float64) - self.centre) / self.half


def closed_curve(points: Points, samples: int = 400) -> DoubleArray:
    """Returns (samples, 2): a smooth closed curve through the points."""
    ring = np.asarray([*points, points[0]], np.float64).T
    spline, _ = splprep(ring, s=0, per=True)
    return np.stack(splev(np.linspace(0, 1, samples, endpoint=False), spline), 1)


def open_curve(points: Points, samples: int = 60) -> DoubleArray:
    """Returns (samples, 2): a smooth curve through two or more points."""
    line = np.asarray(points, np.float64).T
    spline, _ = splprep(line, s=0, k=min(2, len(points) - 1))
    return np.stack(splev(np.linspace(0, 1, samples), spline), 1)


def outline_distance(curve: DoubleArray, window: Window, fine: int = _FINE) -> FloatArray:
    """Returns (SIZE, SIZE) signed distances to a closed curve, negative inside, texture units."""
    mask = np.zeros((SIZE * fine, SIZE * fine), np.uint8)
    cv2.fillPoly(mask, [_pixels(curve, window, fine)], 255, shift=8)
    inner = cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    outer = cv2.distanceTransform(255 - mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return _texels(outer - inner, fine)


def line_distance(curves: list[DoubleArray], window: Window, fine: int = _FINE) -> FloatArray:
    """Returns (SIZE, SIZE) distances to the nearest of several open curves, texture units."""
    mask = np.full((SIZE * fine, SIZE * fine), 255, np.uint8)
    cv2.polylines(mask, [_pixels(c, window, fine) for c in curves], False, 0, 1, cv2.LINE_8, 8)
    return _texels(cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), fine)


def dot_distance(centres: DoubleArray, radii: DoubleArray) -> FloatArray:
    """Returns (SIZE, SIZE) signed distances to discs; centres and radii in texture units."""
    v, u = texel_grid()
    best = np.full((SIZE, SIZE), 4.0, np.float32)
    for (x, y), r in zip(centres, radii, strict=True):
        np.minimum(best, np.hypot(u - x, v - y) - r, out=best)
    return best


def texel_grid() -> tuple[FloatArray, FloatArray]:
    """Returns (v, u), (SIZE, SIZE) each: the coordinates of texel centres."""
    axis = ((np.arange(SIZE, dtype=np.float32) + 0.5) / SIZE * 2 - 1).astype(np.float32)
    v, u = np.meshgrid(axis, axis, indexing="ij")
    return v, u


def inset_points(distance: FloatArray, depth: float, spacing: float) -> DoubleArray:
    """Returns (n, 2) points at equal spacing along the contour `depth` inside an outline."""
    mask = (distance < -depth).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    ring = max(contours, key=len)[:, 0, :].astype(np.float64)
    ring = (ring + 0.5) / SIZE * 2 - 1
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    at = np.arange(0, along[-1], spacing)
    return np.stack([np.interp(at, along, ring[:, 0]), np.interp(at, along, ring[:, 1])], 1)


def _pixels(curve: DoubleArray, window: Window, fine: int) -> np.ndarray:
    pixels = (window.uv(curve) * 0.5 + 0.5) * SIZE * fine - 0.5
    return np.round(pixels * 256).astype(np.int32)


def _texels(distance_px: np.ndarray, fine: int) -> FloatArray:
    smooth = cv2.GaussianBlur(distance_px, (0, 0), 0.6 * fine)
    texels = cv2.resize(smooth, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    return (texels * (2.0 / (SIZE * fine))).astype(np.float32)
