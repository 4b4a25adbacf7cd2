"""Anchored projection: float32 never sees the world (deep zoom).

A level keeps its surfels in a local frame: float64 ``origin`` A, axes of its own camera, and
``unit`` u0, the length of one native pixel at A.  A camera X is *expanded about the anchor* into
three rows, computed in float64 and used in float32::

    a = R_X (A - c_X)        M = R_X axes^T        r = u0 / a.z
    g  = r M_z               gx = fx r (M_x - (a.x / a.z) M_z)          gy alike
    D(u) = 1 + g . u         p_px(u) = anchor_px + (gx . u, gy . u) / D(u)
    log2 pixel scale(u) / u0 = base + log2 D(u),        base = log2(a.z / (f_X u0))

so every number that a shader touches is of the size of a pixel.  The GLSL twin is
``shaders/include/anchor.glsl``.
"""

from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import DoubleArray, FloatArray

DEPTH_FLOOR = 1e-6  # of D(u): behind or at the camera


@dataclass(frozen=True, eq=False)
class LevelFrame:
    """The local frame of a level.

    Attributes:
        origin: A, (3,) float64, world units.
        axes: (3, 3) float64, rows are the local axes in the world (the rotation of the level's camera).
        unit: u0, world units per local unit: one native pixel at A.
    """

    origin: DoubleArray
    axes: DoubleArray
    unit: float

    @classmethod
    def of_camera(cls, camera: Camera, depth: float) -> "LevelFrame":
        """Returns the frame anchored at the centre of a camera's image, at a depth (world units)."""
        origin = camera.unproject(camera.width / 2, camera.height / 2, depth)
        return cls(origin, camera.rotation.copy(), depth / camera.focal_px)

    def unit_seen_by(self, camera: Camera) -> float:
        """Returns the world length of a camera's pixel at A; not positive where A is behind the camera."""
        return camera.pixel_scale(float(camera.to_camera(self.origin)[2]))

    def to_world(self, means: FloatArray) -> DoubleArray:
        """Maps local positions (n, 3) to the world, float64."""
        return self.origin + self.unit * (np.asarray(means, np.float64) @ self.axes)


@dataclass(frozen=True, eq=False)
class AnchoredView:
    """A camera expanded about a level's anchor; all float64, to be cast after the expansion.

    Attributes:
        rows: (3, 4) float64: ``(gx, anchor_x_px)``, ``(gy, anchor_y_px)``, ``(g, base)``.
        depth: depth of the anchor, world units; negative when it lies behind the camera.
        z_axis: M_z, (3,), the camera's z axis in local axes.
    """

    rows: DoubleArray
    depth: float
    z_axis: DoubleArray

    @classmethod
    def expand(cls, camera: Camera, frame: LevelFrame) -> "AnchoredView":
        """Expands a camera about a frame's anchor (module docstring)."""
        a = camera.to_camera(frame.origin)
        M = camera.rotation @ frame.axes.T
        z = a[2] if abs(a[2]) > 1e-300 else 1e-300
        r = frame.unit / z
        rows = np.empty((3, 4))
        rows[0, :3] = camera.fx * r * (M[0] - a[0] / z * M[2])
        rows[1, :3] = camera.fy * r * (M[1] - a[1] / z * M[2])
        rows[2, :3] = r * M[2]
        rows[:, 3] = (
            camera.fx * a[0] / z + camera.cx,
            camera.fy * a[1] / z + camera.cy,
            np.log2(abs(z) / (camera.focal_px * frame.unit)),
        )
        return cls(rows, float(a[2]), M[2])

    def finer(self, factor: float) -> "AnchoredView":
        """Returns the view with pixel scales as of ``factor`` times the resolution; points stay in place.

        A frame that stands in for a finer one, in motion, shows the levels that the finer one would show.
        """
        if factor == 1.0:
            return self
        rows = self.rows.copy()
        rows[2, 3] -= np.log2(factor)
        return replace(self, rows=rows)

    @property
    def side(self) -> float:
        """+1 where the anchor lies in front of the camera, -1 behind."""
        return 1.0 if self.depth > 0.0 else -1.0

    def depth_ratio(self, means: FloatArray) -> FloatArray:
        """D(u): depth relative to the anchor's, (n,) float32; see `in_front`."""
        g = self.rows[2, :3].astype(np.float32)
        return np.float32(1.0) + means @ g

    def in_front(self, means: FloatArray) -> FloatArray:
        """D(u) made positive in front of the camera, also where the anchor itself lies behind it."""
        D = self.depth_ratio(means)
        return D if self.depth > 0.0 else -D

    def project(self, means: FloatArray) -> FloatArray:
        """Image position of local points (n, 3), px, (n, 2) float32; nan behind the camera."""
        D = self.depth_ratio(means)
        D[self.in_front(means) <= DEPTH_FLOOR] = np.nan
        rows = self.rows[:2].astype(np.float32)
        return (means @ rows[:, :3].T) / D[:, None] + rows[:, 3]

    def log_scale(self, means: FloatArray) -> FloatArray:
        """log2 of Eq. 1's d / f over u0, (n,) float32."""
        D = np.maximum(self.in_front(means), np.float32(DEPTH_FLOOR))
        return np.float32(self.rows[2, 3]) + np.log2(D)
