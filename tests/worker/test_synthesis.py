"""Algorithm 1 in one process, on pictures of unusual shape: what holds for every level."""

import math
from dataclasses import replace
from unittest.mock import Mock

import numpy as np
import pytest

from wzviewer.core.assembly import finished
from wzviewer.core.opacity import feather_px
from wzviewer.core.photos import fit_photo
from wzviewer.errors import Cancelled, PromptError, WorkerError
from wzviewer.worker.draft import visible_parts
from wzviewer.worker.levels import context_of
from wzviewer.worker.models.registry import load_synthesizer
from wzviewer.worker.rasterize import render
from wzviewer.worker.stages.stage1_new_scale_image import observe, preview_image
from wzviewer.worker.synthesis import reconstruct_scene, synthesize_level


class Quiet:
    """A report that remembers."""

    def __init__(self, cancel_in=None):
        self.stages, self.levels, self.cancel_in = [], [], cancel_in

    def check(self):
        if self.cancel_in is not None and self.stages and self.stages[-1] >= self.cancel_in:
            raise Cancelled

    def stage(self, stage, name, fraction):
        assert 0.0 <= fraction < 1.0
        self.stages.append(stage)

    def level(self, level):
        self.levels.append(level)


@pytest.fixture(scope="module")
def models():
    return load_synthesizer("builtin")


def picture(kind):
    rng = np.random.default_rng(1)
    width, height = {"tiny": (64, 64), "portrait": (72, 120), "grey": (96, 64), "flat": (96, 64)}[kind]
    y, x = np.mgrid[0:height, 0:width]
    image = np.stack([90 + 60 * np.sin(x / 7.0), 120 + 50 * np.cos(y / 9.0), 60.0 + y], axis=-1)
    image += rng.normal(0, 8, image.shape)
    if kind == "grey":
        image[:] = image.mean(axis=-1, keepdims=True)
    if kind == "flat":
        image[:] = 128
    return fit_photo(np.clip(image, 0, 255).astype(np.uint8), 160)


def assert_sound(path):
    level = path[-1]
    seen = render(visible_parts(path, level.camera), level.camera)
    color = seen.color / np.maximum(seen.coverage, 0.5)[..., None]
    edge = math.ceil(feather_px(level.camera)) if level.parent is not None else 0
    own = (slice(edge, level.camera.height - edge), slice(edge, level.camera.width - edge))
    error = float(np.mean((color[own] - level.image[own] / 255.0) ** 2))
    assert 10 * np.log10(1 / max(error, 1e-9)) > 42.0  # measured 45.5 to 90
    assert np.mean(seen.coverage < 0.5) < 0.002
    assert np.isfinite(level.relief).all()
    assert all(np.isfinite(a).all() for a in level.surfels.arrays().values())
    again = finished(level.surfels, level.camera, level.frame)
    for name, array in level.surfels.arrays().items():
        np.testing.assert_array_equal(array, again.arrays()[name], err_msg=name)


@pytest.mark.parametrize("kind", ["tiny", "portrait", "grey", "flat"])
def test_any_picture_becomes_levels_that_show_their_image(models, kind):
    image = picture(kind)
    root = reconstruct_scene(image, 0, models, Quiet())
    assert_sound([root])
    report = Quiet()
    camera = root.camera.zoomed_to_region(0.5, 0.55, 8.0)
    child = synthesize_level([root], 1, camera, "a ladybug", 1, models, report)
    assert_sound([root, child])
    assert report.stages == [1, 2, 3, 4, 5]
    assert child.notes["consistency_db"] >= 40.0
    assert context_of(child).level == 1
    camera = child.camera.zoomed_to_region(0.5, 0.5, 8.0)
    grandchild = synthesize_level([root, child], 2, camera, "", 2, models, Quiet())
    assert_sound([root, child, grandchild])


def test_a_child_shrunk_is_its_parent(models):
    root = reconstruct_scene(picture("portrait"), 0, models, Quiet())
    child = synthesize_level([root], 1, root.camera.zoomed_to_region(0.5, 0.5, 8.0), "", 1, models, Quiet())
    h, w = root.image.shape[:2]
    small = child.image.reshape(h // 8, 8, w // 8, 8, 3).mean(axis=(1, 3))
    y, x = h * 7 // 16, w * 7 // 16
    crop = root.image[y : y + h // 8, x : x + w // 8].astype(float)
    error = np.mean(((small - crop) / 255.0) ** 2)
    assert 10 * np.log10(1 / error) > 40.0  # measured 42.1


def test_what_a_prompt_asks_for_is_in_a_preview_where_it_will_be(models):
    root = reconstruct_scene(picture("grey"), 0, models, Quiet())
    report = Quiet()
    camera = root.camera.zoomed_to_region(0.5, 0.5, 4.0)
    synthesize_level([root], 1, camera, "a red lego brick", 1, models, report)
    assert len(report.levels) == 4  # what is there, with the brick, complete, optimised
    red = [level.image[..., 0] > level.image[..., 1:].max(-1) + 40.0 for level in report.levels]
    assert red[0].sum() == 0
    assert (red[1] & red[3]).sum() > 0.8 * (red[1] | red[3]).sum()  # measured .92


def test_an_objects_shadow_is_not_read_as_relief_of_its_ground(models):
    root = reconstruct_scene(picture("grey"), 0, models, Quiet())
    camera, read = root.camera.zoomed_to_region(0.5, 0.5, 4.0), []
    for prompt in ("", "a red lego brick"):
        depth = Mock(wraps=models.depth)
        synthesize_level([root], 1, camera, prompt, 1, replace(models, depth=depth), Quiet())
        read.append(depth.read.call_args.args[0])
    assert (read[0] == read[1]).all()


def test_a_preview_of_what_hardly_grows_needs_no_network(models):
    root = reconstruct_scene(picture("portrait"), 0, models, Quiet())
    detail = Mock(wraps=models.detail)
    watched = replace(models, detail=detail)
    for factor, calls in ((2.0, 0), (4.0, 1)):
        seen = observe([root], root.camera.zoomed_to_region(0.5, 0.5, factor))
        image = preview_image(seen, watched, 0).image
        assert image.shape == root.image.shape
        assert detail.preview.call_count == calls


def test_a_prompt_is_refused_before_any_work(models):
    report = Quiet()
    with pytest.raises(PromptError):
        synthesize_level([], 1, None, "a zeppelin made of soup", 1, models, report)
    assert report.stages == []


@pytest.mark.parametrize("stage", [1, 2, 4, 5])
def test_every_stage_notices_a_cancel(models, stage):
    root = reconstruct_scene(picture("tiny"), 0, models, Quiet())
    report = Quiet(cancel_in=stage)
    camera = root.camera.zoomed_to_region(0.5, 0.55, 8.0)
    with pytest.raises(Cancelled):
        synthesize_level([root], 1, camera, "a ladybug", 1, models, report)
    assert report.stages[-1] == stage


def test_a_view_beyond_the_border_extends_the_picture(models):
    root = reconstruct_scene(picture("portrait"), 0, models, Quiet())
    aside = root.camera.zoomed_to_region(1.0, 0.5, 1.0)
    level = synthesize_level([root], 1, aside, "", 1, models, Quiet())
    assert 0.2 < level.notes["extended_share"] < 0.7  # half of the view, less the sharp part of the pad
    seen = render(visible_parts([root, level], aside), aside).color
    edge = math.ceil(feather_px(aside))
    own = (slice(edge, aside.height - edge), slice(edge, aside.width - edge))
    assert (
        np.abs(seen[own] - level.image[own] / 255.0).mean() < 0.02
    )  # at its own scale it is there; measured 0.004
    assert_sound([root, level])


def test_a_view_of_nothing_cannot_be_extended(models):
    root = reconstruct_scene(picture("portrait"), 0, models, Quiet())
    with pytest.raises(WorkerError, match="next to nothing"):
        synthesize_level([root], 1, root.camera.zoomed_to_region(1.7, 0.5, 1.0), "", 1, models, Quiet())


def test_a_zoom_into_the_picture_shows_nothing_but_the_picture(models):
    """Between surfels a surface lets through some of the backdrop, which is no reason to paint it anew."""
    root = reconstruct_scene(picture("portrait"), 0, models, Quiet())
    for x, y in ((0.36, 0.42), (0.5, 0.5), (0.61, 0.37)):
        assert observe([root], root.camera.zoomed_to_region(x, y, 8.0)).extended_share == 0.0
