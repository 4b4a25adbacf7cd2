"""Where the real shaders put a surfel, from its level's own x8^k zoom, against extended precision."""

import numpy as np
import pytest

from tests.gl.surfaces import orbited
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.reference import in_camera, project
from wzviewer.core.scene import Level, Scene
from wzviewer.core.surfels import Surfels
from wzviewer.gl.renderer import SurfelRenderer

WIDTH, HEIGHT = 640, 400
PATCH_PX = 3
LIMIT_PX = 0.02  # of the design; measured 4e-5 to level 10, 2e-4 at 11, 0.0024 at 12 (float64's own)


def grid_level(camera):
    """Points some 60 px apart with a relief of +-40 native px, each its own lonely splat."""
    frame = LevelFrame.of_camera(camera, 1.0)
    x, y = np.meshgrid(np.linspace(-250, 250, 9), np.linspace(-150, 150, 6))
    rng = np.random.default_rng(3)
    means = np.stack([x.ravel(), y.ravel(), rng.uniform(-40, 40, x.size)], 1)
    n = len(means)
    ones, quats = np.ones(n), np.tile([1.0, 0, 0, 0], (n, 1))
    surfels = Surfels(means, quats, np.full((n, 2), 1.5), np.full(n, 0.8), np.ones((n, 3)), ones, ones)
    blank = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    return Level(0, None, camera, frame, surfels, blank, blank[..., 0].astype(np.float32))


def fitted_centres(alpha, near_px):
    """Centres of Gaussians: log alpha is a quadratic in the pixel, whose vertex is solved for."""
    dy, dx = np.mgrid[-PATCH_PX : PATCH_PX + 1, -PATCH_PX : PATCH_PX + 1]
    found = []
    for x, y in np.floor(near_px).astype(int):
        a = alpha[y - PATCH_PX : y + PATCH_PX + 1, x - PATCH_PX : x + PATCH_PX + 1].astype(np.float64)
        use = a > 0.03
        u, v = dx[use], dy[use]
        terms = np.stack([np.ones(u.size), u, v, u * u, u * v, v * v], 1)
        _, b, c, d, e, f = np.linalg.lstsq(terms * a[use][:, None], np.log(a[use]) * a[use], rcond=None)[0]
        vertex = np.linalg.solve([[2 * d, e], [e, 2 * f]], [-b, -c])
        found.append(vertex + np.array([x + 0.5, y + 0.5]))
    return np.array(found)


@pytest.mark.parametrize("level", [0, 3, 6, 9, 12])
@pytest.mark.parametrize("angle_deg", [0.0, 8.0])
def test_a_splat_is_drawn_where_it_belongs(gl_context, level, angle_deg):
    camera = Camera.initial(WIDTH, HEIGHT)
    for _ in range(level):
        camera = camera.zoomed_to_region(0.37, 0.61, 8.0)
    scene = Scene()
    scene.append(grid_level(camera))
    view = orbited(camera, scene[0].frame.origin, angle_deg)
    renderer = SurfelRenderer(gl_context)
    renderer.sync(scene)
    alpha = renderer.render(view).read_coverage()
    renderer.release()
    truth = project(in_camera(scene[0].surfels.means, scene[0].frame, view), view).astype(np.float64)
    inside = ((truth > 8) & (truth < [WIDTH - 8, HEIGHT - 8])).all(1)
    assert inside.sum() > 25
    error = np.linalg.norm(fitted_centres(alpha, truth[inside]) - truth[inside], axis=1)
    assert error.max() < LIMIT_PX
