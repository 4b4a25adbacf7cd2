"""What a new level takes over from coarser ones: surfaces that its own camera does not see.

A level covers whatever lies inside its camera's view, in front or behind (`core.opacity`).  What is
hidden there at C_i may be seen from beside it, so the hidden surfels of the coarser levels become the
new level's too.  They fade in as the originals fade out, and the same surfels are seen throughout.
"""

import cv2
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray
from wzviewer.worker.draft import Draft, visible_parts
from wzviewer.worker.rasterize import LevelPart

SLACK_COARSE_PX = 3.0  # of the coarser level: nearer to what is seen is the seen surface itself
SLOPE_COARSE_PX = 4.0  # of the coarser level: as far as a footprint and its lining reach along a slope
FOOTPRINT_SIGMAS = 2.5  # beyond that a surfel is not seen
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
    limits = _limit(seen, coarse_px, 1.0), _limit(draft.relief, coarse_px, coarse_px)
    parts = (_behind(part, draft, limits, coarse_px) for part in visible_parts(draft.path, draft.camera))
    return Surfels.concatenate([part for part in parts if len(part)])


def _limit(relief: FloatArray, coarse_px: float, pixels: float) -> FloatArray:
    """Returns how deep (h, w) what is seen may reach: a coarse surfel just behind it would stick out of it.

    Args:
        relief: (h, w) native px, of what is seen.
        coarse_px: of the coarser level, native px.
        pixels: of the relief in one of the coarser level.
    """
    farthest = cv2.dilate(relief, np.ones((WINDOW, WINDOW), np.uint8))
    slope = np.hypot(_slope(relief, 0), _slope(relief, 1)) * np.float32(pixels)
    return np.asarray(farthest + SLACK_COARSE_PX * coarse_px + SLOPE_COARSE_PX * slope, np.float32)


def _slope(relief: FloatArray, axis: int) -> FloatArray:
    """Returns the change (h, w) to the next pixel on the flatter side: an edge is no slope."""
    with np.errstate(invalid="ignore"):  # nothing was seen beside nothing
        step = np.nan_to_num(np.abs(np.diff(relief, axis=axis)), posinf=0.0)
    sides = []
    for at in (0, -1):  # the first pixel has nothing before it, the last nothing after it
        nothing = np.full_like(np.take(relief, [at], axis), np.inf)
        sides.append(np.concatenate([nothing, step] if at == 0 else [step, nothing], axis))
    flatter = np.minimum(*sides)
    return np.where(np.isfinite(flatter), flatter, 0).astype(np.float32)


def _behind(part: LevelPart, draft: Draft, limits: tuple[FloatArray, ...], coarse_px: float) -> Surfels:
    """Those of a level that are in view and farther than every limit, all over their footprints."""
    surfels = part.surfels.moved(part.frame, draft.frame)
    view = AnchoredView.expand(draft.camera, draft.frame)
    size = np.array([draft.camera.width, draft.camera.height], np.float32)
    share = (view.project(surfels.means) / size).astype(np.float32)
    kept = np.flatnonzero(np.all((share >= 0.0) & (share < 1.0), axis=1))
    for limit in limits:
        kept = kept[surfels.means[kept, 2] > _at(limit, share[kept])]
    reach = FOOTPRINT_SIGMAS * surfels.scales[kept].max(axis=1)
    steps = np.ceil(np.log2(np.maximum(reach / (FOOTPRINT_SIGMAS * coarse_px), 1.0))).astype(np.int64)
    for step in np.unique(steps[steps > 0]):  # those of older levels, or of a backdrop
        here = steps == step
        far = _farthest(draft.relief, FOOTPRINT_SIGMAS * coarse_px * 2.0**step, coarse_px)
        steps[here] = np.where(surfels.means[kept[here], 2] > _at(far, share[kept[here]]), 0, -1)
    hidden = surfels.take(kept[steps >= 0])
    return hidden.with_(native_scales=np.exp2(view.log_scale(hidden.means)))


def _at(picture: FloatArray, share: FloatArray) -> FloatArray:
    """Returns the values of a picture (h, w) at places (n, 2) in [0, 1)."""
    column, row = (share * np.array(picture.shape[::-1], np.float32)).astype(np.int32).T
    return picture[row, column]


def _farthest(relief: FloatArray, reach_px: float, coarse_px: float) -> FloatArray:
    """Returns the farthest of a relief (h, w) within a reach, at a resolution of coarse pixels."""
    size = [max(round(n / coarse_px), 1) for n in relief.shape[::-1]]
    window = np.ones((round(coarse_px),) * 2, np.uint8)
    small = cv2.resize(cv2.dilate(relief, window), size, interpolation=cv2.INTER_NEAREST)
    reach = min(round(reach_px / coarse_px), max(size))
    return np.asarray(cv2.dilate(small, np.ones((2 * reach + 1,) * 2, np.uint8)), np.float32)
