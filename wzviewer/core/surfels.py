"""Scale-adaptive Gaussian surfels g = {p, q, s, o, c, s_native} (paper, Sec. 3.1)."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.types import DoubleArray, FloatArray

SURFEL_SHAPES: dict[str, tuple[int, ...]] = {
    "means": (3,),
    "quats": (4,),
    "scales": (2,),
    "opacities": (),
    "colors": (3,),
    "native_scales": (),
    "coverage": (),
}


@dataclass(frozen=True, eq=False)
class Surfels:
    """Surfels of one level, a struct of float32 arrays in the level's local frame.

    Attributes:
        means: p, (n, 3), native pixels from the level's anchor.
        quats: q, (n, 4) wxyz, unit, local-from-surfel; the third axis is the normal.
        scales: s, (n, 2), standard deviations along the first two axes, native pixels.
        opacities: o, (n,), [0, 1].
        colors: c, (n, 3), sRGB-encoded [0, 1], blended as stored.
        native_scales: s_native over the level's unit, (n,); Eq. 1.
        coverage: m of the level and of its ancestors at p, (n,), [0, 1]; see `opacity`.

    Raises:
        ValueError: when lengths or shapes disagree.
    """

    means: FloatArray
    quats: FloatArray
    scales: FloatArray
    opacities: FloatArray
    colors: FloatArray
    native_scales: FloatArray
    coverage: FloatArray

    def __post_init__(self) -> None:
        n = len(self.means)
        for name, shape in SURFEL_SHAPES.items():
            array = np.ascontiguousarray(getattr(self, name), np.float32)
            if array.shape != (n, *shape):
                raise ValueError(f"{name} has shape {array.shape}, expected {(n, *shape)}")
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.means)

    @classmethod
    def empty(cls, n: int = 0) -> "Surfels":
        """Returns n surfels of zeros."""
        return cls(**{k: np.zeros((n, *s), np.float32) for k, s in SURFEL_SHAPES.items()})

    @classmethod
    def concatenate(cls, parts: "list[Surfels]") -> "Surfels":
        """Joins surfels in order."""
        if not parts:
            return cls.empty()
        return cls(**{k: np.concatenate([getattr(p, k) for p in parts]) for k in SURFEL_SHAPES})

    def take(self, index: slice | NDArray[Any]) -> "Surfels":
        """Returns the rows that a slice, a mask or an index array selects."""
        return Surfels(**{k: getattr(self, k)[index] for k in SURFEL_SHAPES})

    def with_(self, **arrays: FloatArray) -> "Surfels":
        """Returns a copy with some arrays replaced."""
        return replace(self, **arrays)

    def arrays(self) -> dict[str, FloatArray]:
        """Returns the arrays by name, in declaration order."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def moved(self, from_frame: LevelFrame, to_frame: LevelFrame) -> "Surfels":
        """Returns the surfels of one frame in another one; s_native keeps its length in the world.

        Args:
            from_frame: that they are in.
            to_frame: that they are to be in; float64 until the end, so levels may be x8^12 apart.
        """
        to_from = to_frame.axes @ from_frame.axes.T
        ratio = np.float32(from_frame.unit / to_frame.unit)
        means = (from_frame.to_world(self.means) - to_frame.origin) @ to_frame.axes.T / to_frame.unit
        lengths = {"scales": self.scales * ratio, "native_scales": self.native_scales * ratio}
        return self.with_(means=means.astype(np.float32), quats=turned(to_from, self.quats), **lengths)

    def pieces(self, size: int) -> "Iterator[tuple[int, Surfels]]":
        """Yields (start, surfels) in pieces of at most ``size``; one empty piece when empty."""
        for start in range(0, max(len(self), 1), size):
            yield start, self.take(slice(start, start + size))


def turned(rotation: DoubleArray, quats: FloatArray) -> FloatArray:
    """Turns quaternions (n, 4) wxyz by a rotation matrix (3, 3)."""
    w, x, y, z = _quat_of(rotation)
    product = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    return (quats @ product.T).astype(np.float32)


def _quat_of(rotation: DoubleArray) -> DoubleArray:
    """The unit quaternion (4,) wxyz of a rotation: the dominant eigenvector, defined for any angle."""
    r = rotation
    symmetric = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [0.0, r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [0.0, 0.0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [0.0, 0.0, 0.0, r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    return np.linalg.eigh(symmetric, UPLO="U")[1][:, -1]
