"""Textures that a frame is drawn into, remade when the size changes."""

import moderngl


class Target:
    """A framebuffer with colour textures of one format.

    Attributes:
        textures: one per attachment.
    """

    def __init__(self, ctx: moderngl.Context, components: int, dtype: str, attachments: int = 1) -> None:
        self.ctx = ctx
        self.textures: list[moderngl.Texture] = []
        self._framebuffer: moderngl.Framebuffer | None = None
        self._format = (components, dtype, attachments)

    @property
    def framebuffer(self) -> moderngl.Framebuffer:
        """Draws into the textures; there is one after `resize`."""
        assert self._framebuffer is not None  # resize comes first
        return self._framebuffer

    @property
    def texture(self) -> moderngl.Texture:
        """The first texture."""
        return self.textures[0]

    @property
    def num_bytes(self) -> int:
        """GPU memory held, bytes."""
        components, dtype, attachments = self._format
        if self._framebuffer is None:
            return 0
        width, height = self._framebuffer.size
        return int(width * height) * components * int(dtype[1]) * attachments

    def resize(self, width: int, height: int) -> moderngl.Framebuffer:
        """Makes the textures if the size (px, positive) differs; returns the framebuffer."""
        if self._framebuffer is not None and self._framebuffer.size == (width, height):
            return self._framebuffer
        self.release()
        components, dtype, attachments = self._format
        make = self.ctx.texture
        self.textures = [make((width, height), components, dtype=dtype) for _ in range(attachments)]
        for texture in self.textures:
            texture.repeat_x = texture.repeat_y = False
            if dtype[0] == "u":
                texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._framebuffer = self.ctx.framebuffer(self.textures)
        return self._framebuffer

    def release(self) -> None:
        """Frees the GPU memory."""
        if self._framebuffer is not None:
            self._framebuffer.release()
        for texture in self.textures:
            texture.release()
        self._framebuffer, self.textures = None, []
