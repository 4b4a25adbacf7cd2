import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.layers import Surface
from wzviewer.worker.models.builtin.views.smoothing import dilated
from wzviewer.worker.models.builtin.views.underlay import STRIDE_PX, underlay

SIZE = 192
FAR_PX = 60.0
AXIS = DepthAxis.of(Camera.initial(SIZE, SIZE, 180.0))


def scene(sky=False):
    """A red thing before a green ground, the layer behind it, and where that has been painted and kept."""
    near = np.zeros((SIZE, SIZE), bool)
    near[48:144, 48:144] = True
    relief = np.where(near, -80.0, FAR_PX).astype(np.float32)
    image = np.where(near[..., None], np.float32([0.8, 0.1, 0.1]), np.float32([0.1, 0.6, 0.2]))
    front = Surface(image.astype(np.float32), AXIS.shift_of(relief), relief, np.zeros_like(near))
    rim = near & dilated(~near, 16)
    ground = np.full((SIZE, SIZE), FAR_PX, np.float32)
    color = np.where(rim[..., None], np.float32([0.1, 0.6, 0.2]), image).astype(np.float32)
    shift = np.where(rim, AXIS.shift_of(ground), front.shift).astype(np.float32)
    layer = Surface(color, shift, np.where(rim, ground, relief), rim & sky)
    return front, layer, rim, rim & dilated(~near, 8), near


def test_it_goes_on_where_the_layer_ends_behind_it_and_like_it():
    front, layer, painted, kept, near = scene()
    made = underlay(front, layer, painted, kept, (0, 0), AXIS)
    covered = np.kron(made.mask, np.ones((STRIDE_PX, STRIDE_PX), bool))
    assert made.stride == STRIDE_PX
    assert covered[72:120, 56:66].mean() > 0.9  # measured: 1.0; from the kept rim on
    assert not covered[~near].any()
    color = made.image[made.mask]
    assert np.abs(color - [0.1, 0.6, 0.2]).max() < 0.02  # measured: 2e-8
    assert made.relief[made.mask].min() > FAR_PX
    assert made.relief[made.mask].max() < FAR_PX + 3  # measured: 1.0


def test_sky_is_not_continued_and_nothing_hidden_is_nothing():
    front, layer, painted, kept, _ = scene(sky=True)
    assert not underlay(front, layer, painted, kept, (0, 0), AXIS).mask.any()
    nothing = np.zeros_like(painted)
    assert not underlay(front, layer, nothing, nothing, (0, 0), AXIS).mask.any()
