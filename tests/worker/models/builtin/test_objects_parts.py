"""Objects taken apart: the picture again when put together, and what the view hides of them."""

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Support
from wzviewer.worker.models.builtin.objects.ground import past_others

W, H = 240, 160
EDITOR = ObjectEditor()


def picture():
    noise = cv2.GaussianBlur(np.random.default_rng(0).random((H, W, 3), np.float32), (0, 0), 3)
    return np.clip(0.45 + 2.0 * (noise - 0.5), 0, 1).astype(np.float32)


def insert(prompt, **more):
    v = np.mgrid[:H, :W][0].astype(np.float32)
    support = Support((-0.7 * (v - H / 2)).astype(np.float32), 1800.0)
    return EDITOR.apply(EDITOR.parse(prompt), picture(), support, 1, **more)


@pytest.fixture(scope="module")
def bee():
    return insert("a huge bee")


def placed(part, plane, fill):
    out = np.full((H, W, *plane.shape[2:]), fill, np.float32)
    x, y = part.offset_px
    out[y : y + plane.shape[0], x : x + plane.shape[1]] = plane
    return out


def together(result):
    image = result.ground
    for part in result.parts:
        alpha = placed(part, np.where(np.isfinite(part.relief), part.alpha, 0), 0.0)[..., None]
        image = image + alpha * (placed(part, part.color, 0.0) - image)
    return image


@pytest.mark.parametrize("name", ["bee", "ladybug", "daisy", "lego brick", "drop of water", "fish"])
def test_put_together_they_are_the_picture(name):
    result = insert(f"a huge {name}")
    off = np.abs(together(result) - result.image).max(-1)
    assert off[result.alpha == 0].max() < 1e-6
    assert np.percentile(off[result.alpha > 0], 99) < 0.06  # measured .03 (bee), others below .01


def test_behind_a_wing_the_body_goes_on(bee):
    trunk, limbs, wings = bee.parts
    sheer = placed(wings, wings.alpha, 0.0)
    body = placed(trunk, trunk.alpha, 0.0)
    behind = (sheer > 0.15) & (body > 0.99)
    assert behind.sum() > 200  # measured 900: a third of the wings is before the body
    front, back = (placed(p, p.relief, np.nan) for p in (wings, trunk))
    assert (back - front)[behind].min() > -0.5  # px; measured -.26 where a wing leaves the fur
    assert 0.05 < np.median(sheer[sheer > 0.04]) < 0.7
    assert np.isfinite(limbs.relief).any()


def test_flanks_are_behind_what_is_seen(bee):
    (flanks,) = bee.flanks
    x, y = np.floor(flanks.corners[0, :, :2]).astype(int).T
    assert len(x) > 50
    nearest = np.fmin.reduce([placed(p, p.relief, np.nan) for p in bee.parts])
    assert (flanks.corners[0, :, 2] > nearest[y, x] - 1).mean() > 0.99
    assert ((flanks.color >= 0) & (flanks.color <= 1)).all()


def test_what_is_thin_is_a_part_of_its_own():
    trunk, limbs = insert("a huge ladybug").parts
    shell, legs = placed(trunk, trunk.alpha, 0.0), placed(limbs, limbs.alpha, 0.0)
    assert shell.sum() > 3 * legs.sum()
    assert ((legs > 0.9) & (shell < 0.1)).any()
    assert len(insert("a lego brick").parts) == 1


def test_the_ground_has_the_shadow_and_no_object(bee):
    inside = bee.alpha > 0.9
    assert np.abs(bee.ground - bee.image)[inside].mean() > 0.1
    shaded = (bee.shadow < 0.8) & (bee.alpha == 0)
    assert (bee.ground[shaded].mean(-1) < picture()[shaded].mean(-1)).mean() > 0.95


def test_a_preview_is_not_taken_apart():
    assert insert("a ladybug", apart=False).parts == ()


def test_weather_changes_the_parts_as_well():
    day, night = insert("a ladybug"), insert("a ladybug at night")
    assert night.parts[0].color.mean() < 0.7 * day.parts[0].color.mean()
    inside = (slice(40, -40), slice(40, -40))  # at the border a change ends
    assert night.ground[inside].mean() < 0.7 * day.ground[inside].mean()


def test_the_same_again(bee):
    again = insert("a huge bee")
    for one, two in zip(bee.parts, again.parts, strict=True):
        assert one.color.tobytes() == two.color.tobytes()
    assert bee.flanks[0].corners.tobytes() == again.flanks[0].corners.tobytes()


def test_a_shadow_on_an_older_object_is_not_on_the_ground_behind_it():
    others, gain = np.zeros((30, 40), np.float32), np.full((30, 40), 0.5, np.float32)
    others[5:20, 10:30] = 0.96  # a wing, whatever its colour
    others[20, 10:30] = 0.02  # a trace of its outline
    found = past_others(gain, others)
    assert (found[5:20, 10:30] == 1).all()
    assert (found[20:] == 0.5).all()
