"""Dew: drops of many sizes on what faces the sky, each a small lens with a highlight and a shadow.

At a deeper level the same drops are drawn again (`redrawn`): the outline, the contact line, the
window in the highlight and what the lens shows of its surroundings are as sharp as the new pixels are.
"""

import cv2
import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.lighting import linear_from_srgb, srgb_from_linear

_LEAST_PX = 4.0  # a drop of a smaller radius is not drawn again
_HALO = 1.3  # of the coarser level's pixels, how far a drop's edge has bled
_GLINT = 0.42  # of the radius, where the highlight lies towards the light


class _Disc:
    """The pixels around one drop, in its own coordinates."""

    def __init__(self, shape: tuple[int, int], drop: DoubleArray, light: DoubleArray) -> None:
        h, w = shape
        x, y, self.radius, squash, turn = (float(v) for v in drop)
        self.centre = x, y
        reach = 1.7 * self.radius + 2
        x0, x1 = max(int(x - reach), 0), min(int(x + reach) + 1, w)
        y0, y1 = max(int(y - reach), 0), min(int(y + reach) + 1, h)
        self.window = slice(y0, max(y1, y0)), slice(x0, max(x1, x0))
        rows, columns = np.mgrid[self.window].astype(np.float32) + np.float32(0.5)
        self.u, self.v = (columns - x) / self.radius, (rows - y) / self.radius
        a = np.cos(turn) * self.u + np.sin(turn) * self.v
        b = (np.cos(turn) * self.v - np.sin(turn) * self.u) / squash
        self.rho = np.sqrt(a * a + b * b) / (1 + 0.05 * np.cos(2 * np.arctan2(b, a) + 3 * turn))
        self.alpha = np.clip((1 - self.rho) * self.radius + 0.5, 0, 1)[..., None]
        self.z = np.sqrt(np.clip(1 - self.rho**2, 0, 1))
        self.side = light[:2] / max(float(np.hypot(light[0], light[1])), 1e-6)
        self.toward = self.u * self.side[0] + self.v * self.side[1]

    def seen_through(self, picture: FloatArray) -> FloatArray:
        """Returns what the lens shows of a picture (h, w, 3)."""
        bend = 0.75 * (1 - self.z) / np.maximum(np.hypot(self.u, self.v), 1e-3)
        return self.sampled(picture, 1 - 2 * bend)

    def sampled(self, picture: FloatArray, stretch: FloatArray) -> FloatArray:
        """Returns a picture (h, w, 3) at the pixels moved away from the centre by a factor."""
        at_x = (self.centre[0] - 0.5 + self.u * stretch * self.radius).astype(np.float32)
        at_y = (self.centre[1] - 0.5 + self.v * stretch * self.radius).astype(np.float32)
        return np.asarray(
            cv2.remap(picture, at_x, at_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT), np.float32
        )

    def glint(self) -> tuple[FloatArray, FloatArray]:
        """Returns coordinates of the highlight, in radii."""
        return self.u - _GLINT * self.side[0], self.v - _GLINT * self.side[1]


def bedewed(image: FloatArray, drops: DoubleArray, light: DoubleArray) -> FloatArray:
    """Returns the picture (h, w, 3) sRGB with drops (n, 5), see `scattered`, in a light from `light` (3,)."""
    lin = linear_from_srgb(image)
    out = lin.copy()
    for drop in drops:
        _drop(out, lin, _Disc((image.shape[0], image.shape[1]), drop, light))
    return srgb_from_linear(out)


def scattered(facing: FloatArray, amount: float, seed: int) -> DoubleArray:
    """Returns (n, 5): centre, radius, flattening, turn; log-normal radii, no two touching.

    Args:
        facing: (h, w) 0..1, where they gather.
        amount: 0..1.
        seed: of their places.
    """
    h, w = facing.shape
    rng = np.random.default_rng(seed)
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


def _drop(out: FloatArray, lin: FloatArray, disc: _Disc) -> None:
    """Draws one drop into `out` (linear), in place."""
    u, v, z, rho = disc.u, disc.v, disc.z, disc.rho
    # Shadow on the far side of the light, with the light that the drop gathers in its middle.
    du, dv = u + 0.35 * disc.side[0], v + 0.35 * disc.side[1]
    shadow = 0.42 * np.clip(1.25 - np.hypot(du, dv), 0, 0.5) / 0.5
    ground = out[disc.window] * (1 - shadow * (rho > 0.9))[..., None]
    gathered = 0.95 + 0.75 * np.clip(-disc.toward, 0, 1) ** 1.5 - 0.45 * np.clip(disc.toward, 0, 1)
    inner = gathered * (0.55 + 0.45 * z)
    across, along = disc.glint()
    glint = np.exp(-((across**2 + along**2) / 0.020)) * 1.6
    sky = 0.10 * np.clip(-v, 0, 1) * (1 - z) + 0.05
    drop = disc.seen_through(lin) * inner[..., None] + (glint + sky)[..., None].astype(np.float32)
    out[disc.window] = ground * (1 - disc.alpha) + drop * disc.alpha


def redrawn(
    image: FloatArray,
    drops: DoubleArray,
    light: DoubleArray,
    mapping: tuple[float, float, float],
    parent_factor: float,
) -> FloatArray | None:
    """Returns a deeper level's picture (h, w, 3) sRGB with its drops drawn again; None if none is in view.

    Args:
        image: shows the coarser level's drops enlarged.
        drops: (n, 5) of the level that got them.
        light: (3,) direction of the key.
        mapping: (x0, y0, factor): pixel p of that level is (p - (x0, y0)) * factor here.
        parent_factor: how much finer this image is than its own parent's.
    """
    h, w = image.shape[:2]
    x0, y0, factor = mapping
    here = drops * (factor, factor, factor, 1, 1) - (x0 * factor, y0 * factor, 0, 0, 0)
    x, y, r = here[:, 0], here[:, 1], here[:, 2]
    seen = (x > -1.5 * r) & (x < w + 1.5 * r) & (y > -1.5 * r) & (y < h + 1.5 * r) & (r > _LEAST_PX)
    if not seen.any():
        return None
    lin = linear_from_srgb(image)
    soft = cv2.GaussianBlur(lin, (0, 0), 0.5 * parent_factor)
    out = lin.copy()
    for drop in here[seen]:
        _sharpened(out, soft, lin - soft, _Disc((h, w), drop, light), parent_factor)
    change = srgb_from_linear(out) - image
    small = (max(round(w / parent_factor), 1), max(round(h / parent_factor), 1))
    for _ in range(2):  # shrunk, the finer picture stays the one that was there
        low = cv2.resize(change, small, interpolation=cv2.INTER_AREA)
        change = change - cv2.resize(low, (w, h), interpolation=cv2.INTER_CUBIC)
    return np.clip(image + change, 0, 1).astype(np.float32)


def _sharpened(out: FloatArray, soft: FloatArray, fine: FloatArray, disc: _Disc, factor: float) -> None:
    """Draws one drop again into `out` (linear), in place: its forms from `soft`, detail bent from `fine`."""
    halo = min(_HALO * factor / disc.radius, 0.3)
    rho = np.maximum(disc.rho, 1e-3)
    # The coarser edge is a mixture: within its reach each side is continued from its own pixels.
    inner = np.where(rho > 1 - 2 * halo, 1 - 2 * halo + 0.5 * (rho - 1 + 2 * halo), rho)
    outer = np.where(rho < 1 + 2 * halo, 1 + halo + 0.5 * np.maximum(rho - 1, 0), rho)
    inside = disc.sampled(soft, np.minimum(inner, 1 - halo) / rho) + 0.9 * disc.seen_through(fine)
    beside = disc.sampled(soft + fine, outer / rho)
    blur = 0.35 * factor / disc.radius
    edge = np.exp(-(((disc.rho - 0.985) / 0.016) ** 2))
    lit = np.exp(-(((disc.rho - 0.90) / 0.035) ** 2)) * np.clip(-disc.toward - 0.25, 0, 1)
    across, along = disc.glint()
    a, b = 0.96 * across - 0.28 * along, 0.28 * across + 0.96 * along
    window = _pane((a**4 + b**4) ** 0.25, 0.115, 0.014)
    window *= 1 - 0.45 * np.maximum(_pane(np.abs(a), 0.011, 0.008), _pane(np.abs(b), 0.011, 0.008))
    spot = 1.7 * (window - np.exp(-((across**2 + along**2) / (0.020 + blur * blur))))
    inside = inside * (1 - 0.55 * edge + 0.5 * lit)[..., None] + spot[..., None].astype(np.float32)
    mixed = beside * (1 - disc.alpha) + np.maximum(inside, 0) * disc.alpha
    near = (disc.rho < 1 + 2 * halo)[..., None]
    out[disc.window] = np.where(near, mixed, out[disc.window])


def _pane(x: FloatArray, half: float, soft: float) -> FloatArray:
    """Returns 1 within `half`, 0 beyond, over a soft edge."""
    t = np.clip((half + soft - x) / (2 * soft), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)
