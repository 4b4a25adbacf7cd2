"""The finished form of a surfel: 26 bytes on disk, and the same numbers everywhere.

A level is rounded to this form before it is committed, so memory, file and GPU hold the same values
and a round trip is exact.  ``native_scales`` and ``coverage`` are functions of the position and the
cameras, so they are computed and not stored::

    means    3 x f32   12 bytes          scales     2 x f16, log2     4 bytes
    quats    3 x i16    6 bytes, w >= 0  colors     4 x u8, with o    4 bytes
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.surfels import Surfels
from wzviewer.core.types import FloatArray

Packed = dict[str, NDArray[Any]]
PACKED_DTYPES = {"means": ("<f4", 3), "quats": ("<i2", 3), "scales": ("<f2", 2), "colors": ("u1", 4)}
LOG_SCALE_LIMIT = 60.0  # log2 of native pixels, well inside float16 and beyond any surfel
SNORM16 = 32767


def pack(surfels: Surfels) -> Packed:
    """Rounds surfels to their finished form; idempotent with `unpack`.

    Returns:
        ``means`` (n, 3) f32, ``quats`` (n, 3) i16, ``scales`` (n, 2) f16, ``colors`` (n, 4) u8.
    """
    rgba = np.concatenate([surfels.colors, surfels.opacities[:, None]], axis=1)
    log_scales = np.log2(np.maximum(surfels.scales, np.float32(1e-18)))
    return {
        "means": surfels.means.astype("<f4"),
        "quats": _pack_quats(surfels.quats),
        "scales": np.clip(log_scales, -LOG_SCALE_LIMIT, LOG_SCALE_LIMIT).astype("<f2"),
        "colors": np.rint(np.clip(rgba, 0.0, 1.0) * 255.0).astype(np.uint8),
    }


def unpack(packed: Packed, native_scales: FloatArray, coverage: FloatArray) -> Surfels:
    """Restores surfels from their finished form.

    Args:
        packed: as `pack` returns it.
        native_scales: (n,) s_native over the level's unit.
        coverage: (n,) product of m over the level and its ancestors.

    Raises:
        ValueError: when names, types or shapes are not those of `PACKED_DTYPES`.
    """
    check_packed(packed)
    rgba = packed["colors"].astype(np.float32) / np.float32(255.0)
    scales = np.exp2(packed["scales"].astype(np.float32))
    quats = _unpack_quats(packed["quats"])
    means = packed["means"].astype(np.float32)
    return Surfels(means, quats, scales, rgba[:, 3], rgba[:, :3], native_scales, coverage)


def check_packed(packed: Packed) -> None:
    """Raises ValueError unless names, types, shapes and values are those of packed surfels."""
    n = len(packed.get("means", ()))
    for name, (dtype, columns) in PACKED_DTYPES.items():
        array = packed.get(name)
        if array is None or array.dtype != np.dtype(dtype) or array.shape != (n, columns):
            raise ValueError(f"surfel array {name!r} is missing or malformed")
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError(f"surfel array {name!r} holds values that are not finite")


def rounded(surfels: Surfels) -> Surfels:
    """Returns the surfels as they will be after a round trip through `pack` and `unpack`."""
    return unpack(pack(surfels), surfels.native_scales, surfels.coverage)


def _pack_quats(quats: FloatArray) -> NDArray[np.int16]:
    q = quats / np.maximum(np.linalg.norm(quats, axis=1, keepdims=True), np.float32(1e-12))
    q = np.where(q[:, :1] < 0, -q, q)
    xyz = np.rint(q[:, 1:].astype(np.float64) * SNORM16).astype(np.int64)
    # Rounding may lift (x, y, z) off the unit ball; w would be lost and packing twice would differ.
    while len(over := np.flatnonzero((xyz * xyz).sum(axis=1) > SNORM16 * SNORM16)):
        axis = np.abs(xyz[over]).argmax(axis=1)
        xyz[over, axis] -= np.sign(xyz[over, axis])
    return xyz.astype("<i2")


def _unpack_quats(packed: NDArray[Any]) -> FloatArray:
    xyz = packed.astype(np.float64) / SNORM16
    w = np.sqrt(np.maximum(0.0, 1.0 - (xyz * xyz).sum(axis=1)))
    return np.concatenate([w[:, None], xyz], axis=1).astype(np.float32)
