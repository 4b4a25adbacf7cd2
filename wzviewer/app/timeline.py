"""The keyframes of the film that is being made, and how they are edited: pure, without the app."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.core.keyframes import MAX_KEYS, SECONDS_LIMIT, Key, KeyPath, KeyTrack, Pace
from wzviewer.core.path_files import FAULTS, PathFile, keys_of, keys_record
from wzviewer.core.records import Json
from wzviewer.core.types import DoubleArray

FIELD = "camera_path"  # of a scene file's manifest
SECONDS_PER_LEVEL = 2.0  # for every x8 of magnification
SHORTEST_S = 1.5  # of a new piece
SPANS_S = (5.0, 8.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0, 300.0, 600.0, 1200.0, 3600.0)
AT_KEY_S = 0.02
MAX_PAST = 50
SAMPLED_KEYS = 48  # of a path that came as frames only


@dataclass(frozen=True, eq=False)
class Timeline:
    """Keys, and what is done with them.

    Attributes:
        path: the keys.
        saved: those in the scene's file.
        past: earlier ones, the last one last, to be brought back.
        selected: index of a key, or None.
        at_s: the moment that is shown, s.
        is_playing: whether time goes on.
        is_retiming: whether a hand drags a key.
        shown: the camera that the preview has set; the view has been moved since when it is another.
        span_s: of the ruler.
    """

    path: KeyPath = field(default_factory=KeyPath)
    saved: KeyPath = field(default_factory=KeyPath)
    past: tuple[KeyPath, ...] = ()
    selected: int | None = None
    at_s: float = 0.0
    is_playing: bool = False
    is_retiming: bool = False
    shown: Camera | None = None
    span_s: float = SPANS_S[0]

    @property
    def is_changed(self) -> bool:
        """Whether saving the scene would keep other keys."""
        return self.path is not self.saved and bool(self.path.keys or self.saved.keys)

    def edited(self, path: KeyPath, selected: int | None) -> "Timeline":
        """Returns the timeline with other keys; the present ones can be brought back."""
        past = (*self.past, self.path)[-MAX_PAST:]
        at_s = min(self.at_s, path.duration_s)
        fresh = replace(self, path=path, past=past, selected=selected, at_s=at_s)
        return replace(fresh, is_playing=False, is_retiming=False).fitted()

    def retimed(self, path: KeyPath, at_s: float, is_done: bool) -> "Timeline":
        """Returns the timeline with other times; a drag is one change, and the ruler stands still in it."""
        past = self.past if self.is_retiming else (*self.past, self.path)[-MAX_PAST:]
        line = replace(self, path=path, past=past, at_s=at_s, is_retiming=not is_done, is_playing=False)
        return line.fitted() if is_done else line

    def fitted(self) -> "Timeline":
        """Returns the timeline with a ruler that holds the path."""
        needed = self.path.duration_s * 1.05
        return replace(self, span_s=next((s for s in SPANS_S if s >= needed), needed))

    def camera_at(self, time_s: float, size: tuple[int, int]) -> tuple[Camera, DoubleArray]:
        """Returns the camera of a moment, and the point (3,) that is looked at."""
        track = KeyTrack(self.path, size)
        return track.camera_at(time_s), track.focus_at(time_s)


# ------------------------------------------------------------------ edits of a path


def with_key(path: KeyPath, camera: Camera, focus: DoubleArray, at_s: float) -> tuple[KeyPath, int]:
    """Returns a path with one more key, and its index: at a moment within the path, else at its end."""
    times, keys = path.times_s, list(path.keys)
    before = max((i for i, t in enumerate(times) if t <= at_s + AT_KEY_S), default=-1) if keys else -1
    if before < 0 or before == len(keys) - 1:
        if keys:
            keys[-1] = replace(keys[-1], seconds=natural_s(keys[-1].camera, camera))
        return replace(path, keys=(*keys, Key(camera, focus))), len(keys)
    whole = keys[before].seconds
    first = at_s - times[before]
    first = first if AT_KEY_S < first < whole - AT_KEY_S else whole / 2
    keys[before] = replace(keys[before], seconds=first)
    keys.insert(before + 1, Key(camera, focus, whole - first))
    return replace(path, keys=tuple(keys)), before + 1


def without_key(path: KeyPath, index: int) -> KeyPath:
    """Returns a path without a key; the others keep their times."""
    keys = list(path.keys)
    gone = keys.pop(index)
    if 0 < index < len(keys):
        seconds = min(keys[index - 1].seconds + gone.seconds, SECONDS_LIMIT[1])
        keys[index - 1] = replace(keys[index - 1], seconds=seconds)
    return replace(path, keys=tuple(keys))


def with_time(path: KeyPath, index: int, time_s: float) -> KeyPath:
    """Returns a path with a key at another moment, between its neighbours.

    Args:
        path: the keys.
        index: of the key, from 1; one past the last is the end of a loop.
        time_s: when it is to be reached; kept a little off the neighbours.
    """
    keys, times = list(path.keys), (*path.times_s, path.duration_s)
    low, high = SECONDS_LIMIT
    start = times[index - 1]
    seconds = min(max(time_s - start, low), high)
    if index < path.num_pieces:  # what this piece gains, the next one loses
        both = keys[index - 1].seconds + keys[index].seconds
        seconds = min(max(seconds, both - high), both - low)
        keys[index] = replace(keys[index], seconds=both - seconds)
    keys[index - 1] = replace(keys[index - 1], seconds=seconds)
    return replace(path, keys=tuple(keys))


def with_seconds(path: KeyPath, index: int, seconds: float) -> KeyPath:
    """Returns a path with another time after a key; all later keys move."""
    return _with(path, index, seconds=min(max(seconds, SECONDS_LIMIT[0]), SECONDS_LIMIT[1]))


def with_pace(path: KeyPath, index: int, pace: Pace) -> KeyPath:
    """Returns a path that goes through a key in another way."""
    return _with(path, index, pace=pace)


def with_view(path: KeyPath, index: int, camera: Camera, focus: DoubleArray) -> KeyPath:
    """Returns a path with another view at a key."""
    return _with(path, index, camera=camera, focus=focus)


def _with(path: KeyPath, index: int, **changes: object) -> KeyPath:
    keys = list(path.keys)
    keys[index] = replace(keys[index], **changes)  # type: ignore[arg-type]
    return replace(path, keys=tuple(keys))


def natural_s(start: Camera, end: Camera) -> float:
    """Returns the time from one view to another: 2 s for every x8."""
    ratio = end.focal_px / end.width * start.width / start.focal_px
    folds = abs(math.log(ratio)) / math.log(ZOOM_FACTOR)
    return round(max(SHORTEST_S, SECONDS_PER_LEVEL * folds), 1)


# ------------------------------------------------------------------ with the scene, and from files


def keep(line: Timeline, fields: Json) -> Timeline:
    """Puts keys that were changed where a scene's file has them; returns the timeline as saved.

    Args:
        line: the timeline.
        fields: `Scene.unknown_fields`, changed in place.
    """
    if line.is_changed and line.path.keys:
        fields[FIELD] = record_of(line.path)
    elif line.is_changed:
        fields.pop(FIELD, None)
    return replace(line, saved=line.path)


def record_of(path: KeyPath) -> Json:
    """Returns keys as a scene's file has them."""
    return {"keyframes": keys_record(path), "is_cycle": path.is_loop}


def timeline_of(record: object, size: tuple[int, int]) -> Timeline | None:
    """Returns the timeline of a scene file; None when its record is damaged."""
    if record is None:
        return Timeline()
    try:
        path = keys_of(record, size) if isinstance(record, dict) else None
    except FAULTS:
        path = None
    return None if path is None else Timeline(path, path).fitted()


def path_of_file(found: PathFile, fps: float) -> KeyPath:
    """Returns the keys of a file; where it has frames only, some of them."""
    if found.keys.keys:
        return found.keys
    count = len(found.frames)
    chosen = np.unique(np.linspace(0, count - 1, min(count, SAMPLED_KEYS)).round().astype(int))
    waits = [*np.diff(chosen), chosen[-1] - chosen[-2] if len(chosen) > 1 else 1]
    cameras = [found.frames[i] for i in chosen]
    keys = [
        Key(camera, camera.unproject(camera.width / 2, camera.height / 2, 1.0), float(wait) / fps)
        for camera, wait in zip(cameras, waits, strict=True)
    ]
    return KeyPath(tuple(keys[:MAX_KEYS]))
