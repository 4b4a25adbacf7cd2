"""Inserting one object into a picture: light, pose, march, shadow, composite, contact."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects import composite, cutout, placement
from wzviewer.worker.models.builtin.objects.bodies import Body, Tint
from wzviewer.worker.models.builtin.objects.footing import footing
from wzviewer.worker.models.builtin.objects.grammar import Request
from wzviewer.worker.models.builtin.objects.lighting import (
    Environment,
    Light,
    light_from_photo,
    linear_from_srgb,
)
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS, FLYING
from wzviewer.worker.models.builtin.objects.parts import Depths, Pane, parts_of
from wzviewer.worker.models.builtin.objects.peeling import Studio, dismantled
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, held, merged, shifted
from wzviewer.worker.models.builtin.objects.placement import Plane, Support
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.render import Layer, Scene, ground_shadow, render
from wzviewer.worker.models.builtin.objects.shading import Setting
from wzviewer.worker.models.builtin.objects.substances import recast
from wzviewer.worker.models.builtin.objects.surfaces import beyond, on_front
from wzviewer.worker.models.builtin.objects.words import ALOFT

Check = Callable[[], object] | None
_UPRIGHT_DEG = 60.0  # what is seen from the side stands, and has its own footing
_HOVER = 0.40  # body lengths above its place
_SLIVER, _SPIKE = 0.16, 0.06  # of the width: so narrow, and out by more
_CLEAR_SHADOW = 0.8
_VEIL = 0.45  # share of what is seen under water that is the water
_THROUGH_WATER = np.array([0.62, 0.86, 0.94], np.float32)
_SHADOW_IN_WATER, _BLUR_IN_WATER_PX = 0.35, 1.2


@lru_cache(maxsize=6)
def body_of(name: str, seed: int, tint: Tint) -> Body:
    """Returns a body, built once."""
    return recast((BUILDERS.get(name) or FLYING[name])(np.random.default_rng(seed), tint), tint)


def insert(
    request: Request,
    result: EditResult,
    geometry: Support,
    centre: tuple[float, float],
    width_px: float,
    seed: int,
    light: Light | None,
    check: Check,
    cover: FloatArray | None = None,
    *,
    apart: bool = True,
) -> EditResult:
    """Returns the picture with one more object in it.

    `cover` (h, w) is where the water is that holds it; if not `apart`, it is not taken apart.
    """
    if request.name == "image":
        light = light or light_from_photo(result.image, centre, 0.5 * width_px)
        return _insert_image(request, result, geometry, centre, width_px, seed, light)
    name = flight if request.hovers and (flight := f"{request.name} in flight") in FLYING else request.name
    body = body_of(name, seed, request.tint)
    height = _HOVER if request.hovers else 0.0
    lies = body.tilt_deg[0] < _UPRIGHT_DEG and height == 0 and not request.submerged
    if lies and request.count == 1 and not request.place:
        centre = on_front(geometry, centre, width_px)
    behind_edge = beyond(geometry, centre, width_px) if lies else np.zeros_like(geometry.relief)
    own = replace(geometry, relief=np.where(behind_edge > 0.5, np.float32(np.nan), geometry.relief))
    light = light or light_from_photo(result.image, centre, 0.5 * width_px)
    rng = np.random.default_rng([seed, 5])
    pose, plane = _posed(body, own, centre, width_px, rng, stands=height == 0 and not request.submerged)
    bounce = _surroundings(result.image, centre, width_px)
    share, at = geometry.range_at(pose.position[2]), pose.position[2]
    size = share * pose.size_px  # in native px, which are those of the anchor
    lift = placement.lift_onto(pose, plane.at_range(share))
    pose = placement.hovering(pose, height)
    water = bounce if request.submerged else None
    placed = Placement(name, seed, request.tint, pose, lift, light, bounce, width_px, water)
    h, w = result.image.shape[:2]
    scene, setting = Scene(body, pose, w, h), setting_of(placed, body)
    layer = drowned(render(scene, setting, check), water)
    if cover is not None:
        layer = without(layer, cover < 0.5)
    ground = ground_shadow(scene, setting, _bumps(own.relief, plane, width_px), check, height)
    gain = composite.shadow_gain(ground, light, layer.alpha)
    if ALOFT & set(request.place):
        gain = np.ones_like(gain)  # too high for a shadow
    gain = gain + behind_edge * (1 - gain)  # a shadow of contact ends where its surface does
    if geometry.sky is not None:
        gain = np.where(geometry.sky, np.float32(1), gain)  # nothing darkens the sky
    if water is not None:
        gain = 1 - _SHADOW_IN_WATER * (1 - gain) * (1 if cover is None else cover)
    mask = held(layer.alpha, layer.relief)
    depths = Depths(lift, at, share, np.zeros((h, w), np.float32))
    relief = np.where(mask, depths.of_image(layer.relief), np.float32(np.nan))
    behind = np.fmin(geometry.relief, result.object_relief)
    hidden = placement.hidden_by(behind, relief, mask, size) & (height == 0)
    relief, shift = placement.settle(relief, mask, behind, pose.size_px, floats=height > 0, share=share)
    depths = depths.in_contact(layer.relief, relief, pose.size_px / 24)
    if hidden.any():
        near = geometry.relief < plane_image(plane, (h, w)) - 0.4 * size
        layer, mask, gain = without(layer, hidden), mask & ~hidden, np.where(near, np.float32(1), gain)
    placed = shifted(placed, shift)
    finish = composite.Finish.of(result.image)
    if water is not None:
        finish = composite.Finish(_BLUR_IN_WATER_PX, finish.grain)
    harmony = composite.harmony_of(result.image, layer)

    # A clear body gathers light where an opaque one would cast its shadow.
    gain = 1 - _CLEAR_SHADOW * (1 - gain) if body.refractive else gain
    under = composite.shadowed(result.image, gain, light)
    ground = under if result.ground is None else composite.shadowed(result.ground, gain, light)

    def paint(of: Layer) -> tuple[FloatArray, FloatArray]:
        if body.refractive:
            to_light, clear = setting.to_light, body.clear
            picture, alpha = composite.refract(result.image, of, under, finish, to_light, clear)
        else:
            picture, alpha = composite.composite(under, of, finish, seed, harmony)
        return (picture if water is None else composite.rippled(picture, result.image, alpha)), alpha

    picture, alpha = paint(layer)
    tone = toned(harmony, water)
    studio = Studio(scene, setting, layer, picture, under, paint, tone, finish, depths)
    parts, below, flanks = dismantled(studio, check) if apart else ((), under, ())
    return merged(
        result, picture, relief, mask, alpha, gain, placed, ground + (below - under), (parts, flanks)
    )


def toned(
    harmony: composite.Harmony, water: tuple[float, float, float] | None
) -> Callable[[FloatArray], FloatArray]:
    """Returns what brings linear colours (n, 3) of a body to the picture's sRGB, under water if it is."""

    def tone(lit: FloatArray) -> FloatArray:
        seen = lit if water is None else _through(lit, np.asarray(water, np.float32))
        return harmony(composite.developed(seen))

    return tone


def _posed(
    body: Body,
    geometry: Support,
    centre: tuple[float, float],
    width_px: float,
    rng: np.random.Generator,
    *,
    stands: bool,
) -> tuple[Pose, Plane]:
    """Returns a pose and the plane under it; what is upright is moved to the nearest footing."""
    state = rng.bit_generator.state
    pose, plane = placement.pose_on(body, geometry, centre, width_px, rng)
    if not stands or not placement.is_upright(pose):
        return pose, plane
    x, y = footing(geometry, pose.position[:2], width_px)
    if x or y:
        rng.bit_generator.state = state
        moved = (centre[0] + x, centre[1] + y)
        pose, plane = placement.pose_on(body, geometry, moved, width_px, rng)
    return pose, placement.fit_plane(geometry, *pose.position[:2], 0.25 * width_px)


def drowned(layer: Layer, water: tuple[float, float, float] | None) -> Layer:
    """Returns a layer seen through water: dimmer, most of all in red, and veiled by the water's colour."""
    if water is None:
        return layer
    veil = np.asarray(water, np.float32) * layer.alpha[..., None]
    return replace(layer, color=_through(layer.color, veil))


def _through(lit: FloatArray, veil: FloatArray) -> FloatArray:
    return np.asarray((1 - _VEIL) * _THROUGH_WATER * lit + _VEIL * veil, np.float32)


def without(layer: Layer, hidden: BoolArray) -> Layer:
    """Returns a layer less what stands behind something else, cut softly."""
    keep = 1 - cv2.GaussianBlur(hidden.astype(np.float32), (0, 0), 0.7)
    relief = np.where(hidden, np.float32(np.nan), layer.relief)
    shares = {name: getattr(layer, name) * keep for name in ("alpha", "limbs", "wings")}
    return replace(layer, color=layer.color * keep[..., None], relief=relief, **shares)


def _insert_image(
    request: Request,
    result: EditResult,
    geometry: Support,
    centre: tuple[float, float],
    width_px: float,
    seed: int,
    light: Light,
) -> EditResult:
    shape = (result.image.shape[0], result.image.shape[1])
    rgba = request.pixels if request.pixels is not None else cutout.load_cutout(request.path)
    layer, foot = cutout.card_layer(rgba, shape, centre, width_px, light.exposure)
    plane = placement.fit_plane(geometry, *centre, 0.6 * width_px)
    rows = np.nonzero((layer.alpha > 0.5).any(1))[0]
    height = float(np.ptp(rows) + 1) if len(rows) else 1.0
    ground = cutout.card_shadow(
        layer.alpha, foot, (float(light.direction[0]), float(light.direction[1])), height
    )
    gain = composite.shadow_gain(ground, light, layer.alpha)
    mask = (layer.alpha >= 0.5) & np.isfinite(layer.relief)
    base = cutout.card_lift(plane, foot, centre[0])
    relief, _ = placement.settle(
        layer.relief + np.float32(base), mask, np.fmin(geometry.relief, result.object_relief), width_px
    )
    finish = composite.Finish(0.35, composite.Finish.of(result.image).grain)
    under = composite.shadowed(result.image, gain, light)
    ground = under if result.ground is None else composite.shadowed(result.ground, gain, light)
    harmony = composite.harmony_of(result.image, layer)
    picture, alpha = composite.composite(under, layer, finish, seed, harmony)
    pose = Pose(np.eye(3), width_px, (*centre, base))
    placed = Placement("image", seed, request.tint, pose, plane, light, (0.2, 0.2, 0.2), width_px)
    flat = Depths(Plane(0.0, 0.0, base, 0.0, 0.0), 0.0, 1.0, np.zeros(shape, np.float32))
    depths = flat.in_contact(layer.relief, relief, 1.0)
    parts, _ = parts_of([Pane(picture, alpha, layer.relief)], under, depths)
    return merged(result, picture, relief, mask, alpha, gain, placed, ground, (parts, ()))


def _surroundings(
    image: FloatArray, centre: tuple[float, float], width_px: float
) -> tuple[float, float, float]:
    """Returns the mean linear colour of the picture around a spot."""
    h, w = image.shape[:2]
    r = 0.6 * width_px
    x0, y0 = int(max(centre[0] - r, 0)), int(max(centre[1] - r, 0))
    patch = image[y0 : int(min(centre[1] + r, h)) : 3, x0 : int(min(centre[0] + r, w)) : 3]
    mean = linear_from_srgb(patch).reshape(-1, 3).mean(0) if patch.size else np.full(3, 0.2)
    return float(mean[0]), float(mean[1]), float(mean[2])


def setting_of(placed: Placement, body: Body) -> Setting:
    """Returns the lights and directions that an object is shaded by, at every level."""
    up = placed.pose.camera_from_object[:, 2]
    eye = -np.array([*placed.pose.ray, 1.0])
    bounce = np.asarray(placed.bounce)
    key = placed.light.above(up)
    if body.refractive:  # a drop mirrors the sky's brightest part near its rim, not the flash's place
        key = key * (1.7, 1.7, 0.5)
        key /= np.linalg.norm(key)
    return Setting(
        placed.light, key, eye / np.linalg.norm(eye), up, bounce, Environment(placed.light, bounce)
    )


def plane_image(plane: Plane, shape: tuple[int, int]) -> FloatArray:
    """Returns (h, w) the relief of a plane."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    return plane(x + 0.5, y + 0.5).astype(np.float32)


def _bumps(relief: FloatArray, plane: Plane, width_px: float) -> FloatArray:
    """Returns what the support differs from its plane by, where it still is the same surface.

    A sliver of depth that sticks out is an error of the depth at an edge: it would be lit inside the shadow.
    """
    off = np.nan_to_num(relief - plane_image(plane, (relief.shape[0], relief.shape[1])))
    k = max(int(_SLIVER * width_px), 1) | 1
    without = cv2.morphologyEx(off, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (k, k)))
    off = np.where(without - off > _SPIKE * width_px, without, off)
    soft = np.clip(off, -0.12 * width_px, 0.12 * width_px).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(soft, (0, 0), max(0.008 * width_px, 0.6)), np.float32)
