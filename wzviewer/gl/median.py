"""Median depth on the GPU: the rank of the surfel at which transmittance crosses 1/2, per pixel.

The transmittance in front of rank r falls with r, so r is found by search: a pass multiplies
(1 - alpha) into 16 candidate prefixes at once (4 targets of 4 channels), and a full-screen step
keeps the last one that lets more than half through.  Each pass fixes 4 bits of the rank: five passes
for a million surfels.  Multiplication commutes, so the passes need no order, and the result is exact.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import moderngl
import numpy as np

from wzviewer.gl.draw import Segment, SurfelDraw, Variant
from wzviewer.gl.order import UIntArray
from wzviewer.gl.shader import load_program
from wzviewer.gl.targets import Target

CANDIDATES = 16


class MedianPass:
    """The search for the median rank."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self._factors = Target(ctx, 4, "f4", attachments=4)
        self._low = [Target(ctx, 1, "u4") for _ in range(2)]
        self._step = load_program(ctx, "present.vert", "median_step.frag")
        self._array = ctx.vertex_array(self._step, [])

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return self._factors.num_bytes + sum(low.num_bytes for low in self._low)

    def ranks(
        self,
        draw: SurfelDraw,
        variant: Variant,
        size_px: tuple[int, int],
        num_ranks: int,
        records: moderngl.Buffer,
        textures: Mapping[str, moderngl.Texture],
        segments: Sequence[Segment],
    ) -> UIntArray:
        """Searches the order that `draw` holds (with its ranks set).

        Args:
            draw: holds the order and the ranks.
            variant: of the frame; the ranked one of it is used.
            size_px: (width, height).
            num_ranks: surfels in the order.
            records: the surfel buffer.
            textures: by sampler name.
            segments: of the order.

        Returns:
            (h, w) uint32; ``num_ranks`` or more where the transmittance stays above 1/2.
        """
        for target in (self._factors, *self._low):
            target.resize(*size_px)
        self._low[0].framebuffer.clear()
        num_passes = max(1, int(np.ceil(np.log2(num_ranks + 1) / 4 - 1e-9)))
        for place in reversed(range(num_passes)):
            step = CANDIDATES**place
            self._multiply(draw, replace(variant, ranked=True), records, textures, step, segments)
            self._narrow(step)
        data = self._low[0].texture.read(alignment=1)
        return np.frombuffer(data, np.uint32).reshape(size_px[1], size_px[0])

    def release(self) -> None:
        """Frees everything."""
        for target in (self._factors, *self._low):
            target.release()
        self._array.release()
        self._step.release()

    def _multiply(
        self,
        draw: SurfelDraw,
        variant: Variant,
        records: moderngl.Buffer,
        textures: Mapping[str, moderngl.Texture],
        step: int,
        segments: Sequence[Segment],
    ) -> None:
        target = self._factors.framebuffer
        target.clear(1.0, 1.0, 1.0, 1.0)
        self.ctx.enable_only(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        self.ctx.blend_func = (moderngl.ZERO, moderngl.SRC_COLOR)
        sources = {**textures, "t_low": self._low[0].texture}
        draw.draw(variant, target, records, sources, {"u_step": step}, segments)

    def _narrow(self, step: int) -> None:
        self.ctx.enable_only(moderngl.NOTHING)
        sources = {"t_low": self._low[0].texture}
        sources |= {f"t_t{k}": texture for k, texture in enumerate(self._factors.textures)}
        for unit, (name, texture) in enumerate(sources.items()):
            texture.use(unit)
            self._step[name] = unit
        self._step["u_step"] = step
        self._low[1].framebuffer.use()
        self._array.render(moderngl.TRIANGLES, vertices=3)
        self._low.reverse()
