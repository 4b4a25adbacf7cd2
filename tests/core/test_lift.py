"""Lifting: footprints are round where they are made, normals know planes from steps."""

import numpy as np
import pytest

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import SURFEL_SIGMA_PX
from wzviewer.core.lift import BLOCK_PX, lift, lift_spanned, normals_from_relief

F = 200.0


def wide_camera(width=64, height=43):
    """Off-axis and with unequal focal lengths, so that no symmetry hides a mistake."""
    return Camera(np.eye(4), F, F * 1.1, width / 2 + 90.0, height / 2 - 40.0, width, height)


def plane_relief(camera, normal, z0=1.0):
    """Relief of the plane through the anchor with this normal, from the ray-plane equation alone."""
    x, y = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    rays = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones_like(x)], -1)
    anchor = camera.unproject(camera.width / 2, camera.height / 2, z0)
    z = (anchor @ normal) / (rays @ normal)
    return ((z - z0) / (z0 / camera.focal_px)).astype(np.float32)


def rotations(quats):
    w, x, y, z = quats.astype(np.float64).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def screen_covariances(surfels, camera, frame):
    """J Cov J^T with the Jacobian of `Camera.project` by central differences."""
    R = rotations(surfels.quats)[:, :, :2] * surfels.scales.astype(np.float64)[:, None, :]
    centres = surfels.means.astype(np.float64)
    step, columns = 1e-3, []
    for axis in range(2):
        ends = [
            frame.origin + frame.unit * (centres + s * step * R[:, :, axis]) @ frame.axes for s in (1, -1)
        ]
        columns.append((camera.project(ends[0]) - camera.project(ends[1]))[:, :2] / (2 * step))
    U = np.stack(columns, -1)
    return U @ U.transpose(0, 2, 1)


@pytest.mark.parametrize("normal", [(0.0, 0.0, -1.0), (0.6, 0.3, -0.7), (-0.2, 0.9, -0.4)])
def test_normals_of_a_plane_are_its_normal(normal):
    camera = wide_camera()
    n = np.array(normal) / np.linalg.norm(normal)
    n = n if n @ [(32 - camera.cx) / F, (21 - camera.cy) / F, 1] < 0 else -n
    found = normals_from_relief(plane_relief(camera, n), camera)
    assert np.abs(found - n).max() < 1e-5  # measured 1e-6


@pytest.mark.parametrize("normal", [(0.0, 0.0, -1.0), (0.6, 0.3, -0.7), (-0.2, 0.6, -0.7)])
def test_footprints_are_round_in_the_creating_camera(normal):
    camera = wide_camera()
    n = np.array(normal) / np.linalg.norm(normal)
    relief = plane_relief(camera, n)
    surfels = lift(np.zeros((43, 64, 3), np.float32), relief, camera)
    assert (surfels.scales[:, 0] < 9.99 * surfels.scales[:, 1]).all()  # none at the tilt limit
    covariances = screen_covariances(surfels, camera, LevelFrame.of_camera(camera, 1.0))
    error = np.abs(covariances / SURFEL_SIGMA_PX**2 - np.eye(2)).max()
    assert error < 1e-5  # measured 3e-7


def test_third_axis_faces_the_camera_and_first_runs_along_the_tilt():
    camera = wide_camera()
    n = np.array([0.6, 0.3, -0.7]) / np.linalg.norm([0.6, 0.3, -0.7])
    surfels = lift(np.zeros((43, 64, 3), np.float32), plane_relief(camera, n), camera)
    R = rotations(surfels.quats)
    assert np.abs(R[:, :, 2] - n).max() < 1e-5  # measured 1e-6
    assert np.allclose(np.linalg.det(R), 1.0, atol=1e-5)
    assert (surfels.scales[:, 0] >= surfels.scales[:, 1]).all()


def test_lifted_points_are_the_unprojected_pixels():
    camera = wide_camera().zoomed_to_region(0.3, 0.8, 8.0)
    rng = np.random.default_rng(1)
    relief = rng.normal(0, 3, (43, 64)).astype(np.float32)
    surfels = lift(np.zeros((43, 64, 3), np.float32), relief, camera)
    frame = LevelFrame.of_camera(camera, 0.7)
    world = frame.to_world(surfels.means)
    depth = 0.7 + frame.unit * relief.astype(np.float64)
    x, y = np.meshgrid(np.arange(64) + 0.5, np.arange(43) + 0.5)
    truth = np.stack([camera.unproject(*p) for p in zip(x.ravel(), y.ravel(), depth.ravel(), strict=True)])
    assert np.abs(world - truth).max() / frame.unit < 1e-4  # native px; measured 6e-6
    assert np.allclose(surfels.native_scales, depth.ravel() / 0.7, rtol=1e-6)


def test_a_step_is_not_a_slope_and_nan_gives_nothing():
    camera = Camera.initial(40, 20, F)
    relief = np.zeros((20, 40), np.float32)
    relief[:, 20:] = 80.0
    relief[5, 5] = np.nan
    normals = normals_from_relief(relief, camera)
    assert np.isnan(normals[5, 5]).all()
    defined = ~np.isnan(normals[..., 0])
    assert defined.sum() == 20 * 40 - 1
    assert np.allclose(normals[defined], [0, 0, -1], atol=1e-5)  # differencing over the step gives 0.7
    assert len(lift(np.zeros((20, 40, 3), np.float32), relief, camera)) == 20 * 40 - 1


def test_surfels_come_in_blocks_and_follow_the_mask():
    width, height = BLOCK_PX + 20, 9
    camera = Camera.initial(width, height, F)
    image = np.zeros((height, width, 3), np.float32)
    image[..., 0] = np.arange(width) / width
    image[..., 1] = np.arange(height)[:, None] / height
    mask = np.ones((height, width), bool)
    mask[:, 3] = False
    surfels = lift(image, np.zeros((height, width), np.float32), camera, mask=mask)
    assert len(surfels) == height * (width - 1)
    columns = np.round(surfels.colors[:, 0] * width).astype(int)
    first_block = height * (BLOCK_PX - 1)
    assert (columns[:first_block] < BLOCK_PX).all()
    assert (columns[first_block:] >= BLOCK_PX).all()
    assert (np.diff(surfels.colors[:first_block, 1]) >= 0).all()  # row-major inside
    assert 3 not in columns


def test_a_canvas_with_an_offset_is_the_same_scene():
    camera = wide_camera()
    large = Camera(np.eye(4), camera.fx, camera.fy, camera.cx + 7, camera.cy + 5, 80, 60)
    n = np.array([0.6, 0.3, -0.7])
    anchor_plane = plane_relief(camera, n)
    x, y = np.meshgrid(np.arange(80) + 0.5 - 7, np.arange(60) + 0.5 - 5)
    rays = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones_like(x)], -1)
    z = (camera.unproject(32, 21.5, 1.0) @ n) / (rays @ n)
    canvas = ((z - 1) * camera.focal_px).astype(np.float32)
    assert np.allclose(canvas[5:48, 7:71], anchor_plane, atol=1e-3)
    small = lift(np.zeros((43, 64, 3), np.float32), anchor_plane, camera)
    inner = np.zeros((60, 80), bool)
    inner[5:48, 7:71] = True
    big = lift(np.zeros((60, 80, 3), np.float32), canvas, camera, mask=inner, offset_px=(-7, -5))
    assert np.allclose(big.means, small.means, atol=2e-3)  # native px; measured 3e-4
    assert large.width == 80


def test_an_edge_on_surface_is_stretched_at_most_tenfold():
    camera = Camera.initial(16, 16, F)
    normals = np.tile(np.array([1.0, 0.0, 0.0], np.float32), (16, 16, 1))
    flat = np.zeros((16, 16), np.float32)
    surfels = lift(np.zeros((16, 16, 3), np.float32), flat, camera, normals=normals)
    assert np.isfinite(surfels.quats).all()
    assert (surfels.scales[:, 0] <= 10.001 * surfels.scales[:, 1]).all()


@pytest.mark.parametrize("levels", [0, 6, 12])
def test_the_same_picture_lifts_alike_at_every_zoom(levels):
    camera = Camera.initial(48, 32, F)
    for _ in range(levels):
        camera = camera.zoomed_to_region(0.61, 0.37, 8.0)
    x, y = np.meshgrid(np.arange(48.0), np.arange(32.0))
    relief = (0.4 * x - 0.3 * y - 5).astype(np.float32)
    surfels = lift(np.zeros((32, 48, 3), np.float32), relief, camera)
    covariances = screen_covariances(surfels, camera, LevelFrame.of_camera(camera, 1.0))
    # measured 3e-7, 1e-6, 0.25: at level 12 it is the differences of this test that cancel in float64
    tolerance = {0: 1e-5, 6: 1e-4, 12: 0.5}[levels]
    assert np.abs(covariances / SURFEL_SIGMA_PX**2 - np.eye(2)).max() < tolerance


def test_footprints_that_are_pixels_are_those_of_lifting():
    """A plane's pixels given by their corners: the same points, covariances and normals."""
    camera = wide_camera()
    relief = plane_relief(camera, np.array([0.3, -0.2, -1.0]))
    image = np.random.default_rng(0).random((*relief.shape, 3), np.float32)
    lifted = lift(image, relief, camera)
    rows, columns = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1)
    step = 1e-3

    def corners(dx, dy):
        x, y = columns + 0.5, rows + 0.5
        slope_x, slope_y = (np.gradient(relief.astype(np.float64), axis=a) for a in (1, 0))
        moved = relief + step * (dx * slope_x + dy * slope_y)
        return np.column_stack([x + step * dx, y + step * dy, moved[rows, columns]])

    spanned = lift_spanned(
        np.stack([corners(0, 0), corners(1, 0), corners(0, 1)]),
        image.reshape(-1, 3),
        lifted.opacities,
        camera,
        SURFEL_SIGMA_PX / step,
    )
    inside = (rows > 0) & (rows < camera.height - 1) & (columns > 0) & (columns < camera.width - 1)
    np.testing.assert_allclose(spanned.means, lifted.means, atol=1e-4)
    np.testing.assert_allclose(spanned.scales[inside], lifted.scales[inside], rtol=0.02)  # measured .006
    facing = np.abs((rotations(spanned.quats)[:, :, 2] * rotations(lifted.quats)[:, :, 2]).sum(1))
    assert facing[inside].min() > 0.999  # measured .99999


def test_each_pixel_may_have_its_own_opacity():
    camera = wide_camera()
    opacity = np.linspace(0.1, 0.9, camera.width * camera.height, dtype=np.float32)
    image, relief = (
        np.zeros((camera.height, camera.width, 3), np.float32),
        np.zeros((camera.height, camera.width), np.float32),
    )
    lifted = lift(image, relief, camera, opacity=opacity.reshape(relief.shape))
    assert np.array_equal(np.sort(lifted.opacities), opacity)
