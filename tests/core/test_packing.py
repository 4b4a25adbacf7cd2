import numpy as np
import pytest

from tests.core.builders import random_surfels
from wzviewer.core.packing import PACKED_DTYPES, pack, rounded, unpack


def test_rounding_twice_is_rounding_once():
    surfels = random_surfels(50_000)
    quats = surfels.quats.copy()
    quats[:5000, 0] *= 1e-5  # half turns: w near 0, where rounding could leave the unit ball
    once = rounded(surfels.with_(quats=quats))
    twice = rounded(once)
    for name, array in once.arrays().items():
        np.testing.assert_array_equal(array, twice.arrays()[name], err_msg=name)


def test_rounding_errors_are_below_what_can_be_seen():
    surfels = random_surfels(10_000)
    packed = rounded(surfels)
    np.testing.assert_array_equal(packed.means, surfels.means)
    assert np.abs(packed.colors - surfels.colors).max() <= 0.5 / 255 + 1e-6
    # Measured 3.4e-4: half a step of float16 at log2 of one pixel.
    assert np.abs(packed.scales / surfels.scales - 1).max() < 2e-3
    dots = np.abs((packed.quats.astype(np.float64) * surfels.quats).sum(axis=1))
    # Measured 0.82 degrees, where w is near 0 and is what 16 bits of x, y, z leave of it.
    assert np.degrees(2 * np.arccos(np.minimum(dots, 1))).max() < 1.0


def test_a_surfel_takes_26_bytes():
    assert sum(np.dtype(d).itemsize * n for d, n in PACKED_DTYPES.values()) == 26


@pytest.mark.parametrize("name", sorted(PACKED_DTYPES))
def test_a_missing_or_mistyped_array_is_refused(name):
    packed = pack(random_surfels(4))
    ones = np.ones(4, np.float32)
    for broken in (
        {**packed, name: packed[name].astype(np.float64)},
        {k: v for k, v in packed.items() if k != name},
    ):
        with pytest.raises(ValueError, match=r"surfel array"):
            unpack(broken, ones, ones)


def test_values_that_are_not_finite_are_refused():
    packed = pack(random_surfels(4))
    packed["means"][2, 1] = np.nan
    with pytest.raises(ValueError, match="finite"):
        unpack(packed, np.ones(4, np.float32), np.ones(4, np.float32))
