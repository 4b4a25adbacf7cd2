"""Camera paths as JSON, in the layout that nerfstudio's viewer writes, and back.

::

    {"camera_type": "perspective", "render_width", "render_height", "fps", "seconds", "is_cycle", ...
     "keyframes":   [{"matrix": 16 numbers, "fov", "aspect", "override_transition_sec", "wzviewer": ...}]
     "camera_path": [{"camera_to_world": 16 numbers, "fov", "aspect", "wzviewer": ...}]}

Matrices are row-major, world from camera with OpenGL's axes (x right, y up, z backwards); ``fov`` is
vertical, in degrees.  ``override_transition_sec`` is the time before its key, as in nerfstudio.

That layout has no principal point, which a zoom off the centre moves far outside the picture.  So each
entry is the camera turned towards the picture's centre, of the same magnification there, and has the
exact camera beside it under ``wzviewer``.  It counts as long as the rest of the entry is what was
written with it; what another program has edited counts otherwise.  Read without it, a view is exact
at its centre (0.001 px at x8^12, where float64 ends; nerfstudio itself reads float32, good to about
x100) and off by the keystone of the turn at its corners (4 px of 1088 on the demo's zooms).

Also read: ``{"frames": [CAMERA, ...]}`` of exact cameras.  Nothing in a file is trusted.
"""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.keyframes import MAX_KEYS, NEAREST, SECONDS_LIMIT, Key, KeyPath, Pace
from wzviewer.core.photos import whole_file
from wzviewer.core.records import MAX_SIDE_PX, Json, camera_from_json, camera_to_json
from wzviewer.core.types import DoubleArray
from wzviewer.errors import InputError

OWN = "wzviewer"
MAX_PATH_BYTES = 64 << 20
MAX_FRAMES = 100_000
MAX_FPS = 240.0
FARTHEST = 1e9  # world units
FARTHEST_ZOOM = 1e14  # focal length over width; x8^13.5 of a photo is 2e12
FARTHEST_OFF = 1e4  # tangent of the angle between the lens and the picture's centre
RIGID = 1e-3  # float32 and six printed digits are allowed for
UNEDITED = 1e-9
SMALLEST_FOV_DEG = 1e-13  # x8^15
KEY_SECONDS = 2.0
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # OpenCV's axes from OpenGL's
PACES: tuple[Pace, ...] = ("flow", "stop", "corner")
FAULTS = (ValueError, KeyError, TypeError, AttributeError, RecursionError, OverflowError)


@dataclass(frozen=True, eq=False)
class PathFile:
    """What a file says.

    Attributes:
        frames: camera of every frame; empty when there are only keys.
        keys: the keyframes, perhaps none.
        size: width and height of the film, px; None when it does not say.
        fps: frames per second; None when it does not say.
    """

    frames: list[Camera] = field(default_factory=list)
    keys: KeyPath = field(default_factory=KeyPath)
    size: tuple[int, int] | None = None
    fps: float | None = None


# ------------------------------------------------------------------ writing


def write_path(path: Path, keys: KeyPath, frames: list[Camera], fps: float) -> None:
    """Writes a camera path, whole or not at all.

    Args:
        path: of the file.
        keys: that the frames go through; may be empty.
        frames: of one size, at least one.
        fps: frames per second.

    Raises:
        OutputError: when it cannot be written.
    """
    text = json.dumps(path_record(keys, frames, fps), separators=(",", ":"), allow_nan=False)
    with whole_file(path) as file:
        file.write(text.encode())


def path_record(keys: KeyPath, frames: list[Camera], fps: float) -> Json:
    """Returns a camera path in nerfstudio's layout."""
    first = frames[0]
    entries = {id(camera): _entry(camera, "camera_to_world") for camera in frames}  # a rest is one object
    return {
        "default_fov": fov_deg(first),
        "default_transition_sec": KEY_SECONDS,
        "keyframes": keys_record(keys),
        "camera_type": "perspective",
        "render_height": first.height,
        "render_width": first.width,
        "fps": fps,
        "seconds": len(frames) / fps,
        "is_cycle": keys.is_loop,
        "smoothness_value": 0.0,
        "camera_path": [entries[id(camera)] for camera in frames],
    }


def keys_record(path: KeyPath) -> list[Json]:
    """Returns keyframes in nerfstudio's layout."""
    records = []
    for before, key in zip((path.keys[-1:] + path.keys)[:-1], path.keys, strict=True):
        record = _entry(key.camera, "matrix")
        record[OWN] |= {"focus": key.focus.tolist(), "seconds": key.seconds, "pace": key.pace}
        record |= {"override_transition_enabled": True, "override_transition_sec": before.seconds}
        records.append(record)
    return records


def _entry(camera: Camera, matrix_key: str) -> Json:
    centred = facing(camera)
    return {
        matrix_key: world_from_gl(centred).ravel().tolist(),
        "fov": fov_deg(centred),
        "aspect": camera.width / camera.height,
        OWN: {"camera": camera_to_json(camera)},
    }


def facing(camera: Camera) -> Camera:
    """Returns the camera without a shifted lens that sees the same at the picture's centre.

    A shifted lens stretches: at an angle a off its axis a pixel is 1/cos(a)^2 of an axial one along the
    shift and 1/cos(a) across it, so the focal length is taken over cos(a)^1.5.
    """
    x, y = camera.width / 2, camera.height / 2
    ray = np.array([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0])
    length = float(np.linalg.norm(ray))
    turn = np.cross(ray / length, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(turn))
    turn = turn * (math.asin(min(sine, 1.0)) / sine) if sine > 0.0 else turn
    rotation = (
        navigation.turned_rotation(np.eye(3), turn) @ camera.rotation if sine > 0.0 else camera.rotation
    )
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = -rotation @ camera.position if sine > 0.0 else camera.camera_from_world[:3, 3]
    focal = camera.focal_px * length**1.5
    return Camera(pose, focal, focal, x, y, camera.width, camera.height)


def world_from_gl(camera: Camera) -> DoubleArray:
    """Returns world from camera (4, 4) with OpenGL's axes."""
    matrix = np.eye(4)
    matrix[:3, :3] = camera.rotation.T
    matrix[:3, 3] = camera.position
    return matrix @ FLIP


def fov_deg(camera: Camera) -> float:
    """Vertical field of view."""
    return math.degrees(2.0 * math.atan(camera.height / 2 / camera.fy))


# ------------------------------------------------------------------ reading


def read_path_file(path: Path) -> PathFile:
    """Reads a camera path.

    Raises:
        InputError: when it is missing, too large or malformed.
    """
    try:
        if path.stat().st_size > MAX_PATH_BYTES:
            raise InputError(str(path), f"is too large for a camera path: over {MAX_PATH_BYTES >> 20} MiB")
        record = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(str(path), (error.strerror or str(error)).lower()) from error
    except FAULTS as error:
        raise InputError(str(path), f"is not JSON ({_brief(error)})") from error
    try:
        return path_of(record)
    except FAULTS as error:
        raise InputError(str(path), f"is not a camera path ({_brief(error)})") from error


def path_of(record: Any) -> PathFile:  # noqa: ANN401 - JSON from a stranger
    """Returns what a record says.

    Raises:
        ValueError, KeyError, TypeError, OverflowError: when it is malformed.
    """
    if not isinstance(record, dict):
        raise ValueError("it is no object")
    if "frames" in record:
        frames = _listed(record, "frames", MAX_FRAMES)
        fps = _number(record["fps"], "fps", 0.1, MAX_FPS) if "fps" in record else None
        return PathFile([_exact(frame) for frame in frames], fps=fps)
    if record.get("camera_type", "perspective") != "perspective":
        raise ValueError(f"camera_type {str(record['camera_type'])[:40]!r}: only perspective is known")
    size = tuple(
        _whole(record.get(k, default), k) for k, default in (("render_width", 1920), ("render_height", 1080))
    )
    fps = _number(record.get("fps", 24), "fps", 0.1, MAX_FPS)
    frames = [
        _camera(entry, "camera_to_world", size) for entry in _listed(record, "camera_path", MAX_FRAMES, 0)
    ]
    keys = keys_of(record, size)
    if not frames and not keys.keys:
        raise ValueError("it has neither camera_path nor keyframes")
    return PathFile(frames, keys, (size[0], size[1]), fps)


def keys_of(record: Json, size: tuple[int, ...]) -> KeyPath:
    """Returns the keyframes of a record.

    Raises:
        ValueError, KeyError, TypeError, OverflowError: when they are malformed.
    """
    entries = _listed(record, "keyframes", MAX_KEYS, 0)
    is_loop = bool(record.get("is_cycle", False))
    cameras = [_camera(entry, "matrix", size) for entry in entries]
    waits = [_seconds_before(entry, record, len(entries)) for entry in entries]
    keys = [
        Key(camera, _focus(entry, camera), wait, _pace(entry))
        for entry, camera, wait in zip(entries, cameras, waits[1:] + waits[:1], strict=True)
    ]
    return KeyPath(tuple(keys), is_loop)


def _seconds_before(entry: Json, record: Json, count: int) -> float:
    """Time before a key; older files only know the whole, which is split evenly."""
    if entry.get("override_transition_enabled") and entry.get("override_transition_sec") is not None:
        seconds = _number(entry["override_transition_sec"], "override_transition_sec", 0.0, 1e4)
    elif "default_transition_sec" in record:
        seconds = _number(record["default_transition_sec"], "default_transition_sec", 0.0, 1e4)
    else:
        seconds = _number(record.get("seconds", KEY_SECONDS * count), "seconds", 0.0, 1e6) / max(count - 1, 1)
    return min(max(seconds, SECONDS_LIMIT[0]), SECONDS_LIMIT[1])


def _focus(entry: Json, camera: Camera) -> DoubleArray:
    own = entry.get(OWN)
    if isinstance(own, dict) and "focus" in own:
        focus = np.array(own["focus"], np.float64)
        if focus.shape == (3,) and np.abs(focus).max() <= FARTHEST and camera.to_camera(focus)[2] > NEAREST:
            return focus
    return camera.unproject(camera.width / 2, camera.height / 2, 1.0)  # the median depth of the photo


def _pace(entry: Json) -> Pace:
    own = entry.get(OWN)
    wanted = own.get("pace") if isinstance(own, dict) else None
    return next((pace for pace in PACES if pace == wanted), "flow")


def _camera(entry: Any, matrix_key: str, size: tuple[int, ...]) -> Camera:  # noqa: ANN401
    """The camera of an entry: the exact one, unless the rest was edited."""
    if not isinstance(entry, dict):
        raise ValueError(f"an entry with {matrix_key} is no object")
    centred = _centred(entry, matrix_key, size)
    own = entry.get(OWN)
    if isinstance(own, dict) and "camera" in own:
        exact = _exact(own["camera"])
        written = facing(exact)
        is_same = np.abs(world_from_gl(written) - world_from_gl(centred)).max() <= UNEDITED
        if is_same and abs(fov_deg(written) / float(entry["fov"]) - 1.0) <= UNEDITED:
            return exact
    return centred


def _exact(record: Json) -> Camera:
    """A camera of ours, within what the deepest zoom can have."""
    camera = camera_from_json(record)
    zoom = camera.focal_px / camera.width
    if not 1.0 / FARTHEST_ZOOM <= zoom <= FARTHEST_ZOOM or not 0.1 <= camera.fy / camera.fx <= 10.0:
        raise ValueError("the focal length is out of range")
    off = max(abs(camera.cx) / camera.fx, abs(camera.cy) / camera.fy)
    if off > FARTHEST_OFF or np.abs(camera.camera_from_world).max() > FARTHEST:
        raise ValueError("the camera is out of range")
    return camera


def _centred(entry: Json, matrix_key: str, size: tuple[int, ...]) -> Camera:
    numbers = entry[matrix_key]
    is_old = isinstance(numbers, str)  # three.js: JSON in a text, column after column
    matrix = np.array(json.loads(numbers[:4000]) if is_old else numbers, np.float64)
    if matrix.size != 16:
        raise ValueError(f"{matrix_key} has not 16 numbers")
    matrix = matrix.reshape(4, 4).T if is_old else matrix.reshape(4, 4)
    if not np.isfinite(matrix).all() or np.abs(matrix).max() > FARTHEST:
        raise ValueError(f"{matrix_key} is not finite")
    if not np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=RIGID):
        raise ValueError(f"{matrix_key} is not rigid")
    if np.linalg.det(matrix[:3, :3]) < 0 or np.abs(matrix[3] - [0, 0, 0, 1]).max() > RIGID:
        raise ValueError(f"{matrix_key} is not rigid")
    fov = _number(entry["fov"], "fov", SMALLEST_FOV_DEG, 179.0)
    return _pinhole(matrix, math.radians(fov), size)


def _pinhole(world_from_camera: DoubleArray, fov_rad: float, size: tuple[int, ...]) -> Camera:
    matrix = world_from_camera @ FLIP
    rotation = matrix[:3, :3].T
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > UNEDITED:
        rotation = navigation.turned_rotation(rotation, np.zeros(3))
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = -rotation @ matrix[:3, 3]
    width, height = size
    focal = height / 2 / math.tan(fov_rad / 2)
    return Camera(pose, focal, focal, width / 2, height / 2, width, height)


def _listed(record: Json, key: str, most: int, least: int = 1) -> list[Any]:
    found = record.get(key, [])
    if not isinstance(found, list) or not least <= len(found) <= most:
        many = len(found) if isinstance(found, list) else "no list of"
        raise ValueError(f"{key}: {many} entries, {least} to {most} are read")
    return found


def _number(value: Any, name: str, low: float, high: float) -> float:  # noqa: ANN401
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} is not a number")
    if not low <= float(value) <= high:
        raise ValueError(f"{name} is not between {low:g} and {high:g}")
    return float(value)


def _whole(value: Any, name: str) -> int:  # noqa: ANN401
    return round(_number(value, name, 1, MAX_SIDE_PX))


def _brief(error: BaseException) -> str:
    text = f"{error.args[0]} is missing" if isinstance(error, KeyError) else " ".join(str(error).split())
    return text[:117] + "..." if len(text) > 120 else text
