"""Lines 6-7 of Algorithm 1 as the app uses them: draw what is needed, and only when it is."""

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.context import GlContext
from wzviewer.gl.frame import Frame, RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

UPLOAD_BYTES = 8 << 20  # to the GPU in a frame, so that an arriving level costs no stutter
BACKGROUND = (0.043, 0.047, 0.055, 1.0)


class SceneDrawing:
    """A `SurfelRenderer` that keeps its picture while nothing changes.

    Args:
        context: to draw in.
        settings: of all pictures.
    """

    def __init__(self, context: GlContext, settings: RenderSettings | None = None) -> None:
        self._renderer = SurfelRenderer(context)
        self._settings = settings or RenderSettings(background=BACKGROUND)
        self._version = 0  # of what the GPU holds
        self._synced: tuple[int, int] | None = None
        self._picture: tuple[tuple[object, ...], Frame] | None = None

    def sync(self, scene: Scene) -> bool:
        """Takes over some of what changed in the scene; returns whether that was all."""
        revision = (id(scene), scene.revision)
        if revision == self._synced:
            return True
        is_complete = self._renderer.sync(scene, UPLOAD_BYTES)
        self._version += 1
        self._synced = revision if is_complete else None
        return is_complete

    def draw(self, camera: Camera, fraction: float = 1.0) -> Frame:
        """Renders the scene at a fraction of the camera's resolution, or returns the same picture."""
        size = (max(round(camera.width * fraction), 1), max(round(camera.height * fraction), 1))
        key = (id(camera), camera, size, self._version)  # the camera is held, so its id stays its own
        if self._picture is None or self._picture[0] != key:
            small = camera.resized(*size) if fraction < 1.0 else camera
            self._picture = (key, self._renderer.render(small, self._settings))
        return self._picture[1]

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
            "Graphics memory": f"{stats.gpu_bytes / 2**20:.0f} MiB",
        }

    def close(self) -> None:
        """Frees the GPU."""
        self._picture = None
        self._renderer.release()
