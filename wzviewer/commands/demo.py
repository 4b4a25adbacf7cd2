"""``wzviewer demo``: three zooms into the bundled picture, two with a prompt."""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from wzviewer.commands import cameras
from wzviewer.commands.films import write_film
from wzviewer.commands.generate import report
from wzviewer.commands.generation import Timings, generate_scene
from wzviewer.commands.progress import Progress
from wzviewer.commands.rendering import film_frames, picture, scene_renderer, write_png
from wzviewer.config import Generation, Zoom
from wzviewer.core.assets import demo_picture
from wzviewer.core.camera import Camera
from wzviewer.core.files import save_scene
from wzviewer.core.photos import check_writable
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.errors import OutputError
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

ZOOMS = (
    Zoom(0.318, 0.545, prompt="a butterfly"),  # a petal of the large daisy
    Zoom(0.255, 0.72, prompt="a ladybug"),  # the petal beside the butterfly's wing, well off its edge
    Zoom(0.356, 0.411),  # the ladybug's head: drawn again, finer
)
GUTTER_PX = 8
FILM_SIZE = 0.75  # of the pictures


def run(options: argparse.Namespace) -> None:
    """Writes demo.wz, demo.png and demo.mp4; then opens the window where there is a display."""
    folder: Path = options.out
    _make_folder(folder)
    plan = Generation(demo_picture(), ZOOMS, options.seed)
    with Progress(silent=options.json) as progress:
        scene, timings = generate_scene(plan, progress)
        save_scene(scene, folder / "demo.wz")
        _write_pictures(scene, folder, progress)
        progress.line(f"wrote demo.wz, demo.png and demo.mp4 in {folder}")
    _report(scene, timings, options)
    if not options.json and not options.no_window and has_display():
        from wzviewer.app.loop import run_app

        run_app(folder / "demo.wz")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            str(folder), (error.strerror or str(error)).lower(), "Choose another --out."
        ) from error
    check_writable(folder / "demo.wz")


def _write_pictures(scene: Scene, folder: Path, progress: Progress) -> None:
    with scene_renderer(scene) as renderer:
        write_png(folder / "demo.png", contact_sheet(scene, renderer))
        film = _small(cameras.zoom_path(scene, len(scene) - 1))
        progress.begin(f"film of {len(film)} frames")
        frames = film_frames(renderer, film, RenderSettings())
        write_film(folder / "demo.mp4", frames, cameras.FPS, len(film), progress)
        progress.done()


def _small(film: list[Camera]) -> list[Camera]:
    small = {id(c): c.resized(round(c.width * FILM_SIZE), round(c.height * FILM_SIZE)) for c in film}
    return [small[id(camera)] for camera in film]


def contact_sheet(scene: Scene, renderer: SurfelRenderer) -> ByteArray:
    """Every level seen by its own camera, side by side in two rows."""
    pictures = [picture(renderer, level.camera) for level in scene]
    height, width = pictures[0].shape[:2]
    columns = (len(pictures) + 1) // 2
    rows = -(-len(pictures) // columns)
    shape = (rows * (height + GUTTER_PX) - GUTTER_PX, columns * (width + GUTTER_PX) - GUTTER_PX, 3)
    sheet = np.full(shape, 24, np.uint8)
    for i, image in enumerate(pictures):
        y, x = (i // columns) * (height + GUTTER_PX), (i % columns) * (width + GUTTER_PX)
        sheet[y : y + height, x : x + width] = image
    return sheet


def _report(scene: Scene, timings: Timings, options: argparse.Namespace) -> None:
    if options.json:
        sys.stdout.write(json.dumps(report(scene, timings, options.out / "demo.wz")) + "\n")


def has_display() -> bool:
    """Whether a window can be opened here."""
    import os

    return sys.platform in ("win32", "darwin") or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )
