"""Lines 6-7 of Algorithm 1 as the app uses them: draw what is needed, and only when it is."""

from contextlib import nullcontext
from dataclasses import replace

from wzviewer.app.pacing import SOFTWARE_TARGET_S, SPACING_PX, TARGET_S
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.context import GlContext
from wzviewer.gl.frame import Frame, RenderSettings
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.timing import FrameTimer

UPLOAD_BYTES = 4 << 20  # to the renderer in a frame, so that an arriving level costs no stutter
BACKGROUND = (0.043, 0.047, 0.055, 1.0)


class SceneDrawing:
    """A `SurfelRenderer` that keeps its picture while nothing changes.

    Args:
        context: to draw in.
        settings: of all pictures.
    """

    def __init__(self, context: GlContext, settings: RenderSettings | None = None) -> None:
        self._renderer = SurfelRenderer(context, patient=False)
        self._settings = settings or RenderSettings(background=BACKGROUND)
        self.target_s = SOFTWARE_TARGET_S if context.is_software else TARGET_S
        self._picture: tuple[tuple[object, ...], Frame] | None = None
        self._timer = FrameTimer(context.ctx)

    def sync(self, scene: Scene) -> bool:
        """Takes over some of what changed in the scene; returns whether that was all."""
        budget_bytes = UPLOAD_BYTES if self._renderer.has_levels else None  # the first picture comes whole
        return self._renderer.sync(scene, budget_bytes, merged=True)

    def draw(self, camera: Camera, fraction: float = 1.0, is_moving: bool = False) -> Frame:
        """Renders the scene, or returns the same picture while nothing changes.

        Args:
            camera: at full resolution.
            fraction: of the resolution, in each direction.
            is_moving: whether merged surfels and a slightly old order may stand in.
        """
        size = (max(round(camera.width * fraction), 1), max(round(camera.height * fraction), 1))
        key = (camera.key, size, is_moving, self._renderer.version)
        if self._picture is None or self._picture[0] != key or not self._picture[1].stats.is_exact:
            small = camera.resized(*size) if fraction < 1.0 else camera
            is_coarse = is_moving and fraction < 1.0  # at full resolution there is time for every surfel
            settings = replace(self._settings, spacing_px=SPACING_PX) if is_coarse else self._settings
            with self._timer.frame() if is_moving else nullcontext():
                self._picture = (key, self._renderer.render_soon(small, settings))
        return self._picture[1]

    @property
    def gpu_s(self) -> float:
        """What the graphics card itself took for the picture in motion before the last one, s."""
        return self._timer.seconds

    @property
    def is_settled(self) -> bool:
        """Whether the last picture is the exact one for its camera."""
        return self._picture is None or self._picture[1].stats.is_exact

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
        self._renderer.release()
