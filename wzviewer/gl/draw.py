"""One draw of an ordered set of surfels, as points or as quads.

Points with an element index are the fast way: no vertex is made on the CPU, and a culled surfel
costs almost nothing.  But GL clips a point by its centre, so the viewport is wider than the image by
the largest radius, and drivers limit point sizes, so a frame with larger footprints goes through a
geometry shader that makes quads.  Both run the same fragment shader over the same exact order.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import moderngl
import numpy as np

from wzviewer.gl.compute import GpuOrder
from wzviewer.gl.order import UIntArray
from wzviewer.gl.records import INT16_STEPS, RECORD_ATTRIBUTES, RECORD_FORMAT
from wzviewer.gl.shader import load_program

POINT_LIMIT_PX = 512.0  # a wider guard band would only draw more that is clipped
POINT_SLACK_PX = 0.05  # added to a point's size: rasterisers snap it to 1/16 or 1/256 px


@dataclass(frozen=True)
class Variant:
    """A compiled variant of the surfel program; each field is a macro.

    Attributes:
        quads: a geometry shader makes quads.
        linear_blend: a' = a w.
        unit_weight: w = 1.
        ranked: the search for the median instead of colour.
    """

    quads: bool = False
    linear_blend: bool = False
    unit_weight: bool = False
    ranked: bool = False

    def defines(self) -> dict[str, bool]:
        """Returns the macros of the shaders."""
        return {f.name.upper(): bool(getattr(self, f.name)) for f in fields(self)}


@dataclass(frozen=True)
class Segment:
    """Consecutive places of the uploaded order, farthest first, with one kind of footprint."""

    first: int
    count: int
    quads: bool


class SurfelDraw:
    """Programs, the element index and the vertex arrays.

    Attributes:
        point_limit_px: largest point that the driver draws.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self.point_limit_px = min(float(ctx.info["GL_POINT_SIZE_RANGE"][1]), POINT_LIMIT_PX)
        self._programs: dict[Variant, moderngl.Program] = {}
        self._arrays: dict[Variant, tuple[moderngl.VertexArray, moderngl.Buffer, moderngl.Buffer]] = {}
        self._index: moderngl.Buffer | None = None
        self._ranks: moderngl.Buffer | None = None
        self._count = 0

    @property
    def num_bytes(self) -> int:
        """GPU memory of the element index, bytes."""
        return sum(b.size for b in (self._index, self._ranks) if b is not None)

    def set_order(self, front_to_back: UIntArray) -> None:
        """Uploads the order of the next draws, record numbers nearest first."""
        self._count = len(front_to_back)
        needed = 4 * max(self._count, 1)
        if self._index is None or self._index.size < needed:
            self._release_arrays()
            self._index = _replaced(self.ctx, self._index, needed * 5 // 4 // 4 * 4)
        self._index.orphan()
        self._index.write(front_to_back[::-1].tobytes())

    def set_ranks(self, front_to_back: UIntArray, num_records: int) -> None:
        """Uploads the rank of every record, for the `ranked` variants."""
        ranks = np.zeros(num_records, np.uint32)
        ranks[front_to_back] = np.arange(len(front_to_back), dtype=np.uint32)
        self._release_arrays()
        if self._ranks is not None:
            self._ranks.release()
        self._ranks = self.ctx.buffer(ranks.tobytes())

    def draw(
        self,
        variant: Variant,
        framebuffer: moderngl.Framebuffer,
        records: moderngl.Buffer,
        textures: Mapping[str, moderngl.Texture],
        uniforms: Mapping[str, Any],
        segments: Sequence[Segment],
    ) -> None:
        """Draws the uploaded order, farthest first, with the blend state of the caller.

        Args:
            variant: of the program.
            framebuffer: target; its rows are image rows, top first.
            records: the surfel buffer.
            textures: by sampler name.
            uniforms: further uniforms by name.
            segments: of the order, one after the other.
        """
        assert self._index is not None  # set_order comes first
        values = {**_bound(textures), **uniforms}
        for segment in segments:
            chosen = replace(variant, quads=segment.quads)
            array = self._begin(chosen, framebuffer, records, self._index, values)
            array.render(moderngl.POINTS, vertices=segment.count, first=segment.first)
        framebuffer.viewport = (0, 0, *framebuffer.size)

    def draw_indirect(
        self,
        variant: Variant,
        framebuffer: moderngl.Framebuffer,
        records: moderngl.Buffer,
        textures: Mapping[str, moderngl.Texture],
        uniforms: Mapping[str, Any],
        order: GpuOrder,
    ) -> None:
        """Draws an order that the GPU has made; arguments as of `draw`."""
        values = {**_bound(textures), **uniforms}
        array = self._begin(variant, framebuffer, records, order.index, values)
        array.render_indirect(order.indirect, moderngl.POINTS, 1)
        framebuffer.viewport = (0, 0, *framebuffer.size)

    def release(self) -> None:
        """Frees everything."""
        self._release_arrays()
        for thing in (*self._programs.values(), self._index, self._ranks):
            if thing is not None:
                thing.release()
        self._programs, self._index, self._ranks, self._count = {}, None, None, 0

    def _program(self, variant: Variant) -> moderngl.Program:
        if variant not in self._programs:
            self._programs[variant] = load_program(
                self.ctx,
                "surfel.vert",
                "median.frag" if variant.ranked else "surfel.frag",
                geometry="surfel.geom" if variant.quads else None,
                defines={**variant.defines(), "INT16_STEPS": INT16_STEPS, "POINT_SLACK_PX": POINT_SLACK_PX},
            )
        return self._programs[variant]

    def _begin(
        self,
        variant: Variant,
        framebuffer: moderngl.Framebuffer,
        records: moderngl.Buffer,
        index: moderngl.Buffer,
        values: Mapping[str, Any],
    ) -> moderngl.VertexArray:
        """Sets the program and the viewport of a variant; returns what is to be rendered."""
        program = self._program(variant)
        guard = 0 if variant.quads else int(np.ceil(self.point_limit_px / 2))
        width, height = framebuffer.size
        _set(program, {"u_size_px": (width, height), "u_guard_px": float(guard), **values})
        framebuffer.viewport = (-guard, -guard, width + 2 * guard, height + 2 * guard)
        framebuffer.use()
        return self._array(variant, program, records, index)

    def _array(
        self, variant: Variant, program: moderngl.Program, records: moderngl.Buffer, index: moderngl.Buffer
    ) -> moderngl.VertexArray:
        if made := self._arrays.get(variant):
            if made[1] is records and made[2] is index:
                return made[0]
            made[0].release()
        content: list[tuple[Any, ...]] = [(records, RECORD_FORMAT, *RECORD_ATTRIBUTES)]
        if variant.ranked:
            content.append((self._ranks, "1u4", "in_rank"))
        array = self.ctx.vertex_array(program, content, index, 4, skip_errors=True)
        self._arrays[variant] = (array, records, index)
        return array

    def _release_arrays(self) -> None:
        for array, _, _ in self._arrays.values():
            array.release()
        self._arrays = {}


def _replaced(ctx: moderngl.Context, buffer: moderngl.Buffer | None, size: int) -> moderngl.Buffer:
    if buffer is not None:
        buffer.release()
    return ctx.buffer(reserve=size, dynamic=True)


def _bound(textures: Mapping[str, moderngl.Texture]) -> dict[str, int]:
    """Binds textures to units; returns the values of their samplers."""
    for unit, texture in enumerate(textures.values()):
        texture.use(unit)
    return {name: unit for unit, name in enumerate(textures)}


def _set(program: moderngl.Program, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        if name in program:  # a variant without the weight has no use for some
            program[name] = value
