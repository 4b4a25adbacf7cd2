"""What a body does to the light on what it stands on."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.objects import composite, placement
from wzviewer.worker.models.builtin.objects.placement import Plane, Support
from wzviewer.worker.models.builtin.objects.rays import BAND, Scene, parallel
from wzviewer.worker.models.builtin.objects.shading import Setting

_SLIVER, _SPIKE = 0.16, 0.06  # of the width: so narrow, and out by more
_NEAR = 0.4  # of a body's length: what is nearer than its ground by more is something else
_THEIRS = 0.05  # coverage: a pixel that has more of it shows an object
_CLEAR_SHADOW, _SHADOW_IN_WATER = 0.8, 0.35
_COARSE, _WIDE = 8, 3.0  # a soft shadow all round: px apart, farther by


@dataclass(frozen=True, eq=False)
class Ground:
    """The surface under a body.

    Attributes:
        seen: all that the view shows.
        own: of it the surface that the body stands on.
        plane: that surface's.
        past_edge: (h, w) share of a pixel beyond its edge.
        width_px: of the body.
        height: of the body above it, body lengths.
        aloft: whether it is too far below for a shadow.
    """

    seen: Support
    own: Support
    plane: Plane
    past_edge: FloatArray
    width_px: float
    height: float
    aloft: bool

    def gain(
        self, scene: Scene, setting: Setting, alpha: FloatArray, check: Callable[[], object] | None
    ) -> FloatArray:
        """Returns (h, w) what the picture keeps of its light beside a body of this coverage (h, w)."""
        lift_px = _bumps(self.own.relief, self.plane, self.width_px)
        slant = placement.from_above(scene.pose)
        slant_px = None if slant is None else _plane_image(slant, (scene.height, scene.width))
        arrived = _ground_shadow(scene, setting, lift_px, check, self.height, slant_px)
        gain = composite.shadow_gain(arrived, setting.light, alpha)
        if self.aloft:
            gain = np.ones_like(gain)
        gain = gain + self.past_edge * (1 - gain)  # a shadow of contact ends where its surface does
        if self.seen.sky is not None:
            gain = np.where(self.seen.sky, np.float32(1), gain)  # nothing darkens the sky
        return gain

    def behind_what_is_near(self, gain: FloatArray, size: float) -> FloatArray:
        """Returns a gain (h, w) without what clearly stands before a body of this length, native px."""
        shape = (gain.shape[0], gain.shape[1])
        near = self.seen.relief < _plane_image(self.plane, shape) - _NEAR * size
        return np.where(near, np.float32(1), gain)


def in_water(gain: FloatArray, cover: FloatArray | None) -> FloatArray:
    """Returns the gain (h, w) of a body under water: weak, and only where the water (h, w) is."""
    return np.asarray(1 - _SHADOW_IN_WATER * (1 - gain) * (1 if cover is None else cover), np.float32)


def through_clear(gain: FloatArray) -> FloatArray:
    """Returns the gain (h, w) of a clear body: it gathers light where an opaque one would cast its shadow."""
    return 1 - _CLEAR_SHADOW * (1 - gain)


def past_others(gain: FloatArray, others: FloatArray) -> FloatArray:
    """Returns a gain (h, w) that leaves alone what older objects hide: the shadow lies on those.

    Args:
        gain: (h, w) of the picture.
        others: (h, w) coverage by the older objects.
    """
    return np.where(others > _THEIRS, np.float32(1), gain)


def _ground_shadow(
    scene: Scene,
    setting: Setting,
    lift_px: FloatArray,
    check: Callable[[], object] | None = None,
    height: float = 0.0,
    slant_px: FloatArray | None = None,
) -> FloatArray:
    """Returns (h, w, 2) float32: shares of sky and key that reach the support, at half resolution inside.

    Args:
        scene: the body in its pose.
        setting: lights.
        lift_px: of any size, relief of the real support less that of the plane, native px, + = farther.
        check: called between bands.
        height: of the body above its ground, body lengths.
        slant_px: (h, w) the same as `lift_px` of another plane that is the ground; None if the body's own is.
    """
    near = _arrived(scene, setting, 2, 1.0, lift_px, height, slant_px, check)
    wide = _arrived(scene, setting, _COARSE, _WIDE, lift_px, height, slant_px, check)
    near[..., 0] *= wide[..., 0]
    return near


def _arrived(
    scene: Scene,
    setting: Setting,
    stride: int,
    wide: float,
    lift_px: FloatArray,
    height: float,
    slant_px: FloatArray | None,
    check: Callable[[], object] | None,
) -> FloatArray:
    """Returns the shares (h, w, 2) from points `stride` px apart, whose sky ends `wide` times as far."""
    h, w = -(-scene.height // stride), -(-scene.width // stride)
    rows, columns = np.meshgrid(np.arange(h), np.arange(w), indexing="ij")
    at = stride * np.stack([columns.ravel() + 0.5, rows.ravel() + 0.5], 1)
    corner, dx, dy, direction = scene.frame
    origin = corner + at[:, :1] * dx + at[:, 1:] * dy
    lengths_per_px = scene.pose.stretch / scene.pose.size_px
    lift = cv2.resize(lift_px, (w, h), interpolation=cv2.INTER_AREA).ravel()[:, None] * lengths_per_px
    length = -(origin[:, 2:] + height) / direction[2] + np.clip(lift, -0.15, 0.15)
    if slant_px is not None:
        slant = cv2.resize(slant_px, (w, h), interpolation=cv2.INTER_AREA).ravel()[:, None]
        length += slant * lengths_per_px
    points = origin + length * direction
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    near = np.linalg.norm(points[:, :2], axis=1) < 2.5
    out = np.ones((len(points), 2))
    index = np.flatnonzero(near)
    chunks = [index[k : k + BAND] for k in range(0, len(index), BAND)]
    light = setting.to_light
    parts = parallel(lambda c: scene.occlusion(points[c], normals[c], light, wide), chunks, check)
    for chunk, part in zip(chunks, parts, strict=True):
        out[chunk] = part
    size = (scene.width, scene.height)
    return cv2.resize(out.reshape(h, w, 2).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)


def _plane_image(plane: Plane, shape: tuple[int, int]) -> FloatArray:
    """Returns (h, w) the relief of a plane."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    return plane(x + 0.5, y + 0.5).astype(np.float32)


def _bumps(relief: FloatArray, plane: Plane, width_px: float) -> FloatArray:
    """Returns what the support differs from its plane by, where it is the same surface, at half its size.

    A sliver of depth that sticks out is an error of the depth at an edge: it would be lit inside the shadow.
    """
    h, w = relief.shape[0], relief.shape[1]
    off = np.nan_to_num(relief - _plane_image(plane, (h, w)))
    off = cv2.resize(off, (-(-w // 2), -(-h // 2)), interpolation=cv2.INTER_AREA)
    k = max(int(0.5 * _SLIVER * width_px), 1) | 1
    without = cv2.morphologyEx(off, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (k, k)))
    off = np.where(without - off > _SPIKE * width_px, without, off)
    soft = np.clip(off, -0.12 * width_px, 0.12 * width_px).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(soft, (0, 0), max(0.004 * width_px, 0.3)), np.float32)
