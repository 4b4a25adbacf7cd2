"""Hidden surfels of coarser levels go on to finer ones: which, where, and how they look."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift
from wzviewer.core.navigation import orbited
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels, turned
from wzviewer.worker.draft import Draft
from wzviewer.worker.inherited import hidden_surfels
from wzviewer.worker.levels import preview_level
from wzviewer.worker.rasterize import LevelPart, render

WIDTH, HEIGHT = 96, 64
GREEN, RED = np.float32([0.1, 0.8, 0.1]), np.float32([0.9, 0.1, 0.1])
FRONT, BACK = 0.0, 30.0  # relief of the two walls, native px of the parent


def wall(camera, color, relief, columns=WIDTH):
    image = np.broadcast_to(color, (HEIGHT, WIDTH, 3)).astype(np.float32)
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[:, :columns] = True
    return lift(np.ascontiguousarray(image), np.full((HEIGHT, WIDTH), relief, np.float32), camera, None, mask)


def parent():
    """A green wall over the left three quarters of the view, a red one behind all of it."""
    camera = Camera.initial(WIDTH, HEIGHT, 100.0)
    surfels = Surfels.concatenate([wall(camera, GREEN, FRONT, WIDTH * 3 // 4), wall(camera, RED, BACK)])
    view_scales = np.ones(len(surfels), np.float32)
    frame = LevelFrame.of_camera(camera, 1.0)
    surfels = surfels.with_(coverage=view_scales)
    relief = np.where(np.arange(WIDTH) < WIDTH * 3 // 4, FRONT, BACK) * np.ones((HEIGHT, 1))
    image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    return Level(0, None, camera, frame, surfels, image, relief.astype(np.float32))


@pytest.fixture(scope="module")
def made():
    """What a child four times closer inherits; the edge of the green wall is in its right half."""
    root = parent()
    camera = root.camera.zoomed_to_region(0.65, 0.5, 4.0)
    frame = LevelFrame.of_camera(camera, 1.0)
    edge = WIDTH * 3 // 4 / WIDTH
    right = (edge - 0.65) * 4.0 + 0.5
    own = np.where((np.arange(WIDTH) + 0.5) / WIDTH < right, 4.0 * FRONT, 4.0 * BACK) * np.ones((HEIGHT, 1))
    observed = own[::4, ::4].astype(np.float32)
    blank = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    draft = Draft(camera, frame, [root], blank, own.astype(np.float32), np.zeros((HEIGHT, WIDTH), bool))
    return root, draft, hidden_surfels(draft, observed), right


def test_only_what_is_hidden_is_taken(made):
    _, draft, hidden, right = made
    assert len(hidden) > 100
    assert np.abs(hidden.colors - RED).max() < 1e-6
    share = AnchoredView.expand(draft.camera, draft.frame).project(hidden.means)[:, 0] / WIDTH
    assert share.min() >= 0.0
    assert share.max() < right + 0.02
    assert (share < right - 0.1).sum() > 0.8 * len(hidden)


def test_they_stay_where_they_are_and_as_they_look(made):
    root, draft, hidden, _ = made
    world = draft.frame.to_world(hidden.means)
    np.testing.assert_allclose(world[:, 2], 1.0 + BACK / 100.0, atol=1e-6)  # measured 3e-8
    aside = replace(draft.camera, cx=draft.camera.cx + 7.3)
    ours = render([LevelPart.of(hidden, draft.frame)], aside).color
    red = root.surfels.take(root.surfels.colors[:, 0] > 0.5)
    theirs = render([LevelPart.of(red, root.frame)], aside).color
    inner = np.s_[8:-8, 16:40]  # away from where the inherited ones end
    assert np.abs(ours[inner] - theirs[inner]).max() < 1e-3  # measured 2e-6


def test_their_native_scale_is_the_childs(made):
    _, draft, hidden, _ = made
    expected = np.exp2(AnchoredView.expand(draft.camera, draft.frame).log_scale(hidden.means))
    np.testing.assert_array_equal(hidden.native_scales, expected)


def test_nothing_is_taken_where_nothing_was_seen(made):
    _, draft, _, _ = made
    nothing = np.full((HEIGHT // 4, WIDTH // 4), np.nan, np.float32)
    assert len(hidden_surfels(draft, nothing)) == 0


@pytest.mark.parametrize(("gap_px", "is_taken"), [(8.0, False), (16.0, True)])
def test_what_is_just_behind_the_new_surface_is_that_surface(made, gap_px, is_taken):
    _, draft, _, _ = made
    before = replace(draft, relief=np.full((HEIGHT, WIDTH), 4.0 * BACK - gap_px, np.float32))
    front = np.full((HEIGHT // 4, WIDTH // 4), 4.0 * FRONT, np.float32)
    assert (len(hidden_surfels(before, front)) > 0) is is_taken  # 3 px of the parent are 12 of the child


@pytest.mark.parametrize(("steepness", "is_taken"), [(0.5, True), (3.0, False)])
def test_behind_a_slope_a_coarse_surfel_would_stick_out(made, steepness, is_taken):
    _, draft, _, _ = made
    slope = steepness * (np.mgrid[:HEIGHT, :WIDTH][0] - HEIGHT).astype(np.float32)
    before = replace(draft, relief=slope + np.float32(4.0 * BACK - 30.0))
    front = np.full((HEIGHT // 4, WIDTH // 4), 4.0 * FRONT, np.float32)
    low = hidden_surfels(before, front)  # the surfels in the lowest rows are 30 to 40 px behind it
    row = AnchoredView.expand(draft.camera, draft.frame).project(low.means)[:, 1]
    assert (row > HEIGHT - 6).any() is np.bool_(is_taken)


def test_quaternions_turn_with_their_frame():
    rng = np.random.default_rng(0)
    for _ in range(20):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        rotation *= np.sign(np.linalg.det(rotation))
        quats = rng.normal(size=(5, 4))
        quats /= np.linalg.norm(quats, axis=1, keepdims=True)
        for before, after in zip(quats, turned(rotation, quats), strict=True):
            np.testing.assert_allclose(matrix(after), rotation @ matrix(before), atol=1e-6)  # measured 3e-7
    half_turn = np.diag([1.0, -1.0, -1.0])
    np.testing.assert_allclose(matrix(turned(half_turn, quats)[0]), half_turn @ matrix(quats[0]), atol=1e-6)


def matrix(q):
    w, x, y, z = np.asarray(q, np.float64)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_preview_shows_what_is_behind_it_from_the_side(made):
    root, draft, hidden, _ = made
    blue, observed = (0.0, 0.0, 1.0), SimpleNamespace(relief=draft.relief[::4, ::4])
    camera = orbited(draft.camera, draft.frame.origin, np.radians(-8.0), 0.0)
    gaps = []
    for extra in ({}, {"observation": observed}):
        level = preview_level(replace(draft, extra=extra), 1, root.index, "", 0)
        color = render([LevelPart.of(level.surfels, level.frame)], camera, blue).color
        gaps.append(float((color[..., 2] > 0.5).mean()))
    assert len(level.surfels) == WIDTH * HEIGHT // 4 + len(hidden)
    assert gaps[0] > 0.05  # measured 0.094, beside the green wall
    assert gaps[1] < 0.001  # measured 0
