"""Scenes for the benches, made of the demo picture; no generation, so that they are quick to make."""

import cv2
import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.assembly import finished
from wzviewer.core.assets import demo_picture
from wzviewer.core.camera import Camera
from wzviewer.core.lift import lift
from wzviewer.core.photos import load_photo
from wzviewer.core.scene import Level, Scene, coverage_for
from wzviewer.core.types import ByteArray, FloatArray

PLANE_DEPTH = 1.0  # of all levels, world units
DETAIL_LIMIT = 30.0  # standard deviation of an image, grey levels
CENTRE = (0.53, 0.47)  # of every zoom; off the middle, so that nothing cancels by symmetry


def chain_scene(num_levels: int, image: ByteArray | None = None, relief_px: float = 20.0) -> Scene:
    """Levels x8 apart, each a full grid of surfels with gentle relief.

    Args:
        num_levels: including the root.
        image: colours, (h, w, 3) uint8; the demo picture by default.
        relief_px: amplitude of the relief in native pixels.
    """
    image = load_photo(demo_picture()) if image is None else image
    scene = Scene()
    camera = Camera.initial(image.shape[1], image.shape[0])
    relief = _waves(image.shape[0], image.shape[1], relief_px)
    for index in range(num_levels):
        parent = index - 1 if index else None
        scene.append(grid_level(scene, parent, camera, image, relief))
        scene.commit(index)
        camera = camera.zoomed_to_region(*CENTRE, 8.0)
    return scene


def grid_level(
    scene: Scene, parent: int | None, camera: Camera, image: ByteArray, relief: FloatArray
) -> Level:
    """One level of pixel-aligned surfels at unit depth."""
    frame = LevelFrame.of_camera(camera, PLANE_DEPTH)
    surfels = lift(image.astype(np.float32) / np.float32(255.0), relief, camera)
    surfels = surfels.with_(coverage=coverage_for(scene, parent, camera, frame, surfels.means))
    surfels = finished(surfels, camera, frame)
    return Level(len(scene), parent, camera, frame, surfels, image, relief)


def _waves(height: int, width: int, amplitude_px: float) -> FloatArray:
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    return (amplitude_px * np.sin(x / 37.0) * np.cos(y / 29.0)).astype(np.float32)


def consistent_chain(num_levels: int, width: int, height: int) -> Scene:
    """A chain on one plane whose images agree: each child is its parent's crop, with new detail.

    The detail is of mean zero in every pixel of the parent, and as strong at every level, so a zoom
    changes as much from frame to frame everywhere.
    """
    rng = np.random.default_rng(0)
    image = 128.0 + _detail(rng, height, width)
    scene = Scene()
    camera = Camera.initial(width, height)
    flat = np.zeros((height, width), np.float32)
    for index in range(num_levels):
        parent = index - 1 if index else None
        pixels = np.rint(np.clip(image, 0, 255)).astype(np.uint8)
        scene.append(grid_level(scene, parent, camera, pixels, flat))
        scene.commit(index)
        image = _crop8(image) + _detail(rng, height, width)
        image = 128.0 + (image - 128.0) * min(1.0, DETAIL_LIMIT / float(image.std()))
        camera = camera.zoomed_to_region(*CENTRE, 8.0)
    return scene


def _detail(rng: np.random.Generator, height: int, width: int) -> FloatArray:
    """Smooth noise whose mean over every block of 8x8 pixels is zero, (h, w, 3)."""
    noise = cv2.GaussianBlur(rng.normal(0.0, 60.0, (height, width, 3)).astype(np.float32), (0, 0), 1.5)
    means = noise.reshape(height // 8, 8, width // 8, 8, 3).mean(axis=(1, 3))
    return noise - np.repeat(np.repeat(means, 8, axis=0), 8, axis=1)


def _crop8(image: FloatArray) -> FloatArray:
    """The region of `CENTRE`, eight times closer, smooth."""
    height, width = image.shape[:2]
    # cv2 counts from pixel centres: parent = (child + .5) / 8 + corner - .5
    x, y = CENTRE[0] * width - width / 16, CENTRE[1] * height - height / 16
    parent_from_child = np.array([[1 / 8, 0, x + 1 / 16 - 0.5], [0, 1 / 8, y + 1 / 16 - 0.5]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    border = cv2.BORDER_REPLICATE
    return np.asarray(
        cv2.warpAffine(image, parent_from_child, (width, height), flags=flags, borderMode=border)
    )
