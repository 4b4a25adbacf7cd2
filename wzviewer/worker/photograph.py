"""The photograph's own pixels: a first zoom shows what the camera saw before anything is invented.

E_0 is made at a working size of about a megapixel; most photographs have more.  Where the parent of a
new level is coarser than the photograph, the observation O takes its pixels from there: every pixel's
point is looked up in C_0.  What the levels show, shrunk, stays what it was (`_agreeing`).
"""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.scene import PHOTO, Level
from wzviewer.core.types import ByteArray, DoubleArray, FloatArray
from wzviewer.worker.stages.stage1_new_scale_image import Observation
from wzviewer.worker.stages.stage1_whole_pixels import spread_over

FINER_MIN = 1.2  # less is not worth it
ROUND_UP = 0.34  # of a step: the new image shall be a whole multiple of O, at the price of a third
SLACK_SHARE = 0.02  # of the depth: what is farther than E_0's surface by more is hidden from C_0
AGREEMENTS = 3  # a linear correction keeps about half of a pixel's difference
BORDER_PX = 3.0  # over which what C_0 did not see takes over


def with_photo(level: Level, photo: ByteArray | None) -> Level:
    """Returns E_0 with the photograph, if it has more pixels than I_0."""
    return level if photo is None else replace(level, maps={**level.maps, PHOTO: photo})


def sharpened(seen: Observation) -> Observation:
    """Returns O with the photograph's pixels, where it is finer than the parent; else O itself.

    A path with a prompt is left alone: what was inserted is not in the photograph, nor are siblings.
    """
    finer = _finer(seen.path)
    if seen.is_extension or seen.extended_share > 0 or seen.joined or finer < FINER_MIN:
        return seen
    step = seen.grid.width / seen.image.shape[1]
    whole = max(1, int(step / min(finer, step) + ROUND_UP))
    small = seen.grid.resampled(*(max(side // whole, 1) for side in (seen.grid.width, seen.grid.height)))
    if small.width < FINER_MIN * seen.image.shape[1]:
        return seen
    image = cv2.resize(seen.image, (small.width, small.height), interpolation=cv2.INTER_CUBIC)
    pixels, known = _looked_up(seen, small)
    pixels = image + known[..., None] * (pixels - image)
    return replace(seen, image=_agreeing(pixels, seen.image), coarse=seen.image)


def _finer(path: Sequence[Level]) -> float:
    """How many pixels of the photograph lie side by side in one of the parent."""
    photo = path[0].maps.get(PHOTO)
    if photo is None or any(level.prompt or level.notes.get("placements") for level in path):
        return 0.0
    magnification = path[-1].camera.focal_px / path[0].camera.focal_px
    return photo.shape[1] / path[0].image.shape[1] / magnification


def _looked_up(seen: Observation, small: Camera) -> tuple[FloatArray, FloatArray]:
    """The photograph as a camera sees it (h, w, 3), and how far C_0 saw that, (h, w) in 0..1."""
    root = seen.path[0]
    photo = root.maps[PHOTO]
    x_px, y_px, depth = np.moveaxis(root.camera.project(_points(seen, small)), -1, 0)
    size = (root.camera.width, root.camera.height)
    x, y = x_px * (photo.shape[1] / size[0]) - 0.5, y_px * (photo.shape[0] / size[1]) - 0.5
    pixels = _remapped(photo, x, y)
    front = cv2.remap(
        root.depth.astype(np.float32),
        (x_px - 0.5).astype(np.float32),
        (y_px - 0.5).astype(np.float32),
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_REPLICATE,
    )
    inside = (x_px > 0) & (x_px < size[0]) & (y_px > 0) & (y_px < size[1])
    known = inside & (depth < front * (1 + SLACK_SHARE)) & (depth > 0)
    return pixels, _softened(known | (inside & _is_same_pose(small, root.camera)))


def _points(seen: Observation, small: Camera) -> DoubleArray:
    """World points (h, w, 3) of a camera's pixels, on the surface that O shows."""
    relief = np.where(np.isfinite(seen.relief), seen.relief, np.float32(0))
    relief = spread_over(relief, seen.grid, seen.camera, small.width, small.height)
    z = float(small.to_camera(seen.frame.origin)[2]) + relief.astype(np.float64) * seen.frame.unit
    y, x = np.mgrid[0 : small.height, 0 : small.width] + 0.5
    rays = np.stack([(x - small.cx) / small.fx, (y - small.cy) / small.fy, np.ones_like(x)], -1)
    return small.to_world(rays * z[..., None])


def _remapped(photo: ByteArray, x: DoubleArray, y: DoubleArray) -> FloatArray:
    """Samples only the part of the photograph that is needed; float32 in [0, 1]."""
    left, right = (int(np.clip(f(x), 0, photo.shape[1] - 1)) for f in (np.min, np.max))
    top, bottom = (int(np.clip(f(y), 0, photo.shape[0] - 1)) for f in (np.min, np.max))
    left, top = max(left - 4, 0), max(top - 4, 0)
    piece = photo[top : bottom + 5, left : right + 5].astype(np.float32) / np.float32(255)
    at = ((x - left).astype(np.float32), (y - top).astype(np.float32))
    return np.clip(cv2.remap(piece, *at, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), 0, 1)


def _is_same_pose(a: Camera, b: Camera) -> bool:
    return bool(np.allclose(a.camera_from_world, b.camera_from_world, rtol=0, atol=1e-12))


def _softened(known: np.ndarray) -> FloatArray:
    """A mask without a hard border: what was not seen takes over within a few pixels."""
    reach = 2 * int(BORDER_PX) + 1
    inner = cv2.erode(known.astype(np.float32), np.ones((reach, reach), np.uint8))
    return cv2.blur(inner, (reach, reach))


def _agreeing(fine: FloatArray, coarse: FloatArray) -> FloatArray:
    """Returns the fine picture with the coarse one's means, so that no border shows where it begins."""
    size = (fine.shape[1], fine.shape[0])
    for _ in range(AGREEMENTS):
        shrunk = cv2.resize(fine, (coarse.shape[1], coarse.shape[0]), interpolation=cv2.INTER_AREA)
        missing = cv2.resize(coarse - shrunk, size, interpolation=cv2.INTER_LINEAR)
        fine = np.clip(fine + missing, 0, 1)
    return fine
