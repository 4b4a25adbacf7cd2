"""Paths through keyframes: they meet every key, do not jump, and keep a pure zoom pure."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.keyframes import (
    SPEED_LIMIT,
    Key,
    KeyPath,
    KeyTrack,
    along,
    motion,
    moved,
    swing,
)

SIZE = (320, 212)


def zooms(count, x=0.4, y=0.6):
    """Cameras of nested zooms, x8 each, and the point that the last looks at."""
    cameras = [Camera.initial(*SIZE)]
    for _ in range(count):
        cameras.append(cameras[-1].zoomed_to_region(x, y, 8.0))
    focus = cameras[-1].unproject(SIZE[0] / 2, SIZE[1] / 2, 1.0)
    return cameras, focus


def zoom_path(count=4, seconds=2.0, **key):
    cameras, focus = zooms(count)
    return KeyPath(tuple(Key(camera, focus, seconds, **key) for camera in cameras))


def wandering():
    """Zooms while it turns about a point, then pans far away at depth."""
    home = Camera.initial(*SIZE)
    near = home.zoomed_to_region(0.3, 0.5, 30.0)
    a = near.unproject(160.0, 106.0, 1.2)
    near = navigation.orbited(near, a, 0.1, 0.05)
    nearer = navigation.orbited(near.zoomed(160.0, 106.0, 3.0), a, 0.25, -0.1)
    nearest = navigation.orbited(nearer.zoomed(160.0, 106.0, 2.0), a, 0.1, 0.0)
    aside = navigation.panned(nearest, -20_000.0, 500.0)
    b = aside.unproject(160.0, 106.0, 1.0)
    times = (2.0, 1.0, 0.7, 3.0, 1.5)
    views = ((home, home.unproject(160.0, 106.0, 1.0)), (near, a), (nearer, a), (nearest, a), (aside, b))
    return KeyPath(tuple(Key(*view, seconds) for view, seconds in zip(views, times, strict=True)))


def speeds(track, times, dt=1e-4):
    """Motion per second, about the focus of the moment."""
    found = []
    for t in times:
        a, b = track.camera_at(t), track.camera_at(t + dt)
        found.append(motion(a, b, track.focus_at(t)) / dt)
    return np.array(found)


@pytest.mark.parametrize("path", [zoom_path(), wandering(), replace(wandering(), is_loop=True)])
def test_a_path_goes_through_its_keys_at_their_times(path):
    track = KeyTrack(path, SIZE)
    for key, time_s in zip(path.keys, path.times_s, strict=True):
        assert track.camera_at(time_s) is key.camera
        close = track.camera_at(time_s - 1e-8) if time_s else key.camera
        assert np.abs(motion(key.camera, close, key.focus)).max() < 1e-7  # measured 1.3e-8
    ends = (track.camera_at(-1.0), track.camera_at(path.duration_s + 1.0))
    assert ends[0] is path.keys[0].camera
    assert ends[1] is path.keys[0 if path.is_loop else -1].camera


@pytest.mark.parametrize("path", [zoom_path(), wandering(), replace(wandering(), is_loop=True)])
def test_speed_goes_on_unbroken_through_the_keys(path):
    track, dt = KeyTrack(path, SIZE), 1e-4
    for key, time_s in list(zip(path.keys, path.times_s, strict=True))[1:]:
        if not path.is_loop and key is path.keys[-1]:
            continue
        before = -motion(key.camera, track.camera_at(time_s - dt), key.focus) / dt
        after = motion(key.camera, track.camera_at(time_s + dt), key.focus) / dt
        assert np.abs(after - before).max() < 0.01  # measured 0.001, of speeds up to 1.3


def test_a_zoom_through_levels_is_even_and_never_turns_back():
    cameras = KeyTrack(zoom_path(4), SIZE).cameras(24)
    steps = np.diff(np.log([camera.focal_px for camera in cameras]))
    assert len(cameras) == 8 * 24
    assert steps.min() > 0
    mean = 4 * math.log(8.0) / len(steps)
    assert steps.max() < 1.4 * mean  # measured 1.33: the ends ease in and out
    assert np.abs(np.diff(steps)).max() < 0.1 * mean  # measured 0.081
    middle = steps[49:142]
    assert np.abs(middle / mean - 1.0).max() < 1e-9  # measured 8e-14: between equal zooms it is uniform


@pytest.mark.parametrize("depth", [4, 12])
def test_a_zoom_stays_on_its_pixel_at_any_depth(depth):
    """Between two nested views one world point keeps its pixel."""
    cameras, focus = zooms(depth)
    path = along([(cameras[0], focus), (cameras[-1], focus)], 8.0)
    ratio = cameras[-1].focal_px / cameras[0].focal_px
    first, last = (camera.project(focus)[:2] for camera in (cameras[0], cameras[-1]))
    still = (last - ratio * first) / (1.0 - ratio)
    for camera in KeyTrack(path, SIZE).cameras(3):
        grown = camera.focal_px / cameras[0].focal_px
        wanted = still + (first - still) * grown
        error = np.abs(camera.project(focus)[:2] - wanted).max()
        assert error < (1e-9 if depth == 4 else 0.005)  # measured 8e-12 and 0.0003
        assert camera.camera_from_world is cameras[0].camera_from_world


def test_a_rest_is_a_rest():
    """Equal keys hold the view, and the way on does not swing past them."""
    cameras, focus = zooms(2)
    keys = tuple(Key(cameras[i], focus, 1.0) for i in (0, 1, 1, 2))
    track = KeyTrack(KeyPath(keys), SIZE)
    assert track.camera_at(1.4) is cameras[1]
    focals = [track.camera_at(t).focal_px for t in np.linspace(0.0, 3.0, 200)]
    assert all(b >= a for a, b in pairwise(focals))


def test_stops_stand_still_and_corners_do_not_slow_down():
    dt = 1e-4
    for pace, slowest, fastest in (("stop", 0.0, 0.01), ("corner", 1.03, 1.05)):
        track = KeyTrack(zoom_path(2, pace=pace), SIZE)
        rates = [speeds(track, [t], dt)[0][0] for t in (2.0 - 2 * dt, 2.0, 0.0)]
        assert all(slowest <= rate <= fastest for rate in rates), (pace, rates)  # ln 8 / 2 s = 1.04


def test_a_swing_comes_back_and_keeps_its_pivot():
    camera = Camera.initial(*SIZE).zoomed_to_region(0.5, 0.5, 8.0)
    pivot = camera.unproject(150.0, 100.0, 1.1)
    path = swing(camera, pivot, 20.0, 4.0)
    track = KeyTrack(path, SIZE)
    cameras = track.cameras(24)
    assert len(cameras) == 96
    turns = [math.degrees(float(navigation.turn_of(c.rotation @ camera.rotation.T)[1])) for c in cameras]
    assert max(turns) == pytest.approx(20.0, abs=0.01)
    assert min(turns) == pytest.approx(-20.0, abs=0.01)
    for seen in cameras:
        assert np.abs(seen.project(pivot)[:2] - [150.0, 100.0]).max() < 1e-6  # measured 2e-12


def test_views_that_share_nothing_are_joined_all_the_same():
    front = Camera.initial(*SIZE)
    back = replace(front, camera_from_world=np.diag([-1.0, 1.0, -1.0, 1.0]))
    keys = tuple(Key(c, c.unproject(160.0, 106.0, 1.0), 1.0) for c in (front, back, front))
    track = KeyTrack(KeyPath(keys), SIZE)
    for t in np.linspace(0.0, 2.0, 81):
        camera = track.camera_at(t)
        assert np.isfinite(np.array([camera.fx, camera.cx, *camera.camera_from_world.ravel()])).all()
        assert camera.fx == pytest.approx(front.fx)


def test_a_motion_is_undone_by_its_measure():
    camera = zooms(3)[0][-1]
    focus = camera.unproject(50.0, 60.0, 2.0)
    by = np.array([0.3, 0.01, -0.02, 0.02, -0.05, 0.01, 0.0, 0.001, 0.02])
    assert np.abs(motion(camera, moved(camera, focus, by), focus) - by).max() < 1e-9  # measured 3e-12


def test_a_path_of_one_key_or_of_another_size():
    key = zoom_path(1).keys[0]
    alone = KeyTrack(KeyPath((key,)), SIZE)
    assert [c.key for c in alone.cameras(24)] == [key.camera.key]
    assert alone.path.num_pieces == 0
    sized = KeyTrack(zoom_path(2), (640, 400)).cameras(5)
    assert {(c.width, c.height) for c in sized} == {(640, 400)}
    assert zoom_path(2).lasting(10.0).duration_s == pytest.approx(10.0)
    assert SPEED_LIMIT == 3.0  # the bound that keeps a cubic between its ends
