"""The depth coordinate of this package: image shift per unit of tan(orbit angle), in native px.

At level 0 it is the parallax q = -delta / (1 + delta / f), affine in inverse depth.  Deep levels
have f up to 1e14 px and a background up to 1e15 px away, where q is no longer affine in anything
useful and float32 runs out; there the axis is a signed logarithm that equals q near the anchor.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numba import njit, prange

from wzviewer.core.camera import Camera
from wzviewer.core.constants import FOCAL_PX, IMAGE_WIDTH_PX
from wzviewer.core.types import BoolArray, FloatArray

WIDE_FOCAL_RATIO = 4.0  # focal length / long side below which perspective matters inside the image
NEAREST_DEPTH = 0.02  # relative to the anchor; nothing is nearer to a camera
NEAR_FOCAL_RATIO = 32.0  # the same below which surfaces have the errors of the photograph's depth
DEEP_NOISE_PX = 2.0  # smallest step between two surfaces where depth noise is not relative


@dataclass(frozen=True)
class DepthAxis:
    """Maps relief (delta, + farther) to shift (+ nearer) and back.

    Attributes:
        focal_px: focal length of the level, px.
        base_px: focal length that a level-0 camera of this image size would have, px.
    """

    focal_px: float
    base_px: float

    @classmethod
    def of(cls, camera: Camera) -> Self:
        """Returns the axis of one camera."""
        base = FOCAL_PX * max(camera.width, camera.height) / IMAGE_WIDTH_PX
        return cls(camera.focal_px, base)

    @property
    def wide(self) -> bool:
        """True where the field of view is that of a photograph: depth errors are relative."""
        return self.focal_px < WIDE_FOCAL_RATIO * self.base_px

    @property
    def photographed(self) -> bool:
        """True where most surfaces are still those of the photograph, with the errors of its depth."""
        return self.focal_px < NEAR_FOCAL_RATIO * self.base_px

    def shift_of(self, relief: FloatArray) -> FloatArray:
        """Maps relief (...,) to shift (...,), both native px."""
        if self.wide:
            return _of_all(_wide_shift, relief, self.focal_px)
        delta = relief.astype(np.float64)
        return (-np.sign(delta) * self.base_px * np.log1p(np.abs(delta) / self.base_px)).astype(np.float32)

    def relief_of(self, shift: FloatArray) -> FloatArray:
        """Inverse of `shift_of`."""
        if self.wide:
            return _of_all(_wide_relief, shift, self.focal_px)
        q = shift.astype(np.float64)
        return (-np.sign(q) * self.base_px * np.expm1(np.abs(q) / self.base_px)).astype(np.float32)

    def log_of(self, shift: FloatArray) -> FloatArray:
        """Returns -log(depth) up to a constant (...,): differences are relative depth differences."""
        if self.wide:
            return _of_all(_wide_log, shift, self.focal_px)
        return (shift / np.float32(self.base_px)).astype(np.float32)

    def step_of(self, shift: FloatArray, fraction: float) -> FloatArray:
        """Shift (...,) by which another surface must differ to count as another, px.

        Args:
            shift: (...,) where the question is asked.
            fraction: relative depth difference that a depth map may have by mistake.
        """
        if self.wide:
            return np.asarray(np.float32(fraction) * (shift + np.float32(self.focal_px)), np.float32)
        if self.photographed:
            squeezed = np.exp(np.abs(shift) / np.float32(self.base_px))
            depth = np.maximum(self.focal_px + self.relief_of(shift), NEAREST_DEPTH * self.focal_px)
            return np.maximum(fraction * depth / squeezed, DEEP_NOISE_PX).astype(np.float32)
        return np.full_like(shift, DEEP_NOISE_PX)

    def behind(self, relief: FloatArray, fraction: float) -> FloatArray:
        """Returns the nearest relief (...,) that is safely behind a given one, native px."""
        if self.wide:
            return _of_all(_wide_behind, relief, self.focal_px, fraction)
        delta = relief.astype(np.float64)
        return (delta + 0.5 + fraction * np.abs(delta)).astype(np.float32)

    def within(self, near: FloatArray, far: FloatArray, limit: float) -> BoolArray:
        """Tells where a relief (...,) is farther than another by less than a limit in `log_of`."""
        if self.wide:
            focal_px = np.float32(self.focal_px)
            return np.asarray(focal_px + far < np.float32(np.exp(limit)) * (focal_px + near))
        return np.asarray(self.log_of(self.shift_of(near)) - self.log_of(self.shift_of(far)) < limit)


def _of_all(kernel: Callable[..., FloatArray], values: FloatArray, *parameters: float) -> FloatArray:
    """Applies a kernel to values (...,): the fields are as large as a padded picture, and asked for often."""
    values = np.asarray(values, np.float32)
    return kernel(np.ascontiguousarray(values).ravel(), *map(float, parameters)).reshape(values.shape)


@njit(cache=True, nogil=True, parallel=True)
def _wide_shift(relief: FloatArray, focal_px: float) -> FloatArray:
    shift = np.empty_like(relief)
    for i in prange(relief.size):
        delta = np.float64(relief[i])
        shift[i] = -delta / max(1.0 + delta / focal_px, NEAREST_DEPTH)
    return shift


@njit(cache=True, nogil=True, parallel=True)
def _wide_relief(shift: FloatArray, focal_px: float) -> FloatArray:
    relief = np.empty_like(shift)
    for i in prange(shift.size):
        q = np.float64(shift[i])
        relief[i] = -q / (1.0 + q / focal_px)
    return relief


@njit(cache=True, nogil=True, parallel=True)
def _wide_log(shift: FloatArray, focal_px: float) -> FloatArray:
    log = np.empty_like(shift)
    for i in prange(shift.size):
        log[i] = np.log(max(1.0 + np.float64(shift[i]) / focal_px, 1e-3))
    return log


@njit(cache=True, nogil=True, parallel=True)
def _wide_behind(relief: FloatArray, focal_px: float, fraction: float) -> FloatArray:
    behind = np.empty_like(relief)
    for i in prange(relief.size):
        delta = np.float64(relief[i])
        behind[i] = delta + fraction * (focal_px + delta)
    return behind
