"""Stages 2, 4 and 5 applied to a draft: what each stage's function needs is taken from it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray
from wzviewer.worker.draft import Draft
from wzviewer.worker.inherited import hidden_surfels
from wzviewer.worker.levels import finite_relief, layer_surfels, sky_of
from wzviewer.worker.lining import with_lining
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.stages.stage2_depth_registration import register
from wzviewer.worker.stages.stage4_auxiliary_views import synthesize_auxiliary_views, warp_view
from wzviewer.worker.stages.stage5_optimization import ROOT_STEPS, STEPS, TargetView, optimize
from wzviewer.worker.standing import (
    OPAQUE,
    front_surfels,
    ground_target,
    in_sight,
    part_layers,
    settled,
)

Check = Callable[[], None]


def register_depth(draft: Draft, models: Synthesizer, seed: int, check: Check) -> Draft:
    """Stage 2: D_{i+1} agrees with the coarser level (lines 21, 22; Eq. 5)."""
    focal_px = draft.camera.focal_px
    image = draft.extra.get("unshaded", draft.image if draft.ground is None else draft.ground)
    reading = models.depth.read(image)
    check()
    registration = register(
        image,
        parallax_of(draft.relief, focal_px),
        reading.disparity,
        focal_px=focal_px,
        relief_texture=draft.extra.get("relief_texture"),
        sky=sky_of(draft),
        seed=seed,
        check=check,
    )
    relief = relief_of(registration.parallax, focal_px)
    notes = {**draft.notes, "registration": registration.report}
    return settled(replace(draft, relief=relief, notes=notes))


def parallax_of(relief: FloatArray, focal_px: float) -> FloatArray:
    """Q = -delta / (1 + delta / f): relief to what is affine in inverse depth, both in native px."""
    return (-relief / (np.float32(1.0) + relief / np.float32(focal_px))).astype(np.float32)


def relief_of(parallax: FloatArray, focal_px: float) -> FloatArray:
    """The inverse of `parallax_of`."""
    return (-parallax / (np.float32(1.0) + parallax / np.float32(focal_px))).astype(np.float32)


def complete_scene(draft: Draft, models: Synthesizer, seed: int, check: Check, outside: bool) -> Draft:
    """Stage 4: what neighbouring cameras see behind edges and beside the frame (lines 26-28)."""
    relief = finite_relief(draft.relief)
    image = draft.image if draft.ground is None else draft.ground
    depth = float(draft.camera.to_camera(draft.frame.origin)[2])
    views = synthesize_auxiliary_views(
        image, relief, sky_of(draft), draft.camera, depth, outside, models.views, seed=seed, check=check
    )
    check()
    extra = {**draft.extra, "neighbours": views.cameras}
    draft = settled(replace(draft, relief=views.relief, layers=views.layers, extra=extra))
    if draft.parts:
        draft = replace(draft, layers=tuple(in_sight(layer, draft) for layer in draft.layers))
    if draft.path:
        draft = replace(draft, hidden=hidden_surfels(draft, draft.extra["observation"].relief))
    return with_lining(draft)


def optimize_level(draft: Draft, check: Check) -> Surfels:
    """Stage 5: q, s and o of what is seen at C; what is hidden there stays as lifted (lines 29-31)."""
    front = front_surfels(draft)
    ground = ground_target(draft)
    views = []
    for camera in draft.extra["neighbours"][:2]:
        target, known = warp_view(ground, draft.relief, part_layers(draft, OPAQUE), draft.camera, camera)
        clear = target.min(-1) >= -1e-3  # what is seen through an object, or buried in it, is no target
        views.append(TargetView(camera, np.maximum(target, 0), known & clear))
        check()
    steps = STEPS if draft.path else ROOT_STEPS
    shared = (draft.image, draft.camera, draft.frame, views, steps)
    if not draft.parts:
        surfels = optimize(front.surfels, *shared, on_step=lambda *_: check())
        return Surfels.concatenate([surfels, *layer_surfels(draft)])
    buried, seen = front.surfels.take(front.buried), front.surfels.take(~front.buried)
    kept = front.kept[~front.buried]
    seen = optimize(seen, *shared, on_step=lambda *_: check(), kept=kept, hidden=buried)
    return Surfels.concatenate([seen, buried, *layer_surfels(draft)])
