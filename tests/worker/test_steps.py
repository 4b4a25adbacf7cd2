"""Stages applied to a draft: what is known already is not made up."""

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.steps import before_objects

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
