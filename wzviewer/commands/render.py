"""``wzviewer render``: scene -> picture or film."""

import argparse
from pathlib import Path

import numpy as np

from wzviewer.commands import cameras, films
from wzviewer.commands.progress import Progress
from wzviewer.commands.rendering import film_frames, picture, scene_renderer, write_png
from wzviewer.config import parse_size
from wzviewer.core.camera import Camera
from wzviewer.core.files import load_scene
from wzviewer.core.keyframes import KeyPath
from wzviewer.core.path_files import MAX_FPS, MAX_FRAMES, PathFile, read_path_file, write_path
from wzviewer.core.photos import check_writable, whole_file
from wzviewer.core.scene import Scene
from wzviewer.errors import InputError
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

PICTURE_SUFFIX = ".png"
SECONDS_RANGE = (0.1, 3600.0)


def run(options: argparse.Namespace) -> None:
    """Renders a picture or a film and writes it whole."""
    is_picture = options.output.suffix.lower() == PICTURE_SUFFIX
    _check(options, is_picture)
    scene = load_scene(options.scene)
    level = cameras.level_index(scene, options.level)
    orbit_deg = 0.0 if options.path == "orbit" else options.orbit  # there it is how far the film swings
    camera = cameras.camera_of(scene, level, options.magnify, orbit_deg)
    if options.camera is not None:
        camera = cameras.parse_camera(options.camera)
    size = parse_size(options.size) if options.size else None
    film, fps = ([], 0.0) if is_picture else _film(options, scene, level, size)
    settings = RenderSettings(
        blend=options.blend, modulation=not options.no_modulation, antialias=not options.no_antialias
    )
    with scene_renderer(scene, options.context, options.rasterizer) as renderer:
        if is_picture:
            write_png(options.output, picture(renderer, _sized(camera, size), settings, options.transparent))
        else:
            _write_film(options.output, renderer, film, settings, fps)
        if options.depth is not None:
            _write_depth(options.depth, renderer, scene, level, _sized(camera, size))


def _check(options: argparse.Namespace, is_picture: bool) -> None:
    """Refuses what cannot be, before anything is read."""
    output = str(options.output)
    if not is_picture and options.output.suffix.lower() not in films.SUFFIXES:
        raise InputError(output, "unknown kind of picture", "Use .png, .mp4 or .gif.")
    if options.transparent and not is_picture:
        raise InputError("--transparent", "a film has no transparency", "Write a .png.")
    if not -180.0 <= options.orbit <= 180.0:
        raise InputError(f"--orbit {options.orbit:g}", "must be between -180 and 180 degrees")
    if options.fps is not None and not 1.0 <= options.fps <= MAX_FPS:
        raise InputError(f"--fps {options.fps:g}", f"must be between 1 and {MAX_FPS:g}")
    low, high = SECONDS_RANGE
    if options.seconds is not None and not low <= options.seconds <= high:
        raise InputError(f"--seconds {options.seconds:g}", f"must be between {low:g} and {high:g}")
    if options.path_out is not None:
        if is_picture:
            raise InputError("--path-out", "a picture has no camera path", "Write an .mp4 or a .gif.")
        check_writable(options.path_out)
    check_writable(options.output)


def _sized(camera: Camera, size: tuple[int, int] | None) -> Camera:
    return camera if size is None else camera.resized(*size)


def _film(
    options: argparse.Namespace, scene: Scene, level: int, size: tuple[int, int] | None
) -> tuple[list[Camera], float]:
    """Cameras of all frames, and the frame rate."""
    found = PathFile()
    if options.path not in (None, "zoom", "orbit"):
        found = read_path_file(Path(options.path))
    is_gif = options.output.suffix.lower() == ".gif"
    fps = options.fps or (films.GIF_FPS if is_gif else found.fps or cameras.FPS)
    path = _path(options, scene, level, found, fps)
    if not 0 < len(path) <= MAX_FRAMES:
        raise InputError("--seconds", f"makes {len(path)} frames", f"At most {MAX_FRAMES}.")
    if size is None and is_gif:
        size = films.gif_size(path[0].width, path[0].height)
    size = size or (path[0].width, path[0].height)  # all frames of a film have one size
    film = _all_sized(path, size)
    films.check_film(options.output, film, fps)
    if options.path_out is not None:
        write_path(options.path_out, found.keys if found.keys.num_pieces else KeyPath(), film, fps)
    return film, fps


def _path(options: argparse.Namespace, scene: Scene, level: int, found: PathFile, fps: float) -> list[Camera]:
    if options.path in (None, "zoom"):
        return cameras.zoom_path(scene, level, fps, options.seconds)
    if options.path == "orbit":
        angle_deg, seconds = options.orbit or cameras.ORBIT_DEG, options.seconds or cameras.ORBIT_SECONDS
        return cameras.orbit_path(scene, level, options.magnify, angle_deg, fps, seconds)
    return cameras.film_frames_of(found, fps, options.seconds)


def _all_sized(path: list[Camera], size: tuple[int, int]) -> list[Camera]:
    sized = {id(camera): _sized(camera, size) for camera in path}  # a resting camera stays one object
    return [sized[id(camera)] for camera in path]


def _write_film(
    path: Path, renderer: SurfelRenderer, film: list[Camera], settings: RenderSettings, fps: float
) -> None:
    with Progress() as progress:
        progress.begin(f"film of {len(film)} frames")
        frames = film_frames(renderer, film, settings)
        films.write_film(path, frames, fps, len(film), progress)
        progress.done()


def _write_depth(path: Path, renderer: SurfelRenderer, scene: Scene, level: int, camera: Camera) -> None:
    check_writable(path)
    frame = renderer.render(camera, RenderSettings(outputs=frozenset({"color", "depth"})))
    anchor_depth = float(camera.to_camera(scene[level].frame.origin)[2])
    unit = scene[level].frame.unit
    depth = anchor_depth + unit * frame.read_relief(anchor_depth, unit).astype(np.float64)
    with whole_file(path) as file:
        np.save(file, depth, allow_pickle=False)
