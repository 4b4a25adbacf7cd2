import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.hidden_sky import calm_sky
from wzviewer.worker.models.builtin.views.layers import far_as_sky
from wzviewer.worker.models.builtin.views.synthesizer import ViewSynthesizer

SIZE, SKY_RELIEF = 160, 5000.0


def stalk_before_clouds() -> tuple[np.ndarray, np.ndarray, np.ndarray, Camera]:
    """A broad dark stalk before a sky of hard-edged white and blue stripes; one fringe pixel is near."""
    image = np.empty((SIZE, SIZE, 3), np.float32)
    image[:] = (0.35, 0.5, 0.8)
    image[(np.arange(SIZE) // 20) % 2 == 0] = 0.95
    image[:, 60:100] = (0.15, 0.1, 0.05)
    sky = np.ones((SIZE, SIZE), bool)
    sky[:, 60:100] = False
    relief = np.where(sky, np.float32(SKY_RELIEF), np.float32(-20.0))
    relief[:, 59] = -20.0
    return image, relief.astype(np.float32), sky, Camera.initial(SIZE, SIZE, 150.0)


def test_the_hidden_sky_has_no_edges():
    image, relief, sky, camera = stalk_before_clouds()
    layers = ViewSynthesizer().complete(image, relief, sky, camera, outside=True).layers
    behind = next(la for la in layers if la.stride == 1 and la.mask.sum() > 1500 and la.offset_px[0] > 0)
    inner = behind.mask.copy()
    inner[:, :6] = inner[:, -6:] = False
    steps = np.abs(np.diff(behind.image, axis=0)).max(-1)[inner[1:] & inner[:-1]]
    assert steps.max() < 0.15  # measured: 0.087; the stripes that are seen differ by 0.6
    assert (behind.relief[behind.mask] > 0.9 * SKY_RELIEF).all()


def test_without_a_field_nothing_changes():
    image, _, sky, _ = stalk_before_clouds()
    assert calm_sky(image, ~sky, sky, None) is image


def test_colours_of_the_field_show_with_faint_clouds_only():
    image, _, sky, _ = stalk_before_clouds()
    field = np.full_like(image, 0.5)
    calm = calm_sky(image, ~sky, sky, field)
    assert np.array_equal(calm[sky], image[sky])
    assert np.abs(calm[~sky] - 0.5).max() <= 0.0251  # the limit of clouds, CLOUD_LIMIT


def test_a_little_nearer_than_the_sky_is_the_sky_still():
    axis = DepthAxis.of(Camera.initial(SIZE, SIZE, 150.0))
    reliefs = np.array([SKY_RELIEF, 0.8 * SKY_RELIEF, 0.3 * SKY_RELIEF, -20.0], np.float32)
    shifts = axis.shift_of(reliefs)
    assert far_as_sky(shifts, shifts[:1], axis).tolist() == [True, True, False, False]


def test_a_deep_levels_coarse_label_gives_way_to_its_depth():
    image, relief, sky, camera = stalk_before_clouds()
    deep = camera.zoomed_to_region(0.5, 0.5, 64.0)
    relief = relief * 64
    relief[:, 100:116] = 0.9 * 64 * SKY_RELIEF  # the sky's own blurred border
    relief[:, 116:132] = -20.0
    image[:, 116:132] = image[0, 60]
    sky[:, 100:140] = True  # over the border of the stalk
    complete = ViewSynthesizer().complete(image, relief.astype(np.float32), sky, deep, outside=False)
    assert (complete.relief[:, 120] == -20.0).all()  # not laid at the sky's depth
    assert np.allclose(complete.relief[10::20, 108], 64 * SKY_RELIEF, rtol=1e-3)
