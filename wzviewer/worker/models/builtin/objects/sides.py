"""What of a body its level's own camera does not see: shot from beside it, and put where the body is.

::

    Placement ─► the front, coarsely ─► Fit: how its marched relief and colours became the picture's
              ─► four slanted views  ─► points that no other view has ─► shaded ─► by the Fit ─► Side
              ─► the back            ─► how far nothing else may be
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.aside import BEHIND_PX, Aside, Hits
from wzviewer.worker.models.builtin.objects.inserting import Check
from wzviewer.worker.models.builtin.objects.placed import Placement
from wzviewer.worker.models.builtin.objects.pose import Pose

ASIDE = ((-0.45, 0.0), (0.45, 0.0), (0.0, -0.36), (0.0, 0.36))  # added to the rays' slopes: 24, 20 degrees
_PITCH_PX, _POINTS = 2.0, 60_000  # of the views: that fine, coarser where bodies would have more points
_FEW = 40  # points: too few to say how a body became the picture
_COMPARED = 3000  # points of the front, at most
_OUTLIERS = 3.0  # times the median error: beyond it something else is in front
_ROUNDS = 3
_STEP_PX = 12.0  # native px of depth from a pixel to the next: an outline
_STEEP = 1.0  # native px of depth a px: what is steeper has gaps when seen from aside
_JUST_PX = 1.0  # native px behind the farthest of what is seen around a point
_DEPTH_PRIOR, _COLOR_PRIOR = 1.0, 1e-3  # px^2, sRGB^2: how much a slope is drawn to 1


@dataclass(frozen=True, eq=False)
class Side:
    """Points of bodies behind what the level's camera sees.

    Attributes:
        places: (n, 2) float64 x, y in the level's image, px.
        relief: (n,) float64 native px about the anchor.
        tangents: (n, 2, 3) float64 native px, from a point to its neighbours to the right and below.
        colors: (n, 3) float32 sRGB.
        back: (h, w) float32 native px, where a body ends; -inf where there is none.
    """

    places: DoubleArray
    relief: DoubleArray
    tangents: DoubleArray
    colors: FloatArray
    back: FloatArray

    @classmethod
    def none(cls, shape: tuple[int, int]) -> "Side":
        """Returns no points."""
        back = np.full(shape, -np.inf, np.float32)
        return cls(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2, 3)), np.zeros((0, 3), np.float32), back)

    def take(self, index: BoolArray) -> "Side":
        """Returns some of the points."""
        return Side(
            self.places[index], self.relief[index], self.tangents[index], self.colors[index], self.back
        )

    @classmethod
    def joined(cls, parts: "list[Side]") -> "Side":
        """Joins the points of at least one side, in order."""
        columns = [[getattr(p, k) for p in parts] for k in ("places", "relief", "tangents", "colors")]
        places, relief, tangents, colors = (np.concatenate(column) for column in columns)
        return cls(places, relief, tangents, colors, np.max([p.back for p in parts], axis=0))


@dataclass(frozen=True, eq=False)
class _Fit:
    """How a marched body became what the level shows.

    Attributes:
        depth: (4,) weights of marched relief, 1, x and y in the final relief.
        gains: (3,) of the colour channels.
        offsets: (3,).
    """

    depth: DoubleArray
    gains: DoubleArray
    offsets: DoubleArray

    @classmethod
    def of(cls, view: Aside, front: Hits, image: FloatArray, relief: FloatArray) -> "_Fit | None":
        """Compares the front of a body with a level's image and relief; None where too little is seen."""
        found = _linear(_terms(front), _at(relief, front.places), _DEPTH_PRIOR)
        if found is None:
            return None
        depth, close = found
        seen = front.take(close).take(slice(None, None, max(int(close.sum()) // _COMPARED, 1)))
        colors, shown = view.shade(seen)[0], _at(image, seen.places)
        one = np.ones(len(colors))
        fits = [_linear(np.stack([colors[:, k], one], 1), shown[:, k], _COLOR_PRIOR) for k in range(3)]
        gains, offsets = np.array([(1.0, 0.0) if fit is None else fit[0] for fit in fits]).T
        return cls(depth, gains, offsets)

    def relief_of(self, hits: Hits) -> DoubleArray:
        """Returns (n,) final relief."""
        return np.asarray(_terms(hits) @ self.depth)

    def colors_of(self, colors: FloatArray) -> FloatArray:
        """Returns (n, 3) sRGB colours as in the picture."""
        return np.clip(colors * self.gains + self.offsets, 0, 1).astype(np.float32)

    def level_from_marched(
        self, hits: Hits, pose: Pose, size: tuple[int, int], focal_px: float
    ) -> DoubleArray:
        """Returns the (3, 3) derivative of a point in the level's frame by its place in the marched space."""
        a, _, by_x, by_y = self.depth
        place_x, place_y = np.array([1.0, 0.0, -pose.ray[0]]), np.array([0.0, 1.0, -pose.ray[1]])
        deep = a * np.array([0.0, 0.0, 1.0]) + by_x * place_x + by_y * place_y
        ray = (hits.places.mean(0) - np.asarray(size) / 2) / focal_px
        reach = 1.0 + float(self.relief_of(hits).mean()) / focal_px
        return np.stack([reach * place_x + ray[0] * deep, reach * place_y + ray[1] * deep, deep])


def sides_of(
    placed: Placement,
    mapping: tuple[float, float, float],
    image: FloatArray,
    relief: FloatArray,
    mask: BoolArray,
    focal_px: float,
    check: Check,
) -> Side:
    """Returns what of a body lies behind a level's image, as far as it is seen from 20 degrees aside.

    Args:
        placed: the body.
        mapping: from the image that it was put into to this one, see `ObjectEditor.continue_into`.
        image: (h, w, 3) float32 sRGB.
        relief: (h, w) float32 native px about the anchor.
        mask: (h, w) bool, where bodies are.
        focal_px: of the level's camera.
        check: called between the views.
    """
    h, w = mask.shape
    size, pose = (w, h), placed.pose.seen_from(*mapping)
    pitch_px = max(_PITCH_PX, float(np.sqrt(mask.sum() / _POINTS)))
    view = Aside(placed, pose, size, pitch_px)
    front = view.march(solid=False)
    front = front.take(_at(mask, front.places) > 0)
    fit = _Fit.of(view, front, image, relief) if len(front.relief) >= _FEW else None
    if fit is None:
        return Side.none((h, w))
    level_px, views = float(np.median(front.relief)), list[Aside]()
    sides = [_back(placed, pose, size, pitch_px, fit)]
    to_level = fit.level_from_marched(front, pose, size, focal_px)
    for slope in ASIDE:
        if check is not None:
            check()
        view = Aside(placed, pose, size, pitch_px, slope, level_px)
        hits = view.march()
        new = view.faces(hits) & np.all((hits.places >= 0) & (hits.places < size), axis=1)
        new &= _at(mask, hits.places) > 0
        for other in views:
            new &= ~other.sees(hits)
        views.append(view)
        hits = hits.take(new)
        hidden, depth = _hidden(view, hits, pose, fit.relief_of(hits), relief)
        hidden &= depth < np.maximum(_at(sides[0].back, hits.places), fit.relief_of(hits)) + _JUST_PX
        colors, solid = view.shade(hits := hits.take(hidden))
        tangents = view.tangents(hits) @ to_level.T
        side = Side(hits.places, depth[hidden], tangents, fit.colors_of(colors), sides[0].back)
        sides.append(side.take(solid))
    return Side.joined(sides)


def _hidden(
    view: Aside, hits: Hits, pose: Pose, depth: DoubleArray, relief: FloatArray
) -> tuple[BoolArray, DoubleArray]:
    """Returns which points (n,) the level's image does not show well, and how deep they go behind it.

    What is hidden stays where it is.  A steep surface is in the image, but with wide gaps when seen from
    aside: its points go just behind it.  At an outline of the front they would look out beside it.

    Args:
        view: that saw them.
        hits: (n) in the image.
        pose: of the body in the image.
        depth: (n,) final relief of the points.
        relief: (h, w) of the image.
    """
    normals = hits.normals @ pose.camera_from_object.T
    facing = -(normals @ np.array([*pose.ray, 1.0]))
    slope = np.where(facing > 0, np.linalg.norm(normals[:, :2], axis=1) / np.maximum(facing, 1e-3), np.inf)
    reaches = 0, round(0.7 * view.pitch_px), round(1.2 * view.pitch_px)
    front, next_to, around = (_at(_farthest(relief, k), hits.places) for k in reaches)
    behind = np.where(around - front < _STEP_PX * 2, around, next_to) + _JUST_PX
    shown = (slope < _STEEP) & (depth < front + BEHIND_PX)
    return ~shown & (next_to - front < _STEP_PX), np.maximum(depth, behind)


def _farthest(relief: FloatArray, reach_px: int) -> FloatArray:
    """Returns (h, w) the farthest within a distance."""
    return np.asarray(cv2.dilate(relief, np.ones((2 * reach_px + 1,) * 2, np.uint8)), np.float32)


def _back(placed: Placement, pose: Pose, size: tuple[int, int], pitch_px: float, fit: _Fit) -> Side:
    """Returns where a body ends along the level's rays, and no points."""
    hits = Aside(placed, pose, size, pitch_px, from_behind=True).march()
    w, h = (int(np.ceil(n / pitch_px)) for n in size)
    small = np.full((h, w), -np.inf, np.float32)
    column, row = hits.rays.astype(np.int64).T
    small[row, column] = fit.relief_of(hits)
    side = Side.none((size[1], size[0]))
    side.back[:] = cv2.resize(small, size, interpolation=cv2.INTER_NEAREST)
    return side


def _at(picture: FloatArray | BoolArray, places: DoubleArray) -> DoubleArray:
    """Returns values of a picture (h, w, ...) at places (n, 2), of the nearest pixel."""
    h, w = picture.shape[:2]
    column, row = np.floor(places).astype(np.int64).T
    return picture[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)].astype(np.float64)


def _terms(hits: Hits) -> DoubleArray:
    x, y = hits.places.T
    return np.stack([hits.relief, np.ones(len(x)), x, y], 1)


def _linear(terms: DoubleArray, aims: DoubleArray, prior: float) -> tuple[DoubleArray, BoolArray] | None:
    """Fits aims (n,) by terms (n, k), the first drawn to 1; returns (weights, inliers), or None of few."""
    kept, weights = np.isfinite(aims), np.zeros(terms.shape[1])
    pull = np.zeros(terms.shape[1])
    pull[0] = prior
    for _ in range(_ROUNDS):
        if kept.sum() < _FEW:
            return None
        own, n = terms[kept].astype(np.float64), int(kept.sum())
        square, right = own.T @ own / n + np.diag(pull), own.T @ aims[kept] / n + pull
        weights = np.asarray(np.linalg.lstsq(square, right, rcond=None)[0])
        error = np.abs(terms @ weights - aims)
        kept = np.isfinite(error) & (error <= _OUTLIERS * max(float(np.median(error[kept])), 1e-3))
    return weights, np.asarray(kept)
