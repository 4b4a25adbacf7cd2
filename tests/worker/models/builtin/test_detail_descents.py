"""Descents of eight levels: each is another picture, none fades, none drifts, nothing repeats."""

import itertools

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.consistency import consistency_db
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.library import TileLibrary
from wzviewer.worker.models.builtin.detail.materials import MATERIALS, closer
from wzviewer.worker.models.builtin.detail.noise import periodic_blur
from wzviewer.worker.models.builtin.detail.octaves import BREATH, FORMS, evened
from wzviewer.worker.models.builtin.detail.overlay import with_detail
from wzviewer.worker.models.builtin.detail.seams import (
    bare,
    dark_lines,
    faded_border,
    most_in_light,
    unevenness,
    whole_forms,
    with_seams,
)
from wzviewer.worker.models.builtin.detail.synthesizer import DetailSynthesizer
from wzviewer.worker.models.builtin.detail.texture import coarse_forms, layout, shrunk, tile_texture
from wzviewer.worker.models.builtin.detail.tint import tinted

COLUMNS, ROWS = 34, 23
WIDTH, HEIGHT = 8 * COLUMNS, 8 * ROWS
COLOURS = {
    "venation": (0.36, 0.48, 0.2),
    "plaster": (0.75, 0.7, 0.6),
    "skin": (0.62, 0.42, 0.31),
    "sky": (0.45, 0.6, 0.85),
}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return TileLibrary(tmp_path_factory.mktemp("tiles"))


def calm(name):
    """A picture of one colour with a little of its own unrest, and what is known of it."""
    unrest = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 0.1, (ROWS, COLUMNS, 1)), (0, 0), 1.0)
    image = np.float32(COLOURS[name]) * (1 + unrest[..., None]).astype(np.float32)
    region = Region(1.0, 60, 0, 20, 1.5, 2.0, 2.5, 0.3, 0.5, 0.0)
    return image, Context(np.zeros((ROWS, COLUMNS), np.uint8), (name,), (region,), name)


def descent(library, name, seed=7):
    """Eight levels, each into the middle of the one before: observation and detail of each."""
    synthesizer = DetailSynthesizer(seed=1, library=library)
    observation, context = calm(name)
    region = (0.0, 0.0, 1.0, 1.0)
    levels = []
    for level in range(1, 9):
        detail = synthesizer.upscale(observation, WIDTH, HEIGHT, context, region, level, seed)
        levels.append((observation, detail))
        context = synthesizer.describe(detail.image, context, detail)
        y, x = (HEIGHT - ROWS) // 2, (WIDTH - COLUMNS) // 2
        observation = np.ascontiguousarray(detail.image[y : y + ROWS, x : x + COLUMNS])
        region = (x / WIDTH, y / HEIGHT, (x + COLUMNS) / WIDTH, (y + ROWS) / HEIGHT)
    return levels


def chromaticity(image):
    mean = image.mean((0, 1))
    return mean / mean.sum()


def fine_rms(image):
    grey = 255 * image.mean(2)
    return float((grey - cv2.GaussianBlur(grey, (0, 0), 3.0)).std())


@pytest.mark.parametrize("name", sorted(COLOURS))
def test_eight_levels_keep_colour_and_contrast(library, name):
    levels = descent(library, name)
    first = chromaticity(levels[0][0])
    for observation, detail in levels:
        assert consistency_db(detail.image, observation, 1.0) >= 40  # measured 42.2 and more
        assert (
            np.abs(detail.image.mean((0, 1)) - observation.mean((0, 1))).max() < 0.01
        )  # measured .0083: blue is cut off at white
        assert np.abs(chromaticity(detail.image) - first).max() < 0.06  # measured 0.028, chance for the most
    contrast = [fine_rms(detail.image) / (255 * detail.image.mean()) for _, detail in levels]
    assert min(contrast[3:]) > 0.02  # measured 0.024 to 0.16; .01 is mush
    assert max(contrast) < 0.24  # measured 0.164; more is noise


@pytest.mark.parametrize(
    "name", ["venation", "plaster", "skin", "sky", "ripple", "fur", "weave", "smooth", "petal"]
)
def test_eight_levels_are_eight_materials(name):
    seen = [name]
    while len(seen) < 8:
        seen.append(closer(seen[-1:])[0])
    assert len(set(seen)) == 8


def test_what_fills_a_seam_is_a_material_with_another_name():
    filled = {name: material.between for name, material in MATERIALS.items() if material.between}
    assert filled["granule"] == "fibril"
    assert set(filled.values()) <= set(MATERIALS)
    assert all(name != between for name, between in filled.items())


@pytest.mark.parametrize("name", ["cell", "molecule", "lattice", "orbital"])
def test_a_picture_shows_no_period(library, name):
    texture = tile_texture(library.tile(name), name, 1088, 720, np.random.default_rng(4))
    spectrum = np.fft.rfft2(texture, s=(1440, 2176))
    likeness = np.fft.irfft2(np.abs(spectrum) ** 2)
    likeness /= likeness[0, 0]
    likeness[:40, :40] = likeness[-40:, :40] = likeness[:40, -40:] = likeness[-40:, -40:] = 0
    assert likeness.max() < 0.12  # measured 0.03 to 0.06; 0.29 if the tile lay side by side with itself


def test_a_tile_has_the_octaves_it_was_asked_for():
    grain = np.random.default_rng(0).standard_normal((192, 192)).astype(np.float32)
    grain += periodic_blur(grain, 3.0) * 8
    measured = []
    for octaves in (FORMS, BREATH):
        even = evened(grain, octaves, blur=periodic_blur)
        planes = [even, *(periodic_blur(even, sigma) for sigma in (1.0, 2.0, 5.0))]
        shares = np.array([(a - b).std() for a, b in itertools.pairwise(planes)])
        measured.append(shares / np.linalg.norm(shares))
    assert measured[0] == pytest.approx(FORMS, abs=0.25)  # measured .63, .41, .66: octaves overlap
    assert measured[1][0] < 0.75 * measured[0][0]  # measured .44 and .63
    assert measured[1][2] > 1.15 * measured[0][2]  # measured .81 and .66


def wall_and_rooms():
    grey = np.full((46, 68, 3), 120, np.float32)
    grey[20:23] = 60
    return grey


def test_the_wall_between_cells_is_of_fibrils_and_their_inside_is_not():
    labels, names = with_seams(wall_and_rooms(), np.zeros((46, 68), np.uint8), ("granule",))
    assert names == ("granule", "fibril")
    assert (labels[20:23] == 1).all()
    assert (labels[:14] == 0).all()
    assert (labels[30:] == 0).all()


def test_without_a_wall_or_where_nothing_fills_it_nothing_changes():
    flat = np.full((46, 68, 3), 120, np.float32)
    none = np.zeros((46, 68), np.uint8)
    assert with_seams(flat, none, ("granule",))[1] == ("granule",)
    assert with_seams(wall_and_rooms(), none, ("lattice",))[1] == ("lattice",)
    assert not dark_lines(flat[..., 0]).any()


def test_texture_fades_towards_the_border():
    fade = faded_border(68, 46)
    assert fade.shape == (46, 68)
    assert np.array_equal(fade, fade[::-1, ::-1])
    assert fade[0].max() < 0.2
    assert fade[8:-8, 8:-8].min() == 1  # 17 % of 46 are 7.8
    assert (np.diff(fade[23, :34]) >= 0).all()


def test_texture_is_richer_on_forms_and_varies_from_place_to_place():
    plane = np.full((46, 68), 100, np.float32)
    plane[::6] = 140
    factor = unevenness(plane, (1, 2))
    assert np.array_equal(factor, unevenness(plane, (1, 2)))
    assert factor[::6].mean() > factor[3::6].mean() + 0.2
    assert 0.3 < factor.min() < factor.max() < 2
    assert abs(factor.mean() - 1) < 0.3  # measured 0.02


def test_texture_gathers_on_forms_where_the_picture_has_none():
    flat = np.full((46, 68), 100, np.float32)
    forms = np.tile(np.float32([-1, 1]), (46, 34))
    factor = unevenness(flat, (1, 2), forms)
    assert factor[:, 1::2].mean() > 2.5 * factor[:, ::2].mean()  # measured 2.9
    assert (bare(flat) == 1).all()
    flat[::6] = 140
    assert bare(flat).max() == 0


def test_forms_are_those_of_the_material_only_larger(library):
    place = layout(np.zeros((46, 68), np.uint8), np.zeros((368, 544, 3), np.float32))
    small = shrunk(place, 68, 46)
    seen = np.random.default_rng(2).normal(120, 4, (46, 68, 3)).astype(np.float32)
    cells = coarse_forms(small, ("cell",), seen, library, (1, 2))
    assert cells.shape == (46, 68)
    assert 0.5 < cells.std() < 1.5  # measured 0.9
    assert np.array_equal(cells, coarse_forms(small, ("cell",), seen, library, (1, 2)))
    assert not coarse_forms(small, ("sky",), seen, library, (1, 2)).any()
    assert not coarse_forms(small, ("yarn",), seen, library, (1, 2)).any()
    assert coarse_forms(small, ("fibre",), seen, library, (1, 2)).std() == pytest.approx(1, abs=0.01)


def test_what_the_coarser_picture_missed_is_faint():
    observation = np.full((46, 68, 3), 120, np.float32)
    base = np.full((368, 544, 3), 120, np.float32)
    forms = np.random.default_rng(0).normal(0, 1, (46, 68)).astype(np.float32)
    none = np.zeros((368, 544), np.float32)
    made = with_detail(base, none, observation, 2, forms=forms)
    assert 44 < consistency_db(made, observation) < 50  # measured 48.7
    assert np.array_equal(with_detail(base, none, observation, 2), base)


def test_near_white_there_is_little_contrast_and_a_strong_colour_has_more():
    tones = np.float32([[[128, 128, 128], [220, 220, 220], [250, 250, 250], [250, 120, 60]]])
    grey, light, white, orange = most_in_light(tones)[0].tolist()
    assert grey > 35  # measured 41.0
    assert 10 < light < 16  # measured 13.4
    assert white < 5  # measured 4.4
    assert orange > 15  # measured 18


@pytest.mark.parametrize("colour", [(180, 120, 70), (120, 120, 120), (20, 70, 75)])
def test_colour_varies_without_light_and_around_itself(colour):
    rng = np.random.default_rng(0)
    detail = cv2.GaussianBlur(rng.normal(0, 60, (96, 128)).astype(np.float32), (0, 0), 2.0)
    base = np.tile(np.float32(colour), (96, 128, 1))
    for level in (2, 3):
        added = tinted(base, detail, level)
        light = added @ np.float32([0.299, 0.587, 0.114])
        assert np.abs(light).max() < 5  # grey levels; measured 3.8, of detail up to 30
        assert added.std((0, 1)).max() > 1.5  # grey levels; measured 3.9 to 5.3
        assert np.abs(added.mean((0, 1))).max() < 0.3  # measured .24


def test_sparse_lights_are_paler_and_so_are_sparse_dark_lines():
    spots = np.zeros((64, 64), np.float32)
    spots[8::16, 8::16] = 900
    spots = cv2.GaussianBlur(spots, (0, 0), 2.0)
    spots -= spots.mean()
    base = np.tile(np.float32([180, 120, 70]), (64, 64, 1))
    for detail in (spots, -spots):
        made = base + tinted(base, detail, 2)
        spread = made.max(2) - made.min(2)
        assert spread[8, 8] < spread[0, 0] - 10


@pytest.mark.parametrize("colour", [(190, 110, 50), (70, 130, 40)])
def test_light_leans_to_yellow_and_shade_away_from_it(colour):
    detail = np.tile(np.float32([-20, 20]), (8, 8)).repeat(8, 0).repeat(8, 1)
    base = np.tile(np.float32(colour), (*detail.shape, 1))
    made = base + tinted(base, detail, 2)
    hue = cv2.cvtColor(np.clip(made / 255, 0, 1), cv2.COLOR_RGB2HSV)[..., 0]
    shade, light = abs(hue[4, 4] - 60), abs(hue[4, 12] - 60)
    assert light < shade - 5  # degrees; measured 11 and 16


def test_what_an_eye_surrounds_is_of_the_eye():
    y, x = np.mgrid[0:40, 0:60]
    ring = np.abs(np.hypot(x - 30, y - 20) - 10) < 2
    ring &= ~((y < 20) & (np.abs(x - 30) < 4))  # open above, where the light is
    form = whole_forms(ring)
    assert form[20, 30]
    assert form[12, 30]
    assert not form[5, 30]
    assert not whole_forms(np.zeros((8, 8), bool)).any()
