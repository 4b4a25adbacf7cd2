"""The same objects at a deeper level: marched again, so that the zoom shows finer structure."""

from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects import composite
from wzviewer.worker.models.builtin.objects.inserting import (
    Check,
    body_of,
    drowned,
    setting_of,
    toned,
    without,
)
from wzviewer.worker.models.builtin.objects.parts import Depths
from wzviewer.worker.models.builtin.objects.peeling import Studio, dismantled
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, held, merged
from wzviewer.worker.models.builtin.objects.placement import Plane, Support, hidden_by
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import Layer, render

_OPAQUE = 0.94  # a sheet of feather or wing covers .96 at most
_COMBED_LIMITS = (40 / 255, 20 / 255, 2 / 255)
_BESIDE = 0.3  # of a pixel: a whisker covers so much more of it than of a neighbour
_HAIR = 3.0  # of a coarser pixel, to either side: so far along a hair its correction is evened out
_BAND_LIMITS = (40 / 255, 20 / 255, 10 / 255)  # how far each step may pull back to the parent's picture


def march_again(
    placed: Placement,
    mapping: tuple[float, float, float],
    result: EditResult,
    geometry: Support,
    seed: int,
    check: Check,
    parent_factor: float,
) -> EditResult | None:
    """One object at a deeper level, or None if it is out of view."""
    h, w = result.image.shape[:2]
    body = body_of(placed.name, placed.seed, placed.tint)
    pose = placed.pose.seen_from(*mapping)
    scene = Scene(body, pose, w, h)
    if not (scene.spans[:, 1] > scene.spans[:, 0]).any():
        return None
    setting = setting_of(placed, body)
    layer = drowned(render(scene, setting, check), placed.water)
    mask = held(layer.alpha, layer.relief)
    if mask.mean() < 2e-4:
        return None
    depths = _registered(placed, mapping, layer, geometry, mask)
    relief = depths.of_image(layer.relief)
    hidden = hidden_by(geometry.relief, relief, mask, pose.size_px)
    if hidden.any():
        layer, mask = without(layer, hidden), mask & ~hidden
    reach_px = 2.6 * parent_factor
    clean = _without_halo(result.image, layer.alpha, reach_px)
    ground = clean if result.ground is None else _without_halo(result.ground, layer.alpha, reach_px)
    finish = composite.Finish(0.40, 0.5 * composite.Finish.of(result.image).grain)
    none = np.ones((h, w), np.float32)
    # Its picture is mostly itself: what it was muted to is known from where it was put in.
    harmony = replace(composite.harmony_of(clean, layer), chroma=placed.chroma)

    def paint(of: Layer) -> tuple[FloatArray, FloatArray]:
        if body.refractive:
            return composite.reflected(result.image, clean, of, finish)
        return composite.composite(clean, of, finish, seed, harmony)

    first, alpha = paint(layer)
    picture = _toward_parent(
        first, result.image, alpha, parent_factor, limbs=layer.limbs if scene.furred else None
    )
    pulled = picture - first

    def paint_pulled(of: Layer) -> tuple[FloatArray, FloatArray]:
        own, cover = paint(of)  # where it shows the ground, nothing is to be pulled to the object that hid it
        return np.clip(own + pulled * np.maximum(cover, 1 - alpha)[..., None], 0, 1), cover

    under = np.clip(clean + pulled * (1 - alpha[..., None]), 0, 1)
    ground = np.where(alpha[..., None] > 0, ground, picture).astype(np.float32)
    tone = toned(harmony, placed.water)
    studio = Studio(scene, setting, layer, picture, under, paint_pulled, tone, finish, depths)
    relief = np.where(mask, relief, np.nan).astype(np.float32)
    parts, below, flanks = dismantled(studio, check)
    ground = ground + (below - under)
    return merged(result, picture, relief, mask, alpha, none, placed, ground, (parts, flanks))


def _registered(
    placed: Placement,
    mapping: tuple[float, float, float],
    layer: Layer,
    geometry: Support,
    mask: BoolArray,
) -> Depths:
    """Returns depths sheared as at the ancestor, where the ancestor shows the body.

    Its limbs and wings are no measure: the depth that was seen there may be that of what is behind.
    """
    x0, y0, factor = mapping
    lift = placed.lift
    child = Plane(
        (lift.x0 - x0) * factor, (lift.y0 - y0) * factor, lift.at * factor, lift.slope_x, lift.slope_y
    )
    depths = Depths(child, 0.0, 1.0, np.zeros(mask.shape, np.float32))
    gap = geometry.relief - depths.of_image(layer.relief)
    known = mask & np.isfinite(gap)
    sure = known & (layer.limbs + layer.wings == 0)
    chosen = sure if sure.sum() > 0.05 * known.sum() else known
    offset = float(np.median(gap[chosen])) if chosen.any() else 0.0
    return replace(depths, contact=np.full(mask.shape, offset, np.float32))


def _without_halo(image: FloatArray, alpha: FloatArray, reach_px: float) -> FloatArray:
    """Fills a band around the body from outside: the coarser level's edge has bled into it.

    Push and pull (Gortler 1996) with weights that grow with the distance from the body, so that a
    gap between two legs is filled by its own middle.
    """
    free = (alpha == 0).astype(np.uint8)
    if free.all() or not free.any():
        return image
    away = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) / np.float32(reach_px)
    weight = np.clip(away, 0, 1) ** 4
    filled = image * weight[..., None]
    pyramid = [(filled, weight)]
    while max(weight.shape) > 1:
        size = (-(-weight.shape[1] // 2), -(-weight.shape[0] // 2))
        filled = cv2.resize(filled, size, interpolation=cv2.INTER_AREA)
        weight = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
        pyramid.append((filled, weight))
    guess = filled / np.maximum(weight, 1e-12)[..., None]
    for level in range(len(pyramid) - 2, -1, -1):
        filled, weight = pyramid[level]
        guess = cv2.resize(guess, weight.shape[::-1], interpolation=cv2.INTER_LINEAR)
        share = weight if level == 0 else np.minimum(4 * weight, 1)
        own = filled / np.maximum(weight, 1e-12)[..., None]
        guess = guess + (own - guess) * share[..., None]
    return np.asarray(guess, np.float32)


def _toward_parent(
    picture: FloatArray,
    base: FloatArray,
    alpha: FloatArray,
    factor: float,
    *,
    limbs: FloatArray | None = None,
) -> FloatArray:
    """Adds up(parent - down(child)), limited: shrunk, the finer picture stays the one that was there.

    In fur, where `limbs` (h, w) tells what a whisker covers, along hairs, which the coarser picture's
    pixels would bead; and not beside whiskers, whose own have bled into the coat there.
    """
    h, w = alpha.shape
    size = (max(round(w / factor), 1), max(round(h / factor), 1))
    # Around the body's outline the coarser picture is a mixture: only what lies beyond it counts.
    k = np.ones((int((1.5 if limbs is None else 3.0) * factor) | 1,) * 2, np.uint8)
    inside = cv2.erode((alpha > _OPAQUE).astype(np.float32), k, borderValue=1)
    outside = cv2.erode((alpha < 0.02).astype(np.float32), k, borderValue=1)
    combed = limbs is not None
    lines = _lines(picture, 0.5 * factor) if combed else None
    if limbs is not None:
        beside = cv2.dilate(limbs, k) - cv2.erode(limbs, k) > _BESIDE
        inside = np.where(beside, np.float32(0), inside)
    off = np.abs(base - picture)[inside > 0.5]
    # Where weather has changed the body, the parent's picture is right and what is marched here is not.
    trust = max(1.0, 2.0 * float(np.percentile(off, 90)) / _BAND_LIMITS[0]) if len(off) else 1.0
    limits = _COMBED_LIMITS if combed else _BAND_LIMITS
    for limit in limits:
        low = _pulled(base - picture, inside, alpha, size, limit * trust, trust > 1)
        if lines is not None and limit > limits[-1]:  # a last little step sees to what is left
            low = _along(low, lines, _HAIR * factor)
        low += _pulled(base - picture, outside, 1 - alpha, size, limit, False)
        picture = np.clip(picture + low, 0, 1).astype(np.float32)
    return picture


def _lines(picture: FloatArray, sigma_px: float) -> FloatArray:
    """Returns the unit direction (h / 2, w / 2, 2) along which a picture changes least around each place.

    The structure tensor's smaller eigenvector (Bigun and Granlund 1987).
    """
    luma = cv2.resize(picture.mean(2), _halved(picture), interpolation=cv2.INTER_AREA)
    x, y = cv2.Sobel(luma, cv2.CV_32F, 1, 0), cv2.Sobel(luma, cv2.CV_32F, 0, 1)
    xx, xy, yy = (cv2.GaussianBlur(v, (0, 0), sigma_px / 2) for v in (x * x, x * y, y * y))
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + np.float32(np.pi / 2)
    return np.asarray(np.dstack([np.cos(angle), np.sin(angle)]), np.float32)


def _halved(picture: FloatArray) -> tuple[int, int]:
    return max(picture.shape[1] // 2, 1), max(picture.shape[0] // 2, 1)


def _along(field: FloatArray, lines: FloatArray, reach_px: float) -> FloatArray:
    """Returns the mean of a smooth field (h, w, 3) along its lines, weighed to either side by a tent."""
    small = cv2.resize(field, _halved(field), interpolation=cv2.INTER_AREA)
    h, w = small.shape[:2]
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    steps = np.linspace(-1, 1, 11)[1:-1]
    total = np.zeros_like(small)
    for step in steps:
        way = np.float32(0.5 * step * reach_px)
        at = (x + way * lines[..., 0], y + way * lines[..., 1])
        seen = cv2.remap(small, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += np.float32(1 - abs(step)) * seen
    total /= np.float32((1 - np.abs(steps)).sum())
    return np.asarray(cv2.resize(total, field.shape[1::-1], interpolation=cv2.INTER_CUBIC), np.float32)


def _pulled(
    off: FloatArray, weight: FloatArray, share: FloatArray, size: tuple[int, int], limit: float, spreads: bool
) -> FloatArray:
    """Returns the low band of a difference where `weight` counts it, limited, applied by `share`.

    If it spreads, what does not count (the rim) is pulled like what lies beside it.
    """
    low = cv2.resize(off * weight[..., None], size, interpolation=cv2.INTER_AREA)
    if spreads:
        counted = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
        near = cv2.GaussianBlur(low, (0, 0), 1.5)
        near /= np.maximum(cv2.GaussianBlur(counted, (0, 0), 1.5), 1e-2)[..., None]
        low += (1 - counted)[..., None] * near
    step = cv2.resize(np.clip(low, -limit, limit), weight.shape[::-1], interpolation=cv2.INTER_CUBIC)
    return np.asarray(step * share[..., None], np.float32)
