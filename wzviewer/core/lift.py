"""From a picture with relief to pixel-aligned surfels (paper, Sec. 3.1: Optimization).

A pixel whose surface has the tangents ``e_x = dP/dx_px`` and ``e_y = dP/dy_px`` becomes a surfel with
the covariance ``sigma^2 (e_x e_x^T + e_y e_y^T)``: its footprint in the camera that made it is a round
Gaussian of ``sigma`` px, whatever the tilt and however far off the axis.  Of that matrix's square root
the surfel keeps the two axes: the first runs along the tilt and is ``1 / cos`` longer than the second.
(Axes that stay horizontal and vertical have the same normal, but on a slanting surface a footprint
that is not round: measured 4 dB worse.)
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.constants import COS_TILT_MIN, SURFEL_OPACITY, SURFEL_SIGMA_PX
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray

THREADS = 2
BLOCK_PX = 128  # surfels come in blocks of the image, so that a run of them is near in space
TEAR_SLOPE = 30.0  # native px of depth per px: steeper is an edge between two things (3 % of z at f 1024)
COS_FLOOR = 1e-3  # keeps the tangents of an edge-on surface finite
RANGE_MIN = 1e-9  # of z / z0


def normals_from_relief(
    relief: FloatArray, camera: Camera, offset_px: tuple[int, int] = (0, 0)
) -> FloatArray:
    """Estimates unit normals in camera axes, facing the camera.

    Inverse depth is affine on a plane, so its gradient is averaged: over one-sided differences that do
    not cross a step, then over 3x3 pixels on this side of it.

    Args:
        relief: (h, w) float32 native px, nan where undefined.
        camera: the camera that the relief belongs to.
        offset_px: image pixel of the first array element, (x, y).

    Returns:
        (h, w, 3) float32; nan where the relief is; towards the camera where no neighbour is defined.
    """
    q = _parallax(relief, camera.focal_px)
    limit = np.float32(TEAR_SLOPE) * (1 + q / np.float32(camera.focal_px))
    slope_x, slope_y = _slope(q, limit, 1), _slope(q, limit, 0)
    slope_x, slope_y = _mean_on_this_side(q, limit, slope_x, slope_y)
    ray_x, ray_y = _rays(camera, relief.shape, offset_px)
    f = np.float32(camera.focal_px)
    n_x, n_y = slope_x * np.float32(camera.fx / f), slope_y * np.float32(camera.fy / f)
    n_z = 1 + q / f - n_x * ray_x.astype(np.float32) - n_y * ray_y.astype(np.float32)
    length = np.sqrt(n_x * n_x + n_y * n_y + n_z * n_z)
    return -np.stack([n_x, n_y, n_z], axis=-1) / length[..., None]


def _parallax(relief: FloatArray, focal_px: float) -> FloatArray:
    """Q = -delta / (1 + delta / f), native px; nan where undefined or at the camera."""
    z = 1 + relief / np.float32(focal_px)
    z = np.where(z > np.float32(RANGE_MIN), z, np.float32(np.nan))
    return (-relief / z).astype(np.float32)


def _rays(
    camera: Camera, shape: tuple[int, ...], offset_px: tuple[int, int]
) -> tuple[DoubleArray, DoubleArray]:
    """Ray directions (x, y, 1) of the pixels: (1, w) and (h, 1) float64."""
    ray_x = (np.arange(shape[1]) + 0.5 + offset_px[0] - camera.cx) / camera.fx
    ray_y = (np.arange(shape[0]) + 0.5 + offset_px[1] - camera.cy) / camera.fy
    return ray_x[None, :].astype(np.float64), ray_y[:, None].astype(np.float64)


def _slope(q: FloatArray, limit: FloatArray, axis: int) -> FloatArray:
    """Mean of the differences to both neighbours along an axis that are on this surface; nan if none."""
    step = np.diff(q, axis=axis)
    low, high = (np.take(limit, r, axis) for r in (range(q.shape[axis] - 1), range(1, q.shape[axis])))
    usable = np.abs(step) < np.minimum(low, high)  # false for nan
    before = [(1, 0) if a == axis else (0, 0) for a in range(2)]
    after = [(0, 1) if a == axis else (0, 0) for a in range(2)]
    kept = np.where(usable, step, np.float32(0))
    total = np.pad(kept, before) + np.pad(kept, after)
    count = np.pad(usable, before).astype(np.float32) + np.pad(usable, after)
    return np.where(count > 0, total / np.maximum(count, 1), np.float32(np.nan))


def _mean_on_this_side(
    q: FloatArray, limit: FloatArray, slope_x: FloatArray, slope_y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """3x3 means of both slopes over the neighbours within the tear limit; 0 where there is none."""
    padded = [np.pad(a, 1, constant_values=np.nan) for a in (q, slope_x, slope_y)]
    sums = [np.zeros(q.shape, np.float32) for _ in range(4)]
    h, w = q.shape
    for dy in range(3):
        for dx in range(3):
            near, *slopes = (p[dy : dy + h, dx : dx + w] for p in padded)
            same = np.abs(near - q) < limit
            for k, slope in enumerate(slopes):
                usable = same & ~np.isnan(slope)
                sums[k] += np.where(usable, slope, np.float32(0))
                sums[k + 2] += usable
    mean_x, mean_y = (sums[k] / np.maximum(sums[k + 2], 1) for k in range(2))
    return mean_x.astype(np.float32), mean_y.astype(np.float32)


def lift(
    image: FloatArray,
    relief: FloatArray,
    camera: Camera,
    normals: FloatArray | None = None,
    mask: BoolArray | None = None,
    sigma_px: float = SURFEL_SIGMA_PX,
    opacity: float | FloatArray = SURFEL_OPACITY,
    offset_px: tuple[int, int] = (0, 0),
) -> Surfels:
    """Makes one surfel per pixel, local to the frame anchored at the centre of the camera's image.

    Args:
        image: (h, w, 3) float32 sRGB.
        relief: (h, w) float32 native px relative to the anchor; pixels that are nan give no surfel.
        camera: the creating camera; the arrays may be a canvas larger than its image.
        normals: (h, w, 3) float32 camera axes, or None to estimate them from the relief.
        mask: (h, w) bool, the pixels to lift; None for all.
        sigma_px: standard deviation of a footprint, px.
        opacity: o of every surfel, or (h, w).
        offset_px: image pixel of the first array element, (x, y).

    Returns:
        Surfels in blocks of 128x128 array elements, blocks and pixels row-major; the first axis of
        each runs along its tilt.
    """
    if normals is None:
        normals = normals_from_relief(relief, camera, offset_px)

    opaque = np.broadcast_to(np.float32(opacity), relief.shape)

    def lifted(block: tuple[slice, slice]) -> tuple[DoubleArray | FloatArray, ...]:
        delta = relief[block].astype(np.float64)
        kept = 1 + delta / camera.focal_px > RANGE_MIN  # false for nan
        if mask is not None:
            kept &= mask[block]
        rows, columns = np.nonzero(kept)
        x_px = columns + (block[1].start + offset_px[0] + 0.5)
        y_px = rows + (block[0].start + offset_px[1] + 0.5)
        geometry = _geometry(x_px, y_px, delta[kept], normals[block][kept], camera, sigma_px)
        return (*geometry, image[block][kept], opaque[block][kept])

    # A layer is mostly empty; of its blocks the first stays, so that there is something to join.
    blocks = list(_blocks(relief.shape))
    blocks = blocks[:1] + [block for block in blocks[1:] if mask is None or mask[block].any()]
    with ThreadPoolExecutor(THREADS) as pool:  # numpy lets go of the interpreter; map keeps the order
        pieces = list(pool.map(lifted, blocks))
    means, quats, scales, colors, opacities = (
        np.concatenate(p).astype(np.float32) for p in zip(*pieces, strict=True)
    )
    return _with_native(means, quats, scales, colors, opacities, camera)


def _with_native(
    means: FloatArray,
    quats: FloatArray,
    scales: FloatArray,
    colors: FloatArray,
    opacities: FloatArray,
    camera: Camera,
) -> Surfels:
    native = (1 + means[:, 2].astype(np.float64) / camera.focal_px).astype(np.float32)
    covered = np.ones(len(means), np.float32)
    return Surfels(means, quats, scales, opacities, colors, native, covered)


def lift_spanned(
    corners: DoubleArray, colors: FloatArray, opacities: FloatArray, camera: Camera, sigma_px: float
) -> Surfels:
    """Makes surfels of footprints that are not pixels of the camera, such as those of another view.

    Args:
        corners: (3, n, 3) image x, image y and relief, px: of each centre, and of the ends of the two steps
            that span its footprint.
        colors: (n, 3) sRGB.
        opacities: (n,).
        camera: whose image it is.
        sigma_px: standard deviation over the length of a step.
    """
    points, *ends = (_local(c, camera) for c in corners)
    long, short = _principal_axes(*((end - points).T for end in ends))
    swap = (short * short).sum(0) > (long * long).sum(0)
    long, short = np.where(swap, short, long), np.where(swap, -long, short)
    length = np.maximum(np.sqrt((long * long).sum(0)), 1e-12)
    width = np.maximum(np.sqrt((short * short).sum(0)), 1e-12)
    quats = _quats_from_axes(long / length, -short / width)
    scales = sigma_px * np.stack([np.minimum(length, width / COS_TILT_MIN), width], axis=1)
    return _with_native(
        points.astype(np.float32),
        quats.astype(np.float32),
        scales.astype(np.float32),
        colors,
        opacities,
        camera,
    )


def _local(corners: DoubleArray, camera: Camera) -> DoubleArray:
    """Returns points (n, 3) of the frame at image positions and relief (n, 3), px."""
    x_px, y_px, delta = corners.T
    f = camera.focal_px
    ray_x, ray_y = (x_px - camera.cx) / camera.fx, (y_px - camera.cy) / camera.fy
    across = (x_px - camera.width / 2) * (f / camera.fx), (y_px - camera.height / 2) * (f / camera.fy)
    return np.stack([across[0] + ray_x * delta, across[1] + ray_y * delta, delta], axis=1)


def _blocks(shape: tuple[int, ...]) -> Iterator[tuple[slice, slice]]:
    for y in range(0, shape[0], BLOCK_PX):
        for x in range(0, shape[1], BLOCK_PX):
            rows = slice(y, min(y + BLOCK_PX, shape[0]))
            yield rows, slice(x, min(x + BLOCK_PX, shape[1]))


def _geometry(
    x_px: DoubleArray,
    y_px: DoubleArray,
    delta: DoubleArray,
    normals: FloatArray,
    camera: Camera,
    sigma_px: float,
) -> tuple[DoubleArray, DoubleArray, DoubleArray]:
    """Returns means (n, 3), quats (n, 4) and scales (n, 2) of pixels (n,)."""
    f = camera.focal_px
    ray_x, ray_y = (x_px - camera.cx) / camera.fx, (y_px - camera.cy) / camera.fy
    means = _local(np.stack([x_px, y_px, delta], 1), camera)
    ranges = 1 + delta / f
    e_x, e_y = _tangents(ray_x, ray_y, normals.astype(np.float64), f / camera.fx, f / camera.fy)
    long, short = _principal_axes(e_x, e_y)
    length, width = np.sqrt((long * long).sum(0)), np.sqrt((short * short).sum(0))
    quats = _quats_from_axes(long / length, -short / width)  # so that t1 x t2 faces the camera
    stretch = np.minimum(length, width / COS_TILT_MIN)
    return means, quats, sigma_px * ranges[:, None] * np.stack([stretch, width], axis=1)


def _tangents(
    ray_x: DoubleArray, ray_y: DoubleArray, normals: DoubleArray, px_x: float, px_y: float
) -> tuple[DoubleArray, DoubleArray]:
    """dP/dx_px and dP/dy_px on the plane with this normal, (3, n) each, in pixels at the surfel's depth."""
    n = np.where(np.isnan(normals), np.array([0.0, 0.0, -1.0]), normals).T
    rays = np.stack([ray_x, ray_y, np.ones_like(ray_x)])
    facing = (n * rays).sum(0)
    floor = COS_FLOOR * np.sqrt((rays * rays).sum(0))
    facing = np.where(facing > 0, np.maximum(facing, floor), np.minimum(facing, -floor))
    e_x, e_y = -rays * (n[0] / facing), -rays * (n[1] / facing)
    e_x[0] += 1
    e_y[1] += 1
    return e_x * px_x, e_y * px_y


def _principal_axes(e_x: DoubleArray, e_y: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Rotates two tangents (3, n) into orthogonal ones with the same e_x e_x^T + e_y e_y^T, longest first."""
    xx, xy, yy = (e_x * e_x).sum(0), (e_x * e_y).sum(0), (e_y * e_y).sum(0)
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    c, s = np.cos(angle), np.sin(angle)
    return c * e_x + s * e_y, c * e_y - s * e_x


def _quats_from_axes(t1: DoubleArray, t2: DoubleArray) -> DoubleArray:
    """Unit quaternions wxyz (n, 4) of the rotations [t1 t2 t1 x t2]; the axes are (3, n).

    The largest of the four components is found first (Shepperd, 1978), so nothing cancels.
    """
    n = np.stack([t1[k - 2] * t2[k - 1] - t1[k - 1] * t2[k - 2] for k in range(3)])
    R = np.stack([t1, t2, n], axis=1)  # (3, 3, n): rows, columns
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    squares = np.stack([trace, R[0, 0], R[1, 1], R[2, 2]])
    largest = squares.argmax(0)
    quats = np.empty((t1.shape[1], 4))
    for case in range(4):
        at = largest == case
        quats[at] = _quats_of_case(R[:, :, at], case)
    return quats / np.sqrt((quats * quats).sum(1, keepdims=True))


def _quats_of_case(R: DoubleArray, case: int) -> DoubleArray:
    """Quaternions (n, 4), not normalised, where component ``case`` is the largest."""
    if case == 0:
        parts = [1 + R[0, 0] + R[1, 1] + R[2, 2], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
        return np.stack(parts, axis=1)
    i, j, k = case - 1, case % 3, (case + 1) % 3
    quats = np.empty((R.shape[2], 4))
    quats[:, 0] = R[k, j] - R[j, k]
    quats[:, 1 + i] = 1 + R[i, i] - R[j, j] - R[k, k]
    quats[:, 1 + j] = R[j, i] + R[i, j]
    quats[:, 1 + k] = R[k, i] + R[i, k]
    return quats
