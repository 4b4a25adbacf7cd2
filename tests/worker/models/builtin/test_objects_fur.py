"""Fur: where hairs are rooted, which way they lie, and what the coat looks like from near and far."""

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.bodies import Tint
from wzviewer.worker.models.builtin.objects.coats import Coat
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Support
from wzviewer.worker.models.builtin.objects.inserting import body_of, setting_of
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.primitives import CONE, ELLIPSOID
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import render, render_mask
from wzviewer.worker.models.builtin.objects.roots import Skin, rooted

W, H, CLOSE = 240, 160, 4000.0
EDITOR = ObjectEditor()
SIDE = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # from the cat's right


@pytest.fixture(scope="module")
def cat():
    return body_of("cat", 3, Tint())


def flat_support():
    return Support(np.zeros((H, W), np.float32), 8192.0)


@pytest.fixture(scope="module")
def inserted():
    return EDITOR.apply(EDITOR.parse("a huge cat"), np.full((H, W, 3), 0.5, np.float32), flat_support(), 1)


def plane_of(pose, x0, x1):
    """A flat piece of coat that faces the view, sampled once a pixel."""
    x, y = np.meshgrid(np.arange(x0, x1) + 0.5, np.arange(100) + 0.5)
    q = np.stack([x - pose.position[0], y - pose.position[1], 5.0 + 0 * x], -1).reshape(-1, 3)
    points = q @ pose.camera_from_object / pose.size_px
    normals = np.broadcast_to(-pose.camera_from_object[2], points.shape).copy()
    part = np.zeros(len(points), np.int64)
    return Skin(points, normals, part, np.ones((len(points), 3), np.float32), 1.0)


def test_a_root_is_where_it_is_from_every_view(cat):
    coat = Coat.of(cat)
    first = Pose(SIDE, CLOSE, (70.0, 90.0, 0.0))
    moved = Pose(SIDE, CLOSE, (50.3, 90.0, 0.0))
    a = rooted(coat, first, [plane_of(first, 0, 120)], 11).points
    b = rooted(coat, moved, [plane_of(moved, 0, 120)], 11).points
    inner = (a[:, 1] < (70 - 25) / CLOSE) & (a[:, 1] > (70 - 115) / CLOSE)  # seen by both
    near = np.linalg.norm(a[inner, None] - b[None], axis=2).min(1)
    assert inner.sum() > 200  # measured 298
    assert (near < 1e-6).mean() > 0.93  # measured .96: roots between two pixels are missed by one view


def test_it_lies_away_from_the_nose_down_the_legs_and_along_the_tail(cat):
    coat = Coat.of(cat)
    legs = cat.primitives[(cat.primitives[:, 0] == CONE) & (cat.primitives[:, 17] < 0.07) & coat.furry]
    assert len(legs) >= 2
    cheek, rump = np.array([[0.13, 0.20, 0.68]]), np.array([[0.0, -0.34, 0.25]])
    assert coat.lie(cheek, np.array([[1.0, 0.0, 0.0]]))[0, 1] < -0.5
    assert coat.lie(rump, np.array([[0.0, -1.0, 0.0]]))[0, 2] < -0.9
    shin = np.array([[0.075 + 0.05, 0.17, 0.20]])
    assert coat.lie(shin, np.array([[1.0, 0.0, 0.0]]))[0, 2] < -0.95


def test_hairs_are_short_in_the_face_and_never_longer_than_their_part_is_thick(cat):
    coat = Coat.of(cat)
    body = np.flatnonzero(coat.lengths == coat.lengths.max())[:1]
    face, back = np.array([[0.03, 0.31, 0.70]]), np.array([[0.0, -0.2, 0.4]])
    assert coat.length_at(face, body)[0] < 0.35 * coat.length_at(back, body)[0]
    toes = coat.primitives[:, 16:19].min(1) < 0.016
    assert (coat.lengths[toes & (coat.primitives[:, 0] == ELLIPSOID)] < 0.016).all()


def test_hairs_stand_out_past_the_outline(inserted):
    (placed,) = inserted.placements
    mask, _ = render_mask(Scene(body_of("cat", placed.seed, placed.tint), placed.pose, W, H))
    away = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5)
    beyond = (inserted.alpha > 0.25) & (away > 1.5)
    assert beyond.sum() > 40  # measured 210; a bare body has none
    assert away[beyond].max() < 0.06 * placed.pose.size_px  # measured .024: a hair's length is .05


def turned(image):
    """The direction of least change of a picture, as a doubled angle, and how marked it is."""
    luma = cv2.GaussianBlur(image.mean(2), (0, 0), 1.0)
    x, y = cv2.Sobel(luma, cv2.CV_32F, 1, 0), cv2.Sobel(luma, cv2.CV_32F, 0, 1)
    xx, xy, yy = (cv2.GaussianBlur(v, (0, 0), 8) for v in (x * x, x * y, y * y))
    return np.arctan2(2 * xy, xx - yy), np.hypot(xx - yy, 2 * xy) / (xx + yy + 1e-9)


def closer(result, x, y, factor=8.0):
    """The picture at a level `factor` closer about a place, and the parent's picture enlarged to it."""
    x0, y0 = x - W / 2 / factor, y - H / 2 / factor
    m = np.array([[factor, 0, (0.5 - x0) * factor - 0.5], [0, factor, (0.5 - y0) * factor - 0.5]])
    large = cv2.warpAffine(result.image, m, (W, H), flags=cv2.INTER_CUBIC)
    relief = np.where(result.object_mask, result.object_relief, 0).astype(np.float32)
    support = Support(cv2.warpAffine(relief, m, (W, H)) * np.float32(factor), 8192.0 * factor)
    large = np.clip(large, 0, 1).astype(np.float32)
    return EDITOR.continue_into(result.placements, (x0, y0, factor), large, support, 1), large


@pytest.fixture(scope="module")
def flank(inserted):
    rows, columns = np.nonzero(inserted.alpha > 0.99)
    return closer(inserted, np.percentile(columns, 65), np.percentile(rows, 60))


def test_a_closer_level_shows_lines_and_no_crumbs(flank):
    finer, large = flank
    _, marked = turned(finer.image)
    assert np.median(marked[finer.object_mask]) > 0.6  # measured .83; white noise has .10
    fine = np.std(finer.image - cv2.GaussianBlur(finer.image, (0, 0), 2.0))
    assert fine > 10 * np.std(large - cv2.GaussianBlur(large, (0, 0), 2.0))  # measured 45 times


def test_shrunk_it_is_what_the_parent_showed(flank):
    finer, large = flank
    size = (W // 8, H // 8)
    a, b = (cv2.resize(i, size, interpolation=cv2.INTER_AREA) for i in (finer.image, large))
    assert np.abs(a - b).mean() < 0.008  # measured .0023


def test_the_coat_keeps_its_mean_colour(inserted):
    (placed,) = inserted.placements
    body = body_of("cat", placed.seed, placed.tint)
    furry, bare, again = (
        render(Scene(body, placed.pose, W, H, furred=grows), setting_of(placed, body))
        for grows in (True, False, True)
    )
    inside = bare.alpha > 0.99
    means = [np.sqrt(layer.color[inside]).mean(0) for layer in (furry, bare)]
    np.testing.assert_allclose(means[0], means[1], rtol=0.03)  # measured .995 of it
    assert np.array_equal(furry.color, again.color)


@pytest.mark.parametrize("prompt", ["a golden cat", "a wooden cat", "a marble cat"])
def test_what_is_cast_or_carved_has_no_hairs(prompt):
    (request,) = EDITOR.parse(prompt).objects
    assert not Coat.of(body_of("cat", 3, request.tint)).furry.any()


@pytest.mark.parametrize("name", ["bee", "spider"])
def test_furry_insects_wear_it_too(name):
    assert Coat.of(body_of(name, 3, Tint())).furry.any()
