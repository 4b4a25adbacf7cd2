"""The rasteriser against an independent float64 twin, and the laws that it must keep."""

from dataclasses import replace

import numba
import numpy as np
import pytest

from tests.worker import splat_twin
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift
from wzviewer.core.surfels import Surfels
from wzviewer.kernels.chain import opacity_variable
from wzviewer.kernels.elementary import BLOCK
from wzviewer.worker.objective import AdamState, SurfelObjective
from wzviewer.worker.rasterize import LevelPart, render


def turned(camera, degrees, pivot):
    """The camera moved around a world point, about the vertical."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    pose = np.eye(4)
    pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    pose[:3, 3] = pivot - pose[:3, :3] @ pivot
    return replace(camera, camera_from_world=camera.camera_from_world @ pose)


def camera_and_frame(width=37, height=29):
    """A camera off its axis, turned away from the one that made the level."""
    camera = Camera(np.eye(4), 60.0, 70.0, width / 2 + 25, height / 2 - 11, width, height)
    frame = LevelFrame.of_camera(camera, 2.0)
    return turned(camera, 7.0, frame.origin), frame


def random_splats(n=60, seed=0, size=(37, 29)):
    rng = np.random.default_rng(seed)
    means = (rng.random((n, 3)) - 0.5) * [size[0], size[1], 12]
    return splat_twin.Splats(
        means.astype(np.float32).astype(np.float64),
        rng.normal(size=(n, 4)).astype(np.float32).astype(np.float64),
        np.log(rng.random((n, 2)) * 3 + 0.4).astype(np.float32).astype(np.float64),
        np.clip(rng.normal(0.3, 0.9, n), -1.8, 1.8).astype(np.float32).astype(np.float64),
        rng.random((n, 3)).astype(np.float32).astype(np.float64),
    )


def surfels_of(splats):
    n = len(splats.means)
    return Surfels(
        means=splats.means,
        quats=splats.quats / np.linalg.norm(splats.quats, axis=1, keepdims=True),
        scales=np.exp(splats.log_scales),
        opacities=splats.opacities,
        colors=splats.colors,
        native_scales=np.ones(n),
        coverage=np.ones(n),
    )


def assert_same_picture(color, twin):
    """The parity rule of all renderers: an alpha at the cut may fall either way."""
    error = np.abs(color - twin)
    assert error.max() < 2 / 255  # measured 2e-6: nothing sits at the cut
    assert error.mean() < 2e-4  # measured 6e-8


@pytest.mark.parametrize("seed", range(3))
def test_colour_coverage_and_depth_are_those_of_the_twin(seed):
    camera, frame = camera_and_frame()
    splats = random_splats(seed=seed)
    anchor = (2.5, 0.01)
    got = render([LevelPart.of(surfels_of(splats), frame)], camera, (0.2, 0.5, 0.9), depth_anchor=anchor)
    image, through, depth = splat_twin.render(splats, camera, frame, (0.2, 0.5, 0.9))
    assert_same_picture(got.color, image)
    assert_same_picture(got.coverage, 1 - through)
    relief = (depth - anchor[0]) / anchor[1]
    sure = np.abs(through - 0.5) > 1e-3
    assert (np.isnan(got.relief) == np.isnan(relief))[sure].all()
    differs = ~np.isclose(got.relief, relief, atol=1e-3) & ~np.isnan(relief)
    assert differs.mean() < 0.005  # measured 0: the crossing of 0.5 is a step, so a few pixels may flip
    assert 0.2 < (~np.isnan(relief)).mean() < 1  # the scene shows both


@pytest.mark.parametrize("blend", ["transmittance", "linear"])
def test_weights_follow_the_twin(blend):
    camera, frame = camera_and_frame()
    splats = random_splats(seed=5)
    weights = np.random.default_rng(1).random(60).astype(np.float32)
    weights[:5] = (0, 0, 1, 1, 1e-4)
    part = LevelPart.of(surfels_of(splats), frame, weights)
    image, _, depth = splat_twin.render(splats, camera, frame, weights=weights.astype(float), blend=blend)
    got = render([part], camera, blend=blend, depth_anchor=(0.0, 1.0))
    assert_same_picture(got.color, image)
    assert np.isclose(got.relief, depth, atol=1e-4, equal_nan=True).mean() > 0.995


def test_shares_of_one_surfel_add_up_to_it_only_by_transmittance():
    camera, frame = camera_and_frame()
    surfels = surfels_of(random_splats(n=1, seed=3))
    whole = render([LevelPart.of(surfels, frame)], camera).coverage
    shares = [LevelPart.of(surfels, frame, np.full(1, w, np.float32)) for w in (0.3, 0.7)]
    assert np.abs(render(shares, camera).coverage - whole).max() < 2e-6  # measured 2e-7
    assert np.abs(render(shares, camera, blend="linear").coverage - whole).max() > 0.05


def test_levels_with_their_own_frames_are_one_scene():
    camera, frame = camera_and_frame()
    splats = random_splats(seed=7)
    surfels = surfels_of(splats)
    together = render([LevelPart.of(surfels, frame)], camera)
    ratio, shift = 8.0, np.array([0.01, -0.02, 0.03])
    other = LevelFrame(frame.origin + shift, frame.axes, frame.unit / ratio)
    means = (surfels.means - shift / frame.unit) * ratio
    moved = surfels.with_(means=means.astype(np.float32), scales=surfels.scales * np.float32(ratio))
    odd = np.arange(60) % 2 == 1
    parts = [LevelPart.of(surfels.take(~odd), frame), LevelPart.of(moved.take(odd), other)]
    apart = render(parts, camera)
    assert_same_picture(apart.color, together.color)
    assert np.isclose(apart.relief, together.relief, atol=0.01, equal_nan=True).mean() > 0.99


def test_ties_in_depth_go_to_the_first_part():
    camera = Camera.initial(16, 16)
    frame = LevelFrame.of_camera(camera, 1.0)
    red, blue = (np.zeros((16, 16, 3), np.float32) for _ in range(2))
    red[..., 0], blue[..., 2] = 1, 1
    flat = np.zeros((16, 16), np.float32)
    parts = [LevelPart.of(lift(image, flat, camera), frame) for image in (red, blue)]
    assert render(parts, camera).color[..., 0].mean() > 0.9
    assert render(parts[::-1], camera).color[..., 2].mean() > 0.9


@pytest.mark.parametrize("size", [(64, 43), (333, 217), (8, 8), (1, 1)])
def test_any_size_shows_the_picture(size):
    width, height = size
    camera = Camera.initial(width, height)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    image = np.stack([x / width, y / height, 0.5 + 0 * x], -1)
    relief = (x - width / 2) * np.float32(0.5)
    surfels = lift(image, relief, camera)
    got = render([LevelPart.of(surfels, LevelFrame.of_camera(camera, 1.0))], camera)
    assert got.color.shape == (height, width, 3)
    inner = (slice(1, -1), slice(1, -1)) if min(size) > 3 else (slice(None), slice(None))
    # a neighbour in front, less than one pixel away, shines through: a share of one pixel's step
    assert np.abs(got.color - image)[inner].max() < 0.02 + 0.3 / min(size)
    assert np.allclose(got.relief, relief, atol=1.01)  # of this pixel or its neighbour in front


def test_nothing_gives_the_background():
    camera = Camera.initial(20, 10)
    frame = LevelFrame.of_camera(camera, 1.0)
    for parts in ([], [LevelPart.of(Surfels.empty(), frame)]):
        got = render(parts, camera, (0.1, 0.2, 0.3))
        assert np.allclose(got.color, [0.1, 0.2, 0.3])
        assert np.isnan(got.relief).all()
        assert (got.coverage == 0).all()


def test_broken_and_hidden_surfels_are_ignored_and_huge_ones_fill():
    camera = Camera.initial(50, 30)
    frame = LevelFrame.of_camera(camera, 1.0)
    surfels = surfels_of(random_splats(n=8, size=(50, 30)))
    means = surfels.means.copy()
    means[0], means[1], means[2, 2] = np.nan, np.inf, -1e9
    scales = surfels.scales.copy()
    scales[3] = 1e30
    surfels = surfels.with_(means=means, scales=scales)
    clean = render([LevelPart.of(surfels.take(slice(4, 8)), frame)], camera)
    assert np.array_equal(render([LevelPart.of(surfels, frame)], camera).color, clean.color)
    scales[3] = 1e5
    facing = np.tile(np.float32([1, 0, 0, 0]), (8, 1))
    huge = surfels.with_(scales=scales, quats=facing, opacities=np.full(8, 0.99, np.float32)).take([3])
    assert render([LevelPart.of(huge, frame)], camera).coverage.min() > 0.98


@pytest.mark.parametrize("level", [4, 12])
def test_a_deep_level_renders_like_the_first(level):
    first = Camera.initial(48, 32)
    rng = np.random.default_rng(2)
    image = rng.random((32, 48, 3)).astype(np.float32)
    relief = rng.normal(0, 1, (32, 48)).astype(np.float32)
    normals = np.tile(np.float32([0, 0, -1]), (32, 48, 1))
    deep = first
    for _ in range(level):
        deep = deep.zoomed_to_region(0.61, 0.37, 8.0)
    pictures = []
    for camera in (first, deep):
        # footprints are round in the creating camera and the order is that of the relief, so the
        # picture is the same whatever the focal length
        surfels = lift(image, relief, camera, normals)
        pictures.append(render([LevelPart.of(surfels, LevelFrame.of_camera(camera, 1.0))], camera))
    assert np.abs(pictures[1].color - pictures[0].color).max() < 1e-4  # measured 2e-6
    assert np.array_equal(pictures[1].relief, pictures[0].relief)


def finite_differences(splats, camera, frame, target, background, picks):
    """Central differences of the twin's loss by q, log s and x of some surfels."""
    found = []
    for name, i, k in picks:
        values = []
        for sign in (1, -1):
            moved = replace(splats, **{name: getattr(splats, name).copy()})
            getattr(moved, name)[(i, k) if name != "x" else i] += sign * 1e-6
            values.append(splat_twin.loss(splat_twin.render(moved, camera, frame, background)[0], target))
        found.append((values[0] - values[1]) / 2e-6)
    return np.array(found)


def objective_of(splats, frame):
    objective = SurfelObjective(surfels_of(splats), frame)
    objective.quats[:] = splats.quats
    objective.log_scales[:] = splats.log_scales
    objective.x[:] = splats.x
    return objective


# the tall image has two bands of tile rows, and surfels that reach over their border
@pytest.mark.parametrize("size", [(37, 29), (9, 250)])
def test_gradients_are_those_of_the_twin(size):
    camera, frame = camera_and_frame(*size)
    splats = random_splats(n=24, seed=1, size=size)
    splats.means[:9, 1] = np.linspace(-9, 9, 9)
    target = np.random.default_rng(9).random((size[1], size[0], 3)).astype(np.float32)
    objective = objective_of(splats, frame)
    background = (0.3, 0.6, 0.1)
    value, gradients = objective.gradient(objective.prepare(camera, target), background)
    image = splat_twin.render(splats, camera, frame, background)[0]
    # measured 2e-8
    assert value == pytest.approx(splat_twin.loss(image, target.astype(float)), rel=1e-6)
    for name, width in {"quats": 4, "log_scales": 2, "x": 1}.items():
        picks = [(name, i, k) for i in range(0, 24, 3) for k in range(width)]
        truth = finite_differences(splats, camera, frame, target.astype(float), background, picks)
        got = getattr(gradients, name).reshape(24, width)[::3].ravel()
        error = np.linalg.norm(got - truth) / np.linalg.norm(truth)
        assert error < 5e-5, name  # measured 3e-6, 9e-7 and 8e-7


def test_a_step_is_one_of_adam_down_the_gradient():
    camera, frame = camera_and_frame()
    splats = random_splats(n=40, seed=6)
    target = np.random.default_rng(1).random((29, 37, 3)).astype(np.float32)
    objective, rates = objective_of(splats, frame), (0.01, 0.03, 0.2)
    state, view, kept = AdamState(40, rates), objective.prepare(camera, target), np.arange(40) % 5 == 0
    before = [v.copy() for v in (objective.quats, objective.log_scales, objective.x)]
    _, slopes = objective.gradient(view)
    objective.descend(view, state, kept=kept)
    after = (objective.quats, objective.log_scales, objective.x)
    moved = np.zeros(40, bool)
    for old, new, slope, rate in zip(before, after, vars(slopes).values(), rates, strict=True):
        slope = np.where(kept.reshape(-1, *[1] * (slope.ndim - 1)), 0, slope)
        # the first step is the rate itself, whatever the slope: one part in a thousand of it is rounding
        assert np.allclose(old - new, rate * np.sign(slope), atol=1e-3 * rate)
        moved |= slope.reshape(40, -1).any(1)
    assert moved.sum() > 20


def test_what_a_view_does_not_see_stays():
    camera = Camera.initial(144, 96)  # 13 824 surfels: four blocks
    frame = LevelFrame.of_camera(camera, 1.0)
    image = np.random.default_rng(2).random((96, 144, 3)).astype(np.float32)
    objective = SurfelObjective(lift(image, np.zeros((96, 144), np.float32), camera), frame)
    crop = objective.prepare(camera.zoomed_to_region(0.9, 0.9, 8.0), image)
    assert 0 < len(crop.order) < 900  # measured 560
    assert crop.blocks.tolist() == [2, 3]
    before, state = objective.x.copy(), AdamState(len(objective.x), (0.01, 0.03, 0.2))
    for _ in range(2):
        objective.descend(crop, state)
    changed = np.flatnonzero(objective.x != before)
    assert len(changed) > 100
    assert set(changed // BLOCK) == {2, 3}


def test_masked_pixels_pull_at_nothing():
    camera, frame = camera_and_frame()
    splats = random_splats(n=30, seed=4)
    objective = objective_of(splats, frame)
    mask = np.zeros((29, 37), bool)
    target = np.random.default_rng(1).random((29, 37, 3)).astype(np.float32)
    _, gradients = objective.gradient(objective.prepare(camera, target, mask))
    assert not gradients.x.any()
    mask[:, :20] = True
    pulled = [target, np.where(mask[..., None], target, 0).astype(np.float32)]
    results = [objective.gradient(objective.prepare(camera, t, mask))[1].x for t in pulled]
    assert np.linalg.norm(results[0]) > 1e-4
    # the window of a known pixel still sees the target beyond the mask, as a perfect match
    assert np.linalg.norm(results[0] - results[1]) < 0.2 * np.linalg.norm(results[0])


def test_a_target_of_another_size_is_refused():
    camera, frame = camera_and_frame()
    objective = objective_of(random_splats(n=3), frame)
    with pytest.raises(ValueError, match="must fit"):
        objective.prepare(camera, np.zeros((9, 9, 3), np.float32))


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one core: there is only one thread count")
def test_bytes_do_not_depend_on_the_number_of_threads():
    camera = Camera.initial(180, 300)  # 37 tile rows: two bands; 54 000 surfels: 14 blocks
    rng = np.random.default_rng(3)
    image = rng.random((300, 180, 3)).astype(np.float32)
    surfels = lift(image, rng.normal(0, 2, (300, 180)).astype(np.float32), camera)
    frame = LevelFrame.of_camera(camera, 1.0)
    target = rng.random((300, 180, 3)).astype(np.float32)
    runs, threads = [], numba.get_num_threads()
    try:
        for count in (1, 2):
            numba.set_num_threads(count)
            objective = SurfelObjective(surfels, frame)
            value, g = objective.gradient(objective.prepare(camera, target))
            weights = np.full(len(surfels), 0.6, np.float32)
            seen = render([LevelPart.of(surfels, frame, weights)], camera)
            runs.append([np.float64(value), g.quats, g.log_scales, g.x, seen.color, seen.relief])
    finally:
        numba.set_num_threads(threads)
    for one, two in zip(*runs, strict=True):
        assert one.tobytes() == two.tobytes()


def test_opacity_variable_inverts_the_activation():
    o = np.linspace(0.02, 0.98, 20).astype(np.float32)
    assert np.allclose(0.51 * np.tanh(opacity_variable(o)) + 0.5, o, atol=1e-6)
