"""``wzviewer render``: scene -> picture or film."""

import argparse
from pathlib import Path

import numpy as np

from wzviewer.commands import cameras
from wzviewer.commands.progress import Progress
from wzviewer.commands.rendering import film_frames, picture, scene_renderer, write_film, write_png
from wzviewer.config import parse_size
from wzviewer.core.camera import Camera
from wzviewer.core.files import load_scene
from wzviewer.core.photos import check_writable, whole_file
from wzviewer.core.scene import Scene
from wzviewer.errors import InputError
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

SUFFIXES = (".png", ".mp4")


def run(options: argparse.Namespace) -> None:
    """Renders a picture or a film and writes it whole."""
    if options.output.suffix.lower() not in SUFFIXES:
        raise InputError(str(options.output), "unknown kind of picture", "Use .png or .mp4.")
    check_writable(options.output)
    scene = load_scene(options.scene)
    level = cameras.level_index(scene, options.level)
    camera = cameras.camera_of(scene, level, options.magnify, options.orbit)
    if options.camera is not None:
        camera = cameras.parse_camera(options.camera)
    size = parse_size(options.size) if options.size else None
    settings = RenderSettings(
        blend=options.blend, modulation=not options.no_modulation, antialias=not options.no_antialias
    )
    with scene_renderer(scene, options.context, options.rasterizer) as renderer:
        if options.output.suffix.lower() == ".png":
            image = picture(renderer, _sized(camera, size), settings)
            write_png(options.output, image)
        else:
            path = _film_path(options, scene, level)
            _write_film(options.output, renderer, _all_sized(path, size), settings)
        if options.depth is not None:
            _write_depth(options.depth, renderer, scene, level, _sized(camera, size))


def _sized(camera: Camera, size: tuple[int, int] | None) -> Camera:
    return camera if size is None else camera.resized(*size)


def _all_sized(path: list[Camera], size: tuple[int, int] | None) -> list[Camera]:
    sized = {id(camera): _sized(camera, size) for camera in path}  # a resting camera stays one object
    return [sized[id(camera)] for camera in path]


def _film_path(options: argparse.Namespace, scene: Scene, level: int) -> list[Camera]:
    if options.path in (None, "zoom"):
        return cameras.zoom_path(scene, level)
    if options.path == "orbit":
        return cameras.orbit_path(scene, level, options.magnify)
    return cameras.read_path(Path(options.path))


def _write_film(path: Path, renderer: SurfelRenderer, film: list[Camera], settings: RenderSettings) -> None:
    with Progress() as progress:
        progress.begin(f"film of {len(film)} frames")
        frames = film_frames(renderer, film, settings)
        write_film(path, frames, cameras.FPS, len(film), progress)
        progress.done()


def _write_depth(path: Path, renderer: SurfelRenderer, scene: Scene, level: int, camera: Camera) -> None:
    check_writable(path)
    frame = renderer.render(camera, RenderSettings(outputs=frozenset({"color", "depth"})))
    anchor_depth = float(camera.to_camera(scene[level].frame.origin)[2])
    unit = scene[level].frame.unit
    depth = anchor_depth + unit * frame.read_relief(anchor_depth, unit).astype(np.float64)
    with whole_file(path) as file:
        np.save(file, depth, allow_pickle=False)
