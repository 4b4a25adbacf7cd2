"""Algorithm 1, lines 20-22: the new image's depth, made one with the coarse geometry (Eq. 5).

    estimate, target -> fixed effects (a, one b per segment) -> bilateral grid, if it wins on held-out
        blocks -> segment medians -> holes filled -> steps of the target snapped to the new image
        -> pulled to the target below W/16 -> relief from shading

Objects stand in front of what is registered here (`worker.standing`).

All maps are parallax q, native pixels, + = nearer, affine in inverse depth.  A region may be almost
flat or hold a step of millions of pixels: regressions therefore see one *layer* of the target at a
time (offsets are per segment and layer), and what the estimate adds to a layer is bounded.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import torch

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.depth.grid import Adam, BilateralGrid
from wzviewer.worker.models.builtin.depth.layers import (
    STEP_PX,
    STEP_SLOPE,
    cut_along,
    nearest_fill,
    step_mask,
)
from wzviewer.worker.models.builtin.depth.refine import segment, snap_steps, without_islands
from wzviewer.worker.models.builtin.depth.regression import (
    FixedEffects,
    borrow,
    fixed_effects,
    segment_medians,
)
from wzviewer.worker.models.builtin.depth.sky import smooth_like
from wzviewer.worker.models.builtin.relief import border_ramp, low_pass, relief_from_shading

WORK_WIDTH = 272  # longer side at which regressions run
SNAP_RADIUS_PX = 14  # the coarse geometry is 8 native px wide
FAR_FLOOR = 0.001  # of a step: parallax up to here is that of its far side
RING_SHARE = 0.04  # of the shorter side: here the target itself, not even its steps moved
FAR_SHARE = 0.05  # of the inverse depth: what is far may move less, in pixels of parallax
DETAIL_BLUR_SHARE = 0.01  # of the width: steps of the estimate inside a layer become slopes this wide
DETAIL_SHARE = 0.15  # of the width: largest disagreement that the estimate may express
HELD_OUT_PX, HELD_OUT_WIN = 20, 0.8  # blocks; the grid must beat this share of the error
LEARNING_RATE, ROUGHNESS = 0.06, 0.6


@dataclass(frozen=True)
class Registration:
    """Result of `register`.

    Attributes:
        parallax: (h, w) f32 native px, finite everywhere.
        report: a, b, loss_before (closed form), loss_fixed_effects, loss_after (before relief), all in
            px; grid_accepted, grid_error_ratio, steps_share, hidden_share, relief_px, seconds.
    """

    parallax: FloatArray
    report: dict[str, float]


@dataclass(frozen=True)
class _Work:
    """The inputs at the size where regressions run; steps and layers are known here."""

    estimate: FloatArray
    target: FloatArray  # finite; holes hold the nearest value
    defined: BoolArray
    step: BoolArray
    labels: IntArray  # segment and layer
    luma: FloatArray

    @property
    def visible(self) -> BoolArray:
        """Where the target is defined and not near one of its steps."""
        return self.defined & ~self.step


def register(
    image: FloatArray,
    target: FloatArray,
    estimate: FloatArray,
    *,
    focal_px: float,
    segments: IntArray | None = None,
    relief_texture: FloatArray | None = None,
    sky: BoolArray | None = None,
    relief_share: float | None = None,
    seed: int = 0,
    steps: int = 50,
    check: Callable[[], None] | None = None,
    on_step: Callable[[int, float], None] | None = None,
) -> Registration:
    """Registers a new image's depth to the coarse geometry.

    Args:
        image: (h, w, 3) sRGB 0..1, the new image.
        target: (h, w) parallax of the coarse scene at this camera; nan where undefined.
        estimate: (h, w) disparity of the depth estimator on the new image, any affine unit.
        focal_px: of this level.
        segments: (h, w) labels, or None for graph segments of the image.
        relief_texture: (h, w) signed height of the synthesised texture, or None.
        sky: (h, w) where no relief grows, or None.
        relief_share: amplitude of the relief over the width; None = from the material, 0 = none.
        seed: kept for adapters; nothing here is random.
        steps: Adam steps of the grid.
        check: called often; raises to cancel.
        on_step: called with (step, loss) of the grid.

    Returns:
        Parallax that equals the target at the border and below W/16.
    """
    del seed
    started, check = time.monotonic(), check or (lambda: None)
    labels = segment(image) if segments is None else segments
    check()
    work = _shrink(image, target, estimate, labels, focal_px)
    fit, tuned, report = _regress(work, steps, check, on_step)
    check()
    guess = _full_size(estimate, fit, tuned, image, work)
    base = _base(image, target, guess, work, focal_px)
    check()
    room = _room(base, focal_px, sky)
    parallax = _blend(base, guess, work, room)
    report["loss_after"] = _loss(_sample(parallax, work), work)
    grown = np.clip(_relief(image, labels, relief_texture, sky, relief_share), -room, room)
    parallax = parallax + grown
    report["relief_px"] = float(np.subtract(*np.percentile(grown[::4, ::4], (95, 5))))
    report["seconds"] = time.monotonic() - started
    return Registration(_finite(parallax), report)


def _regress(
    work: _Work, steps: int, check: Callable[[], None], on_step: Callable[[int, float], None] | None
) -> tuple[FixedEffects, DoubleArray, dict[str, float]]:
    """Closed form, then the grid, then the segments' medians; (h, w) at the working size."""
    fit = fixed_effects(work.estimate, work.target, work.labels, work.visible)
    registered = fit.predict(work.estimate, work.labels)
    plain = fit.global_slope * work.estimate.astype(np.float64) + fit.global_offset
    report = {
        "a": fit.slope,
        "b": float(np.median(fit.offsets[work.labels])),
        "steps_share": float(work.step.mean()),
        "hidden_share": float(1 - work.defined.mean()),
        "loss_before": _loss(plain, work),
        "loss_fixed_effects": _loss(registered, work),
    }
    check()
    tuned, tuning = _fine_tune(registered, work, steps, check, on_step)
    if tuning["grid_accepted"]:
        shown = work.visible
        shift = segment_medians((work.target - tuned)[shown], work.labels[shown], len(fit.offsets))
        tuned = tuned + borrow(shift, work.labels, 0.0)[work.labels]
    return fit, tuned, report | tuning


def _shrink(
    image: FloatArray, target: FloatArray, estimate: FloatArray, labels: IntArray, focal_px: float
) -> _Work:
    h, w = target.shape
    shrink = max(max(h, w) / WORK_WIDTH, 1.0)
    size = (max(round(w / shrink), 1), max(round(h / shrink), 1))

    # nearest samples of both maps: the same pixels, so that exact relations stay exact
    small_target, small_estimate, small_labels = (
        cv2.resize(v, size, interpolation=cv2.INTER_NEAREST) for v in (target, estimate, labels)
    )
    luma = cv2.resize(image, size, interpolation=cv2.INTER_AREA).mean(2)
    defined = np.isfinite(small_target)
    filled = nearest_fill(small_target, defined)
    step = step_mask(filled, shrink, focal_px)
    merged = cut_along(small_labels, step)
    return _Work(np.nan_to_num(small_estimate), filled, defined, step, merged, luma.astype(np.float32))


def _loss(prediction: DoubleArray, work: _Work) -> float:
    """Masked L1 of Eq. 5, px."""
    if not work.visible.any():
        return 0.0
    return float(np.abs(prediction - work.target)[work.visible].mean())


def _fine_tune(
    registered: DoubleArray,
    work: _Work,
    steps: int,
    check: Callable[[], None],
    on_step: Callable[[int, float], None] | None,
) -> tuple[DoubleArray, dict[str, float]]:
    """Trains the grid on most blocks; keeps it only if it wins clearly on the others."""
    kept = {"grid_accepted": 0.0, "grid_error_ratio": 1.0}
    if not work.visible.any():
        return registered, kept
    residual = work.target - registered
    level = np.median(work.target[work.visible])
    spread = np.median(np.abs(work.target - level)[work.visible])
    unit = max(float(spread), float(np.percentile(np.abs(residual[work.visible]), 90)), 1e-3)
    usable = work.visible & (np.abs(residual) < 3 * unit)
    held = usable & _held_out(work.target.shape)
    before = float(np.median(np.abs(residual[held]))) if held.any() else 0.0
    if steps <= 0 or before < 2e-4 * unit or np.count_nonzero(usable & ~held) < 200:
        return registered, kept
    # the module sees the registered map in units of the spread, without what lies far away
    scaled = np.clip((registered - np.median(registered[usable])) / unit, -8, 8).astype(np.float32)
    goal = (scaled + residual / unit).astype(np.float32)
    # a quarter of the pixels says the same of so coarse a grid
    module = BilateralGrid(scaled[::2, ::2].copy(), work.luma[::2, ::2].copy())
    _train(module, goal[::2, ::2], (usable & ~held)[::2, ::2], steps, check, on_step)
    with torch.no_grad():
        best = module.applied_to(scaled, work.luma).forward().numpy()
    shift = unit * (best - scaled).astype(np.float64)
    after = float(np.median(np.abs((residual - shift)[held])))
    kept["grid_error_ratio"] = after / before
    if after >= HELD_OUT_WIN * before:
        return registered, kept
    kept["grid_accepted"] = 1.0
    return registered + shift, kept


def _held_out(shape: tuple[int, int]) -> BoolArray:
    """Every fifth block of 20 px, in a pattern that visits all rows and columns."""
    rows, columns = np.arange(shape[0]) // HELD_OUT_PX, np.arange(shape[1]) // HELD_OUT_PX
    return np.asarray((rows[:, None] * 2 + columns[None]) % 5 == 0, bool)


def _train(
    module: BilateralGrid,
    goal: FloatArray,
    mask: BoolArray,
    steps: int,
    check: Callable[[], None],
    on_step: Callable[[int, float], None] | None,
) -> None:
    """Adam on the masked L1 of Eq. 5 plus the grid's roughness; the module keeps its best state."""
    wanted = torch.from_numpy(np.nan_to_num(goal))
    weight = torch.from_numpy(mask.astype(np.float32))
    weight = weight / weight.sum()
    adam = Adam(list(module.parameters()), LEARNING_RATE)
    best, least = {name: v.clone() for name, v in module.state_dict().items()}, float("inf")
    for k in range(steps + 1):
        check()
        loss = ((module() - wanted).abs() * weight).sum() + ROUGHNESS * module.roughness()
        if float(loss.detach()) < least:
            best, least = {name: v.clone() for name, v in module.state_dict().items()}, float(loss.detach())
        if on_step is not None:
            on_step(k, float(loss.detach()))
        if k < steps:
            loss.backward()  # type: ignore[no-untyped-call]
            adam.step()
    module.load_state_dict(best)


def _full_size(
    estimate: FloatArray, fit: FixedEffects, tuned: DoubleArray, image: FloatArray, work: _Work
) -> DoubleArray:
    """The registered estimate at the image's size; offsets end at the image's edges, not at blocks."""
    h, w = estimate.shape
    shifts = tuned - fit.slope * work.estimate.astype(np.float64)
    level = float(np.median(shifts))
    near = np.abs(shifts - level) < 4 * w  # beyond that are other layers: no smoothing across
    guide = cv2.resize((np.clip(image, 0, 1) * 255).astype(np.uint8), work.target.shape[1::-1])
    smooth = smooth_like(
        np.ascontiguousarray(guide), np.where(near, shifts - level, 0).astype(np.float32), 1.0, 12
    )
    if near.all():
        shifts = level + smooth.astype(np.float64)
    shifts = cv2.resize(shifts, (w, h), interpolation=cv2.INTER_LINEAR if near.all() else cv2.INTER_NEAREST)
    return fit.slope * np.nan_to_num(estimate).astype(np.float64) + shifts


def _base(
    image: FloatArray, target: FloatArray, guess: DoubleArray, work: _Work, focal_px: float
) -> FloatArray:
    """The target at full size: holes filled from the registration, steps snapped to the image."""
    h, w = target.shape
    known = np.isfinite(target)
    filled = target if known.all() else _fill_holes(target, known, guess.astype(np.float32), w)
    band = cv2.dilate(work.step.astype(np.uint8), np.ones((5, 5), np.uint8))
    band = cv2.resize(band, (w, h), interpolation=cv2.INTER_NEAREST) > 0
    least = np.float32(max(STEP_PX, STEP_SLOPE * SNAP_RADIUS_PX))
    soft = _unblocked(filled)
    # beyond the band the blur still reaches over the step: a shred between the two sides
    filled = np.where(band | (np.abs(soft - filled) > least), filled, soft)
    if not band.any():
        return filled
    lab = cv2.cvtColor((np.clip(image, 0, 1) * 255).astype(np.uint8), cv2.COLOR_RGB2LAB).astype(np.float32)
    slack = float(np.clip(FAR_SHARE * (focal_px + filled.min()), 1e-3, least))
    jump = np.where(band, least, np.float32(np.inf))
    snapped = snap_steps(filled, lab, SNAP_RADIUS_PX, jump, slack, FAR_FLOOR)
    snapped = without_islands(snapped, filled, float(least))
    ring = max(round(RING_SHARE * min(h, w)), 1)
    result = filled.copy()
    result[ring:-ring, ring:-ring] = snapped[ring:-ring, ring:-ring]
    return result


def _unblocked(v: FloatArray) -> FloatArray:
    """Blurs away the coarse surfels' facets; planes stay planes up to the border (odd reflection)."""
    reach = min(12, min(v.shape) - 1)
    level = np.float32(np.median(v))
    padded = np.pad(v - level, reach, mode="reflect", reflect_type="odd")
    return cv2.GaussianBlur(padded, (2 * reach + 1, 2 * reach + 1), 4)[reach:-reach, reach:-reach] + level


def _fill_holes(target: FloatArray, known: BoolArray, guess: FloatArray, width: int) -> FloatArray:
    """The registered estimate in the holes, shifted to meet their rims, smoothed without losing steps."""
    limit = DETAIL_SHARE * width
    gap = np.where(known, np.clip(np.nan_to_num(target) - guess, -limit, limit), 0).astype(np.float32)
    gap = nearest_fill(gap, known)
    gap = np.where(known, gap, cv2.GaussianBlur(gap, (0, 0), 6))
    filled = np.where(known, target, guess + gap).astype(np.float32)
    smooth = cv2.bilateralFilter(filled, 5, 0.05 * limit, 3)
    return np.where(known, target, smooth).astype(np.float32)


def _room(base: FloatArray, focal_px: float, sky: BoolArray | None) -> FloatArray:
    """How far each pixel may leave the target, px: 5 % of its inverse depth, nothing in the sky."""
    room = FAR_SHARE * np.maximum(focal_px + base.astype(np.float64), 0)
    room = np.minimum(room, DETAIL_SHARE * base.shape[1])
    return np.asarray(room if sky is None else room * ~sky, np.float32)


def _blend(base: FloatArray, guess: DoubleArray, work: _Work, room: FloatArray) -> FloatArray:
    """The registered estimate above W/16, the target below; the target alone where they contradict."""
    h, w = base.shape
    size = work.target.shape[1::-1]
    sigma = size[0] / 16
    gap = _sample(base, work) - _sample(guess, work)
    sure = ((np.abs(gap) < DETAIL_SHARE * w) & ~work.step).astype(np.float32)
    mean = low_pass((gap * sure).astype(np.float32), sigma) / np.maximum(low_pass(sure, sigma), 1e-3)
    share = cv2.GaussianBlur(cv2.erode(sure, np.ones((3, 3), np.uint8)), (0, 0), 1.5) * sure
    mean, share = (cv2.resize(v, (w, h), interpolation=cv2.INTER_LINEAR) for v in (mean, share))
    # the estimate's small steps become slopes: a crack in a meadow costs more than a soft edge
    fine = ((guess + mean - base) * (share > 0)).astype(np.float32)
    fine = np.clip(fine, -DETAIL_SHARE * w, DETAIL_SHARE * w)
    fine = low_pass(fine, DETAIL_BLUR_SHARE * w) / np.maximum(
        low_pass((share > 0).astype(np.float32), DETAIL_BLUR_SHARE * w), 1e-3
    )
    fine = np.clip(fine * share * border_ramp(h, w), -room, room)
    return (base + fine).astype(np.float32)


def _sample(v: FloatArray | DoubleArray, work: _Work) -> DoubleArray:
    return cv2.resize(v, work.target.shape[1::-1], interpolation=cv2.INTER_NEAREST).astype(np.float64)


def _relief(
    image: FloatArray,
    labels: IntArray,
    texture: FloatArray | None,
    sky: BoolArray | None,
    share: float | None,
) -> FloatArray:
    if share == 0:
        return np.zeros(image.shape[:2], np.float32)
    return relief_from_shading(image, labels, texture, sky, share)


def _finite(parallax: FloatArray) -> FloatArray:
    known = np.isfinite(parallax)
    return np.ascontiguousarray(nearest_fill(parallax, known), np.float32)
