"""Neighbouring cameras keep the anchor; the warp is the projection of `core.camera`."""

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.worker.stages.stage4_auxiliary_views import (
    neighbour_cameras,
    synthesize_auxiliary_views,
    warp_view,
)

ANGLES = ((8.0, 0.0), (-8.0, 0.0), (0.0, 5.0), (6.0, -4.0))


def deep_camera(levels: int) -> Camera:
    camera = Camera.initial(1088, 720)
    for _ in range(levels):
        camera = camera.zoomed_to_region(0.53, 0.41, 8.0)
    return camera


@pytest.mark.parametrize(
    ("level", "tolerance_px"), [(0, 1e-6), (4, 1e-6), (12, 0.01)]
)  # measured 0, 1e-9, 0.004
def test_anchor_keeps_its_pixel(level, tolerance_px):
    camera = deep_camera(level)
    anchor = camera.unproject(544.0, 360.0, 1.7)
    for neighbour in neighbour_cameras(camera, 1.7, ANGLES):
        x_px, y_px, z = neighbour.project(anchor)
        assert abs(x_px - 544) <= tolerance_px
        assert abs(y_px - 360) <= tolerance_px
        assert z == pytest.approx(1.7, rel=1e-12)
        assert np.allclose(neighbour.rotation @ neighbour.rotation.T, np.eye(3), atol=1e-12)


def test_neighbours_turn_by_the_angle_asked_for():
    camera = Camera.initial(200, 120, 200.0)
    anchor = camera.unproject(100.0, 60.0, 1.0)
    for (yaw, pitch), neighbour in zip(ANGLES, neighbour_cameras(camera, 1.0, ANGLES), strict=True):
        a, b = camera.position - anchor, neighbour.position - anchor
        cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
        assert cosine == pytest.approx(np.cos(np.deg2rad(yaw)) * np.cos(np.deg2rad(pitch)), abs=1e-9)
        assert np.linalg.norm(b) == pytest.approx(1.0)


@pytest.mark.parametrize("center", [(100.0, 60.0), (-70.0, 230.0)])
def test_warp_is_the_projection_of_the_camera(center):
    camera = Camera(np.eye(4), 200.0, 200.0, *center, 200, 120)
    rows, columns = np.mgrid[:120, :200].astype(np.float32)
    image = np.stack([columns / 200, rows / 120, 0 * rows], axis=-1).astype(np.float32)
    relief = (10 * np.sin(columns / 30) + 0.1 * rows).astype(np.float32)
    depth_z0 = 2.5
    neighbour = neighbour_cameras(camera, depth_z0, ((6.0, -4.0),))[0]
    view, known = warp_view(image, relief, (), camera, neighbour)
    checked = 0
    for y, x in np.random.default_rng(1).integers(20, 100, (40, 2)):
        depth = depth_z0 * (1 + relief[y, x] / 200.0)
        u, v, _ = neighbour.project(camera.unproject(x + 0.5, y + 0.5, depth))
        i, j = int(v), int(u)
        if 1 <= i < 118 and 1 <= j < 198 and known[i, j]:
            found = view[i, j, :2] * [200, 120] - [x, y]
            assert np.abs(found - [j + 0.5 - u, i + 0.5 - v]).max() < 0.25  # measured 0.12: local stretch
            checked += 1
    assert checked > 20


def test_the_source_camera_sees_the_picture_itself():
    rng = np.random.default_rng(0)
    image = rng.random((60, 90, 3)).astype(np.float32)
    relief = np.where(np.arange(90)[None] < 40, -30.0, 25.0).astype(np.float32) + np.zeros(
        (60, 1), np.float32
    )
    camera = Camera.initial(90, 60, 90.0)
    view, known = warp_view(image, relief, (), camera, camera)
    inner = known & (np.arange(90) > 1) & (np.arange(90) < 88)
    assert inner.mean() > 0.9
    assert np.abs(view[inner] - image[inner]).max() < 1e-4


def test_steps_tear_and_nearer_wins():
    image = np.zeros((60, 90, 3), np.float32)
    image[:, :40] = 1
    relief = np.where(np.arange(90)[None] < 40, -40.0, 60.0).astype(np.float32) + np.zeros(
        (60, 1), np.float32
    )
    camera = Camera.initial(90, 60, 90.0)
    left, right = neighbour_cameras(camera, 1.0, ((8.0, 0.0), (-8.0, 0.0)))
    shares = [warp_view(image, relief, (), camera, view)[1][10:50, 15:75].mean() for view in (left, right)]
    assert min(shares) < 0.9 < max(shares)  # a hole on one side, an overlap on the other
    overlap = warp_view(image, relief, (), camera, (left, right)[int(np.argmax(shares))])[0]
    row = overlap[30, 15:75, 0]
    assert (np.diff(row) <= 1e-4).all()  # the near half stays whole, in front


def test_stage_returns_layers_and_cameras():
    image = np.tile(np.linspace(0, 1, 96, dtype=np.float32)[None, :, None], (64, 1, 3))
    relief = np.full((64, 96), 40.0, np.float32)
    relief[20:44, 30:60] = -30
    camera = Camera.initial(96, 64, 96.0)
    views = synthesize_auxiliary_views(np.ascontiguousarray(image), relief, None, camera, 1.0, outside=False)
    assert len(views.layers) >= 1
    assert len(views.cameras) == 4
    assert views.relief.shape == (64, 96)
