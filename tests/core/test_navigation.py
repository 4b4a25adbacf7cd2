"""Laws of `core.navigation`."""

import math
from dataclasses import replace

import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.core.navigation import (
    SPRING_RATE,
    Flight,
    ZoomSpring,
    flown,
    interpolated,
    orbited,
    panned,
    scale_bar,
    slerp,
    total_magnification,
    turned,
)

HOME = Camera.initial(1088, 720)


def deep(level: int, x: float = 0.4, y: float = 0.6) -> Camera:
    camera = HOME
    for _ in range(level):
        camera = camera.zoomed_to_region(x, y, 8.0)
    return camera


def numbers(camera: Camera) -> np.ndarray:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy])


def focus_of(camera: Camera, depth: float = 1.0) -> np.ndarray:
    return camera.unproject(camera.width / 2, camera.height / 2, depth)


def run_spring(spring: ZoomSpring, camera: Camera, dt_s: float, seconds: float) -> tuple[ZoomSpring, Camera]:
    for _ in range(round(seconds / dt_s)):
        spring, camera = spring.advanced(camera, dt_s)
    return spring, camera


@pytest.mark.parametrize("level", [0, 3, 7])
def test_zoom_in_and_out_returns_the_camera(level: int) -> None:
    start = deep(level)
    near = ZoomSpring().turned(300.0, 200.0, 9.0)
    _, camera = run_spring(near, start, 1 / 60, 3.0)
    back = ZoomSpring().turned(300.0, 200.0, -9.0)
    _, camera = run_spring(back, camera, 1 / 60, 3.0)
    # measured 1e-15
    assert np.allclose(numbers(camera), numbers(start), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("level", [0, 4, 8, 12])
def test_pixel_under_the_cursor_stays(level: int) -> None:
    camera = deep(level, 0.5, 0.5)
    cursor = (871.25, 133.5)
    point = camera.unproject(*cursor, 1.0)
    _, near = run_spring(ZoomSpring().turned(*cursor, 10.0), camera, 1 / 60, 3.0)
    assert np.abs(near.project(point)[:2] - cursor).max() < 1e-6  # measured 2e-13 at every level
    assert near.fx / camera.fx == pytest.approx(1.2**10, rel=1e-12)


@pytest.mark.parametrize("level", [4, 8, 12])
def test_pixel_under_the_cursor_stays_far_off_the_axis(level: int) -> None:
    camera = deep(level, 0.4, 0.6)
    cursor = (871.25, 133.5)
    point = camera.unproject(*cursor, 1.0)
    before = camera.project(point)[:2]
    _, near = run_spring(ZoomSpring().turned(*cursor, 10.0), camera, 1 / 60, 3.0)
    # float64 holds the principal point of a picture 8^12 wide to 8e-3 px: that is the limit
    limit_px = max(1e-6, 8.0 * float(np.spacing(max(abs(near.cx), abs(near.cy)))))
    assert np.abs(near.project(point)[:2] - before).max() < limit_px  # measured 5, 3 and 1 of its ulp


def test_spring_converges_and_knows_no_frame_rate() -> None:
    spring = ZoomSpring().turned(100.0, 80.0, 5.0)
    middle = [run_spring(spring, HOME, dt, 0.25)[1].fx for dt in (0.25, 0.05, 1 / 240)]
    assert np.allclose(middle, middle[0], rtol=1e-12)
    left, camera = run_spring(spring, HOME, 1 / 60, 2.0)
    assert left.is_resting
    assert camera.fx == pytest.approx(HOME.fx * 1.2**5, rel=1e-12)
    assert math.log(middle[0] / HOME.fx) == pytest.approx(
        5 * math.log(1.2) * (1 - math.exp(-SPRING_RATE * 0.25)), rel=1e-9
    )


@pytest.mark.parametrize("level", [0, 6, 12])
def test_orbit_keeps_the_pivots_pixel(level: int) -> None:
    camera = deep(level)
    pivot = camera.unproject(700.0, 260.0, 1.3)
    turned = orbited(camera, pivot, 0.3, -0.2)
    before, after = camera.project(pivot), turned.project(pivot)
    ulp_px = float(np.spacing(max(abs(turned.cx), turned.fx)))
    # measured 0 px at all three: the principal point takes up the rounding
    assert np.abs(after - before)[:2].max() < max(1e-6, 4.0 * ulp_px)
    R = turned.rotation
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-15)


def test_orbit_turns_the_near_side_with_the_hand() -> None:
    pivot = np.array([0.0, 0.0, 2.0])
    near = np.array([0.0, 0.0, 1.8])
    x, y, _ = orbited(HOME, pivot, 0.1, 0.0).project(near)
    assert x > HOME.cx + 1
    assert y == pytest.approx(HOME.cy)
    assert orbited(HOME, pivot, 0.0, 0.1).project(near)[1] > HOME.cy + 1


def test_orbit_keeps_the_horizon_level() -> None:
    camera = HOME
    for _ in range(40):
        camera = orbited(camera, np.array([0.1, 0.0, 1.0]), 0.05, 0.02)
    assert camera.rotation[0, 1] == pytest.approx(0.0, abs=1e-12)  # the x axis stays horizontal


@pytest.mark.parametrize("level", [0, 3, 12])
def test_looking_around_moves_the_picture_alike_at_every_magnification(level: int) -> None:
    camera = deep(level)
    near, far = focus_of(camera), focus_of(camera, 7.0)
    after = turned(camera, 0.05, 0.02)
    shift = (after.project(near) - camera.project(near))[:2]
    # 0.6 widths a second; off the axis a turn is a little more or less: measured 0.98 to 1.01 of it
    assert shift == pytest.approx([-0.03 * camera.width, -0.012 * camera.width], rel=0.03)
    no_parallax = (after.project(far) - camera.project(far))[:2]
    assert shift == pytest.approx(no_parallax, abs=0.01)  # px; measured 0.001 at level 12
    np.testing.assert_allclose(after.position, camera.position, atol=1e-12)
    level_again = turned(turned(camera, 0.3, 0.4), -0.2, 0.1)
    assert abs(level_again.rotation[0] @ np.array([0.0, 1.0, 0.0])) < 1e-9  # the horizon stays level


def test_pan_moves_every_depth_alike() -> None:
    camera = deep(2)
    points = np.stack([camera.unproject(200.0, 300.0, z) for z in (0.3, 1.0, 36.0)])
    moved = panned(camera, 31.0, -7.0).project(points)[:, :2] - camera.project(points)[:, :2]
    assert np.allclose(moved, [31.0, -7.0], atol=1e-9)


def test_fly_sideways_is_as_fast_on_the_screen_at_every_magnification() -> None:
    for level in (0, 3):
        camera = deep(level)
        point = focus_of(camera, 2.0)
        moved = flown(camera, (1.0, 0.0, 0.0), 0.1, 2.0, 8.0**level).project(point)
        assert moved[0] - camera.width / 2 == pytest.approx(-0.06 * camera.width, rel=1e-6)


def test_fly_forward_enlarges_alike_at_every_magnification() -> None:
    for level in (0, 3):
        camera = deep(level)
        point = focus_of(camera, 2.0)
        near = flown(camera, (0.0, 0.0, 1.0), 0.1, 2.0, 8.0**level)
        depth = near.to_camera(point)[2]
        ratio = camera.pixel_scale(2.0) / near.pixel_scale(depth)
        assert ratio == pytest.approx(math.exp(0.06), rel=1e-9)
        assert np.allclose(near.project(point)[:2], [544.0, 360.0], atol=1e-6)


def test_flight_ends_at_its_ends() -> None:
    start, end = HOME, deep(3)
    flight = Flight.between(start, end, focus_of(end))
    assert flight.camera is start
    over = flight.advanced(99.0)
    assert over.is_over
    assert over.camera is end


def test_flight_between_equal_poses_is_a_straight_zoom() -> None:
    start, end = HOME, deep(1, 0.7, 0.3)
    focus = focus_of(end, 1.7)
    k = end.fx / start.fx
    fixed = np.array([(end.cx - k * start.cx) / (1 - k), (end.cy - k * start.cy) / (1 - k)])
    for s in (0.1, 0.5, 0.9):
        camera = interpolated(start, end, focus, s)
        expected = start.zoomed(*fixed, k**s)
        assert np.allclose(numbers(camera), numbers(expected), rtol=1e-12)
        assert camera.camera_from_world is start.camera_from_world


def test_flight_is_continuous_at_its_ends_and_between_poses() -> None:
    start = orbited(deep(2, 0.45, 0.55), focus_of(deep(2, 0.45, 0.55)), 0.2, 0.1)
    end = HOME
    focus = focus_of(start)
    for s, target in ((1e-9, start), (1 - 1e-9, end)):
        camera = interpolated(start, end, focus, s)
        points = np.stack([target.unproject(x, 200.0, 1.2) for x in (100.0, 900.0)])
        assert np.allclose(camera.project(points), target.project(points), atol=1e-3)
    pixels = [interpolated(start, end, focus, s).project(focus)[:2] for s in np.linspace(0, 1, 41)]
    steps = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    assert steps.max() < 40.0  # the focus never leaves the picture in a jump


def test_long_pan_rises_between_two_magnified_regions() -> None:
    start, end = deep(3, 0.2, 0.5), deep(3, 0.8, 0.5)
    focus = focus_of(end)
    middle = interpolated(start, end, focus, 0.5)
    assert middle.focal_px < start.focal_px / 50  # both regions are seen on the way
    cameras = [interpolated(start, end, focus, s) for s in (1e-7, 1 - 1e-7)]
    for camera, target in zip(cameras, (start, end), strict=True):
        point = focus_of(target)
        assert np.allclose(camera.project(point)[:2], [544.0, 360.0], atol=0.1)


def test_short_pan_keeps_its_focal_length() -> None:
    start = deep(1)
    end = panned(start, 200.0, 0.0)
    middle = interpolated(start, end, focus_of(end), 0.5)
    assert middle.focal_px > 0.8 * start.focal_px
    assert start.cx < middle.cx < end.cx


def test_flight_takes_a_camera_of_another_size() -> None:
    end = deep(1)
    start = HOME.resized(640, 480)
    over = Flight.between(start, end, focus_of(end)).advanced(99.0).camera
    assert (over.width, over.height) == (640, 480)
    assert over.fx == pytest.approx(end.resized(640, 480).fx)


def test_slerp_halves_the_angle() -> None:
    end = orbited(HOME, np.array([0.0, 0.0, 1.0]), 0.6, 0.0).rotation
    half = slerp(HOME.rotation, end, 0.5)
    assert np.allclose(half @ half, end, atol=1e-12)
    assert np.allclose(slerp(end, end, 0.3), end)


def test_total_magnification_counts_zoom_and_approach() -> None:
    focus = np.array([0.0, 0.0, 2.0])
    assert total_magnification(HOME.zoomed(3.0, 4.0, 5.0), HOME, focus) == pytest.approx(5.0)
    pose = np.eye(4)
    pose[2, 3] = -1.0
    near = replace(HOME, camera_from_world=pose)
    assert total_magnification(near, HOME, focus) == pytest.approx(2.0)


@pytest.mark.parametrize("pixel_scale", [1e-14, 3.3e-7, 1 / 1024, 0.1, 0.005])
def test_scale_bar_is_round_and_fits(pixel_scale: float) -> None:
    bar = scale_bar(pixel_scale, 150.0)
    assert 150.0 * 0.39 < bar.width_px <= 150.0 * (1 + 1e-9)
    assert bar.width_px * pixel_scale == pytest.approx(bar.length)
    mantissa = bar.length / 10.0 ** math.floor(math.log10(bar.length) + 1e-9)
    assert min(abs(mantissa - m) for m in (1, 2, 5, 10)) < 1e-6
