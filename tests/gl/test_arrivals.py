"""What is drawn while a scene arrives: old or new, never a mix."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from tests.core.builders import random_surfels, small_level, small_scene
from tests.gl.paging import shrink_pages
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene, modulation
from wzviewer.gl import arrivals as module
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.pages import Pages

PAGE = 16


@pytest.fixture
def page_bytes(monkeypatch):
    return shrink_pages(monkeypatch, PAGE)


@pytest.fixture
def arrivals():
    return Arrivals(Pages())


def drawn(arrivals):
    return {i: state.level for i, state in arrivals.states.items()}


def one_level(seed):
    scene = Scene()
    scene.append(small_level(scene, None, Camera.initial(64, 48), 40, seed))
    return scene


def test_a_level_is_drawn_when_its_last_surfel_is_there(arrivals, page_bytes):
    scene = small_scene(2)  # 40 and 41 surfels: three pages each
    steps = [not arrivals.sync(scene, page_bytes, None) and sorted(drawn(arrivals)) for _ in range(5)]
    assert steps == [[], [], [0], [0], [0]]
    assert arrivals.sync(scene, page_bytes, None)
    assert drawn(arrivals) == {0: scene[0], 1: scene[1]}


def test_a_call_without_news_changes_nothing(arrivals):
    scene = small_scene(3)
    arrivals.sync(scene, None, None)
    states, version = arrivals.states, arrivals.version
    scene.commit(2)
    assert arrivals.sync(scene, None, None)
    assert arrivals.states is states
    assert arrivals.version == version


def test_no_other_scene_can_have_the_address_of_the_last(arrivals):
    """Scenes are told apart by identity, so the one that is drawn is held, and no other."""
    scene = one_level(1)
    arrivals.sync(scene, None, None)
    last = weakref.ref(scene)
    del scene
    gc.collect()
    assert last() is not None
    other = one_level(2)
    assert arrivals.sync(other, None, None)
    assert drawn(arrivals)[0] is other[0]
    gc.collect()
    assert last() is None


def test_levels_of_the_last_document_do_not_stand_in_for_those_of_the_next(arrivals, page_bytes):
    arrivals.sync(small_scene(3), None, None)
    other = Scene()
    for seed in range(3):
        camera = (
            Camera.initial(64, 48) if seed == 0 else other[seed - 1].camera.zoomed_to_region(0.5, 0.5, 4.0)
        )
        other.append(small_level(other, seed - 1 if seed else None, camera, 40, 10 + seed))
    while not arrivals.sync(other, page_bytes, None):
        assert all(level is other[i] for i, level in drawn(arrivals).items())
    assert drawn(arrivals) == dict(enumerate(other))


def test_the_same_levels_in_another_log_stay(arrivals, page_bytes):
    scene, copy = small_scene(2), Scene()
    arrivals.sync(scene, None, None)
    for level in scene:
        copy.append(level)
    assert arrivals.sync(copy, page_bytes, None)
    assert drawn(arrivals) == {0: scene[0], 1: scene[1]}


def test_a_replaced_level_keeps_its_old_form_until_the_new_one_is_there(arrivals, page_bytes):
    scene = one_level(1)
    old = scene[0]
    arrivals.sync(scene, None, None)
    scene.replace(replace(old, surfels=random_surfels(100, 2)))
    for _ in range(6):
        assert not arrivals.sync(scene, page_bytes, None)
        assert drawn(arrivals)[0] is old
    assert arrivals.sync(scene, page_bytes, None)
    assert drawn(arrivals)[0] is scene[0]


def test_a_level_dropped_half_way_and_another_in_its_place(arrivals, page_bytes):
    scene = small_scene(1)
    arrivals.sync(scene, None, None)
    camera = scene[0].camera.zoomed_to_region(0.5, 0.5, 8.0)
    scene.append(small_level(scene, 0, camera, 40, 7))
    assert not arrivals.sync(scene, page_bytes, None)
    scene.abort(1)
    assert arrivals.sync(scene, page_bytes, None)
    assert sorted(drawn(arrivals)) == [0]
    scene.append(small_level(scene, 0, camera, 40, 8))
    assert arrivals.sync(scene, None, None)
    assert drawn(arrivals)[1] is scene[1]
    scene.abort(1)
    assert arrivals.sync(scene, None, None)
    assert sorted(drawn(arrivals)) == [0]


def test_hidden_levels_go_and_come_back_without_an_upload(arrivals, page_bytes):
    scene = small_scene(3)
    arrivals.sync(scene, None, None)
    scene.hide(1)
    assert arrivals.sync(scene, page_bytes, None)
    assert sorted(drawn(arrivals)) == [0]
    assert arrivals.states[0].modulation.covers == ()
    scene.show(1)
    assert arrivals.sync(scene, page_bytes, None)
    assert sorted(drawn(arrivals)) == [0, 1, 2]


def test_modulation_is_worked_out_anew_only_when_the_tree_changes(arrivals, monkeypatch):
    asked = []

    def counted(scene, index):
        asked.append(index)
        return modulation(scene, index)

    monkeypatch.setattr(module, "modulation", counted)
    scene = small_scene(2)
    camera = scene[1].camera.zoomed_to_region(0.5, 0.5, 8.0)
    scene.append(small_level(scene, 1, camera, 40, 7))
    arrivals.sync(scene, None, None)
    assert asked == [0, 1, 2]
    for seed in range(3):  # a level in the making, as it comes over the wire: equal, not the same
        again = small_level(scene, 1, replace(camera, camera_from_world=np.eye(4)), 40, seed)
        scene.replace(replace(again, index=2))
        arrivals.sync(scene, None, None)
        assert drawn(arrivals)[2] is scene[2]
    assert asked == [0, 1, 2]
    scene.replace(replace(scene[2], camera=camera.zoomed(3.0, 4.0, 1.1)))
    arrivals.sync(scene, None, None)
    assert asked == [0, 1, 2] * 2
    fresh = Arrivals(Pages())
    fresh.sync(scene, None, None)
    for index, state in arrivals.states.items():
        expected = fresh.states[index].modulation.texels()
        np.testing.assert_array_equal(state.modulation.texels(), expected)


class NoMerges:
    """Merged forms that never come."""

    def collect(self, num_levels):
        pass

    def ask(self, level, cells_px=None):
        pass

    def forms(self, level):
        return ()


class SomeMerges(NoMerges):
    def __init__(self, forms):
        self._forms = forms

    def forms(self, level):
        return self._forms if level.index == 1 else ()


class PreviewMerges(NoMerges):
    """Merges one preview, and nothing else."""

    def __init__(self, preview, form):
        self._preview, self._form, self.asked = preview, form, []

    def ask(self, level, cells_px=None):
        self.asked.append((level.surfels, cells_px))

    def forms(self, level):
        return (self._form,) if level.surfels is self._preview else ()


def preview_of(scene, prompt=""):
    level = small_level(scene, 0, scene[0].camera.zoomed_to_region(0.5, 0.5, 4.0), 30, 2)
    return replace(level, prompt=prompt)


def in_the_making(scene, num, seed):
    level = scene[1]
    return replace(level, surfels=random_surfels(num, seed))


def test_a_preview_stands_in_for_merged_forms_until_they_come(arrivals):
    scene = one_level(1)
    scene.commit(0)
    scene.append(preview_of(scene))
    preview = scene[1].surfels
    assert arrivals.sync(scene, None, NoMerges())
    assert [len(state.sets) for state in arrivals.states.values()] == [1, 1]
    for seed in (3, 4):  # revisions; the last one is committed
        scene.replace(in_the_making(scene, 120, seed))
        arrivals.sync(scene, None, NoMerges())
        arrivals.sync(scene, None, NoMerges())
        exact, coarse = arrivals.states[1].sets
        assert exact.surfels is scene[1].surfels
        assert coarse.surfels is preview
        assert coarse.cell_px == 2
    scene.commit(1)
    forms = (random_surfels(31, 5), random_surfels(9, 6))
    for _ in range(3):
        arrivals.sync(scene, None, SomeMerges(forms))
    assert [s.surfels for s in arrivals.states[1].sets] == [scene[1].surfels, *forms]


def test_a_preview_is_merged_for_a_camera_that_moves(arrivals):
    scene = one_level(1)
    scene.commit(0)
    scene.append(preview_of(scene))
    preview, quarter = scene[1].surfels, random_surfels(8, 7)
    merges = PreviewMerges(preview, quarter)
    for _ in range(2):
        arrivals.sync(scene, None, merges)
    assert (preview, (4,)) in merges.asked
    shown = [(s.surfels, s.cell_px) for s in arrivals.states[1].sets]
    assert shown == [(preview, 1), (preview, 2), (quarter, 4)]
    scene.replace(in_the_making(scene, 120, 3))
    arrivals.sync(scene, None, merges)
    assert [s.surfels for s in arrivals.states[1].sets] == [scene[1].surfels, preview, quarter]


def test_what_was_asked_for_is_in_the_preview_that_stands_in(arrivals):
    scene = one_level(1)
    scene.append(preview_of(scene, "a ladybug"))
    arrivals.sync(scene, None, NoMerges())
    scene.replace(in_the_making(scene, 34, 3))  # the preview with the ladybug
    edited = scene[1].surfels
    arrivals.sync(scene, None, NoMerges())
    scene.replace(in_the_making(scene, 120, 4))
    arrivals.sync(scene, None, NoMerges())
    assert [s.surfels for s in arrivals.states[1].sets] == [scene[1].surfels, edited]


def test_no_frame_draws_all_of_a_revision_while_its_preview_comes_back(arrivals, page_bytes):
    scene = one_level(1)
    scene.commit(0)
    scene.append(preview_of(scene))  # two pages
    for _ in range(6):
        arrivals.sync(scene, page_bytes, NoMerges())
    scene.replace(in_the_making(scene, 120, 3))
    scene.commit(1)
    seen = set()
    for _ in range(12):  # a page in each: the revision's come first
        arrivals.sync(scene, page_bytes, NoMerges())
        shown = arrivals.states[1].sets
        seen.add((shown[0].surfels is scene[1].surfels, len(shown)))
    assert seen == {(False, 1), (True, 2)}


def test_no_preview_stands_in_where_it_is_no_smaller_or_was_never_seen(arrivals):
    scene = one_level(1)
    scene.commit(0)
    scene.append(preview_of(scene))
    arrivals.sync(scene, None, NoMerges())
    scene.replace(in_the_making(scene, 50, 3))
    for _ in range(3):
        arrivals.sync(scene, None, NoMerges())
    assert len(arrivals.states[1].sets) == 1
    asked = one_level(1)
    asked.append(preview_of(asked, "a ladybug"))  # of which the preview shows nothing
    arrivals.sync(asked, None, NoMerges())
    asked.replace(in_the_making(asked, 120, 3))
    for _ in range(3):
        arrivals.sync(asked, None, NoMerges())
    assert len(arrivals.states[1].sets) == 1
    loaded = small_scene(2)
    for _ in range(3):
        arrivals.sync(loaded, None, NoMerges())
    assert [len(state.sets) for state in arrivals.states.values()] == [1, 1]
