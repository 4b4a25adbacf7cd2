"""Stage 5: what it gains, what it must leave alone, and that it does not overfit the pixel grid."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, zoom

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.errors import Cancelled
from wzviewer.worker.rasterize import LevelPart, render, warm_up
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
from wzviewer.worker.stages.stage5_optimization import TargetView, optimize, view_schedule


def psnr_db(a, b):
    return float(-10 * np.log10(np.mean((a - b) ** 2)))


@pytest.fixture(scope="module")
def level():
    """A textured bumpy surface: image, camera, frame and unoptimised surfels."""
    width, height = 133, 91
    rng = np.random.default_rng(0)
    coarse = zoom(rng.random((12, 17, 3)), (height / 12, width / 17, 1), order=3)
    dark = np.kron(rng.random((46, 67)) < 0.5, np.ones((2, 2)))[:height, :width]
    image = np.clip(coarse * (1 - 0.4 * dark[..., None]), 0, 1).astype(np.float32)
    relief = (gaussian_filter(rng.normal(0, 1, (height, width)), 6) * 60).astype(np.float32)
    relief += np.linspace(30, -30, height, dtype=np.float32)[:, None]
    camera = Camera.initial(width, height)
    return image, camera, LevelFrame.of_camera(camera, 1.0), generate_surfels(image, relief, camera)


@pytest.fixture(scope="module")
def optimised(level):
    image, camera, frame, surfels = level
    return optimize(surfels, image, camera, frame)


def seen(surfels, camera, frame):
    return render([LevelPart.of(surfels, frame)], camera)


def test_the_creating_view_becomes_the_image(level, optimised):
    image, camera, frame, surfels = level
    before = psnr_db(seen(surfels, camera, frame).color, image)
    plain = optimize(surfels, image, camera, frame, color_steps=0)
    after = psnr_db(seen(plain, camera, frame).color, image)
    with_colors = psnr_db(seen(optimised, camera, frame).color, image)
    assert after > before + 4  # measured 27.4 and 34.5 dB
    assert with_colors > after + 3  # measured 47.0 dB


def test_no_holes_open_off_the_grid(level, optimised):
    _, camera, frame, _ = level
    for view in (replace(camera, cx=camera.cx + 0.5, cy=camera.cy + 0.5), camera.zoomed(60, 40, 8.0)):
        got = seen(optimised, view, frame).coverage[2:-2, 2:-2]
        assert (got < 0.5).mean() < 0.003  # measured 0.0004 at most
        assert got.mean() > 0.85  # measured 0.89


def test_the_creating_view_alone_is_overfitted(level, optimised, monkeypatch):
    """The reason for the schedule; should this fail, the schedule can go."""
    image, camera, frame, surfels = level
    module = "wzviewer.worker.stages.stage5_optimization.view_schedule"
    monkeypatch.setattr(module, lambda source, views, steps: [source] * steps)
    alone = optimize(surfels, image, camera, frame)
    near = camera.zoomed(60, 40, 8.0)
    thin, firm = (1 - seen(s, near, frame).coverage.mean() for s in (alone, optimised))
    assert thin > 1.4 * firm  # measured 0.170 and 0.099


def test_positions_native_scales_and_coverage_stay(level, optimised):
    _, _, _, surfels = level
    for name in ("means", "native_scales", "coverage"):
        assert np.array_equal(getattr(optimised, name), getattr(surfels, name))
    assert np.allclose(np.linalg.norm(optimised.quats, axis=1), 1, atol=1e-5)
    assert ((optimised.opacities > 0) & (optimised.opacities < 1)).all()
    assert ((optimised.colors >= 0) & (optimised.colors <= 1)).all()
    for name in ("quats", "scales", "opacities", "colors"):
        assert not np.array_equal(getattr(optimised, name), getattr(surfels, name))


def test_without_color_steps_colors_are_the_pixels(level):
    image, camera, frame, surfels = level
    result = optimize(surfels, image, camera, frame, steps=1, color_steps=0)
    assert np.array_equal(result.colors, surfels.colors)


def test_the_same_input_gives_the_same_bytes(level, optimised):
    image, camera, frame, surfels = level
    again = optimize(surfels, image, camera, frame)
    for name, array in again.arrays().items():
        assert array.tobytes() == getattr(optimised, name).tobytes()


def test_neighbours_are_learnt_and_their_masks_respected(level):
    image, camera, frame, surfels = level
    view = replace(camera, cx=camera.cx + 9.3)
    blue, unknown = np.zeros_like(image), np.zeros(image.shape[:2], bool)
    blue[..., 2] = 1.0
    black = np.zeros_like(image)
    opacities = [
        optimize(surfels, image, camera, frame, [TargetView(view, *pair)], 6, 0).opacities
        for pair in ((blue, unknown), (black, unknown), (black, None))
    ]
    assert np.array_equal(opacities[0], opacities[1])  # an unknown target is nobody's
    assert opacities[2].mean() < opacities[1].mean() - 0.004  # measured 0.008


def test_hidden_surfels_keep_their_colors(level):
    image, camera, frame, surfels = level
    behind = surfels.with_(means=surfels.means + np.float32([0, 0, 400]), colors=1 - surfels.colors)
    both = type(surfels).concatenate([surfels, behind])
    result = optimize(both, image, camera, frame, steps=2)
    n = len(surfels)
    ahead = np.abs(result.colors[n:] - both.colors[n:]).max(1) > 0
    assert ahead.mean() < 0.02  # a few at the border own a pixel that nothing covers
    assert np.abs(result.colors[:n] - both.colors[:n]).mean() > 1e-4


def test_progress_is_told_and_cancelling_stops(level):
    image, camera, frame, surfels = level
    told = []

    def on_step(done, total):
        told.append((done, total))
        if done == 2:
            raise Cancelled

    with pytest.raises(Cancelled):
        optimize(surfels, image, camera, frame, steps=4, color_steps=1, on_step=on_step)
    assert told == [(0, 5), (1, 5), (2, 5)]


def test_the_schedule_alternates_and_always_leaves_the_grid():
    source = TargetView(Camera.initial(31, 20), np.zeros((20, 31, 3), np.float32))
    views = [TargetView(source.camera, source.target) for _ in range(2)]
    with_views = view_schedule(source, views, 12)
    assert [v is source for v in with_views] == [True, False, False] * 4
    assert [with_views[k] for k in (1, 4, 7, 10)] == [views[0], views[1], views[0], views[1]]
    assert len({id(with_views[k]) for k in (2, 5, 8, 11)}) == 4
    alone = view_schedule(source, [], 8)
    assert [v is source for v in alone] == [True, False] * 4
    assert alone[1].camera.cx == source.camera.cx + 0.5


def test_resampled_targets_show_what_their_camera_sees():
    width, height = 31, 20
    camera = Camera.initial(width, height)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    image = np.stack([x / width, y / height, 0 * x], -1).astype(np.float32)
    for view in view_schedule(TargetView(camera, image), [], 8)[1::2]:
        known_x = (x - view.camera.cx) / view.camera.fx * camera.fx + camera.cx
        error = np.abs(view.target[..., 0] - known_x / width)[view.mask]
        assert view.mask.mean() > 0.85
        assert error.max() < 4e-3  # measured 2e-3: cubic interpolation against the border


def test_no_surfels_and_no_steps_change_nothing(level):
    image, camera, frame, surfels = level
    assert len(optimize(surfels.take(slice(0, 0)), image, camera, frame)) == 0
    same = optimize(surfels, image, camera, frame, steps=0, color_steps=0)
    assert np.allclose(same.scales, surfels.scales, rtol=1e-6)
    assert np.allclose(same.opacities, surfels.opacities, atol=1e-6)


def test_warm_up_runs():
    warm_up()


def test_what_is_kept_keeps_its_shape(level):
    image, camera, frame, surfels = level
    kept = np.arange(len(surfels)) % 3 == 0
    result = optimize(surfels, image, camera, frame, steps=3, kept=kept)
    for name in ("quats", "scales", "opacities"):
        moved = np.abs(getattr(result, name) - getattr(surfels, name)).reshape(len(surfels), -1).max(1)
        assert moved[kept].max() < 1e-3  # measured 1e-6: through the logarithm and back
        assert moved[~kept].mean() > 1e-3


def test_what_is_hidden_is_drawn_once_and_behind(level):
    image, camera, frame, surfels = level
    hidden = generate_surfels(np.ones_like(image), np.full(image.shape[:2], 200, np.float32), camera)
    apart = optimize(surfels, image, camera, frame, steps=6, hidden=hidden)
    kept = np.arange(len(surfels) + len(hidden)) >= len(surfels)
    together = Surfels.concatenate([surfels, hidden])
    whole = optimize(together, image, camera, frame, steps=6, kept=kept).take(~kept)
    alone = optimize(surfels, image, camera, frame, steps=6)
    near, far = (np.abs(s.opacities - apart.opacities).mean() for s in (whole, alone))
    assert near < 0.2 * far  # measured 0.0011 and 0.0278
