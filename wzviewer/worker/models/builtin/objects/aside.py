"""A body along slanted rays: what a pose shows from beside its camera, in the same image.

The rays of a pose are parallel; with another slope they see the body from aside, in the same image plane.
So a point of such a view has a place in the image, and lies there behind what the image shows.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.composite import toned
from wzviewer.worker.models.builtin.objects.inserting import body_of, setting_of
from wzviewer.worker.models.builtin.objects.placed import Placement
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.render import BAND, LongArray, Scene, parallel, shade_points

BEHIND_PX = 2.5  # native px behind what is seen: nearer is the seen surface itself
_MARGIN = 0.08  # of the image, around it: what is seen beside its border may lie inside
_SOLID = 0.5  # opacity of what hides what is behind it
_EDGE_ON = 0.25  # cosine: a surface that faces a view less is left to the others


@dataclass(frozen=True, eq=False)
class Hits:
    """Points of a body that a view sees.

    Attributes:
        rays: (n, 2) pixels of the view.
        places: (n, 2) px of the image.
        relief: (n,) px of the image, as marched.
        hit: (n,) primitives.
        points: (n, 3) in the body.
        normals: (n, 3) in the body.
    """

    rays: DoubleArray
    places: DoubleArray
    relief: DoubleArray
    hit: LongArray
    points: DoubleArray
    normals: DoubleArray

    def take(self, index: BoolArray | slice) -> "Hits":
        """Returns some of them."""
        return Hits(*(getattr(self, f.name)[index] for f in fields(self)))


class Aside:
    """A body seen along rays of another slope, or from behind.

    Args:
        placed: the body.
        pose: in the image.
        size: width and height of the image, px.
        pitch_px: of the view's pixels, native px.
        slope: added to the rays' slopes, (x, y).
        level_px: marched relief that is seen at the same place from everywhere.
        from_behind: along the same rays the other way.
    """

    def __init__(
        self,
        placed: Placement,
        pose: Pose,
        size: tuple[int, int],
        pitch_px: float,
        slope: tuple[float, float] = (0.0, 0.0),
        level_px: float = 0.0,
        from_behind: bool = False,
    ) -> None:
        body = body_of(placed.name, placed.seed, placed.tint)
        self._slope, self._level_px, self.pitch_px = np.asarray(slope), level_px, pitch_px
        self._margin = _MARGIN * size[0] if any(slope) else 0.0
        x, y, z = pose.position
        self.pose = replace(
            pose,
            position=(x + (level_px - z) * slope[0], y + (level_px - z) * slope[1], z),
            ray=(pose.ray[0] + slope[0], pose.ray[1] + slope[1]),
        )
        self._setting = setting_of(replace(placed, pose=replace(placed.pose, ray=self.pose.ray)), body)
        self._flip = -1.0 if from_behind else 1.0
        seen = _turned(self.pose) if from_behind else self.pose
        seen = seen.seen_from(-self._margin, -self._margin, 1 / self.pitch_px)
        w, h = (int(np.ceil((n + 2 * self._margin) / self.pitch_px)) for n in size)
        self._scene = Scene(body, seen, w, h)
        self._nearest = np.full((h, w), np.inf)

    def march(self, solid: bool = True) -> Hits:
        """Returns the first solid point of each ray, or the first of any kind."""
        rays = self._scene.pixels() + np.float64(0.5)
        pieces = [rays[k : k + BAND] for k in range(0, len(rays), BAND)] or [rays]
        marched = parallel(self._scene.march, pieces, None)
        depth, hit, normal = (np.concatenate(column) for column in zip(*marched, strict=True))
        least = _SOLID if solid else 0.0
        opaque = (hit >= 0) & (self._scene.opacity[np.maximum(hit, 0)] >= least)
        r = np.flatnonzero(opaque.any(axis=1))
        k, at = np.argmax(opaque[r], axis=1), rays[r]
        corner, dx, dy, direction = self._scene.frame
        points = corner + at[:, :1] * dx + at[:, 1:] * dy + depth[r, k][:, None] * direction
        z = self.pose.position[2]
        relief = z + self._flip * (self.pitch_px * self._scene.pose.relief(depth[r, k]) - z)
        column, row = at.astype(np.int64).T
        self._nearest[row, column] = relief
        places = at * self.pitch_px - self._margin + (relief - self._level_px)[:, None] * self._slope
        return Hits(at, places, relief, hit[r, k], points, normal[r, k])

    def faces(self, hits: Hits) -> BoolArray:
        """Tells which of its own points (n,) lie on a surface that is turned to this view."""
        ray = np.array([*self.pose.ray, 1.0])
        cosine = -(hits.normals @ self.pose.camera_from_object.T @ ray) / np.linalg.norm(ray)
        return np.asarray(cosine > _EDGE_ON)

    def sees(self, hits: Hits) -> BoolArray:
        """Tells which points (n,) of another view this one has seen."""
        own = hits.places - (hits.relief - self._level_px)[:, None] * self._slope
        column, row = np.floor((own + self._margin) / self.pitch_px).astype(np.int64).T
        h, w = self._nearest.shape
        inside = (column >= 0) & (column < w) & (row >= 0) & (row < h)
        nearest = self._nearest[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)]
        return np.asarray(inside & (hits.relief <= nearest + BEHIND_PX))

    def shade(self, hits: Hits) -> tuple[FloatArray, BoolArray]:
        """Returns colours (n, 3) sRGB, before they meet a picture, and whether they are solid (n,)."""
        pieces = [hits.take(slice(k, k + BAND)) for k in range(0, len(hits.rays), BAND)] or [hits]
        shaded = parallel(self._shade, pieces, None)
        color, opaque = (np.concatenate(column) for column in zip(*shaded, strict=True))
        return toned(color), np.asarray(opaque >= _SOLID)

    def _shade(self, hits: Hits) -> tuple[FloatArray, FloatArray]:
        return shade_points(self._scene, self._setting, hits.hit, hits.points, hits.normals, hits.rays)

    def tangents(self, hits: Hits) -> DoubleArray:
        """Returns (n, 2, 3) camera axes, px of the image: from points that it faces to their neighbours."""
        normals = hits.normals @ self.pose.camera_from_object.T
        ray = np.array([*self.pose.ray, 1.0])
        steps = self.pitch_px * np.eye(3)[:2]
        along = -(normals[:, :2] * self.pitch_px) / (normals @ ray)[:, None]
        return np.asarray(steps + along[:, :, None] * ray)


def _turned(pose: Pose) -> Pose:
    """Returns a pose that shows, at the same pixels, what its rays meet on their way back."""
    mirrored = pose.camera_from_object * np.array([[1.0], [1.0], [-1.0]])
    return replace(pose, camera_from_object=mirrored, ray=(-pose.ray[0], -pose.ray[1]))
