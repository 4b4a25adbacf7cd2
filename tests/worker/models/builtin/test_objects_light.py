"""Light read from a picture, planes fitted to a support."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.composite import Harmony, shadow_gain
from wzviewer.worker.models.builtin.objects.lighting import (
    Light,
    light_from_photo,
    linear_from_srgb,
    srgb_from_linear,
)
from wzviewer.worker.models.builtin.objects.placement import Support, fit_plane


def ramp(sign):
    x = np.linspace(0.15, 0.85, 160, dtype=np.float32)[::sign]
    return np.repeat(np.repeat(x[None, :, None], 106, 0), 3, 2)


def test_srgb_round_trip():
    x = np.linspace(0, 1, 256, dtype=np.float32)
    assert np.abs(srgb_from_linear(linear_from_srgb(x)) - x).max() < 1e-5


@pytest.mark.parametrize("sign", [1, -1])
def test_light_comes_from_the_bright_side_from_above_and_the_viewers_side(sign):
    x, y, z = light_from_photo(ramp(sign), (80, 53), 20).direction
    assert np.sign(x) == sign
    assert y < 0
    assert z < 0


def test_bright_pictures_expose_more_and_colours_have_mean_one():
    dark, bright = (light_from_photo(np.full((60, 90, 3), v, np.float32), (45, 30), 20) for v in (0.25, 0.85))
    assert dark.exposure < bright.exposure
    warm = np.full((60, 90, 3), 0.5, np.float32) * np.array([1.6, 1.0, 0.5], np.float32)
    light = light_from_photo(warm, (45, 30), 20)
    assert light.key.mean() == pytest.approx(1)
    assert light.key[0] > light.key[2]


def test_light_is_raised_above_its_support():
    light = light_from_photo(ramp(1), (80, 53), 20)
    normal = np.array([-0.8, 0.0, -0.6])
    assert light.above(normal) @ normal >= 0.3
    assert np.linalg.norm(light.above(normal)) == pytest.approx(1)


def test_light_survives_its_record():
    light = light_from_photo(ramp(1), (80, 53), 20)
    assert Light.from_dict(light.to_dict()).to_dict() == light.to_dict()


def test_plane_fit_ignores_what_does_not_belong_to_the_surface():
    v, u = np.mgrid[:106, :160].astype(np.float64)
    relief = 0.3 * (u + 0.5) - 0.8 * (v + 0.5) + np.random.default_rng(0).normal(0, 0.05, u.shape)
    relief[:, 100:] += 4000  # the sky behind
    relief[20:30, 20:30] = np.nan
    plane = fit_plane(Support(relief.astype(np.float32), 1024.0), 80, 53, 32)
    assert plane.slope_x == pytest.approx(0.3, abs=0.02)
    assert plane.slope_y == pytest.approx(-0.8, abs=0.02)
    assert plane.at == pytest.approx(0.3 * 80 - 0.8 * 53, abs=0.2)


def test_plane_normal_faces_the_camera_and_is_orthogonal_to_the_surface():
    plane = fit_plane(Support(np.zeros((50, 50), np.float32), 1024.0), 25, 25, 20)
    assert plane.normal((0.0, 0.0)) == pytest.approx([0, 0, -1])
    steep = type(plane)(0, 0, 0, 0.5, -1.0)
    ray = (0.2, -0.1)
    along_x = np.array([1 + 0.5 * ray[0], 0.5 * ray[1], 0.5])
    assert steep.normal(ray) @ along_x == pytest.approx(0, abs=1e-12)
    assert steep.normal(ray) @ np.array([*ray, 1.0]) < 0


def vivid(chroma, gray=0.2, shape=(32, 48)):
    """A picture of one colour with this chroma."""
    image = np.full((*shape, 3), gray, np.float32)
    image[..., 0] += chroma
    return image


def test_a_body_in_a_dull_picture_is_muted_and_keeps_its_luma():
    """A robin in the dusk looked pasted: nothing around it was a fifth as vivid."""
    body, alpha = vivid(0.5), np.ones((32, 48), np.float32)
    dull, garden, paper = (Harmony.of(body, alpha, vivid(*c)) for c in ((0.05,), (0.5,), (0.05, 0.8)))
    assert dull.chroma == pytest.approx(0.6, abs=0.01)  # half of what is beyond its .05 and .05 more
    assert garden.chroma == 1.0
    assert paper.chroma == 1.0  # bright
    gray = np.full((1, 3), 0.3, np.float32)
    muted = Harmony(chroma=0.5)
    assert muted(gray) == pytest.approx(gray, abs=1e-6)
    red = muted(np.array([[0.8, 0.2, 0.2]], np.float32))[0]
    assert np.ptp(red) == pytest.approx(0.3, abs=1e-6)
    assert red @ (0.2126, 0.7152, 0.0722) == pytest.approx(0.32756, abs=1e-5)


def test_a_light_is_never_straight_behind_the_viewer():
    """Then a body's shadow is all under it."""
    image = np.full((90, 136, 3), 0.4, np.float32)
    direction = light_from_photo(image, (68, 45), 20.0).direction
    assert abs(direction[0]) > 0.45  # measured 0.46; 0.26 before


def test_a_shadow_ends_before_the_border_where_the_parent_lacks_it():
    dark = np.zeros((72, 108, 2), np.float32)
    gain = shadow_gain(dark, light_from_photo(ramp(1), (80, 53), 20), np.zeros((72, 108), np.float32))
    assert (gain[[0, -1]] == 1).all()
    assert (gain[:, [0, -1]] == 1).all()
    assert np.abs(np.diff(gain, axis=0)).max() < 0.12  # measured 0.105: no line
    assert gain[36, 54] < 0.05
