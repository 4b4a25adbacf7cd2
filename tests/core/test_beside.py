from dataclasses import replace

import pytest

from tests.core.builders import small_level
from wzviewer.core.beside import levels_beside
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene


@pytest.fixture
def scene():
    scene = Scene()
    scene.append(small_level(scene, None, Camera.initial(64, 48)))
    scene.commit(0)
    return scene


def add(scene, parent, x, factor=8.0, prompt="a ladybug"):
    """Adds a level about a place of E_0's picture, so many times as close as its parent."""
    zoom = factor * scene.magnification(parent)
    camera = scene[0].camera.zoomed_to_region(x, 0.5, zoom)
    scene.append(replace(small_level(scene, parent, camera), prompt=prompt))
    scene.commit(len(scene) - 1)
    return len(scene) - 1


def beside(scene, x, factor=8.0, prompt="a bee", parent=0):
    return levels_beside(scene, parent, scene[0].camera.zoomed_to_region(x, 0.5, factor), prompt)


def test_an_older_sibling_is_beside_where_the_frames_overlap(scene):
    index = add(scene, 0, 0.45)
    assert beside(scene, 0.5) == [index]
    assert beside(scene, 0.57) == [index]  # its border is at .5125, the new one's at .5075
    assert beside(scene, 0.58) == []


def test_what_is_hidden_or_not_finished_is_not_beside(scene):
    index = add(scene, 0, 0.45)
    scene.hide(index)
    assert beside(scene, 0.5) == []
    scene.show(index)
    camera = scene[0].camera.zoomed_to_region(0.5, 0.5, 8.0)
    scene.append(small_level(scene, 0, camera))
    assert beside(scene, 0.5) == [index]


def test_another_version_of_a_level_does_not_show_the_first(scene):
    add(scene, 0, 0.5, prompt="a bee")
    assert beside(scene, 0.5, prompt="a bee") == []
    assert beside(scene, 0.5, prompt="a ladybug") == [1]


def test_ancestors_are_not_beside(scene):
    child = add(scene, 0, 0.5)
    assert beside(scene, 0.5, 64.0, parent=child) == []


def test_a_level_that_has_hardly_faded_in_is_not_seen(scene):
    add(scene, 0, 0.5)
    assert beside(scene, 0.5, 2.0) == []
    assert beside(scene, 0.5, 4.0) == [1]  # two thirds of the way, in log scale


def test_what_is_in_a_sibling_comes_with_it(scene):
    sibling = add(scene, 0, 0.5)
    inner = add(scene, sibling, 0.5, 2.0)
    assert beside(scene, 0.5, 14.0) == [sibling, inner]
    scene.hide(sibling)
    assert beside(scene, 0.5, 14.0) == []


def test_plain_detail_stays_behind_what_is_finer_and_need_not_show_it(scene):
    alike = add(scene, 0, 0.52, 8.0)
    finer = add(scene, 0, 0.5, 20.0)
    assert beside(scene, 0.5, 8.0, prompt="") == [alike]
    assert beside(scene, 0.5, 8.0, prompt="a bee") == [alike, finer]


def test_what_newer_siblings_hide_is_not_kept():
    scene = Scene()
    scene.append(small_level(scene, None, Camera.initial(640, 480)))
    scene.commit(0)
    old, new = add(scene, 0, 0.5), add(scene, 0, 0.5)
    assert beside(scene, 0.5) == [new]
    assert beside(scene, 0.45) == [new]
    newest = add(scene, 0, 0.52)
    assert beside(scene, 0.5) == [new, newest]
    scene.hide(new)
    assert beside(scene, 0.5) == [old, newest]
