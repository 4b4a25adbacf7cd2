"""What stage 5 minimises: 0.8 L1 + 0.2 D-SSIM of one level, and its gradient in q, log s and o.

::

    SurfelObjective(surfels, frame)
        .prepare(camera, target) ──► PreparedView      positions stay, so a view is sorted once
        .descend(view, adam) ──► loss
              look ─ bin ─ composite ─ loss ─ accumulate ─ descend
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
from wzviewer.kernels import adam, backward, binning, chain, forward, loss, projection, stepping
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
        blocks: (k,) int64 of the surfels in the order.
        target: (3, H, W), padded to whole tiles.
        mask: (H, W) 1 where the target is known.
        mean: (3, H, W) local mean of the target.
        variance: (3, H, W) local variance of the target.
    """

    camera: Camera
    packed: FloatArray
    order: binning.Indices
    blocks: binning.Offsets
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


class AdamState:
    """Moments of Adam for the three variables, and how many steps were taken.

    Args:
        n: surfels.
        rates: of q, log s and x.
    """

    def __init__(self, n: int, rates: tuple[float, float, float]) -> None:
        self.quats, self.scales, self.x = (np.zeros((2, n, *s), np.float32) for s in ((4,), (2,), ()))
        self._rates, self._step = np.array(rates), 0

    def next_step(self) -> tuple[FloatArray, np.float32]:
        """Returns the rates (3,) and the factor of the second moments, both without their bias."""
        self._step += 1
        rates = self._rates / (1.0 - adam.BETA_1**self._step)
        return rates.astype(np.float32), np.float32(1.0 / (1.0 - adam.BETA_2**self._step))


@dataclass(eq=False)
class _Workspace:
    """Arrays that every step reuses; planes by padded image size."""

    rows: FloatArray
    weights: FloatArray
    scales: FloatArray
    opacities: FloatArray
    conic_gradients: FloatArray
    spans: binning.Spans
    planes: dict[tuple[int, int], tuple[FloatArray, FloatArray]] = field(default_factory=dict)

    @classmethod
    def of_size(cls, n: int) -> "_Workspace":
        """Returns a workspace for n surfels."""
        shapes: tuple[tuple[int, ...], ...] = ((n, 8), (n,), (n, 2), (n,), (2, n, 4))
        rows, weights, scales, opacities, conics = (np.zeros(s, np.float32) for s in shapes)
        weights[:] = 1.0
        return cls(rows, weights, scales, opacities, conics, np.zeros(n, np.uint64))

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
        row = depth_row(view, self.frame, focus_of(camera, [self.frame]))
        where = (self.surfels.means, self.surfels.scales, packed, row)
        with KERNELS:
            order, blocks = binning.front_to_back(*where, camera.width, camera.height)
        return PreparedView(camera, packed, order, blocks, aim, known, mean, variance)

    def _statistics(self, target: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Local mean and variance (3, h, w) of a target, as SSIM sees them."""
        mean, square = (np.stack([self._blurred(plane) for plane in p]) for p in (target, target * target))
        return mean, square - mean * mean

    def _blurred(self, plane: FloatArray) -> FloatArray:
        return cv2.sepFilter2D(plane, -1, self._window, self._window, borderType=cv2.BORDER_CONSTANT)

    def render(self, view: PreparedView, background: Background = BLACK) -> FloatArray:
        """Renders a prepared view, (3, H, W) padded; the array is reused by the next call."""
        with KERNELS:
            self._forward(view, background)
        return self._work.planes_of(view.mask.shape)[0][0]

    def _forward(self, view: PreparedView, background: Background) -> tuple[binning.Offsets, binning.Indices]:
        work, size = self._work, (view.camera.width, view.camera.height)
        values = (self.surfels.means, self.quats, self.log_scales, self.x)
        out = (work.scales, work.opacities, work.rows, work.spans)
        stepping.look(*values, view.packed, *size, backward.HALF_HEIGHT_MAX_PX, view.blocks, *out)
        lists = binning.bin_spans(work.spans, view.order, *size)
        (image, _), (_, through) = work.planes_of(view.mask.shape)
        color = np.asarray(background if isinstance(background, tuple) else BLACK, np.float32)
        forward.composite(work.rows, self.colors, work.weights, False, *lists, color, *image, through)
        if not isinstance(background, tuple):
            forward.put_over(background, through, image)
        return lists

    def _accumulate(self, view: PreparedView, background: Background) -> float:
        """Returns the loss of a view and keeps what its gradient is by conics and opacities.

        Surfels taller than 112 px are cut off there, as the backward pass needs it.
        """
        work = self._work
        (image, d_image), (behind, through) = work.planes_of(view.mask.shape)
        lists = self._forward(view, background)
        value = self._loss(view, image, d_image)
        pairs = (work.rows, self.colors, *lists)
        backward.accumulate(*pairs, image, d_image, behind, through, work.conic_gradients)
        return value

    def descend(
        self,
        view: PreparedView,
        state: AdamState,
        background: Background = BLACK,
        kept: BoolArray | None = None,
    ) -> float:
        """Takes a step of Adam down the loss of a view, which is returned.

        Args:
            view: from `prepare`; what it does not see stays.
            state: of Adam, changed.
            background: sRGB colour behind everything, or a picture (3, H, W) padded like the target.
            kept: (n,) surfels that stay, too.
        """
        work, kept = self._work, np.zeros(len(self.surfels), np.bool_) if kept is None else kept
        variables = (self.surfels.means, self.quats, self.log_scales, self.x)
        moments = (state.quats, state.scales, state.x)
        with KERNELS:
            value = self._accumulate(view, background)
            slopes = (view.packed, work.scales, work.rows, work.conic_gradients)
            stepping.descend(*variables, *slopes, view.blocks, kept, *state.next_step(), *moments)
        return value

    def gradient(self, view: PreparedView, background: Background = BLACK) -> tuple[float, Gradients]:
        """Returns the loss of a view and its gradient; arguments as of `descend`."""
        n, work = len(self.surfels), self._work
        shapes: list[tuple[int, ...]] = [(n, 4), (n, 2), (n,)]
        found = Gradients(*(np.empty(s, np.float32) for s in shapes))
        with KERNELS:
            value = self._accumulate(view, background)
            surfels = (self.surfels.means, self.quats, work.scales, self.x, view.packed)
            out = (found.quats, found.log_scales, found.x)
            stepping.gradients(*surfels, work.rows, work.conic_gradients, *out)
        return value, found

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

    def step_colors(self, view: PreparedView, behind: FloatArray) -> None:
        """Adds to each colour what its own pixel lacks, clamped to [0, 1].

        Only the nearest surfel centred in a pixel owns it.  The rendering is nearly the colours
        themselves, so this Jacobi iteration converges at once; it departs from the paper, where
        colours are fixed.

        Args:
            view: from `prepare`.
            behind: (3, H, W) what shows through; the target itself where nothing is, as pictures are
                presented relative to their coverage.
        """
        image, size = self.render(view, behind), (view.camera.width, view.camera.height)
        planes = (image, view.target, view.mask)
        with KERNELS:
            stepping.add_lacking(self._work.rows, view.order, *planes, *size, self.colors)
