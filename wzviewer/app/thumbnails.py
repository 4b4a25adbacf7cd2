"""Small pictures of the levels, and the flat photo, as textures that imgui can show."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from wzviewer.app.recents import Recents
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.gl.context import GlContext

THUMBNAIL_PX = 384  # long side: twice what is shown, for dense screens


@dataclass(frozen=True, eq=False)
class Thumbnail:
    """A texture with its aspect.

    Attributes:
        ref: for imgui.
        aspect: width over height.
    """

    ref: imgui.ImTextureRef
    aspect: float


class Thumbnails:
    """Keeps a texture per picture and frees those that are no longer shown."""

    def __init__(self, context: GlContext) -> None:
        self._ctx = context.ctx
        self._kept: dict[object, tuple[ByteArray, Any, Thumbnail]] = {}

    def of_scene(self, scene: Scene) -> dict[int, Thumbnail]:
        """Returns a thumbnail for every level."""
        return {level.index: self._of(level.index, level.image, THUMBNAIL_PX) for level in scene}

    def of_photo(self, photo: ByteArray | None, key: str = "photo") -> Thumbnail | None:
        """Returns a photo (h, w, 3) uint8 at full size."""
        return self._of(key, photo, max(photo.shape)) if photo is not None else None

    def of_recents(self, recents: Recents) -> dict[Path, Thumbnail]:
        """Returns the pictures of recent files, as far as there are some."""
        pictures = {file.path: file.picture for file in recents.files}
        return {path: self._of(path, p, max(p.shape)) for path, p in pictures.items() if p is not None}

    def keep_only(self, keys: set[object]) -> None:
        """Frees the textures of other keys: level indices, paths, or names given to `of_photo`."""
        for key in [k for k in self._kept if k not in keys]:
            self._kept.pop(key)[1].release()

    def _of(self, key: object, image: ByteArray, long_side_px: int) -> Thumbnail:
        kept = self._kept.get(key)
        if kept is not None and kept[0] is image:
            return kept[2]
        if kept is not None:
            kept[1].release()
        small = shrunk(image, long_side_px)
        size = (small.shape[1], small.shape[0])
        texture = self._ctx.texture(size, 3, small.tobytes(), alignment=1)
        texture.repeat_x = texture.repeat_y = False
        thumbnail = Thumbnail(imgui.ImTextureRef(texture.glo), size[0] / size[1])
        self._kept[key] = (image, texture, thumbnail)
        return thumbnail

    def close(self) -> None:
        """Frees all textures."""
        self.keep_only(set())


def shrunk(image: ByteArray, long_side_px: int) -> ByteArray:
    """Returns an image (h, w, 3) uint8 averaged over whole blocks, its long side not below the limit."""
    factor = max(max(image.shape[:2]) // long_side_px, 1)
    height, width = (side // factor for side in image.shape[:2])
    whole = image[: height * factor, : width * factor]
    total = np.zeros((height, width, 3), np.uint32)
    for k in range(factor * factor):  # a tenth of the time of one mean over blocks, between two frames
        total += whole[k // factor :: factor, k % factor :: factor]
    return ((total + factor * factor // 2) // (factor * factor)).astype(np.uint8)
