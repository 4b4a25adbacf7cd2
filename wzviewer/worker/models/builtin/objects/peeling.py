"""What of a body its own view hides: the trunk behind its limbs and wings, and its flanks.

Both come from more rays: straight on through what is thin, and from beside the view.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import composite
from wzviewer.worker.models.builtin.objects.composite import Finish
from wzviewer.worker.models.builtin.objects.march import CLOSE_PX
from wzviewer.worker.models.builtin.objects.parts import LEAST, Depths, Flanks, Pane, Part, parts_of
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.rays import Scene, march_all, shade_points, shoot
from wzviewer.worker.models.builtin.objects.render import Layer
from wzviewer.worker.models.builtin.objects.shading import Setting
from wzviewer.worker.models.builtin.objects.thin import LIMB, WING

ASIDE_DEG = (-20.0, 20.0)
_AHEAD_PX = 0.5  # nearer than what is behind by less, it is that
_NEAR_PX = 2.0  # for a footprint of one pixel: closer to what the view shows is what it shows
_OUTLINE = 0.5  # coverage beside full coverage: at an outline flanks stand edge on and are not seen beside it
_FIRM = 0.5  # coverage of what stays a surface when it is seen on its own: hairs would be dots
_STEEP = 0.25  # least cosine between a flank and its ray

Check = Callable[[], object] | None
Tone = Callable[[FloatArray], FloatArray]
Paint = Callable[[Layer], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True, eq=False)
class Studio:
    """How one body was drawn into a picture.

    Attributes:
        scene: the body in its pose.
        setting: lights.
        layer: its rendering.
        picture: (h, w, 3) sRGB with it.
        under: (h, w, 3) sRGB without it, in its shadow.
        paint: returns the picture of another layer of it, and its coverage.
        tone: linear colours (n, 3) to the picture's sRGB.
        finish: the picture's sharpness.
        depths: from marched relief to the level's.
    """

    scene: Scene
    setting: Setting
    layer: Layer
    picture: FloatArray
    under: FloatArray
    paint: Paint
    tone: Tone
    finish: Finish
    depths: Depths


def dismantled(studio: Studio, check: Check) -> tuple[tuple[Part, ...], FloatArray, tuple[Flanks, ...]]:
    """Returns a body's parts, what is under them (h, w, 3), and its flanks.

    A clear body is what is seen through it, in one part.
    """
    scene, layer = studio.scene, studio.layer
    if scene.body.refractive:
        alpha = composite.soften(layer.color, layer.alpha, studio.finish.blur_px)[1]
        return *parts_of([Pane(studio.picture, alpha, layer.relief)], studio.under, studio.depths), ()
    panes = _panes(studio, check)
    stride = 1 if scene.px > CLOSE_PX else 2
    found = [_seen_from(studio, panes, stride, deg, check) for deg in ASIDE_DEG]
    corners = np.concatenate([f[0] for f in found], axis=1)
    color, alpha = (np.concatenate([f[k] for f in found]) for k in (1, 2))
    flanks = Flanks(corners, studio.tone(color), alpha)
    return *parts_of(panes, studio.under, studio.depths), (flanks,)


def _panes(studio: Studio, check: Check) -> list[Pane]:
    """Returns what a body consists of along the view: behind its wings its limbs, behind those its trunk."""
    scene, layer, picture = studio.scene, studio.layer, studio.picture
    panes: list[Pane] = []
    for kind in (WING, LIMB):
        share = layer.wings if kind == WING else layer.limbs
        if not (share > 0).any():
            continue
        scene = scene.without(kind)
        bare = _without(scene, studio.setting, layer, share > 0, check)
        alpha = composite.soften(layer.color, share, studio.finish.blur_px)[1]
        ahead = (share > 0) & ~(layer.relief > bare.relief - _AHEAD_PX)
        behind = np.where(alpha[..., None] < LEAST, picture, studio.paint(bare)[0])
        marched = np.where(ahead, layer.relief, np.float32(np.nan))
        panes.insert(0, Pane(picture, alpha, marched, kind == WING))
        layer, picture = bare, behind
    alpha = composite.soften(layer.color, layer.alpha, studio.finish.blur_px)[1]
    return [Pane(picture, alpha, layer.relief), *panes]


def _without(bare: Scene, setting: Setting, layer: Layer, hidden: BoolArray, check: Check) -> Layer:
    """Returns a layer with more rays where something of it was hidden (h, w) that is there no more."""
    y, x = np.nonzero(hidden)
    samples = shoot(bare, setting, np.stack([x, y], 1).astype(np.float64) + 0.5, check)
    columns: dict[str, Any] = {
        "color": np.s_[:3],
        "alpha": 3,
        "relief": 4,
        "normal": np.s_[5:8],
        "limbs": 8,
        "wings": 9,
    }
    planes = {}
    for name, column in columns.items():
        planes[name] = getattr(layer, name).copy()
        planes[name][y, x] = samples[:, column]
    return replace(layer, **planes)


def _seen_from(
    studio: Studio, panes: list[Pane], stride: int, aside_deg: float, check: Check
) -> tuple[DoubleArray, FloatArray, FloatArray]:
    """Returns corners (3, n, 3), linear colour (n, 3) and coverage (n,) of hidden points from one side."""
    scene, depths = studio.scene, studio.depths
    toward = _direction(scene.pose, depths, aside_deg)
    beside = _beside(scene, studio.layer, toward, stride)
    rays = beside.pixels() + np.float64(0.5)
    depth, hit, normal = march_all(beside, rays, check)
    ray, layer = np.nonzero(hit >= 0)
    corner, dx, dy, direction = beside.frame
    points = corner + rays[ray, :1] * dx + rays[ray, 1:] * dy + depth[ray, layer][:, None] * direction
    own = _hidden(*_placed(scene.pose, points), panes, stride)
    points, normals, which, rays = points[own], normal[ray, layer][own], hit[ray, layer][own], rays[ray][own]
    if not len(points):
        return np.zeros((3, 0, 3)), np.zeros((0, 3), np.float32), np.zeros(0, np.float32)
    lights = replace(studio.setting, to_eye=-toward)
    color, opaque = shade_points(scene, lights, which, points, normals, rays)
    alpha = opaque * scene.opacity[which].astype(np.float32)
    kept = alpha > _FIRM
    points, normals, color, alpha = points[kept], normals[kept], color[kept], alpha[kept]
    corners = []
    for p in (points, *(points + _across(axis, normals, direction) for axis in (dx, dy))):
        at, marched = _placed(scene.pose, p)
        corners.append(np.column_stack([at, depths(at[:, 0], at[:, 1], marched)]))
    return np.stack(corners), color, alpha


def _direction(pose: Pose, depths: Depths, aside_deg: float) -> DoubleArray:
    """Returns the unit direction (3,) of rays from aside, in the axes of the view.

    The body stands sheared in the level: the ray is sheared back.
    """
    across, down = float(np.tan(np.deg2rad(aside_deg))) + pose.ray[0], pose.ray[1]
    ahead = 1.0 - depths.lift.slope_x * across - depths.lift.slope_y * down
    ray = np.array([across, down, max(ahead, 0.1)])
    return np.asarray(ray / np.linalg.norm(ray), np.float64)


def _beside(scene: Scene, layer: Layer, toward: DoubleArray, stride: int) -> Scene:
    """Returns the scene of rays from aside, about the middle of what is seen of the body."""
    pose, seen = scene.pose, np.isfinite(layer.relief)
    turn = _onto_axis(toward)
    y, x = np.nonzero(seen)
    middle = np.array([np.median(x) + 0.5, np.median(y) + 0.5, np.median(layer.relief[seen])])
    corner, dx, dy, direction = scene.frame
    length = (middle[2] - pose.position[2]) / pose.size_px * pose.stretch
    pivot = corner + middle[0] * dx + middle[1] * dy + length * direction
    rotation, size = turn @ pose.camera_from_object, pose.size_px / stride
    at = (pivot @ rotation.T) * size
    position = (middle[0] / stride - at[0], middle[1] / stride - at[1], 0.0)
    width, height = -(-scene.width // stride), -(-scene.height // stride)
    return Scene(scene.body, Pose(rotation, size, position), width, height)


def _onto_axis(d: DoubleArray) -> DoubleArray:
    """Returns the smallest rotation (3, 3) that takes a unit direction to the z axis."""
    c, v = d[2], np.array([d[1], -d[0], 0.0])
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray(np.eye(3) + k + k @ k / (1 + c), np.float64)


def _placed(pose: Pose, points: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Returns image positions (n, 2) and marched relief (n,) of object points (n, 3)."""
    return pose.project(points), pose.position[2] + (points @ pose.camera_from_object[2]) * pose.size_px


def _across(axis: DoubleArray, normals: DoubleArray, direction: DoubleArray) -> DoubleArray:
    """Returns the step (n, 3) on the surface that a step of the picture is."""
    facing = np.minimum(normals @ direction, -_STEEP)
    return np.asarray(axis - ((normals @ axis) / facing)[:, None] * direction, np.float64)


def _hidden(image: DoubleArray, marched: DoubleArray, panes: list[Pane], stride: int) -> BoolArray:
    """Tells which points an opaque pane hides from the view, that lie on no pane themselves.

    Args:
        image: (n, 2) where the view has them.
        marched: (n,) their relief there.
        panes: what the view sees.
        stride: side of their footprint, px.
    """
    h, w = panes[0].alpha.shape
    column, row = np.floor(image).astype(np.int64).T
    inside = (column >= 0) & (column < w) & (row >= 0) & (row < h)
    column, row = np.clip(column, 0, w - 1), np.clip(row, 0, h - 1)
    behind, apart = np.zeros(len(marched), bool), np.ones(len(marched), bool)
    ring = np.ones((3, 3), np.uint8)
    for pane in panes:
        known = np.isfinite(pane.marched)
        full = (known & (pane.alpha > 1 - LEAST)).astype(np.uint8)
        if pane is panes[0]:
            opaque = known & (pane.alpha > _OUTLINE) & (cv2.dilate(full, ring) > 0)
        else:  # beside a hair what is behind it is seen
            opaque = cv2.erode(full, ring) > 0
        shown, around = pane.marched[row, column], _slack(pane.marched, stride)[row, column]
        with np.errstate(invalid="ignore"):
            behind |= opaque[row, column] & (marched > shown + around)
            apart &= ~(np.abs(marched - shown) <= around)
    return np.asarray(inside & behind & apart, bool)


def _slack(marched: FloatArray, stride: int) -> FloatArray:
    """Returns how near to a relief (h, w) is on it: by its slope, but not across an edge of it."""
    window, known = np.ones((2 * stride + 1,) * 2, np.uint8), np.isfinite(marched)
    far = cv2.dilate(np.where(known, marched, np.float32(-1e30)), window) - marched
    near = marched - cv2.erode(np.where(known, marched, np.float32(1e30)), window)
    return np.asarray(_NEAR_PX * stride + np.minimum(far, near), np.float32)
