"""The sides of inserted objects that a level's own camera does not see, as surfels behind what it sees.

A picture knows only the front of a beetle: from beside it there would be a gap between head and neck.
The body itself is known all around (`models.base.ImageEditor.sides`).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift_points
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.models.builtin.objects.editor import Placement, Side
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.stages.stage1_new_scale_image import mapping_of

SIGMA_PX = 0.65  # of the view that saw a point: as sharp as it may be and closed
_INSIDE = 0.5  # sRGB, of the colour that a body has outside
_NEAR_PX = 48.0  # native px: what is farther from every known side has its colours no more

Check = Callable[[], None]


def with_sides(draft: Draft, models: Synthesizer, check: Check) -> Draft:
    """Returns a draft that shows its objects from beside them, too; in a body there is nothing else.

    What the search for exemplars and coarser levels put there would be seen through gaps of the front.

    Args:
        draft: with image, final relief, layers and hidden surfels, and `object_mask` where it shows objects.
        models: the editor knows the bodies.
        check: raises when the request was cancelled.
    """
    mask = draft.extra.get("object_mask")
    if mask is None or not mask.any():
        return draft
    placed = [*_inherited(draft), *((p, (0.0, 0.0, 1.0)) for p in _records(draft.notes))]
    side = models.editor.sides(placed, draft.image, draft.relief, mask, draft.camera.focal_px, check)
    layers = tuple(_painted(layer, draft.image, side) for layer in draft.layers)
    hidden = draft.hidden.take(~_is_inside(draft.hidden, draft, side.back))
    return replace(draft, layers=layers, hidden=Surfels.concatenate([hidden, _lifted(side, draft.camera)]))


def _painted(layer: Layer, image: FloatArray, side: Side) -> Layer:
    """Returns a layer in which bodies have the colours of their sides, and a dark inside far from those.

    Where a gap of the front is closed by no side, the layer behind its edge is; in a body it is the body's.
    """
    h, w = side.back.shape
    rows, columns = (np.arange(n) * layer.stride + layer.stride // 2 for n in layer.mask.shape)
    rows, columns = rows + layer.offset_px[1], columns + layer.offset_px[0]
    at = np.ix_(np.clip(rows, 0, h - 1), np.clip(columns, 0, w - 1))
    within = ((rows >= 0) & (rows < h))[:, None] & ((columns >= 0) & (columns < w))
    y, x = np.nonzero(layer.mask & within & (layer.relief < side.back[at]))
    if not len(x):
        return layer
    points = np.stack([columns[x], rows[y], layer.relief[y, x]], 1)
    known = np.column_stack([side.places, side.relief])
    distance, nearest = cKDTree(known).query(points, distance_upper_bound=_NEAR_PX)
    colors = np.concatenate([side.colors, np.zeros((1, 3), np.float32)])[nearest]
    colored = layer.image.copy()
    colored[y, x] = np.where(np.isfinite(distance)[:, None], colors, _INSIDE * image[at][y, x])
    return replace(layer, image=colored)


def _is_inside(surfels: Surfels, draft: Draft, back: FloatArray) -> BoolArray:
    """Tells which surfels (n,) lie in bodies that end at `back` (h, w)."""
    h, w = back.shape
    column, row = np.floor(AnchoredView.expand(draft.camera, draft.frame).project(surfels.means)).T
    at = np.clip(row, 0, h - 1).astype(np.int64), np.clip(column, 0, w - 1).astype(np.int64)
    return np.asarray(surfels.means[:, 2] < back[at])


def _inherited(draft: Draft) -> list[tuple[Placement, tuple[float, float, float]]]:
    return [
        (placed, mapping_of(level.camera, draft.camera))
        for level in draft.path
        for placed in _records(level.notes)
    ]


def _records(notes: dict[str, Any]) -> list[Placement]:
    return [Placement.from_dict(record) for record in notes.get("placements") or []]


def _lifted(side: Side, camera: Camera) -> Surfels:
    return lift_points(side.places, side.relief, side.tangents, side.colors, camera, SIGMA_PX)
