"""Stages applied to a draft: what is known already is not made up."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
from wzviewer.worker.steps import before_objects, behind_redrawn

H, W = 60, 80


def draft(**extra):
    camera = Camera.initial(W, H)
    frame = LevelFrame.of_camera(camera, 1.0)
    image = np.full((H, W, 3), 0.9, np.float32)
    return Draft(camera, frame, (), image, np.zeros((H, W), np.float32), np.zeros((H, W), bool), extra=extra)


def layer():
    """Hidden pixels that the exemplar search has filled with the object itself."""
    shape = (30, 40)
    return Layer(
        np.full((*shape, 3), 0.9, np.float32), np.zeros(shape, np.float32), np.ones(shape, bool), (20, 10)
    )


def test_behind_a_new_object_is_what_was_there_before():
    before = np.random.default_rng(0).random((H, W, 3), np.float32)
    objects = np.zeros((H, W), bool)
    objects[20:30, 30:40] = True
    (found,) = before_objects(draft(behind_objects=before, new_objects=objects), (layer(),))
    assert np.array_equal(found.image[10:20, 10:20], before[20:30, 30:40])
    assert (found.image[:4] == 0.9).all()  # far from it the layer stays as it was
    assert np.array_equal(found.relief, layer().relief)


def test_without_new_objects_layers_stay():
    layers = (layer(),)
    assert before_objects(draft(), layers) is layers


def test_behind_an_object_drawn_again_is_what_coarser_levels_hide_there():
    objects = np.zeros((H, W), bool)
    objects[20:30, 30:40] = True
    green = np.zeros((H, W, 3), np.float32)
    green[..., 1] = 0.6
    start = draft(redrawn_objects=objects, observation=SimpleNamespace(relief=np.zeros((H, W), np.float32)))
    hidden = generate_surfels(green, np.full((H, W), 4.0, np.float32), start.camera)
    (found,) = behind_redrawn(replace(start, layers=(layer(),), hidden=hidden))
    assert np.abs(found.image[11:19, 11:19] - green[0, 0]).max() < 0.02  # measured: 0.005
    assert (found.image[:4] == 0.9).all()


def test_where_coarser_levels_hide_nothing_layers_stay():
    shown = replace(draft(redrawn_objects=np.ones((H, W), bool)), layers=(layer(),))
    assert behind_redrawn(shown) is shown.layers
