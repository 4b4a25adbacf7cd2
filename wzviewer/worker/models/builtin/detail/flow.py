"""Materials with a grain: wood, hair, bark, brushed metal, drawn along the picture's own direction.

Line integral convolution (Cabral and Leedom 1993): noise is averaged along the streamlines of a direction
field, so strands follow the picture without a seam or a block.  The field is the structure tensor of the
observation, voted over growing neighbourhoods: where a place has no direction of its own, its surroundings
decide.
"""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numba import njit

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.detail.measures import (
    blurred,
    local_rms,
    orientation_of_tensor,
    over_rows,
    stretched,
    widely_blurred,
)

FIELD_STEP_PX = 4
"""The direction field is stored on a grid this coarse."""
NEAR_VOTES, CALM_VOTES = 1.0, 0.01
"""Beyond the photograph a strand is as long as the picture: it turns once there, not in every blur."""
PAPILLA_PX = 1.2
WIDE_PX = 1.8
"""Strands as wide as this are drawn at half the size: a quarter of the work, the same look."""


@dataclass(frozen=True)
class Grain:
    """How strands look.

    Attributes:
        width_px: deviation of the noise that becomes a strand.
        half_length_px: how far the noise is averaged each way.
        fine: share of a second layer, of strands a third as wide.
        relief: share of shading across the strand.
        vessels: share of short dark dashes.
        unrest_deg: how far strands stray from the field.
        velvet: share of what has no direction: the papillae of a petal, each lit.
    """

    width_px: float
    half_length_px: int
    fine: float
    relief: float
    vessels: float
    unrest_deg: float
    velvet: float = 0.0


GRAINS = {
    "fibre": Grain(2.2, 30, 0.6, 0.6, 0.5, 4.0),
    "fur": Grain(1.2, 22, 0.5, 0.5, 0.0, 7.0),
    "hair": Grain(0.9, 30, 0.4, 0.5, 0.0, 3.0),
    "bristle": Grain(0.9, 24, 0.5, 0.6, 0.0, 4.0),
    "bark": Grain(4.0, 22, 0.7, 1.0, 0.6, 12.0),
    "brushed": Grain(0.8, 32, 0.5, 0.2, 0.0, 0.5),
    "fibril": Grain(0.9, 40, 0.4, 0.9, 0.0, 3.0),
    "petal": Grain(3.0, 48, 0.5, 0.5, 0.0, 3.0, velvet=0.45),
    "velvet": Grain(2.6, 9, 0.5, 0.8, 0.0, 5.0, velvet=0.3),
    "paint": Grain(1.9, 12, 0.9, 1.0, 0.0, 9.0),
    "straw": Grain(2.0, 13, 0.9, 0.9, 0.0, 22.0, velvet=0.15),
}


def voted_direction(
    plane: FloatArray, width: int, height: int, near: float = NEAR_VOTES
) -> tuple[FloatArray, FloatArray]:
    """Returns the unit vectors along the grain, ``(height / 4, width / 4)`` each, for a picture of that size.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
        width: width in px of the picture to be made.
        height: its height in px.
        near: weight of the nearest surroundings; `CALM_VOTES` where they are blurs that point anywhere.
    """
    smooth = blurred(plane, 0.8)
    grad_x = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3, scale=0.125)
    grad_y = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3, scale=0.125)
    damping = 1 / np.sqrt(grad_x * grad_x + grad_y * grad_y + 0.25)  # or one contour outvotes a whole fur
    xx, xy, yy = (
        _voted(a * b * damping, near) for a, b in ((grad_x, grad_x), (grad_x, grad_y), (grad_y, grad_y))
    )
    field = orientation_of_tensor(xx, xy, yy + 1e-4)
    cos2 = field.across_x**2 - field.across_y**2
    sin2 = 2 * field.across_x * field.across_y
    size = (max(width // FIELD_STEP_PX, 2), max(height // FIELD_STEP_PX, 2))
    angle = 0.5 * np.arctan2(stretched(sin2, *size), stretched(cos2, *size)) + np.float32(math.pi / 2)
    return np.cos(angle), np.sin(angle)


def _voted(plane: FloatArray, near: float) -> FloatArray:
    close, middle, far = blurred(plane, 4.0), widely_blurred(plane, 9), widely_blurred(plane, 20)
    return np.float32(near) * (close + 0.4 * middle) + 0.12 * far + 0.02 * plane.mean()


def grain_texture(
    grain: Grain,
    direction: tuple[FloatArray, FloatArray],
    mask: BoolArray,
    rng: np.random.Generator,
    stride: int = 1,
) -> FloatArray:
    """Returns strands along the direction field, local mean 0 and about unit deviation, 0 outside the mask.

    Args:
        grain: how they look.
        direction: unit vectors on a coarse grid, of `voted_direction`.
        mask: ``(H, W)``, where they are needed.
        rng: source of randomness.
        stride: texture px per image px; 2 for a preview of half the size.
    """
    grain = replace(grain, width_px=grain.width_px / stride, half_length_px=grain.half_length_px // stride)
    field = _strayed(direction, grain.unrest_deg, rng)
    half_length = grain.half_length_px
    if grain.width_px < WIDE_PX:
        texture = _leveled(_streamed(_mixed_noise(grain, mask.shape, rng), field, mask, half_length))
    else:
        texture = _leveled(_layer(grain.width_px, half_length, field, mask, rng))
        texture = texture + grain.relief * _leveled(_lit(texture))
        if grain.fine:
            fine = _layer(grain.width_px / 3, half_length // 2, field, mask, rng)
            texture += grain.fine * _leveled(fine)
    if grain.velvet:
        papillae = _noise(mask.shape, PAPILLA_PX / stride, rng)
        texture += np.float32(grain.velvet) * (_lit(papillae) + papillae)
    if grain.vessels:
        dashes = _layer(0.45 * grain.width_px, grain.half_length_px // 3, field, mask, rng, threshold=1.9)
        texture -= grain.vessels * dashes / (dashes.std() + 1e-6)
    return np.where(mask, texture, 0).astype(np.float32)


def _mixed_noise(grain: Grain, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    """Returns what becomes thin strands: coarse, fine and lit noise at once, for streaming is linear."""
    coarse = _noise(shape, grain.width_px, rng)
    lit = _lit(coarse)
    fine = _noise(shape, max(grain.width_px / 3, 0.6), rng)
    return coarse + np.float32(0.5 * grain.relief) * lit / (lit.std() + 1e-6) + np.float32(grain.fine) * fine


def _layer(
    width_px: float,
    half_length_px: int,
    field: tuple[FloatArray, FloatArray],
    mask: BoolArray,
    rng: np.random.Generator,
    threshold: float | None = None,
) -> FloatArray:
    """Returns noise of the given width, or what of it exceeds the threshold, drawn out along the field."""
    height, width = mask.shape
    if width_px >= WIDE_PX:
        size = (max(width // 2, 1), max(height // 2, 1))
        small_mask = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        small = _layer(width_px / 2, half_length_px // 2, field, small_mask, rng, threshold)
        return cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)
    noise = _noise((height, width), width_px, rng)
    if threshold is not None:
        noise = np.maximum(noise - np.float32(threshold), 0)
    return _streamed(noise, field, mask, max(half_length_px, 2))


def _strayed(
    direction: tuple[FloatArray, FloatArray], unrest_deg: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    x, y = direction
    stray = _noise(x.shape, 6.0, rng) * np.float32(math.radians(unrest_deg))
    cosine, sine = np.cos(stray), np.sin(stray)
    return cosine * x - sine * y, sine * x + cosine * y


def _noise(shape: tuple[int, ...], sigma: float, rng: np.random.Generator) -> FloatArray:
    field = blurred(rng.standard_normal(shape, np.float32), sigma)
    return (field / (field.std() + 1e-6)).astype(np.float32)


def _leveled(texture: FloatArray) -> FloatArray:
    flat = texture - blurred(texture, 5.0)
    return flat / (local_rms(flat, 16.0) + np.float32(1e-3))


def _lit(height: FloatArray) -> FloatArray:
    smooth = blurred(height, 0.7)
    return cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3) + cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=3)


def _streamed(
    noise: FloatArray, field: tuple[FloatArray, FloatArray], mask: BoolArray, half_length_px: int
) -> FloatArray:
    target = np.zeros_like(noise)
    x, y = (np.ascontiguousarray(plane) for plane in field)
    over_rows(lambda a, b: _stream_rows(noise, target, x, y, mask, half_length_px, a, b), len(noise))
    return target


@njit(cache=True, nogil=True, fastmath={"contract", "arcp"})
def _stream_rows(
    noise: FloatArray,
    target: FloatArray,
    along_x: FloatArray,
    along_y: FloatArray,
    mask: BoolArray,
    count: int,
    first: int,
    last: int,
) -> None:
    height, width = noise.shape
    rows, columns = along_x.shape
    cell_x, cell_y = np.float32(columns) / np.float32(width), np.float32(rows) / np.float32(height)
    for y in range(first, last):
        for x in range(width):
            if not mask[y, x]:
                continue
            total, weights = noise[y, x], np.float32(1.0)
            for side in range(2):
                px, py = np.float32(x), np.float32(y)
                vx, vy = np.float32(1 - 2 * side), np.float32(0.0)
                for k in range(1, count + 1):
                    i, j = min(int(px * cell_x), columns - 1), min(int(py * cell_y), rows - 1)
                    dx, dy = along_x[j, i], along_y[j, i]
                    if k == 1 and side == 1:
                        dx, dy = -dx, -dy
                    elif k > 1 and dx * vx + dy * vy < 0.0:
                        dx, dy = -dx, -dy
                    vx, vy = dx, dy
                    px += (
                        vx  # steps of one pixel: longer ones skip every other column, which beads the strand
                    )
                    py += vy
                    ix, iy = int(px + np.float32(0.5)), int(py + np.float32(0.5))
                    if ix < 0 or iy < 0 or ix >= width or iy >= height or px < 0 or py < 0:
                        break
                    weight = np.float32(1.0) - np.float32(k) / np.float32(count + 1)
                    total += weight * noise[iy, ix]
                    weights += weight
            target[y, x] = total / weights
