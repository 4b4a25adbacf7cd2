"""Stages 2, 4 and 5 applied to a draft: what each stage's function needs is taken from it."""

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.draft import Draft
from wzviewer.worker.inherited import hidden_surfels
from wzviewer.worker.levels import finite_relief, layer_surfels, sky_of
from wzviewer.worker.lining import with_lining
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.rasterize import LevelPart, render
from wzviewer.worker.stages.stage2_depth_registration import register
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
from wzviewer.worker.stages.stage4_auxiliary_views import synthesize_auxiliary_views, warp_view
from wzviewer.worker.stages.stage5_optimization import ROOT_STEPS, STEPS, TargetView, optimize

COVERED = 0.6  # of a pixel by hidden surfels, for its colour to be known
FRINGE_PX = 9  # around an object: its outline is mixed with what is behind

Check = Callable[[], None]


def register_depth(draft: Draft, models: Synthesizer, seed: int, check: Check) -> Draft:
    """Stage 2: D_{i+1} agrees with the coarser level (lines 21, 22; Eq. 5)."""
    focal_px = draft.camera.focal_px
    reading = models.depth.read(draft.image)
    check()
    registration = register(
        draft.image,
        parallax_of(draft.relief, focal_px),
        reading.disparity,
        focal_px=focal_px,
        object_relief=draft.extra.get("object_relief"),
        object_mask=draft.extra.get("object_mask"),
        relief_texture=draft.extra.get("relief_texture"),
        sky=sky_of(draft),
        seed=seed,
        check=check,
    )
    relief = relief_of(registration.parallax, focal_px)
    return replace(draft, relief=relief, notes={**draft.notes, "registration": registration.report})


def parallax_of(relief: FloatArray, focal_px: float) -> FloatArray:
    """Q = -delta / (1 + delta / f): relief to what is affine in inverse depth, both in native px."""
    return (-relief / (np.float32(1.0) + relief / np.float32(focal_px))).astype(np.float32)


def relief_of(parallax: FloatArray, focal_px: float) -> FloatArray:
    """The inverse of `parallax_of`."""
    return (-parallax / (np.float32(1.0) + parallax / np.float32(focal_px))).astype(np.float32)


def complete_scene(draft: Draft, models: Synthesizer, seed: int, check: Check, outside: bool) -> Draft:
    """Stage 4: what neighbouring cameras see behind edges and beside the frame (lines 26-28)."""
    relief = finite_relief(draft.relief)
    depth = float(draft.camera.to_camera(draft.frame.origin)[2])
    views = synthesize_auxiliary_views(
        draft.image, relief, sky_of(draft), draft.camera, depth, outside, models.views, seed=seed, check=check
    )
    check()
    extra = {**draft.extra, "neighbours": views.cameras}
    draft = replace(draft, relief=views.relief, layers=before_objects(draft, views.layers), extra=extra)
    if not draft.path:
        return with_lining(draft)
    draft = replace(draft, hidden=hidden_surfels(draft, draft.extra["observation"].relief))
    return with_lining(replace(draft, layers=behind_redrawn(draft)))


def behind_redrawn(draft: Draft) -> tuple[Layer, ...]:
    """Returns a draft's layers that show, behind objects drawn again, what coarser levels have behind them.

    They kept there the picture before the object (`before_objects`); the search for exemplars would not.
    """
    objects = draft.extra.get("redrawn_objects")
    if objects is None or not len(draft.hidden) or not draft.layers:
        return draft.layers
    h, w = draft.extra["observation"].relief.shape
    seen = render([LevelPart.of(draft.hidden, draft.frame)], draft.camera.resampled(w, h), depth=False)
    color = seen.color / np.maximum(seen.coverage, COVERED)[..., None]
    size = (draft.camera.width, draft.camera.height)
    image = np.clip(cv2.resize(color, size, interpolation=cv2.INTER_CUBIC), 0, 1).astype(np.float32)
    covered = cv2.resize(seen.coverage, size, interpolation=cv2.INTER_LINEAR) >= COVERED
    inside = cv2.dilate(objects.astype(np.uint8), np.ones((FRINGE_PX, FRINGE_PX), np.uint8)) > 0
    return tuple(_painted(layer, image, inside & covered) for layer in draft.layers)


def before_objects(draft: Draft, layers: tuple[Layer, ...]) -> tuple[Layer, ...]:
    """Returns layers of stage 4 that show, behind new objects, the picture as it was before them.

    Without it the search for exemplars may find the object's own picture: its twin behind it.
    """
    if "behind_objects" not in draft.extra:
        return layers
    inside = cv2.dilate(
        draft.extra["new_objects"].astype(np.uint8), np.ones((FRINGE_PX, FRINGE_PX), np.uint8)
    )
    return tuple(_painted(layer, draft.extra["behind_objects"], inside > 0) for layer in layers)


def _painted(layer: Layer, image: FloatArray, inside: BoolArray) -> Layer:
    """Returns a layer with an image's colours where `inside` (h, w) says so."""
    h, w = inside.shape
    rows, columns = (np.arange(n) * layer.stride + layer.stride // 2 for n in layer.mask.shape)
    rows, columns = (
        np.clip(rows + layer.offset_px[1], 0, h - 1),
        np.clip(columns + layer.offset_px[0], 0, w - 1),
    )
    at = np.ix_(rows, columns)
    return replace(layer, image=np.where(inside[at][..., None], image[at], layer.image))


def optimize_level(draft: Draft, check: Check) -> Surfels:
    """Stage 5: q, s and o of the front surfels; the layers behind it stay as lifted (lines 29-31)."""
    front = generate_surfels(draft.image, draft.relief, draft.camera)
    views = []
    for camera in draft.extra["neighbours"][:2]:
        target, known = warp_view(draft.image, draft.relief, (), draft.camera, camera)
        views.append(TargetView(camera, target, known))
        check()
    steps = STEPS if draft.path else ROOT_STEPS
    front = optimize(front, draft.image, draft.camera, draft.frame, views, steps, on_step=lambda *_: check())
    return Surfels.concatenate([front, *layer_surfels(draft)])
