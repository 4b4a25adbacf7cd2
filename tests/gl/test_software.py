"""The kernels that draw where OpenGL is software, against their twins in numpy and GLSL."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.core.builders import random_surfels
from tests.gl.surfaces import flat_scene, hill_scene, orbited
from tests.gl.test_opacity_parity import random_tree
from wzviewer.core.anchor import AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import weights
from wzviewer.core.reference import depth_row, focus_of
from wzviewer.core.scene import Scene, modulation
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.blit import Blit
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.order import order_places, relative_depths, sortable_bits
from wzviewer.gl.pages import Pages
from wzviewer.gl.present import Presenter
from wzviewer.gl.renderer import SurfelRenderer
from wzviewer.gl.software import Kernels
from wzviewer.gl.visible import Choice, select
from wzviewer.kernels import presenting, projection
from wzviewer.kernels.splatting import Splatter

# ---------------------------------------------------------------- order


def splatted(selection, camera):
    """The selection's runs, added one after the other; a row is a place in them."""
    splatter = Splatter()
    splatter.begin(selection.num_selected, camera.width, camera.height)
    for run in selection.runs:
        row = run.depth_row(selection.focus)
        splatter.add(run.surfels, run.view, row)
    return splatter


def with_ties(scene):
    """Every other surfel at the same depth as another one of its level."""
    rng, copy = np.random.default_rng(8), Scene()
    for level in scene:
        means = level.surfels.means.copy()
        means[::2, 2] = rng.choice(means[:50, 2], len(means[::2]))
        copy.append(level.with_surfels(level.surfels.with_(means=means)))
    return copy


@pytest.mark.parametrize("index", [0, 1, 12])
@pytest.mark.parametrize("angle", [0.0, 7.0])
def test_the_order_is_the_renderers_bit_for_bit(index, angle):
    scene = with_ties(hill_scene(24, 16, num_levels=13))
    arrivals = Arrivals(Pages())
    arrivals.sync(scene, None, None)
    camera = orbited(scene[index].camera, scene[index].frame.origin, angle)
    selection = select(arrivals.states, camera, Choice(culling=False, modulated=False))
    splatter = splatted(selection, camera)
    order = splatter.sort()
    keys = [sortable_bits(relative_depths(r.columns, r.depth_row(selection.focus))) for r in selection.runs]
    keys = np.concatenate(keys)
    places = order_places(selection.runs, selection.focus)
    seen = np.isin(places, order)
    assert 300 < len(order) == seen.sum()
    np.testing.assert_array_equal(order, places[seen])
    np.testing.assert_array_equal(splatter._bits[order], keys[order])
    if angle == 0.0:
        assert (np.diff(keys[order].astype(np.int64)) == 0).sum() > 50  # there are ties


# ---------------------------------------------------------------- weights


def weighed(level, camera, law):
    """Weights of the kernel, and which surfels it found in view."""
    view, splatter, n = AnchoredView.expand(camera, level.frame), Splatter(), len(level.surfels)
    splatter.begin(n, camera.width, camera.height)
    row = depth_row(view, level.frame, focus_of(camera, [level.frame]))
    splatter.add(level.surfels, view, row, None, law.texels())
    rows = np.arange(splatter._count)
    places = splatter._places_of(rows) if len(rows) else rows
    found, seen = np.zeros(n, np.float32), np.zeros(n, bool)
    found[places], seen[places] = splatter._weights[rows], splatter._rows[rows, 6] >= 0.0
    return found, seen, view


def everywhere(camera):
    """The same camera with a larger image, so that next to nothing is out of view."""
    return replace(camera, cx=camera.cx + 4000, cy=camera.cy + 4000, width=8000, height=8000)


def test_weights_are_those_of_numpy():
    worst, partial = 0.0, 0
    for seed in range(4):
        scene, rng = random_tree(seed), np.random.default_rng(100 + seed)
        for level in scene:
            near = scene[int(rng.integers(len(scene)))].camera
            camera = everywhere(near.zoomed(*(rng.random(2) * 50), 0.5 + 3 * rng.random()))
            law, s = modulation(scene, level.index), level.surfels
            found, seen, view = weighed(level, camera, law)
            expected = weights(s.means, s.native_scales, s.coverage, view, law, compensated=True)
            worst = max(worst, float(np.abs(found - expected)[seen].max(initial=0.0)))
            partial += int(((expected > 0.01) & (expected < 0.99) & seen).sum())
    assert partial > 2000  # the cases are not all 0 and 1
    assert worst < 5e-5  # measured 1e-5


def test_weights_are_right_when_the_anchor_is_behind_the_camera():
    """A camera that flew past the anchor of a level still sees what lies behind it."""
    scene, seen_at_all = random_tree(3), 0
    for level in scene:
        means = level.surfels.means * np.float32([1.0, 1.0, 60.0])
        level = level.with_surfels(level.surfels.with_(means=means))
        pose = level.camera.camera_from_world.copy()
        pose[2, 3] -= level.anchor_depth + 20.0 * level.frame.unit
        law, camera = (
            modulation(scene, level.index),
            everywhere(replace(level.camera, camera_from_world=pose)),
        )
        found, seen, view = weighed(level, camera, law)
        assert view.depth < 0.0
        s = level.surfels
        expected = weights(s.means, s.native_scales, s.coverage, view, law, compensated=True)
        np.testing.assert_allclose(found[seen], expected[seen], atol=2e-5)  # measured 3e-6
        seen_at_all += int((expected[seen] > 0.0).sum())
    assert seen_at_all > 100


# ---------------------------------------------------------------- threads


@pytest.mark.gl
@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_the_number_of_threads_changes_no_byte(gl_context, blend):
    import numba

    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("one thread is all there is")
    scene = hill_scene(200, 150, num_levels=2)  # 60 000 surfels: several tasks
    settings = RenderSettings(
        blend=blend, outputs=frozenset({"color", "depth", "level"}), contribution_min=0.3
    )
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(scene)
    threads, pictures = numba.get_num_threads(), []
    try:
        for count in (1, 2, 1):
            numba.set_num_threads(count)
            frame = renderer.render(scene[1].camera.zoomed(100.0, 75.0, 0.5), settings)
            parts = (frame.read_color(), frame.read_color8(), frame.read_level(), frame.read_depth())
            pictures.append([part.tobytes() for part in parts])
    finally:
        numba.set_num_threads(threads)
        renderer.release()
    assert pictures[0] == pictures[1] == pictures[2]


# ---------------------------------------------------------------- small footprints


@pytest.mark.gl
@pytest.mark.parametrize("limit", [0.3, 1.0, 4.0])
def test_small_footprints_are_left_out_as_numpy_says(limit):
    camera, n = Camera.initial(64, 48), 3000
    scene = random_tree(1, 1)
    surfels = random_surfels(n, 4)
    view = AnchoredView.expand(camera, scene[0].frame)
    rows = np.empty((n, 8), np.float32)
    arrays = (surfels.means, surfels.quats, surfels.scales, surfels.opacities)
    projection.project_range(*arrays, projection.view_vector(view), 64, 48, 1e7, rows, 0, len(rows), 0)
    splatter = Splatter()
    splatter.begin(n, 64, 48)
    splatter.add(
        surfels,
        view,
        depth_row(view, scene[0].frame, focus_of(camera, [scene[0].frame])),
        contribution_min=limit,
    )
    kept, seen = splatter._rows[:n, 6] >= 0.0, rows[:, 6] >= 0.0
    a, b, c, o = rows[:, 2:6].astype(np.float64).T
    # alpha = o 2^-(a x^2 + b x y + c y^2), whose integral is o pi / (ln 2 sqrt(a c - b^2 / 4))
    with np.errstate(divide="ignore", invalid="ignore"):
        area = o * np.pi / (np.log(2.0) * np.sqrt(np.maximum(a * c - b * b / 4.0, 0.0)))
    clear = np.abs(area - limit) > 1e-4 * limit
    np.testing.assert_array_equal(kept[seen & clear], (area >= limit)[seen & clear])
    assert not kept[~seen].any()
    assert 0.02 < kept[seen].mean() < 0.999


# ---------------------------------------------------------------- presenting


@pytest.mark.gl
@pytest.mark.parametrize("closed", [1.0, 0.9])
@pytest.mark.parametrize("background", [(0.2, 0.4, 0.6, 1.0), (0.9, 0.1, 0.3, 0.5), (0.0, 0.0, 0.0, 0.0)])
def test_the_kernel_presents_what_the_shader_presents(gl_context, closed, background):
    rng, (width, height) = np.random.default_rng(0), (37, 21)
    alpha = rng.choice([0.0, 0.3, 0.899, 0.9, 0.95, 1.0], (height, width)).astype(np.float32)
    color = (rng.random((3, height, width), np.float32) * alpha).astype(np.float32)
    tiled = [np.zeros((*part.shape[:-2], 24, 40), np.float32) for part in (color, alpha)]
    for whole, part in zip(tiled, (color, 1.0 - alpha), strict=True):
        whole[..., :height, :width] = part
    mine = np.empty((height, width, 4), np.uint8)
    presenting.present(tiled[0], tiled[1], np.float32(background), closed, mine)
    packed = np.concatenate([color, alpha[None]]).transpose(1, 2, 0)
    texture = gl_context.ctx.texture((width, height), 4, packed.tobytes(), dtype="f4", alignment=1)
    presenter = Presenter(gl_context.ctx)
    theirs = presenter.read(texture, background, closed)
    assert np.abs(mine.astype(int) - theirs).max() <= 1  # measured 1: halves are rounded up or to even
    presenter.release()
    texture.release()


@pytest.mark.gl
def test_a_window_gets_what_is_read(gl_context):
    scene = flat_scene(37, 21, num_levels=1, color=90)
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(scene)
    frame = renderer.render(scene[0].camera, RenderSettings(background=(0.8, 0.1, 0.4, 1.0)))
    screen = gl_context.ctx.simple_framebuffer((37, 21), 3)
    frame.present_to(screen, smooth=False)
    pixels = np.frombuffer(screen.read(components=3, alignment=1), np.uint8).reshape(21, 37, 3)
    assert np.abs(pixels[::-1].astype(int) - frame.read_color8()).max() <= 1  # measured 0
    screen.release()
    renderer.release()


def between_pixels(picture, width, height):
    """Bilinear with kept edges, in float64."""
    for axis, count in ((0, height), (1, width)):
        size = picture.shape[axis]
        places = np.clip((np.arange(count) + 0.5) * size / count - 0.5, 0, size - 1)
        first = np.minimum(places.astype(int), max(size - 2, 0))
        second, part = np.minimum(first + 1, size - 1), places - first
        part = part.reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        picture = picture.take(first, axis) * (1 - part) + picture.take(second, axis) * part
    return picture


@pytest.mark.parametrize("size", [(1, 1), (5, 3), (37, 21), (80, 60), (123, 90)])
def test_a_small_picture_is_enlarged_as_a_texture_would_be(size):
    picture = np.random.default_rng(1).integers(0, 256, (*size[::-1], 4), np.uint8)
    out = np.empty((60, 80, 4), np.uint8)
    pixels = (picture.view(np.uint32)[..., 0], out.view(np.uint32)[..., 0])
    presenting.fit(*pixels, False, False)
    expected = between_pixels(picture.astype(float), 80, 60)
    assert np.abs(out - expected).max() < 2.0  # measured 1.7: a step is 1/128, and it rounds twice
    if size == (80, 60):
        np.testing.assert_array_equal(out, picture)
    upright = out.copy()
    presenting.fit(*pixels, True, True)
    np.testing.assert_array_equal(out[::-1, :, [2, 1, 0, 3]], upright)


@pytest.mark.gl
def test_a_coarse_frame_fills_the_place_it_is_given(gl_context):
    scene = hill_scene(num_levels=1)
    renderer = SurfelRenderer(gl_context, "kernels")
    renderer.sync(scene)
    frame = renderer.render(scene[0].camera.resized(40, 30), RenderSettings(background=(0.8, 0.1, 0.4, 1.0)))
    screen = gl_context.ctx.simple_framebuffer((100, 80), 3)
    screen.clear()
    frame.present_to(screen, viewport=(10, 5, 60, 45))
    rows = np.frombuffer(screen.read(components=3, alignment=1), np.uint8).reshape(80, 100, 3)[::-1]
    inside = rows[80 - 50 : 80 - 5, 10:70]
    expected = between_pixels(frame.read_color8().astype(float), 60, 45)
    assert np.abs(inside - expected).max() < 2.0  # measured 1.0
    rows = rows.copy()
    rows[80 - 50 : 80 - 5, 10:70] = 0
    assert (rows == 0).all()
    screen.release()
    renderer.release()


@pytest.mark.gl
@pytest.mark.parametrize("is_for_window", [False, True])
def test_a_blit_is_upright_for_textures_and_for_windows(gl_context, is_for_window):
    blit = Blit.of(gl_context)
    if blit is None:
        pytest.skip("this context does not say where its functions are")
    picture = np.random.default_rng(2).integers(0, 256, (12, 16, 4), np.uint8)
    picture[..., 3] = 255
    screen = gl_context.ctx.simple_framebuffer((16, 12), 4)
    for shown in (255 - picture, picture):
        ordered = shown[..., [2, 1, 0, 3]] if is_for_window else shown[::-1]
        blit.upload(np.ascontiguousarray(ordered), is_for_window)
        blit.draw(screen, 0, 0)
        _ = gl_context.ctx.error  # moderngl leaves one when it makes a framebuffer, and when it reads one
        blit.draw(screen, 0, 0)
        assert gl_context.ctx.error == "GL_NO_ERROR"
        rows = np.frombuffer(screen.read(components=4, alignment=1), np.uint8).reshape(12, 16, 4)[::-1]
        np.testing.assert_array_equal(rows[..., :3], shown[..., :3])
    assert gl_context.ctx.error == "GL_NO_ERROR"
    screen.release()
    blit.release()


@pytest.mark.gl
def test_without_the_functions_a_quad_shows_the_picture(gl_context):
    scene = flat_scene(37, 21, num_levels=1, color=90)
    renderer = SurfelRenderer(replace(gl_context, load=None), "kernels")
    renderer.sync(scene)
    frame = renderer.render(scene[0].camera, RenderSettings(background=(0.8, 0.1, 0.4, 1.0)))
    screen = gl_context.ctx.simple_framebuffer((37, 21), 3)
    frame.present_to(screen, smooth=False)
    pixels = np.frombuffer(screen.read(components=3, alignment=1), np.uint8).reshape(21, 37, 3)
    assert np.abs(pixels[::-1].astype(int) - frame.read_color8()).max() <= 1  # measured 0
    screen.release()
    renderer.release()


# ---------------------------------------------------------------- where they cannot be had


def test_without_numba_they_are_never_ready(monkeypatch):
    monkeypatch.setitem(sys.modules, "wzviewer.kernels", None)
    kernels = Kernels()
    assert not kernels.are_ready(None)
    assert not kernels.are_loading


@pytest.mark.gl
@pytest.mark.parametrize("patient", [True, False])
def test_without_numba_the_shaders_draw(monkeypatch, gl_context, patient):
    monkeypatch.setitem(sys.modules, "wzviewer.kernels", None)
    scene = hill_scene()
    renderer = SurfelRenderer(gl_context, "kernels", patient=patient)
    for _ in range(3):
        assert renderer.sync(scene)
    assert renderer.rasterizer == "shaders"
    assert renderer.is_ready(None)  # there is nothing to wait for
    assert renderer.render(scene[1].camera).read_coverage().mean() > 0.5
    renderer.release()


@pytest.mark.gl
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_kernels_that_do_not_compile_leave_the_shaders(monkeypatch, gl_context):
    """An unknown processor, or a cache folder that cannot be written."""
    from wzviewer.kernels import splatting

    def fails():
        raise RuntimeError("cannot cache function")

    monkeypatch.setattr(splatting, "warm_up", fails)
    renderer = SurfelRenderer(gl_context, "kernels")
    scene = hill_scene()
    assert renderer.sync(scene)
    assert renderer.rasterizer == "shaders"
    assert renderer.render(scene[1].camera).read_coverage().mean() > 0.5
    renderer.release()
