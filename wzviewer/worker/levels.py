"""Drafts become levels: pixel-aligned surfels, coverage, and what is kept for finer levels."""

from dataclasses import asdict, replace
from typing import Any

import cv2
import numpy as np

from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.kernels.lifting import lift
from wzviewer.worker.draft import Draft, coverage_of
from wzviewer.worker.inherited import hidden_surfels
from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
from wzviewer.worker.standing import flank_surfels, front_surfels, seen_relief

PREVIEW_STRIDE = 2  # a preview has every second pixel each way: a quarter of the surfels


def as_level(
    draft: Draft, index: int, parent: int | None, prompt: str, seed: int, surfels: Surfels | None = None
) -> Level:
    """Returns a draft as a level.

    Args:
        draft: with image and finite relief.
        index: of the level.
        parent: of the level; None for E_0.
        prompt: U.
        seed: of the level.
        surfels: optimised ones; by default they are lifted from the draft.
    """
    if surfels is None:
        surfels = Surfels.concatenate([front_surfels(draft).surfels, *layer_surfels(draft)])
    coverage = coverage_of(draft.path, draft.camera, draft.frame, surfels.means)
    maps, notes = _kept(draft)
    return Level(
        index=index,
        parent=parent,
        camera=draft.camera,
        frame=draft.frame,
        surfels=surfels.with_(coverage=coverage),
        image=to_bytes(draft.image),
        relief=seen_relief(draft),
        prompt=prompt,
        seed=seed,
        maps=maps,
        notes=notes,
    )


def layer_surfels(draft: Draft) -> list[Surfels]:
    """Lifts the background layers of stage 4; a layer of stride k has surfels k times as large."""
    layers = (_layer_surfels(layer, draft) for layer in draft.layers)
    return [*layers, draft.hidden, *flank_surfels(draft)]


def _layer_surfels(layer: Layer, draft: Draft) -> Surfels:
    stride, camera = layer.stride, draft.camera
    if stride == 1:
        return lift(layer.image, layer.relief, camera, layer.mask, layer.sigma_px, offset_px=layer.offset_px)
    coarse = camera.resampled(camera.width // stride, camera.height // stride)
    x = np.float32(coarse.width / camera.width)
    offset = (layer.offset_px[0] // stride, layer.offset_px[1] // stride)
    surfels = lift(layer.image, layer.relief * x, coarse, layer.mask, layer.sigma_px, offset_px=offset)
    return surfels.with_(means=surfels.means / x, scales=surfels.scales / x)


def preview_level(draft: Draft, index: int, parent: int | None, prompt: str, seed: int) -> Level:
    """Returns a draft as a level of fewer and larger surfels, for the first look.

    What coarser levels hold behind it comes with it: it closes the gaps beside edges, also at a first glance
    from the side.
    """
    width, height = draft.camera.width // PREVIEW_STRIDE, draft.camera.height // PREVIEW_STRIDE
    x = width / draft.camera.width
    coarse_camera = draft.camera.resampled(width, height)
    relief = finite_relief(draft.relief)
    image = cv2.resize(draft.image, (width, height), interpolation=cv2.INTER_AREA)
    relief_coarse = cv2.resize(relief, (width, height), interpolation=cv2.INTER_NEAREST) * np.float32(x)
    coarse = generate_surfels(image, relief_coarse, coarse_camera)
    enlarged = {"means": coarse.means / np.float32(x), "scales": coarse.scales / np.float32(x)}
    draft = replace(draft, relief=relief)
    surfels = coarse.with_(**enlarged)
    if (observation := draft.extra.get("observation")) is not None:
        surfels = Surfels.concatenate([surfels, hidden_surfels(draft, observation.relief)])
    return as_level(draft, index, parent, prompt, seed, surfels)


def finite_relief(relief: FloatArray) -> FloatArray:
    """Returns a relief (h, w) in which undefined pixels have the median depth."""
    known = np.isfinite(relief)
    fallback = np.float32(np.median(relief[known])) if known.any() else np.float32(0.0)
    return np.where(known, relief, fallback).astype(np.float32)


def to_bytes(image: FloatArray) -> ByteArray:
    """Rounds an image in [0, 1] to uint8."""
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def _kept(draft: Draft) -> tuple[dict[str, Any], dict[str, Any]]:
    maps: dict[str, Any] = {"sky": draft.sky.astype(np.uint8)}
    notes = dict(draft.notes)
    if draft.context is not None:
        labels, notes["context"] = context_record(draft.context)
        maps["labels"] = labels
    return maps, notes


def context_record(context: Context) -> tuple[ByteArray, dict[str, Any]]:
    """Takes a description apart into its label map and a JSON-able record."""
    regions = [asdict(region) for region in context.regions]
    record = {"materials": list(context.materials), "regions": regions, "words": context.words}
    return context.labels, {**record, "level": context.level}


def context_of(level: Level) -> Context:
    """Restores the description S that a level keeps.

    Raises:
        ValueError: when the level has none.
    """
    record, labels = level.notes.get("context"), level.maps.get("labels")
    if not isinstance(record, dict) or labels is None:
        raise ValueError(f"level {level.index} holds no description")
    regions = tuple(Region(**{k: float(v) for k, v in r.items()}) for r in record["regions"])
    materials = tuple(str(name) for name in record["materials"])
    clipped = np.minimum(labels, len(materials) - 1).astype(np.uint8)
    return Context(clipped, materials, regions, str(record["words"]), int(record["level"]))


def sky_of(draft: Draft) -> BoolArray | None:
    """The sky mask of a draft, or None when it has none."""
    return draft.sky if draft.sky.any() else None
