"""Where the levels' own reliefs lie in a view, and what a view turns about."""

import math

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene
from wzviewer.core.types import DoubleArray

STEPS = 6  # of the walk along the ray; equal poses need one
BACKDROP = 2.0  # so much farther than the foreground is behind what one looks at
GRID = 8  # places along a side of the view where its foreground is looked for


def turning_point(scene: Scene, camera: Camera, point: DoubleArray) -> DoubleArray:
    """Returns the world point (3,) that a view turns about to show what it looks at from the side.

    That is the point looked at; where it is sky, the point before it in the foreground, because turning
    about the sky would throw a flower beside it out of the view.
    """
    if not is_sky(scene, point):
        return point
    x_px, y_px, depth = camera.project(point)
    near = foreground_depth(scene, camera)
    return camera.unproject(x_px, y_px, near) if depth > BACKDROP * near > 0 else point


def is_sky(scene: Scene, point: DoubleArray) -> bool:
    """Returns whether the photo shows sky in the direction of a world point (3,)."""
    if not len(scene) or (sky := scene[0].maps.get("sky")) is None:
        return False
    x, y, z = scene[0].camera.project(point)
    return bool(z > 0 and 0 <= x < sky.shape[1] and 0 <= y < sky.shape[0] and sky[int(y), int(x)])


def foreground_depth(scene: Scene, camera: Camera) -> float:
    """Returns the depth that a tenth of the view lies before, by its levels' reliefs; inf if unknown."""
    places = [((i + 0.5) / GRID, (j + 0.5) / GRID) for i in range(GRID) for j in range(GRID)]
    found = [depth_on_relief(scene, camera, x * camera.width, y * camera.height) for x, y in places]
    known = sorted(depth for depth in found if depth is not None and depth > 0)
    return known[len(known) // 10] if known else math.inf


def depth_on_relief(
    scene: Scene, camera: Camera, x_px: float, y_px: float, start: float | None = None
) -> float | None:
    """Returns the depth at a pixel by the finest visible level that shows it; None outside.

    Args:
        scene: the levels.
        camera: that the pixel belongs to.
        x_px: pixel.
        y_px: pixel.
        start: depth where the walk along the ray begins; the level's anchor when None.
    """
    visible = [scene[i] for i in scene.visible()]
    for level in sorted(visible, key=lambda level: -level.camera.focal_px):
        depth = _walk(level, camera, x_px, y_px, start)
        if depth is not None:
            return depth
    return None


def _walk(level: Level, camera: Camera, x_px: float, y_px: float, start: float | None) -> float | None:
    """Alternates between the ray and the relief until the depth stands."""
    anchor = float(camera.to_camera(level.frame.origin)[2])
    depth = start if start is not None else anchor
    for _ in range(STEPS):
        if not depth > 0:
            return None
        surface = _surface(level, camera.unproject(x_px, y_px, depth))
        if surface is None:
            return None
        found = float(camera.to_camera(surface)[2])
        if abs(found - depth) <= 1e-15 * abs(found):
            break
        depth = found
    return depth


def _surface(level: Level, point: DoubleArray) -> DoubleArray | None:
    """The point of a level's relief that its own camera sees in the direction of a point."""
    x, y, z = level.camera.project(point)
    height, width = level.relief.shape
    if not (z > 0 and 0 <= x < width and 0 <= y < height):
        return None
    relief = float(level.relief[int(y), int(x)])
    if not np.isfinite(relief):
        return None
    return level.camera.unproject(x, y, level.anchor_depth + level.frame.unit * relief)
