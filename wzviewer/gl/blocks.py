"""What the vertex shader knows of each level: one row of RGBA32F texels per level slot.

=========  =========================================================================
texel      content
=========  =========================================================================
0, 1, 2    `AnchoredView.rows` of the rendering camera (written every frame)
3          ``(g, base)`` of the parent's camera
4          number of covers, 1 where there is a parent, side of the anchor (+1 | -1), 0
5 + 5 k    cover k: the three rows of its camera, its parent's row, (width, height, feather, side)
=========  =========================================================================

A texture rather than a uniform block: the number of covers of a level has no bound (a parent with a
hundred children, or siblings that overlap), and the texture grows with it.
"""

from collections.abc import Mapping

import moderngl
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.opacity import Modulation

VIEW_TEXELS, HEAD_TEXELS, COVER_TEXELS = 3, 5, 5
WIDTH_STEP = 64 * COVER_TEXELS  # texels by which the texture widens: room for 64 covers


class BlockTexture:
    """The texture of level rows.

    Attributes:
        texture: `moderngl.Texture`, RGBA32F, one row per slot, or None before the first `write`.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self.texture: moderngl.Texture | None = None
        self._texels = np.zeros((0, 0, 4), np.float32)

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return self._texels.nbytes

    def set_modulations(self, modulations: Mapping[int, Modulation]) -> None:
        """Replaces the rows of parents and covers, by slot."""
        packed = {slot: m.texels() for slot, m in modulations.items()}
        widest = max((len(texels) for texels in packed.values()), default=2) - 2
        width = HEAD_TEXELS + max(-(-widest // WIDTH_STEP), 1) * WIDTH_STEP
        height = max(packed, default=0) + 1
        texels = np.zeros((height, width, 4), np.float32)
        for slot, rows in packed.items():
            texels[slot, VIEW_TEXELS : VIEW_TEXELS + len(rows)] = rows
        texture = self._resized(width, height)
        self._texels = texels
        texture.write(texels.tobytes())

    def set_views(self, views: Mapping[int, AnchoredView]) -> None:
        """Replaces the rows of the rendering camera, by slot."""
        if self.texture is None:
            return
        for slot, view in views.items():
            self._texels[slot, :VIEW_TEXELS] = view.rows
            self._texels[slot, HEAD_TEXELS - 1, 2] = view.side
        head = np.ascontiguousarray(self._texels[:, :HEAD_TEXELS])
        self.texture.write(head.tobytes(), viewport=(0, 0, HEAD_TEXELS, len(head)))

    def release(self) -> None:
        """Frees the GPU memory."""
        if self.texture is not None:
            self.texture.release()
        self.texture, self._texels = None, np.zeros((0, 0, 4), np.float32)

    def _resized(self, width: int, height: int) -> moderngl.Texture:
        if self.texture is not None and self.texture.size == (width, height):
            return self.texture
        self.release()
        self.texture = self.ctx.texture((width, height), 4, dtype="f4", alignment=1)
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return self.texture
