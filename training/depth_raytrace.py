"""One ray per pixel through a handful of primitives: colour and inverse depth of a training scene.

World axes: x right, y up, z forward; camera rays have unit z *in camera axes*, so the ray parameter
is the depth.  Rows of `prims` and `materials` are laid out by the constants below; everything is
deterministic (hashed value noise, no random state).
"""

import math

import numpy as np
from depth_solids import FAR, hit, noise3
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
Triple = tuple[float, float, float]

# materials: colours a, b, c (9), noise frequency, contrast, pattern, pattern size, glow, seed
MATERIAL_COLUMNS = 15
PLAIN, STRIPES, WINDOWS, BRICKS, CHECKER, BLOTCHES, PLANKS, ROAD, SHORE = range(9)


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


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _may_cross(prims: FloatArray, normals: FloatArray, eye: FloatArray) -> NDArray[np.bool_]:
    """(n, m): whether primitive n reaches the plane m through the eye; planes and rooms always do."""
    crosses = np.ones((prims.shape[0], normals.shape[0]), np.bool_)
    for k in range(prims.shape[0]):
        p = prims[k]
        if p[0] == 0 or p[0] == 2:
            continue
        radius = math.sqrt(p[4] * p[4] + p[5] * p[5] + p[6] * p[6])
        for m in range(normals.shape[0]):
            n = normals[m]
            off = n[0] * (p[1] - eye[0]) + n[1] * (p[2] - eye[1]) + n[2] * (p[3] - eye[2])
            crosses[k, m] = abs(off) <= radius
    return crosses


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _fan(rotation: FloatArray, count: int, focal: float, center: float, axis: int) -> FloatArray:
    """Unit normals (count, 3) of the planes through the eye and each image row (axis 1) or column (0)."""
    normals = np.empty((count, 3), np.float32)
    for i in range(count):
        slope = (i + 0.5 - center) / focal
        length = math.sqrt(1 + slope * slope)
        for k in range(3):
            normals[i, k] = (rotation[k, axis] - slope * rotation[k, 2]) / length
    return normals


@njit(cache=True, fastmath={"contract", "reassoc", "arcp", "nsz"}, error_model="numpy")
def _sunward(prims: FloatArray, light: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two axes (2, 3) across a distant light, and the primitives' places and squared radii there (n, 3)."""
    length = math.sqrt(light[0] * light[0] + light[1] * light[1] + light[2] * light[2]) + 1e-9
    x, y, z = light[0] / length, light[1] / length, light[2] / length
    across = math.sqrt(x * x + y * y) + 1e-9
    axes = np.zeros((2, 3), np.float32)
    axes[0, 0], axes[0, 1] = y / across, -x / across
    axes[1, 0], axes[1, 1], axes[1, 2] = x * z / across, y * z / across, -across
    places = np.empty((prims.shape[0], 3), np.float32)
    for k in range(prims.shape[0]):
        p = prims[k]
        for a in range(2):
            places[k, a] = axes[a, 0] * p[1] + axes[a, 1] * p[2] + axes[a, 2] * p[3]
        places[k, 2] = p[4] * p[4] + p[5] * p[5] + p[6] * p[6]
        if p[0] == 0 or light[4] > 0:
            places[k, 2] = FAR
    return axes, places


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
    upright: FloatArray,
) -> None:
    """Fills `color` (h, w, 3), `disparity` and `upright` (h, w); pixels that meet nothing keep what they had.

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
        upright: written, 1 on what stands (walls, roofs, round things), 0 on floors, tops, ceilings.
    """
    h, w = disparity.shape
    albedo = np.zeros(3, np.float32)
    o = (float(eye[0]), float(eye[1]), float(eye[2]))
    in_row = _may_cross(prims, _fan(rotation, h, lens[0], lens[2], 1), eye)
    in_column = _may_cross(prims, _fan(rotation, w, lens[0], lens[1], 0), eye)
    axes, places = _sunward(prims, light)
    active = np.empty(prims.shape[0], np.int64)
    for i in range(h):
        count = 0
        for k in range(prims.shape[0]):
            if in_row[k, i]:
                active[count] = k
                count += 1
        for j in range(w):
            cu, cv = (j + 0.5 - lens[1]) / lens[0], (i + 0.5 - lens[2]) / lens[0]
            d = (
                float(rotation[0, 0] * cu + rotation[0, 1] * cv + rotation[0, 2]),
                float(rotation[1, 0] * cu + rotation[1, 1] * cv + rotation[1, 2]),
                float(rotation[2, 0] * cu + rotation[2, 1] * cv + rotation[2, 2]),
            )
            best, nx, ny, nz, px, py, pz, which = FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1
            solid = 0
            for slot in range(count):
                k = active[slot]
                if not in_column[k, j]:
                    continue
                t, a, b, c, lx, ly, lz = hit(prims[k], o, d, 0.05)
                if t < best:
                    best, nx, ny, nz, px, py, pz, which = t, a, b, c, lx, ly, lz, int(prims[k, 9])
                    solid = int(prims[k, 0])
                    if prims[k, 0] == 2 and abs(b) > 0.5:
                        which += 1 if b > 0 else 2
            if span > 0:
                t = _march(field, span, o, d)
                if t < best:
                    best, which, solid = t, field_material, 0
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
                pa = axes[0, 0] * so[0] + axes[0, 1] * so[1] + axes[0, 2] * so[2]
                pb = axes[1, 0] * so[0] + axes[1, 1] * so[1] + axes[1, 2] * so[2]
                for k in range(prims.shape[0]):
                    da, db = places[k, 0] - pa, places[k, 1] - pb
                    if da * da + db * db > places[k, 2]:
                        continue
                    if prims[k, 0] != 2 and hit(prims[k], so, (lx, ly, lz), 0.02)[0] < reach:
                        lit = 0.0
                        break
            shade = light[3] + (1 - light[3]) * max(lit, 0.0) + glow
            for k in range(3):
                color[i, j, k] = albedo[k] * shade
            disparity[i, j] = 1.0 / best
            upright[i, j] = 1.0 if solid > 2 or abs(ny) < 0.7 else 0.0
