"""Camera paths as JSON: ours come back exactly, nerfstudio's are understood, hostile ones are refused."""

import json
import math

import numpy as np
import pytest

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.keyframes import Key, KeyPath, KeyTrack
from wzviewer.core.path_files import (
    MAX_PATH_BYTES,
    OWN,
    facing,
    fov_deg,
    path_of,
    path_record,
    read_path_file,
    world_from_gl,
    write_path,
)
from wzviewer.core.records import camera_to_json
from wzviewer.errors import InputError

SIZE = (320, 212)


def deep(depth, x=0.4, y=0.6):
    camera = Camera.initial(*SIZE)
    for _ in range(depth):
        camera = camera.zoomed_to_region(x, y, 8.0)
    return camera


def a_path(depth=4):
    near = deep(depth)
    focus = near.unproject(160.0, 106.0, 1.3)
    turned = navigation.orbited(near, focus, 0.2, 0.1)
    keys = (Key(deep(0), focus, 3.0), Key(near, focus, 0.5, "stop"), Key(turned, focus, 1.25, "corner"))
    return KeyPath(keys, is_loop=True)


def record(depth=4, fps=24.0):
    path = a_path(depth)
    frames = KeyTrack(path, SIZE).cameras(fps)
    return json.loads(json.dumps(path_record(path, frames, fps))), path, frames


def bare(text):
    """Without our own fields: what nerfstudio would keep."""
    for entry in text["camera_path"] + text["keyframes"]:
        entry.pop(OWN, None)
    return text


@pytest.mark.parametrize("depth", [1, 4, 12])
def test_what_is_written_is_read_exactly(tmp_path, depth):
    _, path, frames = record(depth)
    write_path(tmp_path / "p.json", path, frames, 24.0)
    found = read_path_file(tmp_path / "p.json")
    assert [c.key for c in found.frames] == [c.key for c in frames]
    assert found.fps == 24.0
    assert found.size == SIZE
    assert found.keys.is_loop
    for key, was in zip(found.keys.keys, path.keys, strict=True):
        assert key.camera.key == was.camera.key
        assert np.array_equal(key.focus, was.focus)
        assert (key.seconds, key.pace) == (was.seconds, was.pace)


def test_the_layout_is_nerfstudios():
    text, _, frames = record()
    assert text["camera_type"] == "perspective"
    assert (text["render_width"], text["render_height"], text["fps"]) == (*SIZE, 24.0)
    assert text["seconds"] == pytest.approx(4.75)
    entry = text["camera_path"][0]
    matrix = np.array(entry["camera_to_world"]).reshape(4, 4)
    # C_0 looks along +z with y down; OpenGL's camera looks along -z with y up.
    assert np.array_equal(matrix, np.diag([1.0, -1.0, -1.0, 1.0]))
    assert entry["fov"] == pytest.approx(math.degrees(2 * math.atan(SIZE[1] / 2 / frames[0].fy)))
    assert entry["aspect"] == pytest.approx(SIZE[0] / SIZE[1])
    assert text["keyframes"][1]["override_transition_sec"] == 3.0  # the time before it


NEAR = [(1, 1e-9, 2.0), (4, 1e-6, 1.5), (12, 5e-2, 1.5)]


@pytest.mark.parametrize(("depth", "centre_px", "corner_px"), NEAR)
def test_without_our_fields_the_centre_is_exact_and_the_corners_are_close(depth, centre_px, corner_px):
    """Measured 3e-14, 4e-10 and 5e-3 px at the centre; 1.2, 1.0 and 1.0 px at the corners, of 320 px."""
    text, path, _ = record(depth)
    found = path_of(bare(text))
    camera, exact = found.keys.keys[1].camera, path.keys[1].camera
    for x, y, limit in ((160.0, 106.0, centre_px), (0.0, 0.0, corner_px), (320.0, 212.0, corner_px)):
        point = exact.unproject(x, y, 1.3)
        assert np.abs(camera.project(point)[:2] - [x, y]).max() < limit
    assert found.keys.keys[0].seconds == 3.0


def test_what_another_program_edited_counts():
    text, _, _ = record(1)
    text["camera_path"][0]["camera_to_world"][3] += 0.25
    text["camera_path"][1]["fov"] *= 1.01
    found = path_of(text)
    assert found.frames[0].position[0] == pytest.approx(0.25)
    assert fov_deg(found.frames[1]) == pytest.approx(text["camera_path"][1]["fov"])


def test_keys_of_older_files_are_columns_in_a_text():
    camera = facing(deep(1))
    columns = json.dumps(world_from_gl(camera).T.ravel().tolist())
    entry = {"matrix": columns, "fov": fov_deg(camera), "aspect": 1.5, "properties": "[]"}
    found = path_of({"keyframes": [entry, entry, entry], "seconds": 6, "fps": 30})
    assert [key.seconds for key in found.keys.keys] == [3.0, 3.0, 3.0]
    assert np.allclose(found.keys.keys[0].camera.camera_from_world, camera.camera_from_world)
    assert not found.frames


def test_a_list_of_exact_cameras_is_read_as_before(tmp_path):
    camera = deep(3)
    (tmp_path / "p.json").write_text(json.dumps({"frames": [camera_to_json(camera)] * 5}))
    found = read_path_file(tmp_path / "p.json")
    assert [c.key for c in found.frames] == [camera.key] * 5
    assert found.fps is None


ENTRY = {"camera_to_world": np.eye(4).ravel().tolist(), "fov": 50.0, "aspect": 1.5}


EXACT = camera_to_json(Camera.initial(*SIZE))


def with_entry(**changes):
    return json.dumps({"camera_path": [{**ENTRY, **changes}]})


HOSTILE = {
    "empty": "",
    "no JSON": "{",
    "a list": "[]",
    "nothing in it": "{}",
    "bytes": b"\xff\xfe\x00",
    "deep": "[" * 100_000,
    "no frames": '{"frames": []}',
    "frames no list": '{"frames": {"0": 1}}',
    "frame no object": '{"frames": [3]}',
    "fisheye": json.dumps({"camera_type": "fisheye", "camera_path": [ENTRY]}),
    "entry no object": '{"camera_path": [7]}',
    "no matrix": '{"camera_path": [{"fov": 50}]}',
    "fifteen numbers": with_entry(camera_to_world=[0.0] * 15),
    "not rigid": with_entry(camera_to_world=(2 * np.eye(4)).ravel().tolist()),
    "mirrored": with_entry(camera_to_world=np.diag([-1.0, 1, 1, 1]).ravel().tolist()),
    "infinite": with_entry(camera_to_world=[*np.eye(4).ravel().tolist()[:3], 1e999, *([0.0] * 12)]),
    "far away": with_entry(camera_to_world=[1, 0, 0, 1e300, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
    "no number": with_entry(fov="wide"),
    "flat": with_entry(fov=180.0),
    "no angle": with_entry(fov=0.0),
    "no angle at all": with_entry(fov=5e-324),
    "nan": '{"camera_path": [{"camera_to_world": [NaN], "fov": NaN}]}',
    "huge integer": with_entry(fov=10**400),
    "huge integer in a matrix": with_entry(camera_to_world=[10**400] * 16),
    "huge picture": json.dumps({"render_width": 10**9, "camera_path": [ENTRY]}),
    "fps": json.dumps({"fps": 0, "camera_path": [ENTRY]}),
    "too many keys": json.dumps({"keyframes": [{}] * 5000, "camera_path": [ENTRY]}),
    "text matrix": json.dumps({"keyframes": [{"matrix": "[1,", "fov": 50}]}),
    "zoomed beyond all": json.dumps({"frames": [{**EXACT, "fx": 1e300, "fy": 1e300}]}),
    "squeezed": json.dumps({"frames": [{**EXACT, "fx": 1e9}]}),
    "shifted beyond all": json.dumps({"frames": [{**EXACT, "cx": 1e200}]}),
    "exact camera broken": with_entry(wzviewer={"camera": {"fx": "x"}}),
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_files_are_refused_in_a_line(tmp_path, text):
    path = tmp_path / "p.json"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as refusal:
        read_path_file(path)
    assert str(path) in refusal.value.line()
    assert len(refusal.value.line()) < len(str(path)) + 200
    assert "\n" not in refusal.value.line()


def test_whatever_is_accepted_can_be_played():
    """Keys anywhere, of any zoom, looking anywhere: every camera between them is finite."""
    rng = np.random.default_rng(0)
    for _ in range(60):
        keys = []
        for _ in range(4):
            camera = Camera.initial(*SIZE)
            pivot = rng.normal((0.0, 0.0, 2.0), 1.0)
            camera = navigation.orbited(camera, pivot, *rng.normal(0, 2, 2))
            camera = camera.zoomed(*rng.uniform(0, 200, 2), 10.0 ** rng.uniform(-3, 11))
            entry = {"matrix": world_from_gl(facing(camera)).ravel().tolist(), "fov": fov_deg(facing(camera))}
            entry[OWN] = {"camera": camera_to_json(camera), "focus": (10.0 ** rng.uniform(-9, 8, 3)).tolist()}
            entry |= {"override_transition_enabled": True, "override_transition_sec": rng.uniform(0, 3)}
            keys.append(entry)
        path = path_of({"keyframes": keys, "is_cycle": bool(rng.integers(2))}).keys
        for camera in KeyTrack(path, (64, 48)).cameras(4.0):
            numbers = [*camera.camera_from_world.ravel(), camera.fx, camera.fy, camera.cx, camera.cy]
            assert np.isfinite(numbers).all()
            assert camera.fx > 0


def test_missing_and_enormous_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_path_file(tmp_path / "none.json")
    with open(tmp_path / "big.json", "wb") as file:
        file.truncate(MAX_PATH_BYTES + 1)
    with pytest.raises(InputError, match="too large"):
        read_path_file(tmp_path / "big.json")
