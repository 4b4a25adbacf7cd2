"""Lines 6-7 of Algorithm 1 as the app uses them: draw what is needed, and only when it is."""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

from wzviewer.app.look import Look, Mode, false_colors
from wzviewer.app.pacing import SOFTWARE_TARGET_S, SPACING_PX, TARGET_S
from wzviewer.app.services import PLAIN
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.gl.context import GlContext
from wzviewer.gl.frame import Frame, FrameStats, Output, RenderSettings
from wzviewer.gl.present import Presenter, Rgba
from wzviewer.gl.renderer import RasterizerName, SurfelRenderer
from wzviewer.gl.tiles import tiled
from wzviewer.gl.timing import FrameTimer

UPLOAD_BYTES = 4 << 20  # to the renderer in a frame, so that an arriving level costs no stutter
MOVING_UPLOAD_BYTES = 1536 << 10  # the same while the camera moves: three pages, 4 ms on a slow machine
FAINT_PX2 = 0.5  # opacity times area on the screen: what is less is not seen
OUTPUTS: dict[Mode, frozenset[Output]] = {
    "picture": frozenset({"color"}),
    "levels": frozenset({"color", "level"}),
    "depth": frozenset({"color", "depth"}),
    "coverage": frozenset({"color"}),
}
BACKGROUND = (0.043, 0.047, 0.055, 1.0)
DIMMED = 0.6  # mean colour of a photo that stands for what is behind it, until that has been made


@dataclass(frozen=True, eq=False)
class ColoredFrame:
    """A frame in false colours.

    Attributes:
        colors: (h, w, 3) uint8.
        texture: the same on the GPU.
        presenter: draws it.
        stats: of the frame that it was made from.
    """

    colors: ByteArray
    texture: Any
    presenter: Presenter
    stats: FrameStats

    def present_to(self, framebuffer: Any, viewport: tuple[int, int, int, int] | None = None) -> None:  # noqa: ANN401
        """Draws it into a framebuffer, each pixel as it is."""
        self.presenter.draw(self.texture, framebuffer, BACKGROUND, 1.0, viewport, smooth=False)

    def read_color8(self) -> ByteArray:
        """Returns (h, w, 3) uint8."""
        return self.colors


class SceneDrawing:
    """A `SurfelRenderer` that keeps its picture while nothing changes.

    Args:
        context: to draw in.
        settings: of all pictures.
        rasterizer: who draws.
    """

    def __init__(
        self,
        context: GlContext,
        settings: RenderSettings | None = None,
        rasterizer: RasterizerName = "auto",
    ) -> None:
        self._renderer = SurfelRenderer(context, rasterizer, patient=False)
        self._settings = settings or RenderSettings(background=BACKGROUND)
        self.target_s = SOFTWARE_TARGET_S if context.is_software else TARGET_S
        self._picture: tuple[tuple[object, ...], Frame | ColoredFrame] | None = None
        self._ctx = context.ctx
        self._presenter: Presenter | None = None
        self._texture: Any = None
        self._timer = FrameTimer(context.ctx)
        self._is_moving = False
        self._behind: Rgba = self._settings.background
        self._means: tuple[ByteArray | None, Rgba] = (None, BACKGROUND)  # of a picture

    def sync(self, scene: Scene) -> bool:
        """Takes over some of what changed in the scene; returns whether that was all."""
        budget_bytes: int | None = MOVING_UPLOAD_BYTES if self._is_moving else UPLOAD_BYTES
        is_making_photo = len(scene) == 1 and not scene.is_committed(0)
        self._behind = self._mean_of(scene[0].image) if is_making_photo else self._settings.background
        if not self._renderer.has_levels:
            budget_bytes = None  # the first picture comes whole
        return self._renderer.sync(scene, budget_bytes, merged=True)

    def draw(
        self, camera: Camera, fraction: float = 1.0, is_moving: bool = False, look: Look = PLAIN
    ) -> "Frame | ColoredFrame":
        """Renders the scene, or returns the same picture while nothing changes.

        Args:
            camera: at full resolution.
            fraction: of the resolution, in each direction.
            is_moving: whether merged surfels and a slightly old order may stand in.
            look: what is drawn, and in which colours.
        """
        self._is_moving = is_moving
        size = (max(round(camera.width * fraction), 1), max(round(camera.height * fraction), 1))
        key = (camera.key, size, is_moving, self._renderer.version, look, self._behind)
        if self._picture is None or self._picture[0] != key or not self._picture[1].stats.is_exact:
            small = camera.resized(*size) if fraction < 1.0 else camera
            is_coarse = is_moving and fraction < 1.0  # at full resolution there is time for every surfel
            settings = replace(self._looked(look, is_coarse), finer=camera.width / small.width)
            with self._timer.frame() if is_moving else nullcontext():
                frame = self._renderer.render_soon(small, settings)
                self._picture = (key, frame if look.mode == "picture" else self._colored(frame, look.mode))
        return self._picture[1]

    def _looked(self, look: Look, is_coarse: bool) -> RenderSettings:
        return replace(
            self._settings,
            background=self._behind,
            modulation=look.modulation,
            blend=look.blend,
            antialias=look.merged,
            contribution_min=FAINT_PX2 if look.skips_faint else 0.0,
            spacing_px=SPACING_PX if is_coarse else 0.0,
            outputs=OUTPUTS[look.mode],
        )

    def _mean_of(self, image: ByteArray) -> Rgba:
        if self._means[0] is not image:
            r, g, b = (DIMMED * image[::8, ::8].reshape(-1, 3).mean(0) / 255.0).tolist()
            self._means = (image, (r, g, b, 1.0))
        return self._means[1]

    def _colored(self, frame: Frame, mode: Mode) -> "ColoredFrame":
        self._presenter = self._presenter or Presenter(self._ctx)
        if self._texture is not None:
            self._texture.release()
        colors = false_colors(frame, mode)
        self._texture = self._ctx.texture(
            (colors.shape[1], colors.shape[0]), 3, colors.tobytes(), alignment=1
        )
        return ColoredFrame(colors, self._texture, self._presenter, frame.stats)

    @property
    def gpu_s(self) -> float:
        """What the graphics card itself took for the picture in motion before the last one, s."""
        return self._timer.seconds

    @property
    def is_settled(self) -> bool:
        """Whether the last picture is the exact one for its camera."""
        return self._picture is None or self._picture[1].stats.is_exact

    def picture(self, camera: Camera, look: Look = PLAIN, transparent: bool = False) -> ByteArray:
        """Renders at full quality, in tiles where it is large.

        Args:
            camera: the whole view, of any size.
            look: how it is drawn; false colours have a background, and are drawn in one piece.
            transparent: leave the background out.

        Returns:
            (h, w, 3) uint8, or (h, w, 4) with coverage as straight alpha.
        """
        if look.mode != "picture":
            return self.draw(camera, look=look).read_color8()
        self._picture = None  # a frame is valid until the next one
        return tiled(self._renderer, camera, self._looked(look, is_coarse=False), transparent)

    def pick(self, camera: Camera, x_px: float, y_px: float) -> tuple[float, int] | None:
        """Returns depth in world units and level index at a pixel; None on emptiness."""
        return self._renderer.pick(camera, x_px, y_px, self._settings)

    def statistics(self) -> dict[str, str]:
        """Returns lines for the statistics panel."""
        if self._picture is None:
            return {}
        stats = self._picture[1].stats
        return {
            "Surfels drawn": f"{stats.num_visible:,}",
            "Surfels in view": f"{stats.num_surfels:,}",
            "Cull · sort · draw": f"{stats.cull_ms:.0f} · {stats.sort_ms:.0f} · {stats.draw_ms:.0f} ms",
            "Drawn by": "graphics card" if stats.rasterizer == "shaders" else "processor",
            "Renderer memory": f"{stats.gpu_bytes / 2**20:.0f} MiB",
        }

    def close(self) -> None:
        """Frees the GPU."""
        self._picture = None
        for kept in (self._texture, self._presenter):
            if kept is not None:
                kept.release()
        self._renderer.release()
