import cv2
import numpy as np
import pytest

from wzviewer.commands.bench_naturalness import (
    asymmetric_fit,
    gradient_kl,
    halved,
    naturalness,
    naturalness_of_levels,
    niqe,
    spectrum_slope,
)
from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.core.assets import demo_picture
from wzviewer.core.photos import load_photo

KNOWN_NIQE = 3.807


@pytest.fixture(scope="module")
def meadow() -> np.ndarray:
    return load_photo(demo_picture())[:480, :768].astype(np.float32) / 255


def test_niqe_of_the_demo_picture_is_what_it_was(meadow: np.ndarray) -> None:
    assert niqe(meadow) == pytest.approx(KNOWN_NIQE, abs=0.02)


def test_niqe_rises_with_blur_and_with_noise(meadow: np.ndarray) -> None:
    rng = np.random.default_rng(3)
    noise = rng.normal(0, 1, meadow.shape).astype(np.float32)
    blurs = [niqe(cv2.GaussianBlur(meadow, (0, 0), sigma)) for sigma in (1.0, 2.0, 4.0)]
    noises = [niqe(np.clip(meadow + amount * noise, 0, 1)) for amount in (0.05, 0.1, 0.2)]
    assert niqe(meadow) < blurs[0] < blurs[1] < blurs[2]
    assert niqe(meadow) < noises[0] < noises[1] < noises[2]


def test_a_flat_picture_has_no_niqe_and_a_small_one_is_an_error() -> None:
    assert np.isnan(niqe(np.full((192, 192, 3), 0.5, np.float32)))
    with pytest.raises(ValueError, match="100x100"):
        niqe(np.zeros((100, 100, 3), np.float32))


def test_the_fit_finds_the_distribution_it_was_given() -> None:
    rng = np.random.default_rng(0)
    shape, left, right = asymmetric_fit(rng.standard_normal(200_000))
    assert shape == pytest.approx(2.0, abs=0.03)  # a Gaussian; measured 2.01
    assert left == pytest.approx(np.sqrt(2), abs=0.02)  # its spread parameter is sqrt 2 deviations
    assert right == pytest.approx(np.sqrt(2), abs=0.02)


def test_halving_keeps_a_ramp_a_ramp() -> None:
    ramp = np.tile(np.arange(64.0), (64, 1))
    small = halved(ramp)
    assert small.shape == (32, 32)
    np.testing.assert_allclose(small[:, 4:-4], np.tile(np.arange(32) * 2 + 0.5, (32, 1))[:, 4:-4], atol=1e-9)


def test_slope_of_known_noise() -> None:
    rng = np.random.default_rng(1)
    radius = np.hypot(np.fft.fftfreq(512)[:, None], np.fft.rfftfreq(512)[None])
    radius[0, 0] = 1
    white = np.fft.rfft2(rng.standard_normal((512, 512)))
    plane = np.fft.irfft2(white / radius**1.2)
    image = np.repeat((0.5 + 0.1 * plane / plane.std())[..., None], 3, 2).astype(np.float32)
    assert spectrum_slope(image) == pytest.approx(-2.4, abs=0.1)  # power is amplitude squared; measured -2.39


def test_gradient_divergence_is_zero_for_itself_and_grows_with_blur(meadow: np.ndarray) -> None:
    divergences = [gradient_kl(cv2.GaussianBlur(meadow, (0, 0), s), meadow) for s in (0.7, 1.5, 3.0)]
    assert gradient_kl(meadow, meadow) == pytest.approx(0, abs=1e-12)
    assert 0 < divergences[0] < divergences[1] < divergences[2]


def test_all_numbers_come_by_key(meadow: np.ndarray) -> None:
    assert naturalness(meadow).keys() == {"niqe", "spectrum_slope"}
    assert naturalness(meadow, meadow).keys() == {"niqe", "spectrum_slope", "gradient_kl"}


def test_every_zoom_of_a_scene_is_compared_with_plain_enlargement(meadow: np.ndarray) -> None:
    scene = chain_scene(2, (meadow[:288, :384] * 255).astype(np.uint8))
    found = naturalness_of_levels(scene)
    assert found["niqe_level_1"] == pytest.approx(niqe(scene[1].image.astype(np.float32) / 255))
    assert found["niqe_share_of_bicubic_level_1"] < 0.5  # measured 0.18
    assert found["spectrum_slope_level_1"] > -4  # measured -3.06
