"""A first zoom shows the photograph's own pixels, wherever C_0 saw what is shown."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.worker.test_synthesis import Quiet, picture
from wzviewer.core.scene import PHOTO
from wzviewer.worker.models.registry import load_synthesizer
from wzviewer.worker.photograph import sharpened, with_photo
from wzviewer.worker.stages.stage1_new_scale_image import observe
from wzviewer.worker.synthesis import reconstruct_scene, synthesize_level

FINER = 4


@pytest.fixture(scope="module")
def models():
    return load_synthesizer("builtin")


@pytest.fixture(scope="module")
def root(models):
    """E_0 of a photograph with a pattern that its working size cannot show."""
    image = picture("portrait")
    height, width = image.shape[:2]
    photo = cv2.resize(image, (FINER * width, FINER * height), interpolation=cv2.INTER_CUBIC)
    y, x = np.mgrid[0 : FINER * height, 0 : FINER * width]
    checks = 24.0 * np.where((x // 2 + y // 2) % 2, 1, -1)[..., None]
    photo = np.clip(photo + checks, 0, 255).astype(np.uint8)
    image = cv2.resize(photo, (width, height), interpolation=cv2.INTER_AREA)
    return with_photo(reconstruct_scene(image, 0, models, Quiet()), photo)


def crop(photo, camera, root):
    """The photograph's pixels that a zoomed camera sees, at the size that shows them all."""
    factor = camera.focal_px / root.camera.focal_px
    width, height = (round(side * FINER / factor) for side in (camera.width, camera.height))
    left = round((root.camera.cx - camera.cx / factor) * FINER)
    top = round((root.camera.cy - camera.cy / factor) * FINER)
    return photo[top : top + height, left : left + width] / 255.0


def test_a_zoom_is_the_photograph(root):
    camera = root.camera.zoomed_to_region(0.5, 0.5, 8.0)
    seen = sharpened(observe([root], camera))
    wanted = crop(root.maps[PHOTO], camera, root)
    assert seen.image.shape == wanted.shape
    assert np.abs(seen.image - wanted).mean() < 0.003  # measured 0.00085: the rendering of E_0 itself
    plain = observe([root], camera).image
    assert plain.shape[0] * FINER == wanted.shape[0]
    shrunk = cv2.resize(seen.image, plain.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(shrunk - plain).mean() < 0.003  # measured 0.0008


def test_the_pattern_reaches_the_level(models, root):
    camera = root.camera.zoomed_to_region(0.5, 0.5, 8.0)
    wanted = crop(root.maps[PHOTO], camera, root)
    like = []
    for level0 in (root, replace(root, maps={k: v for k, v in root.maps.items() if k != PHOTO})):
        level = synthesize_level([level0], 1, camera, "", 1, models, Quiet())
        assert level.notes["consistency_db"] >= 40.0
        small = cv2.resize(level.image, wanted.shape[1::-1], interpolation=cv2.INTER_AREA) / 255.0
        like.append(np.corrcoef(*(_fine(picture_) for picture_ in (small, wanted)))[0, 1])
    assert like[0] > 0.9  # measured 0.9997
    assert abs(like[1]) < 0.3  # measured 0.03: without the photograph nobody knows of it


def _fine(image):
    grey = image.mean(2).astype(np.float32)
    return (grey - cv2.GaussianBlur(grey, (0, 0), 2.0)).ravel()


def test_from_aside_what_the_photograph_saw_is_found_again(root):
    from wzviewer.commands.cameras import orbited

    aside = orbited(root.camera.zoomed_to_region(0.5, 0.5, 4.0), root.frame.origin, 6.0)
    seen, plain = sharpened(observe([root], aside)), observe([root], aside)
    assert seen.image.shape[0] > 3 * plain.image.shape[0]
    ratio = _fine(seen.image).std() / _fine(crop(root.maps[PHOTO], root.camera, root)).std()
    assert ratio > 0.8  # measured 0.97: the checks are there
    shrunk = cv2.resize(seen.image, plain.image.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(shrunk - plain.image).mean() < 0.005  # measured 0.0015


@pytest.mark.parametrize("case", ["no photo", "deep", "inserted", "beyond the border"])
def test_where_the_photograph_knows_no_more_nothing_changes(root, case):
    path, camera = [root], root.camera.zoomed_to_region(0.5, 0.5, 8.0)
    if case == "no photo":
        path = [replace(root, maps={})]
    elif case == "deep":
        path = [root, replace(root, index=1, parent=0, camera=camera)]
        camera = camera.zoomed_to_region(0.5, 0.5, 8.0)
    elif case == "inserted":
        path = [replace(root, notes={"placements": [{}]})]
    else:
        camera = root.camera.zoomed_to_region(1.0, 0.5, 1.0)
    seen = observe([root], root.camera.zoomed_to_region(0.5, 0.5, 8.0))
    seen = replace(seen, path=path, camera=camera, extended_share=0.5 * (case == "beyond the border"))
    assert sharpened(seen) is seen
