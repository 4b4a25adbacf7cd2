"""A picture in memory, copied into a framebuffer without a shader.

A software driver takes 4 to 12 ms to draw a quad over a window, and 0.3 ms to copy it, if the copy has
nothing to do: same size, same order of channels and of rows.  Windows keep blue first and the top row
first, textures the other way round; moderngl knows neither that format nor a copy that flips.
"""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any, Self

import moderngl

from wzviewer.core.types import ByteArray
from wzviewer.gl.context import GlContext

GL_TEXTURE_2D, GL_RGBA, GL_RGBA8, GL_BGRA = 0x0DE1, 0x1908, 0x8058, 0x80E1
GL_UNSIGNED_BYTE, GL_BYTES_IN_A_WORD = 0x1401, 0x8367  # the latter: UNSIGNED_INT_8_8_8_8_REV
GL_READ_FRAMEBUFFER, GL_DRAW_FRAMEBUFFER = 0x8CA8, 0x8CA9
GL_COLOR_BUFFER_BIT, GL_NEAREST = 0x4000, 0x2600
SIGNATURES: Mapping[str, tuple[Any, ...]] = {
    "glBindTexture": (ctypes.c_uint,) * 2,
    "glTexImage2D": (ctypes.c_uint, *(ctypes.c_int,) * 5, *(ctypes.c_uint,) * 2, ctypes.c_void_p),
    "glTexSubImage2D": (ctypes.c_uint, *(ctypes.c_int,) * 5, *(ctypes.c_uint,) * 2, ctypes.c_void_p),
    "glBindFramebuffer": (ctypes.c_uint,) * 2,
    "glBlitFramebuffer": (*(ctypes.c_int,) * 8, *(ctypes.c_uint,) * 2),
}


class Blit:
    """Shows pictures as they are.

    Args:
        ctx: to draw in.
        functions: of OpenGL, by name.
    """

    def __init__(self, ctx: moderngl.Context, functions: Mapping[str, Callable[..., None]]) -> None:
        self._ctx, self._gl = ctx, functions
        self._texture: moderngl.Texture | None = None
        self._source: moderngl.Framebuffer | None = None
        self._kind: tuple[tuple[int, int], bool] | None = None  # of the texture: size, for a window

    @classmethod
    def of(cls, context: GlContext) -> Self | None:
        """Returns one for a context, or None where its functions cannot be had."""
        if context.load is None:
            return None
        addresses = {name: context.load(name) for name in SIGNATURES}
        if not all(addresses.values()):
            return None
        prototype = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)  # on Windows alone there is the former
        made = {name: prototype(None, *SIGNATURES[name])(addresses[name]) for name in SIGNATURES}
        return cls(context.ctx, made)

    @property
    def num_bytes(self) -> int:
        """Memory of the texture, bytes."""
        return 0 if self._texture is None else 4 * self._texture.width * self._texture.height

    def upload(self, picture: ByteArray, is_for_window: bool) -> None:
        """Takes a picture.

        Args:
            picture: (h, w, 4) uint8: BGRA, top row first, for a window; else RGBA, bottom row first.
            is_for_window: whether the window itself will show it.
        """
        height, width = picture.shape[:2]
        fresh = self._kind != ((width, height), is_for_window)
        if fresh:
            self._remake(width, height, is_for_window)
        assert self._texture is not None  # remade
        pixels = (GL_BGRA, GL_BYTES_IN_A_WORD) if is_for_window else (GL_RGBA, GL_UNSIGNED_BYTE)
        self._gl["glBindTexture"](GL_TEXTURE_2D, self._texture.glo)
        if fresh and is_for_window:  # memory in the order in which it comes: a driver may take the hint
            size = (GL_RGBA, width, height, 0)
            self._gl["glTexImage2D"](GL_TEXTURE_2D, 0, *size, *pixels, picture.ctypes.data)
            return
        self._gl["glTexSubImage2D"](GL_TEXTURE_2D, 0, 0, 0, width, height, *pixels, picture.ctypes.data)

    def draw(self, framebuffer: moderngl.Framebuffer, x_px: int, y_px: int) -> None:
        """Copies the picture into a framebuffer, its lower left corner to (x_px, y_px) from there."""
        assert self._kind is not None  # upload comes first
        (width, height), is_for_window = self._kind
        if self._source is None:
            self._source = self._ctx.framebuffer([self._texture])
        framebuffer.use()  # no scissors
        rows = (y_px + height, y_px) if is_for_window else (y_px, y_px + height)
        self._gl["glBindFramebuffer"](GL_READ_FRAMEBUFFER, self._source.glo)
        self._gl["glBindFramebuffer"](GL_DRAW_FRAMEBUFFER, framebuffer.glo)
        corners = (0, 0, width, height, x_px, rows[0], x_px + width, rows[1])
        self._gl["glBlitFramebuffer"](*corners, GL_COLOR_BUFFER_BIT, GL_NEAREST)
        framebuffer.use()

    def release(self) -> None:
        """Frees everything."""
        for thing in (self._source, self._texture):
            if thing is not None:
                thing.release()
        self._source = self._texture = self._kind = None

    def _remake(self, width: int, height: int, is_for_window: bool) -> None:
        self.release()
        self._texture = self._ctx.texture((width, height), 4)
        self._kind = ((width, height), is_for_window)
