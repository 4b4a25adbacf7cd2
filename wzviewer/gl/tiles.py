"""Pictures larger than a texture may be: the same view through a grid of smaller cameras.

A tile's camera differs from the picture's in its principal point only, so that every pixel has the ray
that it has in the whole.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import ByteArray
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

TILE_PX = 4096  # a side; OpenGL 3.3 cards have 8192 and more, and a tile in float32 takes 256 MiB

Place = tuple[int, int, int, int]


def tiles(camera: Camera, side_px: int = TILE_PX) -> Iterator[tuple[Place, Camera]]:
    """Yields places (x, y, width, height) that cover a picture, each with its camera."""
    for y in range(0, camera.height, side_px):
        for x in range(0, camera.width, side_px):
            width, height = min(side_px, camera.width - x), min(side_px, camera.height - y)
            part = replace(camera, cx=camera.cx - x, cy=camera.cy - y, width=width, height=height)
            yield (x, y, width, height), part


def largest_tile_px(renderer: SurfelRenderer) -> int:
    """Returns the side of a tile that a renderer can draw."""
    return min(TILE_PX, int(renderer.context.ctx.info.get("GL_MAX_TEXTURE_SIZE", TILE_PX)))


def tiled(
    renderer: SurfelRenderer,
    camera: Camera,
    settings: RenderSettings,
    transparent: bool = False,
    side_px: int | None = None,
) -> ByteArray:
    """Renders a picture of any size.

    Args:
        renderer: of the scene.
        camera: the whole view.
        settings: how to draw.
        transparent: leave out the background.
        side_px: of a tile at most; None is what the renderer can draw.

    Returns:
        (h, w, 3) uint8 over the background, or (h, w, 4) with straight colours and coverage as alpha.
    """
    out = np.empty((camera.height, camera.width, 4 if transparent else 3), np.uint8)
    for (x, y, width, height), part in tiles(camera, side_px or largest_tile_px(renderer)):
        frame = renderer.render(part, settings)
        out[y : y + height, x : x + width] = frame.read_rgba8() if transparent else frame.read_color8()
    return out
