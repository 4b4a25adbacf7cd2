"""What drifts in air and water: faint, of the place's size, and not the same twice."""

import numpy as np
import pytest

from wzviewer.worker.models.builtin.detail.drifts import STRENGTHS, drifting


@pytest.mark.parametrize("name", sorted(STRENGTHS))
def test_drifts_are_faint_and_deterministic(name: str) -> None:
    first, again, other = (drifting(name, 90, 136, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first is not None
    assert other is not None
    assert first.shape == (90, 136)
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.3  # 0.05 at most
    assert 0.5 < first.std() / STRENGTHS[name] < 1.5  # 0.96 to 1.02


def test_nothing_drifts_in_stone() -> None:
    assert drifting("granite", 90, 136, np.random.default_rng(1)) is None
