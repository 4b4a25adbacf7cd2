import numpy as np

from tests.core.builders import random_surfels
from wzviewer.core.reference import surfel_axes
from wzviewer.gl.records import RECORD_BYTES, RECORD_DTYPE, footprint_quats, pack, unpack


def covariances(surfels):
    t1, t2 = (t.astype(np.float64) for t in surfel_axes(surfels.quats.astype(np.float64)))
    a, b = t1 * surfels.scales[:, :1], t2 * surfels.scales[:, 1:]
    return a[:, :, None] * a[:, None] + b[:, :, None] * b[:, None]


def test_a_record_has_32_bytes_at_aligned_offsets():
    offsets = {name: RECORD_DTYPE.fields[name][1] for name in RECORD_DTYPE.names}
    assert RECORD_BYTES == 32
    assert offsets == {"mean": 0, "quat_opacity": 12, "logs_coverage": 20, "color_slot": 28}


def test_a_turned_quaternion_draws_the_same_footprint():
    surfels = random_surfels(500, seed=1)
    turned = footprint_quats(surfels.quats)
    assert (turned[:, 0] >= 0.5 - 1e-6).all()
    np.testing.assert_allclose(
        covariances(surfels.with_(quats=turned)), covariances(surfels), atol=1e-5
    )  # measured 4e-8


def test_records_keep_what_a_footprint_needs():
    surfels = random_surfels(500, seed=2)
    surfels = surfels.with_(coverage=np.linspace(0, 1, 500), native_scales=np.geomspace(0.1, 40, 500))
    back = unpack(pack(surfels, slot=255))
    np.testing.assert_array_equal(back.means, surfels.means)
    np.testing.assert_allclose(back.opacities, surfels.opacities, atol=2e-5)  # half a step: 1.5e-5
    np.testing.assert_allclose(back.colors, surfels.colors, atol=0.00197)  # half a step of 1/255
    np.testing.assert_allclose(back.scales, surfels.scales, rtol=4e-4)  # measured 3.4e-4
    np.testing.assert_allclose(back.native_scales, surfels.native_scales, rtol=1.4e-3)  # measured 1.3e-3
    np.testing.assert_allclose(back.coverage, surfels.coverage, atol=2.5e-4)  # half a step of float16
    relative = np.abs(covariances(back) - covariances(surfels)).max((1, 2)) / surfels.scales.max(1) ** 2
    assert relative.max() < 1e-3  # measured 5.3e-4, from the scales


def test_surfels_that_face_the_camera_lose_nothing():
    """W of their quaternion is about 0, where sqrt(1 - |xyz|^2) would be off by 0.005."""
    surfels = random_surfels(200, seed=3)
    tilt = np.radians(np.linspace(0, 80, 200)) / 2
    quats = np.stack([np.sin(tilt) * 1e-3, np.cos(tilt), np.sin(tilt), 0 * tilt], 1)
    surfels = surfels.with_(quats=quats / np.linalg.norm(quats, axis=1, keepdims=True))
    t1 = surfel_axes(unpack(pack(surfels, 0)).quats.astype(np.float64))[0].astype(np.float64)
    true = surfel_axes(surfels.quats.astype(np.float64))[0].astype(np.float64)
    assert np.abs(np.abs((t1 * true).sum(1)) - 1.0).max() < 1e-7  # cosine of the angle between the axes


def test_zeros_and_extremes_are_finite():
    surfels = random_surfels(3).with_(
        quats=np.zeros((3, 4)), scales=np.zeros((3, 2)), native_scales=np.zeros(3)
    )
    back = unpack(pack(surfels, 0))
    assert all(np.isfinite(a).all() for a in back.arrays().values())
