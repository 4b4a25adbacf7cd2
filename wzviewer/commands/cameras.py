"""Cameras for pictures and films: level, magnification, orbit, and paths."""

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.records import camera_from_json
from wzviewer.core.scene import Scene
from wzviewer.core.types import DoubleArray
from wzviewer.errors import InputError

FPS = 24
SECONDS_PER_LEVEL = 2.0
HOLD_SECONDS = 0.8  # at every level, to look around
ORBIT_SECONDS = 4.0
ORBIT_DEG = 8.0
MAX_PATH_BYTES = 64 << 20
MAX_FRAMES = 100_000


def level_index(scene: Scene, level: int | None) -> int:
    """Returns a level that exists; the last visible one by default.

    Raises:
        InputError: when there is no such level.
    """
    if level is None:
        return scene.visible()[-1]
    if not 0 <= level < len(scene):
        raise InputError(f"--level {level}", f"the scene has levels 0 to {len(scene) - 1}")
    return level


def camera_of(scene: Scene, level: int, magnify: float = 1.0, orbit_deg: float = 0.0) -> Camera:
    """C_K, magnified about its centre and turned about the anchor of its level.

    Raises:
        InputError: when the magnification or the angle is out of range.
    """
    if not 1e-6 <= magnify <= 1e6:
        raise InputError(f"--magnify {magnify:g}", "must be between 1e-6 and 1e6")
    if not -180.0 <= orbit_deg <= 180.0:
        raise InputError(f"--orbit {orbit_deg:g}", "must be between -180 and 180 degrees")
    camera = scene[level].camera
    camera = camera.zoomed(camera.width / 2, camera.height / 2, magnify)
    return orbited(camera, scene[level].frame.origin, orbit_deg)


def orbited(camera: Camera, pivot: DoubleArray, yaw_deg: float) -> Camera:
    """Turns the view about a world point, which keeps its pixel and its depth."""
    return camera if yaw_deg == 0.0 else navigation.orbited(camera, pivot, float(np.deg2rad(yaw_deg)), 0.0)


def zoom_path(scene: Scene, level: int) -> list[Camera]:
    """From C_0 through every level's camera to C_K: even in log focal length, resting at each."""
    stops = [scene[i] for i in scene.path(level)]
    hold = round(HOLD_SECONDS * FPS)
    path = [stops[0].camera] * hold
    for a, b in pairwise(stops):
        steps = _eased(round(SECONDS_PER_LEVEL * FPS))
        path += [navigation.interpolated(a.camera, b.camera, b.frame.origin, t) for t in steps]
        path += [b.camera] * hold
    return path


def orbit_path(scene: Scene, level: int, magnify: float = 1.0) -> list[Camera]:
    """A gentle swing to both sides of C_K and back."""
    camera = camera_of(scene, level, magnify)
    phases = np.linspace(0.0, 2.0 * np.pi, round(ORBIT_SECONDS * FPS), endpoint=False)
    return [orbited(camera, scene[level].frame.origin, ORBIT_DEG * np.sin(p)) for p in phases]


def _eased(count: int) -> Iterator[float]:
    for t in np.linspace(0.0, 1.0, count + 1)[1:]:
        yield float(t * t * (3.0 - 2.0 * t))


def parse_camera(text: str) -> Camera:
    """Parses one camera of JSON.

    Raises:
        InputError: when it is malformed.
    """
    try:
        return camera_from_json(json.loads(text))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(
            "--camera", f"is not a camera ({error})", "The app's Copy view gives one."
        ) from error


def read_path(path: Path) -> list[Camera]:
    """Reads ``{"frames": [CAMERA, ...]}``.

    Raises:
        InputError: when it is missing or malformed.
    """
    try:
        if path.stat().st_size > MAX_PATH_BYTES:
            raise InputError(str(path), "is too large for a camera path")
        frames = json.loads(path.read_text("utf-8"))["frames"]
        if not 0 < len(frames) <= MAX_FRAMES:
            raise InputError(str(path), f"has {len(frames)} frames", f"At most {MAX_FRAMES}.")
        return [camera_from_json(frame) for frame in frames]
    except OSError as error:
        raise InputError(str(path), (error.strerror or str(error)).lower()) from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(str(path), f"is not a camera path ({error})") from error
