from dataclasses import replace

import numpy as np
import pytest

from tests.gl.surfaces import add_surface, flat_scene, hill_scene
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

CORNERS = {(0, 0): (255, 0, 0), (0, -1): (0, 255, 0), (-1, 0): (0, 0, 255), (-1, -1): (255, 255, 0)}


@pytest.fixture
def frame(gl_context):
    """Four quarters of four colours: any flip shows."""
    scene, camera = Scene(), Camera.initial(16, 12)
    image = np.zeros((12, 16, 3), np.uint8)
    for (row, column), color in CORNERS.items():
        image[(slice(0, 6) if row == 0 else slice(6, 12)), (slice(0, 8) if column == 0 else slice(8, 16))] = (
            color
        )
    add_surface(scene, None, camera, 1.0, image)
    renderer = SurfelRenderer(gl_context)
    renderer.sync(scene)
    yield renderer.render(camera, RenderSettings(background=(0.2, 0.4, 0.6, 1.0)))
    renderer.release()


def test_rows_are_read_top_first(frame):
    color = frame.read_color8()
    for (row, column), expected in CORNERS.items():
        np.testing.assert_allclose(
            color[2 * row + (row == 0) * 2, 2 * column + (column == 0) * 2], expected, atol=8
        )


def test_a_window_gets_the_picture_upright(gl_context, frame):
    window = gl_context.ctx.simple_framebuffer((16, 12), 3)
    frame.present_to(window, smooth=False)
    bottom_first = np.frombuffer(window.read(components=3, alignment=1), np.uint8).reshape(12, 16, 3)
    np.testing.assert_array_equal(bottom_first[::-1], frame.read_color8())
    window.release()


def test_a_viewport_holds_the_picture(gl_context, frame):
    window = gl_context.ctx.simple_framebuffer((40, 30), 3)
    window.clear()
    frame.present_to(window, viewport=(10, 5, 16, 12), smooth=False)
    rows = np.frombuffer(window.read(components=3, alignment=1), np.uint8).reshape(30, 40, 3)[::-1]
    np.testing.assert_array_equal(rows[30 - 17 : 30 - 5, 10:26], frame.read_color8())
    rows = rows.copy()
    rows[30 - 17 : 30 - 5, 10:26] = 0
    assert (rows == 0).all()
    window.release()


def test_the_background_shows_where_nothing_is(gl_context):
    scene = hill_scene(num_levels=1)
    renderer = SurfelRenderer(gl_context)
    renderer.sync(scene)
    camera = scene[0].camera.zoomed(20.0, 14.0, 0.3)
    settings = RenderSettings(background=(0.2, 0.4, 0.6, 1.0), closed_coverage=1.0)
    frame = renderer.render(camera, settings)
    np.testing.assert_array_equal(frame.read_color8()[0, 0], [51, 102, 153])
    assert frame.read_rgba8()[0, 0, 3] == 0
    over = frame.read_color()[..., :3] + (1 - frame.read_coverage()[..., None]) * [0.2, 0.4, 0.6]
    np.testing.assert_allclose(frame.read_color8(), over * 255.0, atol=0.51)  # rounded once
    renderer.release()


def test_a_closed_surface_lets_no_background_through(gl_context):
    scene = flat_scene(48, 36, num_levels=1, color=128)
    renderer = SurfelRenderer(gl_context)
    renderer.sync(scene)
    camera = replace(scene[0].camera, cx=24.5, cy=18.5)  # pixel centres between surfels
    settings = RenderSettings(background=(1.0, 1.0, 1.0, 1.0))
    frame = renderer.render(camera, settings)
    assert 0.92 < frame.read_coverage()[18, 24] < 0.95  # measured 0.936
    inner = (slice(4, -4), slice(4, -4))
    assert np.abs(frame.read_color8()[inner].astype(int) - 128).max() <= 1
    assert (frame.read_rgba8()[inner][..., 3] == 255).all()
    as_rendered = renderer.render(camera, replace(settings, closed_coverage=1.0)).read_color8()
    assert as_rendered[18, 24, 0] > 134
    renderer.release()
