"""The reference renderer against closed forms that need no renderer."""

from dataclasses import replace

import numpy as np
import pytest

from tests.gl.surfaces import add_surface, flat_scene, hill_scene, hills, noise_image, orbited
from wzviewer.core import reference
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ALPHA_CUT, ALPHA_MAX, LOW_PASS_PX2
from wzviewer.core.opacity import weights
from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.core.surfels import Surfels


def scene_of(camera, means, scales, opacities, colors, quats=None):
    """One level whose local frame has the camera's axes and a pixel of depth 1 as its unit."""
    n = len(means)
    quats = np.tile([1.0, 0, 0, 0], (n, 1)) if quats is None else quats
    surfels = Surfels(means, quats, scales, opacities, colors, np.ones(n), np.ones(n))
    blank = np.zeros((camera.height, camera.width, 3), np.uint8)
    frame = LevelFrame.of_camera(camera, 1.0)
    scene = Scene()
    scene.append(Level(0, None, camera, frame, surfels, blank, blank[..., 0].astype(np.float32)))
    return scene


CAMERA = Camera.initial(24, 16)


def test_one_surfel_is_its_gaussian():
    scene = scene_of(CAMERA, [[0.3, -0.2, 0]], [[2.0, 1.0]], [0.8], [[1, 0.5, 0]])
    frame = reference.render(scene, CAMERA)
    y, x = np.mgrid[0:16, 0:24] + 0.5
    dx, dy = x - 12.3, y - 7.8
    alpha = 0.8 * np.exp(-0.5 * (dx**2 / (4 + LOW_PASS_PX2) + dy**2 / (1 + LOW_PASS_PX2)))
    alpha[alpha < ALPHA_CUT] = 0.0
    np.testing.assert_allclose(frame.coverage, alpha, atol=1e-6)  # float32 of the mean: 1e-8 px
    np.testing.assert_allclose(frame.color, alpha[..., None] * [1, 0.5, 0], atol=1e-6)
    np.testing.assert_array_equal(frame.level, np.where(alpha >= 0.5, 0, -1))
    assert np.isnan(frame.depth[alpha < 0.5]).all()
    np.testing.assert_allclose(frame.depth[alpha >= 0.5], 1.0)


def test_the_footprint_is_the_projection_of_the_surfel():
    """Points of the one-sigma ellipse, projected, fall on the one-sigma ellipse of the conic."""
    rng = np.random.default_rng(0)
    quats = rng.normal(size=(20, 4))
    means = (rng.random((20, 3)) - 0.5) * [20, 12, 8]
    small = 1e-3  # the footprint is linearised at the centre
    scene = scene_of(CAMERA, means, np.full((20, 2), small) * [2, 1], np.ones(20), np.ones((20, 3)), quats)
    view = orbited(CAMERA, scene[0].frame.origin, 20.0)
    parts = reference.scene_footprints(scene, view)
    t1, t2 = reference.surfel_axes(scene[0].surfels.quats.astype(np.float64))
    for angle in np.linspace(0, 2 * np.pi, 7):
        rim = scene[0].surfels.means + small * (2 * np.cos(angle) * t1 + np.sin(angle) * t2)
        px = reference.project(reference.in_camera(rim, scene[0].frame, view), view).astype(np.float64)
        d = px - parts.centers_px
        cov = np.linalg.inv(parts.conics[:, [0, 1, 1, 2]].reshape(-1, 2, 2)) - LOW_PASS_PX2 * np.eye(2)
        flat = np.linalg.det(cov) > 1e-9 * small**2  # seen edge-on it has no inside
        q = np.einsum("ni,nij,nj->n", d, np.linalg.inv(cov), d)
        np.testing.assert_allclose(q[flat & (np.linalg.cond(cov) < 1e3)], 1.0, rtol=1e-2)


def test_two_layers_composite_front_to_back():
    means = [[0, 0, 3.0], [0, 0, -3.0]]  # the first is behind
    scene = scene_of(CAMERA, means, np.full((2, 2), 40.0), [0.6, 0.5], [[1, 0, 0], [0, 1, 0]])
    frame = reference.render(scene, CAMERA)
    np.testing.assert_allclose(frame.color[8, 12], [0.5 * 0.6, 0.5, 0], atol=1e-3)
    np.testing.assert_allclose(frame.coverage[8, 12], 0.8, atol=1e-3)
    red, blue = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    over = frame.over(blue)[8, 12]
    np.testing.assert_allclose(over, 0.3 * red + [0, 0.5, 0] + 0.2 * blue, atol=2e-3)


def test_opacity_is_clamped_and_ties_go_to_the_lower_index():
    scene = scene_of(CAMERA, np.zeros((2, 3)), np.full((2, 2), 40.0), [1.0, 1.0], [[1, 0, 0], [0, 1, 0]])
    frame = reference.render(scene, CAMERA)
    np.testing.assert_allclose(frame.color[8, 12], [ALPHA_MAX, ALPHA_MAX * (1 - ALPHA_MAX), 0], atol=1e-9)


def test_median_depth_is_that_of_the_surfel_that_crosses_one_half():
    means = [[0, 0, -3.0], [0, 0, 0], [0, 0, 3.0]]
    scene = scene_of(CAMERA, means, np.full((3, 2), 60.0), [0.3, 0.4, 0.9], np.ones((3, 3)))
    frame = reference.render(scene, CAMERA)
    # 0.7 is left behind the first, 0.42 behind the second.
    np.testing.assert_allclose(frame.depth[8, 12], 1.0, atol=1e-12)


def test_weights_are_those_of_core_opacity():
    scene = hill_scene(24, 16, 3)
    for camera in (
        scene[0].camera.zoomed(10.0, 9.0, 3.0),
        scene[1].camera,
        scene[2].camera.zoomed(9, 9, 0.4),
    ):
        for level in scene:
            s = level.surfels
            view = AnchoredView.expand(camera, level.frame)
            arrays, law = (s.means, s.native_scales, s.coverage), modulation(scene, level.index)
            for compensated in (False, True):
                fast = weights(*arrays, view, law, compensated)
                slow = reference.level_weights(scene, level.index, s, camera, compensated)
                np.testing.assert_allclose(slow, fast, atol=1e-6)  # measured 1e-7


def test_siblings_and_their_covers_are_the_scenes():
    scene, root = Scene(), CAMERA
    first = root.zoomed_to_region(0.4, 0.5, 4.0)
    for parent, camera in ((None, root), (0, first), (0, root.zoomed_to_region(0.5, 0.5, 5.0)), (1, first)):
        add_surface(scene, parent, camera, hills(camera, root), noise_image(camera, 0))
    assert reference.covers_of(scene, 0) == [1, 2]
    assert reference.covers_of(scene, 3) == [2]
    assert [len(modulation(scene, i).covers) for i in range(4)] == [
        len(reference.covers_of(scene, i)) for i in range(4)
    ]


@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_half_way_between_two_levels_light_is_kept(blend):
    scene = flat_scene(32, 24)
    camera = scene[0].camera.zoomed(16.0, 12.0, np.sqrt(8.0))
    between_pixels = replace(scene[0].camera, cx=scene[0].camera.cx + 0.31, cy=scene[0].camera.cy + 0.31)
    middle = reference.render(scene, camera, blend).coverage[9:15, 12:20]
    ends = reference.render(scene, between_pixels, blend).coverage[10:14, 14:18]
    leak = (1 - middle).mean() - (1 - ends).mean()
    assert (leak < -0.015) if blend == "transmittance" else (leak > -0.01)  # measured -0.019 and -0.008


@pytest.mark.parametrize(("behind_px", "finer"), [(-3.0, True), (0.0, True), (3.0, True), (5.0, False)])
def test_of_two_levels_as_deep_as_their_noise_the_finer_one_is_in_front(behind_px, finer):
    """`behind_px`: of the coarser level's own pixels."""
    scene = flat_scene(32, 24)
    child = scene[1].surfels
    means = child.means + np.float32([0.0, 0.0, 8.0 * behind_px])
    scene.replace(scene[1].with_surfels(child.with_(means=means)))
    camera = scene[0].camera.zoomed(16.0, 12.0, np.sqrt(8.0))
    parts = reference.scene_footprints(scene, camera).ordered()
    assert (np.diff(parts.levels) <= 0).all() == finer
    assert (np.diff(parts.levels) >= 0).all() == (not finer)


def test_the_focus_is_the_level_seen_nearest_to_its_own_scale():
    scene = hill_scene(24, 16, 3)
    frames = [level.frame for level in scene]
    for level in scene:
        focus = reference.focus_of(level.camera, frames)
        np.testing.assert_allclose(focus.depth, level.anchor_depth, rtol=1e-12)
        np.testing.assert_allclose(focus.unit, level.frame.unit, rtol=1e-12)
    assert reference.focus_of(CAMERA, []).depth == 1.0


def test_nothing_to_see_is_transparent():
    frame = reference.render(Scene(), CAMERA)
    assert frame.coverage.max() == 0.0
    assert np.isnan(frame.depth).all()
    behind = scene_of(CAMERA, [[0, 0, -1e4]], [[1.0, 1.0]], [0.9], [[1, 1, 1]])
    assert reference.render(behind, CAMERA).coverage.max() == 0.0


def test_a_window_is_a_crop():
    scene = hill_scene(24, 16, 1)
    parts = reference.scene_footprints(scene, CAMERA).ordered()
    whole = reference.composite(parts, 24, 16)
    window = reference.composite(parts, 7, 5, left=9, top=4)
    np.testing.assert_allclose(window.color, whole.color[4:9, 9:16], atol=1e-12)
    np.testing.assert_array_equal(window.level, whole.level[4:9, 9:16])
