"""Stage 0 (Algorithm 1, line 1): depth of the single photo, in the frame of C_0."""

from collections.abc import Callable

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level
from wzviewer.core.types import ByteArray
from wzviewer.worker.draft import Draft
from wzviewer.worker.levels import preview_level
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.models.builtin.depth.estimator import depth_from_reading
from wzviewer.worker.models.builtin.detail.describe import below_sky

MEDIAN_DEPTH = 1.0  # the world unit: the median depth of E_0


def flat_draft(image: ByteArray, camera: Camera) -> Draft:
    """The photo as a plane at the median depth, until its depth is known."""
    frame = LevelFrame.of_camera(camera, MEDIAN_DEPTH)
    shape = image.shape[:2]
    pixels = image.astype(np.float32) / np.float32(255.0)
    return Draft(camera, frame, (), pixels, np.zeros(shape, np.float32), np.zeros(shape, bool))


def flat_scene(image: ByteArray, camera: Camera, seed: int) -> Level:
    """First revision of E_0: the photo as a plane."""
    return preview_level(flat_draft(image, camera), 0, None, "", seed)


def read_scene(
    image: ByteArray, camera: Camera, models: Synthesizer, seed: int, check: Callable[[], None]
) -> Draft:
    """Estimates depth and sky of a photo.

    Args:
        image: I_0, (h, w, 3) uint8 sRGB.
        camera: C_0.
        models: the backends.
        seed: of the level.
        check: raises `Cancelled`.

    Returns:
        The draft of E_0 with relief in native pixels about the anchor at median depth 1.
    """
    flat = flat_draft(image, camera)
    reading = models.depth.read(flat.image)
    check()
    depth = depth_from_reading(reading).astype(np.float64)
    relief = ((depth - MEDIAN_DEPTH) / flat.frame.unit).astype(np.float32)
    context = below_sky(models.detail.describe(flat.image, None, None), flat.image, reading.sky)
    notes = {"scene_kind": reading.kind}
    return Draft(camera, flat.frame, (), flat.image, relief, reading.sky, (), context, {}, notes)
