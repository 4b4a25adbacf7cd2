"""The sky, and clouds marched through their layer."""

import numpy as np
from numba import njit, prange

from meadow.light import add_haze
from meadow.noise import fbm
from meadow.world import FOCAL_PX, PITCH, SUN, WIDTH, FloatArray


@njit(nogil=True)
def _cloud(x: float, y: float, z: float, octaves: int) -> float:
    """Density of the cumulus layer between heights 1 and 2: flat bases, heaped tops."""
    h = y - 1.0
    if h <= 0.0 or h >= 1.0:
        return 0.0
    cover = fbm(x * 0.42 + 14.3, 2.0, z * 0.34 + 3.7, 4)
    top = (cover - 0.535) * 4.2
    if top + 0.42 < h:
        return 0.0
    heap = fbm(x * 2.1, y * 2.4, z * 1.9, octaves) - 0.5
    return max(0.0, min(1.0, h * 12.0 + 0.2) * (min(top, 0.75) - h + 1.35 * heap)) * 16.0


@njit(nogil=True, parallel=True)
def sky_picture(width: int, height: int) -> FloatArray:
    """Linear colour of the sky behind every pixel, (h, w, 3), clouds marched through their layer."""
    out = np.zeros((height, width, 3), np.float32)
    focal = FOCAL_PX * width / WIDTH
    cos, sin = np.cos(PITCH), np.sin(PITCH)
    for i in prange(height):
        air = np.empty(3)
        for j in range(width):
            vx, vy = (j + 0.5 - width / 2) / focal, (i + 0.5 - height / 2) / focal
            n = np.sqrt(vx * vx + vy * vy + 1)
            dx, dy, dz = vx / n, (-vy * cos - sin) / n, (-vy * sin + cos) / n
            add_haze(dx, dy, dz, air)
            out[i, j] = air
            if dy < 0.012:
                continue
            clear, r, g, b, steps = 1.0, 0.0, 0.0, 0.0, 110
            step = min(1.0 / dy, 26.0) / steps
            for k in range(steps):
                t = 1.0 / dy + (k + 0.5) * step
                x, y, z = dx * t, dy * t, dz * t
                density = _cloud(x, y, z, 5) * min(1.0, max(0.0, (17.0 - t) / 7.0))
                if density <= 0.0:
                    continue
                shadow = 0.0
                for m in range(1, 5):
                    s = 0.05 * m * m
                    shadow += _cloud(x + SUN[0] * s, y + SUN[1] * s, z + SUN[2] * s, 3) * 0.05 * (2 * m - 1)
                lit = np.exp(-1.5 * shadow) * 0.75 + 0.25 * np.exp(-0.3 * shadow)
                passed = np.exp(-density * min(step, 0.12) * 2.2)
                kept = clear * (1.0 - passed)
                far = 1.0 - np.exp(-((t * 0.055) ** 1.5))
                body_r, body_g, body_b = 0.56 + 1.35 * lit, 0.64 + 1.17 * lit, 0.77 + 0.93 * lit
                r += kept * (body_r * (1 - far) + 1.0 * air[0] * far)
                g += kept * (body_g * (1 - far) + 1.0 * air[1] * far)
                b += kept * (body_b * (1 - far) + 1.0 * air[2] * far)
                clear *= passed
                if clear < 0.01:
                    break
            out[i, j, 0] = air[0] * clear + r
            out[i, j, 1] = air[1] * clear + g
            out[i, j, 2] = air[2] * clear + b
    return out
