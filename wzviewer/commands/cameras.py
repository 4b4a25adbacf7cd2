"""Cameras for pictures and films: level, magnification, orbit, and paths."""

import json
from itertools import pairwise

import numpy as np

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.foreground import turning_point
from wzviewer.core.keyframes import KeyTrack
from wzviewer.core.path_files import MAX_FRAMES, PathFile
from wzviewer.core.records import camera_from_json
from wzviewer.core.scene import Level, Scene
from wzviewer.core.types import DoubleArray
from wzviewer.errors import InputError

FPS = 24
SECONDS_PER_LEVEL = 2.0
HOLD_SECONDS = 0.8  # at every level, to look around
ORBIT_SECONDS = 4.0
ORBIT_DEG = 8.0


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
    """C_K, magnified about its centre and turned about the anchor of its level (see `turning_point`).

    Raises:
        InputError: when the magnification or the angle is out of range.
    """
    if not 1e-6 <= magnify <= 1e6:
        raise InputError(f"--magnify {magnify:g}", "must be between 1e-6 and 1e6")
    if not -180.0 <= orbit_deg <= 180.0:
        raise InputError(f"--orbit {orbit_deg:g}", "must be between -180 and 180 degrees")
    camera = scene[level].camera
    camera = camera.zoomed(camera.width / 2, camera.height / 2, magnify)
    return orbited(camera, turning_point(scene, camera, scene[level].frame.origin), orbit_deg)


def orbited(camera: Camera, pivot: DoubleArray, yaw_deg: float) -> Camera:
    """Turns the view about a world point, which keeps its pixel and its depth."""
    return camera if yaw_deg == 0.0 else navigation.orbited(camera, pivot, float(np.deg2rad(yaw_deg)), 0.0)


def zoom_path(scene: Scene, level: int, fps: float = FPS, duration_s: float | None = None) -> list[Camera]:
    """From C_0 through every level's camera to C_K: even in log focal length, resting at each.

    Args:
        scene: with the cameras.
        level: K.
        fps: frames per second.
        duration_s: of the film; by default 2 s a level and 0.8 s of rest at each.
    """
    stops = [scene[i] for i in scene.path(level)]
    legs = list(pairwise(stops))
    natural_s = HOLD_SECONDS + (HOLD_SECONDS + SECONDS_PER_LEVEL) * len(legs)
    count = max(round((duration_s or natural_s) * fps), 1)
    return [_zoom_at(stops, legs, natural_s * i / count) for i in range(count)]


def _zoom_at(stops: list[Level], legs: list[tuple[Level, Level]], time_s: float) -> Camera:
    """The camera of a moment: a rest at every stop, and a leg after it."""
    index, left_s = divmod(time_s, HOLD_SECONDS + SECONDS_PER_LEVEL)
    share = (left_s - HOLD_SECONDS) / SECONDS_PER_LEVEL
    if share <= 0.0 or int(index) >= len(legs):
        return stops[min(int(index), len(legs))].camera
    a, b = legs[int(index)]
    return navigation.interpolated(a.camera, b.camera, b.frame.origin, share * share * (3.0 - 2.0 * share))


def orbit_path(
    scene: Scene,
    level: int,
    magnify: float = 1.0,
    angle_deg: float = ORBIT_DEG,
    fps: float = FPS,
    duration_s: float = ORBIT_SECONDS,
) -> list[Camera]:
    """A gentle swing to both sides of C_K and back."""
    camera = camera_of(scene, level, magnify)
    pivot = turning_point(scene, camera, scene[level].frame.origin)
    return swing(camera, pivot, angle_deg, fps, duration_s)


def swing(
    camera: Camera, pivot: DoubleArray, angle_deg: float, fps: float = FPS, duration_s: float = ORBIT_SECONDS
) -> list[Camera]:
    """A swing about a world point (3,), to both sides by an angle and back: the end is the start."""
    phases = np.linspace(0.0, 2.0 * np.pi, max(round(duration_s * fps), 1), endpoint=False)
    return [orbited(camera, pivot, angle_deg * float(np.sin(p))) for p in phases]


def film_frames_of(found: PathFile, fps: float, duration_s: float | None = None) -> list[Camera]:
    """Returns the cameras of a film at a frame rate, from what a file says.

    Frames of the file are taken as they are; at another rate or in another time the keys are
    interpolated anew where there are any, else the nearest frame in time is taken.
    """
    file_fps = found.fps or FPS
    is_as_written = fps == file_fps and duration_s is None
    if found.frames and (is_as_written or not found.keys.num_pieces):
        natural_s = len(found.frames) / file_fps
        count = max(round((duration_s or natural_s) * fps), 1)
        if count > MAX_FRAMES:
            raise InputError("--seconds", f"makes {count} frames", f"At most {MAX_FRAMES}.")
        return [found.frames[i * len(found.frames) // count] for i in range(count)]
    keys = found.keys.lasting(duration_s) if duration_s else found.keys
    size = found.size or (keys.keys[0].camera.width, keys.keys[0].camera.height)
    return KeyTrack(keys, size).cameras(fps)


def parse_camera(text: str) -> Camera:
    """Parses one camera of JSON.

    Raises:
        InputError: when it is malformed.
    """
    try:
        return camera_from_json(json.loads(text))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OverflowError) as error:
        raise InputError(
            "--camera", f"is not a camera ({error})", "The app's Copy view gives one."
        ) from error
