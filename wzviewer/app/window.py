"""The window and its headless stand-in; the only module that knows glfw.

Both give the frame loop the same things: a GL context, imgui's input, dropped files, and a
framebuffer.  imgui's native backends draw the panels, so no second GL binding is needed.
"""

import contextlib
import ctypes
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from imgui_bundle import imgui, implot  # before glfw: both must share the library that it ships

from wzviewer.app.keys import LETTERS, Modifiers, key_named
from wzviewer.app.theme import Fonts, apply_theme
from wzviewer.core.types import ByteArray
from wzviewer.errors import ContextError
from wzviewer.gl.context import GL_VERSIONS, GlContext, create_context, import_glfw

TITLE = "wzviewer"
START_SIZE = (1280, 800)  # points
GLSL = "#version 330"
LONGEST_STEP_S = 0.1  # after a stall a motion goes on; it does not jump


@dataclass(frozen=True)
class Pulse:
    """What happened since the last frame.

    Attributes:
        dt_s: what motions go on by, s: the time since then, but at most `LONGEST_STEP_S`.
        dropped: files dropped on the window.
        wants_close: whether its close button was pressed.
        stalled_s: what the time since then was longer, s.
        dropped_at_px: where on the window, framebuffer px; None where that is not known.
    """

    dt_s: float
    dropped: tuple[Path, ...] = ()
    wants_close: bool = False
    stalled_s: float = 0.0
    dropped_at_px: tuple[float, float] | None = None


class Window(Protocol):
    """What the loop needs of a window."""

    context: GlContext
    fonts: Fonts
    scale: float  # imgui units per point

    @property
    def letters(self) -> str:
        """What is printed on the keyboard at the places of W A S D Q E."""
        ...

    @property
    def modifiers(self) -> Modifiers:
        """What was held at the last press of each key; imgui knows only what is held in a frame."""
        ...

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the framebuffer, px; 0 while minimised."""
        ...

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in the units that a window is opened with."""
        ...

    @property
    def is_lost(self) -> bool:
        """Whether the graphics card was reset: all that OpenGL held is gone."""
        ...

    def begin(self, wait_s: float) -> Pulse:
        """Waits at most so long for input, and begins an imgui frame."""
        ...

    def draw(self, paint: Callable[[Any], None]) -> None:
        """Lets ``paint(framebuffer)`` fill the framebuffer, then draws the panels over it."""

    def read_pixels(self) -> ByteArray:
        """Returns what was drawn, (h, w, 3) uint8."""
        ...

    def show(self) -> None:
        """Brings the frame to the screen."""

    def set_title(self, title: str) -> None:
        """Names the window."""

    def close(self) -> None:
        """Frees everything."""


def _new_imgui() -> imgui.IO:
    imgui.create_context()
    implot.create_context()
    io = imgui.get_io()
    io.set_ini_filename("")  # the layout is computed: there is nothing to remember
    io.config_flags |= imgui.ConfigFlags_.no_mouse_cursor_change.value
    io.config_error_recovery_enable_tooltip = False
    return io


def _draw_panels() -> None:
    imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())


def _read(framebuffer: Any, size_px: tuple[int, int]) -> ByteArray:  # noqa: ANN401 - a moderngl object
    data = framebuffer.read(viewport=(0, 0, *size_px), components=3, alignment=1)
    return np.ascontiguousarray(np.frombuffer(data, np.uint8).reshape(size_px[1], size_px[0], 3)[::-1])


def _reset_status_of(context: GlContext) -> Callable[[], int] | None:
    """Returns the function of OpenGL that tells of a reset (0: none), or None where there is none."""
    if context.load is None:
        return None
    names = ("glGetGraphicsResetStatus", "glGetGraphicsResetStatusARB", "glGetGraphicsResetStatusKHR")
    address = next((a for name in names if (a := context.load(name))), 0)
    prototype = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)
    return prototype(ctypes.c_uint)(address) if address else None


def _is_cursor_told(glfw: Any) -> bool:  # noqa: ANN401 - the module
    """Whether glfw follows the cursor while a file is dragged: on Wayland it does not."""
    platform = getattr(glfw, "get_platform", None)
    return platform is None or platform() != getattr(glfw, "PLATFORM_WAYLAND", None)


class OffscreenWindow:
    """No window at all: EGL, a texture, and imgui's input only as a test pushes it.

    Args:
        size_px: width and height.
        step_s: time that a frame stands for, so that runs repeat exactly.
        scale: imgui units per point, as on a dense screen.
    """

    def __init__(
        self, size_px: tuple[int, int] = START_SIZE, step_s: float = 1 / 60, scale: float = 1.0
    ) -> None:
        self.context = create_context("egl")
        self.scale, self._step_s, self.is_lost = scale, step_s, False
        self._dropped: tuple[Path, ...] = ()
        self._dropped_at_px: tuple[float, float] | None = None
        self._size_px = size_px
        self._framebuffer = self.context.ctx.simple_framebuffer(size_px, 3)
        self._io = _new_imgui()
        self.fonts = apply_theme(scale)
        imgui.backends.opengl3_init(GLSL)

    @property
    def letters(self) -> str:
        """There is no keyboard: the American one."""
        return LETTERS

    @property
    def modifiers(self) -> Modifiers:
        """There is no keyboard."""
        return {}

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the framebuffer, px."""
        return self._size_px

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self._size_px

    def resize(self, width: int, height: int) -> None:
        """Takes another size, px."""
        self._framebuffer.release()
        self._size_px = (width, height)
        self._framebuffer = self.context.ctx.simple_framebuffer(self._size_px, 3)

    def drop(self, *paths: Path, at_px: tuple[float, float] | None = None) -> None:
        """Drops files on the window, as a hand would."""
        self._dropped += paths
        self._dropped_at_px = at_px

    def begin(self, wait_s: float) -> Pulse:
        """Begins an imgui frame."""
        self._io.display_size = imgui.ImVec2(*map(float, self._size_px))
        self._io.delta_time = self._step_s
        imgui.backends.opengl3_new_frame()
        imgui.new_frame()
        dropped, self._dropped = self._dropped, ()
        return Pulse(self._step_s, dropped, dropped_at_px=self._dropped_at_px)

    def draw(self, paint: Callable[[Any], None]) -> None:
        """Lets ``paint(framebuffer)`` fill the framebuffer, then draws the panels over it."""
        self._framebuffer.use()
        paint(self._framebuffer)
        imgui.render()
        self._framebuffer.use()
        _draw_panels()

    def read_pixels(self) -> ByteArray:
        """Returns what was drawn, (h, w, 3) uint8."""
        return _read(self._framebuffer, self._size_px)

    def show(self) -> None:
        """There is no screen."""

    def set_title(self, title: str) -> None:
        """There is no title."""

    def close(self) -> None:
        """Frees everything."""
        imgui.backends.opengl3_shutdown()
        implot.destroy_context()
        imgui.destroy_context()
        self._framebuffer.release()
        self.context.close()


class GlfwWindow:
    """A window of the desktop.

    Raises:
        ContextError: when there is no display or no OpenGL 3.3.
    """

    def __init__(self, size: tuple[int, int] = START_SIZE) -> None:
        self._glfw = import_glfw()
        with warnings.catch_warnings():  # what glfw warns of is said by the errors below
            warnings.simplefilter("ignore")
            self._window = self._open(size)
        self.context = create_context("window")
        self._screen = self.context.ctx.screen
        self._reset_status = _reset_status_of(self.context)
        self._dropped: list[Path] = []
        self._dropped_at_px: tuple[float, float] | None = None
        self._io = _new_imgui()
        self.scale = self._imgui_scale()
        self.fonts = apply_theme(self.scale)
        self._modifiers: dict[imgui.Key, tuple[bool, bool]] = {}
        self._fresh: set[imgui.Key] = set()  # pressed since the last frame
        self._glfw.set_drop_callback(self._window, self._on_drop)
        self._glfw.set_key_callback(self._window, self._on_key)  # before imgui's, which calls it
        address = ctypes.cast(self._window, ctypes.c_void_p).value
        assert address is not None  # a window that is open has one
        imgui.backends.glfw_init_for_opengl(address, True)
        imgui.backends.opengl3_init(GLSL)
        self._last_s = time.perf_counter()

    def _open(self, size: tuple[int, int]) -> Any:  # noqa: ANN401 - a ctypes pointer
        glfw = self._glfw
        with contextlib.suppress(AttributeError):  # a null platform chosen before must not linger
            glfw.init_hint(glfw.PLATFORM, glfw.ANY_PLATFORM)
        hint = "Run it on a desktop, or use 'wzviewer render' and 'wzviewer generate' without one"
        if not glfw.init():
            raise ContextError("window", "there is no display", hint)
        glfw.default_window_hints()
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, glfw.TRUE)  # macOS gives 3.3 on no other terms
        glfw.window_hint(glfw.SCALE_TO_MONITOR, glfw.TRUE)
        window = None
        # A driver that does not tell of resets is asked for every version once more.
        for robustness in (glfw.LOSE_CONTEXT_ON_RESET, glfw.NO_ROBUSTNESS):
            glfw.window_hint(glfw.CONTEXT_ROBUSTNESS, robustness)
            for version in GL_VERSIONS:
                glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, version // 100)
                glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, version // 10 % 10)
                window = window or glfw.create_window(*size, TITLE, None, None)
        if not window:
            glfw.terminate()
            raise ContextError("window", "no OpenGL 3.3", "Update the graphics driver")
        glfw.make_context_current(window)
        glfw.swap_interval(1)
        glfw.set_window_size_limits(window, 480, 360, glfw.DONT_CARE, glfw.DONT_CARE)
        return window

    def _imgui_scale(self) -> float:
        """Points of a dense screen: imgui counts in window units, which macOS already scales."""
        content = self._glfw.get_window_content_scale(self._window)[0]
        window_width = max(self._glfw.get_window_size(self._window)[0], 1)
        framebuffer = self._glfw.get_framebuffer_size(self._window)[0] / window_width
        return float(max(content / max(framebuffer, 1e-3), 1.0))

    def _on_drop(self, window: object, paths: list[str]) -> None:
        self._dropped += [Path(p) for p in paths]
        (x, y), (width, height) = self._glfw.get_cursor_pos(self._window), self.size
        is_told = _is_cursor_told(self._glfw) and 0 <= x < width and 0 <= y < height
        ratio = (self.size_px[0] / max(width, 1), self.size_px[1] / max(height, 1))
        self._dropped_at_px = (x * ratio[0], y * ratio[1]) if is_told else None

    def _on_key(self, window: object, place: int, scancode: int, action: int, held: int) -> None:
        """A frame may be long: Ctrl can be let go in the same one in which the key was pressed.

        imgui takes one change of a key a frame: with the key let go first, Ctrl is held until the next.
        """
        glfw = self._glfw
        modifiers = (glfw.KEY_LEFT_CONTROL, glfw.KEY_RIGHT_CONTROL, glfw.KEY_LEFT_SUPER, glfw.KEY_RIGHT_SUPER)
        if place in modifiers:
            for key in self._fresh if action == glfw.RELEASE else ():
                imgui.get_io().add_key_event(key, False)
            return
        name = key_named(glfw.get_key_name(place, scancode) or "")
        if name is not None and action == glfw.PRESS:
            ctrl = glfw.MOD_SUPER if sys.platform == "darwin" else glfw.MOD_CONTROL
            self._modifiers[name] = (bool(held & ctrl), bool(held & glfw.MOD_SHIFT))
            self._fresh.add(name)

    @property
    def is_lost(self) -> bool:
        """Whether the graphics card was reset: all that OpenGL held is gone."""
        return self._reset_status is not None and self._reset_status() != 0

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in the units that a window is opened with."""
        width, height = self._glfw.get_window_size(self._window)
        return int(width), int(height)

    @property
    def modifiers(self) -> Modifiers:
        """What was held at the last press of each key."""
        return self._modifiers

    @property
    def letters(self) -> str:
        """What is printed at the places of W A S D Q E: glfw names keys by place, imgui by letter."""
        places = (getattr(self._glfw, f"KEY_{letter.upper()}") for letter in LETTERS)
        names = [self._glfw.get_key_name(place, 0) or "" for place in places]
        pairs = zip(names, LETTERS, strict=True)
        return "".join(name.lower() if len(name) == 1 and name.isascii() else usual for name, usual in pairs)

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the framebuffer, px; 0 while minimised."""
        width, height = self._glfw.get_framebuffer_size(self._window)
        return int(width), int(height)

    def begin(self, wait_s: float) -> Pulse:
        """Waits at most so long for input, and begins an imgui frame.

        Of keys that came at once imgui takes one a frame; while some wait, so does nobody else.
        """
        self._fresh.clear()
        if wait_s > 0 and not imgui.get_current_context().input_events_queue.size():
            self._glfw.wait_events_timeout(wait_s)
        else:
            self._glfw.poll_events()
        now_s = time.perf_counter()
        passed_s, self._last_s = now_s - self._last_s, now_s
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()
        dropped, self._dropped = tuple(self._dropped), []
        wants_close = bool(self._glfw.window_should_close(self._window))
        self._glfw.set_window_should_close(self._window, False)  # the app decides: it may ask first
        dt_s = min(passed_s, LONGEST_STEP_S)
        return Pulse(dt_s, dropped, wants_close, passed_s - dt_s, self._dropped_at_px)

    def draw(self, paint: Callable[[Any], None]) -> None:
        """Lets ``paint(framebuffer)`` fill the framebuffer, then draws the panels over it."""
        self._screen.viewport = (0, 0, *self.size_px)
        self._screen.use()
        paint(self._screen)
        imgui.render()
        self._screen.use()
        _draw_panels()

    def read_pixels(self) -> ByteArray:
        """Returns what was drawn, (h, w, 3) uint8."""
        return _read(self._screen, self.size_px)

    def show(self) -> None:
        """Brings the frame to the screen."""
        self._glfw.swap_buffers(self._window)

    def set_title(self, title: str) -> None:
        """Names the window."""
        self._glfw.set_window_title(self._window, title)

    def close(self) -> None:
        """Frees everything."""
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        implot.destroy_context()
        imgui.destroy_context()
        self.context.close()
        self._glfw.destroy_window(self._window)
        self._glfw.terminate()
