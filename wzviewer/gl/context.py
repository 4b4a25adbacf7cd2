"""OpenGL contexts: the window's, EGL without a display, or GLFW's null platform with OSMesa.

============  ===============================================  ================================
kind          what it needs                                    when
============  ===============================================  ================================
``window``    a current GLFW context                           the desktop app
``egl``       libEGL (``libegl1``), a driver                   headless on Linux
``osmesa``    libOSMesa (``libosmesa6``), no driver at all     headless where EGL has no device
``auto``      the first of ``egl`` and ``osmesa`` that works   headless, wherever
============  ===============================================  ================================

On Windows and macOS ``egl`` and ``auto`` mean the system's own off-screen context.
"""

import contextlib
import ctypes
import ctypes.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Literal, Self

import moderngl

from wzviewer.errors import ContextError

ContextKind = Literal["egl", "osmesa", "window", "auto"]
GL_VERSION = 330
# Some drivers give exactly what is asked for, and with 4.3 the GPU orders surfels itself.
GL_VERSIONS = (GL_VERSION,) if sys.platform == "darwin" else (430, GL_VERSION)


@dataclass(frozen=True, eq=False)
class GlContext:
    """A live OpenGL context.

    Attributes:
        ctx: the `moderngl.Context`.
        kind: ``egl``, ``osmesa`` or ``window``.
        renderer_name: what the driver calls itself, such as ``llvmpipe (LLVM 15.0.6, 256 bits)``.
        load: gives the address of an OpenGL function by its name; None where that cannot be had.
    """

    ctx: Any
    kind: str
    renderer_name: str
    _close: Callable[[], None]
    load: Callable[[str], int] | None = None

    @property
    def is_software(self) -> bool:
        """Whether the driver rasterises on the CPU."""
        name = self.renderer_name.lower()
        return any(word in name for word in ("llvmpipe", "softpipe", "swiftshader", "software"))

    def close(self) -> None:
        """Releases the context (a window's own context stays with its window)."""
        self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def create_context(kind: ContextKind = "auto", device_index: int | None = None) -> GlContext:
    """Makes an OpenGL 3.3 core context, or adopts the window's.

    Args:
        kind: see the module docstring.
        device_index: EGL device, where there are several; None is the driver's first.

    Raises:
        ContextError: when none can be made; it names the system package that is missing.
    """
    makers: dict[str, Callable[[], GlContext]] = {
        "egl": lambda: _egl_context(device_index),
        "osmesa": _osmesa_context,
        "window": _window_context,
    }
    if kind != "auto":
        return makers[kind]()
    try:
        return makers["egl"]()
    except ContextError as egl_error:
        try:
            return makers["osmesa"]()
        except ContextError as osmesa_error:
            why = f"EGL: {egl_error.why}; OSMesa: {osmesa_error.why}"
            raise ContextError(
                "OpenGL", why, _install_hint("libegl1 libgl1-mesa-dri, or libosmesa6")
            ) from None


def _install_hint(packages: str) -> str:
    return f"Install {packages}" if sys.platform == "linux" else "Install a graphics driver with OpenGL 3.3"


def _adopt(
    ctx: moderngl.Context,
    kind: str,
    close: Callable[[], None],
    load: Callable[[str], int] | None = None,
) -> GlContext:
    return GlContext(ctx, kind, str(ctx.info["GL_RENDERER"]), close, load)


def _egl_context(device_index: int | None) -> GlContext:
    settings: dict[str, Any] = {}
    if sys.platform == "linux":
        settings = {"backend": "egl", "libgl": _library("GL"), "libegl": _library("EGL")}
        if device_index is not None:
            settings["device_index"] = device_index
    for version in GL_VERSIONS:
        try:
            ctx = moderngl.create_context(require=version, standalone=True, **settings)
        except Exception as error:  # glcontext raises bare Exception
            failure = error
            continue
        return _adopt(ctx, "egl", ctx.release, _egl_loader() if sys.platform == "linux" else None)
    raise ContextError("EGL", str(failure), _install_hint("libegl1 and libgl1-mesa-dri")) from failure


def _library(name: str) -> str:
    # Slim images have no ldconfig, so find_library fails; the sonames are stable.
    return ctypes.util.find_library(name) or f"lib{name}.so.1"


def _egl_loader() -> Callable[[str], int] | None:
    try:
        find = ctypes.CDLL(_library("EGL")).eglGetProcAddress
    except (OSError, AttributeError):
        return None
    find.restype, find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
    return lambda name: find(name.encode()) or 0


def _window_context() -> GlContext:
    try:
        ctx = moderngl.create_context(require=GL_VERSION)
    except Exception as error:
        hint = "Update the graphics driver, or render headless with --context egl"
        raise ContextError("window", str(error), hint) from error
    return _adopt(ctx, "window", lambda: None, _GlfwLoader(import_glfw(), None).load_opengl_function)


class _GlfwLoader:
    """Gives moderngl the functions of GLFW's current context."""

    def __init__(self, glfw: ModuleType, window: object) -> None:
        self.glfw, self.window = glfw, window

    def load_opengl_function(self, name: str) -> int:
        address = self.glfw.get_proc_address(name)
        return ctypes.cast(address, ctypes.c_void_p).value or 0

    def __enter__(self) -> "_GlfwLoader":
        self.glfw.make_context_current(self.window)
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def release(self) -> None:
        pass


def import_glfw() -> ModuleType:
    """Imports glfw after imgui_bundle, which ships the GLFW that both have to share."""
    with contextlib.suppress(ImportError):
        import imgui_bundle  # noqa: F401
    import glfw

    return glfw


def _osmesa_context() -> GlContext:
    glfw = import_glfw()
    hint = _install_hint("libosmesa6")
    try:
        window = _null_window(glfw)
    except Exception as error:
        raise ContextError("OSMesa", str(error), hint) from error
    if not window:
        glfw.terminate()
        raise ContextError("OSMesa", "no context (is libOSMesa there?)", hint)
    glfw.make_context_current(window)
    loader: Any = _GlfwLoader(glfw, window)
    ctx = moderngl.create_context(require=GL_VERSION, context=loader)

    def close() -> None:
        ctx.release()
        glfw.destroy_window(window)
        glfw.terminate()  # or the next window of this process would open on the null platform

    return _adopt(ctx, "osmesa", close)


def _null_window(glfw: ModuleType) -> object:
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
    if not glfw.init():
        return None
    glfw.default_window_hints()
    glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
    glfw.window_hint(glfw.CONTEXT_CREATION_API, glfw.OSMESA_CONTEXT_API)
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, GL_VERSION // 100)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, GL_VERSION // 10 % 10)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    return glfw.create_window(16, 16, "wzviewer", None, None)
