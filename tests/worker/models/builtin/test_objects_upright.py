"""What stands keeps standing, whatever it is put before."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
from wzviewer.worker.models.builtin.objects.footing import footing
from wzviewer.worker.models.builtin.objects.grammar import NO_TINT
from wzviewer.worker.models.builtin.objects.inserting import body_of
from wzviewer.worker.models.builtin.objects.placement import Plane, Support, from_above, lift_onto, pose_on

SIZE = (240, 360)
EDITOR = ObjectEditor()


def leaning(name, slope_y):
    """How many px of relief a px of height is worth more than in the body as it was made."""
    y = np.mgrid[0 : SIZE[0], 0 : SIZE[1]][0]
    support = Support((slope_y * (y - SIZE[0] / 2)).astype(np.float32), 1024.0)
    pose, plane = pose_on(body_of(name, 1, NO_TINT), support, (180.0, 120.0), 90.0, np.random.default_rng(1))
    lift = lift_onto(pose, plane)
    assert isinstance(lift, Plane)
    return float(np.hypot(lift.slope_x, lift.slope_y))


@pytest.mark.parametrize("slope_y", [0.0, -0.5, -4.0])
def test_a_cat_stands_before_a_wall_as_on_the_ground(slope_y):
    assert leaning("cat", slope_y) <= 0.35 + 1e-9  # before a wall, slope 0, it was 6.0


@pytest.mark.parametrize(("name", "least_deg", "most_deg"), [("cat", 0, 8), ("beetle", 15, 60)])
def test_what_stands_is_upright_on_ground_that_falls_to_a_side(name, least_deg, most_deg):
    """A beetle lies on its slope; a cat leaned with it as well, by 45 degrees."""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]].astype(np.float32)
    support = Support(-1.2 * (x - SIZE[1] / 2) - 1.2 * (y - SIZE[0] / 2), 1024.0)
    pose, _ = pose_on(body_of(name, 1, NO_TINT), support, (180.0, 120.0), 90.0, np.random.default_rng(1))
    across, down, _ = pose.camera_from_object[:, 2]
    assert least_deg <= abs(np.rad2deg(np.arctan2(across, -down))) <= most_deg  # measured 6.9 and 45


def test_a_beetle_follows_its_wall():
    assert leaning("beetle", 0.0) > 0.5  # measured 0.78: it creeps on it


def corner(at=140):
    """A wall above, a floor below it that comes towards the viewer: the relief of an empty room."""
    y = np.mgrid[0 : SIZE[0], 0 : SIZE[1]][0].astype(np.float32)
    return np.where(y < at, 0.0, -3.0 * (y - at)).astype(np.float32)


def test_what_was_asked_for_before_a_wall_stands_on_the_floor_below():
    x, y = footing(Support(corner(), 1024.0), (180.0, 120.0), 90.0)
    assert abs(x) < 3
    assert 20 <= y <= 40  # measured 33: past the edge, which is soft, with the whole foot


def test_what_stands_on_a_floor_stays_there():
    assert footing(Support(corner(), 1024.0), (180.0, 180.0), 90.0) == (0.0, 0.0)


def test_where_no_floor_is_near_nothing_moves():
    assert footing(Support(corner(235), 1024.0), (180.0, 60.0), 90.0) == (0.0, 0.0)


def test_the_cat_in_the_picture_stands_on_the_floor():
    image = np.full((*SIZE, 3), 0.5, np.float32)
    support = Support(corner(), 1024.0)
    result = EDITOR.apply(EDITOR.parse("a small cat"), image, support, 1)
    y, x = np.nonzero(result.object_mask)
    feet = y > y.max() - 6
    gap = (support.relief[y, x] - result.object_relief[y, x])[feet]
    assert y.max() > 145
    assert np.abs(np.median(gap)) < 15.0  # measured 10.4: 3.5 px of picture on a floor this flat


def test_the_shadow_of_what_stands_is_seen_from_above():
    """On ground seen from 16 degrees a robin's shadow was a streak two pixels high."""
    rng, flat = np.random.default_rng(1), Support(np.zeros(SIZE, np.float32), 1024.0)
    cat, _ = pose_on(body_of("cat", 1, NO_TINT), flat, (180.0, 120.0), 90.0, rng)
    beetle, _ = pose_on(body_of("beetle", 1, NO_TINT), flat, (180.0, 120.0), 90.0, rng)
    raised = from_above(cat)
    assert isinstance(raised, Plane)
    n = cat.camera_from_object[:, 2]
    own = -n[:2] / (n @ np.array([*cat.ray, 1.0]))
    seen_from_deg = np.degrees(np.arctan(1 / np.hypot(own[0] + raised.slope_x, own[1] + raised.slope_y)))
    assert seen_from_deg == pytest.approx(30.0, abs=0.1)
    assert from_above(beetle) is None
