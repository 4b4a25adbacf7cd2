"""A level's header as JSON: everything but its arrays, for the wire and for the file.

Decoding trusts nothing: every field is checked for type, finiteness and range, so that a header
from a stranger ends in `ValueError` and not in a crash.
"""

import math
from typing import Any

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import MAX_LEVELS
from wzviewer.core.scene import Level, StageRecord
from wzviewer.core.types import DoubleArray

Json = dict[str, Any]
MAX_SIDE_PX = 16384
MAX_PROMPT_CHARS = 2000


def camera_to_json(camera: Camera) -> Json:
    """Returns a camera as JSON; floats survive exactly."""
    keys = ("fx", "fy", "cx", "cy", "width", "height")
    matrix = camera.camera_from_world.tolist()
    return {"camera_from_world": matrix, **{k: getattr(camera, k) for k in keys}}


def camera_from_json(record: Json) -> Camera:
    """Restores a camera.

    Raises:
        ValueError: when a field is missing, not finite, or the pose is not rigid.
    """
    matrix = _floats(record, "camera_from_world", (4, 4))
    if not np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-6):
        raise ValueError("camera_from_world is not rigid")
    fx, fy, cx, cy = (_number(record, k) for k in ("fx", "fy", "cx", "cy"))
    if fx <= 0 or fy <= 0:
        raise ValueError("focal length is not positive")
    width, height = (_integer(record, k, 1, MAX_SIDE_PX) for k in ("width", "height"))
    return Camera(matrix, fx, fy, cx, cy, width, height)


def header_of(level: Level) -> Json:
    """Returns a level's header as JSON."""
    return {
        "index": level.index,
        "parent": level.parent,
        "camera": camera_to_json(level.camera),
        "frame": {
            "origin": level.frame.origin.tolist(),
            "axes": level.frame.axes.tolist(),
            "unit": level.frame.unit,
        },
        "prompt": level.prompt,
        "seed": level.seed,
        "stages": {k: {"backend": s.backend, "seconds": s.seconds} for k, s in level.stages.items()},
        "notes": level.notes,
    }


def header_fields(record: Json) -> Json:
    """Checks a header and returns the keyword arguments of `Level` that it determines.

    Raises:
        ValueError: when a field is missing or out of range.
    """
    parent = record.get("parent")
    frame = _mapping(record, "frame")
    unit = _number(frame, "unit")
    if unit <= 0:
        raise ValueError("unit is not positive")
    return {
        "index": _integer(record, "index", 0, MAX_LEVELS - 1),
        "parent": None if parent is None else _integer(record, "parent", 0, MAX_LEVELS - 1),
        "camera": camera_from_json(_mapping(record, "camera")),
        "frame": LevelFrame(_floats(frame, "origin", (3,)), _floats(frame, "axes", (3, 3)), unit),
        "prompt": _text(record, "prompt"),
        "seed": _integer(record, "seed", 0, 2**63 - 1),
        "stages": _stages(_mapping(record, "stages")),
        "notes": _mapping(record, "notes"),
    }


def _stages(record: Json) -> dict[str, StageRecord]:
    return {str(k): StageRecord(_text(v, "backend"), _number(v, "seconds")) for k, v in record.items()}


def _mapping(record: Json, key: str) -> Json:
    value = record.get(key) if isinstance(record, dict) else None
    if not isinstance(value, dict):
        raise ValueError(f"{key} is missing")
    return value


def _text(record: Json, key: str) -> str:
    value = record.get(key) if isinstance(record, dict) else None
    if not isinstance(value, str) or len(value) > MAX_PROMPT_CHARS:
        raise ValueError(f"{key} is not a text of at most {MAX_PROMPT_CHARS} characters")
    return value


def _number(record: Json, key: str) -> float:
    value = record.get(key) if isinstance(record, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{key} is not a finite number")
    return float(value)


def _integer(record: Json, key: str, low: int, high: int) -> int:
    value = record.get(key) if isinstance(record, dict) else None
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{key} is not an integer in [{low}, {high}]")
    return value


def _floats(record: Json, key: str, shape: tuple[int, ...]) -> DoubleArray:
    try:
        array = np.array(record.get(key), np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{key} is not numeric") from error
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{key} is not a finite array of shape {shape}")
    return array
