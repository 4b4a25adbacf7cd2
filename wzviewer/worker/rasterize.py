"""The worker's surfel rasteriser: any number of levels from any camera.

::

    render(parts, camera)              lines 12, 13, 21, 28 of Algorithm 1
        LevelPart ... ──project──► joint order ──composite──► Rendering(color, relief, coverage)

The formulas are those of the shaders, with the constants of :mod:`wzviewer.core.constants`; the loops
are in :mod:`wzviewer.kernels`, the gradient in :mod:`wzviewer.worker.objective`.  Results do not
depend on the number of threads.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.kernels import binning, forward, projection
from wzviewer.kernels.elementary import KERNELS

Blend = Literal["transmittance", "linear"]
BLACK = (0.0, 0.0, 0.0)
_REACH_UNLIMITED_PX = 1e7
VIEW_MAX = 1e30  # of a number in the view vector; beyond it the camera sits in the anchor plane


@dataclass(frozen=True, eq=False)
class LevelPart:
    """Surfels of one level to be rendered together with those of others.

    Attributes:
        surfels: in the level's local frame.
        origin: anchor of the frame, (3,) float64, world units.
        axes: (3, 3) float64, rows are the local axes in the world.
        unit: world units per local unit.
        weights: (n,) Eq. 3 weight of every surfel, or None for 1.
    """

    surfels: Surfels
    origin: DoubleArray
    axes: DoubleArray
    unit: float
    weights: FloatArray | None = None

    @classmethod
    def of(cls, surfels: Surfels, frame: LevelFrame, weights: FloatArray | None = None) -> "LevelPart":
        """Returns the part of a level with this frame."""
        return cls(surfels, frame.origin, frame.axes, frame.unit, weights)

    @property
    def frame(self) -> LevelFrame:
        """The local frame."""
        return LevelFrame(self.origin, self.axes, self.unit)


@dataclass(frozen=True, eq=False)
class Rendering:
    """What a camera sees.

    Attributes:
        color: (h, w, 3) float32, over the background.
        relief: (h, w) float32 median depth, ``(z - z0) / u0`` of the depth anchor; nan where the
            transmittance stays above 0.5, or everywhere when depth was not asked for.
        coverage: (h, w) float32, 1 - transmittance.
    """

    color: FloatArray
    relief: FloatArray
    coverage: FloatArray


@dataclass(frozen=True, eq=False)
class _Projected:
    """The visible surfels of all parts, in the order (part, index); ``keys`` sort them by depth."""

    rows: FloatArray
    colors: FloatArray
    weights: FloatArray
    reliefs: FloatArray
    keys: binning.Keys
    weighted: bool


def render(
    parts: Sequence[LevelPart],
    camera: Camera,
    background: tuple[float, float, float] = BLACK,
    blend: Blend = "transmittance",
    depth: bool = True,
    depth_anchor: tuple[float, float] | None = None,
) -> Rendering:
    """Renders levels together, front to back by the depth of the surfels' centres.

    Args:
        parts: levels; ties in depth go by (part, index).
        camera: any pose and principal point; nothing but ``z > 0`` limits the depth.
        background: sRGB colour behind everything.
        blend: "transmittance" makes an alpha ``1 - (1 - alpha)^w``; "linear" is Eq. 2, ``alpha w``.
        depth: also find the median depth (about as long again as the colour).
        depth_anchor: (z0, u0) in world units that ``relief`` is relative to; by default the depth of
            the first part's origin from this camera, and its unit.
    """
    views = [AnchoredView.expand(camera, part.frame) for part in parts]
    anchor = depth_anchor or ((views[0].depth, parts[0].unit) if parts else (1.0, 1.0))
    with KERNELS:
        scene = _project_parts(parts, views, camera, anchor)
        order = binning.sorted_indices(scene.keys)
        lists = binning.bin_tiles(scene.rows, order, camera.width, camera.height)
        image, through = _composite(scene, lists, camera, background, blend)
        relief = _median(scene, lists, camera, blend) if depth else None
    size = (slice(0, camera.height), slice(0, camera.width))
    if relief is None:
        relief = np.full(through.shape, np.nan, np.float32)
    color = np.ascontiguousarray(image[:, *size].transpose(1, 2, 0))
    return Rendering(color, relief[size].copy(), np.float32(1.0) - through[size])


def _project_parts(
    parts: Sequence[LevelPart],
    views: Sequence[AnchoredView],
    camera: Camera,
    anchor: tuple[float, float],
) -> _Projected:
    """Projects, culls and joins the parts; sort keys are relative to the finest part's anchor."""
    visible = [_project_part(p, v, camera) for p, v in zip(parts, views, strict=True)]
    finest = min(range(len(parts)), key=lambda k: parts[k].unit, default=0)
    focus = (views[finest].depth, parts[finest].unit) if parts else anchor
    keys, reliefs, count = [], [], 0
    for part, view, (rows, _, depths, _) in zip(parts, views, visible, strict=True):
        packed = np.empty(len(rows), np.uint64)
        offset = (view.depth - focus[0]) / focus[1]
        kept = binning.depth_keys(rows, depths, offset, part.unit / focus[1], count, packed)
        keys.append(packed[:kept])
        shift, ratio = (view.depth - anchor[0]) / anchor[1], part.unit / anchor[1]
        reliefs.append(
            depths if (shift, ratio) == (0.0, 1.0) else (shift + ratio * depths).astype(np.float32)
        )
        count += len(rows)
    weights = _join([v[3] for v in visible])
    return _Projected(
        _join([v[0] for v in visible], 8),
        _join([v[1] for v in visible], 3),
        weights,
        _join(reliefs),
        np.concatenate(keys) if keys else np.empty(0, np.uint64),
        bool((weights != 1).any()),
    )


def _join(arrays: list[FloatArray], columns: int | None = None) -> FloatArray:
    if len(arrays) == 1:
        return arrays[0]
    empty = np.empty((0, columns) if columns else 0, np.float32)
    return np.concatenate([empty, *arrays])


def _project_part(
    part: LevelPart, view: AnchoredView, camera: Camera
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Returns rows, colours, depths and weights of the surfels that can be seen, in their order."""
    surfels, n = part.surfels, len(part.surfels)
    weights = np.ones(n, np.float32) if part.weights is None else np.asarray(part.weights, np.float32)
    packed = projection.view_vector(view.rows, view.z_axis, view.depth)
    rows, depths = np.empty((n, 8), np.float32), np.empty(n, np.float32)
    if n == 0 or not np.all(np.abs(packed) < VIEW_MAX) or not weights.any():
        return rows[:0], surfels.colors[:0], depths[:0], weights[:0]
    values = (surfels.means, surfels.quats, surfels.scales, surfels.opacities)
    size = (camera.width, camera.height)
    projection.project(*values, packed, *size, _REACH_UNLIMITED_PX, rows, depths)
    seen = (rows[:, 6] >= 0) & (weights > 0)
    if seen.all():
        return rows, surfels.colors, depths, weights
    index = np.flatnonzero(seen)
    return rows[index], surfels.colors[index], depths[index], weights[index]


def padded_shape(camera: Camera) -> tuple[int, int]:
    """Returns (H, W), the image size rounded up to whole tiles."""
    t = binning.TILE
    return -(-camera.height // t) * t, -(-camera.width // t) * t


def _composite(
    scene: _Projected,
    lists: tuple[binning.Offsets, binning.Indices],
    camera: Camera,
    background: tuple[float, float, float],
    blend: Blend,
) -> tuple[FloatArray, FloatArray]:
    """Returns the image (3, H, W) and the transmittance (H, W), padded to whole tiles."""
    image = np.empty((3, *padded_shape(camera)), np.float32)
    through = np.empty(image.shape[1:], np.float32)
    behind = np.asarray(background, np.float32)
    if scene.weighted:
        laws = (scene.weights, blend == "linear")
        forward.composite_weighted(scene.rows, scene.colors, *laws, *lists, behind, *image, through)
    else:
        forward.composite(scene.rows, scene.colors, *lists, behind, *image, through)
    return image, through


def _median(
    scene: _Projected, lists: tuple[binning.Offsets, binning.Indices], camera: Camera, blend: Blend
) -> FloatArray:
    relief = np.empty(padded_shape(camera), np.float32)
    through = np.empty_like(relief)
    laws = (scene.weights, blend == "linear")
    forward.median_relief(scene.rows, scene.reliefs, *laws, *lists, relief, through)
    relief[through > 0.5] = np.nan
    return relief


def warm_up() -> None:
    """Compiles every kernel, or loads it from the cache, on a scene of 256 surfels."""
    # deferred: the stage imports this module
    from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
    from wzviewer.worker.stages.stage5_optimization import optimize

    camera = Camera.initial(16, 16)
    image, relief = np.full((16, 16, 3), 0.5, np.float32), np.zeros((16, 16), np.float32)
    frame = LevelFrame.of_camera(camera, 1.0)
    surfels = optimize(generate_surfels(image, relief, camera), image, camera, frame, steps=1, color_steps=1)
    for weights in (None, np.full(len(surfels), 0.5, np.float32)):
        render([LevelPart.of(surfels, frame, weights)], camera)
