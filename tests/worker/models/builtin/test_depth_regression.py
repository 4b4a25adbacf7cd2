import numpy as np

from wzviewer.worker.models.builtin.depth.regression import borrow, fixed_effects, robust_line


def analytic(seed=0, h=90, w=136):
    """Wall, ground and spheres: estimate, truth = 3 e + 0.7 + offset[segment], labels."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:h, :w].astype(np.float32) / w
    e = np.maximum(0.1, 1.5 * (y - 0.2)).astype(np.float32)
    labels = (e > 0.1).astype(np.int32)
    for k in range(4):
        cx, cy, r = rng.uniform(0.1, 0.9), rng.uniform(0.1, 0.6), rng.uniform(0.06, 0.13)
        ball = np.hypot(x - cx, y - cy) < r
        bump = np.sqrt(np.maximum(r * r - (x - cx) ** 2 - (y - cy) ** 2, 0))
        e, labels = np.where(ball, 0.5 + k * 0.2 + bump, e).astype(np.float32), np.where(ball, 2 + k, labels)
    offsets = rng.uniform(-0.2, 0.2, 6)
    return e, (3 * e + 0.7 + offsets[labels]).astype(np.float32), labels.astype(np.int32)


def test_slope_and_offsets_are_recovered_exactly():
    e, truth, labels = analytic()
    fit = fixed_effects(e, truth, labels, np.ones(e.shape, bool))
    assert abs(fit.slope / 3 - 1) < 1e-3  # contract 1e-3; measured: 1e-8
    assert np.abs(fit.predict(e, labels) - truth).max() < 1e-3  # measured: 3e-7
    assert abs(fit.global_slope / 3 - 1) > 1e-3  # the plain line is biased: why this exists


def test_noise_and_gross_outliers_hardly_move_it():
    e, truth, labels = analytic()
    rng = np.random.default_rng(1)
    noisy = truth + rng.normal(0, 0.015, truth.shape).astype(np.float32)
    wild = rng.random(truth.shape) < 0.08
    noisy[wild] += rng.normal(0, 3, int(wild.sum()))
    fit = fixed_effects(e, noisy, labels, rng.random(truth.shape) < 0.65)
    error = np.abs(fit.predict(e, labels) - truth)
    assert np.median(error) < 3e-3  # measured: 7e-4, of a range of 4


def test_hidden_segments_borrow_from_their_neighbours():
    labels = np.repeat(np.arange(4, dtype=np.int32), 10)[None].repeat(5, 0)
    got = borrow(np.array([1.0, np.nan, np.nan, 5.0]), labels, 0.0)
    assert got.tolist() == [1.0, 1.0, 5.0, 5.0]
    assert borrow(np.array([np.nan, np.nan]), labels // 2, 7.0).tolist() == [7.0, 7.0]


def test_an_upside_down_estimate_is_not_used():
    e, truth, labels = analytic()
    fit = fixed_effects(-e, truth, labels, np.ones(e.shape, bool))
    assert fit.slope == 0


def test_nothing_visible_is_nothing():
    e, truth, labels = analytic()
    fit = fixed_effects(e, truth, labels, np.zeros(e.shape, bool))
    assert fit.slope == 0
    assert not fit.offsets.any()


def test_robust_line_on_constant_input_has_no_slope():
    slope, offset = robust_line(np.full(50, 2.0), np.linspace(0, 1, 50))
    assert slope == 0
    assert abs(offset - 0.5) < 0.05
