"""Lost contexts, odd windows, wide trees and twenty million surfels."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.gl.paging import shrink_pages
from tests.gl.surfaces import add_surface, hill_scene, noise_image, orbited
from wzviewer.core import reference
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene
from wzviewer.core.surfels import Surfels
from wzviewer.gl import cull, sieve, visible
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.pages import Pages
from wzviewer.gl.records import RECORD_BYTES, pack, unpack
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.visible import Choice, select

pytestmark = pytest.mark.gl


@pytest.fixture(params=["shaders", "kernels"])
def renderer(request, gl_context):
    made = SurfelRenderer(gl_context, request.param)
    yield made
    made.release()


# ---------------------------------------------------------------- a context that is lost

# Another context in this process would take the place of the session's.
LOST = """
import sys
from tests.gl.surfaces import hill_scene
from wzviewer.gl.context import create_context
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

scene = hill_scene()
settings = RenderSettings(outputs=frozenset({"color", "depth"}))
for rasterizer in ("shaders", "kernels"):
    pictures = []
    for goes_first in ("context", "renderer", "renderer, twice"):
        context = create_context("egl")
        renderer = SurfelRenderer(context, rasterizer)
        renderer.sync(scene, merged=True)
        frame = renderer.render(scene[1].camera, settings)
        exact = (frame.read_color8().tobytes(), frame.read_depth().tobytes())
        soon = renderer.render_soon(scene[1].camera).read_color8().tobytes()
        pictures.append((*exact, soon))
        if goes_first == "context":
            context.close()
        renderer.release()
        if goes_first.endswith("twice"):
            renderer.release()
        context.close()
    assert pictures[0][0] == pictures[0][2]
    assert pictures[1:] == pictures[:-1], rasterizer
print("the same")
"""


def test_a_new_context_draws_what_the_lost_one_drew(gl_context):
    command = [sys.executable, "-W", "error", "-c", LOST]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "the same"


# ---------------------------------------------------------------- sizes of the window


@pytest.mark.parametrize("soon", [False, True])
def test_a_window_may_have_any_size(renderer, soon):
    scene = hill_scene()
    renderer.sync(scene)
    render = renderer.render_soon if soon else renderer.render
    home = scene[0].camera
    normal = renderer.render(home).read_color8()
    settings = RenderSettings(outputs=frozenset({"color", "coverage", "depth", "level"}))
    for width, height in ((0, 28), (40, 0), (0, 0), (1, 1), (7, 3), (1087, 719), (8192, 4)):
        frame = render(
            home.resampled(width, height) if width and height else replace(home, width=width, height=height),
            settings,
        )
        assert frame.shape == (height, width)
        assert frame.read_color8().shape == (height, width, 3)
        assert frame.read_rgba8().shape == frame.read_color().shape == (height, width, 4)
        assert frame.read_coverage().shape == (height, width)
        if width and height:
            assert frame.read_coverage().mean() > 0.5
            assert frame.read_level().shape == frame.read_depth().shape == (height, width)
        np.testing.assert_array_equal(renderer.render(home).read_color8(), normal)


def test_an_empty_window_shows_nothing_and_presents_nothing(renderer, gl_context):
    scene = hill_scene()
    renderer.sync(scene)
    screen = gl_context.ctx.simple_framebuffer((16, 12), 3)
    screen.clear(1.0, 0.0, 0.0)
    frame = renderer.render_soon(replace(scene[0].camera, width=0))
    frame.present_to(screen)
    pixels = np.frombuffer(screen.read(components=3, alignment=1), np.uint8).reshape(-1, 3)
    assert (pixels == (255, 0, 0)).all()
    assert frame.stats.num_visible == 0
    screen.release()


def test_sizes_that_are_no_whole_tiles_show_the_same_pixels(renderer):
    """Pixels do not depend on where the image ends."""
    scene = hill_scene(64, 48)
    renderer.sync(scene)
    whole = renderer.render(scene[1].camera).read_color()
    for width, height in ((63, 47), (57, 41), (9, 33), (64, 1)):
        part = renderer.render(replace(scene[1].camera, width=width, height=height)).read_color()
        # The kernels end a saturated tile early and together: what follows counts less than 1e-4.
        assert np.abs(part - whole[:height, :width]).max() < 2e-4  # measured 0


# ---------------------------------------------------------------- a wide and deep tree


def tree_scene(width, height, depth, branches, seed=1):
    """A trunk of so many levels; each has several children anywhere on it, and the last is the next."""
    scene, root = Scene(), Camera.initial(width, height)
    add_surface(scene, None, root, 1.0, noise_image(root, 0))
    rng, trunk = np.random.default_rng(seed), 0
    for _ in range(depth):
        for branch in range(branches):
            at = (0.5, 0.5) if branch == branches - 1 else tuple(0.25 + 0.5 * rng.random(2))
            camera = scene[trunk].camera.zoomed_to_region(*at, 8.0)
            add_surface(scene, trunk, camera, 1.0, noise_image(camera, len(scene)))
        trunk = len(scene) - 1
    return scene


@pytest.fixture(scope="module")
def wide_tree():
    return tree_scene(16, 12, depth=12, branches=8)


def states_of(scene):
    arrivals = Arrivals(Pages())
    arrivals.sync(scene, None, None)
    return arrivals.states


def decoded(scene):
    copy = Scene()
    for level in scene:
        copy.append(level.with_surfels(unpack(pack(level.surfels, 0))))
    return copy


VIEWS = ((0, 1.0, 0.0), (3, 2.83, 0.0), (20, 0.9, 3.0), (40, 1.0, 6.0), (56, 2.83, 0.0))


def error_of(renderer, scene, camera):
    held = decoded(scene) if renderer.rasterizer == "shaders" else scene
    settings = RenderSettings(antialias=False, outputs=frozenset({"color", "level"}))
    frame, expected = renderer.render(camera, settings), reference.render(held, camera)
    assert (frame.read_level() != expected.level).mean() <= 0.01  # measured 0
    return np.abs(frame.read_color()[..., :3] - expected.color).max(), set(np.unique(expected.level))


def test_a_tree_of_twelve_times_eight_levels_is_drawn_right(renderer, wide_tree):
    assert len(wide_tree) == 97
    renderer.sync(wide_tree)
    drawn = set()
    for index, magnify, angle in VIEWS:
        level = wide_tree[index]
        camera = orbited(level.camera, level.frame.origin, angle).zoomed(8.0, 6.0, magnify)
        error, levels = error_of(renderer, wide_tree, camera)
        assert error <= 1e-4  # measured 1e-6
        drawn |= levels
    assert len(drawn) >= 8  # not one level everywhere


@pytest.mark.parametrize("index", [72, 88, 96])
def test_surfels_far_above_the_view_take_their_share(renderer, wide_tree, index):
    """A pixel of the root is 8^12 px wide there, and fills the view where its children fade out."""
    renderer.sync(wide_tree)
    error, _ = error_of(renderer, wide_tree, wide_tree[index].camera)
    assert error <= 1e-3  # measured 1e-6


def test_no_chunk_of_a_tree_that_matters_is_culled(monkeypatch, renderer):
    shrink_pages(monkeypatch, 32)
    scene = tree_scene(24, 16, depth=2, branches=4)
    for k in range(2):  # extensions at their parent's own scale
        shifted = scene[1].camera.zoomed_to_region(0.4 + 0.3 * k, 0.5, 1.0 + 0.01 * k)
        add_surface(scene, 1, shifted, 1.0, noise_image(shifted, 50 + k))
    renderer.sync(scene)
    skipped = 0
    for level in scene:
        for angle, magnify in ((0.0, 1.0), (5.0, 0.97), (0.0, 1.02), (-8.0, 2.5), (0.0, 0.4)):
            camera = orbited(level.camera, level.frame.origin, angle).zoomed(9.0, 10.0, magnify)
            some = renderer.render(camera, RenderSettings(antialias=False))
            picture, chunks = some.read_color(), some.stats.num_chunks
            every = renderer.render(camera, RenderSettings(antialias=False, culling=False))
            assert np.abs(picture - every.read_color()).max() < 1e-4  # measured 0
            skipped += every.stats.num_chunks - chunks
    assert skipped > 1000


@pytest.mark.parametrize("octaves", [-0.02, 0.0, 0.01, 0.03, 0.06])
def test_an_extension_at_its_parents_scale_fades_in_over_a_ramp_of_its_own(monkeypatch, renderer, octaves):
    shrink_pages(monkeypatch, 32)
    scene = tree_scene(48, 32, depth=0, branches=0)
    beside = scene[0].camera.zoomed_to_region(0.8, 0.5, 1.0)
    add_surface(scene, 0, beside, 1.0, noise_image(beside, 1))
    renderer.sync(scene)
    held = decoded(scene) if renderer.rasterizer == "shaders" else scene
    camera = window(beside.zoomed(24.0, 16.0, 2.0**octaves), 12, 10, 16, 12)  # well inside its border
    expected = reference.render(held, camera)
    frame = renderer.render(camera)
    assert np.abs(frame.read_color()[..., :3] - expected.color).max() < 1e-4  # measured 3e-7
    assert frame.stats.num_chunks < 2 * 48


class Counter:
    """Counts calls, and the boxes that they look at."""

    def __init__(self, function):
        self.function, self.calls, self.boxes = function, 0, 0

    def __call__(self, bounds, *rest):
        self.calls += 1
        self.boxes += len(bounds)
        return self.function(bounds, *rest)


def test_levels_out_of_view_cost_next_to_nothing(monkeypatch, wide_tree):
    """Work of a selection: array operations, and the boxes in them; time is noise."""
    few = tree_scene(16, 12, depth=2, branches=8)
    counters = []
    for scene in (few, wide_tree):
        states, camera = states_of(scene), scene[8].camera.zoomed(8.0, 6.0, 1.3)
        select(states, camera, Choice())  # stacks the levels
        names = ("in_frustum", "may_cover", "weightless", "fades_in", "chunk_radii_px", "view_slabs")
        counted = {name: Counter(getattr(cull, name)) for name in names}
        for name, counter in counted.items():
            for module in (visible, sieve):
                if hasattr(module, name):
                    monkeypatch.setattr(module, name, counter)
        chosen = select(states, camera, Choice())
        counters.append({name: (counter.calls, counter.boxes) for name, counter in counted.items()})
        assert 1 <= len(chosen.seen) <= 12
        monkeypatch.undo()
    calls = [sum(c for c, _ in counted.values()) for counted in counters]
    boxes = [sum(b for _, b in counted.values()) for counted in counters]
    assert calls[0] == calls[1] <= 20  # not a function of the levels; measured 14
    # Two looks at the box of each level, then only at those in view: measured 2.1 for each more.
    assert boxes[1] - boxes[0] <= 3 * (len(wide_tree) - len(few))


# ---------------------------------------------------------------- twenty million surfels


TILE_PX = 128  # a chunk is a tile of the plane: 128 x 128 = PAGE_SURFELS
PLANE_PX = (40 * TILE_PX, 31 * TILE_PX)
SCRATCH_BYTES = 96 << 20  # targets, element index, sort


def plane(width, height):
    """A frontal plane of width x height surfels, tile by tile, (n, 3) means."""
    y, x = np.mgrid[0:TILE_PX, 0:TILE_PX].reshape(2, -1).astype(np.float32) + np.float32(0.5)
    tiles = np.zeros((height // TILE_PX, width // TILE_PX, TILE_PX**2, 3), np.float32)
    tiles[..., 0] = x + (np.arange(width // TILE_PX) * TILE_PX - width / 2)[None, :, None]
    tiles[..., 1] = y + (np.arange(height // TILE_PX) * TILE_PX - height / 2)[:, None, None]
    return tiles.reshape(-1, 3)


def plane_surfels(means):
    n = len(means)
    colors = np.tile(np.random.default_rng(5).random((9973, 3), np.float32), (n // 9973 + 1, 1))[:n]
    quats, ones = np.zeros((n, 4), np.float32), np.ones(n, np.float32)
    quats[:, 0] = 1.0
    scales = np.broadcast_to(np.float32(0.55), (n, 2))
    return Surfels(means, quats, scales, np.full(n, 0.99, np.float32), colors, ones, ones)


def plane_scene(surfels, camera):
    blank = np.zeros((4, 4, 3), np.uint8)
    scene, frame = Scene(), LevelFrame.of_camera(camera, 1.0)
    scene.append(Level(0, None, camera, frame, surfels, blank, blank[..., 0].astype(np.float32)))
    return scene


@pytest.fixture(scope="module")
def huge():
    width, height = PLANE_PX
    camera = Camera.initial(width, height)
    return plane_scene(plane_surfels(plane(width, height)), camera)


def window(camera, x_px, y_px, width, height):
    """A part of a camera's image."""
    return replace(camera, cx=camera.cx - x_px, cy=camera.cy - y_px, width=width, height=height)


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def test_twenty_million_surfels(renderer, gl_context, huge):
    level = huge[0]
    assert len(level.surfels) > 20_000_000
    assert renderer.sync(huge)
    part = window(level.camera, 2000.3, 1900.6, 200, 150)
    frame = renderer.render(part)
    picture = frame.read_color()
    assert picture[..., 3].min() > 0.9
    # 200 x 150 px meet 9 tiles of the plane at most; the other 1231 are not even looked at.
    assert frame.stats.num_chunks <= 9
    assert frame.stats.num_visible <= 9 * TILE_PX**2
    assert renderer.gpu_bytes <= RECORD_BYTES * len(level.surfels) + SCRATCH_BYTES
    if sys.platform == "linux":
        assert resident_bytes() < 6e9  # measured 2.3e9
    alone = SurfelRenderer(gl_context, renderer.rasterizer)  # holds only what is near
    alone.sync(plane_scene(near_tiles(level, (2036.0, 1911.0)), level.camera))
    np.testing.assert_array_equal(alone.render(part).read_color(), picture)
    alone.release()
    soon = renderer.render_soon(part)
    np.testing.assert_array_equal(soon.read_color(), picture)
    whole = renderer.render(window(level.camera, 1000.0, 1000.0, 1400, 900))
    assert whole.stats.num_visible > 1_000_000
    assert whole.read_coverage().min() > 0.9
    assert renderer.gpu_bytes <= RECORD_BYTES * len(level.surfels) + SCRATCH_BYTES
    np.testing.assert_array_equal(renderer.render(part).read_color(), picture)


def near_tiles(level, centre_px):
    """The surfels of the tiles around a pixel."""
    at = level.surfels.means[:: TILE_PX**2, :2] + [PLANE_PX[0] / 2, PLANE_PX[1] / 2]  # of each tile
    near = np.flatnonzero((np.abs(at - centre_px) < 300).all(1))
    pieces = [level.surfels.take(slice(i * TILE_PX**2, (i + 1) * TILE_PX**2)) for i in near]
    return Surfels.concatenate(pieces)
