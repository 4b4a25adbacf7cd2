"""Which surfels of a level a camera may see: one compiled pass, since a zoom looks at one in fifty."""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from wzviewer.core.anchor import DEPTH_FLOOR, AnchoredView
from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.kernels.elementary import KERNELS

REACH_SIGMAS = 3.5  # of a surfel seen face on; those of a coarse level reach hundreds of pixels
FRAME_MARGIN_PX = 8.0  # more, for the low-pass and for what perspective stretches


def surfels_in_view(surfels: Surfels, view: AnchoredView, camera: Camera) -> NDArray[np.int64]:
    """Indices (m,) of the surfels that reach into a camera's image, in order.

    Args:
        surfels: of one level.
        view: the camera, expanded about the level's anchor.
        camera: the same.
    """
    near = np.empty(len(surfels), np.bool_)
    with KERNELS:
        _reach_in(surfels.means, surfels.scales, view.rows, view.side, camera.width, camera.height, near)
    return np.flatnonzero(near)


@njit(cache=True, nogil=True, parallel=True)
def _reach_in(
    means: FloatArray,
    scales: FloatArray,
    rows: DoubleArray,
    side: float,
    width: int,
    height: int,
    near: BoolArray,
) -> None:
    """Sets near (n,): the projected centre (`AnchoredView.project`) is in the image or within reach of it."""
    for i in prange(means.shape[0]):
        x, y, z = np.float64(means[i, 0]), np.float64(means[i, 1]), np.float64(means[i, 2])
        ratio = 1.0 + rows[2, 0] * x + rows[2, 1] * y + rows[2, 2] * z
        if ratio * side <= DEPTH_FLOOR:
            near[i] = False
            continue
        u = (rows[0, 0] * x + rows[0, 1] * y + rows[0, 2] * z) / ratio + rows[0, 3]
        v = (rows[1, 0] * x + rows[1, 1] * y + rows[1, 2] * z) / ratio + rows[1, 3]
        scale = 2.0 ** rows[2, 3] * ratio * side
        margin = FRAME_MARGIN_PX + REACH_SIGMAS * max(scales[i, 0], scales[i, 1]) / scale
        near[i] = -margin < u < width + margin and -margin < v < height + margin


def warm_up() -> None:
    """Compiles the pass, or loads it from the cache, for arrays of this process and for shared ones."""
    near = np.empty(1, np.bool_)
    for writable in (True, False):
        means, scales = np.zeros((1, 3), np.float32), np.ones((1, 2), np.float32)
        means.flags.writeable = scales.flags.writeable = writable
        with KERNELS:
            _reach_in(means, scales, np.ones((3, 4)), 1.0, 8, 8, near)
