"""Where the real shaders put a surfel, from its level's own x8^k zoom, against extended precision."""

import numpy as np
import pytest

from wzviewer.commands.bench_precision import fitted_centres, projection_error_px

LIMIT_PX = 0.02  # of the design; measured 4e-5 to level 10, 2e-4 at 11, 0.0024 at 12 (float64's own)


@pytest.mark.parametrize("level", [0, 3, 6, 9, 12])
@pytest.mark.parametrize("angle_deg", [0.0, 8.0])
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_a_splat_is_drawn_where_it_belongs(gl_context, level, angle_deg, rasterizer):
    assert projection_error_px(gl_context, level, angle_deg, rasterizer) < LIMIT_PX


def test_the_fit_finds_the_centre_of_a_gaussian_and_would_see_a_shift():
    y, x = np.mgrid[0:20, 0:20] + 0.5
    true = np.array([9.3, 10.8])
    alpha = 0.8 * np.exp(-((x - true[0]) ** 2 + (y - true[1]) ** 2) / (2 * 1.5**2))
    found = fitted_centres(alpha.astype(np.float32), true[None] + 0.4)[0]
    assert np.abs(found - true).max() < 1e-4  # measured 3e-08
    assert np.linalg.norm(found - (true + np.array([0.02, 0.0]))) > 0.019
