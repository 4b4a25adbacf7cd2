"""What can be measured on a picture: bands, local energy, orientation, and resampling.

Everything here works on *grey levels*: float32 in 0..255, because the amplitude law and the classifier were
fitted in them.  Images are ``(h, w, 3)`` RGB, planes ``(h, w)``.
"""

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import FloatArray

LUMA_WEIGHTS = np.array([0.299, 0.587, 0.114], np.float32)
"""ITU-R BT.601 luma of sRGB-encoded values."""


@dataclass(frozen=True)
class Orientation:
    """The structure tensor of a picture, read per pixel.

    Attributes:
        across_x: ``(h, w)`` first component of the unit vector across the edge.
        across_y: ``(h, w)`` second component.
        coherence: ``(h, w)`` 0 (no direction) to 1 (one direction).
        strength: ``(h, w)`` gradient magnitude in grey levels per pixel.
    """

    across_x: FloatArray
    across_y: FloatArray
    coherence: FloatArray
    strength: FloatArray


def luma(image: FloatArray) -> FloatArray:
    """Returns the ``(h, w)`` luma of an ``(h, w, 3)`` image, in the image's own unit."""
    return np.ascontiguousarray(image @ LUMA_WEIGHTS)


def blurred(plane: FloatArray, sigma: float) -> FloatArray:
    """Returns the Gaussian blur; borders are mirrored."""
    return cv2.GaussianBlur(plane, (0, 0), sigma, borderType=cv2.BORDER_REFLECT_101)


def widely_blurred(plane: FloatArray, sigma: float) -> FloatArray:
    """Returns the Gaussian blur for a large sigma, computed on a quarter of the size to save time."""
    height, width = plane.shape[:2]
    if sigma < 6 or min(height, width) < 32:
        return blurred(plane, sigma)
    small = cv2.resize(plane, (max(width // 4, 8), max(height // 4, 8)), interpolation=cv2.INTER_AREA)
    return cv2.resize(blurred(small, sigma / 4), (width, height), interpolation=cv2.INTER_LINEAR)


def local_rms(plane: FloatArray, sigma: float) -> FloatArray:
    """Returns the root mean square over a Gaussian window of the given sigma."""
    return np.sqrt(np.maximum(widely_blurred(plane * plane, sigma), 0))


def dense_rms(plane: FloatArray, sigma: float) -> FloatArray:
    """Returns a local RMS that counts dense texture and hardly counts sparse edges.

    The 1/2-norm ``(mean |x|^.5)^2`` of a Gaussian variable is 0.676 of its RMS, which is divided out; of a
    lone contour, a wire or a line of text in a flat field it is far below the RMS.
    """
    half_norm = widely_blurred(np.sqrt(np.abs(plane)), sigma)
    return np.minimum(half_norm * half_norm / np.float32(0.676), local_rms(plane, sigma))


def drawn_not_lettered(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: 0 where the picture has two tones, 1 where it has tones of all kinds.

    Letters, window rows, railings and flat graphics are two tones and the contours between them.  The measure
    is the median distance from the nearer tone over the local deviation: 1 in Gaussian texture, 0 in black
    on white; photographs of text and facades measure 0.5-0.6, fur 0.7, leaves, rock and carpet 0.75-0.9.
    """
    window = (9, 9)
    mean = cv2.blur(plane, window)
    light = (plane > mean).astype(np.float32)
    upper = cv2.blur(plane * light, window) / np.maximum(cv2.blur(light, window), 1e-3)
    lower = cv2.blur(plane * (1 - light), window) / np.maximum(cv2.blur(1 - light, window), 1e-3)
    distance = np.abs(plane - np.where(light > 0, upper, lower))
    steps = np.clip(distance * 8 + 0.5, 0, 255).astype(np.uint8)
    middle = cv2.medianBlur(steps, 9).astype(np.float32) / (8 * 0.45)
    deviation = np.sqrt(np.maximum(cv2.blur(plane * plane, window) - mean * mean, 0))
    return ramp(blurred(middle / (deviation + np.float32(0.3)), 3.0), 0.58, 0.2)


def first_band(plane: FloatArray) -> FloatArray:
    """Returns the finest octave, ``Y - G(1) Y``."""
    return plane - blurred(plane, 1.0)


def area_down(image: FloatArray, width: int, height: int) -> FloatArray:
    """Returns the mean over every coarse pixel's area: what a coarser camera would see."""
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)


def enlarged(image: FloatArray, width: int, height: int) -> FloatArray:
    """Returns the bicubic enlargement (or, where that is smaller, the reduction)."""
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_CUBIC)


def stretched(plane: FloatArray, width: int, height: int) -> FloatArray:
    """Returns the bilinear enlargement, which never leaves the range of its input."""
    return cv2.resize(plane, (width, height), interpolation=cv2.INTER_LINEAR)


def resized(plane: FloatArray, width: int, height: int) -> FloatArray:
    """Returns the plane at a size: enlarged, or reduced where both sides become shorter."""
    if plane.shape[:2] == (height, width):
        return plane
    smaller = width <= plane.shape[1] and height <= plane.shape[0]
    return cv2.resize(plane, (width, height), interpolation=cv2.INTER_AREA if smaller else cv2.INTER_CUBIC)


def orientation(plane: FloatArray, sigma: float, window: float) -> Orientation:
    """Returns the structure tensor of G(`sigma`) Y, gathered over G(`window`)."""
    smooth = blurred(plane, sigma)
    grad_x = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=0.125)
    grad_y = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=0.125)
    return orientation_of_tensor(
        widely_blurred(grad_x * grad_x, window),
        widely_blurred(grad_x * grad_y, window),
        widely_blurred(grad_y * grad_y, window),
    )


def orientation_of_tensor(xx: FloatArray, xy: FloatArray, yy: FloatArray) -> Orientation:
    """Returns the reading of a symmetric 2x2 tensor field in closed form."""
    difference, trace = xx - yy, xx + yy
    spread = np.sqrt(difference * difference + 4 * xy * xy)
    angle = 0.5 * np.arctan2(2 * xy, difference)
    coherence = spread / (trace + np.float32(1e-6))
    strength = np.sqrt(np.maximum(0.5 * (trace + spread), 0))
    return Orientation(np.cos(angle), np.sin(angle), coherence, strength)


def ramp(plane: FloatArray, start: float, width: float) -> FloatArray:
    """Returns 0 below `start`, 1 above ``start + width``, linear between."""
    rising: FloatArray = (plane - np.float32(start)) / np.float32(width)
    return rising.clip(0, 1)


def over_rows(kernel: Callable[[int, int], None], height: int) -> None:
    """Runs ``kernel(first_row, last_row)`` over slices of rows, on every core.

    Kernels release the interpreter lock and write disjoint rows, so the result does not depend on the number
    of threads.  (Numba's own ``parallel=True`` compiles several times longer.)
    """
    slices = max(1, min(os.cpu_count() or 1, 8, height // 100))  # small pictures are not worth a thread
    if slices == 1:
        return kernel(0, height)
    edges = [height * index // slices for index in range(slices + 1)]
    with ThreadPoolExecutor(slices) as pool:
        for done in [pool.submit(kernel, a, b) for a, b in itertools.pairwise(edges)]:
            done.result()
    return None
