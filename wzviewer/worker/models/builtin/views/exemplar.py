"""Depth-aware exemplar fill: holes are painted with patches of the picture from the right depth.

A greedy onion (Criminisi, Perez, Toyama 2004, without their priority) with the candidate search of
PatchMatch (Barnes et al. 2009): continue what a filled neighbour copied, try random places of the
right depth and near the rim, then refine.  The same fill at a quarter of the size guides the large
shapes.

The order of the patches depends on the mask alone, so it is planned first; patches that do not
touch one another run in parallel, and the result is the same for any number of threads.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.views.exemplar_kernels import (
    Aims,
    Places,
    Planes,
    Search,
    paint,
    plan_centres,
    plan_waves,
)
from wzviewer.worker.models.builtin.views.smoothing import push_pull

GUIDE_STEP_PX = 4
DEPTH_RANGE = 0.2  # largest spread of log depth inside a source patch
LIST_LIMIT = 300_000
WAVES_PER_CHECK = 24


@dataclass(frozen=True)
class FillRule:
    """How candidates are found and judged; costs are squared grey levels (0..255).

    Attributes:
        radius_px: patches have side 2 r + 1.
        coherent: candidates that continue a neighbour's copy.
        scattered: random candidates, half by depth, half around the rim.
        refined: local refinements of the best.
        depth_cost: per unit of |log depth difference|.
        row_cost: per px of height difference from the rim.
        rim_cost: per px of distance from the rim, up to 200.
        guide_cost: weight of the coarse fill.
    """

    radius_px: int = 6
    coherent: int = 24
    scattered: int = 88
    refined: int = 24
    depth_cost: float = 300.0
    row_cost: float = 0.3
    rim_cost: float = 0.25
    guide_cost: float = 0.6

    def coarse(self) -> "FillRule":
        """Returns the rule of the guide, at a quarter of the size."""
        return replace(self, radius_px=max(3, self.radius_px - 2), scattered=72, row_cost=0.8, rim_cost=1.0)


@dataclass(frozen=True)
class FillTask:
    """What is to be painted and from what.

    Attributes:
        picture: (h, w, 3) float32 in [0, 1]; colours around the hole, read where ``known``.
        known: (h, w) bool, context: pixels that a patch must fit to; never the foreground.
        target: (h, w) bool, pixels to paint.
        source: (h, w, 3) float32 in [0, 1], the original picture.
        usable: (h, w) bool, where the source is real.
        source_log: (h, w) float32, log depth coordinate of the source.
        target_log: (h, w) float32, of what is to be painted.
        origin: (h, w, 2) int32, row and column of the rim that each target continues.
    """

    picture: FloatArray
    known: BoolArray
    target: BoolArray
    source: FloatArray
    usable: BoolArray
    source_log: FloatArray
    target_log: FloatArray
    origin: IntArray


def fill(
    task: FillTask, rule: FillRule, seed: int, check: Callable[[], None] | None = None
) -> tuple[FloatArray, IntArray]:
    """Paints the targets.

    Returns:
        (h, w, 3) float32 the painted picture (only targets differ from ``task.picture``), and
        (h, w, 2) int32 the source row and column of each painted pixel, -1 elsewhere.
    """
    step = GUIDE_STEP_PX
    guide = None
    if rule.guide_cost > 0 and min(task.known.shape) > 16 * step:
        guide = _fill_once(_shrunk(task, step), rule.coarse(), seed + 1, check, None)[0]
    return _fill_once(task, rule, seed, check, guide)


def _fill_once(
    task: FillTask, rule: FillRule, seed: int, check: Callable[[], None] | None, guide: FloatArray | None
) -> tuple[FloatArray, IntArray]:
    """Paints at one size; ``guide`` is the result at a quarter of it."""
    height, width = task.known.shape
    centres = _centres(task, rule.radius_px)
    places = _source_places(task, rule.radius_px)
    if not len(centres) or not len(places.listed):
        return _soft_fill(task), np.full((height, width, 2), -1, np.int32)
    order, starts = plan_waves(centres, height, width, rule.radius_px)
    planes = _planes(task, guide)
    aims = Aims(task.source_log, task.target_log, task.origin)
    search = Search(
        rule.radius_px, rule.coherent, rule.scattered, rule.refined, seed,
        rule.depth_cost, rule.row_cost, rule.rim_cost, rule.guide_cost if guide is not None else 0.0,
    )  # fmt: skip
    for first in range(0, len(starts) - 1, WAVES_PER_CHECK):
        if check is not None:
            check()
        paint(planes, aims, places, search, centres[order], starts[first : first + WAVES_PER_CHECK + 1])
    painted = np.where(task.target[..., None], planes.picture / np.float32(255.0), task.picture)
    return painted, planes.copied_from


def _planes(task: FillTask, guide: FloatArray | None) -> Planes:
    """Returns the working pictures; without a guide its two are single pixels."""
    picture = np.ascontiguousarray(task.picture * np.float32(255.0))
    source = np.ascontiguousarray(task.source * np.float32(255.0))
    state = np.where(task.target, 2, np.where(task.known, 1, 0)).astype(np.uint8)
    copied_from = np.full((*state.shape, 2), -1, np.int32)
    coarse = coarse_source = np.zeros((1, 1, 3), np.float32)
    if guide is not None:
        coarse = np.ascontiguousarray(guide * np.float32(255.0))
        size = (guide.shape[1], guide.shape[0])
        coarse_source = np.asarray(cv2.resize(source, size, interpolation=cv2.INTER_AREA), np.float32)
    weight = np.zeros(state.shape, np.float32)
    return Planes(picture, state, copied_from, source, coarse, coarse_source, weight)


def _centres(task: FillTask, radius_px: int) -> IntArray:
    """Returns patch centres (n, 2): outside in, in thin rings of scattered order."""
    distance = cv2.distanceTransform((~task.known).astype(np.uint8), cv2.DIST_L2, 3)
    distance = np.minimum(distance, np.float32(sum(distance.shape)))  # endless where nothing is known
    rows, columns = np.nonzero(task.target)
    ring = (distance[rows, columns] / max(1.0, radius_px / 2)).astype(np.int64)
    scatter = (rows * 73856093 ^ columns * 19349663) * 2654435761 % (1 << 20)
    return plan_centres(_in_order(ring * (1 << 20) + scatter, rows, columns), task.target, radius_px)


def _in_order(keys: NDArray[Any], rows: NDArray[Any], columns: NDArray[Any]) -> IntArray:
    """Returns pixels (n, 2) int32 by ascending key (n,) of 32 bits; equal ones stay in their order."""
    packed = keys.astype(np.uint64) << np.uint64(32) | np.arange(len(keys), dtype=np.uint64)
    order = np.sort(packed) & np.uint64(0xFFFFFFFF)  # a third of the time of argsort
    return np.stack([rows[order], columns[order]], axis=-1).astype(np.int32)


def _sortable(values: FloatArray) -> NDArray[np.uint32]:
    """Returns integers (n,) in the order of floats (n,): the sign of IEEE 754 turned round."""
    bits = np.ascontiguousarray(values, np.float32).view(np.uint32)
    top = np.uint32(1 << 31)
    return np.where(bits & top, ~bits, bits | top)


def _source_places(task: FillTask, radius_px: int) -> Places:
    """Returns where source patches may be centred."""
    window = np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)
    inside = cv2.erode(task.usable.astype(np.uint8), window, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    spread = cv2.dilate(task.source_log, window) - cv2.erode(task.source_log, window)
    allowed = (inside > 0) & (spread < DEPTH_RANGE)
    if not allowed.any():
        allowed = inside > 0
    rows, columns = np.nonzero(allowed)
    thin = max(1, len(rows) // LIST_LIMIT)
    rows, columns = rows[::thin], columns[::thin]
    listed = _in_order(_sortable(task.source_log[rows, columns]), rows, columns)
    return Places(allowed, listed, task.source_log[listed[:, 0], listed[:, 1]])


def _shrunk(task: FillTask, step: int) -> FillTask:
    """Returns the task at 1/step of its size; known pixels are averaged among themselves."""
    height, width = task.known.shape
    size = (max(1, width // step), max(1, height // step))

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float32)

    def mean_where(values: FloatArray, mask: BoolArray) -> tuple[FloatArray, FloatArray]:
        weight = mask.astype(np.float32)
        share = mean(weight)
        flat = values.ndim == 2
        total = mean(values * (weight if flat else weight[..., None]))
        return np.asarray(total / np.maximum(share if flat else share[..., None], 1e-6), np.float32), share

    picture, known = mean_where(task.picture, task.known)
    target_log, target = mean_where(task.target_log, task.target)
    at = np.minimum((np.arange(size[1]) + 0.5) * height / size[1], height - 1).astype(int)
    along = np.minimum((np.arange(size[0]) + 0.5) * width / size[0], width - 1).astype(int)
    origin = task.origin[at][:, along] // step
    np.minimum(origin, np.array([size[1] - 1, size[0] - 1]), out=origin)
    painted = (target > 0) & (known < 0.5)
    return FillTask(
        picture=np.where((known > 0)[..., None], picture, 0).astype(np.float32, copy=False),
        known=(known > 0.25) & ~painted,
        target=painted,
        source=mean(task.source),
        usable=mean(task.usable.astype(np.float32)) > 0.99,
        source_log=np.ascontiguousarray(task.source_log[at][:, along]),
        target_log=target_log.astype(np.float32, copy=False),
        origin=np.ascontiguousarray(origin.astype(np.int32)),
    )


def _soft_fill(task: FillTask) -> FloatArray:
    """The fallback without any usable source patch: the surroundings, blurred in."""
    smooth = push_pull(task.picture, task.known.astype(np.float32))
    return np.where(task.target[..., None], smooth, task.picture).astype(np.float32, copy=False)
