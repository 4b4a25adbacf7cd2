"""Draws a scene: the public face of `gl`.

Example:
    ::

        with create_context() as context:
            renderer = SurfelRenderer(context)
            renderer.sync(scene)
            frame = renderer.render(camera)
            frame.read_color8()  # (h, w, 3) uint8
"""

import time
from dataclasses import replace
from typing import Any

import moderngl
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.gl.blocks import BlockTexture
from wzviewer.gl.context import GlContext
from wzviewer.gl.draw import SurfelDraw, Variant
from wzviewer.gl.frame import Frame, FrameStats, MedianMap, RenderSettings
from wzviewer.gl.median import MedianPass
from wzviewer.gl.picking import pick
from wzviewer.gl.present import Presenter
from wzviewer.gl.records import RECORD_BYTES
from wzviewer.gl.surfel_buffer import PAGE_SURFELS, SurfelBuffer
from wzviewer.gl.targets import Target
from wzviewer.gl.visible import LevelState, Prepared, growth_of, prepare

DEFAULT_SETTINGS = RenderSettings()


class SurfelRenderer:
    """Keeps a scene on the GPU and draws it.

    A level is drawn when all its surfels have arrived; until then its parent shows through, and a
    level that is replaced keeps its former version.
    """

    def __init__(self, context: GlContext) -> None:
        self.context = context
        ctx = context.ctx
        self._buffer = SurfelBuffer(ctx)
        self._blocks = BlockTexture(ctx)
        self._draw = SurfelDraw(ctx)
        # Software drivers blend float32 as fast as float16, which they round towards zero.
        self._target = Target(ctx, 4, "f4" if context.is_software else "f2")
        self._presenter = Presenter(ctx)
        self._median: MedianPass | None = None
        self._levels: dict[int, Level] = {}  # whose surfels are complete on the GPU
        self._states: dict[int, LevelState] = {}  # of those that are drawn
        self._synced: tuple[Any, ...] = ()
        self._prepared: tuple[tuple[Any, ...], Prepared] | None = None
        self._ordered: Prepared | None = None  # what the element index holds

    @property
    def gpu_bytes(self) -> int:
        """GPU memory held, bytes."""
        parts = (self._buffer.num_bytes, self._blocks.num_bytes, self._draw.num_bytes, self._target.num_bytes)
        return sum(parts) + (self._median.num_bytes if self._median else 0)

    @property
    def bytes_per_surfel(self) -> float:
        """GPU memory of one surfel; those that are drawn take 4 more in the element index."""
        return float(RECORD_BYTES)

    def sync(self, scene: Scene, budget_bytes: int | None = None) -> bool:
        """Brings the GPU up to the scene's revision; costs nothing when nothing changed.

        Args:
            scene: to be drawn.
            budget_bytes: upload at most about this much now; None uploads everything.

        Returns:
            Whether every level has arrived; when False, call again next frame.
        """
        if self._synced[:2] != (id(scene), scene.revision):
            self._stage(scene)
        self._buffer.upload(budget_bytes)
        synced = (id(scene), scene.revision, self._buffer.generation)
        if synced != self._synced:
            self._synced = synced
            self._adopt(scene)
        return all(self._buffer.shown(lv.index) is lv.surfels for lv in scene if len(lv.surfels))

    def render(self, camera: Camera, settings: RenderSettings = DEFAULT_SETTINGS) -> Frame:
        """Draws the levels of the last `sync`.

        Returns:
            A frame whose texture is valid until the next call.
        """
        if camera.width <= 0 or camera.height <= 0:
            return Frame(camera, settings, None, FrameStats(), self._presenter)
        cached = self._prepared
        prepared = self._prepare(camera, settings)
        began = time.perf_counter()
        quads = self._chooses_quads(prepared, settings)
        variant = Variant(quads, settings.blend == "linear", prepared.is_unit_weight)
        self._draw.growth = growth_of(settings.stride)
        self._draw_color(prepared, camera, variant)
        median = self._find_median(prepared, camera, variant) if _wants_median(settings) else None
        reused = cached is not None and cached[1] is prepared
        stats = self._stats(prepared, quads, 1e3 * (time.perf_counter() - began), reused)
        return Frame(camera, settings, self._target.texture, stats, self._presenter, median)

    def pick(
        self, camera: Camera, x_px: float, y_px: float, settings: RenderSettings = DEFAULT_SETTINGS
    ) -> tuple[float, int] | None:
        """Finds the surface under a pixel.

        Args:
            camera: that the user looks through.
            x_px: image column, px.
            y_px: image row, px.
            settings: of the frame that is seen.

        Returns:
            Median depth (world units along the camera's axis) and level index, or None on emptiness.
        """
        prepared = self._prepare(camera, replace(settings, stride=1))
        return pick(self._states, prepared, camera, (x_px, y_px), settings.blend, settings.modulation)

    def release(self) -> None:
        """Frees all GPU objects."""
        for part in (self._buffer, self._blocks, self._draw, self._target, self._presenter, self._median):
            if part is not None:
                part.release()
        self._levels, self._states, self._synced = {}, {}, ()
        self._prepared = self._ordered = self._median = None

    # ------------------------------------------------------------- scene

    def _stage(self, scene: Scene) -> None:
        for level in scene:
            if len(level.surfels) and self._buffer.latest(level.index) is not level.surfels:
                self._buffer.stage(level.index, level.surfels, level.index)  # slot = index <= 255
        for index in sorted(self._buffer.levels()):
            if index >= len(scene) or not len(scene[index].surfels):
                self._buffer.remove(index)
                self._levels.pop(index, None)

    def _adopt(self, scene: Scene) -> None:
        """Takes what has arrived as the levels that are drawn."""
        for level in scene:
            if self._buffer.shown(level.index) is level.surfels:
                self._levels[level.index] = level
        drawn = self._replica(scene)
        states = {}
        for index in drawn.visible():
            states[index] = self._state(drawn, index)
        self._states = states
        self._prepared = None
        if states:
            self._blocks.set_modulations({i: s.modulation for i, s in states.items()})

    def _replica(self, scene: Scene) -> Scene:
        """The scene with levels that have not arrived hidden, and replaced ones in their old state."""
        replica = Scene()
        for level in scene:
            replica.append(self._levels.get(level.index, level))
            if level.index not in self._levels or level.index in scene.hidden:
                replica.hide(level.index)
        return replica

    def _state(self, drawn: Scene, index: int) -> LevelState:
        level, surfels = drawn[index], self._buffer.shown(index)
        assert surfels is not None  # hidden in the replica otherwise
        records, covers = self._buffer.first_records(index), modulation(drawn, index)
        former = self._states.get(index)
        if former is not None and former.surfels is surfels:
            return former.moved(level, records, covers)
        return LevelState.measure(level, surfels, records, covers, PAGE_SURFELS)

    # ------------------------------------------------------------- frame

    def _prepare(self, camera: Camera, settings: RenderSettings) -> Prepared:
        pose = camera.camera_from_world.tobytes()
        lens = (camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)
        key = (pose, lens, self._synced, settings.modulation, settings.culling, settings.stride)
        if self._prepared is None or self._prepared[0] != key:
            how = (settings.modulation, settings.culling, settings.stride)
            self._prepared = (key, prepare(self._states, camera, *how))
        return self._prepared[1]

    def _chooses_quads(self, prepared: Prepared, settings: RenderSettings) -> bool:
        if settings.quads is not None:
            return settings.quads
        return not self._draw.fits_points(prepared.radius_px)

    def _draw_color(self, prepared: Prepared, camera: Camera, variant: Variant) -> None:
        framebuffer = self._target.resize(camera.width, camera.height)
        framebuffer.clear(0.0, 0.0, 0.0, 0.0)
        if not len(prepared.order):
            return
        if self._ordered is not prepared:
            self._draw.set_order(prepared.order)
            self._ordered = prepared
        self._blocks.set_views(prepared.views)
        ctx = self.context.ctx
        ctx.enable_only(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        ctx.blend_func = (moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)
        self._draw.draw(variant, framebuffer, self._records(), self._textures())
        ctx.enable_only(moderngl.NOTHING)

    def _records(self) -> moderngl.Buffer:
        assert self._buffer.buffer is not None  # something is drawn
        return self._buffer.buffer

    def _textures(self) -> dict[str, moderngl.Texture]:
        assert self._blocks.texture is not None  # something is drawn
        return {"t_levels": self._blocks.texture}

    def _find_median(self, prepared: Prepared, camera: Camera, variant: Variant) -> MedianMap:
        size = (camera.width, camera.height)
        if not len(prepared.order):
            return MedianMap(np.zeros(size[::-1], np.uint32), prepared.order, prepared.runs)
        self._median = self._median or MedianPass(self.context.ctx)
        self._draw.set_ranks(prepared.order, self._buffer.capacity_surfels)
        textures = self._textures()
        ranks = self._median.ranks(self._draw, variant, size, len(prepared.order), self._records(), textures)
        return MedianMap(ranks, prepared.order, prepared.runs)

    def _stats(self, prepared: Prepared, quads: bool, draw_ms: float, reused: bool) -> FrameStats:
        stats = FrameStats(
            num_visible=len(prepared.order),
            num_surfels=prepared.num_surfels,
            num_chunks=prepared.num_chunks,
            cull_ms=prepared.cull_ms,
            sort_ms=prepared.sort_ms,
            draw_ms=draw_ms,
            quads=quads,
            gpu_bytes=self.gpu_bytes,
        )
        return replace(stats, cull_ms=0.0, sort_ms=0.0) if reused else stats


def _wants_median(settings: RenderSettings) -> bool:
    return bool(settings.outputs & {"depth", "level"})
