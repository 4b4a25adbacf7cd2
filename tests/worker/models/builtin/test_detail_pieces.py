"""Pieces that are known by what lies around them."""

import numpy as np

from wzviewer.worker.models.builtin.detail.folds import with_folds

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
