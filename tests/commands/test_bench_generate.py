"""What ``bench generate`` calls consistent."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.gl.surfaces import flat_scene
from wzviewer.commands.bench_generate import consistency_db
from wzviewer.core.scene import Scene

FINE = 8  # pixels of the world's picture in one of the parent's


def looked_at(world, at):
    """A parent and its child, a zoom of x8 at a place, that both show one picture (8 h, 8 w, 3) exactly."""
    parent, child = flat_scene(64, 48)
    camera = parent.camera.zoomed_to_region(*at, 8.0)
    image = cv2.resize(world, (64, 48), interpolation=cv2.INTER_AREA)
    start = np.array([parent.camera.cx - camera.cx / 8, parent.camera.cy - camera.cy / 8]) * FINE
    shift = np.array([[1.0, 0.0, start[0]], [0.0, 1.0, start[1]]])
    crop = cv2.warpAffine(world, shift, (64, 48), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    scene = Scene()
    scene.append(replace(parent, image=image))
    scene.append(replace(child, camera=camera, image=crop))
    return scene


@pytest.mark.parametrize("at", [(0.5, 0.5), (0.503, 0.515), (0.31, 0.44)])
def test_a_level_that_shows_the_parents_picture_is_consistent_wherever_it_begins(at):
    rng = np.random.default_rng(0)
    world = cv2.GaussianBlur(rng.uniform(0, 255, (48 * FINE, 64 * FINE, 3)).astype(np.float32), (0, 0), 2.0)
    world = np.clip(8 * (world - 128) + 128, 0, 255).astype(np.uint8)
    scene = looked_at(world, at)
    assert consistency_db(scene, 1) > 43  # measured 58.3, 44.9 (within a pixel of the level), 47.8
    image = scene[1].image
    scene.replace(replace(scene[1], image=np.roll(image, 4, axis=1)))  # by half a pixel of the parent
    assert consistency_db(scene, 1) < 25  # measured 17.7 and less
