"""Frames of the GPU against the slow exact renderer."""

from dataclasses import replace

import numpy as np
import pytest

from tests.gl.surfaces import add_surface, flat_scene, hill_scene, hills, noise_image, orbited
from wzviewer.core import reference
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.records import pack, unpack
from wzviewer.gl.renderer import SurfelRenderer

ALL = frozenset({"color", "coverage", "depth", "level"})


@pytest.fixture(params=["shaders", "kernels"])
def renderer(request, gl_context):
    made = SurfelRenderer(gl_context, request.param)
    assert made.rasterizer == request.param
    yield made
    made.release()


@pytest.fixture
def shaders(gl_context):
    made = SurfelRenderer(gl_context, "shaders")
    yield made
    made.release()


def as_held(renderer, scene):
    """The scene as the rasteriser holds it: the shaders read records, the kernels the scene itself."""
    return decoded(scene) if renderer.rasterizer == "shaders" else scene


def tree_scene():
    """A root, two overlapping children, a grandchild."""
    scene, root = Scene(), Camera.initial(40, 28)
    first, second = root.zoomed_to_region(0.4, 0.5, 4.0), root.zoomed_to_region(0.5, 0.6, 5.0)
    for parent, camera in ((None, root), (0, first), (0, second), (1, first.zoomed_to_region(0.5, 0.5, 4.0))):
        add_surface(scene, parent, camera, hills(camera, root), noise_image(camera, len(scene)))
    return scene


def views(scene):
    last = scene[len(scene) - 1].camera
    root = scene[0].camera
    yield root
    yield root.zoomed(18.0, 15.0, 2.83)  # between two levels
    yield orbited(scene[1].camera, scene[1].frame.origin, 8.0)
    yield last.zoomed(20.0, 14.0, 5.0)  # beyond the last: big footprints


def decoded(scene):
    copy = Scene()
    for level in scene:
        copy.append(level.with_surfels(unpack(pack(level.surfels, 0))))
    return copy


@pytest.mark.parametrize("blend", ["transmittance", "linear"])
@pytest.mark.parametrize("make", [hill_scene, tree_scene])
def test_colour_is_the_references(renderer, make, blend):
    scene = make()
    renderer.sync(scene)
    for camera in views(scene):
        expected = reference.render(scene, camera, blend)
        color = renderer.render(camera, RenderSettings(blend=blend)).read_color()
        error = np.abs(color[..., :3] - expected.color)
        # float32 target: measured max 0.6/255, mean 2e-5 (records); a float16 target: 1.0/255 and 8e-4.
        assert error.max() <= 2 / 255
        assert error.mean() <= 2e-4
        assert np.abs(color[..., 3] - expected.coverage).max() <= 0.004


def test_with_the_same_records_only_rounding_is_left(renderer, gl_context):
    scene = tree_scene()
    renderer.sync(scene)
    for camera in views(scene):
        expected = reference.render(as_held(renderer, scene), camera)
        color = renderer.render(camera).read_color()
        error = np.abs(color[..., :3] - expected.color)
        assert error.max() <= 1 / 255  # a fragment exactly at the cut may fall on its other side
        limit = 1e-5 if gl_context.is_software else 1e-3  # measured 1e-6 with a float32 target
        assert np.quantile(error, 0.99) < limit  # all but 17 of 3360 values in one of four views


def test_without_modulation_every_level_is_drawn_in_full(renderer):
    scene = hill_scene()
    renderer.sync(scene)
    camera = scene[1].camera
    expected = reference.render(scene, camera, modulation=False)
    color = renderer.render(camera, RenderSettings(modulation=False)).read_color()
    assert np.abs(color[..., :3] - expected.color).max() <= 2 / 255
    modulated = renderer.render(camera).read_color()
    assert np.abs(modulated - color).max() > 0.2  # the switch does something


@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_median_depth_and_level_are_the_references(renderer, blend):
    scene = tree_scene()
    renderer.sync(scene)
    for camera in views(scene):
        expected = reference.render(as_held(renderer, scene), camera, blend)
        frame = renderer.render(camera, RenderSettings(blend=blend, outputs=ALL))
        depth, level = frame.read_depth(), frame.read_level()
        # The crossing of 1/2 is a step: a pixel in ten thousand may fall on its other side.
        wrong = (np.isnan(depth) != np.isnan(expected.depth)) | (level != expected.level)
        assert wrong.mean() <= 0.002  # measured 0
        both = ~np.isnan(depth) & ~np.isnan(expected.depth)
        assert (np.abs(depth - expected.depth)[both] > 1e-12).mean() <= 0.002  # the same surfel
        assert set(np.unique(level)) <= {-1, 0, 1, 2, 3}
    assert both.any()


def test_points_and_quads_draw_the_same_picture(shaders):
    renderer = shaders
    scene = tree_scene()
    renderer.sync(scene)
    for camera in [*views(scene)][:3]:
        points = renderer.render(camera, RenderSettings(quads=False))
        assert not points.stats.quads
        first = points.read_color()
        second = renderer.render(camera, RenderSettings(quads=True)).read_color()
        assert np.abs(first - second).max() <= 1 / 255  # measured 1e-4: a pixel centre on the edge of a point


def test_footprints_beyond_the_point_limit_go_as_quads(shaders):
    renderer = shaders
    scene = hill_scene(num_levels=1)
    renderer.sync(scene)
    camera = scene[0].camera.zoomed(20.0, 14.0, 400.0)
    frame = renderer.render(camera)
    assert frame.stats.quads
    expected = reference.render(scene, camera)
    assert np.abs(frame.read_color()[..., :3] - expected.color).max() <= 2 / 255


def test_culling_never_changes_the_picture(renderer):
    scene = flat_scene(160, 120, num_levels=3)  # 19200 surfels a level: two chunks each
    renderer.sync(scene)
    near = scene[1].camera
    for camera in (
        near,
        near.zoomed(10.0, 100.0, 3.0),
        orbited(scene[2].camera, scene[2].frame.origin, -8.0),
    ):
        culled = renderer.render(camera, RenderSettings(quads=True))
        first = culled.read_color()
        whole = renderer.render(camera, RenderSettings(quads=True, culling=False))
        assert culled.stats.num_chunks < whole.stats.num_chunks
        assert np.abs(first - whole.read_color()).max() < 1e-6


def test_a_zoom_of_eight_to_the_twelfth(renderer):
    scene = hill_scene(32, 24, num_levels=2)
    camera = scene[1].camera
    for i in range(2, 13):
        camera = camera.zoomed_to_region(0.45, 0.55, 8.0)
        add_surface(scene, i - 1, camera, hills(camera, scene[0].camera), noise_image(camera, i))
    renderer.sync(scene)
    for view in (camera, camera.zoomed(16.0, 12.0, 0.4), orbited(camera, scene[12].frame.origin, 8.0)):
        expected = reference.render(scene, view)
        frame = renderer.render(view, RenderSettings(outputs=ALL))
        error = np.abs(frame.read_color()[..., :3] - expected.color)
        assert error.max() < 0.01  # measured 0.002: noise of full contrast, 0.002 px of float64
        assert error.mean() < 1e-4  # measured 3e-5
        level = frame.read_level()
        assert (level == expected.level).mean() > 0.99
        assert level.max() == 12
        anchor_depth = float(view.to_camera(scene[12].frame.origin)[2])
        relief = frame.read_relief(anchor_depth, scene[12].frame.unit)
        assert np.nanmax(np.abs(relief)) < 1e3  # native px; world float32 would say 0 or millions


def test_hidden_levels_are_neither_drawn_nor_cover(renderer):
    scene = hill_scene(num_levels=2)
    camera = scene[1].camera
    renderer.sync(scene)
    both = renderer.render(camera).read_color()
    scene.hide(1)
    renderer.sync(scene)
    undone = renderer.render(camera).read_color()
    alone = reference.render(hill_scene(num_levels=1), camera)
    assert np.abs(undone[..., :3] - alone.color).max() <= 2 / 255
    scene.show(1)
    renderer.sync(scene)
    np.testing.assert_array_equal(renderer.render(camera).read_color(), both)


def test_a_level_that_has_not_arrived_leaves_its_parent_whole(renderer):
    scene = hill_scene(num_levels=1)
    renderer.sync(scene)
    root = scene[0].camera
    camera = root.zoomed_to_region(0.45, 0.55, 8.0)
    before = renderer.render(camera).read_color()
    add_surface(scene, 0, camera, hills(camera, root), noise_image(camera, 5))
    renderer._rasterizer.pages.upload = lambda budget=None: 0  # the driver is busy
    assert not renderer.sync(scene)
    np.testing.assert_array_equal(renderer.render(camera).read_color(), before)
    del renderer._rasterizer.pages.upload
    assert renderer.sync(scene)
    assert np.abs(renderer.render(camera).read_color() - before).max() > 0.1


def test_a_level_without_surfels_takes_no_share(renderer):
    scene = hill_scene(num_levels=2)
    camera = scene[1].camera
    empty = scene[1].with_surfels(scene[1].surfels.take(slice(0, 0)))
    scene.replace(empty)
    assert renderer.sync(scene)
    alone = reference.render(hill_scene(num_levels=1), camera)
    assert np.abs(renderer.render(camera).read_color()[..., :3] - alone.color).max() <= 2 / 255


def test_replaced_and_aborted_levels(renderer):
    scene = hill_scene(num_levels=2)
    renderer.sync(scene)
    camera = scene[1].camera
    red = scene[1].surfels.with_(colors=np.tile(np.float32([1, 0, 0]), (len(scene[1].surfels), 1)))
    scene.replace(scene[1].with_surfels(red))
    renderer.sync(scene)
    color = renderer.render(camera).read_color()
    assert color[14, 20, 0] > 0.9
    assert color[14, 20, 1:3].max() < 0.05
    scene.abort(1)
    renderer.sync(scene)
    alone = reference.render(hill_scene(num_levels=1), camera)
    assert np.abs(renderer.render(camera).read_color()[..., :3] - alone.color).max() <= 2 / 255


def test_an_empty_scene_and_an_empty_size(renderer):
    camera = Camera.initial(20, 10)
    renderer.sync(Scene())
    frame = renderer.render(camera, RenderSettings(background=(1.0, 0.0, 0.0, 1.0), outputs=ALL))
    assert (frame.read_color8() == [255, 0, 0]).all()
    assert np.isnan(frame.read_depth()).all()
    assert (frame.read_level() == -1).all()
    assert renderer.pick(camera, 3.0, 3.0) is None
    none = renderer.render(replace(camera, width=0, height=0))
    assert none.read_color8().shape == (0, 0, 3)
    assert none.read_coverage().shape == (0, 0)


def test_sizes_may_change_between_frames(renderer):
    scene = hill_scene(num_levels=1)
    renderer.sync(scene)
    first = renderer.render(scene[0].camera).read_color8()
    small = renderer.render(scene[0].camera.resized(20, 14))
    assert small.read_color8().shape == (14, 20, 3)
    np.testing.assert_array_equal(renderer.render(scene[0].camera).read_color8(), first)


def test_depth_has_to_be_asked_for(renderer):
    scene = hill_scene(num_levels=1)
    renderer.sync(scene)
    with pytest.raises(ValueError, match="outputs"):
        renderer.render(scene[0].camera).read_depth()


def test_the_same_frame_twice_is_the_same_bytes(renderer):
    scene = hill_scene()
    renderer.sync(scene)
    first = renderer.render(scene[1].camera)
    color = first.read_color()
    again = renderer.render(scene[1].camera)
    np.testing.assert_array_equal(again.read_color(), color)
    if renderer.rasterizer == "shaders":  # which keep the order; the kernels' is a small part of a frame
        assert first.stats.sort_ms > 0.0
        assert again.stats.sort_ms == 0.0


def test_picking_finds_what_the_frame_shows(renderer):
    scene = tree_scene()
    renderer.sync(scene)
    for camera in views(scene):
        frame = renderer.render(camera, RenderSettings(outputs=ALL))
        depth, level = frame.read_depth(), frame.read_level()
        for x, y in ((20, 14), (3, 4), (33, 20)):
            if np.isnan(depth[y, x]):
                continue
            picked = renderer.pick(camera, x + 0.3, y + 0.8)
            assert picked is not None
            assert picked[1] == level[y, x]
            assert abs(picked[0] - depth[y, x]) < 1e-9
    away = orbited(scene[0].camera, scene[0].frame.origin, 80.0)
    assert renderer.pick(away.zoomed(20.0, 14.0, 0.1), 0.5, 0.5) is None


def test_an_anchor_behind_the_camera_is_no_obstacle(renderer):
    """Fly past the middle of the root: what lies farther is still drawn, and nothing mirrored."""
    scene, root = Scene(), Camera.initial(40, 28)
    depth = np.tile(np.where(np.arange(40) < 20, 0.6, 1.5), (28, 1))
    add_surface(scene, None, root, depth, noise_image(root, 0))
    renderer.sync(scene)
    pose = np.eye(4)
    pose[2, 3] = -(scene[0].anchor_depth + 0.05)
    camera = replace(root, camera_from_world=pose)
    expected = reference.render(scene, camera)
    assert 0.2 < expected.coverage.mean() < 0.8
    color = renderer.render(camera).read_color()
    error = np.abs(color - np.concatenate([expected.color, expected.coverage[..., None]], -1))
    assert error.max() <= 2 / 255  # measured 0.1/255


@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_an_order_made_on_the_gpu_gives_the_same_frame(gl_context, shaders, blend):
    gpu = SurfelRenderer(gl_context, "shaders", gpu_order=True)
    scene = tree_scene()
    shaders.sync(scene)
    gpu.sync(scene)
    if not gpu._rasterizer.orders_itself:
        gpu.release()
        pytest.skip("no compute shaders in this context")
    for camera in views(scene):
        settings = RenderSettings(blend=blend, outputs=ALL)
        expected = shaders.render(camera, settings)
        color, levels, depth = expected.read_color(), expected.read_level(), expected.read_depth()
        frame = gpu.render(camera, settings)
        np.testing.assert_array_equal(frame.read_color(), color)
        np.testing.assert_array_equal(frame.read_level(), levels)
        np.testing.assert_array_equal(frame.read_depth(), depth)
    gpu.release()
