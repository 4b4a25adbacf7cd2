"""Draws selections with the shaders: records on the GPU, one exact order, premultiplied "over"."""

import time
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import moderngl
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Modulation
from wzviewer.core.types import ByteArray, FloatArray, IntArray
from wzviewer.gl.blocks import BlockTexture
from wzviewer.gl.compute import ComputeOrder, GpuOrder, SurfelCull
from wzviewer.gl.draw import Segment, SurfelDraw, Variant
from wzviewer.gl.frame import DrawCost, RenderSettings
from wzviewer.gl.median import MedianPass
from wzviewer.gl.present import Presenter, Rgba, Viewport
from wzviewer.gl.surfel_buffer import SurfelBuffer
from wzviewer.gl.targets import Target
from wzviewer.gl.visible import Ordered, Selection

SEGMENTS_MAX = 64  # draws of a frame; more, and all footprints become quads
UNCOVERED = Modulation(None, ())


@dataclass(frozen=True, eq=False)
class GpuPicture:
    """A picture on the GPU.

    Attributes:
        texture: premultiplied RGBA, first row = top of the image.
    """

    texture: moderngl.Texture

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
        presenter.draw(self.texture, framebuffer, background, closed_coverage, viewport, smooth)

    def read(self) -> FloatArray:
        """Premultiplied colour and coverage, (h, w, 4) float32."""
        width, height = self.texture.size
        data = np.frombuffer(self.texture.read(alignment=1), np.dtype(self.texture.dtype))
        return data.reshape(height, width, 4).astype(np.float32)

    def read8(self, presenter: Presenter, background: Rgba, closed_coverage: float) -> ByteArray:
        """Composited over a background, (h, w, 4) uint8."""
        return presenter.read(self.texture, background, closed_coverage)


class ShaderRasterizer:
    """Programs, records and level rows of one context.

    Attributes:
        pages: records on the GPU.
        point_limit_px: largest footprint that can be a point.
    """

    name = "shaders"

    def __init__(self, ctx: moderngl.Context, is_software: bool, gpu_order: bool | None = None) -> None:
        self.ctx = ctx
        self.pages = SurfelBuffer(ctx)
        self._blocks = BlockTexture(ctx)
        self._draw = SurfelDraw(ctx)
        wants_compute = not is_software if gpu_order is None else gpu_order
        self._compute = ComputeOrder(ctx) if wants_compute and ComputeOrder.is_supported(ctx) else None
        # Software drivers blend float32 as fast as float16, which they round towards zero.
        self._target = Target(ctx, 4, "f4" if is_software else "f2")
        self._median: MedianPass | None = None
        self._drawn: tuple[Selection, Variant] | None = None
        self._uploaded: Ordered | None = None  # what the element index holds
        self._segments: list[Segment] = []

    @property
    def point_limit_px(self) -> float:
        """Largest footprint that can be a point."""
        return self._draw.point_limit_px

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        parts = (self.pages, self._blocks, self._draw, self._target, self._median, self._compute)
        return sum(part.num_bytes for part in parts if part is not None)

    @property
    def orders_itself(self) -> bool:
        """Whether the GPU makes the orders."""
        return self._compute is not None

    def can_order(self, selection: Selection) -> bool:
        """Whether the GPU itself can order a selection."""
        return self._compute is not None and (
            not selection.runs or self._compute.fits(selection.runs, self._records())
        )

    def draw(
        self, selection: Selection, ordered: Ordered | None, camera: Camera, settings: RenderSettings
    ) -> tuple[GpuPicture, DrawCost]:
        """Draws a selection.

        Args:
            selection: what to draw; it may have been made for a camera nearby.
            ordered: its order, or None to have the GPU order it.
            camera: from where.
            settings: how.
        """
        began = time.perf_counter()
        framebuffer = self._target.resize(camera.width, camera.height)
        framebuffer.clear(0.0, 0.0, 0.0, 0.0)
        exact = camera.key == selection.camera.key
        variant = Variant(False, settings.blend == "linear", exact and selection.is_unit_weight)
        self._drawn, quads = None, False
        if selection.runs:
            self._drawn = (selection, variant)
            quads = self._draw_runs(selection, ordered, camera, settings, variant)
        count, sort_ms = selection.num_selected, 0.0 if ordered is None else ordered.sort_ms
        draw_ms = 1e3 * (time.perf_counter() - began)
        return GpuPicture(self._target.texture), DrawCost(count, sort_ms, draw_ms, self.name, quads)

    def median_places(self) -> IntArray:
        """Place in the runs where transmittance crosses 1/2, (h, w); -1 where nowhere; after `draw`."""
        width, height = self._target.texture.size
        if self._drawn is None:
            return np.full((height, width), -1, np.int32)
        selection, variant = self._drawn
        ordered = self._uploaded
        if ordered is None or ordered.selection is not selection:
            ordered = selection.ordered()
            self._upload(ordered, RenderSettings())
        self._median = self._median or MedianPass(self.ctx)
        self._draw.set_ranks(ordered.records(), self.pages.capacity_surfels)
        parts = (self._records(), self._textures(), self._segments)
        ranks = self._median.ranks(self._draw, variant, (width, height), len(ordered.places), *parts)
        found = ranks < len(ordered.places)
        return np.where(found, ordered.places[np.where(found, ranks, 0)], -1).astype(np.int32)

    def release(self) -> None:
        """Frees all GPU objects."""
        for part in (self.pages, self._blocks, self._draw, self._target, self._median, self._compute):
            if part is not None:
                part.release()
        self._median = self._drawn = self._uploaded = None

    def _draw_runs(
        self,
        selection: Selection,
        ordered: Ordered | None,
        camera: Camera,
        settings: RenderSettings,
        variant: Variant,
    ) -> bool:
        """Draws what is there; returns whether some footprints are quads."""
        self._write_blocks(selection, camera, settings.finer)
        how = (self._target.framebuffer, self._records(), self._textures())
        uniforms = {"u_contribution_min": settings.contribution_min}
        order = None
        if ordered is None:
            order = self._order_on_gpu(selection, camera, settings, variant)
        else:
            self._upload(ordered, settings)
        self.ctx.enable_only(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        self.ctx.blend_func = (moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)
        if order is not None:
            big = any(run.is_big for run in selection.runs)
            variant = replace(variant, quads=big if settings.quads is None else settings.quads)
            self._draw.draw_indirect(variant, *how, uniforms, order)
        else:
            self._draw.draw(variant, *how, uniforms, self._segments)
        self.ctx.enable_only(moderngl.NOTHING)
        return variant.quads if order is not None else any(s.quads for s in self._segments)

    def _order_on_gpu(
        self, selection: Selection, camera: Camera, settings: RenderSettings, variant: Variant
    ) -> GpuOrder:
        assert self._compute is not None  # can_order said so
        assert self._blocks.texture is not None  # written before
        size = (camera.width, camera.height)
        modulated = not variant.unit_weight
        cull = SurfelCull(self._blocks.texture, size, modulated, settings.contribution_min)
        return self._compute.order(selection.runs, selection.focus, self._records(), cull)

    def _write_blocks(self, selection: Selection, camera: Camera, finer: float) -> None:
        frames = {i: level.runs[0].frame for i, level in selection.seen.items()}
        views = {i: AnchoredView.expand(camera, frame).finer(finer) for i, frame in frames.items()}
        self._blocks.write(views, {i: level.modulation or UNCOVERED for i, level in selection.seen.items()})

    def _upload(self, ordered: Ordered, settings: RenderSettings) -> None:
        if self._uploaded is None or self._uploaded.places is not ordered.places:
            self._draw.set_order(ordered.records())
        self._uploaded = ordered
        self._segments = self._footprints(ordered, settings)

    def _footprints(self, ordered: Ordered, settings: RenderSettings) -> list[Segment]:
        """Splits the order where points and quads meet; all quads where that would be too often."""
        total = len(ordered.places)
        if settings.quads is not None:
            return [Segment(0, total, settings.quads)]
        runs = ordered.selection.runs
        big = np.array([run.is_big for run in runs])
        if big.all() or not big.any():
            return [Segment(0, total, bool(big.all()))]
        ends = np.cumsum([len(run) for run in runs])
        is_quad = big[np.searchsorted(ends, ordered.places[::-1], side="right")]  # farthest first
        cuts = np.concatenate([[0], np.flatnonzero(np.diff(is_quad)) + 1, [total]])
        if len(cuts) > SEGMENTS_MAX + 1:
            return [Segment(0, total, True)]
        return [Segment(int(a), int(b - a), bool(is_quad[a])) for a, b in pairwise(cuts)]

    def _records(self) -> moderngl.Buffer:
        assert self.pages.buffer is not None  # something is drawn
        return self.pages.buffer

    def _textures(self) -> dict[str, Any]:
        assert self._blocks.texture is not None  # something is drawn
        return {"t_levels": self._blocks.texture}
