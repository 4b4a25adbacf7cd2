"""Marks of levels, in memory and in manifests."""

import json

import pytest

from tests.app.fakes import make_scene
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.marks import UNMARKED, Mark, clean_name, marks_from_json, marks_to_json


def test_marks_round_trip_and_older_readers_hide_what_is_removed():
    marks = {1: Mark("hidden"), 2: Mark("removed", "wing"), 4: Mark("shown", "leg")}
    record = json.loads(json.dumps(marks_to_json(marks)))
    assert record == {"hidden": [1, 2], "removed": [2], "names": {"2": "wing", "4": "leg"}}
    assert marks_from_json(record, 5) == marks
    assert marks_to_json({}) == {"hidden": []}


@pytest.mark.parametrize(
    "record",
    [
        {},
        {"hidden": "all", "removed": {}, "names": []},
        {"hidden": [0, -1, 9, True, "1", None, 1.0], "removed": [[2]]},
        {"names": {"9": "far", "x": "y", "-1": "a", "1": 5, "2": "\n", "١": "digit"}},
    ],
)
def test_what_is_malformed_is_left_out(record):
    assert marks_from_json(record, 3) == {}


def test_the_photo_is_always_shown_and_may_have_a_name():
    assert marks_from_json({"hidden": [0], "names": {"0": "home"}}, 2) == {0: Mark("shown", "home")}


def test_names_are_one_clean_line():
    assert clean_name(" a\tb\x00c \n") == "a b c"
    assert len(clean_name("ä" * 500)) == 80


def test_a_scene_keeps_marks_and_forgets_those_of_a_dropped_level():
    scene = make_scene(3)
    before = scene.revision
    scene.set_mark(2, Mark("removed", "x"))
    assert scene.revision > before
    assert scene.hidden == {2}
    scene.show(2)
    assert scene.mark(2) == Mark("shown", "x")
    scene.set_mark(2, UNMARKED)
    assert scene.marks == {}


def test_marks_are_in_the_file_and_fields_of_later_versions_too(tmp_path):
    scene = make_scene(3)
    scene.set_mark(1, Mark("shown", "wing"))
    scene.set_mark(2, Mark("removed"))
    scene.unknown_fields = {"stars": {"1": 5}}
    save_scene(scene, tmp_path / "s.wz")
    loaded = load_scene(tmp_path / "s.wz")
    assert loaded.marks == scene.marks
    assert loaded.unknown_fields == scene.unknown_fields
