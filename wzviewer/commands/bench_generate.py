"""``bench generate``: seconds and quality of every level of a real generation."""

import argparse
import math
import tempfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from wzviewer.commands.bench_naturalness import naturalness_of_levels
from wzviewer.commands.bench_optimize import psnr_db
from wzviewer.commands.cameras import orbited
from wzviewer.commands.generation import generate_scene
from wzviewer.commands.progress import Progress
from wzviewer.commands.rendering import picture, scene_renderer
from wzviewer.config import Generation, Zoom
from wzviewer.core.assets import demo_picture
from wzviewer.core.files import save_scene
from wzviewer.core.scene import Scene
from wzviewer.gl.context import ContextKind
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

ZOOMS = (Zoom(0.35, 0.55), Zoom(0.5, 0.5), Zoom(0.5, 0.5))
ORBITS_DEG = (8, 20)
UNCOVERED_BELOW = 0.5  # coverage of a pixel that counts as a hole


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns times from the worker, and what the pictures of the finished scene show."""
    plan = Generation(options.image or demo_picture(), ZOOMS)
    with Progress(silent=options.json) as progress:
        scene, timings = generate_scene(plan, progress)
    record: dict[str, Any] = {
        "initial_scene_seconds": timings.seconds[0],
        "new_level_seconds": float(np.median(timings.seconds[1:])),
        "first_preview_seconds": float(np.median(timings.first_preview_seconds[1:])),
        "file_bytes_per_surfel": file_bytes_per_surfel(scene),
    }
    for level in scene:
        for name, stage in level.stages.items():
            record[f"seconds_level_{level.index}_{name.replace(' ', '_')}"] = stage.seconds
    return {
        **record,
        **consistency(scene),
        **naturalness_of_levels(scene),
        **looks(scene, options.context),
    }


def file_bytes_per_surfel(scene: Scene) -> float:
    """Bytes of a scene file without its PNGs, per surfel."""
    import zipfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.wz"
        save_scene(scene, path)
        with zipfile.ZipFile(path) as archive:
            sizes = [i.file_size for i in archive.infolist() if not i.filename.endswith(".png")]
    return sum(sizes) / scene.num_surfels


def consistency(scene: Scene) -> dict[str, Any]:
    """Every new image, shrunk, against the crop of its parent's image."""
    values: dict[str, Any] = {}
    for level in list(scene)[1:]:
        values[f"consistency_db_level_{level.index}"] = consistency_db(scene, level.index)
        values[f"observation_consistency_db_level_{level.index}"] = level.notes.get("consistency_db")
    return {**values, "consistency_db": min(v for k, v in values.items() if k.startswith("consistency"))}


def consistency_db(scene: Scene, index: int) -> float:
    """PSNR of a level's image, shrunk to the pixels of its parent that it shows whole, against those, dB."""
    level = scene[index]
    assert level.parent is not None  # a child
    parent = scene[level.parent]
    ratio = level.camera.focal_px / parent.camera.focal_px
    starts = (
        parent.camera.cx - level.camera.cx / ratio,
        parent.camera.cy - level.camera.cy / ratio,
    )
    x, y = (math.ceil(start - 1e-6) for start in starts)
    columns, rows = (
        math.floor(start + n / ratio + 1e-6) - first
        for start, n, first in zip(starts, (level.camera.width, level.camera.height), (x, y), strict=True)
    )
    # the level moves by a part of its own pixel, not the parent by one of its, which would blur that
    shift = np.array([[1.0, 0.0, (x - starts[0]) * ratio], [0.0, 1.0, (y - starts[1]) * ratio]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (round(columns * ratio), round(rows * ratio))
    whole = cv2.warpAffine(level.image.astype(np.float32), shift, size, flags=flags)
    small = cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA)
    return psnr_db(small / 255.0, parent.image[y : y + rows, x : x + columns] / 255.0)


def looks(scene: Scene, context: ContextKind) -> dict[str, Any]:
    """Renders at every C_i against I_i, and the uncovered share of an orbit."""
    record: dict[str, Any] = {}
    with scene_renderer(scene, context) as renderer:
        for level in scene:
            image = picture(renderer, level.camera) / 255.0
            record[f"render_psnr_db_level_{level.index}"] = psnr_db(image, level.image / 255.0)
            for angle in ORBITS_DEG:
                share = uncovered(renderer, scene, level.index, angle)
                record[f"uncovered_share_{angle}deg_level_{level.index}"] = share
    for key in ("render_psnr_db", *(f"uncovered_share_{angle}deg" for angle in ORBITS_DEG)):
        worst = min if key == "render_psnr_db" else max
        record[key] = worst(v for k, v in record.items() if k.startswith(key + "_level"))
    return record


def uncovered(renderer: SurfelRenderer, scene: Scene, index: int, angle_deg: float) -> float:
    """Largest share of pixels that an orbit to either side leaves without a surface."""
    level = scene[index]
    shares = []
    for yaw_deg in (-angle_deg, angle_deg):
        camera = orbited(level.camera, level.frame.origin, yaw_deg)
        settings = RenderSettings(outputs=frozenset({"color", "coverage"}))
        coverage = renderer.render(camera, settings).read_coverage()
        shares.append(float(np.mean(coverage < UNCOVERED_BELOW)))
    return max(shares)
