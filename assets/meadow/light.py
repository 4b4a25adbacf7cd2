"""Light on a sample: shadow, occlusion, translucency, highlights, haze."""

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from meadow.noise import fbm, lattice_hash, value_noise
from meadow.world import (
    EYE_HEIGHT,
    FLORET,
    FOCAL_PX,
    FOLIAGE,
    GRASS,
    GROUND,
    LEAF,
    MATERIALS,
    PETAL,
    PITCH,
    STONE,
    SUN,
    WIDTH,
    WOOD,
    DoubleArray,
    FloatArray,
)


@njit(nogil=True)
def _sunlight(p: DoubleArray, depth: float, turn: float, maps: FloatArray, axes: DoubleArray,
              windows: DoubleArray) -> float:  # fmt: skip
    """Share of the sun's disc seen from `p`: five taps, turned by `turn` so that samples differ."""
    k = 0 if depth < 1.95 else (1 if depth < 7.0 else 2)
    s = maps.shape[1]
    x = (axes[0, 0] * p[0] + axes[0, 1] * p[1] + axes[0, 2] * p[2] - windows[k, 0]) * windows[k, 2]
    y = (axes[1, 0] * p[0] + axes[1, 1] * p[1] + axes[1, 2] * p[2] - windows[k, 1]) * windows[k, 2]
    h = axes[2, 0] * p[0] + axes[2, 1] * p[1] + axes[2, 2] * p[2]
    reach = max(1.2, 0.0022 * depth * windows[k, 2])
    bias = 0.0012 + 2.2 * reach / windows[k, 2]
    lit = 0.0
    for tap in range(5):
        angle = turn + 2.4 * tap
        r = reach * np.sqrt((tap + 0.5) / 5.0)
        i, j = int(np.floor(y + r * np.sin(angle))), int(np.floor(x + r * np.cos(angle)))
        if i < 0 or j < 0 or i >= s or j >= s or maps[k, i, j] <= h + bias:
            lit += 0.2
    return lit


@njit(nogil=True)
def _crevice(row: int, column: int, depth: float, turn: float, reach: float, nearness: FloatArray) -> float:
    """Screen-space ambient occlusion, 0 open to 1 closed, from six neighbours."""
    rows, columns = nearness.shape
    total = 0.0
    for tap in range(6):
        angle = turn + 2.4 * tap
        r = reach * ((tap + 0.5) / 6.0)
        i, j = row + int(r * np.sin(angle)), column + int(r * np.cos(angle))
        if i < 0 or j < 0 or i >= rows or j >= columns or nearness[i, j] <= 0:
            continue
        ahead = (depth - 1.0 / nearness[i, j]) / depth
        if ahead > 0.0015:
            total += min(1.0, ahead * 60.0) / (1.0 + (ahead * 14.0) ** 2)
    return total / 6.0


@njit(nogil=True)
def _pattern(material: int, u: float, v: float, p: DoubleArray, depth: float, color: DoubleArray) -> None:
    """Fine texture, applied to `color` in place."""
    k = np.floor(u / 2.0)
    s = u - 2.0 * k
    gain = 1.0
    if material == PETAL:
        gain += 0.20 * (value_noise(v * 7.0 + 40, s * 2.0, k) - 0.5)
        gain += 0.24 * (value_noise(v * 17.0 + 90, s * 3.0, k) - 0.5)
        gain += 0.08 * (value_noise(v * 12.0, s * 30.0, k) - 0.5)
    elif material == GRASS:
        gain += 0.30 * (value_noise(v * 3.5 + 20, s * 9.0, k) - 0.5)
        gain += 0.18 * (value_noise(v * 9.0 + 50, s * 3.0, k) - 0.5)
        if abs(v) < 0.14:
            gain *= 1.16
    elif material == LEAF:
        phase = (s - 0.32 * abs(v)) * 9.87
        vein = abs(phase - np.floor(phase + 0.5))
        thin = max(0.0, 1.0 - vein / 0.055) * 0.8 + max(0.0, 1.0 - abs(v) / 0.07)
        net = value_noise(p[0] * 330, p[1] * 330, p[2] * 330)
        gain = 0.93 + 0.25 * (fbm(p[0] * 30, p[1] * 30, p[2] * 30, 3) - 0.5) + 0.18 * (net - 0.5)
        color[0] += 0.050 * thin
        color[1] += 0.055 * thin
        color[2] += 0.022 * thin
    elif material == GROUND:
        if depth < 16.0:
            coarse = fbm(p[0] * 16, 3.0, p[2] * 16, 3)
            fine = fbm(p[0] * 90, 7.0, p[2] * 90, 2)
            gain = 1.0 + 0.9 * (coarse - 0.5) + 1.1 * (fine - 0.5)
        else:
            gain = 1.0 + 0.7 * (fbm(p[0] * 7, p[1] * 7, p[2] * 3, 4) - 0.5)
    elif material == STONE:
        grain = fbm(p[0] * 140, p[1] * 140, p[2] * 140, 3)
        gain = 0.8 + 0.55 * (fbm(p[0] * 26, p[1] * 26, p[2] * 26, 4) - 0.35) + 0.55 * (grain - 0.5)
        lichen = fbm(p[0] * 40 + 9, p[1] * 40, p[2] * 40, 3) - 0.56
        if lichen > 0:
            lichen = min(1.0, lichen * 9.0)
            color[0] += lichen * (0.30 - color[0])
            color[1] += lichen * (0.29 - color[1])
            color[2] += lichen * (0.17 - color[2])
    elif material == WOOD:
        gain = 1.0 + 0.45 * (value_noise(v * 5.0 + 30, s * 30.0, k) - 0.5)
    elif material == FLORET:
        gain = 1.0 + 0.25 * (value_noise(p[0] * 700, p[1] * 700, p[2] * 700) - 0.5)
    for c in range(3):
        color[c] = max(0.002, color[c] * gain)


@njit(nogil=True)
def _roughen(p: DoubleArray, normal: DoubleArray) -> None:
    """Tilt the normal of near ground by its crumbs and pebbles, in place."""
    e = 0.002
    here = fbm(p[0] * 55, 1.0, p[2] * 55, 3)
    normal[0] -= 0.020 * (fbm((p[0] + e) * 55, 1.0, p[2] * 55, 3) - here) / e
    normal[2] -= 0.020 * (fbm(p[0] * 55, 1.0, (p[2] + e) * 55, 3) - here) / e
    normal /= np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)


@njit(nogil=True)
def add_haze(x: float, y: float, z: float, out: DoubleArray) -> None:
    """Colour of the clear air towards the unit vector (x, y, z)."""
    up = max(y, 0.0)
    t = 1.0 - np.exp(-up * 5.2)
    warm = max(0.0, SUN[0] * x + SUN[2] * z) ** 2 * np.exp(-up * 6.0)
    low = (0.92 + 0.16 * warm, 0.95 + 0.04 * warm, 0.97 - 0.12 * warm)
    high = (0.085, 0.28, 0.80)
    for c in range(3):
        out[c] = low[c] * (1 - t) + high[c] * t


@njit(nogil=True)
def _tone(x: float) -> float:
    """Filmic curve (Narkowicz's fit of ACES), display-linear in 0..1."""
    x *= 0.64
    return min(1.0, max(0.0, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)))


@njit(nogil=True)
def _dot(a: DoubleArray, b: DoubleArray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(nogil=True)
def _blend(vertices: FloatArray, screen: FloatArray, triangle: NDArray[np.int32], i: int, j: int,
           out: DoubleArray) -> None:  # fmt: skip
    """Mean of the corners' normal, colour, (u, v) and openness, in perspective, into `out` (9,)."""
    a, b, c = triangle
    xa, ya, xb, yb = screen[a, 0], screen[a, 1], screen[b, 0], screen[b, 1]
    xc, yc = screen[c, 0], screen[c, 1]
    u = ((xb - j - 0.5) * (yc - i - 0.5) - (xc - j - 0.5) * (yb - i - 0.5)) * screen[a, 2]
    v = ((xc - j - 0.5) * (ya - i - 0.5) - (xa - j - 0.5) * (yc - i - 0.5)) * screen[b, 2]
    w = ((xa - j - 0.5) * (yb - i - 0.5) - (xb - j - 0.5) * (ya - i - 0.5)) * screen[c, 2]
    norm = u + v + w
    for k in range(9):
        out[k] = (u * vertices[a, 3 + k] + v * vertices[b, 3 + k] + w * vertices[c, 3 + k]) / norm
    size = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2) + 1e-9
    for k in range(3):
        out[k] /= size


@njit(nogil=True)
def _light(normal: DoubleArray, view: DoubleArray, color: DoubleArray, row: FloatArray, openness: float,
           sun: float, closed: float, out: DoubleArray) -> None:  # fmt: skip
    """Light that leaves a point towards the camera.

    Args:
        normal: Unit, facing the camera.
        view: Unit, towards the camera.
        color: Reflectance.
        row: Its row of `MATERIALS`.
        openness: Share of sky that its own plant leaves open.
        sun: Share of the sun's disc seen.
        closed: Ambient occlusion on the picture.
        out: Receives linear RGB.
    """
    facing = _dot(normal, SUN)
    wrap = row[3]
    front = max(0.0, (facing + wrap) / (1.0 + wrap))
    back = max(0.0, -facing)
    hx, hy, hz = SUN[0] + view[0], SUN[1] + view[1], SUN[2] + view[2]
    size = np.sqrt(hx * hx + hy * hy + hz * hz) + 1e-9
    shine = max(0.0, (normal[0] * hx + normal[1] * hy + normal[2] * hz) / size) ** row[2] * row[1] * sun
    rim = (1.0 - max(0.0, _dot(normal, view))) ** 4 * row[1] * 0.5
    open_air = openness * (1.0 - 0.85 * closed)
    dome = 0.5 + 0.5 * normal[1]
    sun_rgb = (3.95, 3.12, 2.12)
    sky_rgb = (0.60, 0.76, 1.05)
    bounce_rgb = (0.26, 0.27, 0.10)
    through_rgb = (1.00, 1.02, 0.50)
    white = min(color[0], color[1], color[2]) / (max(color[0], color[1], color[2]) + 1e-6)
    for c in range(3):
        pass_through = through_rgb[c] * (1 - white) + white
        direct = sun * sun_rgb[c] * (front * (1 - 0.5 * row[0]) + back * row[0] * 1.7 * pass_through)
        # Light that the leaves let through reaches even what stands in their shadow.
        stray = (1.0 - sun) * 0.16 * row[0] * sun_rgb[c] * pass_through * openness
        ambient = open_air * (sky_rgb[c] * dome + bounce_rgb[c] * (1.0 - dome) + 0.10)
        out[c] = color[c] * (direct + stray + ambient)
        out[c] += shine * sun_rgb[c] * 0.8 + rim * sky_rgb[c] * open_air


@njit(nogil=True, parallel=True)
def shade_samples(vertices: FloatArray, triangles: NDArray[np.int32], materials: NDArray[np.int8],
           screen: FloatArray, nearness: FloatArray, index: NDArray[np.int32], sky: FloatArray,
           samples: int, maps: FloatArray, axes: DoubleArray,
           windows: DoubleArray) -> FloatArray:  # fmt: skip
    """Mean display-linear colour of every pixel, (h, w, 3)."""
    height, width = sky.shape[:2]
    picture = np.zeros((height, width, 3), np.float32)
    focal = FOCAL_PX * width / WIDTH * samples
    reach = 30.0 * width / WIDTH * samples
    cos, sin = np.cos(PITCH), np.sin(PITCH)
    for y in prange(height):
        p, view, out, air, mixed = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(9)
        normal, color = mixed[:3], mixed[3:6]
        for x in range(width):
            total = np.zeros(3)
            for sub in range(samples * samples):
                i, j = y * samples + sub // samples, x * samples + sub % samples
                t = index[i, j]
                if t < 0:
                    for c in range(3):
                        total[c] += _tone(sky[y, x, c])
                    continue
                _blend(vertices, screen, triangles[t], i, j, mixed)
                depth = 1.0 / nearness[i, j]
                vx = (j + 0.5 - width * samples / 2) / focal
                vy = (i + 0.5 - height * samples / 2) / focal
                view[0], view[1], view[2] = -vx, vy * cos + sin, vy * sin - cos
                for c in range(3):
                    p[c] = -view[c] * depth
                p[1] += EYE_HEIGHT
                view /= np.sqrt(_dot(view, view))
                material = materials[t]
                if material != FOLIAGE and _dot(normal, view) < 0:
                    normal *= -1.0
                if material == GROUND and depth < 9.0:
                    _roughen(p, normal)
                _pattern(material, mixed[6], mixed[7], p, depth, color)
                turn = 6.2832 * lattice_hash(i, j, 5)
                sun = _sunlight(p, depth, turn, maps, axes, windows)
                closed = _crevice(i, j, depth, turn, reach, nearness)
                _light(normal, view, color, MATERIALS[material], mixed[8], sun, closed, out)
                clear = np.exp(-((depth * 0.0205) ** 1.7))
                add_haze(-view[0], max(-view[1], 0.02), -view[2], air)
                for c in range(3):
                    total[c] += _tone(out[c] * clear + 0.88 * air[c] * (1.0 - clear) * (0.96, 1.0, 1.07)[c])
            for c in range(3):
                picture[y, x, c] = total[c] / (samples * samples)
    return picture
