import numpy as np
import pytest

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.in_view import FRAME_MARGIN_PX, REACH_SIGMAS, surfels_in_view, warm_up
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels

CAMERA = Camera.initial(90, 60)
FRAME = LevelFrame.of_camera(CAMERA, 1.0)


def surfels():
    rng = np.random.default_rng(0)
    relief = rng.uniform(-30, 60, (60, 90)).astype(np.float32)
    found = generate_surfels(rng.random((60, 90, 3), np.float32), relief, CAMERA)
    return found.with_(scales=(found.scales * rng.uniform(0.1, 4, (len(found), 1))).astype(np.float32))


def in_view_by_definition(found, view, camera):
    with np.errstate(all="ignore"):
        points_px = view.project(found.means)
        reach_px = REACH_SIGMAS * found.scales.max(1) / np.exp2(view.log_scale(found.means))
        margin_px = FRAME_MARGIN_PX + reach_px[:, None]
        inside = (points_px > -margin_px) & (points_px < margin_px + np.array([camera.width, camera.height]))
    return np.flatnonzero(inside.all(1))


@pytest.mark.parametrize("factor", [1.0, 8.0, 512.0])
def test_a_zoom_sees_what_projects_into_it_or_reaches_it(factor):
    camera = CAMERA.zoomed_to_region(0.4, 0.6, factor)
    view, found = AnchoredView.expand(camera, FRAME), surfels()
    expected = in_view_by_definition(found, view, camera)
    assert len(expected) > 0
    assert np.array_equal(surfels_in_view(found, view, camera), expected)


def test_behind_the_camera_is_out_of_view():
    view, found = AnchoredView.expand(CAMERA, FRAME), surfels()
    behind = found.with_(means=found.means - np.array([0, 0, 3 * CAMERA.focal_px], np.float32))
    assert len(surfels_in_view(behind, view, CAMERA)) == 0


def test_arrays_that_are_shared_read_only_do_as_well():
    warm_up()
    view, found = AnchoredView.expand(CAMERA, FRAME), surfels()
    expected = surfels_in_view(found, view, CAMERA)
    for values in (found.means, found.scales):
        values.flags.writeable = False
    assert np.array_equal(surfels_in_view(found, view, CAMERA), expected)
