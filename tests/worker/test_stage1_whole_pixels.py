"""A zoom that begins inside a pixel of its parent still shows, shrunk, the parent's own pixels."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.worker.test_synthesis import Quiet
from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.detail.consistency import psnr_db
from wzviewer.worker.models.registry import load_synthesizer
from wzviewer.worker.photograph import sharpened, with_photo
from wzviewer.worker.stages.stage1_new_scale_image import observe, preview_image, upscale_image
from wzviewer.worker.stages.stage1_whole_pixels import (
    cut,
    is_zoom,
    on_whole_pixels,
    spread_over,
    whole_pixels,
)
from wzviewer.worker.synthesis import reconstruct_scene

PARENT = Camera.initial(96, 64)


@pytest.fixture(scope="module")
def models():
    return load_synthesizer("builtin")


@pytest.fixture(scope="module")
def root(models):
    """E_0 of contours as sharp as pixels can show."""
    return reconstruct_scene(stones(1), 0, models, Quiet())


def stones(finer):
    """A wall of light and dark stones, (64 finer, 96 finer, 3) uint8: the same in any size."""
    tones = np.random.default_rng(3).integers(40, 216, (16, 24, 3))
    large = cv2.resize(tones.astype(np.uint8), (96 * 8, 64 * 8), interpolation=cv2.INTER_NEAREST)
    size = (round(96 * finer), round(64 * finer))
    return cv2.resize(cv2.GaussianBlur(large, (0, 0), 2.0), size, interpolation=cv2.INTER_AREA)


def whole_footprints(image, camera, parent):
    """The image's means over the parent's pixels that lie in it entirely, and those pixels; at x8."""
    grid, (left, top, columns, rows) = whole_pixels(camera, parent.camera)
    x, y = round(grid.cx - camera.cx), round(grid.cy - camera.cy)
    first_x, first_y = -(-x // 8), -(-y // 8)
    columns = (camera.width + x) // 8 - first_x
    rows = (camera.height + y) // 8 - first_y
    inner = image[8 * first_y - y :, 8 * first_x - x :][: 8 * rows, : 8 * columns]
    means = inner.reshape(rows, 8, columns, 8, 3).mean((1, 3))
    return means, parent.image[top + first_y :, left + first_x :][:rows, :columns] / 255.0


@pytest.mark.parametrize(
    ("at", "pixels", "size"),
    [
        ((0.5, 0.5), (42, 28, 12, 8), (96, 64)),  # nothing to add
        ((0.5, 0.51), (42, 28, 12, 9), (96, 72)),  # starts at 28.64 of 64
        ((0.503, 0.5), (42, 28, 13, 8), (104, 64)),
        ((0.01, 0.5), (-6, 28, 13, 8), (104, 64)),  # beyond the border
    ],
)
def test_the_grid_sees_whole_pixels_of_the_parent(at, pixels, size):
    camera = PARENT.zoomed_to_region(*at, 8.0)
    grid, found = whole_pixels(camera, PARENT)
    assert found == pixels
    assert (grid.width, grid.height) == size
    points = np.array([[0.0, 0.0, 1.0], [0.3, -0.2, 2.0]])
    shift = (grid.project(points) - camera.project(points))[:, :2]
    np.testing.assert_array_equal(shift, np.rint(shift))  # so that its pictures can be cut
    corner = (grid.project(points) / [8, 8, 1] - PARENT.project(points))[:, :2]
    assert np.abs(corner + pixels[:2]).max() <= 0.5 / 8 + 1e-9


def test_a_cut_is_what_the_camera_sees():
    camera = PARENT.zoomed_to_region(0.503, 0.51, 8.0)
    grid, _ = whole_pixels(camera, PARENT)
    plane = np.arange(grid.width * grid.height).reshape(grid.height, grid.width)
    inner = cut(plane, grid, camera)
    assert inner.shape == (camera.height, camera.width)
    assert inner[0, 0] == plane[round(grid.cy - camera.cy), round(grid.cx - camera.cx)]


@pytest.mark.parametrize("scale", [1, 2])
def test_a_plane_of_the_view_lies_in_the_grid_where_it_was(scale):
    camera = PARENT.zoomed_to_region(0.503, 0.51, 8.0)
    grid, (_, _, columns, rows) = whole_pixels(camera, PARENT)
    slope = np.tile(np.arange(12, dtype=np.float32) + 0.5, (8, 1))  # x in the parent's pixels
    spread = spread_over(slope, grid, camera, scale * columns, scale * rows)
    assert spread.shape == (scale * rows, scale * columns)
    x = (np.arange(scale * columns) + 0.5) / scale - (grid.cx - camera.cx) / 8
    inner = (x > 0.5) & (x < 11.5)
    np.testing.assert_allclose(spread[4, inner], x[inner], atol=0.04)  # measured 0.03: five bits of a pixel


def test_a_rendering_is_kept_within_a_step_of_the_image():
    image = np.full((20, 30, 3), 100, np.uint8)
    rendered = np.full((6, 8, 3), 100.3 / 255, np.float32)
    rendered[2:] = 0.9
    kept = on_whole_pixels(image, (-2, 4, 8, 6), rendered) * 255
    np.testing.assert_allclose(kept[:2], 100.3, atol=1e-3)
    np.testing.assert_allclose(kept[2:, 2:], 100.5, atol=1e-3)
    np.testing.assert_allclose(kept[2:, :2], 229.5, atol=1e-3)  # beyond the image only the rendering knows
    assert on_whole_pixels(image, (40, 40, 8, 6), rendered) is rendered


def test_only_a_zoom_has_the_parents_pixels(root):
    from wzviewer.commands.cameras import orbited

    camera = root.camera.zoomed_to_region(0.5, 0.51, 8.0)
    assert is_zoom(camera, root.camera)
    assert not is_zoom(replace(camera, fx=1.01 * camera.fx), root.camera)
    aside = orbited(camera, root.frame.origin, 8.0)
    assert not is_zoom(aside, root.camera)
    assert observe([root], aside).grid is aside


@pytest.mark.parametrize("finer", [1, 1.4, 2])
@pytest.mark.parametrize("at", [(0.5, 0.5), (0.503, 0.515), (0.31, 0.44)])
def test_a_level_shrunk_is_its_parents_pixels_wherever_it_begins(models, root, at, finer):
    known = root
    if finer > 1:
        known = with_photo(root, stones(finer))
    camera = root.camera.zoomed_to_region(*at, 8.0)
    seen = sharpened(observe([known], camera))
    made = upscale_image(seen, models, 0, lambda: None)
    assert made.image.shape == root.image.shape
    assert made.extra["relief_texture"].shape == made.context.labels.shape == root.image.shape[:2]
    found, wanted = whole_footprints(made.image, camera, root)
    assert psnr_db(found, wanted, 1.0) > 41.5  # measured 43.1 to 53.9; on a view's own pixels 30.8 to 41
    assert made.notes["consistency_db"] > 41.5
    assert preview_image(seen, models, 0).image.shape == root.image.shape
