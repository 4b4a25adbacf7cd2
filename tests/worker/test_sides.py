"""Objects from beside them: their sides are surfels behind the picture, and in a body is nothing else."""

from dataclasses import replace

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.objects.editor import Side
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.sides import with_sides
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels

H, W = 60, 80
RED, GREY = np.array([0.8, 0.1, 0.1], np.float32), 0.5


class Editor:
    """Knows of a block in the middle of the picture: 40 px deep, with one red point on its side."""

    def sides(self, placed, image, relief, mask, focal_px, check=None):
        back = np.where(mask, np.float32(40), np.float32(-np.inf))
        point = np.array([[40.5, 30.5]]), np.array([20.0]), np.array([[[1.0, 0, 0], [0, 1.0, 0]]])
        return Side(*point, RED[None], back)


class Models:
    """Only the editor is asked."""

    editor = Editor()


def draft():
    camera = Camera.initial(W, H)
    image, mask = np.full((H, W, 3), 0.9, np.float32), np.zeros((H, W), bool)
    mask[20:40, 30:50] = True
    layer = Layer(
        np.full((H, W, 3), GREY, np.float32), np.full((H, W), 10.0, np.float32), np.ones((H, W), bool), (0, 0)
    )
    start = Draft(
        camera,
        LevelFrame.of_camera(camera, 1.0),
        (),
        image,
        np.zeros((H, W), np.float32),
        np.zeros((H, W), bool),
        layers=(layer,),
        extra={"object_mask": mask},
    )
    inherited = generate_surfels(image, np.full((H, W), 15.0, np.float32), camera)
    return replace(start, hidden=inherited), mask


def test_a_side_is_a_surfel_and_what_was_in_the_body_is_gone():
    start, mask = draft()
    found = with_sides(start, Models(), lambda: None)
    assert np.allclose(found.hidden.means[-1, 2], 20)
    assert np.allclose(found.hidden.colors[-1], RED)
    left, before = len(found.hidden) - 1, len(start.hidden)
    # Places of surfels 15 px behind the picture shift by less than a pixel towards its middle.
    assert abs(before - left - mask.sum()) < 45  # of 400; measured 19


def test_a_layer_in_a_body_has_its_sides_colours():
    start, mask = draft()
    (layer,) = with_sides(start, Models(), lambda: None).layers
    assert np.allclose(layer.image[mask], RED)  # all of it is close to the side
    assert np.allclose(layer.image[~mask], GREY)
    assert np.array_equal(layer.relief, start.layers[0].relief)


def test_without_objects_nothing_changes():
    start, _ = draft()
    bare = replace(start, extra={})
    assert with_sides(bare, Models(), lambda: None) is bare
