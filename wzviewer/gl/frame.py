"""What `SurfelRenderer.render` returns: the picture on the GPU, and how to read it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import moderngl
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.reference import Blend
from wzviewer.core.types import ByteArray, DoubleArray, FloatArray, IntArray
from wzviewer.gl.order import Run, UIntArray
from wzviewer.gl.present import Presenter, Rgba, Viewport

Output = Literal["color", "coverage", "depth", "level"]


@dataclass(frozen=True)
class RenderSettings:
    """How to draw.

    Attributes:
        blend: transmittance (exact partition) or linear (Eq. 2 of the paper).
        modulation: False draws every level at full weight (the paper's ablation).
        background: straight RGBA behind the scene.
        closed_coverage: surfels of a closed surface cover 92 to 99.7 % of a pixel, depending on where its
            centre falls between theirs.  When presented, this much counts as all, so that neither the
            background shines through nor a slow zoom pulses; 1 presents what was rendered.
        outputs: depth and level cost about five more passes.
        culling: False draws every chunk (to test the culling).
        quads: None chooses points where they fit; True and False force one.
        stride: draws one surfel in so many, grown to cover for the others: for slow drivers while the
            camera moves.  5 is best: in rows of 128 pixels (`core.lift`) it picks an even lattice.
    """

    blend: Blend = "transmittance"
    modulation: bool = True
    background: Rgba = (0.0, 0.0, 0.0, 1.0)
    closed_coverage: float = 0.9
    outputs: frozenset[Output] = frozenset({"color"})
    culling: bool = True
    quads: bool | None = None
    stride: int = 1


@dataclass(frozen=True)
class FrameStats:
    """Numbers of one frame.

    Attributes:
        num_visible: surfels drawn.
        num_surfels: surfels of the visible levels.
        num_chunks: chunks drawn.
        cull_ms: choosing chunks.
        sort_ms: keys and sort; 0 when the last order was reused.
        draw_ms: upload of the order and submission; on a software driver most of the drawing.
        quads: whether footprints were too big for points.
        gpu_bytes: GPU memory held by the renderer.
    """

    num_visible: int = 0
    num_surfels: int = 0
    num_chunks: int = 0
    cull_ms: float = 0.0
    sort_ms: float = 0.0
    draw_ms: float = 0.0
    quads: bool = False
    gpu_bytes: int = 0


@dataclass(frozen=True, eq=False)
class MedianMap:
    """The surfel at which transmittance crosses 1/2, per pixel.

    Attributes:
        ranks: (h, w) place in the order; ``len(order)`` or more where undefined.
        order: (n,) record numbers, nearest first.
        runs: where records come from.
    """

    ranks: UIntArray
    order: UIntArray
    runs: Sequence[Run]

    def relief(self, anchor_depth: float, unit: float) -> DoubleArray:
        """(z - anchor_depth) / unit, (h, w) float64; nan where undefined."""
        out = np.full(self.ranks.shape, np.nan)
        for run, pixels, at in self._by_run():
            means = run.columns[:, at].astype(np.float64)
            out[pixels] = (run.view.depth - anchor_depth) / unit + run.frame.unit / unit * (
                run.view.z_axis @ means
            )
        return out

    def levels(self) -> IntArray:
        """Level index, (h, w) int32; -1 where undefined."""
        out = np.full(self.ranks.shape, -1, np.int32)
        for run, pixels, _ in self._by_run():
            out[pixels] = run.level
        return out

    def _by_run(self) -> list[tuple[Run, Any, Any]]:
        defined = self.ranks < len(self.order)
        records = self.order[np.where(defined, self.ranks, 0)] if len(self.order) else self.ranks
        found = []
        for run in self.runs:
            at, between = np.divmod(records.astype(np.int64) - run.first_record, run.stride)
            pixels = defined & (at >= 0) & (at < len(run)) & (between == 0)
            if pixels.any():
                found.append((run, pixels, at[pixels]))
        return found


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered view; its texture is valid until the next `render`.

    Attributes:
        camera: that was rendered.
        settings: with which.
        texture: premultiplied RGBA, first row = top of the image; None for an empty size.
        stats: of the frame.
    """

    camera: Camera
    settings: RenderSettings
    texture: moderngl.Texture | None
    stats: FrameStats
    _presenter: Presenter
    _median: MedianMap | None = field(default=None)

    @property
    def shape(self) -> tuple[int, int]:
        """(h, w)."""
        return self.camera.height, self.camera.width

    def present_to(
        self, framebuffer: moderngl.Framebuffer, viewport: Viewport | None = None, smooth: bool = True
    ) -> None:
        """Draws the frame over its background into a framebuffer (see `Presenter.draw`)."""
        if self.texture is not None:
            look = (self.settings.background, self.settings.closed_coverage)
            self._presenter.draw(self.texture, framebuffer, *look, viewport, smooth)

    def read_color(self) -> FloatArray:
        """Premultiplied colour and coverage, (h, w, 4) float32."""
        if self.texture is None:
            return np.zeros((*self.shape, 4), np.float32)
        data = np.frombuffer(self.texture.read(alignment=1), np.dtype(self.texture.dtype))
        return data.reshape(*self.shape, 4).astype(np.float32)

    def read_color8(self) -> ByteArray:
        """Colour over the background, (h, w, 3) uint8."""
        return np.ascontiguousarray(self._read8(self.settings.background)[..., :3])

    def read_rgba8(self) -> ByteArray:
        """Straight colour and coverage, without a background, (h, w, 4) uint8."""
        color = self.read_color()
        straight = color[..., :3] / np.maximum(color[..., 3:], 1e-6)
        rgba = np.concatenate([straight, color[..., 3:] / self.settings.closed_coverage], -1)
        return np.rint(np.clip(rgba, 0.0, 1.0) * 255.0).astype(np.uint8)

    def read_coverage(self) -> FloatArray:
        """1 - transmittance, (h, w) float32."""
        return self.read_color()[..., 3]

    def read_relief(self, anchor_depth: float, unit: float) -> FloatArray:
        """Median depth relative to an anchor, (h, w) float32: (z - anchor_depth) / unit; nan undefined.

        Raises:
            ValueError: when depth was not among the frame's outputs.
        """
        return self._medians().relief(anchor_depth, unit).astype(np.float32)

    def read_depth(self) -> DoubleArray:
        """Median depth, (h, w) float64, world units along the camera's axis; nan where undefined.

        Raises:
            ValueError: when depth was not among the frame's outputs.
        """
        return self._medians().relief(0.0, 1.0)

    def read_level(self) -> IntArray:
        """Index of the level of the median surfel, (h, w) int32; -1 where undefined.

        Raises:
            ValueError: when neither depth nor level was among the frame's outputs.
        """
        return self._medians().levels()

    def _medians(self) -> MedianMap:
        if self._median is None:
            raise ValueError("render with outputs={'color', 'depth'} to read depth or level")
        return self._median

    def _read8(self, background: Rgba) -> ByteArray:
        if self.texture is None:
            return np.zeros((*self.shape, 4), np.uint8)
        return self._presenter.read(self.texture, background, self.settings.closed_coverage)
