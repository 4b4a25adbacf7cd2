"""From a pixel to the world: the point under the cursor, to the precision of its level.

The renderer's depth is float32, and at a x8^12 zoom one float32 step is a million pixels.  So it only
says *which* surface is hit; the level's own relief, which is local and exact, says where it is.
"""

import math

from wzviewer.app.services import SceneRenderer
from wzviewer.core.camera import Camera
from wzviewer.core.foreground import depth_on_relief
from wzviewer.core.scene import Scene
from wzviewer.core.types import DoubleArray

AGREEMENT = 0.02  # of the depth: within it the relief refines what the renderer picked


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
