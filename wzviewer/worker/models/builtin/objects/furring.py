"""Fur: hairs drawn one by one over a marched body, at whatever scale it is looked at.

::

    marched coat ── roots   one a cell of object space, so that they stay where they are
        │             coats   which way they lie, how long they are
        ▼
    hairs           a bent line each, drawn to its tuft, lit along its length, coloured like its skin
        ▼
    strands.draw    the nearest hair of each of 2x2 samples a pixel, over a darker undercoat
        ▼
    shaded where others lie higher; brought back to the mean colour that the coat had without hairs

A hair is as fine as about two pixels and no finer than it really is: a deeper level shows more of
them, each lock of the coarser level a bundle of its own.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import strands
from wzviewer.worker.models.builtin.objects.coats import Coat
from wzviewer.worker.models.builtin.objects.hairs import LUMA, Lights, hairs
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.roots import Skin, rooted, width_px

Run = Callable[[Callable[[int], object], list[int]], object]

_SEED = 11  # of where hairs are rooted: the same for every body, whose own shape differs
_FINE = 2  # samples a pixel, along either axis
_BANDS = 8  # of rows, each on a thread of its own
_BEHIND = 0.012  # body lengths that a hair may sink into the skin where that is hollow
_UNDERCOAT = 0.42  # of the coat's brightness, between hairs
_BALANCED_PX = 12.0  # around a pixel, over so much the mean colour stays what it was
_SCATTERED = 0.7  # of the shade between white hairs is lit by light that went through them
_FAR = np.float32(1e30)


@dataclass(frozen=True, eq=False)
class Marched:
    """A marched body, taken apart into its coat and what stands before that.

    Attributes:
        color: (h, w, 3) linear, premultiplied: the coat, and what has none.
        alpha: (h, w) coverage.
        relief: (h, w) native px of the coat, nan where there is none.
        furry: (h, w) share of a pixel that the coat covers.
        limbs: (h, w) share of a pixel that limbs cover.
        over_color: (h, w, 3) linear, premultiplied, of what stands before the coat.
        over_alpha: (h, w) coverage.
        over_relief: (h, w) native px; infinite where there is nothing.
        over_limbs: (h, w) share of a pixel that limbs cover.
    """

    color: FloatArray
    alpha: FloatArray
    relief: FloatArray
    furry: FloatArray
    limbs: FloatArray
    over_color: FloatArray
    over_alpha: FloatArray
    over_relief: FloatArray
    over_limbs: FloatArray

    def cut(self, box: tuple[slice, slice]) -> "Marched":
        """Returns a part of the picture."""
        return Marched(*(np.ascontiguousarray(getattr(self, f.name)[box]) for f in fields(self)))


@dataclass(frozen=True, eq=False)
class Furred:
    """A body with its hairs.

    Attributes:
        box: the part of the picture that this is; beyond it nothing changes.
        color: (h, w, 3) linear, premultiplied.
        alpha: (h, w) coverage.
        relief: (h, w) native px where hairs are, else nan: the skin's, beyond its outline as at the outline,
            so that what stands out there stays with it from aside.
        limbs: (h, w) share of a pixel that limbs cover, with the hairs on them.
    """

    box: tuple[slice, slice]
    color: FloatArray
    alpha: FloatArray
    relief: FloatArray
    limbs: FloatArray


@dataclass(frozen=True, eq=False)
class _Fur:
    """Drawn hairs, `_FINE` samples a pixel: colour, relief px, whether there is one, whether a limb's."""

    color: FloatArray
    depth: FloatArray
    there: BoolArray
    limb: BoolArray


def furred(
    coat: Coat, pose: Pose, skins: list[Skin], marched: Marched, lights: Lights, limbs: BoolArray, run: Run
) -> Furred:
    """Grows hairs on a body.

    Args:
        coat: what fur there is.
        pose: of the body.
        skins: what of it is marched, in the picture and around it.
        marched: (h, w) planes.
        lights: directions.
        limbs: (n,) which primitives are limbs.
        run: maps a function over items, on threads.
    """
    roots = rooted(coat, pose, skins, _SEED)
    joints, colors, lengths = hairs(coat, pose, roots, lights)
    box = _box(joints, marched.furry)
    under = marched.cut(box)
    joints[..., :2] -= [box[1].start, box[0].start]
    light = np.ascontiguousarray(lights.to_light[:2], np.float64)
    fur = _drawn(under, (joints, colors, light, lengths), limbs[roots.part], _BEHIND * pose.size_px, run)
    wide = width_px(coat, 1.0 / pose.size_px)
    relief = np.where(_blocks(fur.there).any((1, 3)), _nearest(under.relief), np.float32(np.nan))
    color, alpha, limb_share = _laid_over(under, fur, wide)
    return Furred(box, color, alpha, relief, limb_share)


def _box(joints: DoubleArray, furry: FloatArray) -> tuple[slice, slice]:
    """Returns the part of a picture (h, w) that hairs and what they grow on take."""
    sides = []
    for axis, size in ((1, furry.shape[0]), (0, furry.shape[1])):
        coat = np.flatnonzero(furry.any(axis))
        at = joints[..., axis]
        low = min(float(at.min()) if at.size else size, float(coat[0]) if len(coat) else size) - 2
        high = max(float(at.max()) if at.size else 0, float(coat[-1]) if len(coat) else 0) + 3
        first = int(np.clip(low, 0, size - 1))
        sides.append(slice(first, int(np.clip(high, first + 1, size))))
    return sides[0], sides[1]


def _drawn(
    under: Marched,
    drawing: tuple[DoubleArray, FloatArray, DoubleArray, FloatArray],
    limb: BoolArray,
    behind_px: float,
    run: Run,
) -> _Fur:
    """Draws hairs, in bands of rows."""
    joints, colors, light, lengths = drawing
    deep = np.where(under.furry > 0.5, under.relief + np.float32(behind_px), under.relief)
    depth = _fine(np.nan_to_num(deep, nan=float(_FAR)).astype(np.float32))
    color = np.zeros((*depth.shape, 3), np.float32)
    owner = np.full(depth.shape, -1, np.int32)
    joints, lengths = joints * np.array([_FINE, _FINE, 1, _FINE]), lengths * np.float32(_FINE)
    low, high = ((joints[..., 1] + sign * joints[..., 3]) for sign in (-1, 1))
    low, high = low.min(1, initial=np.inf), high.max(1, initial=-np.inf)
    rows = -(-len(depth) // _BANDS)

    def band(first: int) -> None:
        last = min(first + rows, len(depth))
        near = np.flatnonzero((high >= first) & (low <= last))
        own = owner[first:last]
        lines = joints[near], colors[near], light, lengths[near]
        strands.draw(*lines, first, depth[first:last], color[first:last], own)
        own[own >= 0] = near[own[own >= 0]]

    run(band, list(range(0, len(depth), rows)))
    there = owner >= 0
    of_limb = there & limb[np.maximum(owner, 0)] if len(limb) else there
    return _Fur(color, depth, there, of_limb)


def _nearest(relief: FloatArray) -> FloatArray:
    """Continues a relief (h, w) by the nearest that is known."""
    known = np.isfinite(relief)
    if not known.any():
        return relief
    _, label = cv2.distanceTransformWithLabels(
        (~known).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    values = np.zeros(int(label.max()) + 1, np.float32)
    values[label[known]] = relief[known]
    return np.asarray(values[label], np.float32)


def _fine(plane: NDArray[Any]) -> NDArray[Any]:
    """Repeats the pixels of a plane (h, w) for their samples."""
    return np.ascontiguousarray(np.repeat(np.repeat(plane, _FINE, 0), _FINE, 1))


def _blocks(samples: NDArray[Any]) -> NDArray[Any]:
    """Returns samples (H, W) as (h, `_FINE`, w, `_FINE`)."""
    h, w = samples.shape[0] // _FINE, samples.shape[1] // _FINE
    return samples.reshape(h, _FINE, w, _FINE)


def _mean(samples: NDArray[Any]) -> FloatArray:
    """Returns the mean of each pixel's samples (H, W) or (H, W, 3)."""
    size = (samples.shape[1] // _FINE, samples.shape[0] // _FINE)
    return np.asarray(cv2.resize(samples.astype(np.float32), size, interpolation=cv2.INTER_AREA))


def _shaded(fur: _Fur, wide: float) -> FloatArray:
    """Returns colours (H, W, 3), darker where others lie higher (unsharp depth, Luft et al. 2006)."""
    weight = fur.there.astype(np.float32)
    z = np.where(fur.there, fur.depth, np.float32(0))
    mean = _smooth(z, wide) / np.maximum(_smooth(weight, wide), 1e-3)
    lower = np.where(fur.there, z - mean, 0) / np.float32(1.6 * wide)
    deep = (1 - _SCATTERED * np.clip(fur.color @ LUMA, 0, 1)) * (0.5 * lower)
    return np.asarray(fur.color * (np.clip(1 - deep, 0.35, 1.3) * weight)[..., None], np.float32)


def _smooth(field: FloatArray, wide: float) -> FloatArray:
    """Returns the mean of a field (H, W) over some hairs' width."""
    h, w = field.shape
    soft = cv2.GaussianBlur(_mean(field), (0, 0), float(np.clip(2.0 * wide, 1.0, 8.0)))
    return np.asarray(cv2.resize(soft, (w, h), interpolation=cv2.INTER_LINEAR), np.float32)


def _laid_over(under: Marched, fur: _Fur, wide: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Returns premultiplied colour (h, w, 3), coverage (h, w) and the share of limbs (h, w)."""
    colors = _shaded(fur, wide)
    color, share = _mean(colors), _mean(fur.there)
    pale = 1 - _SCATTERED * np.clip(under.color @ LUMA, 0, 1)
    dim = 1 - ((1 - _UNDERCOAT) * under.furry * pale)[..., None]
    coat = color + (1 - share)[..., None] * under.color * dim
    alpha = share + (1 - share) * under.alpha
    gain = _gain(coat, under, share)
    limbs = _mean(fur.limb) + (1 - share) * under.limbs
    coat, alpha, limbs = _beneath(under, coat * gain, alpha, limbs)
    before = fur.there & (fur.depth < _fine(under.over_relief)) & _fine(under.over_alpha > 0)
    if before.any():  # hairs that stand before what stands before the coat
        front, rest = _mean(before), 1 - _mean(before)
        coat = gain * _mean(colors * before[..., None]) + rest[..., None] * coat
        alpha, limbs = front + rest * alpha, _mean(before & fur.limb) + rest * limbs
    return coat, alpha, limbs


def _beneath(
    under: Marched, coat: FloatArray, alpha: FloatArray, limbs: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Puts what stands before a coat over it: colour, coverage, share of limbs."""
    rest = 1 - under.over_alpha
    return (
        under.over_color + rest[..., None] * coat,
        under.over_alpha + rest * alpha,
        under.over_limbs + rest * limbs,
    )


def _gain(coat: FloatArray, under: Marched, share: FloatArray) -> FloatArray:
    """Returns what (h, w, 3) brings the mean colour around each pixel back to the coat's without hairs."""
    there = (under.furry * under.alpha)[..., None]
    roots = (np.sqrt(np.maximum(c, 0)) for c in (coat, under.color))  # about as the eye sees them
    own, want = (cv2.GaussianBlur(c * there, (0, 0), _BALANCED_PX) for c in roots)
    gain = np.clip((want + 1e-3) / (own + 1e-3), 0.75, 1.6) ** 2
    return np.asarray(1 + np.maximum(under.furry, share)[..., None] * (gain - 1), np.float32)
