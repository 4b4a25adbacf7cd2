"""``bench render``: frame times by number of levels, with and without modulation, at rest and moving.

Every frame is of a camera of its own, as in motion: it is culled, sorted and drawn anew, and its pixels
are read.  ``frame_ms_*`` are exact frames at full resolution; ``moving_ms`` is what the window draws
while the camera moves, with the resolution that the pacing settles at.
"""

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from wzviewer.app.pacing import SOFTWARE_TARGET_S, SPACING_PX, TARGET_S, Pace
from wzviewer.commands.bench_quality import measure_quality
from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.commands.rendering import scene_renderer
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.frame import FrameStats, RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

LEVEL_COUNTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
ABLATION_COUNTS = (2, 5)  # without modulation everything is drawn: more would take minutes
REPEATS = 7
VIEWED_LEVEL = 1
PAN_PX = 0.37  # between frames: no two see the same pixel centres
BETWEEN = 8.0**0.5  # magnification half-way to the next level, where two levels share every pixel


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns frame times in ms, visible surfels and memory."""
    full = chain_scene(max(LEVEL_COUNTS))
    record: dict[str, Any] = {}
    for count in LEVEL_COUNTS:
        scene = first_levels(full, count)
        with scene_renderer(scene, options.context, options.rasterizer) as renderer:
            record |= _of_levels(scene, renderer, count)
            if count == 1:
                record |= _of_one_level(scene, renderer)
            if count == 5:
                record |= _in_motion(scene, renderer)
    record |= measure_quality(full, options.context, options.rasterizer)
    record["frame_ms_levels_ratio_10_2"] = record["frame_ms_levels_10"] / record["frame_ms_levels_2"]
    return record


def first_levels(scene: Scene, count: int) -> Scene:
    """The first levels of a chain as a scene of their own; arrays are shared."""
    part = Scene()
    for index in range(count):
        part.append(scene[index])
        part.commit(index)
    return part


def _of_levels(scene: Scene, renderer: SurfelRenderer, count: int) -> dict[str, Any]:
    """Frames at the native scale of one level, whatever the number of levels."""
    camera = scene[min(VIEWED_LEVEL, count - 1)].camera
    times_ms, stats = frame_times_ms(renderer, camera, RenderSettings())
    record: dict[str, Any] = {
        f"frame_ms_levels_{count}": float(np.median(times_ms)),
        f"frame_ms_p95_levels_{count}": float(np.percentile(times_ms, 95)),
        f"visible_surfels_levels_{count}": stats.num_visible,
        f"total_surfels_levels_{count}": scene.num_surfels,
        f"cull_ms_levels_{count}": stats.cull_ms,
    }
    if count > VIEWED_LEVEL + 1:
        middle = camera.zoomed(camera.width / 2, camera.height / 2, BETWEEN)
        between_ms, _ = frame_times_ms(renderer, middle, RenderSettings())
        record[f"frame_ms_between_levels_{count}"] = float(np.median(between_ms))
    if count in ABLATION_COUNTS:
        off_ms, _ = frame_times_ms(renderer, camera, RenderSettings(modulation=False))
        record[f"frame_ms_levels_{count}_no_modulation"] = float(np.median(off_ms))
    return record


def _of_one_level(scene: Scene, renderer: SurfelRenderer) -> dict[str, Any]:
    times_ms, stats = frame_times_ms(renderer, scene[0].camera, RenderSettings())
    return {
        "frame_ms_full_level": float(np.median(times_ms)),
        "cull_ms": stats.cull_ms,
        "sort_ms": stats.sort_ms,
        "draw_ms": stats.draw_ms,
        "gpu_bytes": stats.gpu_bytes,
        "gpu_bytes_per_surfel": renderer.bytes_per_surfel,
        "rasterizer": stats.rasterizer,
        "renderer": renderer.context.renderer_name,
    }


def _in_motion(scene: Scene, renderer: SurfelRenderer) -> dict[str, Any]:
    """A zoom through three levels as the window draws it: what a frame takes, and how fine it is."""
    renderer.wait_for_merged(scene)
    pace = Pace(target_s=SOFTWARE_TARGET_S if renderer.context.is_software else TARGET_S)
    settings, times_s, fractions = RenderSettings(spacing_px=SPACING_PX), [], []
    for camera in _zoom(scene[0].camera, 8.0**3, 120):
        fraction = pace.fraction(is_moving=True)
        small = camera.resized(round(camera.width * fraction), round(camera.height * fraction))
        began = time.perf_counter()
        renderer.render_soon(small, settings).read_color8()
        times_s.append(time.perf_counter() - began)
        fractions.append(fraction)
        pace = pace.measured(True, times_s[-1])
    settled = times_s[20:]
    return {
        "moving_ms": 1e3 * float(np.median(settled)),
        "moving_ms_p95": 1e3 * float(np.percentile(settled, 95)),
        "moving_fps": 1.0 / float(np.median(settled)),
        "moving_resolution": float(np.median(fractions[20:])),
    }


def _zoom(camera: Camera, factor: float, frames: int) -> Iterator[Camera]:
    for share in np.linspace(0.0, 1.0, frames):
        yield camera.zoomed(0.53 * camera.width, 0.47 * camera.height, factor ** float(share))


def frame_times_ms(
    renderer: SurfelRenderer, camera: Camera, settings: RenderSettings
) -> tuple[list[float], FrameStats]:
    """Times of whole frames from a panning camera: cull, sort, draw, and the pixels are there."""
    times = []
    for i in range(REPEATS + 1):
        moved = replace(camera, cx=camera.cx + PAN_PX * i)
        start = time.perf_counter()
        frame = renderer.render(moved, settings)
        frame.read_color8()
        times.append(1e3 * (time.perf_counter() - start))
    return times[1:], frame.stats
