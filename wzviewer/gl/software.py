"""Draws with the CPU kernels where OpenGL itself is software.

A software driver spends most of a frame on setting up a primitive for each surfel, on one thread.
The kernels know that all of them are Gaussians: they project, sort, bin and composite the same surfels
on all cores, front to back, and stop where nothing shines through any more.  OpenGL is left to present
the picture.  Formulas, order and constants are those of the shaders, and a test holds the two together.
"""

import logging
import threading
import time
from typing import Any

import moderngl
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import ByteArray, FloatArray, IntArray
from wzviewer.gl.blit import Blit
from wzviewer.gl.context import GlContext
from wzviewer.gl.frame import DrawCost, RenderSettings
from wzviewer.gl.pages import Pages
from wzviewer.gl.present import Presenter, Rgba, Viewport
from wzviewer.gl.targets import Target
from wzviewer.gl.visible import Selection

LOG = logging.getLogger(__name__)
TRANSPARENT: Rgba = (0.0, 0.0, 0.0, 0.0)


class HostPicture:
    """A picture in memory; it becomes a texture when a window wants to show it.

    Args:
        planes: `kernels.splatting.Planes`.
        size: width and height, px.
        target: of pictures that a quad shows.
        kernels: the module `kernels.presenting`.
        blit: shows pictures that fill a framebuffer; None lets quads do it.
    """

    def __init__(
        self,
        planes: Any,  # noqa: ANN401 - of a package that is imported late
        size: tuple[int, int],
        target: Target,
        kernels: Any,  # noqa: ANN401
        blit: Blit | None = None,
    ) -> None:
        self._planes, self._size, self._target = planes, size, target
        self._kernels, self._blit = kernels, blit
        self._shown: tuple[object, ...] = ()  # what the texture holds

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
        x_px, y_px, width, height = viewport or (0, 0, *framebuffer.size)
        size = (width, height)
        if self._blit is not None and (smooth or size == self._size):
            is_window = framebuffer.glo == 0
            if self._is_new(background, closed_coverage, size, is_window):
                picture = self._composited(background, closed_coverage)
                self._blit.upload(self._fitted(picture, size, is_window), is_window)
            self._blit.draw(framebuffer, x_px, y_px)
            return
        if self._is_new(background, closed_coverage):
            self._target.resize(*self._size)
            self._target.texture.write(self._composited(background, closed_coverage), alignment=1)
        presenter.draw(self._target.texture, framebuffer, TRANSPARENT, 1.0, viewport, smooth)

    def _fitted(self, picture: ByteArray, size: tuple[int, int], is_window: bool) -> ByteArray:
        """Enlarged here, in the order of rows and channels that OpenGL has only to copy."""
        fitted = np.empty((size[1], size[0], 4), np.uint8)
        self._kernels.fit(_pixels(picture), _pixels(fitted), not is_window, is_window)
        return fitted

    def _is_new(self, *shown: object) -> bool:
        before, self._shown = self._shown, shown
        return before != shown

    def read(self) -> FloatArray:
        """Premultiplied colour and coverage, (h, w, 4) float32."""
        width, height = self._size
        out = np.empty((height, width, 4), np.float32)
        self._kernels.interleave(self._planes.color, self._planes.through, out)
        return out

    def read8(self, presenter: Presenter, background: Rgba, closed_coverage: float) -> ByteArray:
        """Composited over a background, (h, w, 4) uint8."""
        return self._composited(background, closed_coverage)

    def _composited(self, background: Rgba, closed_coverage: float) -> ByteArray:
        width, height = self._size
        out = np.empty((height, width, 4), np.uint8)
        behind = np.array(background, np.float32)
        self._kernels.present(self._planes.color, self._planes.through, behind, closed_coverage, out)
        return out


def _pixels(picture: ByteArray) -> Any:  # noqa: ANN401 - (h, w) uint32
    return picture.view(np.uint32)[..., 0]


class Kernels:
    """The compiled loops, loaded on a thread: the first time on a machine they are compiled for it."""

    def __init__(self) -> None:
        self._splatting: Any = None
        self._presenting: Any = None
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._load, name="kernels", daemon=True)
        self._thread.start()

    def are_ready(self, wait_s: float | None = 0.0) -> bool:
        """Waits for them, None for as long as it takes; False for good where numba is not installed."""
        self._thread.join(wait_s)
        return not self.are_loading and self._error is None

    @property
    def are_loading(self) -> bool:
        """Whether waiting may help."""
        return self._thread.is_alive()

    def splatter(self) -> Any:  # noqa: ANN401 - of a package that is imported late
        """Returns a new `kernels.splatting.Splatter`."""
        return self._splatting.Splatter()

    def weights_of(self, is_plain: bool) -> int:
        """Where the weights of a run come from, as `kernels.footprints` puts it."""
        return int(self._splatting.PLAIN if is_plain else self._splatting.BY_CAMERAS)

    @property
    def presenting(self) -> Any:  # noqa: ANN401 - of a package that is imported late
        """The module `kernels.presenting`."""
        return self._presenting

    def _load(self) -> None:
        try:
            from wzviewer.kernels import presenting, splatting

            splatting.warm_up()
        except Exception as error:  # no numba, an unknown processor, no folder for the compiled code
            LOG.info("no kernels: %s", error)
            self._error = error
            return
        self._splatting, self._presenting = splatting, presenting


class SoftwareRasterizer:
    """Draws selections with the kernels.

    Attributes:
        pages: of the levels; nothing is copied, they only pace the arrival.
    """

    name = "kernels"
    point_limit_px = float("inf")

    def __init__(self, context: GlContext, kernels: Kernels) -> None:
        self.pages = Pages()
        self._kernels = kernels
        self._splatter = kernels.splatter()
        self._target = Target(context.ctx, 4, "f1")
        self._blit = Blit.of(context)

    @property
    def num_bytes(self) -> int:
        """Memory of the frame's arrays and of the texture, bytes."""
        blitted = 0 if self._blit is None else self._blit.num_bytes
        return int(self._splatter.num_bytes) + self._target.num_bytes + blitted

    def draw(
        self, selection: Selection, camera: Camera, settings: RenderSettings
    ) -> tuple[HostPicture, DrawCost]:
        """Draws a selection from its own camera."""
        began = time.perf_counter()
        size = (camera.width, camera.height)
        splatter, is_linear = self._splatter, settings.blend == "linear"
        splatter.begin(selection.num_selected, *size)
        for index, level in selection.seen.items():
            texels = None if level.modulation is None else level.modulation.texels(not is_linear)
            view, source = selection.views[index], level.runs[0].source  # all runs are of one set
            row = level.runs[0].depth_row(selection.focus)
            pieces = [(run.piece, self._kernels.weights_of(run.is_plain)) for run in level.runs]
            splatter.add(source.surfels, view, row, pieces, texels, None, settings.contribution_min)
        projected = time.perf_counter()
        splatter.sort()
        sorted_at = time.perf_counter()
        planes = splatter.draw((0.0, 0.0, 0.0), is_linear)
        drawn = time.perf_counter()
        draw_ms = 1e3 * (drawn - sorted_at + projected - began)
        cost = DrawCost(splatter.num_drawn, 1e3 * (sorted_at - projected), draw_ms, self.name)
        return HostPicture(planes, size, self._target, self._kernels.presenting, self._blit), cost

    def median_places(self) -> IntArray:
        """Place in the selection's runs where transmittance crosses 1/2, (h, w); -1 where nowhere."""
        return np.asarray(self._splatter.median())

    def release(self) -> None:
        """Frees everything."""
        self.pages.release()
        self._target.release()
        if self._blit is not None:
            self._blit.release()
