"""No light leaks between two full levels of one plane, 8x apart, on the way from one to the other."""

from dataclasses import replace

import numpy as np
import pytest

from tests.gl.surfaces import flat_scene
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

STEPS = np.linspace(0.0, 1.0, 9)


def leaks(gl_context, blend, rasterizer="shaders"):
    """Mean of 1 - coverage over the middle of the child's image at magnifications 8^t."""
    scene = flat_scene(96, 72)
    renderer = SurfelRenderer(gl_context, rasterizer)
    renderer.sync(scene)
    found = []
    for t in STEPS:
        camera = scene[0].camera.zoomed(48.0, 36.0, 8.0**t)
        camera = replace(camera, cx=camera.cx + 0.31, cy=camera.cy + 0.31)  # off the pixel grid
        coverage = renderer.render(camera, RenderSettings(blend=blend)).read_coverage()
        half = 2.25 * 8.0**t  # three quarters of the child's half height, inside its feather
        y, x = np.mgrid[0:72, 0:96] + 0.5
        inside = (np.abs(x - 48.31) < half) & (np.abs(y - 36.31) < half)
        found.append(float(1.0 - coverage[inside].mean()))
    renderer.release()
    return np.array(found)


@pytest.mark.parametrize(
    ("blend", "limit"),
    # Measured: transmittance -0.001 (never more than at the ends), linear 0.012 as the paper has it.
    [("transmittance", 0.005), ("linear", 0.03)],
)
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_leak_during_a_transition(gl_context, blend, limit, rasterizer):
    leak = leaks(gl_context, blend, rasterizer)
    assert leak[1:-1].max() - max(leak[0], leak[-1]) <= limit
    assert max(leak[0], leak[-1]) < 0.08  # one level alone, off the grid: measured 0.057


@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_no_line_along_a_childs_border(gl_context, rasterizer):
    """At the child's own scale its border is as closed as one level is; presenting hides up to 0.1."""
    scene = flat_scene(192, 128)
    renderer = SurfelRenderer(gl_context, rasterizer)
    renderer.sync(scene)
    camera = scene[1].camera
    camera = replace(camera, cx=camera.cx - 96.0 + 0.31, cy=camera.cy + 0.27)  # on the right border
    settings = RenderSettings()
    lost = 1.0 - renderer.render(camera, settings).read_coverage()
    renderer.release()
    # Measured 0.103 with a feather of 28 px; with one of 4 % of the height 0.189.
    assert lost[16:-16].max() < 1.1 * (1.0 - settings.closed_coverage)


def test_the_linear_law_leaks_more(gl_context):
    assert leaks(gl_context, "linear")[4] > leaks(gl_context, "transmittance")[4] + 0.01
