"""The solids of a training scene and where a ray meets them."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
Triple = tuple[float, float, float]

PLANE, BOX, ROOM, ELLIPSOID, CYLINDER, GABLE, PYRAMID, CONE = range(8)
# prims: type, centre (3), half size (3), cos yaw, sin yaw, material, porosity, porosity frequency
PRIM_COLUMNS = 12
FAR = 1e9


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _hash(ix: int, iy: int, iz: int, seed: int) -> float:
    h = (ix * 374761393 + iy * 668265263 + iz * 1440662683 + seed * 974634777) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFFFF) / 16777216.0


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def noise3(x: float, y: float, z: float, seed: int) -> float:
    """Value noise in [0, 1], trilinear between hashed lattice points."""
    fx, fy, fz = math.floor(x), math.floor(y), math.floor(z)
    ix, iy, iz = int(fx), int(fy), int(fz)
    u, v, w = x - fx, y - fy, z - fz
    u, v, w = u * u * (3 - 2 * u), v * v * (3 - 2 * v), w * w * (3 - 2 * w)
    total = 0.0
    for c in range(8):
        a, b, d = c & 1, (c >> 1) & 1, c >> 2
        weight = (u if a else 1 - u) * (v if b else 1 - v) * (w if d else 1 - w)
        total += weight * _hash(ix + a, iy + b, iz + d, seed)
    return total


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _slabs(o: Triple, d: Triple, half: Triple) -> tuple[float, ...]:
    """Entry and exit of a ray through a centred box, with the axis of each."""
    enter, leave, axis_in, axis_out = -FAR, FAR, 0, 0
    for k in range(3):
        inverse = 1.0 / d[k] if abs(d[k]) > 1e-9 else (1e9 if d[k] >= 0 else -1e9)
        a, b = (-half[k] - o[k]) * inverse, (half[k] - o[k]) * inverse
        if a > b:
            a, b = b, a
        if a > enter:
            enter, axis_in = a, k
        if b < leave:
            leave, axis_out = b, k
    return enter, leave, axis_in, axis_out


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _round(o: Triple, d: Triple, half: Triple, cylinder: bool) -> tuple[float, ...]:
    """Both roots of a ray with a unit sphere or an endless upright cylinder scaled by `half`."""
    ox, oy, oz = o[0] / half[0], o[1] / half[1], o[2] / half[2]
    dx, dy, dz = d[0] / half[0], d[1] / half[1], d[2] / half[2]
    if cylinder:
        oy = dy = 0.0
    a = dx * dx + dy * dy + dz * dz + 1e-12
    b = ox * dx + oy * dy + oz * dz
    c = ox * ox + oy * oy + oz * oz - 1
    root = b * b - a * c
    if root <= 0:
        return FAR, FAR
    root = math.sqrt(root)
    return (-b - root) / a, (-b + root) / a


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _roof(o: Triple, d: Triple, half: Triple, hipped: bool) -> tuple[float, ...]:
    """Entry of a ray into a gabled roof (ridge along z) or a pyramid, with the normal there; FAR if none."""
    enter, leave, ex, ey, ez = -FAR, FAR, 0.0, 0.0, 0.0
    for k in range(5):
        nx = 1.0 / half[0] if k == 0 else (-1.0 / half[0] if k == 1 else 0.0)
        nz = 1.0 / half[2] if k == 2 else (-1.0 / half[2] if k == 3 else 0.0)
        slanted = k < 2 or (hipped and k < 4)
        ny = 0.5 / half[1] if slanted else (-1.0 / half[1] if k == 4 else 0.0)
        gap = (0.5 if slanted else 1.0) - (nx * o[0] + ny * o[1] + nz * o[2])
        slope = nx * d[0] + ny * d[1] + nz * d[2]
        if abs(slope) < 1e-9:
            if gap < 0:
                return FAR, 0.0, 0.0, 0.0
            continue
        t = gap / slope
        if slope < 0:
            if t > enter:
                enter, ex, ey, ez = t, nx, ny, nz
        elif t < leave:
            leave = t
    if enter >= leave:
        return FAR, 0.0, 0.0, 0.0
    length = math.sqrt(ex * ex + ey * ey + ez * ez) + 1e-12
    return enter, ex / length, ey / length, ez / length


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _cone(o: Triple, d: Triple, half: Triple, near: float) -> tuple[float, ...]:
    """First hit beyond `near` of an upright cone (apex at +half[1], open below) and its normal."""
    ox, oz, dx, dz = o[0] / half[0], o[2] / half[2], d[0] / half[0], d[2] / half[2]
    oy, dy = (half[1] - o[1]) / (2 * half[1]), -d[1] / (2 * half[1])
    a = dx * dx + dz * dz - dy * dy
    b = ox * dx + oz * dz - oy * dy
    c = ox * ox + oz * oz - oy * oy
    root = b * b - a * c
    if root <= 0 or abs(a) < 1e-12:
        return FAR, 0.0, 0.0, 0.0
    root = math.sqrt(root)
    first, second = (-b - root) / a, (-b + root) / a
    if first > second:
        first, second = second, first
    for t in (first, second):
        if t > near and 0.0 <= oy + t * dy <= 1.0:
            nx, nz = (ox + t * dx) / half[0], (oz + t * dz) / half[2]
            ny = (oy + t * dy) / (2 * half[1])
            length = math.sqrt(nx * nx + ny * ny + nz * nz) + 1e-12
            return t, nx / length, ny / length, nz / length
    return FAR, 0.0, 0.0, 0.0


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _solid(p: FloatArray, o: Triple, d: Triple, t: float) -> bool:
    """False where porosity (leaves) lets the ray through."""
    if p[10] <= 0:
        return True
    f = p[11]
    n = noise3((o[0] + t * d[0]) * f, (o[1] + t * d[1]) * f, (o[2] + t * d[2]) * f, 7)
    return n >= p[10]


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def hit(p: FloatArray, o: Triple, d: Triple, near: float) -> tuple[float, ...]:
    """Distance beyond `near` (FAR = none) and the normal in the primitive's axes, then its local point."""
    rx, ry, rz = o[0] - p[1], o[1] - p[2], o[2] - p[3]
    if p[0] != 0 and p[0] != 2:  # most rays pass by the bounding sphere
        along = rx * d[0] + ry * d[1] + rz * d[2]
        square = p[4] * p[4] + p[5] * p[5] + p[6] * p[6]
        off = rx * rx + ry * ry + rz * rz
        if off > square and (
            along > 0 or (off - square) * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) > along * along
        ):
            return FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    c, s = p[7], p[8]
    lo = (c * rx - s * rz, ry, s * rx + c * rz)
    ld = (c * d[0] - s * d[2], d[1], s * d[0] + c * d[2])
    half = (p[4], p[5], p[6])
    t, nx, ny, nz = FAR, 0.0, 0.0, 0.0
    kind = int(p[0])
    if kind == 0:
        if ld[1] < -1e-6:
            t, ny = -lo[1] / ld[1], 1.0
    elif kind <= 2:
        enter, leave, axis_in, axis_out = _slabs(lo, ld, half)
        inside = kind == 2
        axis = axis_out if inside else axis_in
        if leave > enter:
            t = leave if inside else enter
            sign = -1.0 if ld[axis] > 0 else 1.0
            nx = sign if axis == 0 else 0.0
            ny = sign if axis == 1 else 0.0
            nz = sign if axis == 2 else 0.0
    elif kind == 7:
        t, nx, ny, nz = _cone(lo, ld, half, near)
    elif kind >= 5:
        t, nx, ny, nz = _roof(lo, ld, half, kind == 6)
    else:
        first, second = _round(lo, ld, half, kind == 4)
        for root in (first, second):
            y = lo[1] + root * ld[1]
            if root > near and root < FAR and (kind == 3 or abs(y) < half[1]) and _solid(p, lo, ld, root):
                t = root
                break
        if t < FAR:
            nx = (lo[0] + t * ld[0]) / (half[0] * half[0])
            ny = 0.0 if kind == 4 else (lo[1] + t * ld[1]) / (half[1] * half[1])
            nz = (lo[2] + t * ld[2]) / (half[2] * half[2])
            length = math.sqrt(nx * nx + ny * ny + nz * nz) + 1e-12
            nx, ny, nz = nx / length, ny / length, nz / length
    if t <= near or t >= FAR or ((kind < 3 or kind > 4) and not _solid(p, lo, ld, t)):
        return FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # local point for the patterns, normal back in world axes
    return (t, c * nx + s * nz, ny, -s * nx + c * nz, lo[0] + t * ld[0], lo[1] + t * ld[1], lo[2] + t * ld[2])
