import numpy as np

from wzviewer.worker.models.builtin.depth.figures import find_figures, stand_figures

H, W = 240, 360
PERSON = (slice(120, 170), slice(200, 214))


def meadow(person=PERSON):
    """A green lawn of uneven light, a person in red on it, and a sky."""
    rng = np.random.default_rng(0)
    light = rng.normal(0, 12, (H, W, 1))
    image = np.clip(np.array([70, 110, 60]) + light, 0, 255).astype(np.uint8)
    image[:60] = (150, 180, 220)
    image[person] = (150, 20, 30)
    hidden = np.zeros((H, W), bool)
    hidden[:60] = True
    return image, hidden


def test_a_person_on_a_lawn_is_found_whole_and_nothing_else():
    image, hidden = meadow()
    found = find_figures(image, hidden) > 0
    truth = np.zeros((H, W), bool)
    truth[PERSON] = True
    assert (found & truth).sum() > 0.9 * truth.sum()  # measured: 1.00
    assert (found & ~truth).sum() < 0.15 * truth.sum()  # measured: 0.03


def test_what_is_wide_or_cut_off_by_the_frame_is_no_figure():
    for shape in ((slice(150, 164), slice(180, 230)), (slice(190, 240), slice(200, 214))):
        assert find_figures(*meadow(shape)).max() == 0


def test_a_figure_is_as_far_away_as_its_foot():
    image, hidden = meadow()
    ground = np.repeat(np.linspace(0, 1, H, dtype=np.float32)[:, None], W, 1)
    figures = find_figures(image, hidden)
    d = stand_figures(ground, figures)
    inside = d[125:160, 202:212]
    assert np.ptp(inside) < 1e-6
    assert abs(inside[0, 0] - ground[170, 0]) < 0.03  # measured: 0.017
    assert np.array_equal(d[figures == 0], ground[figures == 0])
    assert np.array_equal(stand_figures(ground, np.zeros_like(figures)), ground)


def test_what_goes_on_above_in_something_that_stands_is_a_part_of_that():
    image, hidden = meadow()
    lying = np.repeat(np.linspace(0, 1, H, dtype=np.float32)[:, None], W, 1)
    stood = lying.copy()
    stood[60:120] += 0.15
    figures = find_figures(image, hidden)
    assert np.array_equal(stand_figures(stood, figures, lying), stood)


def test_a_stem_is_no_figure():
    assert find_figures(*meadow((slice(90, 200), slice(200, 206)))).max() == 0
