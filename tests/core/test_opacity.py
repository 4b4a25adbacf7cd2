"""Eq. 3 as printed, and the partition of unity on any tree."""

import numpy as np
import pytest

from tests.gl.surfaces import orbited
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import (
    EXTENSION_OCTAVES,
    edge_coverage,
    opacity_weight,
    stored_coverage,
    weights,
)
from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.core.surfels import Surfels

NUM_POINTS = 400


def bare_level(scene, parent, camera):
    frame = LevelFrame.of_camera(camera, 1.0)
    blank = np.zeros((camera.height, camera.width, 3), np.uint8)
    relief = np.zeros((camera.height, camera.width), np.float32)
    return Level(len(scene), parent, camera, frame, Surfels.empty(), blank, relief)


def random_tree(seed, num_levels=8):
    """Feathered, overlapping siblings; children off the middle; zooms of 2 to 3.5 (x64 to x500 in all).

    Deeper below, float32 rows of a far descendant's camera err by 1e-3 px, and m by 2e-4.
    """
    rng = np.random.default_rng(seed)
    scene = Scene()
    scene.append(bare_level(scene, None, Camera.initial(64, 48)))
    for index in range(1, num_levels):
        parent = int(rng.integers(max(0, index - 3), index))
        x, y = 0.25 + 0.5 * rng.random(2)
        camera = scene[parent].camera.zoomed_to_region(x, y, 2.0 + 1.5 * rng.random())
        scene.append(bare_level(scene, parent, camera))
    return scene


def points_in_view(camera, seed):
    """World points seen by a camera, at depths about 1, (n, 3) float64."""
    rng = np.random.default_rng(seed)
    x, y, depth = rng.random((3, NUM_POINTS))
    return np.array(
        [
            camera.unproject(a * camera.width, b * camera.height, 0.9 + 0.2 * c)
            for a, b, c in zip(x, y, depth, strict=True)
        ]
    )


def weights_at(scene, camera, world):
    """The weight of each visible level at world points, (levels, n)."""
    found = []
    for index in scene.visible():
        level = scene[index]
        # Not float32: of the root's frame it would be another point than of a level x500 below.
        local = (world - level.frame.origin) @ level.frame.axes.T / level.frame.unit
        native = np.exp2(AnchoredView.expand(level.camera, level.frame).log_scale(local))
        chain = [scene[i].camera for i in scene.path(index)[1:]]
        coverage = stored_coverage(local, level.frame, chain)
        view = AnchoredView.expand(camera, level.frame)
        found.append(weights(local, native, coverage, view, modulation(scene, index)))
    return np.array(found)


@pytest.mark.parametrize("seed", [0, 2, 3, 5])
def test_weights_sum_to_one_at_every_point_of_any_tree(seed):
    scene = random_tree(seed)
    shared = 0
    for index in range(len(scene)):
        camera = orbited(scene[index].camera, scene[index].frame.origin, 4.0 * (index % 3 - 1))
        for magnify in (0.3, 1.0, 2.0):
            view = camera.zoomed(30.0, 20.0, magnify)
            w = weights_at(scene, view, points_in_view(view, index))
            np.testing.assert_allclose(w.sum(0), 1.0, atol=1e-5)  # measured 2e-6
            shared += int(((w > 0.05).sum(0) >= 3).sum())
    assert shared > 0  # points that three levels share: siblings and their parent


def test_hidden_levels_take_no_part():
    scene = random_tree(1)
    camera = scene[3].camera
    world = points_in_view(camera, 0)
    before = weights_at(scene, camera, world)
    scene.hide(scene.children(0)[-1])
    after = weights_at(scene, camera, world)
    assert len(after) < len(before)
    np.testing.assert_allclose(after.sum(0), 1.0, atol=1e-5)


def test_a_new_child_takes_its_share_without_touching_what_is_stored():
    """Append-only: modulation of the parent changes through its covers alone."""
    scene = random_tree(2, 3)
    camera = scene[2].camera.zoomed_to_region(0.5, 0.5, 8.0)
    world = points_in_view(camera, 0)
    before = weights_at(scene, camera, world)
    scene.append(bare_level(scene, 2, camera))
    after = weights_at(scene, camera, world)
    assert (after[:3] <= before + 1e-6).all()
    np.testing.assert_allclose(after.sum(0), 1.0, atol=1e-5)


def test_on_a_chain_it_is_eq_3_as_printed():
    """In the middle of the images, where coverage is 1."""
    scene, camera = Scene(), Camera.initial(64, 48)
    for index in range(4):
        scene.append(bare_level(scene, index - 1 if index else None, camera))
        camera = camera.zoomed_to_region(0.5, 0.5, 8.0)
    world = np.array([scene[3].camera.unproject(x, 24.0, 1.0) for x in np.linspace(20, 44, 9)])
    for magnify in np.geomspace(0.2, 1500.0, 40):
        view = scene[0].camera.zoomed(32.0, 24.0, magnify)
        scales = [np.full(9, c.pixel_scale(1.0), np.float32) for c in (view, *(lv.camera for lv in scene))]
        render, native = scales[0], scales[1:]
        w = weights_at(scene, view, world)
        for i in range(4):
            parent = native[i - 1] if i else np.full(9, np.inf, np.float32)
            child = native[i + 1] if i < 3 else np.zeros(9, np.float32)
            printed = opacity_weight(render, native[i], parent, child)
            np.testing.assert_allclose(w[i], printed, atol=2e-6)  # measured 4e-7


def test_eq_3_by_its_cases():
    def weight(render, parent=8.0, child=0.125):
        one = np.ones(1, np.float32)
        return float(
            opacity_weight(one * np.float32(render), one, one * np.float32(parent), one * np.float32(child))[
                0
            ]
        )

    assert weight(1.0) == 1.0
    assert weight(8.0) == weight(100.0) == 0.0
    assert weight(0.125) == weight(0.001) == 0.0
    assert weight(np.sqrt(8.0)) == pytest.approx(0.5, abs=1e-6)
    assert weight(0.5) == pytest.approx(2 / 3, abs=1e-6)
    assert weight(1e6, parent=np.inf) == 1.0
    assert weight(1e-6, child=0.0) == 1.0


def test_coverage_fades_inside_the_border_and_is_nothing_outside():
    px = np.float32([[50, 50], [0, 50], [-1, 50], [5, 50], [50, 95], [np.nan, 50], [101, 50]])
    m = edge_coverage(px, 100, 100, 10.0)
    np.testing.assert_allclose(m, [1, 0, 0, 0.5, 0.5, 0, 0], atol=1e-6)


def test_an_extension_is_there_at_its_parents_own_scale():
    scene, root = Scene(), Camera.initial(64, 48)
    scene.append(bare_level(scene, None, root))
    aside = root.zoomed_to_region(1.0, 0.5, 1.0)
    scene.append(bare_level(scene, 0, aside))
    law, frame = modulation(scene, 1), scene[1].frame
    points = np.zeros((1, 3), np.float32)
    native = np.exp2(AnchoredView.expand(aside, frame).log_scale(points))
    found = []
    for magnify in (2.0**-EXTENSION_OCTAVES, 2.0 ** (-0.5 * EXTENSION_OCTAVES), 1.0):
        view = AnchoredView.expand(aside.zoomed(aside.width / 2, aside.height / 2, magnify), frame)
        found.append(float(weights(points, native, np.ones(1, np.float32), view, law)[0]))
    np.testing.assert_allclose(found, [0.0, 0.5, 1.0], atol=1e-5)  # measured 2e-6
