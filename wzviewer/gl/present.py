"""The finished frame over its background, into a window or into bytes: one path for both."""

import moderngl
import numpy as np

from wzviewer.core.types import ByteArray
from wzviewer.gl.shader import load_program
from wzviewer.gl.targets import Target

Rgba = tuple[float, float, float, float]
Viewport = tuple[int, int, int, int]


class Presenter:
    """Draws frames."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self._program = load_program(ctx, "present.vert", "present.frag")
        self._array = ctx.vertex_array(self._program, [])
        self._bytes = Target(ctx, 4, "f1")

    def draw(
        self,
        frame: moderngl.Texture,
        framebuffer: moderngl.Framebuffer,
        background: Rgba,
        closed_coverage: float = 1.0,
        viewport: Viewport | None = None,
        smooth: bool = True,
        top_first: bool = False,
    ) -> None:
        """Draws a frame's texture.

        Args:
            frame: premultiplied texture whose first row is the top of the image.
            framebuffer: a window's or another.
            background: straight RGBA behind the frame.
            closed_coverage: see `RenderSettings`.
            viewport: (x, y, width, height) in px from the lower left; None is all of it.
            smooth: linear filtering when sizes differ, else nearest.
            top_first: the framebuffer's first row is the top (a texture to be read), not a window.
        """
        kept = framebuffer.viewport
        frame.filter = (moderngl.LINEAR, moderngl.LINEAR) if smooth else (moderngl.NEAREST, moderngl.NEAREST)
        frame.use(0)
        self._program["t_frame"] = 0
        self._program["u_background"] = background
        self._program["u_closed"] = closed_coverage
        self._program["u_top_first"] = float(top_first)
        framebuffer.viewport = viewport or (0, 0, *framebuffer.size)
        framebuffer.use()
        self.ctx.enable_only(moderngl.NOTHING)
        self._array.render(moderngl.TRIANGLES, vertices=3)
        framebuffer.viewport = kept

    def read(self, frame: moderngl.Texture, background: Rgba, closed_coverage: float = 1.0) -> ByteArray:
        """Composites a frame and reads it, (h, w, 4) uint8, alpha straight where background has none."""
        width, height = frame.size
        target = self._bytes.resize(width, height)
        self.draw(frame, target, background, closed_coverage, smooth=False, top_first=True)
        data = target.read(components=4, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(height, width, 4)

    def release(self) -> None:
        """Frees everything."""
        self._bytes.release()
        self._array.release()
        self._program.release()
