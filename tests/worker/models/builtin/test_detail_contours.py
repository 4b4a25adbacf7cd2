"""Faint contours become steep, within what the coarser picture could have missed."""

import numpy as np
import pytest

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.consistency import psnr_db
from wzviewer.worker.models.builtin.detail.contours import supposed, with_steeper
from wzviewer.worker.models.builtin.detail.measures import area_down, blurred


def _bars(low: float, high: float, grow: int = 1) -> FloatArray:
    """A soft lattice of bars, contours about four coarse px wide, ``(90 grow, 136 grow, 3)``."""
    x, y = np.meshgrid(np.arange(136 * grow) // grow, np.arange(90 * grow) // grow)
    bars = ((x % 34 < 12) | (y % 30 < 9)).astype(np.float32)
    plane = blurred((low + (high - low) * bars).astype(np.float32), 1.3 + 0.5 * grow)
    return np.repeat(plane[..., None], 3, 2)


def _steepest(image: FloatArray) -> float:
    return float(np.abs(np.diff(image[..., 1], axis=1)).max())


def test_faint_contours_of_metal_are_cut() -> None:
    murk = _bars(35, 60)
    labels = np.zeros(murk.shape[:2], np.uint8)
    cut = supposed(murk, labels, ("cast",))
    assert _steepest(cut) > 1.6 * _steepest(murk)  # 2.0 times
    assert psnr_db(cut, murk) > 45.5  # 45.9


def test_what_a_lens_made_soft_stays_soft() -> None:
    murk = _bars(35, 60)
    labels = np.zeros(murk.shape[:2], np.uint8)
    labels[:, 68:] = 1
    seen = supposed(murk, labels, ("air", "cast"))
    assert np.allclose(seen[:, :68], murk[:, :68])
    assert np.abs(seen[:, 68:] - murk[:, 68:]).max() > 2


@pytest.mark.parametrize(("high", "least", "most"), [(65, 2.5, 5.0), (230, 0.9, 1.4)])  # 3.5, 1.15
def test_strong_contours_are_left_to_the_base(high: float, least: float, most: float) -> None:
    base = _bars(20, high, grow=8)
    made = with_steeper(base, area_down(base, 136, 90), np.ones(base.shape[:2], np.float32))
    assert least < _steepest(made) / _steepest(base) < most
