"""Inserting one object into a picture: light, pose, march, shadow, composite, contact."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects import composite, placement
from wzviewer.worker.models.builtin.objects.bodies import Body, Tint
from wzviewer.worker.models.builtin.objects.cards import insert_card
from wzviewer.worker.models.builtin.objects.footing import footing
from wzviewer.worker.models.builtin.objects.grammar import Request
from wzviewer.worker.models.builtin.objects.ground import Ground, in_water, past_others, through_clear
from wzviewer.worker.models.builtin.objects.lighting import (
    Environment,
    Light,
    light_from_photo,
    linear_from_srgb,
)
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS, FLYING
from wzviewer.worker.models.builtin.objects.parts import Depths
from wzviewer.worker.models.builtin.objects.peeling import Studio, dismantled
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, held, merged, shifted
from wzviewer.worker.models.builtin.objects.placement import Plane, Support
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import Layer, render
from wzviewer.worker.models.builtin.objects.shading import Setting
from wzviewer.worker.models.builtin.objects.substances import recast
from wzviewer.worker.models.builtin.objects.surfaces import beyond, on_front
from wzviewer.worker.models.builtin.objects.words import ALOFT

Check = Callable[[], object] | None
_HOVER = 0.40  # body lengths above its place
_VEIL = 0.45  # share of what is seen under water that is the water
_THROUGH_WATER = np.array([0.62, 0.86, 0.94], np.float32)
_BLUR_IN_WATER_PX = 1.2


@lru_cache(maxsize=6)
def body_of(name: str, seed: int, tint: Tint) -> Body:
    """Returns a body, built once."""
    return recast((BUILDERS.get(name) or FLYING[name])(np.random.default_rng(seed), tint), tint)


@dataclass(frozen=True, eq=False)
class _Stand:
    """A body in its place, before any ray is shot.

    Attributes:
        body: what stands there.
        placed: its pose, light and surroundings.
        ground: what it stands on.
        share: how far it is, the level's anchor being 1.
        at: relief of its place, native px.
    """

    body: Body
    placed: Placement
    ground: Ground
    share: float
    at: float

    @property
    def size(self) -> float:
        """Its length in the anchor's px."""
        return self.share * self.placed.pose.size_px


@dataclass(frozen=True, eq=False)
class _Touch:
    """A body in contact with its ground.

    Attributes:
        mask: (h, w) where it is in front.
        relief: (h, w) its depth there.
        hidden: (h, w) where something else is in front of it.
        depths: from its marched relief to the level's.
        shift: by how much it was moved along the rays, native px.
    """

    mask: BoolArray
    relief: FloatArray
    hidden: BoolArray
    depths: Depths
    shift: float


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
        return insert_card(request, result, geometry, centre, width_px, seed, light)
    stand = _stand(request, result.image, geometry, centre, width_px, seed, light)
    body, placed = stand.body, stand.placed
    h, w = result.image.shape[:2]
    scene, setting = Scene(body, placed.pose, w, h), setting_of(placed, body)
    layer = drowned(render(scene, setting, check), placed.water)
    layer = layer if cover is None else without(layer, cover < 0.5)
    gain = stand.ground.gain(scene, setting, layer.alpha, check)
    gain = gain if placed.water is None else in_water(gain, cover)
    touch = _touching(stand, layer, result.object_relief)
    if touch.hidden.any():
        layer, gain = without(layer, touch.hidden), stand.ground.behind_what_is_near(gain, stand.size)
    gain = through_clear(gain) if body.refractive else gain
    harmony = composite.harmony_of(result.image, layer)
    studio, alpha = _painted(stand, scene, setting, layer, touch.depths, result.image, gain, seed, harmony)
    bare = studio.under
    if result.ground is not None:
        bare = composite.shadowed(result.ground, past_others(gain, result.others), placed.light)
    parts, below, flanks = dismantled(studio, check) if apart else ((), studio.under, ())
    bare = bare + (below - studio.under)
    placed = replace(shifted(placed, touch.shift), chroma=harmony.chroma)
    return merged(
        result, studio.picture, touch.relief, touch.mask, alpha, gain, placed, bare, (parts, flanks)
    )


def _stand(
    request: Request,
    image: FloatArray,
    geometry: Support,
    centre: tuple[float, float],
    width_px: float,
    seed: int,
    light: Light | None,
) -> _Stand:
    """Finds a body its place, its pose there and the light."""
    name = flight if request.hovers and (flight := f"{request.name} in flight") in FLYING else request.name
    body = body_of(name, seed, request.tint)
    height = _HOVER if request.hovers else 0.0
    rests = height == 0 and not request.submerged
    lies = rests and not placement.stands(body)
    if lies and request.count == 1 and not request.place:
        centre = on_front(geometry, centre, width_px)
    past_edge = beyond(geometry, centre, width_px) if lies else np.zeros_like(geometry.relief)
    own = replace(geometry, relief=np.where(past_edge > 0.5, np.float32(np.nan), geometry.relief))
    light = light or light_from_photo(image, centre, 0.5 * width_px)
    pose, plane = _posed(body, own, centre, width_px, np.random.default_rng([seed, 5]), stands=rests)
    bounce = _surroundings(image, centre, width_px)
    at = pose.position[2]
    share = geometry.range_at(at)
    lift = placement.lift_onto(pose, plane.at_range(share))
    water = bounce if request.submerged else None
    pose = placement.hovering(pose, height)
    placed = Placement(name, seed, request.tint, pose, lift, light, bounce, width_px, water)
    aloft = bool(ALOFT & set(request.place))
    return _Stand(body, placed, Ground(geometry, own, plane, past_edge, width_px, height, aloft), share, at)


def _touching(stand: _Stand, layer: Layer, others: FloatArray) -> _Touch:
    """Brings a rendered body into contact with the support and with other objects' relief (h, w)."""
    ground, pose, share = stand.ground, stand.placed.pose, stand.share
    mask = held(layer.alpha, layer.relief)
    depths = Depths(stand.placed.lift, stand.at, share, np.zeros(mask.shape, np.float32))
    relief = np.where(mask, depths.of_image(layer.relief), np.float32(np.nan))
    behind, floats = np.fmin(ground.seen.relief, others), ground.height > 0
    hidden = placement.hidden_by(behind, relief, mask, stand.size) & (not floats)
    relief, shift = placement.settle(relief, mask, behind, pose.size_px, floats=floats, share=share)
    depths = depths.in_contact(layer.relief, relief, pose.size_px / 24)
    return _Touch(mask & ~hidden, relief, hidden, depths, shift)


def _painted(
    stand: _Stand,
    scene: Scene,
    setting: Setting,
    layer: Layer,
    depths: Depths,
    image: FloatArray,
    gain: FloatArray,
    seed: int,
    harmony: composite.Harmony,
) -> tuple[Studio, FloatArray]:
    """Puts a body into a picture in its shadow; returns how that was done, and its coverage (h, w)."""
    body, water = stand.body, stand.placed.water
    finish = composite.Finish.of(image)
    if water is not None:
        finish = composite.Finish(_BLUR_IN_WATER_PX, finish.grain)
    under = composite.shadowed(image, gain, stand.placed.light)

    def paint(of: Layer) -> tuple[FloatArray, FloatArray]:
        if body.refractive:
            picture, alpha = composite.refract(image, of, under, finish, setting.to_light, body.clear)
        else:
            picture, alpha = composite.composite(under, of, finish, seed, harmony)
        return (picture if water is None else composite.rippled(picture, image, alpha)), alpha

    picture, alpha = paint(layer)
    tone = toned(harmony, water)
    return Studio(scene, setting, layer, picture, under, paint, tone, finish, depths), alpha


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
