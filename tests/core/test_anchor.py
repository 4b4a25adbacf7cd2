"""Anchored float32 projection against extended precision, from level 0 to a x8^12 zoom."""

import numpy as np
import pytest

from tests.gl.surfaces import orbited
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.reference import in_camera, project

# Max error in px by level, 1500 points, four poses each: measured 0.0003 for levels 0 to 10
# (float32 of a 1088 px image), 0.001 at 11, 0.010 at 12 (float64 of the cameras themselves).
LIMIT_PX = 0.02
has_long_doubles = np.finfo(np.longdouble).eps < 1e-18  # not on Windows nor on ARM Macs


def deep_camera(level):
    camera = Camera.initial(1088, 720)
    for _ in range(level):
        camera = camera.zoomed_to_region(0.37, 0.61, 8.0)
    return camera


def points(n=1500):
    rng = np.random.default_rng(0)
    return ((rng.random((n, 3)) - 0.5) * [1088, 720, 300]).astype(np.float32)


@pytest.mark.skipif(not has_long_doubles, reason="no 80-bit floats to be right with")
@pytest.mark.parametrize("level", range(13))
def test_projection_is_exact_at_every_level(level):
    camera = deep_camera(level)
    frame = LevelFrame.of_camera(camera, 1.0 + 0.01 * level)
    for angle_deg in (0.0, 8.0, -30.0):
        turned = orbited(camera, frame.origin, angle_deg)
        for view in (turned, turned.zoomed(300.0, 500.0, 2.7)):
            truth = project(in_camera(points(), frame, view), view)
            error = AnchoredView.expand(view, frame).project(points()) - truth
            assert np.abs(error).max() < LIMIT_PX


def test_a_float32_world_would_be_lost():
    """What the expansion is for: the same points through float32 world coordinates."""
    camera = deep_camera(6)
    frame = LevelFrame.of_camera(camera, 1.0)
    world = frame.to_world(points()).astype(np.float32).astype(np.float64)
    truth = camera.project(frame.to_world(points()))[:, :2]
    assert np.abs(camera.project(world)[:, :2] - truth).max() > 2.0  # measured 4.4 px


def test_depth_and_scale_are_those_of_eq_1():
    camera = deep_camera(2)
    frame = LevelFrame.of_camera(camera, 1.3)
    view_camera = orbited(camera, frame.origin, 5.0).zoomed(100.0, 100.0, 3.0)
    view = AnchoredView.expand(view_camera, frame)
    z = view_camera.project(frame.to_world(points()))[:, 2]
    np.testing.assert_allclose(view.depth * view.depth_ratio(points()), z, rtol=1e-6)
    scale_log = np.log2(z / view_camera.focal_px / frame.unit)
    np.testing.assert_allclose(view.log_scale(points()), scale_log, atol=2e-6)


def test_behind_the_camera_is_undefined():
    camera = deep_camera(0)
    frame = LevelFrame.of_camera(camera, 1.0)
    behind = np.float32([[0, 0, -2 * camera.focal_px], [0, 0, 10]])
    px = AnchoredView.expand(camera, frame).project(behind)
    assert np.isnan(px[0]).all()
    assert np.isfinite(px[1]).all()


def test_the_anchor_projects_to_the_image_centre():
    camera = deep_camera(12)
    frame = LevelFrame.of_camera(camera, 1.0)
    px = AnchoredView.expand(camera, frame).project(np.zeros((1, 3), np.float32))
    np.testing.assert_allclose(px, [[544.0, 360.0]], atol=0.02)  # measured 0.008, float64 at 7e13 px


def test_points_in_front_are_projected_although_the_anchor_lies_behind():
    camera = Camera.initial(640, 480)
    behind = LevelFrame(np.array([0.1, 0.0, -2.0]), np.eye(3), 1e-3)
    points = np.array([[0.2, -0.1, 3.0], [0.0, 0.0, -1.0]])
    means = ((points - behind.origin) / behind.unit).astype(np.float32)
    view = AnchoredView.expand(camera, behind)
    projected = view.project(means)
    np.testing.assert_allclose(projected[0], camera.project(points[0])[:2], atol=1e-4)  # measured 2.4e-6
    assert np.isnan(projected[1]).all()
    expected = np.log2(3.0 / (camera.focal_px * behind.unit))
    assert view.log_scale(means)[0] == pytest.approx(expected, abs=1e-4)
