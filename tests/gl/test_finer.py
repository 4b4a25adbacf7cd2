"""A frame at a part of the resolution, in motion, shows the levels that the whole one shows."""

import cv2
import numpy as np
import pytest

from tests.core.builders import random_surfels
from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import weights
from wzviewer.core.scene import modulation
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

PART = 4


@pytest.fixture(scope="module")
def scene():
    """Two levels that no one takes for each other: grey, and on it red."""
    image = np.full((96, 144, 3), 120, np.uint8)
    grey, red = chain_scene(2, image), chain_scene(2, np.full_like(image, (220, 40, 30)))
    mixed = type(grey)()
    for level in (grey[0], red[1]):
        mixed.append(level)
        mixed.commit(level.index)
    return mixed


def camera_between(scene):
    """Half of the way from the parent's scale to the child's: Eq. 3 gives each about a half."""
    child = scene[1].camera
    return child.zoomed(child.width / 2, child.height / 2, 8**-0.5)


def test_weights_are_those_of_the_whole_resolution(scene):
    camera = camera_between(scene)
    small = camera.resized(camera.width // PART, camera.height // PART)
    law, frame, surfels = modulation(scene, 1), scene[1].frame, scene[1].surfels
    arrays = (surfels.means, surfels.native_scales, surfels.coverage)
    whole = weights(*arrays, AnchoredView.expand(camera, frame), law)
    part = weights(*arrays, AnchoredView.expand(small, frame).finer(PART), law)
    np.testing.assert_allclose(part, whole, atol=2e-6)  # measured 0
    assert np.abs(weights(*arrays, AnchoredView.expand(small, frame), law) - whole).max() > 0.4


def test_points_stay_in_their_place():
    camera = Camera.initial(64, 48)
    view = AnchoredView.expand(camera, LevelFrame.of_camera(camera, 1.0))
    means = random_surfels(20, 3).means
    np.testing.assert_array_equal(view.finer(PART).project(means), view.project(means))
    np.testing.assert_allclose(view.finer(PART).log_scale(means), view.log_scale(means) - 2.0, atol=1e-6)
    assert view.finer(1.0) is view


@pytest.mark.gl
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
@pytest.mark.parametrize("culling", [True, False])
def test_no_level_fades_for_want_of_pixels(gl_context, scene, rasterizer, culling):
    camera = camera_between(scene)
    small = camera.resized(camera.width // PART, camera.height // PART)
    renderer = SurfelRenderer(gl_context, rasterizer)
    renderer.sync(scene)
    size = (small.width, small.height)
    whole = cv2.resize(renderer.render(camera).read_color8(), size, interpolation=cv2.INTER_AREA)
    settings = RenderSettings(culling=culling, finer=PART)
    part = renderer.render(small, settings).read_color8()
    faded = renderer.render(small).read_color8()
    renderer.release()
    inner = (
        slice(small.height // 2 - 3, small.height // 2 + 3),
        slice(small.width // 2 - 4, small.width // 2 + 4),
    )
    means = [picture[inner].reshape(-1, 3).astype(float).mean(0) for picture in (whole, part, faded)]
    assert np.abs(means[1] - means[0]).max() < 3  # measured 0.8
    assert np.abs(means[2] - means[0]).max() > 20  # without it the child is all but gone: measured 70


@pytest.mark.gl
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_culling_leaves_out_nothing_that_counts(gl_context, scene, rasterizer):
    camera = camera_between(scene)
    small = camera.resized(camera.width // PART, camera.height // PART)
    renderer = SurfelRenderer(gl_context, rasterizer)
    renderer.sync(scene)
    pictures = [
        renderer.render(small, RenderSettings(culling=culling, finer=PART)).read_color8().astype(int)
        for culling in (True, False)
    ]
    renderer.release()
    assert np.abs(pictures[0] - pictures[1]).max() <= 1  # as at the whole resolution: rounding
