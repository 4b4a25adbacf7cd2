"""What a body's own level does not see: it is where the body is, behind the picture, in its colours."""

from functools import cache

import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects import sides as module
from wzviewer.worker.models.builtin.objects.aside import Aside
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Support

W, H, FOCAL = 240, 160, 300.0
HERE = (0.0, 0.0, 1.0)
EDITOR = ObjectEditor()


@cache
def drawn(name="ladybug"):
    """A picture with an object on a floor, and its relief."""
    v = np.mgrid[:H, :W][0].astype(np.float32)
    floor = (-0.4 * (v - H / 2)).astype(np.float32)
    image = np.full((H, W, 3), 0.55, np.float32)
    result = EDITOR.apply(EDITOR.parse(f"a {name}"), image, Support(floor, FOCAL), 4)
    relief = np.where(result.object_mask, result.object_relief, floor).astype(np.float32)
    return result, relief


@cache
def side_of(name="ladybug"):
    result, relief = drawn(name)
    placed = [(p, HERE) for p in result.placements]
    return EDITOR.sides(placed, result.image, relief, result.object_mask, FOCAL)


def at(picture, places):
    column, row = np.floor(places).astype(int).T
    return picture[row, column]


@pytest.mark.parametrize("name", ["ladybug", "bee", "cat"])
def test_sides_lie_behind_the_picture_and_before_the_back(name):
    side, (result, relief) = side_of(name), drawn(name)
    assert len(side.relief) > 100  # measured: 250, 158, 476
    assert (side.relief > at(relief, side.places)).all()
    assert at(result.object_mask, side.places).all()
    known = at(side.back, side.places)
    here = np.isfinite(known)
    assert (side.relief[here] < known[here] + 3).mean() > 0.95  # measured: 1, .994, .985


def test_the_front_is_found_where_the_picture_has_it():
    result, relief = drawn()
    placed = result.placements[0]
    view = Aside(placed, placed.pose, (W, H), 2.0)
    front = view.march(solid=False)
    seen = front.take(at(result.object_mask, front.places))
    fit = module._Fit.of(view, seen, result.image, relief)
    off = np.abs(fit.relief_of(seen) - at(relief, seen.places))
    assert np.median(off) < 0.3  # px; measured .11
    colors = fit.colors_of(view.shade(seen)[0])
    assert np.median(np.abs(colors - at(result.image, seen.places))) < 0.05  # measured .011


def test_a_point_has_one_place_whoever_sees_it():
    placed = drawn()[0].placements[0]
    level_px = placed.pose.position[2]
    views = [Aside(placed, placed.pose, (W, H), 1.0, slope, level_px) for slope in ((0.0, 0.0), (0.3, 0.1))]
    hits = [view.march() for view in views]
    expected = placed.pose.project(hits[1].points)
    assert np.allclose(hits[1].places, expected, atol=1e-6)  # measured 3e-14
    assert views[1].sees(hits[1]).all()
    shared = views[1].sees(hits[0]).mean()
    assert 0.7 < shared < 1  # measured .993: what is turned away from aside is not seen there


def test_tangents_lead_to_the_neighbours():
    placed = drawn("cat")[0].placements[0]
    view = Aside(placed, placed.pose, (W, H), 1.0, (0.3, 0.0), placed.pose.position[2])
    hits = view.march()
    hits = hits.take(view.faces(hits))
    q = hits.points @ placed.pose.camera_from_object.T * placed.pose.size_px
    index = {tuple(ray): i for i, ray in enumerate(np.floor(hits.rays).astype(int))}
    pairs = [(i, index[(x + 1, y)]) for (x, y), i in index.items() if (x + 1, y) in index]
    here, right = np.array(pairs).T
    off = np.linalg.norm(q[right] - q[here] - view.tangents(hits)[here, 0], axis=1)
    assert np.median(off) < 0.15  # px of 1; measured .06


def test_the_back_is_behind_the_front():
    placed = drawn()[0].placements[0]
    front = Aside(placed, placed.pose, (W, H), 1.0).march()
    back = Aside(placed, placed.pose, (W, H), 1.0, from_behind=True).march()
    depth = {tuple(ray): z for ray, z in zip(front.rays, front.relief, strict=True)}
    both = [
        (depth[tuple(ray)], z) for ray, z in zip(back.rays, back.relief, strict=True) if tuple(ray) in depth
    ]
    assert len(both) > 0.99 * max(len(front.rays), len(back.rays))  # but for a few at the outline
    thick = np.diff(np.array(both), axis=1)
    assert thick.min() > -1  # px; measured -.67: where a leg is thinner than a pixel
    assert np.median(thick) > 5  # px: it has a body


def test_what_was_not_put_in_has_no_sides():
    image = np.full((H, W, 3), 0.5, np.float32)
    flat, nothing = np.zeros((H, W), np.float32), np.zeros((H, W), bool)
    placed = [(p, (5e4, 5e4, 1.0)) for p in drawn()[0].placements]  # far out of the picture
    side = EDITOR.sides(placed, image, flat, nothing, FOCAL)
    assert not len(side.relief)
    assert not np.isfinite(side.back).any()


def test_the_same_twice():
    result, relief = drawn()
    placed = [(p, HERE) for p in result.placements]
    again = EDITOR.sides(placed, result.image, relief, result.object_mask, FOCAL)
    for name in ("places", "relief", "tangents", "colors", "back"):
        assert getattr(again, name).tobytes() == getattr(side_of(), name).tobytes()
