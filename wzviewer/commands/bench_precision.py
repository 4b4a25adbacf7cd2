"""``bench precision``: where the real shaders put a surfel, level by level, against extended precision.

Lonely splats are drawn, a Gaussian is fitted to the coverage of each, and its centre is compared with
the projection in extended precision.
"""

import argparse
from typing import Any

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.navigation import orbited
from wzviewer.core.reference import in_camera, project
from wzviewer.core.scene import Level, Scene
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.gl.context import GlContext, create_context
from wzviewer.gl.renderer import RasterizerName, SurfelRenderer

WIDTH_PX, HEIGHT_PX = 640, 400
PATCH_PX, BORDER_PX = 3, 8
CENTRE = (0.37, 0.61)  # of every zoom
ORBIT_DEG = 8.0
LEVELS = range(13)

KEYS: dict[RasterizerName, str] = {"shaders": "", "kernels": "_kernels"}  # how their keys end


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns the largest error in px at every level, seen straight and from an orbit of 8 degrees."""
    context = create_context(options.context)
    try:
        record: dict[str, Any] = {}
        for level in LEVELS:
            for rasterizer, key in KEYS.items():
                errors = [projection_error_px(context, level, a, rasterizer) for a in (0.0, ORBIT_DEG)]
                record[f"projection_error_px_level_{level}{key}"] = max(errors)
        return record
    finally:
        context.close()


def projection_error_px(
    context: GlContext, level: int, angle_deg: float, rasterizer: RasterizerName = "shaders"
) -> float:
    """Largest distance in px between drawn and true centres, in a x8^level zoom."""
    camera = Camera.initial(WIDTH_PX, HEIGHT_PX)
    for _ in range(level):
        camera = camera.zoomed_to_region(*CENTRE, 8.0)
    scene = Scene()
    scene.append(lonely_splats(camera))
    view = orbited(camera, scene[0].frame.origin, float(np.deg2rad(angle_deg)), 0.0)
    renderer = SurfelRenderer(context, rasterizer)
    renderer.sync(scene)
    coverage = renderer.render(view).read_coverage()
    renderer.release()
    truth = project(in_camera(scene[0].surfels.means, scene[0].frame, view), view).astype(np.float64)
    limit_px = np.array([WIDTH_PX, HEIGHT_PX]) - BORDER_PX
    inside = np.all((truth > BORDER_PX) & (truth < limit_px), axis=1)
    if np.count_nonzero(inside) < len(truth) // 2:
        return float("inf")  # they were thrown out of the picture
    errors = np.linalg.norm(fitted_centres(coverage, truth[inside]) - truth[inside], axis=1)
    return float(errors.max())


def lonely_splats(camera: Camera) -> Level:
    """Points some 60 px apart with a relief of +-40 native px."""
    frame = LevelFrame.of_camera(camera, 1.0)
    x, y = np.meshgrid(np.linspace(-250, 250, 9), np.linspace(-150, 150, 6))
    rng = np.random.default_rng(3)
    means = np.stack([x.ravel(), y.ravel(), rng.uniform(-40, 40, x.size)], 1).astype(np.float32)
    n = len(means)
    ones = np.ones(n, np.float32)
    quats = np.tile(np.array([1, 0, 0, 0], np.float32), (n, 1))
    scales, white = np.full((n, 2), 1.5, np.float32), np.ones((n, 3), np.float32)
    surfels = Surfels(means, quats, scales, np.full(n, 0.8, np.float32), white, ones, ones)
    image = np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.uint8)
    return Level(0, None, camera, frame, surfels, image, image[..., 0].astype(np.float32))


def fitted_centres(coverage: FloatArray, near_px: DoubleArray) -> DoubleArray:
    """Centres of Gaussians: log alpha is a quadratic in the pixel, whose vertex is solved for.

    Args:
        coverage: (h, w) of lonely splats.
        near_px: (n, 2) where to look, within a pixel or so.
    """
    dy, dx = np.mgrid[-PATCH_PX : PATCH_PX + 1, -PATCH_PX : PATCH_PX + 1]
    found = []
    for x, y in np.floor(near_px).astype(int):
        rows, columns = slice(y - PATCH_PX, y + PATCH_PX + 1), slice(x - PATCH_PX, x + PATCH_PX + 1)
        alpha = coverage[rows, columns].astype(np.float64)
        use = alpha > 0.03
        u, v, weight = dx[use], dy[use], alpha[use]
        terms = np.stack([np.ones(u.size), u, v, u * u, u * v, v * v], 1)
        solution = np.linalg.lstsq(terms * weight[:, None], np.log(weight) * weight, rcond=None)[0]
        _, b, c, d, e, f = solution
        vertex = np.linalg.solve([[2 * d, e], [e, 2 * f]], [-b, -c])
        found.append(vertex + np.array([x + 0.5, y + 0.5]))
    return np.array(found)
