"""The measures of ``bench transition``: they hold on a small chain, and find defects that are planted."""

from dataclasses import replace

import numpy as np
import pytest

from wzviewer.app.pacing import SPACING_PX
from wzviewer.commands import bench_transition as bench
from wzviewer.commands.bench_scenes import chain_scene, consistent_chain
from wzviewer.core import opacity
from wzviewer.core.navigation import orbited
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

WIDTH, HEIGHT, FRAMES = 160, 112, 49
LATE = 21  # a frame at 7/8 of the first of two transitions
RASTERIZERS = ["shaders", "kernels"]
CORNERS = 5.5  # limit of a pop where Eq. 3 begins and ends: its ramps have corners, an eased one gives 1.9


@pytest.fixture(scope="module")
def chain():
    return consistent_chain(3, WIDTH, HEIGHT)


@pytest.fixture(scope="module")
def white():
    return chain_scene(3, np.full((HEIGHT, WIDTH, 3), 200, np.uint8), relief_px=0.0)


@pytest.fixture
def drawn(gl_context):
    """Makes renderers that hold a scene."""
    renderers = []

    def make(scene, rasterizer="kernels"):
        renderers.append(SurfelRenderer(gl_context, rasterizer))
        renderers[-1].sync(scene)
        return renderers[-1]

    yield make
    for renderer in renderers:
        renderer.release()


def film(renderer, path, **settings):
    return list(bench.pictures(renderer, path, RenderSettings(**settings)))


def ratios(frames, path):
    found = bench.changes(frames, path)
    return bench.ratio(found.steps), bench.ratio(found.pops), bench.ratio(found.local_pops)


@pytest.fixture(scope="module")
def straight(chain, gl_context):
    """A zoom with no defect, and its cameras."""
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(chain)
    path = bench.straight_zoom(chain, FRAMES)
    frames = film(renderer, path)
    renderer.release()
    return frames, path


# ---------------------------------------------------------------- laws


@pytest.mark.parametrize("rasterizer", RASTERIZERS)
@pytest.mark.parametrize(
    ("name", "limit"),
    # Measured 4.5, 4.5 and 3.4; a slide stays between two scales, where nothing begins or ends.
    [("straight", CORNERS), ("pan", CORNERS), ("oblique", CORNERS), ("slide", 3.0), ("slide_native", 3.0)],
)
def test_no_step_of_a_path_stands_out(chain, drawn, rasterizer, name, limit):
    path = bench.paths(chain, FRAMES)[name]
    step, pop, local = ratios(film(drawn(chain, rasterizer), path), path)
    assert step <= 3.0
    assert pop <= limit
    assert local <= limit


@pytest.mark.parametrize("rasterizer", RASTERIZERS)
@pytest.mark.parametrize("name", ["straight", "pan", "oblique", "slide", "slide_native"])
def test_no_light_leaks_along_a_path(white, drawn, rasterizer, name):
    renderer = drawn(white, rasterizer)
    alone = bench.alone_through(renderer, white, "transmittance")
    path = bench.paths(white, FRAMES)[name][::4]
    assert bench.path_through(renderer, white, path, "transmittance") - alone <= 0.005


def test_merged_surfels_take_over_without_a_step(chain, drawn):
    renderer = drawn(chain)
    renderer.wait_for_merged(chain)
    path = bench.straight_zoom(chain, FRAMES)
    step, pop, _ = ratios(film(renderer, path, spacing_px=SPACING_PX), path)
    assert step <= 3.0
    assert pop <= 7.0  # measured 6.2; 3.3 with an eased ramp: 0.15 grey levels where a form changes


# ---------------------------------------------------------------- planted defects


def test_a_child_that_appears_at_once_is_found(chain, drawn, straight):
    """No ramp of Eq. 3: the child is hidden up to 7/8 of the transition."""
    frames, path = straight
    renderer = drawn(chain)
    chain.hide(1)
    renderer.sync(chain)
    without = film(renderer, path[: LATE + 1])
    chain.show(1)
    _, pop, local = ratios(without + frames[LATE + 1 :], path)
    assert pop > 3.0
    assert local > 3.0


def test_a_child_without_a_feather_is_found(drawn, monkeypatch):
    for module in (opacity, bench):
        monkeypatch.setattr(module, "feather_px", lambda camera: 1e-3)
    scene = chain_scene(3, np.full((HEIGHT, WIDTH, 3), 200, np.uint8), relief_px=0.0)
    renderer = drawn(scene)
    alone = bench.alone_through(renderer, scene, "transmittance")
    path = bench.panning_zoom(scene, FRAMES)[::4]
    assert bench.path_through(renderer, scene, path, "transmittance") - alone > 0.005
    alike = consistent_chain(3, WIDTH, HEIGHT)
    path = bench.straight_zoom(alike, FRAMES)
    assert ratios(film(drawn(alike), path), path)[2] > 3.0


@pytest.mark.parametrize(("size_px", "found"), [(WIDTH, [False, True, True]), (16, [False, False, True])])
def test_a_flash_is_found(chain, drawn, size_px, found):
    """One frame 2 % brighter, all of it or a corner: less than the motion, more than anything else."""
    path = bench.slide(chain[1].camera, FRAMES)
    frames = film(drawn(chain), path)
    assert max(ratios(frames, path)) <= 3.0
    flash = frames[LATE].astype(np.float32)
    flash[:size_px, :size_px] *= 1.02
    frames[LATE] = np.rint(flash).clip(0, 255).astype(np.uint8)
    assert [value > 3.0 for value in ratios(frames, path)] == found


# ---------------------------------------------------------------- the measure itself


def test_motion_alone_is_no_pop(chain):
    """A picture of the plane, drawn from its own formula, moves by grey levels and pops by none."""
    camera = chain[0].camera
    others = [
        camera.zoomed(60.0, 40.0, 1.1),
        replace(camera, cx=camera.cx + 3.3),
        orbited(camera, chain[0].frame.origin, np.deg2rad(3.0), 0.0),
    ]
    for other in others:
        step = np.abs(waves(other) - waves(camera)).mean()
        pop, seen = bench.difference(waves(other), other, waves(camera), camera)
        assert seen.mean() > 0.7
        assert step > 2.0
        assert pop[seen].mean() < 0.02 * step  # measured 0.011


def waves(camera):
    """A smooth pattern on the plane z = 1, (h, w)."""
    y, x = np.mgrid[0 : camera.height, 0 : camera.width] + 0.5
    rays = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones_like(x)], -1)
    rays = rays @ camera.rotation
    at = camera.position + (1.0 - camera.position[2]) / rays[..., 2:] * rays
    pattern = 128.0 + 60.0 * np.sin(40.0 * at[..., 0]) * np.cos(50.0 * at[..., 1])
    return pattern.astype(np.float32)


def test_keys_of_a_path():
    found = bench.Changes(np.array([1.0, 2.0, 6.0]), np.array([1.0, 1.0, 4.0]), np.array([2.0, 2.0, 10.0]))
    figures = found.figures("_pan")
    assert figures["transition_step_ratio_pan"] == 3.0
    assert figures["transition_step_mean_pan"] == 3.0
    assert figures["transition_pop_ratio_pan"] == 4.0
    assert figures["transition_pop_local_ratio_pan"] == 5.0


def test_a_borders_middle_passes_the_pictures_middle(chain):
    """Half-way between two scales the pan has left the child for good measure, and comes back."""
    path = bench.panning_zoom(chain, 65)
    child = chain[1].camera
    middle = [bench.image_points(c, child)[HEIGHT // 2, WIDTH // 2, 0] / child.width for c in path]
    assert abs(middle[0] - 0.5) < 4.0  # at the parent's scale the child is anywhere in the picture
    assert middle[16] > 1.0  # beyond its right border
    assert abs(middle[32] - 0.5) < 0.05
