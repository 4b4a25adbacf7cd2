"""The crisp base: contours of the enlarged picture, sharp and without halos; no new texture.

Each step doubles the size (bicubic, held inside the range of its neighbourhood), blurs *along* contours and
then lets a coherence-oriented shock filter (Osher and Rudin 1990, Weickert 2003) steepen them.  The shock
filter is total-variation diminishing: it moves values, it cannot overshoot, hence no ringing and no halos
that the next levels would enlarge.  Where there is no clear direction it hardly acts, because it would turn
foliage into worms.

A network can take this place: anything that is a `BaseUpscaler` will do.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numba import njit

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import (
    Orientation,
    area_down,
    blurred,
    dense_rms,
    enlarged,
    first_band,
    local_rms,
    luma,
    orientation,
    over_rows,
    ramp,
    stretched,
)

BaseUpscaler = Callable[[FloatArray, int, int], FloatArray]
"""``base(image, doublings, level)``: grey levels ``(h, w, 3)`` in, each side 2^doublings times longer out."""

SHOCK_TIME_STEP = 0.35
SHOCK_GAIN = 0.2  # per grey level per px^2: weak gradients stay soft, real edges snap
DEEP_SHOCK_GAIN = 0.32  # from level 2 on the contours are our own, and they were sharp


def crisp_base(image: FloatArray, doublings: int, level: int = 1) -> FloatArray:
    """Returns the image enlarged by ``2**doublings`` with crisp contours.

    Args:
        image: ``(h, w, 3)`` float32 grey levels.
        doublings: number of x2 steps.
        level: of the new image; 1 enlarges a photograph.
    """
    gain = SHOCK_GAIN if level <= 1 else DEEP_SHOCK_GAIN
    result, calm = image, 1 - chaos(image)
    for step in range(doublings):
        result = doubled(result, back_project=step == 0)
        result = refined(result, stretched(calm, result.shape[1], result.shape[0]), min(step, 2), gain)
    return result if doublings == 0 else blurred(result, 0.5)


def chaos(image: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` 0..1: how much the picture has contrast everywhere and a direction nowhere."""
    plane = luma(image)
    field = orientation(plane, 0.7, 2.5)
    band = first_band(plane)
    density = dense_rms(band, 3.0) / (local_rms(band, 3.0) + np.float32(0.3))
    return (1 - ramp(field.coherence, 0.3, 0.25)) * ramp(density, 0.55, 0.25)


def doubled(image: FloatArray, back_project: bool) -> FloatArray:
    """Returns the x2 bicubic enlargement, held between the extremes of each pixel's 3x3 neighbourhood."""
    height, width = image.shape[:2]
    size = (2 * width, 2 * height)
    result = enlarged(image, *size)
    if back_project:
        result += enlarged(image - area_down(result, width, height), *size)
    box = np.ones((3, 3), np.uint8)
    lowest = cv2.resize(cv2.erode(image, box), size, interpolation=cv2.INTER_NEAREST)
    highest = cv2.resize(cv2.dilate(image, box), size, interpolation=cv2.INTER_NEAREST)
    return np.clip(result, lowest, highest)


def refined(image: FloatArray, calm: FloatArray, step: int, gain: float) -> FloatArray:
    """Returns the image blurred along its contours and, where it is `calm`, steepened across them."""
    field = orientation(luma(image), 1.0, 2.0 + 0.5 * step)
    along = ramp(field.coherence, 0.3, 0.4) * ramp(field.strength, 0.0, 2.0) * calm
    steep = np.float32(0.5) + np.float32(0.5) * calm
    result = blurred_along(image, field, along, half_length=4 + step // 2)
    for count in ((4,), (5,), (3, 3))[step]:
        speed = steep * shock_speed(result, field, (1.0, 1.3, 1.6)[step], gain)
        result = shocked(result, speed, count)
    return result


def shock_speed(image: FloatArray, field: Orientation, sigma: float, gain: float) -> FloatArray:
    """Returns the signed speed of the shock filter: tanh of the second derivative across the edge."""
    smooth = blurred(luma(image), sigma)
    xx = cv2.Sobel(smooth, cv2.CV_32F, 2, 0, ksize=3, scale=0.25)
    yy = cv2.Sobel(smooth, cv2.CV_32F, 0, 2, ksize=3, scale=0.25)
    xy = cv2.Sobel(smooth, cv2.CV_32F, 1, 1, ksize=3, scale=0.25)
    c, s = field.across_x, field.across_y
    bend = c * c * xx + 2 * c * s * xy + s * s * yy
    return np.tanh(np.float32(gain) * bend) * (0.25 + 0.75 * ramp(field.coherence, 0.25, 0.4))


def shocked(image: FloatArray, speed: FloatArray, count: int) -> FloatArray:
    """Returns the image after `count` explicit upwind steps, the same speed for all three channels."""
    source, target = np.ascontiguousarray(image), np.empty_like(image)
    for _ in range(count):
        _run_shock(source, target, speed)
        source, target = target, source if source is not image else np.empty_like(image)
    return source


def _run_shock(source: FloatArray, target: FloatArray, speed: FloatArray) -> None:
    over_rows(lambda first, last: _shock_rows(source, target, speed, first, last), len(source))


def blurred_along(image: FloatArray, field: Orientation, amount: FloatArray, half_length: int) -> FloatArray:
    """Returns a line blur along the contour, of `half_length` px each way, mixed in by `amount`."""
    source, target = np.ascontiguousarray(image), np.empty_like(image)
    x, y = np.ascontiguousarray(-field.across_y), np.ascontiguousarray(field.across_x)
    over_rows(lambda a, b: _along_rows(source, target, x, y, amount, half_length, a, b), len(source))
    return target


@njit(cache=True, nogil=True, fastmath={"contract", "arcp"})
def _minmod(a: np.float32, b: np.float32) -> np.float32:
    if a * b <= np.float32(0.0):
        return np.float32(0.0)
    return a if abs(a) < abs(b) else b


@njit(cache=True, nogil=True, fastmath={"contract", "arcp"})
def _shock_rows(source: FloatArray, target: FloatArray, speed: FloatArray, first: int, last: int) -> None:
    height, width = speed.shape
    for y in range(first, last):
        up, down = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            left, right = max(x - 1, 0), min(x + 1, width - 1)
            step = np.float32(SHOCK_TIME_STEP) * speed[y, x]
            for c in range(3):
                here = source[y, x, c]
                gx = _minmod(source[y, right, c] - here, here - source[y, left, c])
                gy = _minmod(source[down, x, c] - here, here - source[up, x, c])
                target[y, x, c] = here - step * np.sqrt(gx * gx + gy * gy)


@njit(cache=True, nogil=True, fastmath={"contract", "arcp"})
def _along_rows(
    source: FloatArray,
    target: FloatArray,
    along_x: FloatArray,
    along_y: FloatArray,
    amount: FloatArray,
    half_length: int,
    first: int,
    last: int,
) -> None:
    height, width = amount.shape
    right, bottom, one = np.float32(width - 1), np.float32(height - 1), np.float32(1)
    for y in range(first, last):
        for x in range(width):
            mix = amount[y, x]
            if mix <= 0.0:
                target[y, x] = source[y, x]
                continue
            red, green, blue, total = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            for k in range(-half_length, half_length + 1):
                weight = np.float32(1.0) - np.float32(abs(k)) / np.float32(half_length + 1)
                px = min(max(np.float32(x) + np.float32(k) * along_x[y, x], np.float32(0)), right)
                py = min(max(np.float32(y) + np.float32(k) * along_y[y, x], np.float32(0)), bottom)
                ix, iy = min(int(px), width - 2), min(int(py), height - 2)
                fx, fy = px - np.float32(ix), py - np.float32(iy)
                gx, gy = one - fx, one - fy
                w00, w01 = gx * gy * weight, fx * gy * weight
                w10, w11 = gx * fy * weight, fx * fy * weight
                a, b, c, d = source[iy, ix], source[iy, ix + 1], source[iy + 1, ix], source[iy + 1, ix + 1]
                red += w00 * a[0] + w01 * b[0] + w10 * c[0] + w11 * d[0]
                green += w00 * a[1] + w01 * b[1] + w10 * c[1] + w11 * d[1]
                blue += w00 * a[2] + w01 * b[2] + w10 * c[2] + w11 * d[2]
                total += weight
            keep = np.float32(1.0) - mix
            target[y, x, 0] = keep * source[y, x, 0] + mix * red / total
            target[y, x, 1] = keep * source[y, x, 1] + mix * green / total
            target[y, x, 2] = keep * source[y, x, 2] + mix * blue / total
