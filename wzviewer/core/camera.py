"""Cameras: the paper's C, with the focal length that Eq. 1 needs.

Spaces: ``world``; ``camera`` (OpenCV: x right, y down, z forward); ``image`` (pixels, origin top
left, first centre at .5).  Everything is float64: at a x8^12 zoom a pixel is 1e-14 of the depth.

A zoom multiplies the focal length and moves the principal point, so the pose stays and a child
image is an exact crop of its parent's, subdivided.
"""

from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.constants import FOCAL_PX, IMAGE_WIDTH_PX
from wzviewer.core.types import DoubleArray


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera C.

    Attributes:
        camera_from_world: (4, 4) float64, rigid.
        fx: focal length in x, px.
        fy: focal length in y, px.
        cx: principal point in x, px; far outside the image after a zoom off the centre.
        cy: principal point in y, px.
        width: image width, px.
        height: image height, px.
    """

    camera_from_world: DoubleArray
    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    @classmethod
    def initial(cls, width: int, height: int, focal_px: float | None = None) -> "Camera":
        """Returns C_0: at the world origin, looking along +z, f_0 = 1024 px at 1088 px width."""
        f = focal_px if focal_px is not None else FOCAL_PX * max(width, height) / IMAGE_WIDTH_PX
        return cls(np.eye(4), f, f, width / 2, height / 2, width, height)

    @property
    def focal_px(self) -> float:
        """sqrt(fx fy) of Eq. 1, px."""
        return float(np.sqrt(self.fx * self.fy))

    @property
    def key(self) -> tuple[object, ...]:
        """All numbers: equal keys are the same view."""
        return (self.camera_from_world.tobytes(), self.fx, self.fy, self.cx, self.cy, self.width, self.height)

    @property
    def rotation(self) -> DoubleArray:
        """R, (3, 3): camera axes from world axes."""
        return self.camera_from_world[:3, :3]

    @property
    def position(self) -> DoubleArray:
        """Centre of projection in world units, (3,)."""
        return -self.rotation.T @ self.camera_from_world[:3, 3]

    def to_camera(self, points: DoubleArray) -> DoubleArray:
        """Maps world points (..., 3) to camera space."""
        # R (p - c), never R p + t: near the camera's own position the sum would cancel.
        return (np.asarray(points, np.float64) - self.position) @ self.rotation.T

    def to_world(self, points: DoubleArray) -> DoubleArray:
        """Maps camera-space points (..., 3) to the world."""
        return np.asarray(points, np.float64) @ self.rotation + self.position

    def project(self, points: DoubleArray) -> DoubleArray:
        """Projects world points (..., 3) to image pixels and depth, (..., 3) = x_px, y_px, z."""
        p = self.to_camera(points)
        z = p[..., 2]
        x_px = self.fx * p[..., 0] / z + self.cx
        y_px = self.fy * p[..., 1] / z + self.cy
        return np.stack([x_px, y_px, z], axis=-1)

    def unproject(self, x_px: float, y_px: float, depth: float) -> DoubleArray:
        """Returns the world point (3,) seen at a pixel at a given depth."""
        ray = np.array([(x_px - self.cx) / self.fx, (y_px - self.cy) / self.fy, 1.0])
        return self.to_world(ray * depth)

    def pixel_scale(self, depth: float) -> float:
        """World length of one pixel at a depth, Eq. 1: d / sqrt(fx fy)."""
        return depth / self.focal_px

    def zoomed(self, x_px: float, y_px: float, factor: float) -> "Camera":
        """Returns the camera magnified about a pixel that keeps its place."""
        return replace(
            self,
            fx=self.fx * factor,
            fy=self.fy * factor,
            cx=x_px + (self.cx - x_px) * factor,
            cy=y_px + (self.cy - y_px) * factor,
        )

    def zoomed_to_region(self, x: float, y: float, factor: float) -> "Camera":
        """Returns C_{i+1}: the region centred at a fraction (x, y) of this image, ``factor`` closer.

        Args:
            x: centre as a fraction of the image width, [0, 1].
            y: centre as a fraction of the image height, [0, 1].
            factor: magnification.
        """
        x_px, y_px = x * self.width, y * self.height
        near = self.zoomed(x_px, y_px, factor)
        return replace(near, cx=near.cx + self.width / 2 - x_px, cy=near.cy + self.height / 2 - y_px)

    def resampled(self, width: int, height: int) -> "Camera":
        """Returns the same view with other pixels: the image is stretched to the new size."""
        x, y = width / self.width, height / self.height
        lens = (self.fx * x, self.fy * y, self.cx * x, self.cy * y)
        return Camera(self.camera_from_world, *lens, width, height)

    def resized(self, width: int, height: int) -> "Camera":
        """Returns the same view at another size: the field of view that fits is kept whole."""
        ratio = min(width / self.width, height / self.height)
        return replace(
            self,
            fx=self.fx * ratio,
            fy=self.fy * ratio,
            cx=width / 2 + (self.cx - self.width / 2) * ratio,
            cy=height / 2 + (self.cy - self.height / 2) * ratio,
            width=width,
            height=height,
        )
