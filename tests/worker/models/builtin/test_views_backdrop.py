"""The layer behind everything: where it reaches, how deep, and of which colours."""

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.backdrop import STRIDE_PX, backdrop
from wzviewer.worker.models.builtin.views.layers import Surface
from wzviewer.worker.models.builtin.views.outpaint import Canvas

WIDTH, HEIGHT, PAD = 192, 128, (32, 16)
AXIS = DepthAxis.of(Camera.initial(WIDTH, HEIGHT, 200.0))
BLUE, RED = np.float32([0.2, 0.4, 0.9]), np.float32([0.9, 0.1, 0.1])


def canvas():
    """A near red box in the middle before a blue wall, with a pad."""
    shape = (HEIGHT + 2 * PAD[1], WIDTH + 2 * PAD[0])
    inside = np.zeros(shape, bool)
    inside[PAD[1] : -PAD[1], PAD[0] : -PAD[0]] = True
    box = np.zeros(shape, bool)
    box[40:120, 80:176] = True
    relief = np.where(box, -60.0, 300.0).astype(np.float32)
    image = np.where(box[..., None], RED, BLUE).astype(np.float32)
    return Canvas(Surface(image, AXIS.shift_of(relief), relief, np.zeros(shape, bool)), inside, PAD)


def test_it_reaches_a_frame_beyond_the_frame():
    layer = backdrop(canvas(), AXIS)
    x0, y0 = layer.offset_px
    height, width = layer.mask.shape
    assert layer.stride == STRIDE_PX
    assert (x0, y0) == (-WIDTH, -HEIGHT)
    assert x0 + width * STRIDE_PX >= 2 * WIDTH
    assert y0 + height * STRIDE_PX >= 2 * HEIGHT
    assert layer.mask.all()


def test_it_lies_behind_the_farthest():
    layer = backdrop(canvas(), AXIS)
    assert (layer.relief > 300.0).all()
    assert np.isfinite(layer.relief).all()


def test_it_has_the_colours_of_the_background_everywhere():
    layer = backdrop(canvas(), AXIS)
    assert np.abs(layer.image - BLUE).max() < 0.02  # measured 1e-6; the box would be off by 0.8
