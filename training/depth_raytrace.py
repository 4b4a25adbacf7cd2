"""One ray per pixel through a handful of primitives: colour and inverse depth of a training scene.

World axes: x right, y up, z forward; camera rays have unit z *in camera axes*, so the ray parameter
is the depth.  Rows of `prims` and `materials` are laid out by the constants below; everything is
deterministic (hashed value noise, no random state).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
Triple = tuple[float, float, float]

PLANE, BOX, ROOM, ELLIPSOID, CYLINDER = 0, 1, 2, 3, 4
# prims: type, centre (3), half size (3), cos yaw, sin yaw, material, porosity, porosity frequency
PRIM_COLUMNS = 12
# materials: colours a, b, c (9), noise frequency, contrast, pattern, pattern size, glow, seed
MATERIAL_COLUMNS = 15
PLAIN, STRIPES, WINDOWS, BRICKS, CHECKER, BLOTCHES, PLANKS, ROAD, SHORE = range(9)
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
def _solid(p: FloatArray, o: Triple, d: Triple, t: float) -> bool:
    """False where porosity (leaves) lets the ray through."""
    if p[10] <= 0:
        return True
    f = p[11]
    n = noise3((o[0] + t * d[0]) * f, (o[1] + t * d[1]) * f, (o[2] + t * d[2]) * f, 7)
    return n >= p[10]


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _hit(p: FloatArray, o: Triple, d: Triple, near: float) -> tuple[float, ...]:
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
    if t <= near or t >= FAR or (kind < 3 and not _solid(p, lo, ld, t)):
        return FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # local point for the patterns, normal back in world axes
    return (t, c * nx + s * nz, ny, -s * nx + c * nz, lo[0] + t * ld[0], lo[1] + t * ld[1], lo[2] + t * ld[2])


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _height(field: FloatArray, span: float, x: float, z: float) -> float:
    """Bilinear height; the field covers x in [-span, span], z in [0, 2 span]."""
    n = field.shape[0]
    u = min(max((x + span) / (2 * span) * (n - 1), 0.0), n - 1.001)
    v = min(max(z / (2 * span) * (n - 1), 0.0), n - 1.001)
    i, j = int(v), int(u)
    a, b = v - i, u - j
    top = field[i, j] * (1 - b) + field[i, j + 1] * b
    return top * (1 - a) + (field[i + 1, j] * (1 - b) + field[i + 1, j + 1] * b) * a


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _march(field: FloatArray, span: float, o: Triple, d: Triple) -> float:
    """Depth at which the ray dips under the height field, bisected; FAR if never."""
    t, before = 0.02 * span / 40, 0.0
    while t < 2 * span:
        x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
        if abs(x) > span or z > 2 * span:
            return FAR
        gap = y - _height(field, span, x, z)
        if gap < 0:
            low, high = before, t
            for _ in range(6):
                mid = 0.5 * (low + high)
                if o[1] + mid * d[1] < _height(field, span, o[0] + mid * d[0], o[2] + mid * d[2]):
                    high = mid
                else:
                    low = mid
            return high
        before = t
        t += max(0.025 * t, 0.25 * gap)
    return FAR


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _pattern(kind: int, u: float, v: float, x: float, z: float, seed: int) -> float:
    """Share of the third colour, u and v in units of the pattern's size."""
    fu, fv = u - math.floor(u), v - math.floor(v)
    if kind == 1:
        return 1.0 if fu < 0.5 else 0.0
    if kind == 2:
        return 1.0 if 0.22 < fu < 0.75 and 0.25 < fv < 0.8 else 0.0
    if kind == 3:
        shifted = u * 0.5 + (0.5 if int(np.floor(v)) % 2 == 0 else 0.0)
        return 1.0 if fv < 0.12 or shifted - math.floor(shifted) < 0.06 else 0.0
    if kind == 4:
        return 1.0 if (int(np.floor(u)) + int(np.floor(v))) % 2 == 0 else 0.0
    if kind == 5:
        return 1.0 if noise3(u, v, 3.3, seed) > 0.55 else 0.0
    if kind == 6:
        return 1.0 if fv < 0.07 else 0.0
    if kind == 7:
        return 1.0 if abs(x) < 1.0 else 0.0
    if kind == 8:
        return 1.0 if z + 1.2 * noise3(x, z, 0.5, seed) > 3.0 else 0.0
    return 0.0


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _paint(m: FloatArray, face: int, p: Triple, world: Triple, footprint: float, out: FloatArray) -> None:
    """Albedo at a hit: two colours by noise (faded by the pixel's footprint), a third by the pattern."""
    seed = int(m[14])
    value, amplitude, f = 0.0, 0.5, m[9]
    for _ in range(4):
        fade = min(max(1.4 - 1.6 * footprint * f, 0.0), 1.0)
        if fade > 0:
            value += amplitude * fade * (noise3(world[0] * f, world[1] * f, world[2] * f, seed) - 0.5)
        f, amplitude = f * 2.3, amplitude * 0.75
    mix = min(max(0.5 + m[10] * value, 0.0), 1.0)
    u = p[2] if face == 0 else p[0]
    v = p[2] if face == 1 else p[1]
    size = m[12]
    share = 0.0
    if m[11] > 0:
        share = _pattern(int(m[11]), u / size, v / size, p[0] / size, p[2] / size, seed)
        if m[11] < 7:
            share *= min(max(1.5 - 2.0 * footprint / size, 0.0), 1.0)
    shade = 1.0 + 0.5 * m[10] * value
    for k in range(3):
        base = m[k] * (1 - mix) + m[3 + k] * mix
        out[k] = (base * (1 - share) + m[6 + k] * share) * shade


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def render(
    prims: FloatArray,
    materials: FloatArray,
    field: FloatArray,
    span: float,
    field_material: int,
    rotation: FloatArray,
    eye: FloatArray,
    lens: FloatArray,
    light: FloatArray,
    color: FloatArray,
    disparity: FloatArray,
) -> None:
    """Fills `color` (h, w, 3) and `disparity` (h, w); pixels that meet nothing keep what they had.

    Args:
        prims: (n, PRIM_COLUMNS).
        materials: (m, MATERIAL_COLUMNS).
        field: (k, k) heights.
        span: half the width that the field covers; 0 switches it off.
        field_material: its row of materials.
        rotation: (3, 3) world_from_camera, camera axes x right, y down, z forward.
        eye: (3,) camera position.
        lens: focal_px, cx, cy.
        light: x, y, z, ambient, 1 for a point light (position) or 0 for a direction.
        color: written.
        disparity: written, 1/z.
    """
    h, w = disparity.shape
    albedo = np.zeros(3, np.float32)
    o = (float(eye[0]), float(eye[1]), float(eye[2]))
    for i in range(h):
        for j in range(w):
            cu, cv = (j + 0.5 - lens[1]) / lens[0], (i + 0.5 - lens[2]) / lens[0]
            d = (
                float(rotation[0, 0] * cu + rotation[0, 1] * cv + rotation[0, 2]),
                float(rotation[1, 0] * cu + rotation[1, 1] * cv + rotation[1, 2]),
                float(rotation[2, 0] * cu + rotation[2, 1] * cv + rotation[2, 2]),
            )
            best, nx, ny, nz, px, py, pz, which = FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1
            for k in range(prims.shape[0]):
                t, a, b, c, lx, ly, lz = _hit(prims[k], o, d, 0.05)
                if t < best:
                    best, nx, ny, nz, px, py, pz, which = t, a, b, c, lx, ly, lz, int(prims[k, 9])
                    if prims[k, 0] == 2 and abs(b) > 0.5:
                        which += 1 if b > 0 else 2
            if span > 0:
                t = _march(field, span, o, d)
                if t < best:
                    best, which = t, field_material
                    px, py, pz = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
                    e = 0.004 * t + span / field.shape[0]
                    nx = _height(field, span, px - e, pz) - _height(field, span, px + e, pz)
                    nz = _height(field, span, px, pz - e) - _height(field, span, px, pz + e)
                    length = math.sqrt(nx * nx + nz * nz + 4 * e * e)
                    nx, ny, nz = nx / length, 2 * e / length, nz / length
            if best > 1e5:
                continue
            x, y, z = o[0] + best * d[0], o[1] + best * d[1], o[2] + best * d[2]
            face = 0 if abs(nx) > 0.7 else (1 if abs(ny) > 0.7 else 2)
            _paint(materials[which], face, (px, py, pz), (x, y, z), best / lens[0], albedo)
            lx, ly, lz = light[0], light[1], light[2]
            if light[4] > 0:
                lx, ly, lz = lx - x, ly - y, lz - z
            length = math.sqrt(lx * lx + ly * ly + lz * lz) + 1e-9
            lx, ly, lz = lx / length, ly / length, lz / length
            lit = nx * lx + ny * ly + nz * lz
            glow = materials[which, 13]
            if lit > 0:
                reach = length if light[4] > 0 else 1e5
                so = (x + 0.02 * best * nx / 4, y + 0.02 * best * ny / 4, z + 0.02 * best * nz / 4)
                for k in range(prims.shape[0]):
                    if prims[k, 0] != 2 and _hit(prims[k], so, (lx, ly, lz), 0.02)[0] < reach:
                        lit = 0.0
                        break
            shade = light[3] + (1 - light[3]) * max(lit, 0.0) + glow
            for k in range(3):
                color[i, j, k] = albedo[k] * shade
            disparity[i, j] = 1.0 / best
