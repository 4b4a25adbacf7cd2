"""Stage 5, lines 29-31 of Algorithm 1: E_{i+1} from partial surfels and the images that show them.

Adam on orientation, scales and opacity; positions, colours and s_native stay (paper, Sec. 3.1).  A view
on the pixel grid of C alone would be overfitted: surfels shrink onto the grid and holes open as soon as
the camera moves.  So C alternates with neighbours and with views off the grid (each moves what it sees)::

    with neighbours      C  N1  x2 crop   C  N2  x2 crop   ...
    without              C  shifted by half a pixel   C  x2 crop   ...
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.objective import AdamState, PreparedView, SurfelObjective
from wzviewer.worker.rasterize import LevelPart, render

STEPS, COLOR_STEPS = 12, 2
ROOT_STEPS = 10  # of E_0, which is waited for; at C_0 it is as sharp (45.0 dB, after twelve 44.4)
RATE_OPACITY, RATE_LOG_SCALE, RATE_QUAT = 0.2, 0.03, 0.01
CROP_FACTOR = 2.0
BACKDROP_CONTRAST = 0.3  # at 1 edges soften by 1.8 dB; at 0 leaks are free
CROP_CENTRES = ((0.25, 0.25), (0.75, 0.75), (0.75, 0.25), (0.25, 0.75))


@dataclass(frozen=True, eq=False)
class TargetView:
    """A neighbouring view that the surfels are to reproduce.

    Attributes:
        camera: C_{i+1}^k.
        target: I_{i+1}^k, (h, w, 3) float32 sRGB.
        mask: (h, w) true where the target is known; None for everywhere.
    """

    camera: Camera
    target: FloatArray
    mask: BoolArray | None = None


def optimize(
    surfels: Surfels,
    image: FloatArray,
    camera: Camera,
    frame: LevelFrame,
    views: Sequence[TargetView] = (),
    steps: int = STEPS,
    color_steps: int = COLOR_STEPS,
    on_step: Callable[[int, int], None] | None = None,
    kept: BoolArray | None = None,
    hidden: Surfels | None = None,
) -> Surfels:
    """OptimizeSurfels of Algorithm 1 (lines 30-31).

    Args:
        surfels: E_{i+1}, partial: stage 3 and the layers of stage 4.
        image: I_{i+1}, (h, w, 3) float32 sRGB.
        camera: C_{i+1}.
        frame: the level's local frame.
        views: I_{i+1}^k with their cameras.
        steps: of Adam, one view each.
        color_steps: closed-form steps on the colours at C_{i+1} afterwards; 0 keeps them, as the paper.
        on_step: called as (done, total) before each step; may raise `Cancelled`.
        kept: (n,) surfels whose q, s and o stay, such as what is meant to be seen through.
        hidden: what is behind the surfels wherever C sees them; drawn once for each view, as its backdrop.

    Returns:
        The surfels with new quats, scales, opacities (and colors), in the same order.
    """
    if len(surfels) == 0:
        return surfels
    objective = SurfelObjective(surfels, frame)
    source = TargetView(camera, image)
    schedule = view_schedule(source, views, steps)
    parts = [LevelPart.of(hidden, frame)] if hidden is not None and len(hidden) else []
    prepared: dict[int, tuple[PreparedView, FloatArray]] = {}
    state = AdamState(len(surfels), (RATE_QUAT, RATE_LOG_SCALE, RATE_OPACITY))
    for step, view in enumerate(schedule):
        if on_step is not None:
            on_step(step, steps + color_steps)
        if id(view) not in prepared:
            looked = objective.prepare(view.camera, view.target, view.mask)
            prepared[id(view)] = looked, _over(parts, view.camera, contrasting(looked.target))
        objective.descend(prepared[id(view)][0], state, prepared[id(view)][1], kept)
    looked = prepared[id(source)][0] if steps else objective.prepare(camera, image)
    behind = _over(parts, camera, looked.target)
    for step in range(color_steps):
        if on_step is not None:
            on_step(steps + step, steps + color_steps)
        objective.step_colors(looked, behind)
    return objective.result()


def _over(parts: Sequence[LevelPart], camera: Camera, picture: FloatArray) -> FloatArray:
    """Returns hidden surfels over a picture (3, H, W), as a camera sees them."""
    if not parts:
        return picture
    seen = render(parts, camera, depth=False)
    inside = (slice(None), slice(0, camera.height), slice(0, camera.width))
    out = picture.copy()
    out[inside] = seen.color.transpose(2, 0, 1) + (1 - seen.coverage) * picture[inside]
    return out


def contrasting(target: FloatArray) -> FloatArray:
    """Returns what stands behind the surfels while they are optimised, (3, h, w).

    Over black a dark surface may leak for nothing, and something bright behind it shines through
    later.  Over the target pulled towards its opposite every leak costs a little everywhere.
    """
    opposite = (target < 0.5).astype(np.float32)
    return target + np.float32(BACKDROP_CONTRAST) * (opposite - target)


def view_schedule(source: TargetView, views: Sequence[TargetView], steps: int) -> list[TargetView]:
    """Returns the view of every step; equal views are the same object (module docstring)."""
    crops = [_same_pose(source, source.camera.zoomed_to_region(x, y, CROP_FACTOR)) for x, y in CROP_CENTRES]
    rounds: list[tuple[TargetView, ...]]
    if views:
        rounds = [(source, views[k % len(views)], crops[k % 4]) for k in range(steps // 3 + 1)]
    else:
        camera = source.camera
        shifted = _same_pose(source, replace(camera, cx=camera.cx + 0.5, cy=camera.cy + 0.5))
        rounds = [(source, shifted, source, crops[k % 4]) for k in range(steps // 4 + 1)]
    return [view for turn in rounds for view in turn][:steps]


def _same_pose(source: TargetView, camera: Camera) -> TargetView:
    """Resamples an image for a camera that shares its pose: bicubic, unknown outside of the image."""
    known = source.camera
    ratio_x, ratio_y = known.fx / camera.fx, known.fy / camera.fy
    # cv2 counts from pixel centres: known_px = ratio (px - c) + c_known, less one half
    shift_x = ratio_x * (0.5 - camera.cx) + known.cx - 0.5
    shift_y = ratio_y * (0.5 - camera.cy) + known.cy - 0.5
    known_from_new = np.array([[ratio_x, 0.0, shift_x], [0.0, ratio_y, shift_y]])
    size = (camera.width, camera.height)
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    target = cv2.warpAffine(source.target, known_from_new, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    x = ratio_x * np.arange(camera.width) + shift_x
    y = ratio_y * np.arange(camera.height) + shift_y
    inside = ((x >= 0) & (x <= known.width - 1))[None, :] & ((y >= 0) & (y <= known.height - 1))[:, None]
    return TargetView(camera, np.clip(target, 0.0, 1.0), inside)
