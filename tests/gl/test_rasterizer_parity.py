"""The worker's rasteriser and the OpenGL renderer draw the same picture."""

from dataclasses import replace

import numpy as np
import pytest

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.assembly import finished
from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift
from wzviewer.core.scene import Level, Scene, coverage_for
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.worker.draft import visible_parts
from wzviewer.worker.rasterize import render

pytestmark = pytest.mark.gl


def textured_level(scene, parent, camera, seed):
    rng = np.random.default_rng(seed)
    h, w = camera.height, camera.width
    image = rng.random((h, w, 3), dtype=np.float32)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    relief = 3.0 * np.sin(x / 9.0) + 2.0 * np.cos(y / 7.0)
    relief[h // 3 : h // 2, w // 3 : w // 2] -= 25.0  # a step
    frame = LevelFrame.of_camera(camera, 1.0)
    surfels = lift(image, relief.astype(np.float32), camera)
    surfels = surfels.with_(coverage=coverage_for(scene, parent, camera, frame, surfels.means))
    surfels = finished(surfels, camera, frame)
    pixels = (image * 255).astype(np.uint8)
    return Level(len(scene), parent, camera, frame, surfels, pixels, relief.astype(np.float32))


@pytest.fixture(scope="module")
def scene():
    scene = Scene()
    camera = Camera.initial(96, 72, 90.0)
    for index in range(3):
        scene.append(textured_level(scene, index - 1 if index else None, camera, index))
        scene.commit(index)
        camera = camera.zoomed_to_region(0.55, 0.45, 8.0)
    return scene


VIEWS = {
    "native 0": (0, 1.0),
    "between": (0, 3.0),
    "native 1": (1, 1.0),
    "late": (1, 5.0),
    "native 2": (2, 1.0),
}


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS.keys())
@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_worker_and_gl_agree(gl_context, scene, view, blend):
    level, magnification = view
    camera = scene[level].camera
    camera = camera.zoomed(camera.width * 0.55, camera.height * 0.45, magnification)
    path = [scene[i] for i in range(3)]
    worker = render(visible_parts(path, camera, blend), camera, blend=blend)
    renderer = SurfelRenderer(gl_context, "shaders")
    renderer.sync(scene)
    frame = renderer.render(camera, RenderSettings(blend=blend, outputs=frozenset({"color", "coverage"})))
    image, coverage = frame.read_color()[..., :3], frame.read_coverage()
    difference = np.abs(image - worker.color)
    assert difference.mean() < 1e-4  # measured 8.8e-6
    assert np.quantile(difference, 0.999) < 1e-3  # measured 1.1e-4
    assert np.abs(coverage - worker.coverage).mean() < 1e-4  # measured 7.5e-6
    renderer.release()


def test_median_depth_agrees(gl_context, scene):
    camera = scene[1].camera
    frame_1 = scene[1].frame
    worker = render(visible_parts([scene[0], scene[1]], camera), camera, depth_anchor=(1.0, frame_1.unit))
    renderer = SurfelRenderer(gl_context, "shaders")
    alone = Scene()
    for level in (scene[0], scene[1]):
        alone.append(replace(level))
    renderer.sync(alone)
    frame = renderer.render(camera, RenderSettings(outputs=frozenset({"color", "depth"})))
    relief = frame.read_relief(1.0, frame_1.unit)
    both = np.isfinite(relief) & np.isfinite(worker.relief)
    assert both.mean() > 0.95
    # The crossing of one half is a step: a few pixels may pick the neighbouring surfel.
    assert np.mean(np.abs(relief[both] - worker.relief[both]) > 0.5) < 0.01  # measured 0
    renderer.release()
