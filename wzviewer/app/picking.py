"""From a pixel to the world: the point under the cursor, to the precision of its level.

The renderer's depth is float32, and at a x8^12 zoom one float32 step is a million pixels.  So it only
says *which* surface is hit; the level's own relief, which is local and exact, says where it is.
"""

import math

import numpy as np

from wzviewer.app.services import SceneRenderer
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene
from wzviewer.core.types import DoubleArray

AGREEMENT = 0.02  # of the depth: within it the relief refines what the renderer picked
STEPS = 6  # of the walk along the ray; equal poses need one


def world_point(
    scene: Scene, renderer: SceneRenderer, camera: Camera, x_px: float, y_px: float, fallback_depth: float
) -> DoubleArray:
    """Returns the world point (3,) seen at a pixel; nowhere is taken to be at a given depth."""
    hit = renderer.pick(camera, x_px, y_px) if len(scene) else None
    picked = hit[0] if hit is not None and math.isfinite(hit[0]) and hit[0] > 0 else None
    depth = depth_on_relief(scene, camera, x_px, y_px, picked)
    if depth is None or (picked is not None and abs(depth - picked) > AGREEMENT * picked):
        depth = picked
    return camera.unproject(x_px, y_px, depth if depth is not None else fallback_depth)


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
