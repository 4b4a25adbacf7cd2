"""The parts of the detail synthesis: sharpening, consistency, amplitude, tiles and grain."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.detail.amplitude import (
    drawn_not_lettered,
    glossy,
    hems,
    in_focus,
    lawful_sigma,
    light_gain,
    regional_sigma,
    shade_ceiling,
    tone_damping,
    woods,
)
from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.consistency import (
    brought_near,
    consistency_db,
    projected,
    psnr_db,
)
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.flow import CALM_VOTES, GRAINS, grain_texture, voted_direction
from wzviewer.worker.models.builtin.detail.library import TILE_PX, TileLibrary
from wzviewer.worker.models.builtin.detail.measures import area_down, dense_rms, local_rms, over_rows
from wzviewer.worker.models.builtin.detail.noise import cellular, fractal
from wzviewer.worker.models.builtin.detail.overlay import film_grain, grain_rms, multiplied
from wzviewer.worker.models.builtin.detail.seams import without_leaves_on_grass
from wzviewer.worker.models.builtin.detail.texture import layout, tile_texture
from wzviewer.worker.models.builtin.detail.tiles import TILE_MAKERS


def photo_like(rows=24, columns=36, seed=0):
    rng = np.random.default_rng(seed)
    coarse = cv2.resize(rng.uniform(30, 220, (6, 9, 3)).astype(np.float32), (columns, rows))
    return np.clip(coarse + rng.normal(0, 6, (rows, columns, 1)), 0, 255).astype(np.float32)


@pytest.mark.parametrize("factor", [2, 4, 8])
def test_projection_reaches_the_observation_from_anywhere(factor):
    rng = np.random.default_rng(0)
    observation = (rng.random((9, 13, 3)) > 0.5).astype(np.float32) * 255
    start = rng.uniform(0, 255, (9 * factor, 13 * factor, 3)).astype(np.float32)
    result = projected(start, observation)
    assert consistency_db(result, observation) >= 40.1
    assert result.min() >= 0
    assert result.max() <= 255


def test_projection_leaves_a_consistent_picture_alone():
    image = np.repeat(np.repeat(photo_like(), 4, 0), 4, 1)
    assert np.array_equal(projected(image, area_down(image, 36, 24)), image)


def test_psnr_of_a_known_error():
    assert psnr_db(np.zeros(4, np.float32), np.full(4, 25.5, np.float32)) == pytest.approx(20)


def test_dense_rms_is_the_rms_of_noise_and_far_below_it_for_a_lone_line():
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 5, (128, 128)).astype(np.float32)
    assert dense_rms(noise, 6.0)[32:96, 32:96].mean() == pytest.approx(5, rel=0.06)  # measured 4.9
    line = np.zeros((128, 128), np.float32)
    line[:, 64] = 80
    ratio = dense_rms(line, 6.0)[64, 64] / local_rms(line, 6.0)[64, 64]
    assert ratio < 0.4  # measured 0.3


def test_the_law_gives_texture_to_texture_and_none_to_flatness_or_letters():
    rng = np.random.default_rng(0)
    rough = rng.normal(128, 12, (64, 96)).astype(np.float32)
    flat = np.full((64, 96), 128, np.float32)
    letters = flat.copy()
    letters[20:44, 48:51] = 10
    assert lawful_sigma(rough).mean() > 5
    assert lawful_sigma(flat).max() < 0.5
    assert lawful_sigma(letters).max() < 0.8  # measured 0.52: one stroke, however strong, is no texture


def test_a_page_of_letters_is_told_from_texture():
    rng = np.random.default_rng(0)
    rough = cv2.GaussianBlur(rng.normal(128, 30, (90, 136)).astype(np.float32), (0, 0), 0.5)
    page = np.full((360, 544), 230, np.uint8)
    for row in range(30, 360, 34):
        cv2.putText(
            page, "letters on a page of text", (4, row), cv2.FONT_HERSHEY_SIMPLEX, 1.1, 20, 3, cv2.LINE_AA
        )
    page = cv2.resize(page.astype(np.float32), (136, 90), interpolation=cv2.INTER_AREA)
    assert drawn_not_lettered(rough).mean() > 0.9
    assert drawn_not_lettered(page).mean() < 0.2
    assert lawful_sigma(page).mean() < 0.2 * lawful_sigma(rough).mean()


def test_glitter_is_told_from_hair_and_from_light_ground():
    rng = np.random.default_rng(2)
    specks = np.zeros((64, 96), np.float32)
    specks[rng.integers(2, 62, 90), rng.integers(2, 94, 90)] = 1
    hair = np.zeros_like(specks)
    for y in range(3, 64, 5):
        cv2.line(hair, (0, y), (95, y + 8), 1.0, 1, cv2.LINE_AA)
    dark, light = np.float32(25), np.float32(120)
    specks, hair = (100 * cv2.GaussianBlur(plane, (0, 0), 0.7) for plane in (specks * 3, hair))
    assert glossy(dark + specks).mean() > 0.8  # measured 1.0
    assert glossy(dark + hair).mean() < 0.2  # measured 0.0
    assert glossy(light + specks).max() == 0


def test_leaves_from_afar_are_a_wood_and_leaves_with_contours_are_not():
    afar = Region(0.3, 25, -8, 9, 7.5, 7.0, 8.1, 0.37, 0.75, 0.0)
    near = Region(0.3, 33, -7, 31, 8.6, 12.4, 17.2, 0.44, 0.68, 0.0)
    names = ("foliage", "foliage", "rock")
    assert woods((afar, near, afar), names).tolist() == [True, False, False]
    wood, leaf, stone = regional_sigma((afar, near, afar), names)
    assert wood == pytest.approx(stone * 1.0 / 0.7)
    assert leaf < wood


def blob(blur_px):
    disc = np.full((90, 136), 60, np.float32)
    cv2.circle(disc, (40, 45), 25, 180, -1, cv2.LINE_AA)
    return cv2.GaussianBlur(disc, (0, 0), blur_px)


def test_what_lies_in_a_sharp_contour_is_in_focus():
    sharp, soft = in_focus(blob(0.4)), in_focus(blob(3.0))
    assert sharp[45, 40] > 0.8  # its middle, 25 px from the contour; measured 0.89
    assert sharp[45, 130] < 0.1  # far from it
    assert soft.max() < 0.1  # measured 0.0
    noise = np.random.default_rng(2).normal(0, 0.5, (90, 136)).astype(np.float32)
    assert in_focus(100 + noise).max() < 0.1  # a camera's noise is no contour


def test_a_narrow_band_of_two_tones_is_a_hem_and_a_wood_is_none():
    rng = np.random.default_rng(3)
    plane = np.full((90, 136), 190, np.float32)
    plane[:, 68:] = 120
    band, wood = np.zeros((2, 90, 136), np.float32)
    band[:, 65:71] = wood[:, 40:] = 1
    assert hems(band, plane)[45, 68] > 0.9  # measured 1.0
    assert hems(wood, plane)[45, 80:].max() < 0.1
    textured = plane + cv2.GaussianBlur(rng.normal(0, 60, plane.shape).astype(np.float32), (0, 0), 0.8)
    assert hems(band, textured)[20:70, 68].mean() < 0.6  # measured 0.45
    assert hems(band, plane)[:, :60].max() == 0


def test_no_leaves_grow_on_blades_of_grass():
    y, x = np.mgrid[0:90, 0:136].astype(np.float32)
    grass = 110 + 40 * np.sin(0.9 * x + 0.2 * y)
    noise = cv2.GaussianBlur(np.random.default_rng(0).standard_normal((90, 136), np.float32), (0, 0), 1.5)
    crowns = 110 + 40 * noise / noise.std()
    leaves = np.zeros((90, 136), np.uint8)
    for plane, name in ((grass, "venation"), (crowns, "foliage")):
        picture = np.repeat(plane[..., None], 3, 2).astype(np.float32)
        labels, names = without_leaves_on_grass(picture, leaves, ("foliage",))
        assert set(np.array(names)[labels].ravel()) == {name}


def test_leaves_in_the_light_have_more_contrast_than_in_the_gaps():
    plane = np.full((90, 136), 60, np.float32)
    plane[40:50, 40:50] = 120
    plane[40:50, 90:100] = 20
    gain = light_gain(plane)
    assert gain[45, 45] > 1.4  # measured 1.5
    assert gain[45, 95] < 0.35  # measured 0.2: the gap is as calm as the photograph has it
    assert gain[10, 10] == pytest.approx(1, abs=0.02)


def test_a_noisy_sky_shows_its_own_noise_and_leaves_that_of_the_calmest_place():
    sky = Region(0.5, 70, 0, -20, 1, 1, 1, 0.5, 0.2, 0.9, calm=0.8)
    leaf = Region(0.3, 40, 0, 0, 9, 9, 9, 0.5, 0.7, 0, calm=5)
    wall = Region(0.2, 70, 0, 0, 0.5, 0.5, 0.5, 0.5, 0.5, 0, calm=0.4)
    context = Context(np.zeros((720, 1088), np.uint8), ("sky", "foliage", "smooth"), (sky, leaf, wall), "")
    assert grain_rms(context).tolist() == pytest.approx([1.2, 0.8, 0.8])  # the rest of it are clouds
    small = replace(context, labels=np.zeros((180, 272), np.uint8))
    assert grain_rms(small).tolist() == pytest.approx([2.4, 1.6, 1.6])  # shrunk, its noise is half gone


def test_grain_is_fine_with_clumps_and_less_in_the_lights():
    grain = film_grain(np.full((200, 200), 100, np.float32), (1, 2))
    assert grain.std() == pytest.approx(1, abs=1e-3)
    alike = [np.corrcoef(grain[:, k:].ravel(), grain[:, :-k].ravel())[0, 1] for k in (1, 3)]
    assert 0.37 < alike[0] < 0.6  # measured 0.47
    assert 0.1 < alike[1] < 0.3  # measured 0.21
    light = film_grain(np.full((200, 200), 225, np.float32), (1, 2))
    assert light.std() < 0.6  # measured 0.50


def test_deep_shade_is_quiet_and_a_lifted_black_is_black():
    light = np.repeat(np.float32([[30, 36, 62, 95]]), 30, 1).repeat(60, 0)
    quiet = shade_ceiling(light)[30, 15::30]
    assert quiet[0] == pytest.approx(1, abs=0.1)
    assert 2 < quiet[1] < 5  # measured 3.3
    assert quiet[2] > 20  # measured 24.0
    np.testing.assert_allclose(shade_ceiling(light - 30)[30, 15::30], quiet, rtol=1e-4)
    assert shade_ceiling(np.full((60, 60), 180, np.float32)).min() > 60  # a bright crop holds no black


def test_detail_multiplies_light_and_never_falls_below_black():
    detail = np.float32([-40, -3, 3, 40])
    made = multiplied(detail, np.full(4, 10, np.float32))
    assert made.min() > -10
    assert made[3] == pytest.approx(62.1, abs=0.1)  # the most there may be: 10 (e^2.1 - 1), faded into 244
    bright = multiplied(detail[1:3], np.full(2, 200, np.float32))
    assert np.abs(bright - detail[1:3]).max() < 0.1  # grey levels; measured 0.06
    white = multiplied(np.float32([60, -60]), np.full(2, 245, np.float32))
    assert 0 < white[0] < 10  # nothing is above white; measured 9.0
    assert white[1] < -50


def test_tone_damping_spares_black_and_white():
    damping = tone_damping(np.float32([[0, 60, 128, 255]]))
    assert damping[0].tolist() == pytest.approx([0.25, 1, 1, 0.2])


@pytest.mark.parametrize("name", sorted(TILE_MAKERS))
def test_tiles_are_normalized_and_seamless(name):
    tile = TILE_MAKERS[name](192, np.random.default_rng(0))
    assert tile.shape == (192, 192)
    assert tile.mean() == pytest.approx(0, abs=1e-3)
    assert tile.std() == pytest.approx(1, abs=1e-3)
    seam = np.abs(tile[:, 0] - tile[:, -1]).mean() + np.abs(tile[0] - tile[-1]).mean()
    steps = [np.abs(np.diff(tile, axis=axis)).mean(1 - axis) for axis in (0, 1)]
    inside = sum(np.percentile(step, 90) for step in steps)  # the median of sparse tiles is nothing
    assert seam < 1.3 * inside  # 0.5 to 1.1; cut off at 150 px 1.3 to 5.8, plaster alone 1.15


def test_cellular_matches_brute_force():
    first, second, index = cellular(48, 4, np.random.default_rng(5))
    points = np.random.default_rng(5).uniform(0.08, 0.92, (4, 4, 2)).astype(np.float32)
    centres = (points + np.stack(np.meshgrid(range(4), range(4)), 2)) * 12
    y, x = np.mgrid[0:48, 0:48]
    gap = np.abs(np.stack([x, y], 2)[:, :, None] - centres.reshape(1, 1, 16, 2))
    distance = np.sort(np.hypot(*np.moveaxis(np.minimum(gap, 48 - gap), 3, 0)), 2)
    assert np.abs(first - distance[..., 0]).max() < 1e-3
    assert (
        np.abs(second - distance[..., 1]) > 1e-3
    ).mean() < 0.02  # 3x3 cells miss a far second now and then
    assert index.max() == 15


def test_fractal_noise_has_the_slope_it_was_asked_for():
    field = fractal(256, 1.5, np.random.default_rng(0))
    power = np.abs(np.fft.rfft2(field)) ** 2
    radius = np.hypot(np.fft.fftfreq(256, 1 / 256)[:, None], np.fft.rfftfreq(256, 1 / 256)[None])
    bands = [power[(radius > r) & (radius < 1.3 * r)].mean() for r in (10, 40)]
    assert np.log(bands[1] / bands[0]) / np.log(4) == pytest.approx(-3, abs=0.3)


def test_strands_follow_the_picture():
    y, x = np.mgrid[0:40, 0:60].astype(np.float32)
    stripes = 128 + 40 * np.sin((x - y) * 0.9)  # lines of equal value run along (1, 1)
    direction = voted_direction(stripes, 480, 320)
    assert np.abs(direction[0] - direction[1])[10:-10, 10:-10].max() < 0.1
    mask = np.ones((320, 480), bool)
    strands = grain_texture(GRAINS["fibre"], direction, mask, np.random.default_rng(0))[40:-40, 40:-40]
    along = np.mean((strands[6:, 6:] - strands[:-6, :-6]) ** 2)
    across = np.mean((strands[6:, :-6] - strands[:-6, 6:]) ** 2)
    assert across > 1.5 * along  # measured 2.6


def test_beyond_the_photograph_strands_do_not_turn_about_every_blur():
    y, x = np.mgrid[0:90, 0:136].astype(np.float32)
    blurs = cv2.GaussianBlur(np.random.default_rng(0).normal(size=y.shape).astype(np.float32), (0, 0), 7)
    seen = 128 + 120 * blurs + 2 * np.sin((x + 0.5 * y) * 0.5)
    direction = voted_direction(seen, 544, 360, CALM_VOTES)
    turns = np.exp(2j * np.arctan2(direction[1], direction[0]))
    assert np.abs(turns.mean()) > 0.96  # measured .987; .892 if every blur votes


def test_strands_do_not_depend_on_the_number_of_threads(monkeypatch):
    direction = voted_direction(photo_like()[..., 0], 288, 256)
    mask = np.ones((256, 288), bool)
    results = []
    for cores in (1, 3):
        monkeypatch.setattr("os.cpu_count", lambda cores=cores: cores)
        results.append(grain_texture(GRAINS["fur"], direction, mask, np.random.default_rng(0)))
    assert np.array_equal(results[0], results[1])


def test_over_rows_covers_every_row_once(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 4)
    seen = np.zeros(1001, int)
    over_rows(lambda a, b: np.add.at(seen, np.arange(a, b), 1), 1001)
    assert (seen == 1).all()


def test_the_layout_follows_the_contour_not_the_coarse_grid():
    guide = np.full((160, 240, 3), 40, np.float32)
    guide[:, 117:] = 210  # off the grid of 8 px
    labels = np.zeros((20, 30), np.uint8)
    labels[:, 15:] = 3
    place = layout(labels, guide)
    assert set(np.unique(place.labels)) == {0, 3}
    border = np.argmax(place.labels[80] == 3)
    assert abs(int(border) - 117) <= 4  # the coarse labels alone say 120
    assert np.abs(sum(place.shares.values()) - 1).max() < 1e-5


def test_tiles_are_kept_and_a_broken_file_is_made_again(tmp_path):
    made = TileLibrary(tmp_path).tile("weave")
    assert made.shape == (TILE_PX, TILE_PX)
    (file,) = tmp_path.iterdir()
    assert np.array_equal(TileLibrary(tmp_path).tile("weave"), made)
    file.write_bytes(b"broken")
    assert np.array_equal(TileLibrary(tmp_path).tile("weave"), made)


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    assert TileLibrary(blocked / "tiles").tile("scales").dtype == np.int8


def test_a_preview_samples_the_same_texture():
    wave = 90 * np.sin(np.arange(TILE_PX) * 2 * np.pi / 64)
    tile = np.tile(wave.astype(np.int8), (TILE_PX, 1))
    full = tile_texture(tile, "plaster", 96, 64, np.random.default_rng(2))
    half = tile_texture(tile, "plaster", 48, 32, np.random.default_rng(2), stride=2)
    assert np.abs(full[::2, ::2] - half).mean() < 0.05


def test_what_is_near_enough_stays_and_the_rest_comes_no_nearer_than_it_must():
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.uniform(0, 255, (96, 96, 3)).astype(np.float32), (0, 0), 2.0)
    noisy = area_down(image, 12, 12) + rng.normal(0, 4, (12, 12, 3)).astype(np.float32)
    assert consistency_db(image, noisy) < 37  # measured 36.3
    made = brought_near(image, noisy, 40.0)
    assert 40 <= consistency_db(made, noisy) < 40.8  # measured 40.1
    assert brought_near(image, noisy, 30.0) is image
