"""What a pixel of a new level is worth in metres, as far as the photograph tells."""

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects.sizes import Ruler, coarse


def metres_of(
    root: Level, camera: Camera, frame: LevelFrame, relief: FloatArray, sky: BoolArray
) -> FloatArray | None:
    """Returns metres in a pixel over a new level's view, coarse, nan in the sky; None if unknown.

    Args:
        root: E_0, whose photograph has ground and horizon.
        camera: of the new level.
        frame: its frame.
        relief: (h, w) its depth, native px about the anchor.
        sky: (h, w).
    """
    kind = str(root.notes.get("scene_kind", ""))
    ruler = Ruler.of(root.depth, root.maps.get("sky"), root.camera.focal_px, kind)
    if ruler is None:
        return None
    anchor = float(camera.to_camera(frame.origin)[2])
    from_root = float(root.camera.to_camera(frame.origin)[2])
    depth = coarse(np.where(sky, np.nan, anchor + frame.unit * relief.astype(np.float64))).astype(np.float64)
    metres_per_unit = ruler(depth + (from_root - anchor))
    return np.asarray(metres_per_unit * depth / camera.focal_px, np.float32)
