"""Thin parts: balls that hold them, and hairs widened to a pixel."""

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, DoubleArray
from wzviewer.worker.models.builtin.objects.primitives import BEZIER, CARD, CONE, LOFT, LOFT_STEP

LongArray = NDArray[np.int64]

LIMB_RADIUS = 0.06  # of a body length: the largest radius of what counts as a limb


def stamps(P: DoubleArray) -> tuple[DoubleArray, DoubleArray, LongArray]:
    """Returns (points, radii, owners): balls that hold each primitive, small ones along a thin part."""
    points, radii, owners = [P[:, 30:33]], [P[:, 33]], [np.arange(len(P))]
    thin = np.isin(P[:, 0], (BEZIER, CONE)) | _slender(P)
    t = np.linspace(0, 1, 9)[:, None]
    for i in np.flatnonzero(thin):
        row = P[i]
        if row[0] == BEZIER:
            a, b, c = row[16:19], row[19:22], row[22:25]
            curve, thick = (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c, row[25:27].max()
        elif row[0] == CONE:
            curve, thick = row[4:7] + t * row[16] * row[13:16], row[17:19].max()
        else:
            axes, (y0, y1, x0, x1, z0, z1) = row[7:16].reshape(3, 3), row[16:22]
            curve = (
                row[4:7] + (x0 + x1) / 2 * axes[0] + (z0 + z1) / 2 * axes[2] + (y0 + t * (y1 - y0)) * axes[1]
            )
            thick = float(np.hypot(x1 - x0, z1 - z0)) / 2
        step = np.linalg.norm(np.diff(curve, axis=0), axis=1).max()
        points.append(curve)
        blend = row[2] / (LOFT_STEP if row[0] == LOFT else 1.0)
        radii.append(np.full(9, thick + 0.5 * step + blend))
        owners.append(np.full(9, i))
    radii[0] = np.where(thin, -1e6, radii[0])  # replaced by their own chains
    return np.concatenate(points), np.concatenate(radii), np.concatenate(owners).astype(np.int64)


def _slender(P: DoubleArray) -> BoolArray:
    """Tells which lofts are clearly longer than wide (n,)."""
    long, wide = P[:, 17] - P[:, 16], np.hypot(P[:, 19] - P[:, 18], P[:, 21] - P[:, 20])
    return np.asarray((P[:, 0] == LOFT) & (long > 1.5 * wide))


def widened(P: DoubleArray, px: float) -> tuple[DoubleArray, DoubleArray]:
    """Returns primitives at least a pixel wide, and the share of a pixel that each really covers."""
    P, opacity = P.copy(), np.ones(len(P))
    for kind, columns in ((BEZIER, (25, 26)), (CONE, (17, 18))):
        rows = P[:, 0] == kind
        radius = P[rows][:, columns]
        opacity[rows] = np.minimum(1.0, radius.max(1) / (0.5 * px)) if rows.any() else 1.0
        P[np.ix_(rows, columns)] = np.maximum(radius, 0.5 * px)
    cards = P[:, 0] == CARD
    P[cards, 17] = np.maximum(P[cards, 17], 0.35 * px)
    P[:, 33] += 0.5 * px
    return P, opacity


TRUNK, LIMB, WING = 0, 1, 2


def kinds_of(P: DoubleArray, sheets: BoolArray) -> LongArray:
    """Tells what primitives (n,) belong to: a wing is before limbs and hairs, those before the trunk.

    Args:
        P: (n, 36) primitives.
        sheets: (n,) those that let light through.
    """
    tubes = np.isin(P[:, 0], (BEZIER, CONE))
    radius = np.where(P[:, 0] == CONE, P[:, 17:19].max(1), P[:, 25:27].max(1))
    thin = (P[:, 0] == CARD) | (tubes & (radius < LIMB_RADIUS))
    kinds = np.where(sheets, WING, np.where(thin, LIMB, TRUNK))
    for least in (LIMB, WING):  # what has no trunk is its own
        kinds[kinds == least] = TRUNK if not (kinds == TRUNK).any() else least
    return kinds.astype(np.int64)
