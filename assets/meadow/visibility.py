"""Which triangle a sample of the camera or of the sun sees first."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from meadow.sheets import frame_about
from meadow.world import EYE_HEIGHT, FOCAL_PX, PITCH, SUN, WIDTH, DoubleArray, FloatArray


@njit(nogil=True)
def rasterize(
    screen: FloatArray, triangles: NDArray[np.int32], nearness: FloatArray, index: NDArray[np.int32]
) -> None:
    """Keep for every sample the triangle of greatest nearness (column 2 of `screen`, linear there)."""
    rows, columns = nearness.shape
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t]
        wa, wb, wc = screen[a, 2], screen[b, 2], screen[c, 2]
        if not (wa > -1e29 and wb > -1e29 and wc > -1e29):
            continue
        xa, ya = float(screen[a, 0]), float(screen[a, 1])
        xb, yb = float(screen[b, 0]), float(screen[b, 1])
        xc, yc = float(screen[c, 0]), float(screen[c, 1])
        left = max(0, int(np.ceil(min(xa, xb, xc) - 0.5)))
        right = min(columns - 1, int(np.floor(max(xa, xb, xc) - 0.5)))
        top = max(0, int(np.ceil(min(ya, yb, yc) - 0.5)))
        bottom = min(rows - 1, int(np.floor(max(ya, yb, yc) - 0.5)))
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area == 0.0 or left > right or top > bottom:
            continue
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                u = ((xb - x - 0.5) * (yc - y - 0.5) - (xc - x - 0.5) * (yb - y - 0.5)) / area
                v = ((xc - x - 0.5) * (ya - y - 0.5) - (xa - x - 0.5) * (yc - y - 0.5)) / area
                s = 1.0 - u - v
                if u >= 0.0 and v >= 0.0 and s >= 0.0:
                    near = u * wa + v * wb + s * wc
                    if near > nearness[y, x]:
                        nearness[y, x] = near
                        index[y, x] = t


def project_vertices(points: FloatArray, width: int, height: int, samples: int) -> FloatArray:
    """(n, 3): sample coordinates and inverse depth; behind the camera the third is -1e30."""
    focal = FOCAL_PX * width / WIDTH * samples
    p = points.astype(np.float64) - [0.0, EYE_HEIGHT, 0.0]
    depth = p[:, 2] * np.cos(PITCH) - p[:, 1] * np.sin(PITCH)
    down = -p[:, 1] * np.cos(PITCH) - p[:, 2] * np.sin(PITCH)
    safe = np.maximum(depth, 0.3)
    x = focal * p[:, 0] / safe + width * samples / 2
    y = focal * down / safe + height * samples / 2
    return np.stack([x, y, np.where(depth > 0.3, 1 / safe, -1e30)], -1).astype(np.float32)


@dataclass(frozen=True)
class Shadow:
    """Height towards the sun of what it meets first, seen from the sun over three nested regions."""

    maps: FloatArray  # (3, s, s)
    axes: DoubleArray  # (3, 3): two axes across the sun's direction, and the direction
    windows: DoubleArray  # (3, 3): least x, least y, texels for a unit


def sun_view(vertices: FloatArray, triangles: NDArray[np.int32], texels: int) -> Shadow:
    """Three depth maps as the sun sees the meadow, from what is near to all of it."""
    axes = frame_about(SUN)
    seen = vertices[:, :3].astype(np.float64) @ axes.T
    maps = np.full((3, texels, texels), -1e30, np.float32)
    windows = np.empty((3, 3))
    z, slope = vertices[:, 2], vertices[:, 0] / vertices[:, 2]
    for k, limit in enumerate((2.1, 7.5, 200.0)):
        inside = seen[(z < limit) & (np.abs(slope) < 0.60)]
        low, high = inside[:, :2].min(0), inside[:, :2].max(0)
        windows[k] = low[0], low[1], texels / (high - low).max()
        screen = np.empty((len(seen), 3), np.float32)
        screen[:, :2] = (seen[:, :2] - low) * windows[k, 2]
        screen[:, 2] = seen[:, 2]
        rasterize(screen, triangles, maps[k], np.empty((texels, texels), np.int32))
    return Shadow(maps, axes, windows)
