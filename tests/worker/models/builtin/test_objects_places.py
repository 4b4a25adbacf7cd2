"""Places of a prompt: found by their look, never in the sky, in the air, under water."""

import json

import cv2
import numpy as np
import pytest

from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Placement, Support
from wzviewer.worker.models.builtin.objects.inserting import body_of
from wzviewer.worker.models.builtin.objects.places import View, spots
from wzviewer.worker.models.builtin.objects.words import LOOKS, SURFACES

W, H = 240, 160
EDITOR = ObjectEditor()
FLOWER, LAKE = (60, 92), (185, 125)


def scene(flower=True):
    """Sky above; a meadow below with a sunflower on the left and a lake on the right."""
    image = np.empty((H, W, 3), np.float32)
    image[:] = (0.62, 0.74, 0.92)
    image[70:] = (0.22, 0.40, 0.12)
    cv2.ellipse(image, LAKE, (42, 22), 0, 0, 360, (0.10, 0.27, 0.42), -1)
    if flower:
        cv2.circle(image, FLOWER, 34, (0.95, 0.75, 0.08), -1)
        cv2.circle(image, FLOWER, 13, (0.20, 0.12, 0.05), -1)
    v = np.mgrid[:H, :W][0].astype(np.float32)
    relief = np.where(v < 70, 900, -4.0 * (v - 115)).astype(np.float32)
    return image, Support(relief, 1200.0, sky=np.asarray(v < 70))


def put(prompt, **more):
    image, support = scene(**more)
    return EDITOR.apply(EDITOR.parse(prompt), image, support, 1), image, support


def middle(mask):
    y, x = np.nonzero(mask)
    return x.mean(), y.mean()


def test_on_the_sunflower_is_on_the_sunflower():
    result, _, _ = put("a butterfly on the sunflower")
    x, y = middle(result.object_mask)
    assert np.hypot(x - FLOWER[0], y - FLOWER[1]) < 30  # of a radius of 34 px; measured 24
    assert result.places == ({"object": "butterfly", "place": "sunflower", "found": True},)
    columns = np.flatnonzero(result.object_mask.any(0))
    assert np.ptp(columns) < 0.4 * W  # no larger than its flower; measured .17


def test_a_colour_says_which():
    image, support = scene()
    cv2.circle(image, (180, 90), 30, (0.80, 0.10, 0.12), -1)
    view = View.of(image, support)
    (((x, _), _),) = spots(("red", "flower"), "on", (W / 2, H / 2), 60, view, (H, W))[0]
    assert x == pytest.approx(180, abs=25)  # measured 171
    (((x, _), _),) = spots(("yellow", "flower"), "on", (W / 2, H / 2), 60, view, (H, W))[0]
    assert x == pytest.approx(FLOWER[0], abs=25)  # measured 80


def test_what_is_looked_at_is_preferred():
    image, support = scene()
    view = View.of(image, support)
    for wanted in ((120.0, 130.0), (100.0, 145.0)):
        (((x, y), _),), found = spots(("grass",), "on", wanted, 30, view, (H, W))
        assert ((x, y), found) == (wanted, True)


def test_beside_is_not_on():
    result, _, _ = put("a small beetle near the sunflower")
    x, y = middle(result.object_mask)
    assert 28 < np.hypot(x - FLOWER[0], y - FLOWER[1]) < 75  # measured 40


@pytest.mark.parametrize(
    "prompt", ["a cat on the sunflower", "a cat", "three small snails", "a cat on the chair"]
)
def test_what_is_not_there_is_not_looked_for_in_the_sky(prompt):
    result, _, support = put(prompt, flower=False)
    feet = max(p.pose.position[1] for p in result.placements)
    assert feet > 70
    assert (
        result.object_mask & support.sky
    ).sum() < 0.6 * result.object_mask.sum()  # a cat stands upright; measured .24
    assert all(told["found"] is False for told in result.places)


def test_the_view_is_all_sky_and_still_something_is_drawn():
    image, support = scene()
    sky = Support(support.relief, 1200.0, sky=np.ones((H, W), bool))
    assert EDITOR.apply(EDITOR.parse("a cat"), image, sky, 1).object_mask.any()


@pytest.mark.parametrize("place", sorted(set(LOOKS)))
def test_every_look_belongs_to_a_place_word(place):
    assert place in SURFACES


@pytest.mark.parametrize("prompt", ["a flying lizard", "a cat flying over the meadow", "a ladybug hovering"])
def test_what_cannot_fly_does_not(prompt):
    with pytest.raises(PromptError) as caught:
        EDITOR.parse(prompt)
    assert "butterfly" in caught.value.hint


def test_in_the_air_it_touches_nothing_and_its_shadow_is_apart():
    rests, _, support = put("a butterfly on the meadow")
    flies, _, _ = put("a butterfly flying over the meadow")
    gaps = [(support.relief - r.object_relief)[r.object_mask & ~support.sky].min() for r in (rests, flies)]
    assert gaps[0] < 2  # native px; measured .25
    assert gaps[1] > 8  # measured 22
    under = [r.shadow[r.alpha == 0].min() for r in (rests, flies)]
    assert under[1] > under[0]  # softer; measured .52 beside .21


def test_a_bird_in_the_air_has_its_wings_spread():
    flies, _, _ = put("a bird in the sky")
    assert flies.placements[0].name == "bird in flight"
    assert (flies.shadow == 1).all()
    (placed,) = (Placement.from_dict(json.loads(json.dumps(p.to_dict()))) for p in flies.placements)
    reach = [np.abs(body_of(n, 1, placed.tint).primitives[:, 30]).max() for n in ("bird", placed.name)]
    assert reach[1] > 3 * reach[0]  # measured .14 and .48 of its length
    x, y = (int(v) for v in middle(flies.object_mask))
    base = np.full((H, W, 3), 0.5, np.float32)
    flat = Support(np.zeros((H, W), np.float32), 4800.0)
    assert EDITOR.continue_into((placed,), (x - 30, y - 20, 4.0), base, flat, 1) is not None


def test_several_in_a_narrow_place_are_small_enough_not_to_overlap():
    image, support = scene()
    where, found = spots(("sunflower",), "on", (W / 2, H / 2), 60, View.of(image, support), (H, W), count=3)
    assert found
    for k, (a, width) in enumerate(where):
        for b, other in where[:k]:
            assert np.hypot(a[0] - b[0], a[1] - b[1]) >= 0.45 * (width + other)


def test_under_water_it_is_dim_and_ends_at_the_shore():
    result, image, _ = put("a fish in the lake")
    dry, _, _ = put("a fish")
    blue = image[..., 2] > 1.5 * image[..., 0]
    assert (result.object_mask & ~blue).sum() < 0.05 * result.object_mask.sum()  # measured 0
    inside, outside = result.image[result.object_mask], dry.image[dry.object_mask]
    assert inside[:, 0].mean() < 0.75 * outside[:, 0].mean()  # red goes first; measured .53
    (placed,) = result.placements
    assert Placement.from_dict(json.loads(json.dumps(placed.to_dict()))).water == placed.water
    assert placed.water is not None
    assert dry.placements[0].water is None
