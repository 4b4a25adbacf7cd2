from dataclasses import replace

import numpy as np
import pytest

from tests.core.builders import random_surfels, small_level, small_scene
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene, modulation, siblings_before


def digest(level):
    return [a.tobytes() for a in level.surfels.arrays().values()]


def test_appending_leaves_the_bytes_of_finished_levels_unchanged():
    scene = small_scene(1)
    before = digest(scene[0])
    scene.append(small_level(scene, 0, scene[0].camera.zoomed_to_region(0.5, 0.5, 8.0)))
    assert digest(scene[0]) == before


def test_a_finished_level_cannot_be_replaced_nor_dropped():
    scene = small_scene(2)
    with pytest.raises(ValueError, match="finished"):
        scene.replace(scene[1].with_surfels(random_surfels(3)))
    with pytest.raises(ValueError, match="cannot be dropped"):
        scene.abort(1)


def test_a_level_in_the_making_can_be_replaced_and_dropped():
    scene = small_scene(1)
    level = small_level(scene, 0, scene[0].camera.zoomed_to_region(0.5, 0.5, 8.0))
    scene.append(level)
    scene.replace(level.with_surfels(random_surfels(7)))
    assert len(scene[1].surfels) == 7
    scene.abort(1)
    assert len(scene) == 1


@pytest.mark.parametrize(("index", "parent"), [(2, 0), (1, 1), (1, None), (1, 5)])
def test_a_level_that_does_not_fit_the_log_is_refused(index, parent):
    scene = small_scene(1)
    level = replace(small_level(scene, 0, scene[0].camera), index=index, parent=parent)
    with pytest.raises(ValueError, match="level"):
        scene.append(level)


def test_hiding_hides_descendants_and_showing_brings_them_back():
    scene = small_scene(4)
    scene.hide(2)
    assert scene.visible() == [0, 1]
    assert scene.children(1) == []
    scene.show(2)
    assert scene.visible() == [0, 1, 2, 3]


def test_modulation_lists_children_and_newer_siblings_of_ancestors():
    scene = Scene()
    scene.append(small_level(scene, None, Camera.initial(64, 48)))
    for parent in (0, 0, 1):  # level 3 is a child of 1; 2 is a newer sibling of 1
        scene.append(small_level(scene, parent, scene[parent].camera.zoomed_to_region(0.5, 0.5, 8.0)))
    assert modulation(scene, 0).parent_rows is None
    assert len(modulation(scene, 0).covers) == 2
    assert len(modulation(scene, 1).covers) == 2  # its child 3, its newer sibling 2
    assert len(modulation(scene, 3).covers) == 1  # 2, newer sibling of its ancestor 1
    scene.hide(2)
    assert len(modulation(scene, 3).covers) == 0


def test_plain_detail_does_not_wipe_out_what_was_put_there_before():
    scene = Scene()
    root = Camera.initial(64, 48)
    scene.append(small_level(scene, None, root))
    asked = ((4.0, "a ladybug"), (2.0, ""), (8.0, ""), (3.0, "a butterfly"), (2.9, ""))
    for factor, prompt in asked:
        level = small_level(scene, 0, root.zoomed_to_region(0.5, 0.5, factor))
        scene.append(replace(level, prompt=prompt))
    before = [siblings_before(scene, index, 0) for index in range(1, 6)]
    assert before == [[3, 4, 5], [1, 3, 4, 5], [4], [], [3, 4]]
    scene.hide(4)
    assert siblings_before(scene, 5, 0) == [3]
    assert siblings_before(scene, 2, 0) == [1, 3, 5]
    chains = [len(siblings_before(scene, index, 0)) for index in (1, 2, 3, 5)]
    assert sorted(chains) == [0, 1, 2, 3]  # an order, whatever is hidden


def test_depth_restores_world_units():
    level = small_scene(2)[1]
    expected = 1.0 + level.frame.unit * level.relief.astype(np.float64)
    np.testing.assert_allclose(level.depth, expected, rtol=1e-12)
