"""A picture in tiles is the picture."""

import numpy as np
import pytest

from tests.app.fakes import make_scene
from wzviewer.core.camera import Camera
from wzviewer.gl.context import create_context
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.tiles import largest_tile_px, tiled, tiles


def test_tiles_cover_every_pixel_once_with_its_own_ray():
    camera = Camera.initial(100, 70).zoomed(10.0, 60.0, 3.0)
    count = np.zeros((70, 100), int)
    for (x, y, width, height), part in tiles(camera, 32):
        count[y : y + height, x : x + width] += 1
        assert (part.width, part.height) == (width, height)
        point = camera.unproject(x + 1.5, y + 2.5, 2.0)
        assert np.allclose(part.project(point)[:2], [1.5, 2.5])
    assert (count == 1).all()


@pytest.mark.gl
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_a_picture_in_tiles_is_the_picture(rasterizer):
    scene = make_scene(2)
    camera = scene[0].camera.zoomed(68.0, 45.0, 2.5).resized(200, 150)
    with create_context() as context:
        renderer = SurfelRenderer(context, rasterizer)
        renderer.sync(scene)
        for transparent in (False, True):
            whole = tiled(renderer, camera, RenderSettings(), transparent)
            parts = tiled(renderer, camera, RenderSettings(), transparent, side_px=64)
            assert whole.shape == (150, 200, 4 if transparent else 3)
            # Measured 1: float32 about another principal point.
            assert np.abs(whole.astype(int) - parts).max() <= 1
        assert largest_tile_px(renderer) >= 2048
        renderer.release()
