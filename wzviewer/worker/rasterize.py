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

import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.reference import Blend, depth_row, focus_of
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import DoubleArray, FloatArray, IntArray
from wzviewer.kernels import binning
from wzviewer.kernels.elementary import KERNELS
from wzviewer.kernels.splatting import Splatter

BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class LevelPart:
    """Surfels of one level to be rendered together with those of others.

    Attributes:
        surfels: in the level's local frame.
        origin: anchor of the frame, (3,) float64, world units.
        axes: (3, 3) float64, rows are the local axes in the world.
        unit: world units per local unit.
        weights: (n,) Eq. 3 weight of every surfel, or None for 1.
        back: the level's `core.reference.setback`; of one level by itself it changes nothing.
    """

    surfels: Surfels
    origin: DoubleArray
    axes: DoubleArray
    unit: float
    weights: FloatArray | None = None
    back: float = 0.0

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
    splatter, focus = Splatter(), focus_of(camera, [part.frame for part in parts])
    splatter.begin(sum(len(part.surfels) for part in parts), camera.width, camera.height)
    views = [AnchoredView.expand(camera, part.frame) for part in parts]
    size = (slice(0, camera.height), slice(0, camera.width))
    with KERNELS:
        for part, view in zip(parts, views, strict=True):
            row = depth_row(view, part.frame, focus, part.back)
            splatter.add(part.surfels, view, row, weights=part.weights)
        splatter.sort()
        planes = splatter.draw(background, blend == "linear")
        color = np.ascontiguousarray(planes.color[:, *size].transpose(1, 2, 0))
        rows = splatter.median() if depth else np.full(color.shape[:2], -1, np.int32)
    anchor = depth_anchor or ((views[0].depth, parts[0].unit) if parts else (1.0, 1.0))
    return Rendering(color, _relief(rows, parts, views, anchor), np.float32(1.0) - planes.through[size])


def _relief(
    rows: IntArray, parts: Sequence[LevelPart], views: Sequence[AnchoredView], anchor: tuple[float, float]
) -> FloatArray:
    """Depth (h, w) of the surfels in ``rows``, which count through the parts; nan where -1."""
    relief, first = np.full(rows.shape, np.nan, np.float32), 0
    for part, view in zip(parts, views, strict=True):
        pixels = (rows >= first) & (rows < first + len(part.surfels))
        means = part.surfels.means[rows[pixels] - first].astype(np.float64)
        shift, ratio = (view.depth - anchor[0]) / anchor[1], part.unit / anchor[1]
        relief[pixels] = shift + ratio * (means @ view.z_axis)
        first += len(part.surfels)
    return relief


def padded_shape(camera: Camera) -> tuple[int, int]:
    """Returns (H, W), the image size rounded up to whole tiles."""
    t = binning.TILE
    return -(-camera.height // t) * t, -(-camera.width // t) * t


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
