"""The depth coordinate of this package: image shift per unit of tan(orbit angle), in native px.

At level 0 it is the parallax q = -delta / (1 + delta / f), affine in inverse depth.  Deep levels
have f up to 1e14 px and a background up to 1e15 px away, where q is no longer affine in anything
useful and float32 runs out; there the axis is a signed logarithm that equals q near the anchor.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.constants import FOCAL_PX, IMAGE_WIDTH_PX
from wzviewer.core.types import FloatArray

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
        delta = relief.astype(np.float64)
        if self.wide:
            depth = np.maximum(1.0 + delta / self.focal_px, NEAREST_DEPTH)
            return (-delta / depth).astype(np.float32)
        return (-np.sign(delta) * self.base_px * np.log1p(np.abs(delta) / self.base_px)).astype(np.float32)

    def relief_of(self, shift: FloatArray) -> FloatArray:
        """Inverse of `shift_of`."""
        q = shift.astype(np.float64)
        if self.wide:
            return (-q / (1.0 + q / self.focal_px)).astype(np.float32)
        return (-np.sign(q) * self.base_px * np.expm1(np.abs(q) / self.base_px)).astype(np.float32)

    def log_of(self, shift: FloatArray) -> FloatArray:
        """Returns -log(depth) up to a constant (...,): differences are relative depth differences."""
        if self.wide:
            near = np.maximum(1.0 + shift.astype(np.float64) / self.focal_px, 1e-3)
            return np.log(near).astype(np.float32)
        return (shift / np.float32(self.base_px)).astype(np.float32)

    def step_of(self, shift: FloatArray, fraction: float) -> FloatArray:
        """Shift (...,) by which another surface must differ to count as another, px.

        Args:
            shift: (...,) where the question is asked.
            fraction: relative depth difference that a depth map may have by mistake.
        """
        if self.wide:
            return (fraction * (shift + np.float32(self.focal_px))).astype(np.float32)
        if self.photographed:
            squeezed = np.exp(np.abs(shift) / np.float32(self.base_px))
            depth = np.maximum(self.focal_px + self.relief_of(shift), NEAREST_DEPTH * self.focal_px)
            return np.maximum(fraction * depth / squeezed, DEEP_NOISE_PX).astype(np.float32)
        return np.full_like(shift, DEEP_NOISE_PX)

    def behind(self, relief: FloatArray, fraction: float) -> FloatArray:
        """Returns the nearest relief (...,) that is safely behind a given one, native px."""
        delta = relief.astype(np.float64)
        if self.wide:
            return (delta + fraction * (self.focal_px + delta)).astype(np.float32)
        return (delta + 0.5 + fraction * np.abs(delta)).astype(np.float32)
