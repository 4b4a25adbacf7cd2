"""Orders made off the frame thread: the newest camera wins, and no frame waits."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from tests.gl.gates import PATIENCE_S, Gate, until
from tests.gl.surfaces import hill_scene, orbited
from wzviewer.core.camera import Camera
from wzviewer.gl import ordering
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.ordering import OrderQueue, is_near
from wzviewer.gl.pages import Pages
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.visible import Choice, select

CHOICE = Choice()


class SelectGate(Gate):
    """Holds back `select` on the ordering thread, and counts."""

    def __init__(self, monkeypatch):
        super().__init__()
        self.cameras = []
        monkeypatch.setattr(ordering, "select", self)

    def __call__(self, states, camera, choice):
        self.cameras.append(camera)
        self.pass_through()
        return select(states, camera, choice)


@pytest.fixture
def gate(monkeypatch):
    made = SelectGate(monkeypatch)
    yield made
    made.open.set()


@pytest.fixture
def orders():
    made = OrderQueue()
    yield made
    made.close()


def states_of(scene):
    arrivals = Arrivals(Pages())
    arrivals.sync(scene, None, None)
    return arrivals.states


def cameras_about(level, count):
    """Too far from each other for one order."""
    return [orbited(level.camera, level.frame.origin, 3.0 * k) for k in range(count)]


def test_the_newest_camera_wins(orders, gate):
    scene = hill_scene()
    states, cameras = states_of(scene), cameras_about(scene[1], 5)
    gate.open.clear()
    for camera in cameras[:1]:
        orders.ask(states, camera, CHOICE)
    gate.wait()  # it is at the first one
    for camera in cameras[1:]:
        orders.ask(states, camera, CHOICE)
    gate.open.set()
    until(lambda: orders.newest(states, cameras[-1], CHOICE).is_exact)
    assert [camera.key for camera in gate.cameras] == [cameras[0].key, cameras[-1].key]


def test_a_slow_order_blocks_no_frame_after_the_first(orders, gate):
    scene = hill_scene()
    states, cameras = states_of(scene), cameras_about(scene[1], 4)
    orders.ask(states, cameras[0], CHOICE)
    first = orders.newest(states, cameras[0], CHOICE)
    assert first.is_current
    assert first.is_exact
    gate.open.clear()
    for camera in cameras[1:]:
        orders.ask(states, camera, CHOICE)
        newest = orders.newest(states, camera, CHOICE)  # would never return if it waited
        assert newest.ordered is first.ordered
        assert newest.is_current
        assert not newest.is_exact


def test_at_rest_the_exact_order_comes_and_then_nothing_is_made(orders, gate):
    scene = hill_scene()
    states, camera = states_of(scene), scene[1].camera
    orders.ask(states, camera, CHOICE)
    orders.newest(states, camera, CHOICE)
    moved = replace(camera, cx=camera.cx + 0.3)  # near: the order serves while it moves
    orders.ask(states, moved, CHOICE)
    assert not orders.newest(states, moved, CHOICE).is_exact
    assert len(gate.cameras) == 1
    orders.ask(states, moved, CHOICE)  # it rests
    until(lambda: orders.newest(states, moved, CHOICE).is_exact)
    exact = orders.newest(states, moved, CHOICE).ordered
    np.testing.assert_array_equal(exact.places, select(states, moved, CHOICE).ordered().places)
    for _ in range(50):
        orders.ask(states, moved, CHOICE)
        assert orders.newest(states, moved, CHOICE).ordered is exact
    assert len(gate.cameras) == 2


MOTIONS = {
    "turn 0.1 %": (lambda c, d: turned(c, 0.001), True),
    "turn 10 %": (lambda c, d: turned(c, 0.1), False),
    "orbit a little": (lambda c, d: orbited(c, c.unproject(c.width / 2, c.height / 2, d), 0.2), True),
    "orbit a degree": (lambda c, d: orbited(c, c.unproject(c.width / 2, c.height / 2, d), 1.0), False),
    "pan 2 %": (lambda c, d: replace(c, cx=c.cx + 0.02 * c.width), True),
    "pan 10 %": (lambda c, d: replace(c, cx=c.cx + 0.10 * c.width), False),
    "zoom 5 %": (lambda c, d: c.zoomed(c.width / 2, c.height / 2, 1.05), True),
    "zoom 30 %": (lambda c, d: c.zoomed(c.width / 2, c.height / 2, 1.3), False),
    "approach 0.1 %": (lambda c, d: moved(c, c.width / 2, c.height / 2, 0.001 * d), True),
    "approach 1 %": (lambda c, d: moved(c, c.width / 2, c.height / 2, 0.01 * d), False),
    "step 0.2 % of the image aside": (lambda c, d: aside(c, 0.002 * c.width * c.pixel_scale(d)), True),
    "step 10 % of the image aside": (lambda c, d: aside(c, 0.10 * c.width * c.pixel_scale(d)), False),
}


def turned(camera, share):
    """By a share of the image."""
    return orbited(camera, camera.position, np.degrees(share * camera.width / camera.focal_px))


def moved(camera, x_px, y_px, by):
    """Towards what lies under a pixel."""
    ray = camera.unproject(x_px, y_px, 1.0) - camera.position
    return placed(camera, camera.position + by * ray)


def aside(camera, by):
    return placed(camera, camera.position + by * camera.rotation[0])


def placed(camera, position):
    pose = camera.camera_from_world.copy()
    pose[:3, 3] = -camera.rotation @ position
    return replace(camera, camera_from_world=pose)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS.keys())
def test_the_same_relative_motion_is_judged_alike_at_every_depth_of_zoom(motion):
    move, serves = motion
    root = Camera.initial(1088, 720)
    for level, depth in ((0, 1.0), (0, 37.0), (3, 1.2), (9, 0.8)):
        camera = root
        for _ in range(level):
            camera = camera.zoomed_to_region(0.47, 0.52, 8.0)
        assert is_near(camera, camera, depth)
        assert is_near(camera, move(camera, depth), depth) == serves, (level, depth)


def test_another_size_or_another_scene_needs_another_order(orders, gate):
    scene = hill_scene()
    states, camera = states_of(scene), scene[1].camera
    assert not is_near(camera, replace(camera, width=camera.width + 1), 1.0)
    orders.ask(states, camera, CHOICE)
    orders.newest(states, camera, CHOICE)
    others = states_of(scene)
    gate.open.clear()
    orders.ask(others, camera, CHOICE)
    assert not orders.newest(others, camera, CHOICE).is_current
    gate.open.set()
    until(lambda: orders.newest(others, camera, CHOICE).is_current)


def test_closing_ends_the_thread_while_it_works(gate):
    scene, orders = hill_scene(), OrderQueue()
    states = states_of(scene)
    gate.open.clear()
    orders.ask(states, scene[1].camera, CHOICE)
    gate.wait()
    orders.ask(states, scene[0].camera, CHOICE)  # will not be begun
    closing = threading.Thread(target=orders.close)
    closing.start()
    gate.open.set()
    closing.join(PATIENCE_S)
    assert not closing.is_alive()
    assert len(gate.cameras) == 1
    assert all(thread.name != "ordering" for thread in threading.enumerate())
    orders.close()


def test_closing_frees_who_waits(gate):
    scene, orders = hill_scene(), OrderQueue()
    states, camera = states_of(scene), scene[0].camera
    failures = []

    def wait():
        try:
            orders.newest(states, camera, CHOICE)
        except RuntimeError as error:
            failures.append(str(error))

    waiting = threading.Thread(target=wait)
    waiting.start()
    orders.close()
    waiting.join(PATIENCE_S)
    assert "closed" in failures[0]


def test_an_error_in_the_thread_reaches_the_frame_and_the_next_order_is_made(orders, monkeypatch):
    scene = hill_scene()
    states, camera = states_of(scene), scene[0].camera

    def fails(*_):
        raise MemoryError("no room for the order")

    with monkeypatch.context() as patch:
        patch.setattr(ordering, "select", fails)
        for _ in range(2):
            orders.ask(states, camera, CHOICE)
            with pytest.raises(MemoryError, match="no room"):
                orders.newest(states, camera, CHOICE)
    orders.ask(states, camera, CHOICE)
    assert orders.newest(states, camera, CHOICE).is_exact


def test_orders_of_levels_whose_pages_are_written_again_are_forgotten(orders, gate):
    scene = hill_scene()
    old, new, camera = states_of(scene), states_of(scene), scene[0].camera
    orders.ask(old, camera, CHOICE)
    orders.newest(old, camera, CHOICE)
    gate.wait()
    gate.open.clear()
    orders.ask(old, scene[1].camera, CHOICE)
    gate.wait()  # and one of the old levels is being made
    orders.forget_older(new)
    orders.ask(new, camera, CHOICE)
    gate.open.set()
    newest = orders.newest(new, camera, CHOICE)
    assert newest.is_current
    assert newest.is_exact


@pytest.mark.gl
def test_not_even_the_first_order_is_waited_for_where_frames_go_on(gl_context, gate):
    scene = hill_scene()
    renderer = SurfelRenderer(gl_context, "shaders", patient=False, gpu_order=False)
    renderer.sync(scene)
    gate.open.clear()
    first = renderer.render_soon(scene[0].camera)  # would never return if it waited
    assert not first.stats.is_exact
    assert not first.read_coverage().any()
    shown = gl_context.ctx.simple_framebuffer((8, 6))
    shown.clear(1.0, 1.0, 1.0, 1.0)
    first.present_to(shown)
    assert not np.frombuffer(shown.read(), np.uint8).any()  # the background, not the picture before
    shown.release()
    gate.open.set()
    until(lambda: renderer.render_soon(scene[0].camera).stats.is_exact)
    assert renderer.render_soon(scene[0].camera).read_coverage().any()
    renderer.release()


@pytest.mark.gl
def test_frames_in_motion_become_exact_at_rest(gl_context):
    scene = hill_scene()
    renderer = SurfelRenderer(gl_context, "shaders")
    renderer.sync(scene)
    for angle in (0.0, 0.1, 0.2, 0.5, 1.0, 3.0, 3.1):  # near and far
        camera = orbited(scene[1].camera, scene[1].frame.origin, angle)
        renderer.render_soon(camera)
    until(lambda: renderer.render_soon(camera).stats.is_exact)
    soon = renderer.render_soon(camera).read_color()
    np.testing.assert_array_equal(soon, renderer.render(camera).read_color())
    renderer.release()
