"""Objects as surfels of their own: a mixed pixel is two surfaces, and both are where they belong."""

from dataclasses import replace

import numpy as np
import pytest

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.rasterize import LevelPart, render
from wzviewer.worker.standing import (
    covering_relief,
    flank_surfels,
    front_surfels,
    in_sight,
    opacity_of,
    out_of_sight,
    part_layers,
    seen_relief,
    settled,
)

H, W = 60, 80
RED, GREEN = np.array([0.9, 0.1, 0.1], np.float32), np.array([0.1, 0.8, 0.1], np.float32)


def draft(alpha=1.0, relief=-20.0):
    """A green ground at relief 0 with a red square in front of its middle."""
    camera = Camera.initial(W, H)
    ground = np.broadcast_to(GREEN, (H, W, 3)).astype(np.float32)
    square = np.full((20, 30), alpha, np.float32)
    part = Part(
        np.broadcast_to(RED, (20, 30, 3)).astype(np.float32),
        square,
        np.full((20, 30), relief, np.float32),
        (25, 20),
    )
    image = ground.copy()
    image[20:40, 25:55] += alpha * (RED - GREEN)
    flat, sky = np.zeros((H, W), np.float32), np.zeros((H, W), bool)
    return Draft(
        camera, LevelFrame.of_camera(camera, 1.0), (), image, flat, sky, ground=ground, parts=(part,)
    )


@pytest.mark.parametrize("alpha", [0.2, 0.5, 0.8, 1.0])
def test_over_each_other_ground_and_object_are_the_picture(alpha):
    start = draft(alpha)
    seen = render([LevelPart.of(front_surfels(start).surfels, start.frame)], start.camera)
    inside = np.s_[24:36, 30:50]
    assert np.abs(seen.color[inside] - start.image[inside]).max() < 0.03  # measured .02
    assert np.abs(seen.color[5:15] - GREEN).max() < 0.03


def test_opacities_grow_with_coverage():
    opacities = opacity_of(np.array([0.0, 0.2, 0.5, 0.8, 1.0], np.float32))
    assert (np.diff(opacities) > 0).all()
    assert opacities[0] == 0
    assert opacities[-1] == pytest.approx(0.99)


def test_a_level_has_the_objects_relief_where_they_cover_most():
    assert (seen_relief(draft(0.6))[20:40, 25:55] == -20).all()
    assert (seen_relief(draft(0.4)) == 0).all()
    core = covering_relief(draft(1.0)) == -20
    assert core[21:39, 26:54].all()
    assert core.sum() == 18 * 28  # less a pixel of its outline
    assert (covering_relief(draft(0.6)) == 0).all()


def test_an_object_is_never_behind_its_ground():
    start = draft(1.0, relief=7.0)
    assert (settled(start).parts[0].relief == -0.25).all()
    assert (settled(draft()).parts[0].relief == -20).all()


def test_a_guessed_ground_makes_room_for_an_object():
    start = draft(1.0, relief=7.0)
    known = np.zeros((H, W), bool)
    known[:, 10:] = True
    found = settled(replace(start, extra={"guessed": known}))
    assert (found.parts[0].relief == 7.0).all()
    assert (found.relief[20:40, 25:55] == 7.25).all()
    assert (found.relief[:10] == 0).all()


def test_in_a_neighbours_target_a_sheer_part_has_no_colour():
    opaque, sheer = (part_layers(draft(a), 0.97)[0] for a in (1.0, 0.5))
    assert np.array_equal(opaque.image[0, 0], RED)
    assert opaque.mask.all()
    assert sheer.image.max() < -1


def test_flanks_are_where_their_corners_say():
    start = draft()
    x, y = np.meshgrid(np.arange(30, 50) + 0.5, np.arange(25, 35) + 0.5)
    at = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -5.0)])
    corners = at + np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)[:, None]
    flanks = Flanks(corners, np.tile(RED, (x.size, 1)), np.ones(x.size, np.float32))
    (surfels,) = flank_surfels(replace(start, flanks=(flanks,)))
    seen = render([LevelPart.of(surfels, start.frame)], start.camera)
    assert seen.coverage[28:32, 34:46].min() > 0.98  # measured .999
    assert np.abs(seen.relief[28:32, 34:46] + 5).max() < 0.1
    assert seen.coverage[:20].max() < 0.01


def test_what_is_hidden_or_sheer_is_not_optimised():
    opaque = front_surfels(draft(1.0))
    assert opaque.kept[: H * W].sum() == 20 * 30  # of the ground
    assert not opaque.kept[H * W :].any()
    sheer = front_surfels(draft(0.5))
    assert not sheer.kept[: H * W].any()
    assert sheer.kept[H * W :].all()


def test_what_touches_nothing_that_is_seen_is_buried():
    floating, touching = draft(1.0), draft(1.0)
    assert front_surfels(floating).buried.sum() == 14 * 24  # three pixels in from each side
    relief = touching.relief + np.linspace(-40, 40, W, dtype=np.float32)  # steep: it reaches past the part
    part = replace(touching.parts[0], relief=relief[20:40, 25:55] - 0.25)
    assert not front_surfels(replace(touching, relief=relief, parts=(part,))).buried.any()


def test_what_a_part_buries_of_another_is_no_target():
    start = draft(1.0)
    near = replace(start.parts[0], relief=start.parts[0].relief - 5)
    under, over = part_layers(replace(start, parts=(start.parts[0], near)), 0.97)
    assert (under.image[3:-3, 3:-3] < -1).all()
    assert np.array_equal(over.image[9, 9], RED)


def standing(height_px):
    """A red square, 60 px wide, so high above a green ground."""
    start = draft()
    part = Part(
        np.ones((40, 60, 3), np.float32),
        np.ones((40, 60), np.float32),
        np.full((40, 60), -height_px, np.float32),
        (10, 10),
    )
    return replace(start, parts=(part,))


def test_what_no_neighbour_sees_under_an_object_is_left_out():
    low, high = standing(5.0), standing(40.0)
    for made, share in ((low, 0.285), (high, 0.0)):
        gone = out_of_sight(made, made.relief)
        assert gone[10:50, 10:70].mean() == pytest.approx(share, abs=0.02)
        assert not gone[:18].any()
        left = len(front_surfels(made).surfels) - 2400
        assert left == H * W - gone.sum()
    assert not out_of_sight(replace(low, parts=()), low.relief).any()


def test_a_layer_keeps_what_a_neighbour_may_see():
    made = standing(5.0)
    shape = (30, 40)
    layer = Layer(
        np.zeros((*shape, 3), np.float32), np.zeros(shape, np.float32), np.ones(shape, bool), (-4, 0), 2
    )
    gone = out_of_sight(made, made.relief)
    kept = in_sight(layer, made).mask
    assert kept.sum() == pytest.approx(layer.mask.sum() - gone.sum() / 4, abs=8)
    assert kept[:, :3].all()  # beside the frame
