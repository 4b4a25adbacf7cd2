"""``bench render``: frame times against the number of levels, with and without modulation."""

import argparse
import time
from typing import Any

import numpy as np

from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.commands.rendering import scene_renderer
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

LEVEL_COUNTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
ABLATION_COUNTS = (2, 5)  # without modulation everything is drawn: more would take minutes
REPEATS = 5
VIEWED_LEVEL = 1


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns frame times in ms, visible surfels and GPU memory."""
    full = chain_scene(max(LEVEL_COUNTS))
    record: dict[str, Any] = {}
    for count in LEVEL_COUNTS:
        scene = first_levels(full, count)
        with scene_renderer(scene, options.context) as renderer:
            _measure_count(record, scene, renderer, count)
            record["renderer"] = renderer.context.renderer_name
    record["frame_ms_levels_ratio_10_2"] = record["frame_ms_levels_10"] / record["frame_ms_levels_2"]
    return record


def first_levels(scene: Scene, count: int) -> Scene:
    """The first levels of a chain as a scene of their own; arrays are shared."""
    part = Scene()
    for index in range(count):
        part.append(scene[index])
        part.commit(index)
    return part


def _measure_count(record: dict[str, Any], scene: Scene, renderer: SurfelRenderer, count: int) -> None:
    camera = scene[min(VIEWED_LEVEL, count - 1)].camera
    times_ms = frame_times_ms(renderer, camera, RenderSettings())
    record[f"frame_ms_levels_{count}"] = float(np.median(times_ms))
    record[f"frame_ms_p95_levels_{count}"] = float(np.percentile(times_ms, 95))
    stats = renderer.render(camera).stats
    record[f"visible_surfels_levels_{count}"] = stats.num_visible
    record[f"total_surfels_levels_{count}"] = scene.num_surfels
    if count in ABLATION_COUNTS:
        off = frame_times_ms(renderer, camera, RenderSettings(modulation=False))
        record[f"frame_ms_levels_{count}_no_modulation"] = float(np.median(off))
    if count == 1:
        record["frame_ms_full_level"] = record["frame_ms_levels_1"]
        record["gpu_bytes"] = stats.gpu_bytes
        record["gpu_bytes_per_surfel"] = renderer.bytes_per_surfel
        record |= {"cull_ms": stats.cull_ms, "sort_ms": stats.sort_ms, "draw_ms": stats.draw_ms}


def frame_times_ms(renderer: SurfelRenderer, camera: Camera, settings: RenderSettings) -> list[float]:
    """Times of whole frames from a moving camera: cull, sort, draw, and the pixels are there."""
    times = []
    for i in range(REPEATS + 1):
        moved = camera.zoomed(camera.width / 2, camera.height / 2, 1.0 + 1e-4 * i)
        start = time.perf_counter()
        renderer.render(moved, settings).read_color8()
        times.append(1e3 * (time.perf_counter() - start))
    return times[1:]
