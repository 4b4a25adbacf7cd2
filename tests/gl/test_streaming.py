"""Levels that arrive piece by piece while frames go on."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from tests.core.builders import random_surfels
from tests.gl.gates import PATIENCE_S, Gate, until
from tests.gl.paging import shrink_pages
from tests.gl.surfaces import add_surface, flat_scene, hill_scene, hills, noise_image, orbited
from wzviewer.core.scene import Scene
from wzviewer.gl import ordering
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.pages import PAGE_BYTES, Pages
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.software import Kernels
from wzviewer.gl.visible import select

pytestmark = pytest.mark.gl

PAGE = 64


@pytest.fixture(params=["shaders", "kernels"])
def renderer(request, gl_context):
    made = SurfelRenderer(gl_context, request.param)
    yield made
    made.release()


def picture_of(gl_context, rasterizer, scene, camera):
    """What a new renderer draws."""
    made = SurfelRenderer(gl_context, rasterizer)
    made.sync(scene)
    picture = made.render(camera).read_color()
    made.release()
    return picture


def arrived(arrivals, scene):
    """The levels that are drawn, as a scene of their own."""
    copy = Scene()
    for level in scene:
        state = arrivals.states.get(level.index)
        copy.append(level if state is None else state.level)
        if state is None:
            copy.hide(level.index)
    return copy


def recolored(level, seed):
    colors = np.random.default_rng(seed).random(level.surfels.colors.shape, np.float32)
    return level.with_surfels(level.surfels.with_(colors=colors))


def grow(scene, step):
    """A new level now and then, and the last one again and again."""
    last = scene[len(scene) - 1]
    if step % 6 == 1:
        camera = last.camera.zoomed_to_region(0.45, 0.55, 4.0)
        depth = hills(camera, scene[0].camera)
        add_surface(scene, last.index, camera, depth, noise_image(camera, step))
    elif step % 3 == 2:
        scene.replace(recolored(last, step))


SIZES = ((40, 28), (33, 50), (1, 1), (64, 8), (57, 41), (40, 0), (7, 3))


def test_the_window_changes_while_levels_come_and_are_replaced(monkeypatch, gl_context, renderer):
    page_bytes = shrink_pages(monkeypatch, PAGE)
    scene, twin, step = hill_scene(num_levels=1), Arrivals(Pages()), 0
    pictures = 0
    while not renderer.sync(scene, 5 * page_bytes) or step < 20:
        twin.sync(scene, 5 * page_bytes, None)
        width, height = SIZES[step % len(SIZES)]
        camera = scene[(step // 4) % len(scene)].camera
        camera = replace(orbited(camera, scene[0].frame.origin, 0.5 * step), width=width, height=height)
        color = renderer.render(camera).read_color()
        assert color.shape == (height, width, 4)
        if step % 2 and width * height:  # a new renderer for each is slow
            expected = picture_of(gl_context, renderer.rasterizer, arrived(twin, scene), camera)
            np.testing.assert_array_equal(color, expected)
            pictures += len(twin.states) > 0
        if step < 20:
            grow(scene, step)
        step += 1
        assert step < 200
    assert pictures > 8
    assert len(scene) == 5
    for level in scene:
        expected = picture_of(gl_context, renderer.rasterizer, scene, level.camera)
        np.testing.assert_array_equal(renderer.render(level.camera).read_color(), expected)


@pytest.mark.parametrize("pages", [1, 8])
def test_no_call_takes_more_than_its_budget(monkeypatch, renderer, pages):
    scene = flat_scene(32, 24, num_levels=1)
    renderer.sync(scene)
    big = scene[0].with_surfels(random_surfels(1_000_000, 3))
    scene.replace(big)
    taken, upload = [], Pages.upload

    def counted(self, budget_bytes=None):
        taken.append(upload(self, budget_bytes))
        return taken[-1]

    monkeypatch.setattr(Pages, "upload", counted)
    budget = pages * PAGE_BYTES
    while not renderer.sync(scene, budget):
        assert len(taken) < 100
    assert sum(taken) == 32 * 1_000_000
    assert max(taken) <= budget
    assert len(taken) == -(-62 // pages)
    assert renderer.sync(scene, budget)
    assert taken[-1] == 0


@pytest.mark.parametrize("soon", [False, True])
def test_nothing_outside_a_new_level_changes(monkeypatch, renderer, soon):
    page_bytes = shrink_pages(monkeypatch, PAGE)
    scene = hill_scene(48, 36, num_levels=1)
    renderer.sync(scene)
    root = scene[0].camera
    view = root.zoomed(24.0, 18.0, 1.9)  # the child is half faded in
    before = renderer.render(view).read_color8()  # float32 differs in the last bit: another shader
    child = root.zoomed_to_region(0.4, 0.6, 4.0)
    add_surface(scene, 0, child, hills(child, root), noise_image(child, 9))
    corners = [child.unproject(x, y, 1.0) for x in (0.0, child.width) for y in (0.0, child.height)]
    low, high = (edge(view.project(np.array(corners))[:, :2], axis=0) for edge in (np.min, np.max))
    reach = (
        4.0 * 1.9
    )  # a parent's surfel whose centre lies inside: 3.3 sigma of 0.55 px, tilted, and rounding
    y, x = np.mgrid[0 : view.height, 0 : view.width] + 0.5
    outside = (x < low[0] - reach) | (x > high[0] + reach) | (y < low[1] - reach) | (y > high[1] + reach)
    assert 0.2 < outside.mean() < 0.9
    states = []
    for _ in range(3000):
        arriving = not renderer.sync(scene, page_bytes)
        frame = renderer.render_soon(view) if soon else renderer.render(view)
        picture = frame.read_color8()
        np.testing.assert_array_equal(picture[outside], before[outside])
        states.append(bool((picture != before).any()))
        if not arriving and states[-1] and frame.stats.is_exact:
            break
        if not arriving:
            time.sleep(0.01)  # the order is made on another thread; a busy machine takes its time
    assert states.count(True) >= 1  # and inside it does
    assert states[:20] == [False] * 20  # 27 pages: nothing of it is shown before its last
    assert states == sorted(states)


class OrderGate(Gate):
    """Holds back the orders of `render_soon`."""

    def __init__(self, monkeypatch):
        super().__init__()
        self.busy = threading.Event()
        monkeypatch.setattr(ordering, "select", self)

    def __call__(self, states, camera, choice):
        self.busy.set()
        self.pass_through()
        return select(states, camera, choice)

    def shut(self):
        self.busy.clear()
        self.open.clear()


@pytest.fixture
def gate(monkeypatch):
    made = OrderGate(monkeypatch)
    yield made
    made.open.set()


@pytest.fixture
def shaders(gl_context):
    """With orders from the thread, also where the GPU could make them."""
    made = SurfelRenderer(gl_context, "shaders", gpu_order=False)
    yield made
    made.release()


def settle(renderer, camera, allowed):
    """Draws until the order is exact; every frame on the way is one of those allowed."""
    ticks = threading.Event()
    for _ in range(int(PATIENCE_S / 0.005)):
        frame = renderer.render_soon(camera)
        picture = frame.read_color()
        assert any(np.array_equal(picture, each) for each in allowed)
        if frame.stats.is_exact:
            return picture
        ticks.wait(0.005)
    raise AssertionError("the exact order never came")


def versions_of(gl_context, scene, camera, count):
    """Pictures of a scene whose last level is replaced again and again."""
    pictures, copy = [], Scene()
    for level in scene:
        copy.append(level)
    for seed in range(count):
        copy.replace(recolored(copy[len(copy) - 1], seed))
        pictures.append(picture_of(gl_context, "shaders", copy, camera))
    return pictures


def test_an_old_order_draws_the_old_level_whatever_arrives_meanwhile(monkeypatch, gl_context, shaders, gate):
    page_bytes = shrink_pages(monkeypatch, PAGE)
    scene = hill_scene(num_levels=2)
    camera = scene[1].camera.zoomed(20.0, 14.0, 0.6)
    versions = versions_of(gl_context, scene, camera, 12)
    shaders.sync(scene)
    old = settle(shaders, camera, [picture_of(gl_context, "shaders", scene, camera)])
    gate.shut()
    for seed in range(4):  # versions that come and go; none may be written over what is drawn
        scene.replace(recolored(scene[1], seed))
        while not shaders.sync(scene, 3 * page_bytes):
            np.testing.assert_array_equal(shaders.render_soon(camera).read_color(), old)
        frame = shaders.render_soon(camera)
        np.testing.assert_array_equal(frame.read_color(), old)
        assert not frame.stats.is_exact
    assert gate.busy.wait(PATIENCE_S)
    gate.open.set()
    # The order that was under way is of the first version.
    np.testing.assert_array_equal(settle(shaders, camera, [old, *versions[:4]]), versions[3])
    held = shaders.gpu_bytes
    for seed in range(4, 12):  # what the old versions held is used again
        scene.replace(recolored(scene[1], seed))
        shaders.sync(scene)
        settle(shaders, camera, versions[seed - 1 : seed + 1])
    assert shaders.gpu_bytes <= held


def test_an_exact_frame_between_frees_no_page_of_an_older_order(monkeypatch, gl_context, shaders, gate):
    shrink_pages(monkeypatch, PAGE)
    scene = hill_scene(num_levels=2)
    camera = scene[1].camera.zoomed(20.0, 14.0, 0.6)
    versions = versions_of(gl_context, scene, camera, 4)
    shaders.sync(scene)
    old = settle(shaders, camera, [picture_of(gl_context, "shaders", scene, camera)])
    gate.shut()
    shaders.render_soon(orbited(camera, scene[1].frame.origin, 5.0))  # an order of the old level is begun
    assert gate.busy.wait(PATIENCE_S)
    for seed in range(4):
        scene.replace(recolored(scene[1], seed))
        shaders.sync(scene)
        np.testing.assert_array_equal(shaders.render(camera).read_color(), versions[seed])
    threading.Timer(0.05, gate.open.set).start()
    settle(shaders, camera, [old, versions[3]])


class SlowKernels:
    """Kernels that are compiled when they are told to be."""

    def __init__(self, monkeypatch):
        self.compile, load = threading.Event(), Kernels._load

        def slowly(kernels):
            assert self.compile.wait(PATIENCE_S)
            load(kernels)

        monkeypatch.setattr(Kernels, "_load", slowly)


@pytest.mark.parametrize("soon", [False, True])
def test_the_kernels_take_over_in_the_middle_of_a_session(monkeypatch, gl_context, soon):
    """Until they are compiled the shaders draw."""
    slow, scene = SlowKernels(monkeypatch), hill_scene()
    camera = scene[1].camera.zoomed(20.0, 14.0, 1.6)
    made = SurfelRenderer(gl_context, "kernels", patient=False, gpu_order=False)
    render = made.render_soon if soon else made.render
    assert made.rasterizer == "shaders"
    assert made.sync(scene)
    until(lambda: render(camera).stats.is_exact)  # the first order of all is not waited for
    first = render(camera).read_color8()
    version = made.version
    slow.compile.set()
    until(lambda: made.sync(scene) and made.rasterizer == "kernels")
    assert made.version != version  # a picture at rest is drawn again
    second = render(camera).read_color8()
    assert np.abs(first.astype(int) - second).max() <= 2  # measured 1: records are rounded
    made.release()


def test_the_change_over_shows_no_empty_frame(monkeypatch, gl_context):
    page_bytes = shrink_pages(monkeypatch, PAGE)
    slow, scene = SlowKernels(monkeypatch), hill_scene()
    made = SurfelRenderer(gl_context, "kernels", patient=False, gpu_order=False)
    made.sync(scene)
    whole = made.render(scene[1].camera).read_coverage()
    slow.compile.set()
    try:
        while made.rasterizer == "shaders":
            made.sync(scene, page_bytes)
            assert np.abs(made.render(scene[1].camera).read_coverage() - whole).max() < 0.01
    finally:
        made.release()
