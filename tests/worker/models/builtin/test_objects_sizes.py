"""Sizes that fit the scene: what a pixel is worth, and how large a thing is drawn there."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS
from wzviewer.worker.models.builtin.objects.placement import Support
from wzviewer.worker.models.builtin.objects.sizes import (
    LEAST_OF_USUAL,
    LEAST_SHARE,
    NATURAL_M,
    Ruler,
    coarse,
    metres_at,
    share_of,
)
from wzviewer.worker.models.builtin.objects.words import USUAL_SIZE

H, W, FOCAL = 480, 720, 700.0
EDITOR = ObjectEditor()


def ground(eye=2.4):
    """A level ground seen from eye height, the unit of depth being one metre; sky above."""
    rows = np.arange(H)[:, None] + 0.5 - H / 2
    depth = np.where(rows > 0, eye * FOCAL / np.maximum(rows, 1e-9), np.nan)
    return np.broadcast_to(depth, (H, W)).copy(), np.broadcast_to(rows <= 0, (H, W))


def test_every_object_has_a_natural_size():
    assert set(NATURAL_M) == set(BUILDERS)


def test_level_ground_tells_its_metres():
    depth, sky = ground()
    ruler = Ruler.of(depth, sky, FOCAL, "landscape")
    assert ruler is not None
    assert ruler(np.array([5.0, 12.0, 40.0])) == pytest.approx(1.0, rel=0.02)  # measured .999 to 1.001


def test_it_does_so_in_any_unit_of_depth():
    depth, sky = ground()
    ruler = Ruler.of(depth / 7.0, sky, FOCAL, "landscape")
    assert ruler is not None
    assert ruler(np.array([1.0])) == pytest.approx(7.0, rel=0.02)


def test_a_close_up_tells_nothing():
    depth, sky = ground()
    assert Ruler.of(depth, sky, FOCAL, "macro") is None
    assert share_of("bird", USUAL_SIZE, None, (H, W)) == USUAL_SIZE


def test_a_robin_is_far_smaller_than_a_person_beside_it():
    metres = 4.0 / W  # a view four metres wide
    bird, person = share_of("bird", USUAL_SIZE, metres, (H, W)), 1.7 / 4.0
    assert bird < 0.35 * person  # measured .19


def test_deeper_views_are_smaller_worlds():
    shares = [share_of("bird", USUAL_SIZE, width / W, (H, W)) for width in (100.0, 8.0, 1.0, 0.1)]
    assert shares == sorted(shares)
    assert shares[-1] == USUAL_SIZE


def test_nothing_is_a_speck():
    """What is read of a picture may be wrong: a robin stays in sight, a tiny one nearly so."""
    far = 500.0 / W
    assert share_of("bird", USUAL_SIZE, far, (H, W)) == pytest.approx(LEAST_OF_USUAL * USUAL_SIZE)
    assert share_of("bird", 0.12, far, (H, W)) >= LEAST_SHARE * H / W


@pytest.mark.parametrize("name", ["ladybug", "butterfly", "lego brick"])
def test_what_is_smaller_than_a_hand_is_there_to_be_looked_at(name):
    """A petal near the camera, in a meadow, read as metres wide: a butterfly on it was 3 % of the view."""
    for width_m in (50.0, 1.0, 0.01):
        assert share_of(name, USUAL_SIZE, width_m / W, (H, W)) == USUAL_SIZE


@pytest.mark.parametrize("width_m", [0.1, 1.0, 8.0])
def test_words_still_act(width_m):
    tiny, usual, giant = (share_of("cat", size, width_m / W, (H, W)) for size in (0.12, USUAL_SIZE, 0.8))
    assert tiny < usual
    assert giant >= 1.9 * usual


def test_what_is_not_known_is_asked_of_the_rest():
    metres = np.full((4, 6), np.nan, np.float32)
    metres[3] = 0.01
    assert metres_at(metres, (H, W), 10, 10) == pytest.approx(0.01)
    assert metres_at(metres * np.nan, (H, W), 10, 10) is None


def test_a_coarse_map_leaves_out_the_sky():
    depth, sky = ground()
    small = coarse(np.where(sky, np.nan, depth))
    assert small.shape == (H // 24, W // 24)
    assert np.isnan(small[0]).all()
    assert small[-1, 0] == pytest.approx(2.4 * FOCAL / (H / 2 - 12), rel=0.01)


def test_the_editor_draws_it_so():
    v = np.mgrid[:160, :240][0].astype(np.float32)
    image = np.full((160, 240, 3), 0.4, np.float32)
    widths = []
    for metres in (None, np.full((6, 10), 4.0 / 240, np.float32)):
        support = Support((-0.9 * (v - 80)).astype(np.float32), 1200.0, metres_per_px=metres)
        result = EDITOR.apply(EDITOR.parse("a bird"), image, support, 1)
        widths.append(result.placements[0].width_px)
    assert widths[0] == pytest.approx(0.4 * 240)
    assert widths[1] == pytest.approx(share_of("bird", USUAL_SIZE, 4.0 / 240, (160, 240)) * 240)
    assert widths[1] < 0.4 * widths[0]
