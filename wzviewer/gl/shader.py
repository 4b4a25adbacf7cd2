"""Programs from the files in ``wzviewer/shaders``.

``#include "name.glsl"`` (from ``include/``, each once) is resolved here, with a ``#line`` at every
boundary, so that a driver's message can be rewritten to ``file:line``.  The constants of
`core.constants` are injected as macros: Python and GLSL cannot disagree about them.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from importlib.resources.abc import Traversable

import moderngl

from wzviewer.core import anchor, constants, opacity
from wzviewer.errors import ContextError

Define = bool | int | float

INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')
STAGES = ("vertex_shader", "geometry_shader", "fragment_shader")
DRAWING, COMPUTING = "330 core", "430 core"  # versions of the language
# "0:12(5): error: ..." (Mesa), "0(12) : error ..." (NVIDIA), "ERROR: 0:12: ..." (others)
POSITIONS = (
    re.compile(r"^(\d+):(\d+)\(\d+\): "),
    re.compile(r"^(\d+)\((\d+)\) ?: "),
    re.compile(r"^(?:ERROR|WARNING): (\d+):(\d+): "),
)


class ShaderError(ContextError):
    """A shader that the driver does not accept; positions are ``file:line``."""


@dataclass(frozen=True)
class ShaderSource:
    """One stage, ready for the driver.

    Attributes:
        text: GLSL with the includes in place.
        files: names by source index of ``#line``.
    """

    text: str
    files: list[str] = field(default_factory=list)


def shared_constants() -> dict[str, Define]:
    """The macros that every shader sees."""
    names = ("ALPHA_CUT", "ALPHA_MAX", "LOW_PASS_PX2", "SURFEL_SIGMA_PX", "WEIGHT_MIN")
    shared: dict[str, Define] = {name: float(getattr(constants, name)) for name in names}
    return shared | {"DEPTH_FLOOR": anchor.DEPTH_FLOOR, "LOG_SPAN_MIN": opacity.LOG_SPAN_MIN}


def load_source(
    name: str,
    defines: Mapping[str, Define] | None = None,
    root: Traversable | None = None,
    version: str = DRAWING,
) -> ShaderSource:
    """Reads a shader file and resolves its includes.

    Args:
        name: file in the shaders folder.
        defines: further macros; True is a bare ``#define``, False is left out.
        root: folder instead of the package's own.
        version: of the language.
    """
    folder = files("wzviewer").joinpath("shaders") if root is None else root
    source = ShaderSource("", [])
    macros = shared_constants() | dict(defines or {})
    head = [f"#version {version}", *(_macro(k, v) for k, v in macros.items() if v is not False)]
    return ShaderSource("\n".join(head + _expand(folder, name, source.files)) + "\n", source.files)


def _macro(name: str, value: Define) -> str:
    return f"#define {name}" if value is True else f"#define {name} {value!r}"


def _expand(folder: Traversable, name: str, seen: list[str]) -> list[str]:
    index = len(seen)
    seen.append(name)
    lines = [f"#line 1 {index}"]
    for number, line in enumerate(folder.joinpath(*name.split("/")).read_text("utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if match is None:
            lines.append(line)
            continue
        target = f"include/{match[1]}"
        lines += _expand(folder, target, seen) if target not in seen else []
        lines.append(f"#line {number + 1} {index}")
    return lines


def load_program(
    ctx: moderngl.Context,
    vertex: str,
    fragment: str,
    geometry: str | None = None,
    defines: Mapping[str, Define] | None = None,
    root: Traversable | None = None,
) -> moderngl.Program:
    """Compiles a program from shader files.

    Args:
        ctx: `moderngl.Context`.
        vertex: file of the vertex stage.
        fragment: file of the fragment stage.
        geometry: file of the geometry stage, if there is one.
        defines: macros beside `shared_constants`.
        root: folder instead of the package's own.

    Returns:
        The `moderngl.Program`.

    Raises:
        ShaderError: with the driver's messages as ``file:line: text``.
    """
    names = dict(zip(STAGES, (vertex, geometry, fragment), strict=True))
    sources = {s: load_source(n, defines, root) for s, n in names.items() if n is not None}
    try:
        text = {stage: source.text for stage, source in sources.items()}
        return ctx.program(
            vertex_shader=text["vertex_shader"],
            geometry_shader=text.get("geometry_shader"),
            fragment_shader=text["fragment_shader"],
        )
    except moderngl.Error as error:
        raise _rewritten(str(error), sources) from None


def load_compute(
    ctx: moderngl.Context,
    name: str,
    defines: Mapping[str, Define] | None = None,
    root: Traversable | None = None,
) -> moderngl.ComputeShader:
    """Compiles a compute shader (OpenGL 4.3) from a file.

    Args:
        ctx: `moderngl.Context` of version 4.3 or more.
        name: file in the shaders folder.
        defines: macros beside `shared_constants`.
        root: folder instead of the package's own.

    Raises:
        ShaderError: with the driver's messages as ``file:line: text``.
    """
    source = load_source(name, defines, root, COMPUTING)
    try:
        return ctx.compute_shader(source.text)
    except moderngl.Error as error:
        raise _rewritten(str(error), {"compute_shader": source}) from None


def _rewritten(message: str, sources: Mapping[str, ShaderSource]) -> ShaderError:
    stage = next((s for s in sources if s in message), "")
    table = sources[stage].files if stage else [f for s in sources.values() for f in s.files]
    lines = [_place(line.strip(), table) for line in message.splitlines()]
    told = [
        line
        for line in lines
        if line and not line.startswith("=") and line not in (*STAGES, "compute_shader")
    ]
    # Drivers sometimes name the wrong source index, so the files are listed too.
    return ShaderError("shader", "; ".join(told), f"Files: {', '.join(table)}")


def _place(line: str, table: list[str]) -> str:
    for pattern in POSITIONS:
        if match := pattern.match(line):
            index = int(match[1])
            name = table[index] if index < len(table) else table[0]
            return f"{name}:{match[2]}: {line[match.end() :]}"
    return line
