"""Where the depth steps, a body lies on the front side, and its shadow ends where that does."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
from wzviewer.worker.models.builtin.objects.placement import Support
from wzviewer.worker.models.builtin.objects.surfaces import beyond, on_front

SIZE = (240, 360)
FOCAL_PX = 2048.0
MIDDLE = (180.0, 120.0)
WIDTH_PX = 144.0
EDITOR = ObjectEditor()


def petal(edge, behind=900.0, slope=0.0):
    """A surface left of a column, and another far behind it; both may slant."""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]].astype(np.float32)
    return Support((np.where(x < edge, 0.0, behind) + slope * (y - MIDDLE[1])).astype(np.float32), FOCAL_PX)


def ladybug(support, prompt="a ladybug"):
    return EDITOR.apply(EDITOR.parse(prompt), np.full((*SIZE, 3), 0.6, np.float32), support, 1)


@pytest.mark.parametrize("edge", [165, 180, 195])
@pytest.mark.parametrize("slope", [0.0, -1.0])
def test_beside_an_edge_the_front_comes_first(edge, slope):
    x, y = on_front(petal(edge, slope=slope), MIDDLE, WIDTH_PX)
    assert edge - 0.25 * WIDTH_PX <= x <= edge - 0.13 * WIDTH_PX  # measured 29 to 30 px, .2 of its width
    assert abs(y - MIDDLE[1]) < 6


def test_the_front_is_found_from_either_anchor_distance():
    """The same step seen from a level that is anchored far behind it."""
    near = petal(180)
    far = Support((near.relief - np.float32(900)) / np.float32(1 + 900 / FOCAL_PX), FOCAL_PX)
    assert on_front(far, MIDDLE, WIDTH_PX) == pytest.approx(on_front(near, MIDDLE, WIDTH_PX))


@pytest.mark.parametrize("slope", [0.0, -1.5, 2.5])
def test_without_a_step_nothing_moves(slope):
    assert on_front(petal(400, slope=slope), MIDDLE, WIDTH_PX) == MIDDLE
    assert not beyond(petal(400, slope=slope), MIDDLE, WIDTH_PX).any()


def test_specks_of_depth_are_no_surface():
    support = petal(400)
    support.relief[110:116, 150:156] = 900.0
    assert on_front(support, MIDDLE, WIDTH_PX) == MIDDLE
    assert not beyond(support, MIDDLE, WIDTH_PX).any()


def test_far_from_the_edge_nothing_moves():
    assert on_front(petal(110), MIDDLE, WIDTH_PX) == MIDDLE
    assert on_front(petal(250), MIDDLE, WIDTH_PX) == MIDDLE


def test_a_blade_that_is_too_narrow_is_left_for_what_is_behind():
    x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]][1]
    blade = Support(np.where(np.abs(x - 180) < 5, 0.0, 900.0).astype(np.float32), FOCAL_PX)
    at = on_front(blade, MIDDLE, WIDTH_PX)
    assert abs(at[0] - 180) > 0.13 * WIDTH_PX  # measured 33 px: beside the blade
    assert abs(at[0] - 180) < 0.18 * SIZE[1]


def test_the_ladybug_is_whole_and_touches_the_petal():
    support = petal(170)
    result = ladybug(support)
    relief = result.object_relief[result.object_mask]
    assert np.nanmax(relief) < 0.05 * WIDTH_PX  # measured 4.9 px: a foot hangs over the edge
    on_it = result.object_mask & (support.relief == 0)
    assert -0.3 < np.nanmax(result.object_relief[on_it]) <= 0  # measured -0.25 px: it touches
    lost = (result.alpha >= 0.5) & ~result.object_mask
    assert lost.sum() < 0.02 * result.object_mask.sum()  # measured 26 of 8489 px: hairs
    x = np.nonzero(result.object_mask)[1]
    assert 0.5 * (x.min() + x.max()) < 170


def test_its_shadow_stays_on_the_petal():
    result = ladybug(petal(170))
    behind = np.mgrid[0 : SIZE[0], 0 : SIZE[1]][1] >= 170
    assert (result.shadow[behind] == 1).all()
    assert result.shadow[~behind & ~result.object_mask].min() < 0.8


def test_the_place_of_the_prompt_wins():
    x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]][1]
    image = np.where((x < 175)[..., None], (0.92, 0.90, 0.88), (0.25, 0.5, 0.12)).astype(np.float32)
    support = petal(175)
    free = EDITOR.apply(EDITOR.parse("a ladybug"), image, support, 1)
    asked = EDITOR.apply(EDITOR.parse("a ladybug on the grass"), image, support, 1)
    assert np.nonzero(free.object_mask)[1].mean() < 175 < np.nonzero(asked.object_mask)[1].mean()


def test_a_sliver_of_wrong_depth_is_not_lit_inside_the_shadow():
    flat = np.zeros(SIZE, np.float32)
    clean = ladybug(Support(flat, FOCAL_PX))
    y, x = np.nonzero((clean.shadow < 0.75) & ~clean.object_mask & (clean.alpha == 0))
    row, column = int(np.median(y)), int(np.median(x[y == int(np.median(y))]))
    sliver = flat.copy()
    sliver[row - 8 : row + 8, column - 8 : column + 8] = -30
    marred = ladybug(Support(sliver, FOCAL_PX))
    free = (clean.alpha == 0) & (marred.alpha == 0)
    assert np.abs(marred.shadow - clean.shadow)[free].max() < 0.1
