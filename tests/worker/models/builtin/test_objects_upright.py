"""What stands keeps standing, whatever it is put before."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.grammar import NO_TINT
from wzviewer.worker.models.builtin.objects.inserting import body_of
from wzviewer.worker.models.builtin.objects.placement import Plane, Support, lift_onto, pose_on

SIZE = (240, 360)


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


def test_a_beetle_follows_its_wall():
    assert leaning("beetle", 0.0) > 0.5  # measured 0.78: it creeps on it
