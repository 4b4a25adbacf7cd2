"""``bench transition``: what shows through two levels mid-transition, and how steady a zoom is.

Leak: over a patch that both levels cover fully, the largest (1 - coverage) during the transition
minus the larger of its values at the two ends.
"""

import argparse
from typing import Any

import numpy as np

from wzviewer.commands.bench_scenes import chain_scene, consistent_chain
from wzviewer.commands.rendering import picture, scene_renderer
from wzviewer.core.camera import Camera
from wzviewer.core.navigation import interpolated
from wzviewer.core.reference import Blend
from wzviewer.core.scene import Scene
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

LEAK_STEPS = 17
ZOOM_FRAMES = 256
ZOOM_LEVELS = 5
SIZE_PX = (272, 184)


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns the leak of both blends and the step ratio of a zoom through five levels."""
    record: dict[str, Any] = {}
    scene = chain_scene(2, np.full((SIZE_PX[1], SIZE_PX[0], 3), 200, np.uint8), relief_px=0.0)
    with scene_renderer(scene, options.context, options.rasterizer) as renderer:
        record["transition_leak"] = leak(renderer, scene, "transmittance")
        record["transition_leak_linear"] = leak(renderer, scene, "linear")
    zoom = consistent_chain(ZOOM_LEVELS, *SIZE_PX)
    with scene_renderer(zoom, options.context, options.rasterizer) as renderer:
        steps = step_sizes(renderer, zoom)
    record["transition_step_median"] = float(np.median(steps))
    record["transition_step_max"] = float(np.max(steps))
    record["transition_step_ratio"] = float(np.max(steps) / np.median(steps))
    return record


def leak(renderer: SurfelRenderer, scene: Scene, blend: Blend) -> float:
    """Leak between levels 0 and 1 over the middle of level 1."""
    through = []
    for t in np.linspace(0.0, 1.0, LEAK_STEPS):
        camera = interpolated(_at_scale_of_parent(scene), scene[1].camera, scene[1].frame.origin, float(t))
        settings = RenderSettings(blend=blend, outputs=frozenset({"color", "coverage"}))
        coverage = renderer.render(camera, settings).read_coverage()
        h, w = coverage.shape
        patch = coverage[h * 15 // 32 : h * 17 // 32, w * 15 // 32 : w * 17 // 32]
        through.append(float(1.0 - patch.mean()))
    return max(0.0, max(through) - max(through[0], through[-1]))


def _at_scale_of_parent(scene: Scene) -> Camera:
    """The parent's focal length, centred on what the child shows."""
    child = scene[1].camera
    return child.zoomed(child.width / 2, child.height / 2, scene[0].camera.fx / child.fx)


def step_sizes(renderer: SurfelRenderer, scene: Scene) -> list[float]:
    """Mean absolute change between successive frames of an even zoom, in grey levels.

    The motion of the zoom itself is the same in every frame, so a pop stands out of the median.
    """
    start, last = scene[0].camera, scene[len(scene) - 1]
    path = (interpolated(start, last.camera, last.frame.origin, t) for t in np.linspace(0, 1, ZOOM_FRAMES))
    frames = (picture(renderer, camera) for camera in path)
    before: Any = None
    steps = []
    for frame in frames:
        if before is not None:
            steps.append(float(np.abs(frame.astype(np.int16) - before).mean()))
        before = frame.astype(np.int16)
    return steps
