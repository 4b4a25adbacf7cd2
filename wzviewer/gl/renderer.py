"""Draws a scene: the public face of `gl`.

Example:
    ::

        with create_context() as context:
            renderer = SurfelRenderer(context)
            renderer.sync(scene)
            frame = renderer.render(camera)
            frame.read_color8()  # (h, w, 3) uint8
"""

from dataclasses import replace
from typing import Any, Literal

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.context import GlContext
from wzviewer.gl.frame import DrawCost, Frame, FrameStats, MedianMap, Picture, RenderSettings
from wzviewer.gl.merging import MergeQueue
from wzviewer.gl.ordering import OrderQueue
from wzviewer.gl.picking import pick
from wzviewer.gl.present import Presenter
from wzviewer.gl.records import RECORD_BYTES
from wzviewer.gl.shading import ShaderRasterizer
from wzviewer.gl.software import Kernels, SoftwareRasterizer
from wzviewer.gl.visible import Choice, Ordered, Selection, select

DEFAULT_SETTINGS = RenderSettings()
ANTIALIAS_SPACING_PX = 0.5
MARGIN_SHARE = 0.15  # of the image, around it: kept for a frame in motion, whose order is a little old

RasterizerName = Literal["auto", "shaders", "kernels"]


class SurfelRenderer:
    """Keeps a scene ready to draw, and draws it.

    Args:
        context: to draw in.
        rasterizer: ``shaders``; ``kernels`` draws on the CPU; ``auto`` does so where OpenGL is software.
        gpu_order: whether the GPU orders surfels for the shaders; None: a real one with OpenGL 4.3 does.
        patient: wait for the kernels and for merged surfels; when False the shaders draw until the
            kernels are ready, exact surfels until merged ones have been made, and `render_soon` draws
            nothing until it has the first order of all.
    """

    def __init__(
        self,
        context: GlContext,
        rasterizer: RasterizerName = "auto",
        patient: bool = True,
        gpu_order: bool | None = None,
    ) -> None:
        self.patient = patient
        self._gpu_order = gpu_order
        self.context = context
        self._presenter = Presenter(context.ctx)
        self._merges = MergeQueue()
        self._orders = OrderQueue()
        wants_kernels = rasterizer == "kernels" or (rasterizer == "auto" and context.is_software)
        self._kernels = Kernels() if wants_kernels else None
        self._use(self._choose(patient))
        self._selected: tuple[tuple[Any, ...], Selection] | None = None
        self._ordered: Ordered | None = None

    @property
    def rasterizer(self) -> str:
        """Who draws now: ``shaders`` or ``kernels``."""
        return self._rasterizer.name

    def is_ready(self, wait_s: float | None = 0.0) -> bool:
        """Waits for the kernels, if they are wanted; the first time on a machine they are compiled.

        Args:
            wait_s: at most so long; None as long as it takes.

        Returns:
            Whether the rasteriser is the one that was asked for, as far as this machine has it.
        """
        if self._kernels is None:
            return True
        self._kernels.are_ready(wait_s)
        return not self._kernels.are_loading

    @property
    def has_levels(self) -> bool:
        """Whether anything of a scene has arrived."""
        return bool(self._arrivals.states)

    @property
    def version(self) -> tuple[int, ...]:
        """Changes when what would be drawn changes."""
        return (id(self._rasterizer), self._rasterizer.pages.generation, self._arrivals.version)

    @property
    def gpu_bytes(self) -> int:
        """Memory held for the scene's records and the frame, bytes."""
        return self._rasterizer.num_bytes

    @property
    def bytes_per_surfel(self) -> float:
        """GPU memory of one surfel; those that are drawn take 4 more in the element index."""
        return float(RECORD_BYTES)

    def sync(self, scene: Scene, budget_bytes: int | None = None, merged: bool = False) -> bool:
        """Brings the renderer up to the scene's revision; costs nothing when nothing changed.

        Args:
            scene: to be drawn.
            budget_bytes: take over at most about this much now; None takes everything.
            merged: also make merged surfels, in the background, for `RenderSettings.spacing_px`.

        Returns:
            Whether every level has arrived; when False, call again next frame.
        """
        if self._kernels is not None and not isinstance(self._rasterizer, SoftwareRasterizer):
            if self._take_kernels():
                budget_bytes = None  # nothing is copied, and a frame without them would be empty
        return self._arrivals.sync(scene, budget_bytes, self._merges if merged else None)

    def wait_for_merged(self, scene: Scene) -> None:
        """Waits until the merged surfels of all levels can be drawn."""
        while not self.sync(scene, merged=True) or self._merges.is_busy:
            self._merges.wait()

    def render(self, camera: Camera, settings: RenderSettings = DEFAULT_SETTINGS) -> Frame:
        """Draws the levels of the last `sync`, in the exact order for this camera.

        Returns:
            A frame whose picture is valid until the next call.
        """
        if camera.width <= 0 or camera.height <= 0:
            return self._empty(camera, settings)
        selection = self._select(camera, settings)
        if selection.unmerged and self.patient:
            self._arrivals.merge(selection.unmerged, self._merges)
            selection = self._select(camera, settings)
        if isinstance(self._rasterizer, SoftwareRasterizer):
            drawn = self._rasterizer.draw(selection, camera, settings)
            return self._frame(*drawn, selection, camera, settings)
        self._orders.forget_older(self._arrivals.states)
        self._rasterizer.pages.reclaim()  # nothing older is drawn from here on
        ordered = None if self._rasterizer.can_order(selection) else self._order(selection)
        shaded = self._rasterizer.draw(selection, ordered, camera, settings)
        return self._frame(*shaded, selection, camera, settings)

    def render_soon(self, camera: Camera, settings: RenderSettings = DEFAULT_SETTINGS) -> Frame:
        """Draws at once with the newest order there is, and has the exact one made in the background.

        Where the kernels draw or the GPU orders, the sort is a small part of the frame: this is `render`.

        Returns:
            A frame; its ``stats.is_exact`` says whether it is what `render` would have drawn.
        """
        rasterizer = self._rasterizer
        if camera.width <= 0 or camera.height <= 0 or isinstance(rasterizer, SoftwareRasterizer):
            return self.render(camera, settings)
        if rasterizer.orders_itself:
            return self.render(camera, settings)
        choice = replace(self._choice(settings), margin_px=MARGIN_SHARE * max(camera.width, camera.height))
        self._orders.ask(self._arrivals.states, camera, choice)
        if not self.patient and self._orders.is_first:  # a quarter of a second, that no frame waits for
            return replace(self._empty(camera, settings), stats=FrameStats(is_exact=False))
        newest = self._orders.newest(self._arrivals.states, camera, choice)
        if newest.is_current:
            rasterizer.pages.reclaim()
        selection = newest.ordered.selection
        shaded = rasterizer.draw(selection, newest.ordered, camera, settings)
        return self._frame(*shaded, selection, camera, settings, newest.is_exact)

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
        exact = replace(settings, spacing_px=0.0, antialias=False, contribution_min=0.0)
        return pick(self._arrivals.states, camera, (x_px, y_px), self._choice(exact), settings.blend)

    def release(self) -> None:
        """Frees all GPU objects and ends the threads."""
        self._merges.close()
        self._orders.close()
        self._rasterizer.release()
        self._presenter.release()
        self._selected = self._ordered = None

    # ------------------------------------------------------------- parts

    def _choose(self, patient: bool) -> ShaderRasterizer | SoftwareRasterizer:
        if self._kernels is not None and self._kernels.are_ready(None if patient else 0.0):
            return SoftwareRasterizer(self.context, self._kernels)
        return ShaderRasterizer(self.context.ctx, self.context.is_software, self._gpu_order)

    def _use(self, rasterizer: ShaderRasterizer | SoftwareRasterizer) -> None:
        self._rasterizer = rasterizer
        self._arrivals = Arrivals(rasterizer.pages)

    def _take_kernels(self) -> bool:
        """Changes over to the kernels once they have been compiled; returns whether it did."""
        if self._kernels is None or not self._kernels.are_ready():
            return False
        self._rasterizer.release()
        self._use(SoftwareRasterizer(self.context, self._kernels))
        self._selected = self._ordered = None
        return True

    # ------------------------------------------------------------- frame

    def _choice(self, settings: RenderSettings) -> Choice:
        return Choice(
            settings.modulation,
            settings.culling,
            settings.spacing_px,
            ANTIALIAS_SPACING_PX if settings.antialias and settings.modulation else 0.0,
            settings.contribution_min,
            finer=settings.finer,
            point_limit_px=self._rasterizer.point_limit_px,
        )

    def _select(self, camera: Camera, settings: RenderSettings) -> Selection:
        choice = self._choice(settings)
        key = (self._arrivals.states, camera.key, choice)
        if self._selected is None or self._selected[0][0] is not key[0] or self._selected[0][1:] != key[1:]:
            self._selected = (key, select(self._arrivals.states, camera, choice))
        return self._selected[1]

    def _order(self, selection: Selection) -> Ordered:
        """The order of a selection, kept for the next frame from the same camera."""
        if self._ordered is None or self._ordered.selection is not selection:
            self._ordered = selection.ordered()
        elif self._ordered.sort_ms:
            self._ordered = replace(self._ordered, sort_ms=0.0)  # this frame did not sort
        return self._ordered

    def _frame(
        self,
        picture: Picture,
        cost: DrawCost,
        selection: Selection,
        camera: Camera,
        settings: RenderSettings,
        is_exact: bool = True,
    ) -> Frame:
        median = None
        if settings.outputs & {"depth", "level"}:
            median = MedianMap(self._rasterizer.median_places(), selection.runs)
        stats = FrameStats(
            num_visible=cost.num_drawn,
            num_surfels=selection.num_surfels,
            num_chunks=selection.num_chunks,
            cull_ms=selection.cull_ms,
            sort_ms=cost.sort_ms,
            draw_ms=cost.draw_ms,
            rasterizer=cost.rasterizer,
            quads=cost.quads,
            gpu_bytes=self.gpu_bytes,
            is_exact=is_exact,
        )
        return Frame(camera, settings, picture, stats, self._presenter, median)

    def _empty(self, camera: Camera, settings: RenderSettings) -> Frame:
        return Frame(camera, settings, None, FrameStats(), self._presenter)
