"""A level over older siblings: what they show in its view stays seen."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.worker.test_synthesis import Quiet, picture
from wzviewer.core.navigation import orbited
from wzviewer.worker.beside import Overlay
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part
from wzviewer.worker.models.builtin.objects.placed import EditResult
from wzviewer.worker.models.registry import load_synthesizer
from wzviewer.worker.stages.stage1_drawn_again import (
    BESIDE,
    PLACEMENTS,
    _Hidden,
    _with_standing,
    groups_in_view,
    mapping_to,
)
from wzviewer.worker.stages.stage1_new_scale_image import observe, preview_image
from wzviewer.worker.synthesis import reconstruct_scene, synthesize_level

ASIDE = 0.02  # of E_0's width: a sixth of a level


@pytest.fixture(scope="module")
def models():
    return load_synthesizer("builtin")


@pytest.fixture(scope="module")
def scene(models):
    """E_0, a sibling with a ladybug, and a level aside that was made over it."""
    root = reconstruct_scene(picture("grey"), 0, models, Quiet())
    camera = root.camera.zoomed_to_region(0.5, 0.5, 8.0)
    sibling = synthesize_level([root], 1, camera, "a huge red ladybug", 1, models, Quiet())
    aside = root.camera.zoomed_to_region(0.5 + ASIDE, 0.5, 8.0)
    report = Quiet()
    level = synthesize_level([root], 2, aside, "a tiny bee", 2, models, report, beside=[sibling])
    return SimpleNamespace(root=root, sibling=sibling, level=level, report=report)


def shared(scene):
    """The same place in both pictures, without the borders and without what was asked for later."""
    shift = round(8 * ASIDE * scene.root.camera.width)
    h, w = scene.root.image.shape[:2]
    rows, own = slice(h // 4, -h // 4), slice(w // 8, w // 2 - w // 8)
    return (rows, slice(own.start + shift, own.stop + shift)), (rows, own)


def red(image):
    return image[..., 0].astype(float) - image[..., 1:].max(-1)


def test_what_a_sibling_shows_is_in_the_new_picture(scene):
    theirs, own = shared(scene)
    before, after = scene.sibling.image[theirs].astype(float), scene.level.image[own].astype(float)
    assert (red(before) > 60).mean() > 0.25  # measured .346
    error = np.mean((before - after) ** 2)
    assert 10 * np.log10(255**2 / error) > 30.0  # measured 32.3


def test_it_is_in_the_first_preview(scene):
    theirs, own = shared(scene)
    before, first = scene.sibling.image[theirs], scene.report.levels[0].image[own]
    there = red(before) > 60
    assert (red(first)[there] > 40).mean() > 0.95  # measured 1.0


def test_it_stands_in_front_of_the_ground(scene, models):
    draft = preview_image(observe([scene.root], scene.level.camera, beside=[scene.sibling]), models, 0)
    bare = preview_image(observe([scene.root], scene.level.camera), models, 0)
    theirs, own = shared(scene)
    there = red(scene.sibling.image[theirs]) > 60
    assert np.median((bare.relief - draft.relief)[own][there]) > 8.0  # native px; measured 25
    assert (bare.relief - scene.level.relief)[own][there].mean() > 8.0  # measured 25


def test_a_deeper_level_finds_what_was_drawn_again(scene):
    (kept,) = scene.level.notes[BESIDE]
    assert [record["name"] for record in kept[PLACEMENTS]] == ["ladybug"]
    camera = scene.level.camera.zoomed_to_region(0.3, 0.4, 8.0)
    path = [scene.root, scene.level]
    extra = {"observation": SimpleNamespace(joined=(), overlay=None)}
    blank = np.zeros((4, 4), np.float32)
    draft = Draft(camera, scene.level.frame, path, blank, blank, blank > 0, extra=extra)
    groups = groups_in_view(draft)
    assert [g.placements[0].name for g in groups] == ["ladybug", "bee"]
    assert all(g.is_ancestral and g.factor == pytest.approx(8.0) for g in groups)
    np.testing.assert_allclose(groups[0].mapping, mapping_to(scene.sibling.camera, camera), atol=1e-6)
    groups = groups_in_view(replace(draft, path=[scene.root, scene.sibling, scene.level]))
    assert len(groups) == 2  # the ladybug once, though two levels tell of it


def test_objects_seen_from_another_place_are_not_where_they_were(scene):
    turned = orbited(scene.level.camera, scene.level.frame.origin, 0.2, 0.0)
    extra = {"observation": SimpleNamespace(joined=(scene.sibling,), overlay=None)}
    blank = np.zeros((4, 4), np.float32)
    draft = Draft(turned, scene.level.frame, [scene.root], blank, blank, blank > 0, extra=extra)
    assert groups_in_view(draft) == []
    assert len(groups_in_view(replace(draft, camera=scene.level.camera))) == 1


def test_a_sibling_out_of_view_changes_nothing(scene):
    camera = scene.root.camera.zoomed_to_region(0.2, 0.5, 8.0)
    one, two = (observe([scene.root], camera, beside=beside) for beside in ((), [scene.sibling]))
    assert two.overlay is None
    for name in ("image", "relief", "sky"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


def test_a_coarse_sibling_is_in_the_observation(scene):
    near = scene.root.camera.zoomed_to_region(0.5, 0.5, 20.0)
    seen, bare = observe([scene.root], near, beside=[scene.sibling]), observe([scene.root], near)
    assert seen.overlay is None
    assert seen.joined == (scene.sibling,)
    assert (red(seen.image) > 0.2).mean() > 0.4 > 0.1 > (red(bare.image) > 0.2).mean()  # measured .53, 0


def test_an_objects_hidden_part_stays_hidden():
    shape = (20, 30)
    relief = np.full(shape, np.nan, np.float32)
    relief[5:15, 5:25] = 0.0
    mask = np.isfinite(relief)
    picture = np.zeros((*shape, 3), np.float32)
    result = EditResult(picture + 1, relief, mask, mask.astype(np.float32), picture[..., 0])
    shown = np.full(shape, 0.0, np.float32)
    shown[:, 18:] = -50.0  # what the sibling shows there is nearer than the object
    overlay = Overlay((), picture, np.ones(shape, np.float32), shown)
    extra = {"observation": SimpleNamespace(overlay=overlay)}
    before = Draft(None, None, (), picture, np.zeros(shape, np.float32), np.zeros(shape, bool), extra=extra)
    part = Part(picture[5:15, 5:25] + 1, np.ones((10, 20), np.float32), relief[5:15, 5:25], (5, 5))
    flanks = Flanks(
        np.array([[[8.5, 8.5, 1.0], [20.5, 8.5, 1.0]]] * 3), picture[0, :2], np.ones(2, np.float32)
    )
    drawn = replace(before, image=result.image, ground=picture + 0.5, parts=(part,), flanks=(flanks,))
    cut = _Hidden.nothing(before).with_objects(result, 100.0).cut(drawn, before)
    assert (cut.image[8, 5:18] == 1).all()
    assert (cut.image[8, 18:25] == 0).all()
    assert np.isfinite(cut.parts[0].relief[:, :13]).all()
    assert np.isnan(cut.parts[0].relief[:, 13:]).all()
    assert len(cut.flanks[0].alpha) == 1
    same = _Hidden.nothing(before).with_objects(result, 400.0).cut(drawn, before)
    assert same is drawn  # 50 px are within the roughness of the ground under so large an object


def test_what_nobody_draws_again_stands_before_the_ground():
    shape = (40, 60)
    flat, picture = np.zeros(shape, np.float32), np.full((*shape, 3), 0.5, np.float32)
    card = np.zeros(shape, bool)
    card[10:30, 20:40] = True
    shown = np.where(card[..., None], np.float32(0.9), picture)
    overlay = Overlay((), shown, flat + 1, np.where(card, np.float32(-30), flat))
    stands = overlay.standing(flat)
    assert (stands == card).all()
    bare = Draft(None, None, (), picture, flat, card & False)
    extra = {"observation": SimpleNamespace(overlay=overlay), "bare": bare}
    extra |= {"stands": stands, "unshaded": shown}
    draft = replace(bare, image=shown, relief=np.where(card, overlay.relief, flat), extra=extra)
    found = _with_standing(draft)
    assert (found.image == shown).all()
    assert (found.ground == picture).all()
    assert (found.relief == 0).all()
    (part,) = found.parts
    (x, y), (h, w) = part.offset_px, part.alpha.shape
    assert (x, y, w, h) == (18, 8, 24, 24)  # with a soft rim of two pixels
    assert (part.alpha[2:-2, 2:-2] == 1).all()
    assert (part.relief == -30).all()
    specks = replace(draft, extra={**extra, "stands": np.eye(40, 60) > 0})
    assert _with_standing(specks) is specks
