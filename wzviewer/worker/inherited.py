"""What a new level takes over from coarser ones: surfaces that its own camera does not see.

A level covers whatever lies inside its camera's view, in front or behind (`core.opacity`).  What is
hidden there at C_i may be seen from beside it, so the hidden surfels of the coarser levels become the
new level's too.  They fade in as the originals fade out, and the same surfels are seen throughout.
"""

import cv2
import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.draft import Draft, visible_parts
from wzviewer.worker.rasterize import LevelPart
from wzviewer.worker.standing import covering_relief

SLACK_COARSE_PX = 3.0  # of the coarser level: nearer to what is seen is the seen surface itself
WINDOW = 3  # pixels among which the farthest counts


def hidden_surfels(draft: Draft, observed: FloatArray) -> Surfels:
    """Surfels of coarser levels that lie in the new camera's view, behind all it sees.

    Args:
        draft: with camera, frame, path and the registered relief.
        observed: (h', w') float32 relief of the coarser levels at their own resolution, in the new
            level's native pixels; nan where nothing was seen.

    Returns:
        The surfels in the draft's frame, with s_native of the draft's camera; coverage is not set.
    """
    coarse_px = draft.camera.width / observed.shape[1]
    seen = np.where(np.isfinite(observed), observed, np.float32(np.inf))
    slack, front = SLACK_COARSE_PX * coarse_px, covering_relief(draft)
    parts = (
        _behind(part, draft.camera, draft.frame, (seen, front), slack)
        for part in visible_parts(draft.path, draft.camera)
    )
    return Surfels.concatenate([part for part in parts if len(part)])


def _behind(
    part: LevelPart, camera: Camera, frame: LevelFrame, fronts: tuple[FloatArray, ...], slack: float
) -> Surfels:
    """Those of a level that are in view and farther than every front by the slack.

    A coarse surfel just behind a slope of the new level would stick out of it beside its middle.
    """
    surfels = part.surfels.moved(part.frame, frame)
    view = AnchoredView.expand(camera, frame)
    size = np.array([camera.width, camera.height], np.float32)
    share = (view.project(surfels.means) / size).astype(np.float32)
    kept = np.flatnonzero(np.all((share >= 0.0) & (share < 1.0), axis=1))
    for relief in fronts:
        kept = kept[_is_behind(surfels.means[kept, 2], share[kept], relief, slack)]
    hidden = surfels.take(kept)
    return hidden.with_(native_scales=np.exp2(view.log_scale(hidden.means)))


def _is_behind(depths: FloatArray, share: FloatArray, relief: FloatArray, slack: float) -> BoolArray:
    """Whether depths (n,), native px from the anchor, are behind a relief at places (n, 2) in [0, 1)."""
    farthest = cv2.dilate(relief, np.ones((WINDOW, WINDOW), np.uint8))
    column, row = (share * np.array(relief.shape[::-1], np.float32)).astype(np.int32).T
    return np.asarray(depths > farthest[row, column] + np.float32(slack))
