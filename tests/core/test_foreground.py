from dataclasses import replace

import numpy as np
import pytest

from tests.app.fakes import make_scene
from wzviewer.commands import cameras
from wzviewer.core.foreground import foreground_depth, is_sky, turning_point
from wzviewer.core.scene import Scene


@pytest.fixture
def scene():
    """Sky at 60 in the upper four fifths, ground at 1 below; the anchor is in the sky."""
    made, level = Scene(), make_scene(1)[0]
    sky = np.zeros(level.relief.shape, np.uint8)
    sky[: 4 * len(sky) // 5] = 1
    relief = np.where(sky, (60.0 - level.anchor_depth) / level.frame.unit, 0.0).astype(np.float32)
    frame = replace(level.frame, origin=np.array([0.0, 0.0, 60.0]))
    made.append(replace(level, relief=relief, maps={"sky": sky}, frame=frame))
    made.commit(0)
    return made


def test_the_sky_is_not_turned_about(scene):
    camera = scene[0].camera
    sky, ground = camera.unproject(68.0, 45.0, 60.0), camera.unproject(68.0, 85.0, 1.0)
    assert is_sky(scene, sky)
    assert not is_sky(scene, ground)
    near = foreground_depth(scene, camera)
    assert turning_point(scene, camera, ground) is ground
    pivot = turning_point(scene, camera, sky)
    assert camera.to_camera(pivot)[2] == pytest.approx(near)
    np.testing.assert_allclose(camera.project(pivot)[:2], [68.0, 45.0], atol=1e-9)


def test_an_orbit_film_turns_about_the_foreground(scene):
    before = scene[0].camera
    near = before.unproject(68.0, 85.0, foreground_depth(scene, before))
    shifts = [
        np.linalg.norm(camera.project(near)[:2] - before.project(near)[:2])
        for camera in cameras.orbit_path(scene, 0, angle_deg=8.0, fps=4)
    ]
    assert max(shifts) < 6.0  # measured 3.0 px of 136; about the sky 8500 px
    still = cameras.camera_of(scene, 0, orbit_deg=8.0)
    assert np.linalg.norm(still.project(near)[:2] - before.project(near)[:2]) < 6.0


def test_without_sky_nothing_changes():
    plain = make_scene(1)
    point = plain[0].frame.origin
    assert turning_point(plain, plain[0].camera, point) is point
