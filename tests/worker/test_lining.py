"""What shines through between magnified surfels is the picture's own colour."""

from dataclasses import replace

import numpy as np
import pytest

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.draft import Draft
from wzviewer.worker.levels import layer_surfels
from wzviewer.worker.lining import lining, with_lining
from wzviewer.worker.models.builtin.objects.parts import Part
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.rasterize import LevelPart, render
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels

H, W = 60, 80


def draft(relief):
    """A dark picture before a bright sky."""
    camera = Camera.initial(W, H)
    image = np.full((H, W, 3), 0.1, np.float32)
    sky = Layer(
        np.ones((H, W, 3), np.float32), np.full((H, W), 900, np.float32), np.ones((H, W), bool), (0, 0)
    )
    nothing = np.zeros((H, W), bool)
    return Draft(camera, LevelFrame.of_camera(camera, 1.0), (), image, relief, nothing, layers=(sky,))


def plane(slope=0.0):
    return (slope * np.mgrid[:H, :W][0]).astype(np.float32)


@pytest.mark.parametrize("slope", [0.0, 3.0])
def test_nothing_shines_through_a_magnified_picture(slope):
    seen = {}
    for name, made in (("bare", draft(plane(slope))), ("lined", with_lining(draft(plane(slope))))):
        surfels = [generate_surfels(made.image, made.relief, made.camera), *layer_surfels(made)]
        parts = [LevelPart.of(part, made.frame) for part in surfels if len(part)]
        close = made.camera.zoomed_to_region(0.5, 0.5, 8.0)
        seen[name] = float(np.abs(render(parts, close, depth=False).color - 0.1).max())
    assert seen["lined"] < 0.1 * seen["bare"]  # measured: .079 -> .0005
    assert seen["lined"] < 0.01


def test_it_is_behind_all_that_is_seen_near_it():
    relief = plane(3.0)
    layer = lining(np.zeros((H, W, 3), np.float32), relief, np.ones((H, W), bool))
    y, x = np.nonzero(layer.mask)
    for down in (-3, 0, 4):
        near = relief[np.clip(2 * y + down, 0, H - 1), 2 * x]
        assert (layer.relief[y, x] > near).all()


def test_beside_an_edge_there_is_none():
    relief = plane()
    relief[:, W // 2 :] = 100
    layer = lining(np.zeros((H, W, 3), np.float32), relief, np.ones((H, W), bool))
    assert not layer.mask[:, W // 4 - 1 : W // 4 + 1].any()
    assert layer.mask[:, : W // 4 - 3].all()
    assert layer.mask[:, W // 4 + 3 :].all()


def test_where_nothing_is_behind_there_is_none():
    bare = replace(draft(plane()), layers=())
    assert with_lining(bare) is bare
    sky = replace(draft(plane()), sky=np.ones((H, W), bool))
    assert with_lining(sky) is sky


def test_an_object_is_lined_too_but_for_its_outline_and_what_is_sheer():
    h, w = 21, 31
    alpha = np.ones((h, w), np.float32)
    alpha[:, 20:] = 0.6
    relief = np.zeros((h, w), np.float32)
    relief[:, :4] = np.nan
    part = Part(np.full((h, w, 3), 0.4, np.float32), alpha, relief, (7, 11))
    (layer,) = with_lining(replace(draft(plane()), layers=(), parts=(part,))).layers
    assert layer.offset_px == (8, 12)
    whole = np.repeat(np.repeat(layer.mask, 2, 0), 2, 1)
    assert whole[:, 8:16].all()
    assert not whole[:, :4].any()
    assert not whole[:, 20:].any()
    assert np.allclose(layer.image[layer.mask], 0.4)
