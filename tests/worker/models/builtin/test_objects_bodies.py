"""Every builder: a bounded body, the same from the same seed, in every substance."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.bodies import Tint
from wzviewer.worker.models.builtin.objects.inserting import body_of
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS
from wzviewer.worker.models.builtin.objects.patterns import MATERIAL, SHEET
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.primitives import ROW
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import render_mask
from wzviewer.worker.models.builtin.objects.substances import recast

SIDE = np.array([[0.0, 1, 0], [0, 0, -1], [-1, 0, 0]])  # x of the picture along y, z up
NONE = Tint()


def mask_of(body, size_px=40.0):
    pose = Pose(SIDE, size_px, (60.0, 70.0, 0.0))
    return render_mask(Scene(body, pose, 120, 100))


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_a_bounded_body_of_about_one_length(name):
    body = BUILDERS[name](np.random.default_rng(4), NONE)
    assert body.primitives.shape[1] == ROW
    assert body.materials.shape[1] == MATERIAL
    assert np.isfinite(body.primitives).all()
    assert np.isfinite(body.materials).all()
    assert len(body.primitives) < 400
    mask, relief = mask_of(body)
    y, x = np.nonzero(mask)
    assert 0.4 < np.ptp(x) / 40 < 1.9  # measured .6 (cat) to 1.6 (spider)
    assert 0 < x.min()
    assert x.max() < 119
    assert 0 < y.min()
    assert np.isfinite(relief[mask]).all()


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_the_same_seed_builds_the_same_bytes(name):
    first, again = (BUILDERS[name](np.random.default_rng(4), NONE) for _ in range(2))
    assert first.primitives.tobytes() == again.primitives.tobytes()
    assert first.materials.tobytes() == again.materials.tobytes()
    assert first.outlines.tobytes() == again.outlines.tobytes()


@pytest.mark.parametrize(
    "substance", ["metal", "wood", "stone", "marble", "glass", "ice", "moss", "rust", "plastic"]
)
def test_substances_keep_the_form(substance):
    body = BUILDERS["fish"](np.random.default_rng(4), NONE)
    cast = recast(body, Tint(substance=substance))
    assert cast.refractive == (substance in {"glass", "ice"})
    assert (cast.materials[:, SHEET] == 0).all()
    assert np.array_equal(mask_of(body)[0], mask_of(cast)[0])


def test_no_substance_is_the_body_itself():
    body = BUILDERS["fish"](np.random.default_rng(4), NONE)
    assert recast(body, NONE) is body


def test_colour_words_reach_the_body():
    red, blue = (body_of("mushroom", 3, Tint(c)).materials[0, 1:4] for c in ((0.5, 0, 0), (0, 0, 0.5)))
    assert red[0] > red[2]
    assert blue[2] > blue[0]
