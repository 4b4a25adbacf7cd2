"""What stage 5 minimises: 0.8 L1 + 0.2 D-SSIM of one level, and its gradient in q, log s and o.

::

    SurfelObjective(surfels, frame)
        .prepare(camera, target) ──► PreparedView      positions stay, so a view is sorted once
        .render_with_gradient(view) ──► loss, Gradients
              project ─ bin ─ composite ─ loss ─ accumulate ─ chain
        .result() ──► Surfels
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.reference import depth_row, focus_of
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.kernels import backward, binning, chain, forward, loss, projection
from wzviewer.kernels.elementary import KERNELS
from wzviewer.kernels.splatting import VIEW_MAX
from wzviewer.worker.rasterize import BLACK, padded_shape


@dataclass(frozen=True, eq=False)
class PreparedView:
    """A camera with its target, sorted and blurred once.

    Attributes:
        camera: the view.
        packed: (13,) view vector of the level's frame.
        order: (m,) uint32 surfels that may be seen, front to back.
        target: (3, H, W), padded to whole tiles.
        mask: (H, W) 1 where the target is known.
        mean: (3, H, W) local mean of the target.
        variance: (3, H, W) local variance of the target.
    """

    camera: Camera
    packed: FloatArray
    order: binning.Indices
    target: FloatArray
    mask: FloatArray
    mean: FloatArray
    variance: FloatArray


@dataclass(frozen=True, eq=False)
class Gradients:
    """dL/d of the optimiser's variables: quats (n, 4), log_scales (n, 2), x (n,); float32."""

    quats: FloatArray
    log_scales: FloatArray
    x: FloatArray


@dataclass(eq=False)
class _Workspace:
    """Arrays that every step reuses; planes by padded image size."""

    rows: FloatArray
    weights: FloatArray
    scales: FloatArray
    opacities: FloatArray
    conic_gradients: FloatArray
    planes: dict[tuple[int, int], tuple[FloatArray, FloatArray]] = field(default_factory=dict)

    @classmethod
    def of_size(cls, n: int) -> "_Workspace":
        """Returns a workspace for n surfels."""
        shapes: tuple[tuple[int, ...], ...] = ((n, 8), (n,), (n, 2), (n,), (2, n, 4))
        rows, weights, scales, opacities, conics = (np.zeros(s, np.float32) for s in shapes)
        weights[:] = 1.0
        return cls(rows, weights, scales, opacities, conics)

    def planes_of(self, shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Returns (2, 3, H, W): image and gradient, and (2, H, W): S and T, for one image size."""
        if shape not in self.planes:
            self.planes[shape] = (np.zeros((2, 3, *shape), np.float32), np.zeros((2, *shape), np.float32))
        return self.planes[shape]


Background = tuple[float, float, float] | FloatArray


class SurfelObjective:
    """0.8 L1 + 0.2 D-SSIM of one level's renderings, and its gradient in q, log s and x.

    Positions and colours are fixed; ``o = clip(0.51 tanh x + 0.5, 1e-4, 0.995)``.

    Args:
        surfels: the level's.
        frame: the level's local frame.

    Attributes:
        quats: (n, 4) wxyz, need not be unit; may be changed between calls.
        log_scales: (n, 2) log of local units; may be changed between calls.
        x: (n,) opacity variable; may be changed between calls.
        colors: (n, 3).
    """

    def __init__(self, surfels: Surfels, frame: LevelFrame) -> None:
        self.frame = frame
        self.surfels = surfels
        self.quats = surfels.quats.copy()
        self.log_scales = np.log(np.maximum(surfels.scales, np.float32(1e-12)))
        self.x = chain.opacity_variable(surfels.opacities)
        self.colors = surfels.colors.copy()
        self._window = loss.window()
        self._work = _Workspace.of_size(len(surfels))

    def result(self) -> Surfels:
        """Returns the surfels with the present parameters; quaternions are normalised."""
        length = np.linalg.norm(self.quats, axis=1, keepdims=True)
        quats = self.quats / np.maximum(length, np.float32(1e-12))
        with KERNELS:
            chain.activate(self.log_scales, self.x, self._work.scales, self._work.opacities)
        arrays = {"scales": self._work.scales.copy(), "opacities": self._work.opacities.copy()}
        return self.surfels.with_(quats=quats, colors=self.colors.copy(), **arrays)

    def prepare(self, camera: Camera, target: FloatArray, mask: BoolArray | None = None) -> PreparedView:
        """Sorts the surfels for a camera and keeps the statistics of its target.

        Args:
            camera: the view.
            target: (h, w, 3) float32 of the camera's size.
            mask: (h, w) bool, true where the target is known; None for everywhere.

        Raises:
            ValueError: when the target or the mask has another size than the camera.
        """
        size = (camera.height, camera.width)
        if target.shape != (*size, 3) or (mask is not None and mask.shape != size):
            raise ValueError(f"target {target.shape} and mask must fit the camera's {size}")
        shape = padded_shape(camera)
        inside = (slice(0, size[0]), slice(0, size[1]))
        aim, known = np.zeros((3, *shape), np.float32), np.zeros(shape, np.float32)
        aim[:, *inside] = target.transpose(2, 0, 1)
        known[inside] = 1.0 if mask is None else mask
        mean, variance = np.zeros_like(aim), np.zeros_like(aim)
        mean[:, *inside], variance[:, *inside] = self._statistics(aim[:, *inside])
        view = AnchoredView.expand(camera, self.frame)
        packed = projection.view_vector(view)
        if not np.all(np.abs(packed) < VIEW_MAX):
            raise ValueError("the camera lies in the plane of the level's anchor")
        with KERNELS:
            order = self._order(packed, camera, depth_row(view, self.frame, focus_of(camera, [self.frame])))
        return PreparedView(camera, packed, order, aim, known, mean, variance)

    def _statistics(self, target: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Local mean and variance (3, h, w) of a target, as SSIM sees them."""
        mean, square = (np.stack([self._blurred(plane) for plane in p]) for p in (target, target * target))
        return mean, square - mean * mean

    def _blurred(self, plane: FloatArray) -> FloatArray:
        return cv2.sepFilter2D(plane, -1, self._window, self._window, borderType=cv2.BORDER_CONSTANT)

    def _order(self, packed: FloatArray, camera: Camera, depth_row: FloatArray) -> binning.Indices:
        """Sorts the surfels in front of the camera that touch the image, or may once they have grown."""
        work, n = self._work, len(self.surfels)
        grown, opaque = self.surfels.scales * np.float32(2.0), np.full(n, 0.99, np.float32)
        where = (self.surfels.means, self.surfels.quats, grown, opaque)
        size, reach_px = (camera.width, camera.height), backward.HALF_HEIGHT_MAX_PX
        projection.project(*where, packed, *size, reach_px, work.rows)
        return binning.front_to_back(work.rows, self.surfels.means, depth_row)

    def render(self, view: PreparedView, background: Background = BLACK) -> FloatArray:
        """Renders a prepared view, (3, H, W) padded; the array is reused by the next call."""
        with KERNELS:
            self._forward(view, background)
        return self._work.planes_of(view.mask.shape)[0][0]

    def _forward(self, view: PreparedView, background: Background) -> tuple[binning.Offsets, binning.Indices]:
        work, camera = self._work, view.camera
        chain.activate(self.log_scales, self.x, work.scales, work.opacities)
        values = (self.surfels.means, self.quats, work.scales, work.opacities)
        size, reach_px = (camera.width, camera.height), backward.HALF_HEIGHT_MAX_PX
        projection.project(*values, view.packed, *size, reach_px, work.rows)
        lists = binning.bin_tiles(work.rows, view.order, *size)
        (image, _), (_, through) = work.planes_of(view.mask.shape)
        color = np.asarray(background if isinstance(background, tuple) else BLACK, np.float32)
        forward.composite(work.rows, self.colors, work.weights, False, *lists, color, *image, through)
        if not isinstance(background, tuple):
            np.add(image, through * background, out=image)
        return lists

    def render_with_gradient(
        self, view: PreparedView, background: Background = BLACK
    ) -> tuple[float, Gradients]:
        """Returns the loss of a view and its gradient.

        Surfels taller than 112 px are cut off there, as the backward pass needs it.

        Args:
            view: from `prepare`.
            background: sRGB colour behind everything, or a picture (3, H, W) padded like the target.
        """
        n, work = len(self.surfels), self._work
        shapes: list[tuple[int, ...]] = [(n, 4), (n, 2), (n,)]
        gradients = Gradients(*(np.empty(s, np.float32) for s in shapes))
        (image, d_image), (behind, through) = work.planes_of(view.mask.shape)
        with KERNELS:
            lists = self._forward(view, background)
            value = self._loss(view, image, d_image)
            pairs = (work.rows, self.colors, *lists)
            backward.accumulate(*pairs, image, d_image, behind, through, work.conic_gradients)
            surfels = (self.surfels.means, self.quats, work.scales, self.x)
            out = (gradients.quats, gradients.log_scales, gradients.x)
            chain.chain(*surfels, view.packed, work.rows, work.conic_gradients, *out)
        return value, gradients

    def _loss(self, view: PreparedView, image: FloatArray, d_image: FloatArray) -> float:
        """Returns 0.8 L1 + 0.2 D-SSIM and writes dL/d image."""
        h, w = view.camera.height, view.camera.width
        partials = np.empty((3, *image.shape), np.float32)
        ssim, l1 = np.empty(3 * h), np.empty(3 * h)
        pair, g = (image, view.target), self._window
        if not view.mask[:h, :w].all():
            loss.hide_masked(*pair, view.mask, h, w)
        loss.ssim_partials(*pair, view.mean, view.variance, g, h, w, partials, ssim)
        loss.loss_gradient(*pair, view.mask, partials, g, h, w, d_image, l1)
        count = 3 * h * w
        return float(loss.L1_SHARE * l1.sum() / count + loss.SSIM_SHARE * (1 - ssim.sum() / count))

    def step_colors(self, view: PreparedView) -> None:
        """Adds to each colour what its own pixel lacks, clamped to [0, 1].

        What shows through is taken to be right, as pictures are presented relative to their coverage.
        Only the nearest surfel centred in a pixel owns it.  The rendering is nearly the colours
        themselves, so this Jacobi iteration converges at once; it departs from the paper, where
        colours are fixed.
        """
        image, (h, w) = self.render(view, view.target), (view.camera.height, view.camera.width)
        centres = self._work.rows[view.order, :2]
        inside = (centres >= 0).all(1) & (centres[:, 0] < w) & (centres[:, 1] < h)
        nearest_last = view.order[inside][::-1]
        x, y = centres[inside][::-1].astype(np.int64).T
        owners = np.full((h, w), -1, np.int64)
        owners[y, x] = nearest_last
        y, x = np.nonzero((owners >= 0) & (view.mask[:h, :w] > 0))
        index = owners[y, x]
        lacking = (view.target[:, y, x] - image[:, y, x]).T
        self.colors[index] = np.clip(self.colors[index] + lacking, 0.0, 1.0)
