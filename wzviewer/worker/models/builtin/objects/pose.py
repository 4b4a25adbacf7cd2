"""How a body stands in an image: rays are parallel and slanted, lengths are native pixels."""

from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.types import DoubleArray


@dataclass(frozen=True, eq=False)
class Pose:
    """How a body stands in an image.

    Attributes:
        camera_from_object: (3, 3) rotation.
        size_px: native pixels in one body length.
        position: (x, y) image position and z relief, native px, of the body's origin.
        ray: (x, y) slope of the parallel rays: image offset for a unit of depth.
    """

    camera_from_object: DoubleArray
    size_px: float
    position: tuple[float, float, float]
    ray: tuple[float, float] = (0.0, 0.0)

    @property
    def stretch(self) -> float:
        """Length of a ray for a unit of depth."""
        return float(np.sqrt(1 + self.ray[0] ** 2 + self.ray[1] ** 2))

    def seen_from(self, x0: float, y0: float, factor: float) -> "Pose":
        """Returns the pose in an image whose pixel is (p - (x0, y0)) * factor."""
        x, y, z = self.position
        return replace(
            self, size_px=self.size_px * factor, position=((x - x0) * factor, (y - y0) * factor, z * factor)
        )

    def frame(self) -> DoubleArray:
        """Returns (4, 3): the object-space origin of image (0, 0), steps in x and y, unit direction."""
        back = self.camera_from_object.T
        x, y, _ = self.position
        direction = back @ np.array([self.ray[0], self.ray[1], 1.0]) / self.stretch
        corner = back @ np.array([-x, -y, 0.0]) / self.size_px
        return np.stack([corner, back[:, 0] / self.size_px, back[:, 1] / self.size_px, direction])

    def relief(self, depth: DoubleArray) -> DoubleArray:
        """Returns relief, native px, at ray lengths in body lengths."""
        return self.position[2] + depth * self.size_px / self.stretch

    def project(self, points: DoubleArray) -> DoubleArray:
        """Returns image positions (n, 2) of object points (n, 3)."""
        q = points @ self.camera_from_object.T * self.size_px
        return q[:, :2] + self.position[:2] - q[:, 2:] * np.asarray(self.ray)
