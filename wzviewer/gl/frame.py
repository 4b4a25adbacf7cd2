"""What `SurfelRenderer.render` returns: the picture on the GPU, and how to read it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import moderngl
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.reference import Blend
from wzviewer.core.types import BoolArray, ByteArray, DoubleArray, FloatArray, IntArray
from wzviewer.gl.order import Run
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
        antialias: with modulation, a root that is seen at a quarter of its resolution or less is drawn
            with merged surfels half a pixel apart: its own would be so many to a pixel that they flicker
            (and 6 dB further from what a lens would show).  The paper's renderer has no such thing.
        contribution_min: surfels whose opacity times area on the screen, px^2, is less are left out; 0
            draws all.  About 0.5 is invisible on a level that is seen far below its own scale.
        spacing_px: levels whose merged surfels (2x2, 4x4) would be at most this far apart on the screen
            are drawn with those: for a camera in motion on a slow machine.  0 draws every surfel.
        finer: how many times the resolution the frame stands in for, in each direction: levels are then
            weighted as they would be there, and none fades for want of pixels.
    """

    blend: Blend = "transmittance"
    modulation: bool = True
    background: Rgba = (0.0, 0.0, 0.0, 1.0)
    closed_coverage: float = 0.9
    outputs: frozenset[Output] = frozenset({"color"})
    culling: bool = True
    quads: bool | None = None
    antialias: bool = True
    contribution_min: float = 0.0
    spacing_px: float = 0.0
    finer: float = 1.0


@dataclass(frozen=True)
class DrawCost:
    """What a rasteriser says of a frame; see `FrameStats`."""

    num_drawn: int = 0
    sort_ms: float = 0.0
    draw_ms: float = 0.0
    rasterizer: str = ""
    quads: bool = False


@dataclass(frozen=True)
class FrameStats:
    """Numbers of one frame.

    Attributes:
        num_visible: surfels drawn.
        num_surfels: surfels of the visible levels.
        num_chunks: chunks drawn.
        cull_ms: choosing chunks.
        sort_ms: keys and sort, wherever they ran.
        draw_ms: all else: projection and compositing, or upload of the order and submission.
        rasterizer: ``shaders`` or ``kernels``.
        quads: whether some footprints were too big for points (shaders).
        gpu_bytes: memory held by the renderer for the scene and the frame.
        is_exact: whether order and surfels are those of this very camera; False for a frame in motion.
    """

    num_visible: int = 0
    num_surfels: int = 0
    num_chunks: int = 0
    cull_ms: float = 0.0
    sort_ms: float = 0.0
    draw_ms: float = 0.0
    rasterizer: str = ""
    quads: bool = False
    gpu_bytes: int = 0
    is_exact: bool = True


@dataclass(frozen=True, eq=False)
class MedianMap:
    """The surfel at which transmittance crosses 1/2, per pixel.

    Attributes:
        places: (h, w) place in the concatenated runs; -1 where undefined.
        runs: what the places count through.
    """

    places: IntArray
    runs: Sequence[Run]

    def relief(self, anchor_depth: float, unit: float) -> DoubleArray:
        """(z - anchor_depth) / unit, (h, w) float64; nan where undefined."""
        out = np.full(self.places.shape, np.nan)
        for run, pixels, at in self._by_run():
            means = run.columns[:, at].astype(np.float64)
            out[pixels] = (run.view.depth - anchor_depth) / unit + run.frame.unit / unit * (
                run.view.z_axis @ means
            )
        return out

    def levels(self) -> IntArray:
        """Level index, (h, w) int32; -1 where undefined."""
        out = np.full(self.places.shape, -1, np.int32)
        for run, pixels, _ in self._by_run():
            out[pixels] = run.level.index
        return out

    def _by_run(self) -> Iterator[tuple[Run, BoolArray, IntArray]]:
        first = 0
        for run in self.runs:
            pixels = (self.places >= first) & (self.places < first + len(run))
            if pixels.any():
                yield run, pixels, self.places[pixels] - first
            first += len(run)


class Picture(Protocol):
    """Where a rasteriser left its picture."""

    def present(
        self,
        presenter: Presenter,
        framebuffer: moderngl.Framebuffer,
        background: Rgba,
        closed_coverage: float,
        viewport: Viewport | None,
        smooth: bool,
    ) -> None:
        """Draws it over a background into a framebuffer; arguments as of `Presenter.draw`."""

    def read(self) -> FloatArray:
        """Premultiplied colour and coverage, (h, w, 4) float32."""
        ...

    def read8(self, presenter: Presenter, background: Rgba, closed_coverage: float) -> ByteArray:
        """Composited over a background, (h, w, 4) uint8."""
        ...


@dataclass(frozen=True, eq=False)
class Frame:
    """A rendered view; its picture is valid until the next `render`.

    Attributes:
        camera: that was rendered.
        settings: with which.
        picture: None for an empty size, and as long as there is none.
        stats: of the frame.
    """

    camera: Camera
    settings: RenderSettings
    picture: Picture | None
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
        if self.picture is None:
            if min(self.shape) > 0:  # there is none yet
                framebuffer.clear(*self.settings.background, viewport=viewport)
            return
        look = (self.settings.background, self.settings.closed_coverage)
        self.picture.present(self._presenter, framebuffer, *look, viewport, smooth)

    def read_color(self) -> FloatArray:
        """Premultiplied colour and coverage, (h, w, 4) float32."""
        return np.zeros((*self.shape, 4), np.float32) if self.picture is None else self.picture.read()

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
        if self.picture is None:
            return np.zeros((*self.shape, 4), np.uint8)
        return self.picture.read8(self._presenter, background, self.settings.closed_coverage)
