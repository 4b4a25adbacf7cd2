"""The surface under the pointer is found among a level's surfels without projecting them all."""

import numpy as np
import pytest

from tests.gl.surfaces import hill_scene, orbited
from wzviewer.core.scene import Scene
from wzviewer.gl import picking
from wzviewer.gl.renderer import SurfelRenderer

HUGE = 8000  # one surfel of the scene, in the middle of its rows


@pytest.fixture
def projected(monkeypatch):
    """How many surfels each call projects in full."""
    counts, whole = [], picking.footprints

    def counted(surfels, *arguments):
        counts.append(len(surfels))
        return whole(surfels, *arguments)

    monkeypatch.setattr(picking, "footprints", counted)
    return counts


def scene_with_one_huge_surfel():
    """A backdrop's surfels are as large as the image; its neighbours must not be taken for such."""
    plain, scene = hill_scene(160, 112, num_levels=1), Scene()
    scales = plain[0].surfels.scales.copy()
    scales[HUGE] *= 60.0
    opacities = plain[0].surfels.opacities.copy()
    opacities[HUGE] = 0.1  # else it hides what is behind it
    scene.append(plain[0].with_surfels(plain[0].surfels.with_(scales=scales, opacities=opacities)))
    return scene


def test_only_what_may_reach_the_pointer_is_projected(gl_context, projected):
    scene = scene_with_one_huge_surfel()
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(scene)
    assert renderer.pick(scene[0].camera, 90.2, 60.7) is not None
    assert 1 <= sum(projected) < 0.08 * len(scene[0].surfels)  # measured 0.039
    renderer.release()


@pytest.mark.parametrize("angle_deg", [0.0, 35.0, -70.0])
def test_nothing_that_reaches_the_pointer_is_left_out(gl_context, monkeypatch, angle_deg):
    scene = scene_with_one_huge_surfel()
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(scene)
    camera = orbited(scene[0].camera, scene[0].frame.origin, angle_deg).zoomed(90.0, 60.0, 1.7)
    at = [(12.5, 30.5), (80.0, 56.0), (91.3, 61.9), (150.0, 100.0)]
    found = [renderer.pick(camera, *place) for place in at]
    monkeypatch.setattr(picking, "_reaches", lambda run, size_px: np.ones(len(run), bool))
    assert found == [renderer.pick(camera, *place) for place in at]
    assert any(found)
    renderer.release()
