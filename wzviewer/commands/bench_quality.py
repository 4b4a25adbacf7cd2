"""How right a frame is: against the slow exact renderer, and against what an ideal lens would show.

``reference_psnr_db_*`` compares with `core.reference` zoomed out x8, at the native scale and zoomed in
x8: the error of the renderer.  ``minified_psnr_db_*`` compares with the native frame, averaged over
areas: the aliasing of surfels smaller than a pixel, with merged surfels and without.
"""

from typing import Any

import cv2
import numpy as np

from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.commands.rendering import picture, scene_renderer
from wzviewer.core import reference
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.gl.context import ContextKind
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import RasterizerName

REFERENCE_SIZE_PX = (136, 88)
MAGNIFICATIONS = {"out8": 1 / 8, "native": 1.0, "in8": 8.0}
REDUCTIONS = (2, 4, 8)


def measure_quality(full: Scene, kind: ContextKind, rasterizer: RasterizerName) -> dict[str, Any]:
    """Returns PSNR in dB.

    Args:
        full: a scene whose root is of full size.
        kind: of the context.
        rasterizer: of the renderer.
    """
    return {**_fidelity(kind, rasterizer), **_antialiasing(full, kind, rasterizer)}


def psnr_db(image: FloatArray, truth: FloatArray) -> float:
    """Peak signal-to-noise ratio of images in [0, 1], dB."""
    return float(-10.0 * np.log10(max(np.square(image - truth).mean(), 1e-20)))


def _fidelity(kind: ContextKind, rasterizer: RasterizerName) -> dict[str, float]:
    scene = chain_scene(2, _small(), relief_px=3.0)
    settings, found = RenderSettings(antialias=False), {}
    with scene_renderer(scene, kind, rasterizer) as renderer:
        for name, magnification in MAGNIFICATIONS.items():
            camera = _magnified(scene[0].camera, magnification)
            expected = reference.render(scene, camera).color.astype(np.float32)
            color = renderer.render(camera, settings).read_color()[..., :3]
            found[f"reference_psnr_db_{name}"] = psnr_db(color, expected)
    return found


def _small() -> ByteArray:
    from wzviewer.core.assets import demo_picture
    from wzviewer.core.photos import load_photo

    return np.ascontiguousarray(
        cv2.resize(load_photo(demo_picture()), REFERENCE_SIZE_PX, interpolation=cv2.INTER_AREA)
    )


def _magnified(camera: Camera, magnification: float) -> Camera:
    return camera.zoomed(0.4 * camera.width, 0.6 * camera.height, magnification)


def _antialiasing(full: Scene, kind: ContextKind, rasterizer: RasterizerName) -> dict[str, float]:
    scene, found = Scene(), {}
    scene.append(full[0])
    scene.commit(0)
    camera = full[0].camera
    with scene_renderer(scene, kind, rasterizer) as renderer:
        native = picture(renderer, camera).astype(np.float32) / 255.0
        for k in REDUCTIONS:
            small = camera.resized(camera.width // k, camera.height // k)
            truth = cv2.resize(native, (small.width, small.height), interpolation=cv2.INTER_AREA)
            for name, antialias in (("", True), ("_exact", False)):
                image = picture(renderer, small, RenderSettings(antialias=antialias))
                found[f"minified_psnr_db_{k}{name}"] = psnr_db(image.astype(np.float32) / 255.0, truth)
    return found
