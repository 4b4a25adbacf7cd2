"""Stage 3, lines 23-25 of Algorithm 1: surfels with s_native = d_native / sqrt(fx fy)."""

from collections.abc import Iterable

from wzviewer.core.camera import Camera
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray
from wzviewer.kernels.lifting import lift


def generate_surfels(
    image: FloatArray, relief: FloatArray, camera: Camera, layers: Iterable[Surfels] = ()
) -> Surfels:
    """InitializeSurfels of Algorithm 1 (lines 23-25): one surfel per pixel of the new-scale image.

    Args:
        image: I_{i+1}, (h, w, 3) float32 sRGB.
        relief: D_{i+1} in native pixels from the level's anchor, (h, w) float32; nan gives no surfel.
        camera: C_{i+1}.
        layers: further surfels in the same frame, such as those behind depth edges; appended in order.

    Returns:
        The pixel-aligned surfels (see `core.lift`), then those of the layers.
    """
    return Surfels.concatenate([lift(image, relief, camera), *layers])
