"""Stage 1 (Algorithm 1, lines 11-19): the new scale image.

``O = render(E_i, C_{i+1})`` is rendered at the parent's own resolution: more pixels would hold no
more than the parent has.  Where the world ends, O is continued.  ``S`` is the description that the
parent's stage 1 kept.  Super-resolution makes ``I'``; a prompt edits it into ``I``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from wzviewer.config import EXTENSION_FACTOR
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.errors import WorkerError
from wzviewer.worker.beside import Overlay, grown, overlay_of, parts_among, split
from wzviewer.worker.draft import Draft, visible_parts
from wzviewer.worker.levels import context_of
from wzviewer.worker.metres import metres_of
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.models.builtin.detail.consistency import brought_near, consistency_db
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.synthesizer import Detail
from wzviewer.worker.models.builtin.objects.editor import Edit, Support
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.extend import extended
from wzviewer.worker.models.builtin.views.layers import Surface
from wzviewer.worker.rasterize import LevelPart, render
from wzviewer.worker.stages.stage1_drawn_again import covered_share, drawn_again, with_objects
from wzviewer.worker.stages.stage1_whole_pixels import cut, is_zoom, on_whole_pixels, whole_pixels

MIN_SIDE_PX = 8  # of an observation
EXTEND_SHARE_MIN, EXTEND_SHARE_MAX = 0.02, 0.97  # of an observation that is continued; less is a gap
# A surfel with a larger standard deviation, in native pixels of its level, shows nothing: in a zoom that is
# the backdrop; an extension makes what was painted around the frame anew, from more of the picture.
BACKDROP_SIGMA_PX, PAD_SIGMA_PX = 10.0, 1.2
SPECK_PX, ISLAND_SHARE = 7, 0.3  # of the largest piece of what is known
EMPTY_SHARE = 0.35  # of a pixel; between its surfels a surface lets through up to an eighth of what is behind
SKY_RELIEF_SHARE = 0.5  # a point this close to the depth of the sky counts as sky

STEP_REACH_PX = 3  # beside an outline: there its step is found in the picture
PARENT_DB = 42.5  # between a first zoom and its parent, which had the photograph's noise
PLAIN_UP_TO = 2  # enlarged so little, a preview is what a network took two seconds for
Check = Callable[[], None]


@dataclass(frozen=True, eq=False)
class Observation:
    """O_{i+1}: what the chain of levels shows at the new camera, at the parent's resolution.

    Attributes:
        path: the levels from the root to E_i.
        camera: C_{i+1}.
        frame: the new level's frame, anchored at the median depth of the view.
        image: O, (h', w', 3) float32 in [0, 1], as `grid` sees it; holes filled.  Finer where the
            photograph is (`worker.photograph`).
        relief: target depth in the *new* native pixels, (h', w') float32; nan where undefined.
        sky: (h', w') bool.
        grid: the camera of `image`: C_{i+1}, or for a zoom one that sees whole pixels of the parent.
        extended_share: share of O that no level showed and that was continued.
        coarse: O as the parent has it, where `image` is finer; else None.
        joined: older siblings that O shows, too.
        overlay: what older siblings show that are finer than O; it lies over I'.
    """

    path: Sequence[Level]
    camera: Camera
    frame: LevelFrame
    image: FloatArray
    relief: FloatArray
    sky: BoolArray
    grid: Camera
    extended_share: float = 0.0
    coarse: FloatArray | None = None
    joined: tuple[Level, ...] = ()
    overlay: Overlay | None = None

    @property
    def is_extension(self) -> bool:
        """Whether the view is no closer than the parent's, so that there is no detail to add."""
        return self.camera.width < EXTENSION_FACTOR * self.relief.shape[1]


def observe(
    path: Sequence[Level],
    camera: Camera,
    seed: int = 0,
    check: Check = lambda: None,
    beside: Sequence[Level] = (),
) -> Observation:
    """Renders O_{i+1} and the target depth (lines 12 and 20).

    Args:
        path: the levels from the root to E_i.
        camera: C_{i+1}.
        seed: of the continuation, where there is one.
        check: called now and then; raises to cancel.
        beside: what the new level will lie over, see `worker.beside`.

    Raises:
        WorkerError: when next to nothing of the world is in view.
    """
    parent = path[-1]
    ratio = parent.camera.focal_px / camera.focal_px
    size = [max(MIN_SIDE_PX, round(s * ratio)) for s in (camera.width, camera.height)]
    small = camera.resampled(size[0], size[1])
    anchor_depth = float(camera.to_camera(parent.frame.origin)[2])
    anchor = (anchor_depth, parent.frame.unit)
    joined = _joined(beside, camera, small)
    parts = visible_parts(path, small)
    if joined:
        parts = [part for _, part in parts_among(path, joined, small, camera)]
    seen = render(parts, small, depth_anchor=anchor)
    relief = seen.relief.astype(np.float64)
    middle = _central_median(relief)
    frame = LevelFrame.of_camera(camera, anchor_depth + middle * parent.frame.unit)
    own = ((relief - middle) * (parent.frame.unit / frame.unit)).astype(np.float32)
    image = _filled(seen.color, seen.coverage)
    observation = Observation(path, camera, frame, image, own, _sky(path, relief, anchor), camera)
    sigma_px = PAD_SIGMA_PX if observation.is_extension else BACKDROP_SIGMA_PX
    continued = _continued(observation, _known(parts, small, seen.coverage, sigma_px), seed, check)
    if not beside:
        return _on_the_parents_pixels(continued, parts)
    continued = replace(continued, joined=tuple(joined))
    return _overlaid(_on_the_parents_pixels(continued, parts), beside)


def _joined(beside: Sequence[Level], camera: Camera, small: Camera) -> list[Level]:
    """Those siblings that O can show as they are: an extension is no finer than they are."""
    is_extension = camera.width < EXTENSION_FACTOR * small.width
    return list(beside) if is_extension else split(beside, camera)[0]


def _overlaid(seen: Observation, beside: Sequence[Level]) -> Observation:
    """Adds what siblings show that O is too coarse for."""
    if seen.is_extension:
        return seen
    return replace(seen, overlay=overlay_of(seen.path, beside, seen.camera, seen.frame))


def _on_the_parents_pixels(seen: Observation, parts: Sequence[LevelPart]) -> Observation:
    """Where there is detail to add to them: see `stage1_whole_pixels`."""
    parent = seen.path[-1].camera
    if seen.is_extension or seen.extended_share > 0 or seen.joined or not is_zoom(seen.camera, parent):
        return seen
    grid, pixels = whole_pixels(seen.camera, parent)
    image = seen.image
    if image.shape[:2] != (pixels[3], pixels[2]) or grid.key != seen.camera.key:
        shown = render(parts, grid.resampled(pixels[2], pixels[3]), depth=False)
        image = _filled(shown.color, shown.coverage)
    return replace(seen, grid=grid, image=on_whole_pixels(seen.path[-1].image, pixels, image))


def _known(parts: Sequence[LevelPart], camera: Camera, coverage: FloatArray, sigma_px: float) -> BoolArray:
    """Where a camera sees what a level really shows, (h, w): surfels that are not too large for it."""
    flags = [p.surfels.scales.min(axis=1) > sigma_px * p.surfels.native_scales for p in parts]
    if not any(flag.any() for flag in flags):
        return np.asarray(coverage > 0.5)
    marked = [
        replace(part, surfels=part.surfels.with_(colors=np.repeat(flag[:, None], 3, 1).astype(np.float32)))
        for part, flag in zip(parts, flags, strict=True)
    ]
    empty = render(marked, camera, depth=False).color[..., 0]
    return np.asarray((coverage > 0.5) & (empty < EMPTY_SHARE * coverage))


def _in_one_piece(known: BoolArray) -> BoolArray:
    """Closes specks and drops islands (h, w): scraps of what was painted around a frame are no source."""
    closed = cv2.morphologyEx(
        known.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((SPECK_PX, SPECK_PX), np.uint8)
    )
    _, labels, stats, _ = cv2.connectedComponentsWithStats(closed, connectivity=4)
    areas = stats[:, cv2.CC_STAT_AREA].copy()
    areas[0] = 0
    return np.asarray((areas >= ISLAND_SHARE * areas.max())[labels] & (closed > 0))


def _continued(seen: Observation, known: BoolArray, seed: int, check: Check) -> Observation:
    """Continues an observation over what no level shows: sky, ground and texture go on."""
    known = _in_one_piece(known & np.isfinite(seen.relief))
    share = 1.0 - float(known.mean())
    if share < EXTEND_SHARE_MIN:
        return seen
    if share > EXTEND_SHARE_MAX:
        raise WorkerError("new level", "next to nothing of the picture is in view to continue from")
    axis = DepthAxis.of(seen.camera)
    relief = np.where(known, seen.relief, np.float32(0))
    surface = extended(Surface(seen.image, axis.shift_of(relief), relief, seen.sky), known, axis, seed, check)
    return replace(seen, image=surface.image, relief=surface.relief, sky=surface.sky, extended_share=share)


def _central_median(relief: FloatArray | Any) -> float:  # noqa: ANN401
    h, w = relief.shape
    middle = relief[h // 4 : h - h // 4, w // 4 : w - w // 4]
    values = middle[np.isfinite(middle)]
    if not len(values):
        values = relief[np.isfinite(relief)]
    return float(np.median(values)) if len(values) else 0.0


def _filled(color: FloatArray, coverage: FloatArray) -> FloatArray:
    """Holes of an observation are filled from their surroundings: push-pull over a pyramid."""
    # Where half is covered, the gaps between surfels are no holes: colour relative to coverage.
    weight = np.clip(2.0 * coverage, 0.0, 1.0)[..., None].astype(np.float32)
    filled = (color / np.maximum(coverage, 0.5)[..., None]).astype(np.float32)
    levels = []
    while min(filled.shape[:2]) > 2:
        levels.append((filled, weight))
        half = (max(1, filled.shape[1] // 2), max(1, filled.shape[0] // 2))
        filled = cv2.resize(filled, half, interpolation=cv2.INTER_AREA)
        weight = cv2.resize(weight, half, interpolation=cv2.INTER_AREA)[..., None]
    result = filled / np.maximum(weight, np.float32(1e-4))
    for fine, fine_weight in reversed(levels):
        size = (fine.shape[1], fine.shape[0])
        below = cv2.resize(result, size, interpolation=cv2.INTER_LINEAR)
        result = fine + (1.0 - fine_weight) * below
    return np.clip(result, 0.0, 1.0).astype(np.float32)


def _sky(path: Sequence[Level], relief: Any, anchor: tuple[float, float]) -> BoolArray:  # noqa: ANN401
    root = path[0]
    sky = root.maps.get("sky")
    if sky is None or not np.any(sky):
        return np.zeros(relief.shape, bool)
    sky_depth = float(np.nanmedian(root.depth[sky.astype(bool)]))
    depth = anchor[0] + relief * anchor[1]
    return np.asarray(np.nan_to_num(depth) > SKY_RELIEF_SHARE * sky_depth)


def preview_image(seen: Observation, models: Synthesizer, seed: int) -> Draft:
    """A first, quick I': seen within a second, replaced later."""
    width, height = seen.grid.width, seen.grid.height
    if seen.is_extension or PLAIN_UP_TO * seen.image.shape[1] >= width:
        image = _resized(seen.image, width, height)
    else:
        context, region = _context(seen)
        image = models.detail.preview(seen.image, width, height, context, region, seed, len(seen.path))
    return _with_siblings(_draft(seen, cut(image, seen.grid, seen.camera)))


def preview_edit(draft: Draft, edit: Edit, models: Synthesizer, seed: int, check: Check) -> Draft:
    """The quick I' with what the prompt asks for, softer than it will be, at the place where it will be."""
    result = models.editor.preview(edit, draft.image, _support(draft), seed, check)
    relief = np.where(result.object_mask, result.object_relief, draft.relief)
    return replace(draft, image=result.image, relief=relief.astype(np.float32))


def upscale_image(seen: Observation, models: Synthesizer, seed: int, check: Check) -> Draft:
    """I' = SR(O, S) (lines 13 and 14); an extension is no closer, so that O is what it shows."""
    width, height = seen.grid.width, seen.grid.height
    if seen.is_extension:
        image = _resized(seen.image, width, height)
        notes = {"extended_share": seen.extended_share}
        own = models.detail.describe(image, None, None)
        return replace(_draft(seen, image), context=own, notes=notes)
    context, region = _context(seen)
    shared = (context, region, len(seen.path), seed)
    detail = models.detail.upscale(seen.image, width, height, *shared, check=check)
    detail = _cut(_as_the_parent_has_it(detail, seen), seen)
    own = models.detail.describe(detail.image, context, detail)
    extra = {"relief_texture": detail.relief_texture, "observation": seen}
    notes = {"consistency_db": float(detail.consistency_db)}
    return _with_siblings(replace(_draft(seen, detail.image), context=own, extra=extra, notes=notes))


def _with_siblings(draft: Draft) -> Draft:
    """Lays what siblings show over I'; what is clearly not the ground has its own depth."""
    overlay = draft.extra["observation"].overlay
    if overlay is None:
        return draft
    stands, image = overlay.standing(draft.relief), overlay.over(draft.image)
    unshaded = np.where(grown(stands, STEP_REACH_PX)[..., None], image, draft.image)
    extra = {**draft.extra, "bare": draft, "unshaded": unshaded}
    if (texture := extra.get("relief_texture")) is not None:  # that of a picture which is not seen there
        extra["relief_texture"] = texture * (1 - overlay.cover)
    extra |= {"shown": np.fmin(overlay.relief, draft.relief), "stands": stands}
    relief = np.where(stands, overlay.relief, draft.relief)
    return replace(draft, image=image, relief=relief, sky=draft.sky & ~stands, extra=extra)


def _as_the_parent_has_it(detail: Detail, seen: Observation) -> Detail:
    """Returns what shrinks to the parent's pixels, too.

    Where six new ones are one of the photograph's and eight one of the parent's, those do not say what these
    are.
    """
    if seen.coarse is None:
        return detail
    grey = np.float32(255)
    known = seen.coarse * grey
    image = brought_near(detail.image * grey, known, PARENT_DB)
    return replace(detail, image=image / grey, consistency_db=consistency_db(image, known))


def _cut(detail: Detail, seen: Observation) -> Detail:
    planes = (detail.image, detail.relief_texture, detail.labels)
    image, relief, labels = (cut(plane, seen.grid, seen.camera) for plane in planes)
    return replace(detail, image=image, relief_texture=relief, labels=labels)


def _resized(image: FloatArray, width: int, height: int) -> FloatArray:
    if image.shape[:2] == (height, width):
        return image
    return np.clip(cv2.resize(image, (width, height), interpolation=cv2.INTER_CUBIC), 0.0, 1.0)


def edit_image(draft: Draft, edit: Edit, models: Synthesizer, seed: int, check: Check) -> Draft:
    """I = Edit(I', U) (lines 15-19); objects of coarser levels, and of siblings, are drawn again."""
    support = _support(draft)
    draft = drawn_again(draft, models, support, seed, check)
    if not edit:
        return draft
    shared = (edit, draft.image, support, seed)
    result = models.editor.apply(*shared, check=check, ground=draft.ground, older=covered_share(draft))
    placements = [placement.to_dict() for placement in result.placements]
    if not edit.changes:  # an object's shadow, read as shading, would hollow out its ground
        unshaded = draft.image if draft.ground is None else draft.ground
        draft = replace(draft, extra={"unshaded": unshaded, **draft.extra})
    draft = with_objects(draft, result)
    notes = {**draft.notes, "placements": placements}
    if result.places:
        notes["places"] = list(result.places)
    if any(request.pixels is not None for request in edit.objects):
        notes["cutout"] = True
    return replace(draft, notes=notes)


def _support(draft: Draft) -> Support:
    """What objects stand on: the target depth, with the rays and the size in metres of the view."""
    camera = draft.camera
    ray = ((camera.width / 2 - camera.cx) / camera.fx, (camera.height / 2 - camera.cy) / camera.fy)
    metres = metres_of(draft.path[0], camera, draft.frame, draft.relief, draft.sky)
    relief = draft.extra.get("shown", draft.relief)
    return Support(relief, camera.focal_px, *ray, sky=draft.sky, metres_per_px=metres)


def _context(seen: Observation) -> tuple[Context, tuple[float, float, float, float]]:
    """S: what stage 1 of the parent knew, and where in its image the new view lies."""
    parent = seen.path[-1]
    view = AnchoredView.expand(parent.camera, seen.frame)
    w, h = seen.camera.width, seen.camera.height
    corners = np.array([[-w / 2, -h / 2, 0], [w / 2, h / 2, 0]], np.float32)
    low, high = view.project(corners)
    if seen.grid is not seen.camera:
        left, top, columns, rows = whole_pixels(seen.camera, parent.camera)[1]
        low, high = np.array([left, top], np.float32), np.array([left + columns, top + rows], np.float32)
    size = np.array([parent.camera.width, parent.camera.height], np.float32)
    low, high = low / size, high / size
    return context_of(parent), (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def _draft(seen: Observation, image: FloatArray) -> Draft:
    size = (seen.camera.width, seen.camera.height)
    sky = cv2.resize(seen.sky.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST).astype(bool)
    relief = _enlarged(seen.relief, size)
    return Draft(seen.camera, seen.frame, seen.path, image, relief, sky, extra={"observation": seen})


def _enlarged(relief: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Smooth enlargement of a target depth; nan where it is undefined."""
    known = np.isfinite(relief)
    fallback = np.float32(np.median(relief[known])) if known.any() else np.float32(0.0)
    large = cv2.resize(np.where(known, relief, fallback), size, interpolation=cv2.INTER_LINEAR)
    mask = cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_LINEAR) > 0.5
    return np.where(mask, large, np.float32(np.nan)).astype(np.float32)
