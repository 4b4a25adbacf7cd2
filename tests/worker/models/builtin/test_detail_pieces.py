"""Pieces that are split off: by what lies around them, or because the lens left them out of focus."""

import dataclasses

import cv2
import numpy as np

from wzviewer.worker.models.builtin.detail.blurs import out_of_focus, with_blurs
from wzviewer.worker.models.builtin.detail.clusters import Region
from wzviewer.worker.models.builtin.detail.folds import with_folds
from wzviewer.worker.models.builtin.detail.materials import MATERIALS

PLAIN = Region(0.5, 50, 0, 0, 0.3, 0.5, 0.8, 0.5, 0.5, 0.0)
NAMES = ("skin", "fibre", "plaster")


def sofa():
    """Leather with a narrow dark crease in it, and a broad board beside it."""
    labels = np.full((200, 400), 2, np.uint8)
    labels[:, :200] = 0
    labels[90:98, 40:160] = 1
    labels[40:160, 280:380] = 1
    return labels


def test_a_crease_in_leather_is_leather_and_a_board_is_wood():
    labels = with_folds(sofa(), NAMES)
    assert (labels[90:98, 40:160] == 0).all()
    assert (labels[40:160, 280:380] == 1).all()


def test_a_lath_on_a_wall_is_wood():
    labels = sofa()
    labels[90:98, 40:160] = 0
    labels[90:98, 220:260] = 1
    assert np.array_equal(with_folds(labels, NAMES), labels)


def test_without_leather_nothing_is_folded():
    assert np.array_equal(with_folds(sofa(), ("rock", "fibre", "plaster")), sofa())


def meadow_behind_a_flower():
    """Sharp speckled leaves on the left, on the right the same out of focus; labels and names of one kind."""
    rng = np.random.default_rng(3)
    leaves = 0.4 + 0.15 * rng.normal(0, 1, (240, 360)).astype(np.float32)
    leaves[:, 180:] = 0.4 + 6.0 * cv2.GaussianBlur(leaves - 0.4, (0, 0), 5.0)[:, 180:]
    image = np.clip(leaves[..., None] * np.float32((0.6, 1.0, 0.3)), 0, 1)
    return image, np.zeros((240, 360), np.uint8)


def test_what_is_out_of_focus_stays_so_and_what_is_sharp_grows():
    image, labels = meadow_behind_a_flower()
    leaf = dataclasses.replace(PLAIN, green_red=-15, blue_yellow=20, calm=0.2)
    found, regions, names = with_blurs(image, labels, (leaf,), ("foliage",))
    assert names == ("foliage", "blur")
    assert len(regions) == 2
    assert (found[20:-20, :150] == 0).all()
    assert (found[20:-20, 220:-20] == 1).mean() > 0.9  # measured 1.0
    assert with_blurs(image, labels, (leaf,), ("plaster",))[2] == ("plaster",)
    assert MATERIALS["blur"].closer == MATERIALS["sky"].closer


def test_what_has_no_forms_at_all_is_not_out_of_focus():
    flat = np.full((240, 360), 120, np.float32)
    flat[100:140] = 60  # a sharp edge
    assert not out_of_focus(flat).any()
