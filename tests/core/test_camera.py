import numpy as np
import pytest

from wzviewer.core.camera import Camera


def deep(levels: int) -> Camera:
    camera = Camera.initial(1088, 720)
    for _ in range(levels):
        camera = camera.zoomed_to_region(0.55, 0.45, 8.0)
    return camera


@pytest.mark.parametrize("levels", [0, 3, 12])
def test_unproject_then_project_returns_the_pixel(levels):
    camera = deep(levels)
    point = camera.unproject(300.25, 500.5, 1.7)
    x, y, z = camera.project(point)
    # Measured 0 to level 3, 0.0005 px at level 12: a float64 world coordinate, magnified 8^12 times.
    assert abs(x - 300.25) < 0.02
    assert abs(y - 500.5) < 0.02
    assert z == pytest.approx(1.7, rel=1e-12)


def test_a_zoom_keeps_its_pixel_and_multiplies_the_focal_length():
    camera = Camera.initial(1088, 720)
    near = camera.zoomed(200.0, 100.0, 8.0)
    point = camera.unproject(200.0, 100.0, 2.0)
    assert near.project(point)[:2] == pytest.approx([200.0, 100.0], abs=1e-9)
    assert near.focal_px == pytest.approx(8 * 1024.0)


def test_a_child_image_is_an_exact_crop_of_its_parents():
    camera = Camera.initial(1088, 720)
    child = camera.zoomed_to_region(0.25, 0.75, 8.0)
    left_top = camera.unproject(0.25 * 1088 - 1088 / 16, 0.75 * 720 - 720 / 16, 3.0)
    assert child.project(left_top)[:2] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_pixel_scale_is_equation_1():
    camera = Camera(np.eye(4), 100.0, 400.0, 0, 0, 10, 10)
    assert camera.pixel_scale(3.0) == pytest.approx(3.0 / 200.0)


@pytest.mark.parametrize("size", [(544, 360), (500, 500), (64, 720)])
def test_resizing_keeps_what_is_in_the_middle_and_all_that_was_seen(size):
    camera = Camera.initial(1088, 720).zoomed_to_region(0.3, 0.6, 4.0)
    small = camera.resized(*size)
    for x, y in ((0, 0), (1088, 720), (544, 360)):
        u, v = small.project(camera.unproject(x, y, 1.0))[:2]
        assert -1e-6 <= u <= size[0] + 1e-6
        assert -1e-6 <= v <= size[1] + 1e-6
    assert small.project(camera.unproject(544, 360, 1.0))[:2] == pytest.approx([size[0] / 2, size[1] / 2])
