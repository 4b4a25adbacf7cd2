"""The 32 bytes of a surfel on the GPU.

======  =====================  ==================================================================
offset  attribute              content
======  =====================  ==================================================================
0       ``in_mean``            3 x float32, level-local, native pixels
12      ``in_quat_opacity``    4 x int16 of 1/32767: x, y, z of the quaternion (w >= 0.5), opacity
20      ``in_logs_coverage``   4 x float16: log2 of both scales, log2 of s_native, coverage
28      ``in_color_slot``      4 x uint8: red, green, blue, level slot
======  =====================  ==================================================================

A footprint has no orientation: turning a surfel by 180 degrees about one of its own axes leaves
s1^2 t1 t1^T + s2^2 t2 t2^T as it is.  So of the four equivalent quaternions the one with the
largest w is stored, and w = sqrt(1 - |xyz|^2) loses nothing (a surfel that faces the camera has
w = 0 otherwise, where that root is ill-conditioned).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray

RECORD_DTYPE = np.dtype(
    [
        ("mean", "<f4", 3),
        ("quat_opacity", "<i2", 4),
        ("logs_coverage", "<f2", 4),
        ("color_slot", "u1", 4),
    ]
)
RECORD_BYTES = RECORD_DTYPE.itemsize
RECORD_FORMAT = "3f4 4i2 4f2 4f1"  # the same for moderngl
RECORD_ATTRIBUTES = ("in_mean", "in_quat_opacity", "in_logs_coverage", "in_color_slot")

INT16_STEPS = 32767.0
TINY = 1e-30


def footprint_quats(quats: FloatArray) -> FloatArray:
    """Returns the equivalent quaternions (n, 4) wxyz whose w is the largest component, >= 0.5."""
    norm = np.linalg.norm(quats, axis=1, keepdims=True)
    q = np.where(norm > TINY, quats / np.maximum(norm, TINY), np.array([1, 0, 0, 0], np.float32))
    w, x, y, z = q.T
    turned = np.stack(  # q, q i, q j, q k
        [q, np.stack([-x, w, z, -y], 1), np.stack([-y, -z, w, x], 1), np.stack([-z, y, -x, w], 1)]
    )
    best = turned[np.abs(q).argmax(1), np.arange(len(q))]
    return np.where(best[:, :1] < 0, -best, best).astype(np.float32)


def pack(surfels: Surfels, slot: int) -> NDArray[Any]:
    """Encodes surfels (n) as records (n,) of `RECORD_DTYPE`.

    Args:
        surfels: of one level.
        slot: row of the level in `blocks`, 0..255.
    """
    records = np.zeros(len(surfels), RECORD_DTYPE)
    records["mean"] = surfels.means
    records["quat_opacity"][:, :3] = np.rint(footprint_quats(surfels.quats)[:, 1:] * INT16_STEPS)
    records["quat_opacity"][:, 3] = np.rint(np.clip(surfels.opacities, 0.0, 1.0) * INT16_STEPS)
    records["logs_coverage"][:, :2] = np.log2(np.maximum(surfels.scales, TINY))
    records["logs_coverage"][:, 2] = np.log2(np.maximum(surfels.native_scales, TINY))
    records["logs_coverage"][:, 3] = surfels.coverage
    records["color_slot"][:, :3] = np.rint(np.clip(surfels.colors, 0.0, 1.0) * 255.0)
    records["color_slot"][:, 3] = slot
    return records


def unpack(records: NDArray[Any]) -> Surfels:
    """Decodes records as the vertex shader does; footprints, not orientations, survive."""
    xyz = records["quat_opacity"][:, :3].astype(np.float32) / np.float32(INT16_STEPS)
    w = np.sqrt(np.maximum(1.0 - (xyz * xyz).sum(1, keepdims=True), 0.0))
    logs = records["logs_coverage"].astype(np.float32)
    return Surfels(
        means=records["mean"].astype(np.float32),
        quats=np.concatenate([w, xyz], 1),
        scales=np.exp2(logs[:, :2]),
        opacities=records["quat_opacity"][:, 3].astype(np.float32) / np.float32(INT16_STEPS),
        colors=records["color_slot"][:, :3].astype(np.float32) / np.float32(255.0),
        native_scales=np.exp2(logs[:, 2]),
        coverage=logs[:, 3],
    )
