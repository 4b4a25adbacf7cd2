"""Dew: drops of many sizes on what faces the sky, each a small lens with a highlight and a shadow."""

import cv2
import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.lighting import (
    light_from_photo,
    linear_from_srgb,
    srgb_from_linear,
)


def bedewed(image: FloatArray, facing: FloatArray, amount: float, seed: int) -> FloatArray:
    """Returns the picture (h, w, 3) sRGB with drops; `facing` (h, w) 0..1 says where they gather."""
    h, w = facing.shape
    drops = _scattered(facing, amount, np.random.default_rng(seed))
    light = light_from_photo(image, (w / 2, h / 2), w / 4).direction
    lin = linear_from_srgb(image)
    out = lin.copy()
    for x, y, r, squash, turn in drops:
        _drop(out, lin, (x, y), r, squash, turn, light)
    return srgb_from_linear(out)


def _scattered(facing: FloatArray, amount: float, rng: np.random.Generator) -> DoubleArray:
    """Returns (n, 5): centre, radius, flattening, turn; log-normal radii, no two touching."""
    h, w = facing.shape
    radii = np.sort(np.exp(rng.normal(np.log(0.0085), 0.65, int(260 * amount))))[::-1] * w
    kept: list[tuple[float, float, float, float, float]] = []
    for r in np.clip(radii, 0.0025 * w, 0.042 * w):
        for _ in range(12):
            x, y = rng.uniform(r, w - r), rng.uniform(r, h - r)
            if rng.random() > 0.15 + 1.4 * float(facing[int(y), int(x)]):
                continue
            if all((x - a) ** 2 + (y - b) ** 2 > (1.12 * (r + c)) ** 2 for a, b, c, _, _ in kept):
                kept.append((x, y, float(r), float(rng.uniform(0.82, 1.0)), float(rng.uniform(0, np.pi))))
                break
    return np.asarray(kept, np.float64).reshape(-1, 5)


def _drop(
    out: FloatArray,
    lin: FloatArray,
    centre: tuple[float, float],
    radius: float,
    squash: float,
    turn: float,
    light: DoubleArray,
) -> None:
    """Draws one drop into `out` (linear), in place."""
    h, w = out.shape[:2]
    reach = 1.7 * radius + 2
    x0, x1 = max(int(centre[0] - reach), 0), min(int(centre[0] + reach) + 1, w)
    y0, y1 = max(int(centre[1] - reach), 0), min(int(centre[1] + reach) + 1, h)
    y, x = np.mgrid[y0:y1, x0:x1].astype(np.float32) + np.float32(0.5)
    u, v = (x - centre[0]) / radius, (y - centre[1]) / radius
    a, b = np.cos(turn) * u + np.sin(turn) * v, (np.cos(turn) * v - np.sin(turn) * u) / squash
    wobble = 1 + 0.05 * np.cos(2 * np.arctan2(b, a) + 3 * turn)
    rho = np.sqrt(a * a + b * b) / wobble
    alpha = np.clip((1 - rho) * radius + 0.5, 0, 1)[..., None]
    side = light[:2] / max(float(np.hypot(light[0], light[1])), 1e-6)
    # Shadow on the far side of the light, with the light that the drop gathers in its middle.
    du, dv = u + 0.35 * side[0], v + 0.35 * side[1]
    shadow = 0.42 * np.clip(1.25 - np.hypot(du, dv), 0, 0.5) / 0.5
    ground = out[y0:y1, x0:x1] * (1 - shadow * (rho > 0.9))[..., None]
    z = np.sqrt(np.clip(1 - rho**2, 0, 1))
    bend = np.float32(0.75 * radius) * (1 - z)
    scale = bend / np.maximum(np.hypot(u, v), 1e-3)
    at_x, at_y = (x - 0.5 - 2 * u * scale).astype(np.float32), (y - 0.5 - 2 * v * scale).astype(np.float32)
    seen = cv2.remap(lin, at_x, at_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
    toward = u * side[0] + v * side[1]
    inner = (0.95 + 0.75 * np.clip(-toward, 0, 1) ** 1.5 - 0.45 * np.clip(toward, 0, 1)) * (0.55 + 0.45 * z)
    glint = np.exp(-(((u - 0.42 * side[0]) ** 2 + (v - 0.42 * side[1]) ** 2) / 0.020)) * 1.6
    sky = 0.10 * np.clip(-v, 0, 1) * (1 - z) + 0.05
    drop = seen * inner[..., None] + (glint + sky)[..., None].astype(np.float32)
    out[y0:y1, x0:x1] = ground * (1 - alpha) + drop * alpha
