"""What the vertex shader knows of each level: one row of RGBA32F texels per level slot.

=========  =========================================================================
texel      content
=========  =========================================================================
0, 1, 2    `AnchoredView.rows` of the rendering camera (written every frame)
3          ``(g, base)`` of the parent's camera
4          number of covers, 1 where there is a parent, side of the anchor (+1 | -1), cell
5 + 5 k    cover k: the three rows of its camera, its parent's row, (width, height, feather, side)
=========  =========================================================================

A texture rather than a uniform block: the number of covers of a level has no bound (a parent with a
hundred children, or siblings that overlap), and the texture grows with it.
"""

from collections.abc import Mapping
from operator import is_

import moderngl
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.opacity import Cover, Modulation
from wzviewer.core.types import DoubleArray

VIEW_TEXELS, HEAD_TEXELS, COVER_TEXELS = 3, 5, 5
WIDTH_STEP = 64 * COVER_TEXELS  # texels by which the texture widens: room for 64 covers


_Row = tuple[DoubleArray | None, tuple[Cover, ...], float]
_Held = dict[int, _Row]


def _same(one: _Held, other: _Held) -> bool:
    """Whether two frames have the very same parents and covers."""
    return one.keys() == other.keys() and all(_identical(one[slot], other[slot]) for slot in one)


def _identical(one: _Row, other: _Row) -> bool:
    same_covers = len(one[1]) == len(other[1]) and all(map(is_, one[1], other[1]))
    return one[0] is other[0] and same_covers and one[2] == other[2]


class BlockTexture:
    """The texture of level rows.

    Attributes:
        texture: `moderngl.Texture`, RGBA32F, one row per slot, or None before the first `write`.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        self.ctx = ctx
        self.texture: moderngl.Texture | None = None
        self._texels = np.zeros((0, 0, 4), np.float32)
        self._held: _Held = {}

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        return self._texels.nbytes

    def write(self, views: Mapping[int, AnchoredView], modulations: Mapping[int, Modulation]) -> None:
        """Writes the rows of a frame, by slot; covers only where they differ from the last frame's.

        Args:
            views: the rendering camera about each level's anchor.
            modulations: parent and covers of the same levels.
        """
        held = {slot: (m.parent_rows, m.covers, m.cell_px) for slot, m in modulations.items()}
        if self.texture is None or not _same(held, self._held):
            self._set_modulations(modulations)
            self._held = held
        self._set_views(views)

    def _set_modulations(self, modulations: Mapping[int, Modulation]) -> None:
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

    def _set_views(self, views: Mapping[int, AnchoredView]) -> None:
        assert self.texture is not None  # made by _set_modulations
        for slot, view in views.items():
            self._texels[slot, :VIEW_TEXELS] = view.rows
            self._texels[slot, HEAD_TEXELS - 1, 2] = view.side
        head = np.ascontiguousarray(self._texels[:, :HEAD_TEXELS])
        self.texture.write(head.tobytes(), viewport=(0, 0, HEAD_TEXELS, len(head)))

    def release(self) -> None:
        """Frees the GPU memory."""
        if self.texture is not None:
            self.texture.release()
        self.texture, self._texels, self._held = None, np.zeros((0, 0, 4), np.float32), {}

    def _resized(self, width: int, height: int) -> moderngl.Texture:
        if self.texture is not None and self.texture.size == (width, height):
            return self.texture
        self.release()
        self.texture = self.ctx.texture((width, height), 4, dtype="f4", alignment=1)
        self.texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return self.texture
