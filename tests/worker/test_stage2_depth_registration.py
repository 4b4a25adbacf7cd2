import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.depth.layers import step_mask
from wzviewer.worker.stages.stage2_depth_registration import register

H, W, FOCAL = 360, 544, 8192.0


def scene(seed=0):
    """A slope with three coloured balls: image, parallax (px), segments."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:H, :W].astype(np.float32)
    parallax = (0.35 * (y - H / 2)).astype(np.float32)
    labels = np.zeros((H, W), np.int32)
    for k, (cx, cy, r) in enumerate([(150, 130, 60), (330, 200, 80), (430, 90, 45)]):
        d2 = (x - cx) ** 2 + (y - cy) ** 2
        ball = d2 < r * r
        parallax = np.where(ball, 15 + 20 * k + 0.4 * np.sqrt(np.maximum(r * r - d2, 0)), parallax)
        labels = np.where(ball, k + 1, labels)
    colors = np.float32([[0.3, 0.4, 0.2], [0.8, 0.3, 0.2], [0.2, 0.3, 0.8], [0.9, 0.8, 0.3]])
    image = colors[labels] * (1 + 0.06 * rng.normal(size=(H, W, 1)))
    return np.clip(image, 0, 1).astype(np.float32), parallax.astype(np.float32), labels.astype(np.int32)


def estimate_of(parallax, labels, slope=90.0):
    """An estimate from which the parallax follows with one slope and an offset per segment."""
    return ((parallax - np.float32([0, 12, -9, 5])[labels] - 3) / slope).astype(np.float32)


def borders(v):
    return np.concatenate([v[0], v[-1], v[:, 0], v[:, -1]])


def two_layers(step_px):
    """A blue disc of parallax 20 + slope before a ground `step_px` behind it."""
    y, x = np.mgrid[:H, :W].astype(np.float32)
    near = np.hypot(x - 270, y - 180) < 90
    truth = np.where(near, 20 + 0.02 * x, -np.float32(step_px) + 0.02 * x).astype(np.float32)
    image = np.where(near[..., None], np.float32([0.2, 0.3, 0.8]), np.float32([0.7, 0.6, 0.3]))
    noise = np.random.default_rng(0).normal(0, 0.02, (H, W, 1))
    return (image + noise).clip(0, 1).astype(np.float32), truth, near


def test_truth_is_recovered_where_seen_and_where_hidden():
    image, truth, labels = scene()
    target = truth.copy()
    target[150:250, 300:360] = np.nan  # inside one ball
    target[300:, :200] = np.nan  # slope
    got = register(image, target, estimate_of(truth, labels), focal_px=FOCAL, segments=labels, relief_share=0)
    hidden = ~np.isfinite(target)
    assert abs(got.report["a"] / 90 - 1) < 1e-3  # contract 1e-3; measured: 1e-7
    error = np.abs(got.parallax - truth)
    assert np.median(error[hidden]) < 0.1  # px of a range of 180; measured: 0.02
    assert np.median(error[~hidden]) < 0.1  # measured: 0.01
    assert got.report["loss_fixed_effects"] < 0.02 < got.report["loss_before"]  # measured: 0.003, 3.1
    assert got.report["grid_accepted"] == 0  # nothing left to win


def test_grid_wins_on_a_smooth_warp_and_the_loss_of_eq_5_falls():
    image, truth, labels = scene()
    y, x = np.mgrid[:H, :W].astype(np.float32)
    target = (truth + 25 * np.sin(x / 120) * np.cos(y / 90)).astype(np.float32)
    losses = []
    got = register(
        image, target, estimate_of(truth, labels), focal_px=FOCAL, segments=labels, relief_share=0,
        on_step=lambda k, loss: losses.append(loss),
    )  # fmt: skip
    assert got.report["grid_accepted"] == 1
    assert got.report["grid_error_ratio"] < 0.5  # measured: 0.1
    assert len(losses) == 51
    assert min(losses) < 0.5 * losses[0]
    assert got.report["loss_after"] < 0.2 * got.report["loss_before"]


def test_grid_is_rejected_on_noise():
    image, truth, labels = scene()
    noisy = truth + np.random.default_rng(2).normal(0, 1.0, truth.shape).astype(np.float32)
    got = register(image, noisy, estimate_of(truth, labels), focal_px=FOCAL, segments=labels, relief_share=0)
    assert got.report["grid_accepted"] == 0


def test_child_meets_its_parent_at_the_border_and_in_the_low_band():
    image, _truth, _ = scene()
    rng = np.random.default_rng(0)
    useless = cv2.resize(rng.random((12, 18)).astype(np.float32), (W, H), interpolation=cv2.INTER_CUBIC)
    slope = np.repeat((0.35 * (np.arange(H, dtype=np.float32) - H / 2))[:, None], W, 1)
    got = register(image, slope, useless, focal_px=FOCAL)
    assert np.abs(borders(got.parallax - slope)).max() < 0.01  # native px; measured: 4e-5
    low = cv2.GaussianBlur(got.parallax - slope, (0, 0), W / 8)
    assert np.abs(low).max() < 2.0  # px of 544, 0.02 % of the focal length; measured: 0.7


@pytest.mark.parametrize("step_px", [400.0, 1e3, 1e6, 1e9])
def test_a_step_snaps_to_the_new_image_and_stays_two_plateaus(step_px):
    image, truth, near = two_layers(step_px)
    coarse = truth[4::8, 4::8]
    target = cv2.resize(coarse, (W, H), interpolation=cv2.INTER_NEAREST)
    estimate = cv2.GaussianBlur(near.astype(np.float32), (0, 0), 6)
    got = register(image, target, estimate, focal_px=1e12, relief_share=0).parallax
    assert np.isfinite(got).all()
    between = (got < -0.1 * step_px) & (got > -0.9 * step_px)
    assert between.mean() < 2e-4  # measured: 0: no tent
    wrong_before, wrong = ((v > -0.5 * step_px) != near for v in (target, got))
    assert wrong.sum() < 0.35 * wrong_before.sum()  # the outline is the new image's; measured: 0.1


def test_no_shreds_are_left_beside_a_large_step():
    image, truth, _ = two_layers(200_000.0)
    coarse = cv2.resize(truth, (W // 8, H // 8), interpolation=cv2.INTER_NEAREST)
    target = cv2.resize(coarse, (W, H), interpolation=cv2.INTER_LINEAR)
    got = register(image, target, np.zeros_like(truth), focal_px=400_000.0, relief_share=0).parallax
    y, x = np.mgrid[:H, :W]
    beside = np.hypot(x - 270, y - 180) > 96
    assert np.abs(got - truth)[beside].max() < 60  # px; measured: 21, and 199000 with a blur over the step


def test_a_grazing_slope_is_no_step():
    slope = np.repeat((10 * np.arange(180, dtype=np.float32))[:, None] * 4, 272, 1)
    assert not step_mask(slope, 4.0, FOCAL).any()
    slope[90:] += 4000
    assert step_mask(slope, 4.0, FOCAL)[88:92].all()


def test_a_flat_target_stays_flat_whatever_the_estimate_says():
    image, _, labels = scene()
    noise = np.random.default_rng(0).random((H, W)).astype(np.float32)
    target = np.full((H, W), 3.0, np.float32)
    got = register(image, target, noise, focal_px=1e8, segments=labels, relief_share=0)
    assert np.abs(got.parallax - 3).max() < 1e-3
    lifted = register(image, target, noise, focal_px=1e8, segments=labels)
    assert lifted.report["relief_px"] > 1
    assert np.abs(borders(lifted.parallax - 3)).max() < 1e-3


def test_nothing_known_is_still_finite():
    image, _, _ = scene()
    nothing = np.full((H, W), np.nan, np.float32)
    got = register(image, nothing, np.zeros((H, W), np.float32), focal_px=FOCAL)
    assert np.isfinite(got.parallax).all()
    assert got.report["hidden_share"] == 1


def test_it_is_deterministic_and_can_be_cancelled():
    image, truth, labels = scene()
    estimate = estimate_of(truth, labels)
    first, second = (register(image, truth, estimate, focal_px=FOCAL) for _ in range(2))
    assert np.array_equal(first.parallax, second.parallax)

    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        register(image, truth, estimate, focal_px=FOCAL, check=stop)
