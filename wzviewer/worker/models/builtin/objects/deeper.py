"""The same objects at a deeper level: marched again, so that the zoom shows finer structure."""

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.objects import composite
from wzviewer.worker.models.builtin.objects.inserting import Check, body_of, plane_image, setting_of
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, merged
from wzviewer.worker.models.builtin.objects.placement import Plane, Support
from wzviewer.worker.models.builtin.objects.render import Scene, render

_BAND_LIMIT = 12 / 255  # how far a deeper level may be pulled back to its parent's picture


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
    layer = render(scene, setting, check)
    mask = (layer.alpha >= 0.5) & np.isfinite(layer.relief)
    if mask.mean() < 2e-4:
        return None
    clean = _without_halo(result.image, layer.alpha, 2.6 * parent_factor)
    finish = composite.Finish(0.40, 0.5 * composite.Finish.of(result.image).grain)
    none = np.ones((h, w), np.float32)
    if body.refractive:
        picture, alpha = composite.refract(
            clean, layer, none, placed.light, finish, setting.to_light, body.clear
        )
    else:
        picture, alpha = composite.composite(clean, layer, none, placed.light, finish, seed)
    picture = _toward_parent(picture, result.image, alpha, parent_factor)
    x0, y0, factor = mapping
    lift = placed.lift
    child = Plane(
        (lift.x0 - x0) * factor, (lift.y0 - y0) * factor, lift.at * factor, lift.slope_x, lift.slope_y
    )
    relief = layer.relief + plane_image(child, (h, w))
    known = mask & np.isfinite(geometry.relief)
    offset = float(np.median(geometry.relief[known] - relief[known])) if known.any() else 0.0
    relief = np.where(mask, relief + np.float32(offset), np.nan).astype(np.float32)
    return merged(result, picture, relief, mask, alpha, none, placed)


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


def _toward_parent(picture: FloatArray, base: FloatArray, alpha: FloatArray, factor: float) -> FloatArray:
    """Adds up(parent - down(child)), limited: shrunk, the finer picture stays the one that was there."""
    h, w = alpha.shape
    size = (max(round(w / factor), 1), max(round(h / factor), 1))
    # Only what lies well inside the body counts: around its outline the coarser picture is a mixture.
    k = int(1.5 * factor) | 1
    weight = cv2.erode((alpha > 0.98).astype(np.float32), np.ones((k, k), np.uint8), borderValue=1)
    for limit in (_BAND_LIMIT, 0.5 * _BAND_LIMIT):
        low = cv2.resize((base - picture) * weight[..., None], size, interpolation=cv2.INTER_AREA)
        step = cv2.resize(np.clip(low, -limit, limit), (w, h), interpolation=cv2.INTER_CUBIC)
        picture = np.clip(picture + step * alpha[..., None], 0, 1).astype(np.float32)
    return picture
