"""Scene files: one stored ZIP, written whole or not at all, read with caps and without trust.

::

    scene.wz
      manifest.json                       format, version, levels (headers), marks; unknown fields kept
      levels/000/surfels.safetensors      packed surfels (core.packing) and coverage
      levels/000/image.png                I_0
      levels/000/depth.safetensors        relief and further maps
      levels/000/photo.png                the photograph, where it is finer than I_0
      levels/001/...

Nothing in a file is ever executed.  An entry is read only when it is stored uncompressed and its
size is within the cap, so a file can ask for no more memory than it has bytes.
"""

import json
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.assembly import MAP_PREFIX, level_of, surfel_arrays
from wzviewer.core.constants import MAX_LEVELS
from wzviewer.core.marks import FIELDS, marks_from_json, marks_to_json
from wzviewer.core.photos import decode_png, encode_png, whole_file
from wzviewer.core.records import Json, header_of
from wzviewer.core.scene import PHOTO, Level, Scene
from wzviewer.errors import InputError

FORMAT, VERSION = "wzviewer-scene", 1
MAX_MANIFEST_BYTES = 16 << 20
MAX_ENTRY_BYTES = 4 << 30
MAX_ENTRIES = 5 * MAX_LEVELS
READERS = 2  # levels at once
DAMAGED = "the scene file is damaged"


def save_scene(scene: Scene, path: Path) -> None:
    """Writes the finished levels of a scene.

    Raises:
        OutputError: when the folder cannot be written; an older file stays as it was.
    """
    with whole_file(path) as file:
        write_scene(scene, file)


def write_scene(scene: Scene, file: BinaryIO) -> None:
    """Writes a scene to an open file, level by level; equal scenes give equal bytes."""
    levels = [level for level in scene if scene.is_committed(level.index)]
    manifest = {
        **scene.unknown_fields,
        "format": FORMAT,
        "version": VERSION,
        "levels": [header_of(level) for level in levels],
        **marks_to_json({i: mark for i, mark in scene.marks.items() if i < len(levels)}),
    }
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        _put(archive, "manifest.json", json.dumps(manifest, indent=1).encode())
        for level in levels:
            put_level(archive, level)


def put_level(archive: zipfile.ZipFile, level: Level) -> None:
    """Writes the arrays of a level into an archive; its header goes into a manifest."""
    from safetensors.numpy import save

    folder = f"levels/{level.index:03d}"
    _put(archive, f"{folder}/surfels.safetensors", save(surfel_arrays(level.surfels)))
    _put(archive, f"{folder}/image.png", encode_png(level.image))
    maps = {MAP_PREFIX + k: np.ascontiguousarray(v) for k, v in level.maps.items() if k != PHOTO}
    _put(archive, f"{folder}/depth.safetensors", save({"relief": level.relief, **maps}))
    if PHOTO in level.maps:
        _put(archive, f"{folder}/{PHOTO}.png", encode_png(level.maps[PHOTO]))


def _put(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    info = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))  # a fixed date: equal scenes, equal bytes
    info.external_attr = 0o644 << 16
    archive.writestr(info, data)


def load_scene(path: Path) -> Scene:
    """Reads a scene file.

    Raises:
        InputError: when it is missing, not a scene, from a newer version, damaged or out of bounds.
    """
    if path.is_dir():
        raise InputError(str(path), "is a directory", "Give a .wz file.")
    if not path.is_file():
        raise InputError(str(path), "no such file", "Check the path.")
    try:
        with zipfile.ZipFile(path) as archive:
            return _read_scene(archive, str(path))
    except zipfile.BadZipFile as error:
        raise InputError(str(path), "is not a wzviewer scene, or is truncated") from error
    except (ValueError, KeyError, TypeError, RecursionError, NotImplementedError, OSError) as error:
        raise InputError(str(path), f"{DAMAGED} ({error})") from error


def is_scene_file(path: Path) -> bool:
    """Whether a path looks like a scene rather than a photograph."""
    return path.suffix.lower() == ".wz"


def _read_scene(archive: zipfile.ZipFile, name: str) -> Scene:
    if len(archive.infolist()) > MAX_ENTRIES:
        raise ValueError("too many entries")
    manifest = json.loads(_get(archive, "manifest.json", MAX_MANIFEST_BYTES))
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise ValueError("no wzviewer manifest")
    if not isinstance(manifest.get("version"), int) or manifest["version"] > VERSION:
        raise InputError(name, f"has version {manifest.get('version')}", "Update wzviewer.")
    scene = Scene()
    known = ("format", "version", "levels", *FIELDS)
    scene.unknown_fields = {k: v for k, v in manifest.items() if k not in known}
    headers = manifest["levels"][:MAX_LEVELS]
    with ThreadPoolExecutor(READERS) as pool:  # most of it is done without Python's lock
        for level in pool.map(lambda index: get_level(archive, index, headers[index]), range(len(headers))):
            scene.append(level)
            scene.commit(level.index)
    for index, mark in marks_from_json(manifest, len(scene)).items():
        scene.set_mark(index, mark)
    if not len(scene):
        raise ValueError("no levels")
    return scene


def get_level(archive: zipfile.ZipFile, index: int, header: Json) -> Level:
    """Reads a level from an archive.

    Raises:
        ValueError, KeyError: when it is damaged or out of bounds.
    """
    folder = f"levels/{index:03d}"
    arrays: dict[str, NDArray[Any]] = {"image": decode_png(_get(archive, f"{folder}/image.png"), folder)}
    for entry in ("surfels", "depth"):
        arrays |= _tensors(_get(archive, f"{folder}/{entry}.safetensors"))
    if f"{folder}/{PHOTO}.png" in archive.NameToInfo:
        arrays[MAP_PREFIX + PHOTO] = decode_png(_get(archive, f"{folder}/{PHOTO}.png"), folder)
    return level_of(header, arrays)


def _tensors(data: bytes) -> dict[str, NDArray[Any]]:
    from safetensors import SafetensorError
    from safetensors.numpy import load

    try:
        return dict(load(data))
    except SafetensorError as error:
        raise ValueError(str(error)) from error


def _get(archive: zipfile.ZipFile, name: str, cap_bytes: int = MAX_ENTRY_BYTES) -> bytes:
    info = archive.getinfo(name)
    if info.compress_type != zipfile.ZIP_STORED or info.file_size > cap_bytes:
        raise ValueError(f"{name} is compressed or too large")
    return archive.read(info)
