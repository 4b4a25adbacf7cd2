"""The super-resolver and describer as a whole: the promises that a level rests on."""

import math

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.consistency import consistency_db
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.library import TileLibrary
from wzviewer.worker.models.builtin.detail.materials import MATERIALS
from wzviewer.worker.models.builtin.detail.synthesizer import DetailSynthesizer

WHOLE = (0.0, 0.0, 1.0, 1.0)
WIDTH, HEIGHT = 272, 184
COLUMNS, ROWS = WIDTH // 8, HEIGHT // 8


@pytest.fixture(scope="module")
def synthesizer(tmp_path_factory):
    return DetailSynthesizer(seed=1, library=TileLibrary(tmp_path_factory.mktemp("tiles")))


def upscaled(synthesizer, observation, width=WIDTH, height=HEIGHT, level=1, **options):
    context = synthesizer.describe(observation, None)
    return synthesizer.upscale(observation, width, height, context, WHOLE, level, 7, **options)


def meadow(rows=ROWS, columns=COLUMNS):
    """Green, rough and without a direction: every rule says leaves."""
    rng = np.random.default_rng(3)
    tone = cv2.GaussianBlur(rng.normal(0, 0.16, (rows, columns)).astype(np.float32), (0, 0), 0.6)
    return np.clip(np.float32([0.3, 0.46, 0.14]) * (1 + 1.6 * tone[..., None]), 0, 1).astype(np.float32)


def gradient_sky():
    rise = np.linspace(0, 1, ROWS, dtype=np.float32)[:, None, None]
    return np.float32([0.45, 0.62, 0.9]) * (1 - 0.25 * rise) + np.zeros((ROWS, COLUMNS, 3), np.float32)


def step_edge():
    image = np.full((ROWS, COLUMNS, 3), 0.25, np.float32)
    image[:, COLUMNS // 2 :] = 0.75
    return image


def nasty(kind):
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    board = ((x + y) % 2).astype(np.float32)
    return {
        "noise": rng.random((ROWS, COLUMNS, 3), np.float32),
        "binary noise": (rng.random((ROWS, COLUMNS, 3)) > 0.5).astype(np.float32),
        "black": np.zeros((ROWS, COLUMNS, 3), np.float32),
        "white": np.ones((ROWS, COLUMNS, 3), np.float32),
        "checkerboard": np.repeat(board[..., None], 3, 2),
        "saturated": np.stack([board, 1 - board, np.ones_like(board)], 2),
        "nearly white": np.float32(0.99) - 0.3 * np.repeat(board[..., None], 3, 2).astype(np.float32),
    }[kind]


def fine_rms(image):
    grey = image.mean(2)
    return 255 * float((grey - cv2.GaussianBlur(grey, (0, 0), 1.0))[16:-16, 16:-16].std())


@pytest.mark.parametrize(
    "kind", ["noise", "binary noise", "black", "white", "checkerboard", "saturated", "nearly white"]
)
@pytest.mark.parametrize("level", [1, 3])
def test_shrunk_it_is_the_observation_whatever_that_is(synthesizer, kind, level):
    observation = nasty(kind)
    detail = upscaled(synthesizer, observation, level=level)
    assert consistency_db(detail.image, observation, peak=1.0) >= 40  # measured 40.5 (noise) to 120
    assert detail.consistency_db >= 40
    assert detail.image.min() >= 0
    assert detail.image.max() <= 1


@pytest.mark.parametrize(
    ("columns", "rows", "width", "height"),
    [(8, 5, 64, 40), (5, 8, 40, 64), (17, 23, 68, 92), (17, 11, 272, 176), (1, 1, 8, 8), (2, 3, 16, 24)],
)
def test_small_and_odd_sizes_keep_the_promise(synthesizer, columns, rows, width, height):
    observation = meadow(rows, columns)
    detail = upscaled(synthesizer, observation, width, height)
    assert detail.image.shape == (height, width, 3)
    assert detail.relief_texture.shape == detail.labels.shape == (height, width)
    assert consistency_db(detail.image, observation, peak=1.0) >= 40


@pytest.mark.parametrize(("width", "height"), [(150, 101), (250, 170), (330, 223)])
def test_broken_factors_keep_the_promise_on_a_photograph(synthesizer, width, height):
    observation = meadow()
    detail = upscaled(synthesizer, observation, width, height)
    assert detail.image.shape == (height, width, 3)
    assert consistency_db(detail.image, observation, peak=1.0) >= 40  # measured 43.8 at the least


def test_same_seed_same_bytes_other_seed_other_bytes(synthesizer, tmp_path):
    observation = meadow()
    context = synthesizer.describe(observation, None)
    other = DetailSynthesizer(seed=1, library=TileLibrary(tmp_path))  # makes its tiles anew
    images = [
        who.upscale(observation, WIDTH, HEIGHT, context, WHOLE, 1, seed).image
        for who, seed in ((synthesizer, 7), (other, 7), (synthesizer, 8))
    ]
    assert np.array_equal(images[0], images[1])
    assert not np.array_equal(images[0], images[2])


def test_a_step_edge_rings_nowhere(synthesizer):
    image = upscaled(synthesizer, step_edge()).image
    near = image[16:-16, WIDTH // 2 - 24 : WIDTH // 2 + 24].mean(axis=(0, 2))
    assert near.min() > 0.25 - 0.004  # measured 0.2500; bicubic reaches 0.198
    assert near.max() < 0.75 + 0.004  # measured 0.7501; bicubic reaches 0.802
    bicubic = cv2.resize(step_edge(), (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)[64].mean(1)
    steepest = np.abs(np.diff(image[64].mean(1))).max()
    assert steepest > 2.5 * np.abs(np.diff(bicubic)).max()  # measured 3.2


def test_a_sky_stays_smooth_at_first_and_goes_on_in_the_end(synthesizer):
    observation = gradient_sky()
    context = synthesizer.describe(observation, None)
    fine, seen = [], []
    for level in range(1, 6):
        detail = synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, level, 7)
        seen.append(detail.names[detail.labels[HEIGHT // 2, WIDTH // 2]])
        fine.append(fine_rms(detail.image))
        context = synthesizer.describe(detail.image, context, detail)
        observation = detail.image[:ROWS, :COLUMNS]
    assert seen == ["sky", "air", "haze", "droplet", "frost"]
    assert max(fine[:2]) < 0.5  # grey levels of 255; measured 0.16 and 0.21
    assert 0.3 < fine[2] < 2  # measured 0.63
    assert min(fine[3:]) > 1  # measured 1.6 and 2.1


def test_rough_material_becomes_richer_than_bicubic_and_stays_so(synthesizer):
    observation = meadow()
    context = synthesizer.describe(observation, None)
    bicubic = cv2.resize(observation, (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC)
    assert "foliage" in context.materials
    for level in range(1, 5):
        detail = synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, level, 7)
        if level == 1:
            assert fine_rms(detail.image) > 8 * fine_rms(bicubic)  # measured 16
        assert 1.2 < fine_rms(detail.image) < 12  # neither mush nor noise; measured 4.4, 3.0, 2.5, 2.2
        context = synthesizer.describe(detail.image, context, detail)
        observation = detail.image[80 : 80 + ROWS, 100 : 100 + COLUMNS]


def test_the_mean_colour_does_not_drift(synthesizer):
    observation = meadow()
    image = upscaled(synthesizer, observation).image
    drift = 255 * np.abs(image.mean((0, 1)) - observation.mean((0, 1)))
    assert drift.max() < 0.1  # grey levels; measured 0.002


def test_flat_letters_are_not_covered_with_texture(synthesizer):
    page = np.full((ROWS, COLUMNS, 3), 235, np.uint8)
    cv2.putText(page, "wz", (2, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (25, 25, 25), 1, cv2.LINE_AA)
    image = upscaled(synthesizer, page.astype(np.float32) / 255).image
    paper = image[8:32, :].mean(2)  # above the letters
    assert 255 * paper.std() < 1.5  # measured 0.5


def test_flat_graphics_are_not_covered_with_texture(synthesizer):
    sign = np.full((8 * ROWS, 8 * COLUMNS, 3), (200, 40, 40), np.uint8)
    cv2.circle(sign, (80, 90), 60, (240, 240, 240), -1, cv2.LINE_AA)
    cv2.rectangle(sign, (130, 40), (250, 150), (30, 60, 160), -1)
    small = cv2.resize(sign, (COLUMNS, ROWS), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    image = upscaled(synthesizer, small).image
    for row, column in ((70, 60), (70, 160), (2, 2)):  # disc, box, ground
        assert 255 * image[row : row + 24, column : column + 24].std((0, 1)).max() < 1.5  # measured 1.1


def glossy_ball():
    y, x = np.mgrid[0:92, 0:136].astype(np.float32) / 4
    height = np.clip(1 - ((x - 17) / 15) ** 2 - ((y - 11) / 10) ** 2, 0, 1)
    shine = np.exp(-((x - 13) ** 2 + (y - 7) ** 2) / 3)
    return np.clip(
        np.float32([0.5, 0.55, 0.62]) * (0.3 + 0.6 * height[..., None]) + 0.5 * shine[..., None], 0, 1
    )


def test_a_glossy_thing_stays_smooth_and_turns_into_neither_stone_nor_wood(synthesizer):
    ball = glossy_ball()
    context, region = synthesizer.describe(ball, None), (40 / 136, 20 / 92, 74 / 136, 43 / 92)
    observation = ball[20:43, 40:74]
    for level in range(1, 5):
        detail = synthesizer.upscale(observation, WIDTH, HEIGHT, context, region, level, 7)
        assert not {"rock", "granite", "fibre", "foliage", "sand"} & set(detail.names)
        calm = detail.image[60:120, 90:170].mean(2)
        grain = 255 * (calm - cv2.GaussianBlur(calm, (0, 0), 1.5)).std()
        assert grain < (0.7, 0.7, 3, 9)[level - 1]  # grey levels; measured 0.35, 0.37, 1.0, 5.2
        context = synthesizer.describe(detail.image, context, detail)
        observation, region = detail.image[70:93, 110:144], (110 / 272, 70 / 184, 144 / 272, 93 / 184)


def test_a_wood_is_leafy_everywhere_not_in_patches(synthesizer):
    observation = meadow(46, 68)
    observation[10:36, 20:48] = cv2.GaussianBlur(observation[10:36, 20:48], (0, 0), 1.0)  # a calm place in it
    image = upscaled(synthesizer, observation, 544, 368).image.mean(2)
    fine = image - cv2.GaussianBlur(image, (0, 0), 1.5)
    calm, lively = fine[120:250, 200:340].std(), fine[120:250, 30:130].std()
    assert calm > 0.12 * lively  # measured 0.141


def test_preview_agrees_with_the_final_picture_where_both_can_be_seen(synthesizer):
    observation = meadow()
    context = synthesizer.describe(observation, None)
    quick = synthesizer.preview(observation, WIDTH, HEIGHT, context, WHOLE, 7, 1)
    final = synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, 1, 7).image
    assert quick.shape == final.shape
    low = [cv2.resize(image, (COLUMNS, ROWS), interpolation=cv2.INTER_AREA) for image in (quick, final)]
    assert 255 * float(np.sqrt(np.mean(np.square(low[0] - low[1])))) < 1.5  # measured 0.6
    assert quick.min() >= 0
    assert quick.max() <= 1


def test_a_named_material_is_used_and_shows(synthesizer):
    observation = np.full((ROWS, COLUMNS, 3), 0.5, np.float32)
    plain = upscaled(synthesizer, observation)
    cloth = upscaled(synthesizer, observation, material="a linen cloth")
    assert cloth.names == ("weave",)
    assert fine_rms(cloth.image) > 4 * fine_rms(plain.image)
    assert upscaled(synthesizer, observation, material="xyzzy").names == plain.names


def test_relief_is_signed_and_belongs_to_the_picture(synthesizer):
    detail = upscaled(synthesizer, meadow())
    assert abs(detail.relief_texture.mean()) < 0.1 * detail.relief_texture.std()
    grey = detail.image.mean(2)
    fine = grey - cv2.GaussianBlur(grey, (0, 0), 3.0)
    assert np.corrcoef(fine.ravel(), detail.relief_texture.ravel())[0, 1] > 0.7  # measured 0.82


def test_labels_index_known_materials(synthesizer):
    detail = upscaled(synthesizer, meadow())
    assert detail.labels.dtype == np.uint8
    assert detail.labels.max() < len(detail.names)
    assert set(detail.names) <= set(MATERIALS)


def test_cancelling_ends_the_work(synthesizer):
    def check():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        upscaled(synthesizer, meadow(), check=check)


def test_bad_sizes_are_refused(synthesizer):
    context = synthesizer.describe(meadow(), None)
    with pytest.raises(ValueError, match="smaller than the observation"):
        synthesizer.upscale(meadow(), 10, 10, context, WHOLE, 1, 0)
    with pytest.raises(ValueError, match="not \\(h, w, 3\\)"):
        synthesizer.upscale(meadow()[..., 0], WIDTH, HEIGHT, context, WHOLE, 1, 0)


def test_undefined_pixels_do_not_spread(synthesizer):
    observation = meadow()
    observation[3, 3] = math.nan
    context = synthesizer.describe(meadow(), None)
    assert np.isfinite(synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, 1, 0).image).all()


def test_no_leaves_on_the_white_petal_beside_them(synthesizer):
    """Regions are drawn coarsely: what is light and has another colour does not belong to the leaves."""
    rng = np.random.default_rng(3)
    rows, columns = ROWS, 3 * COLUMNS  # or all would lie near the one contour
    observation = np.tile(np.float32([0.45, 0.62, 0.25]), (rows, columns, 1))
    observation += rng.normal(0, 0.06, (rows, columns, 1)).astype(np.float32)
    observation[:, columns // 2 :] = (0.92, 0.9, 0.87)
    leaves = Region(1.0, 60, -22, 36, 12.0, 12.0, 11.0, 0.4, 0.5, 0.0)
    context = Context(np.zeros((rows, columns), np.uint8), ("foliage",), (leaves,), "leaves")
    detail = synthesizer.upscale(observation, 3 * WIDTH, HEIGHT, context, WHOLE, 1, 7)
    sides = np.split(detail.relief_texture, [8 * columns // 2], axis=1)
    green, white = (255 * float(side[:, 40:-40].std()) for side in sides)
    assert green > 5  # measured 12.7
    assert white < 0.05 * green  # measured 0.0, and 0.11 if the whole region belonged to them


def eye_amid_fur():
    """Streaks of hair, and in them a dark disc with glitter."""
    rng = np.random.default_rng(5)
    streaks = cv2.GaussianBlur(rng.normal(0, 1, (46, 68)).astype(np.float32), (0, 0), sigmaX=6, sigmaY=0.6)
    image = np.float32([0.62, 0.42, 0.28]) * (1 + 0.9 * streaks[..., None])
    y, x = np.mgrid[0:46, 0:68]
    disc = (np.hypot(x - 34, y - 23) < 13)[..., None]
    specks = np.zeros((46, 68), np.float32)
    specks[rng.integers(13, 34, 30), rng.integers(24, 45, 30)] = 1.2
    dark = np.float32([0.08, 0.09, 0.1]) + cv2.GaussianBlur(specks, (0, 0), 0.7)[..., None]
    return np.clip(np.where(disc, dark, image), 0, 1).astype(np.float32)


def test_an_eye_amid_fur_is_remembered_and_never_grows_hair(synthesizer):
    observation = eye_amid_fur()
    coat = Region(1.0, 55, 15, 27, 3.3, 5.4, 6.9, 0.51, 0.4, 0.0)
    context = Context(np.zeros((46, 68), np.uint8), ("fur",), (coat,), "brown fur")
    detail = synthesizer.upscale(observation, 544, 368, context, WHOLE, 1, 7)
    names = np.array(detail.names)[detail.labels]
    assert (names[140:228, 230:314] == "wet").mean() > 0.95  # inside of the disc; measured 1.0
    assert (names[:60] == "fur").all()
    seen = []
    for level in range(2, 5):
        context = synthesizer.describe(detail.image, context, detail)
        rows, columns = slice(160, 206), slice(238, 306)
        if level > 2:
            rows, columns = slice(100, 146), slice(200, 268)
        height, width = detail.image.shape[:2]
        region = (columns.start / width, rows.start / height, columns.stop / width, rows.stop / height)
        detail = synthesizer.upscale(detail.image[rows, columns], 544, 368, context, region, level, 7)
        seen.append(set(np.unique(np.array(detail.names)[detail.labels])))
    assert seen == [{"tear"}, {"cornea"}, {"cytoplasm"}]


def test_a_picture_without_gloss_gets_no_new_label(synthesizer):
    coat = Region(1.0, 55, 15, 27, 3.3, 5.4, 6.9, 0.51, 0.4, 0.0)
    streaks = cv2.GaussianBlur(np.random.default_rng(5).normal(0, 1, (46, 68)), (0, 0), sigmaX=6, sigmaY=0.6)
    observation = (np.float32([0.62, 0.42, 0.28]) * (1 + 0.9 * streaks[..., None])).astype(np.float32)
    context = Context(np.zeros((46, 68), np.uint8), ("fur",), (coat,), "brown fur")
    assert synthesizer.upscale(observation, 544, 368, context, WHOLE, 1, 7).names == ("fur",)


@pytest.mark.parametrize("tone", [6, 20, 45])
def test_a_shadow_does_not_go_black(synthesizer, tone):
    observation = np.full((ROWS, COLUMNS, 3), tone / 255, np.float32)
    stone = Region(1.0, 10, 0, 0, 12.0, 12.0, 11.0, 0.4, 0.5, 0.0)
    context = Context(np.zeros((ROWS, COLUMNS), np.uint8), ("granite",), (stone,), "crystals", 2)
    photograph = synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, 1, 7)
    deeper = synthesizer.upscale(observation, WIDTH, HEIGHT, context, WHOLE, 3, 7)
    contrast = 255 * deeper.image.mean(2).std() / tone
    assert 0.15 < contrast < 0.9  # measured 0.61, 0.38, 0.23
    assert deeper.consistency_db > 42  # measured 44.5 to 50.8
    assert photograph.image.std() < deeper.image.std()  # a photograph's own blacks stay as they are
