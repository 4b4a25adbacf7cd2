"""The last half per cent: what the layers leave open in a few neighbouring views.

Holes of those views get the depth of their farther rim, are carried back to the source view, pushed
behind what is seen there, and painted like a layer.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numba import njit

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.exemplar import FillTask, fill
from wzviewer.worker.models.builtin.views.layers import (
    CONTEXT_PX,
    CONTEXT_STEP,
    DEEPER_RULE,
    Original,
    Surface,
    behind_front,
    far_as_sky,
)
from wzviewer.worker.models.builtin.views.mesh import EMPTY, OrbitView, rotation_of, splat_depth
from wzviewer.worker.models.builtin.views.smoothing import dilated

CELL_PX = 2.0  # a surface stretched twofold is still closed
YAW, PITCH = 0.7, 0.45  # of the largest orbit angle
UNSET = np.float32(-3e38)


def leftover_layer(
    surfaces: list[Surface],
    masks: list[BoolArray],
    original: Original,
    offset_px: tuple[int, int],
    camera: Camera,
    axis: DepthAxis,
    angle_deg: float,
    seed: int,
    check: Callable[[], None] | None = None,
) -> tuple[Surface, BoolArray]:
    """Makes one more layer from the holes of eight neighbouring views.

    Args:
        surfaces: the front and the layers behind it, on one canvas.
        masks: (h, w) bool, the pixels of each that are kept.
        original: where patches come from.
        offset_px: image pixel of the canvas origin.
        camera: the source camera.
        axis: the depth coordinate.
        angle_deg: largest orbit angle.
        seed: of the candidate search.
        check: called now and then; may raise `Cancelled`.

    Returns:
        The layer and its pixels (h, w) bool, possibly none.
    """
    front = surfaces[0]
    relief = _holes([s.relief for s in surfaces], masks, offset_px, camera, angle_deg)
    relief = np.asarray(cv2.dilate(relief, np.ones((7, 7), np.uint8)), np.float32)
    mask = relief > UNSET
    relief, hidden = behind_front(np.where(mask, relief, front.relief), front.relief, axis)
    mask &= hidden
    sky = np.zeros_like(mask)
    if front.sky.any():
        far = np.median(front.relief[front.sky], keepdims=True)
        sky = mask & far_as_sky(axis.shift_of(relief), axis.shift_of(far), axis)
        relief = np.where(sky, far, relief).astype(np.float32)
    shift = axis.shift_of(relief)
    behind = surfaces[-1]
    nearer = behind.shift > shift + axis.step_of(shift, CONTEXT_STEP)
    around = dilated(mask, CONTEXT_PX)
    rows, columns = np.indices(mask.shape, np.int32)
    task = FillTask(
        behind.image, around & ~mask & ~nearer, mask, original.image, original.usable,
        original.log_depth, axis.log_of(shift), np.stack([rows, columns], axis=-1),
    )  # fmt: skip
    image = front.image
    if mask.any():
        image, copied_from = fill(task, DEEPER_RULE, seed, check)
        mask &= sky | ~original.from_sky(copied_from)
    return Surface(image, shift, relief, np.where(mask, sky, front.sky)), mask


def _holes(
    reliefs: list[FloatArray],
    masks: list[BoolArray],
    offset_px: tuple[int, int],
    camera: Camera,
    angle_deg: float,
) -> FloatArray:
    """Returns the relief (h, w) of hole pixels carried back to the source canvas, `UNSET` elsewhere."""
    angles = [(x, y) for x in (-YAW, 0.0, YAW) for y in (-PITCH, 0.0, PITCH) if x or y]
    probes = [OrbitView.of(camera, rotation_of(x * angle_deg, y * angle_deg)) for x, y in angles]
    views = np.stack([probe.parameters() for probe in probes])
    cells = (len(views), int(camera.height // CELL_PX), int(camera.width // CELL_PX))
    depth = np.full(cells, EMPTY, np.float32)
    for relief, mask in zip(reliefs, masks, strict=True):
        splat_depth(relief, mask, offset_px, views, CELL_PX, depth)
    found = np.full(reliefs[0].shape, UNSET, np.float32)
    for k, view in enumerate(views):
        along = depth[k] if angles[k][0] else np.ascontiguousarray(depth[k].T)
        filled = _far_rims(along)
        filled = filled if angles[k][0] else np.ascontiguousarray(filled.T)
        _carry_back(depth[k], filled, view, offset_px, CELL_PX, found)
    return found


@njit(cache=True, nogil=True)
def _far_rims(depth: FloatArray) -> FloatArray:
    """Gives every empty cell (n, m) the farther of the two ends of its run along the row."""
    filled = depth.copy()
    for i in range(depth.shape[0]):
        start = 0
        while start < depth.shape[1]:
            if depth[i, start] != EMPTY:
                start += 1
                continue
            stop = start
            while stop < depth.shape[1] and depth[i, stop] == EMPTY:
                stop += 1
            far = UNSET
            if start > 0:
                far = depth[i, start - 1]
            if stop < depth.shape[1]:
                far = max(far, depth[i, stop])
            filled[i, start:stop] = far
            start = stop
    return filled


@njit(cache=True, nogil=True)
def _carry_back(
    depth: FloatArray,
    filled: FloatArray,
    view: DoubleArray,
    offset: tuple[int, int],
    cell_px: float,
    found: FloatArray,
) -> None:
    """Unprojects the empty cells of a view and marks the source pixels (h, w) that they fall on."""
    tx, ty, inverse_f = view[11], view[12], view[13]
    samples = int(cell_px) + 1
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            z = np.float64(filled[i, j])
            if depth[i, j] != EMPTY or filled[i, j] == UNSET:
                continue
            for s in range(samples * samples):
                x = (j + (s % samples + 0.5) / samples) * cell_px
                y = (i + (s // samples + 0.5) / samples) * cell_px
                rx = (x - view[14]) * (1 + z * inverse_f) + tx * z
                ry = (y - view[15]) * (1 + z * inverse_f) + ty * z
                back = view[2] * rx + view[5] * ry + view[8] * z
                near = 1 + back * inverse_f
                if near < 0.02:
                    continue
                u = (view[0] * rx + view[3] * ry + view[6] * z - tx * back) / near + view[9] - offset[0]
                v = (view[1] * rx + view[4] * ry + view[7] * z - ty * back) / near + view[10] - offset[1]
                if u >= 0 and v >= 0 and u < found.shape[1] and v < found.shape[0]:
                    found[int(v), int(u)] = max(found[int(v), int(u)], np.float32(back))
