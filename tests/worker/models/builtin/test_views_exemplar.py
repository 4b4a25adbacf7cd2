"""The exemplar fill: waves, sources, context."""

import numpy as np

from wzviewer.worker.models.builtin.views.exemplar import FillRule, FillTask, fill
from wzviewer.worker.models.builtin.views.exemplar_kernels import plan_centres, plan_waves

SHAPE = (96, 120)


def task(picture: np.ndarray, target: np.ndarray, log_depth: np.ndarray | None = None) -> FillTask:
    depth = np.zeros(SHAPE, np.float32) if log_depth is None else log_depth
    origin = np.stack(np.mgrid[: SHAPE[0], : SHAPE[1]], axis=-1).astype(np.int32)
    flat = np.zeros(SHAPE, np.float32)
    return FillTask(picture, ~target, target, picture, ~target, depth, flat, origin)


def hole() -> np.ndarray:
    target = np.zeros(SHAPE, bool)
    target[36:64, 40:76] = True
    return target


def test_texture_is_continued_not_blurred():
    x = np.arange(SHAPE[1])
    picture = np.repeat((0.5 + 0.4 * np.sign(np.sin(x / 2.0)))[None, :, None], SHAPE[0], 0)
    picture = np.repeat(picture, 3, 2).astype(np.float32)
    broken = np.where(hole()[..., None], np.float32(0.5), picture)
    filled, copied_from = fill(task(np.ascontiguousarray(broken), hole()), FillRule(), 0)
    error = np.abs(filled - picture)[hole()]
    assert error.mean() < 0.12  # measured 0.02; a blur has 0.4
    assert np.array_equal(filled[~hole()], broken[~hole()])
    assert (copied_from[hole()] >= 0).all()
    assert not hole()[tuple(copied_from[hole()].T)].any()  # only real pixels are copied


def test_patches_come_from_the_wanted_depth():
    picture = np.zeros((*SHAPE, 3), np.float32)
    picture[:, :20] = [1, 0, 0]  # near things, the only other colour
    picture[:, 20:] = [0, 0, 1]
    log_depth = np.where(np.arange(SHAPE[1])[None] < 20, 2.0, 0.0).astype(np.float32) + np.zeros(
        SHAPE, np.float32
    )
    filled, _ = fill(task(picture, hole(), log_depth), FillRule(), 3)
    assert filled[hole()][:, 0].max() < 0.1


def test_without_sources_the_surroundings_are_blurred_in():
    picture = np.full((*SHAPE, 3), 0.25, np.float32)
    empty = task(picture, hole())
    nothing = FillTask(**{**empty.__dict__, "usable": np.zeros(SHAPE, bool)})
    filled, copied_from = fill(nothing, FillRule(), 0)
    assert np.allclose(filled, 0.25, atol=1e-5)
    assert (copied_from == -1).all()


def test_every_target_is_covered_and_waves_do_not_overlap():
    radius = 4
    pixels = np.argwhere(hole()).astype(np.int32)
    pixels = pixels[np.random.default_rng(0).permutation(len(pixels))]
    centres = plan_centres(pixels, hole(), radius)
    covered = np.zeros(SHAPE, bool)
    for y, x in centres:
        covered[y - radius : y + radius + 1, x - radius : x + radius + 1] = True
    assert covered[hole()].all()
    order, starts = plan_waves(centres, *SHAPE, radius)
    assert sorted(order) == list(range(len(centres)))
    wave = np.empty(len(centres), int)
    for k in range(len(starts) - 1):
        wave[order[starts[k] : starts[k + 1]]] = k
    for i in range(len(centres)):
        for j in range(i):
            if np.abs(centres[i] - centres[j]).max() <= 2 * radius:
                assert wave[i] > wave[j]  # what overlaps keeps its order


def test_without_anything_known_around_it_a_hole_is_filled_from_the_source():
    rng = np.random.default_rng(0)
    source = rng.random((64, 80, 3), dtype=np.float32)
    nothing, target = np.zeros((64, 80), bool), np.zeros((64, 80), bool)
    target[20:40, 30:50] = True
    flat, origin = np.zeros((64, 80), np.float32), np.zeros((64, 80, 2), np.int32)
    image, _ = fill(FillTask(source, nothing, target, source, ~target, flat, flat, origin), FillRule(), 0)
    assert np.isfinite(image).all()
