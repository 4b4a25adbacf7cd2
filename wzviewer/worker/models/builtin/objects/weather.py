"""Changes of the whole picture: what covers its surfaces, and its light.

Everything is a pure function of picture, relief and seed.  What covers a surface follows it: snow lies
on what faces the sky, moss and rust begin where it is dark and sheltered, fog thickens with depth.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.border import border_px, within
from wzviewer.worker.models.builtin.objects.dew import bedewed, scattered
from wzviewer.worker.models.builtin.objects.grammar import Change
from wzviewer.worker.models.builtin.objects.lighting import (
    Light,
    light_from_photo,
    linear_from_srgb,
    srgb_from_linear,
)

# Snowflakes, far to near: how many, radius and blur in picture widths, strength.
_FLAKES = ((420, 0.0011, 0.0006, 0.9), (130, 0.0022, 0.0012, 0.85), (26, 0.0055, 0.0035, 0.55))
_LYING = frozenset({"moss", "rust", "dust", "snow", "frost"})  # of these one sees where they end
_FADE, _UNEVEN = 0.06, 0.5  # of the shorter side: how wide that is, and how unevenly
_MOSS_DARK, _MOSS_YOUNG = (
    np.array([0.085, 0.135, 0.022], np.float32),
    np.array([0.30, 0.36, 0.06], np.float32),
)
_RUST_DARK, _RUST_BRIGHT = (
    np.array([0.075, 0.028, 0.014], np.float32),
    np.array([0.40, 0.135, 0.030], np.float32),
)
_LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True, eq=False)
class Dew:
    """Drops (n, 5), see `dew.scattered`, and the light on them."""

    drops: DoubleArray
    light: Light


@dataclass(frozen=True, eq=False)
class Ground:
    """What a change knows of a picture.

    Attributes:
        image: (h, w, 3) sRGB.
        facing: (h, w) 0..1, how much the surface faces the sky.
        away: (h, w) 0..1, from the nearest to the farthest point.
        shelter: (h, w) 0..1, dark and hollow.
        seed: of the noise.
    """

    image: FloatArray
    facing: FloatArray
    away: FloatArray
    shelter: FloatArray
    seed: int

    @classmethod
    def of(cls, image: FloatArray, relief: FloatArray, seed: int) -> "Ground":
        """Reads a picture and its relief (h, w), native px, nan where unknown."""
        luma = image @ _LUMA
        w = image.shape[1]
        known = np.isfinite(relief)
        z = _filled(relief, known)
        low, high = np.percentile(z, 2), np.percentile(z, 98)
        deep = float(high - low) > 0.02 * w
        away = (
            np.clip((z - low) / max(float(high - low), 1e-3), 0, 1)
            if deep
            else np.linspace(1, 0, len(z))[:, None]
        )
        smooth = cv2.GaussianBlur(np.clip(z, low, high), (0, 0), max(w / 220, 0.8))
        gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0) / 8, cv2.Sobel(smooth, cv2.CV_32F, 0, 1) / 8
        lying = -gy / np.sqrt(gx**2 + gy**2 + 1)
        soft, softer = cv2.GaussianBlur(luma, (0, 0), w / 300), cv2.GaussianBlur(luma, (0, 0), w / 45)
        lit = cv2.Sobel(cv2.GaussianBlur(luma, (0, 0), w / 160), cv2.CV_32F, 0, 1) * (w / 160)
        facing = np.clip(0.62 * lying + 0.22 + 0.35 * np.tanh(-1.2 * lit) + 0.5 * (soft - softer), 0, 1)
        shelter = np.clip(0.5 + 2.2 * (softer - soft) + 0.6 * (0.45 - softer), 0, 1)
        full = np.broadcast_to(away, luma.shape).astype(np.float32)
        return cls(image, facing.astype(np.float32), full, shelter.astype(np.float32), seed)


def _filled(relief: FloatArray, known: BoolArray) -> FloatArray:
    """Returns a relief (h, w) that is about as far where it is unknown as around there."""
    fallback = np.float32(np.median(relief[known]) if known.any() else 0.0)
    near = np.where(known, relief - fallback, np.float32(0))
    spread = relief.shape[1] / 60
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), spread)
    around = cv2.GaussianBlur(near, (0, 0), spread) / np.maximum(weight, np.float32(1e-3))
    return np.where(known, relief, around + fallback).astype(np.float32)


def changed(image: FloatArray, relief: FloatArray, changes: tuple[Change, ...], seed: int) -> FloatArray:
    """Returns the picture (h, w, 3) sRGB after its changes, one after the other."""
    for k, change in enumerate(changes):
        image = changed_by(change, image, relief, seed + 13 * k)
    return image


def changed_by(change: Change, image: FloatArray, relief: FloatArray, seed: int) -> FloatArray:
    """Returns the picture (h, w, 3) sRGB after one change."""
    ground = Ground.of(image, relief, seed)
    made = np.clip(_CHANGES[change.name](ground, change.amount), 0, 1)
    if change.name in _LYING:  # what is in the air or of the light has no end that could be natural
        h, w = image.shape[:2]
        uneven = np.exp(_UNEVEN * noise((h, w), max(w / 24, 2.0), seed + 7, 4))
        made = image + (made - image) * within((h, w), _FADE, uneven)[..., None]
    return np.asarray(made, np.float32)


def noise(
    shape: tuple[int, int], wave_px: float, seed: int, octaves: int = 5, stretch: float = 1.0
) -> FloatArray:
    """Returns (h, w) fractal noise of about unit spread; `stretch` draws it out downwards."""
    rng = np.random.default_rng(seed)
    total = np.zeros(shape, np.float32)
    weight = 1.0
    for _ in range(octaves):
        size = (max(round(shape[1] / wave_px) + 2, 2), max(round(shape[0] / (wave_px * stretch)) + 2, 2))
        grid = rng.standard_normal((size[1], size[0])).astype(np.float32)
        total += weight * cv2.resize(grid, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
        wave_px, weight = max(wave_px / 2, 1.0), weight * 0.6
    return total / np.float32(1.15)


def _smooth(low: float, high: float, x: DoubleArray | FloatArray) -> FloatArray:
    t = np.clip((x - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)


def _over(want: FloatArray, amount: float) -> FloatArray:
    """Returns by how much each pixel is wanted more than the last one that a share of the picture holds."""
    return np.asarray(want - np.quantile(want[::3, ::3], 1 - 0.85 * min(amount, 1.0)), np.float32)


def _relit(height: FloatArray, strength: float) -> FloatArray:
    """Returns the gain that a relief gives to light from above and the left."""
    gx, gy = cv2.Sobel(height, cv2.CV_32F, 1, 0) / 8, cv2.Sobel(height, cv2.CV_32F, 0, 1) / 8
    return np.asarray(np.clip(1 - strength * (0.6 * gx + 1.0 * gy) * -1.0, 0.35, 1.8), np.float32)


def _covered(image: FloatArray, cover: FloatArray, mask: FloatArray, shadow: float) -> FloatArray:
    """Lays a cover (linear) over a picture: thick enough for a dark rim below its edge."""
    w = image.shape[1]
    under = np.roll(cv2.GaussianBlur(mask, (0, 0), w / 400), (max(w // 400, 1), max(w // 700, 1)), (0, 1))
    dark = 1 - shadow * np.clip(under - mask, 0, 1)
    base = linear_from_srgb(image) * dark[..., None]
    return srgb_from_linear(base + (cover - base) * mask[..., None])


def _light_of(ground: Ground, share: float) -> FloatArray:
    """Returns (h, w) how brightly the picture is lit, its own small contrasts kept by `share`."""
    luma = linear_from_srgb(ground.image) @ _LUMA
    large = cv2.GaussianBlur(luma, (0, 0), ground.image.shape[1] / 40)
    return np.asarray(0.35 * large.mean() + 0.65 * large + share * (luma - large), np.float32)


def _moss(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    patches = noise((h, w), w / 7, ground.seed)
    want = (
        0.55 * patches + 1.1 * (ground.facing - 0.35) + 0.9 * (ground.shelter - 0.5) + 2.6 * (amount - 0.68)
    )
    mask = _smooth(-0.18, 0.22, want + 0.22 * noise((h, w), w / 90, ground.seed + 1, 3))
    cushions = noise((h, w), w / 45, ground.seed + 2, 3)
    tufts = noise((h, w), max(w / 240, 2.5), ground.seed + 3, 3)
    height = 5.0 * cushions * w / 720 + 1.6 * tufts * w / 720
    tone = _relit(height.astype(np.float32), 0.55) * np.exp(0.22 * tufts) * (0.7 + 0.5 * mask)
    young = _smooth(-0.6, 1.2, cushions + 0.5 * tufts)[..., None]
    green = _MOSS_DARK + (_MOSS_YOUNG - _MOSS_DARK) * young
    cover = green * (tone * (0.35 + 1.9 * _light_of(ground, 0.35)))[..., None]
    return _covered(ground.image, cover, mask, 0.5)


def _rust(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    streaks = noise((h, w), w / 60, ground.seed, 3, 9.0)
    patches = noise((h, w), w / 8, ground.seed + 1)
    want = 0.6 * patches + 0.35 * streaks + 0.7 * ground.shelter
    want += 0.25 * noise((h, w), w / 150, ground.seed + 2, 3)
    mask = _smooth(-0.35, 0.40, _over(want, amount))
    fine = noise((h, w), max(w / 300, 2.0), ground.seed + 3, 3)
    t = _smooth(-1.2, 1.4, patches + 0.7 * fine + 0.3 * streaks)[..., None]
    tone = _relit((1.4 * fine * w / 720).astype(np.float32), 0.5) * np.exp(0.15 * fine)
    tone *= 0.25 + 2.0 * _light_of(ground, 0.8)
    cover = (_RUST_DARK + (_RUST_BRIGHT - _RUST_DARK) * t) * tone[..., None]
    return _covered(ground.image, cover, 0.92 * mask, 0.35)


def _dust(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    want = 0.9 * ground.facing + 0.25 * noise((h, w), w / 12, ground.seed) + 1.4 * (amount - 0.75)
    mask = 0.75 * _smooth(0.1, 0.9, want)
    fine = noise((h, w), 2.5, ground.seed + 1, 2)
    cover = (
        np.array([0.42, 0.36, 0.27], np.float32)
        * ((0.4 + 1.1 * _light_of(ground, 0.5)) * np.exp(0.10 * fine))[..., None]
    )
    return _covered(ground.image, cover, mask, 0.1)


def _snow(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    drift = noise((h, w), w / 9, ground.seed)
    want = 1.6 * ground.facing + 0.12 * drift + 0.07 * noise((h, w), w / 70, ground.seed + 1, 4)
    mask = _smooth(-0.08, 0.10, _over(want, 0.9 * amount))
    thick = cv2.GaussianBlur(mask, (0, 0), w / 180)
    fine = noise((h, w), max(w / 500, 1.5), ground.seed + 2, 2)
    tone = _relit((7.0 * thick * w / 720 + 0.35 * drift * w / 720 + 0.05 * fine).astype(np.float32), 0.5)
    light = 0.30 + 1.25 * np.sqrt(np.clip(_light_of(ground, 0.45), 0, 1))
    white = np.array([0.80, 0.86, 0.94], np.float32)
    warm = np.clip(light - 0.75, 0, 0.4)[..., None] * np.array([0.18, 0.06, -0.08], np.float32)
    cover = (white + warm) * (tone * light * (1 + 0.03 * fine))[..., None]
    cold = ground.image @ _LUMA
    muted = ground.image + 0.30 * (cold[..., None] * np.array([0.96, 1.0, 1.06], np.float32) - ground.image)
    lying = _covered(muted, np.clip(cover, 0, 1), mask, 0.45)
    return lying + (1 - lying) * _flakes(ground, amount)[..., None] * np.array([0.95, 0.97, 1.0], np.float32)


def _flakes(ground: Ground, amount: float) -> FloatArray:
    """Falling flakes: many far and small, a few near and out of focus."""
    h, w = ground.facing.shape
    rng = np.random.default_rng(ground.seed + 5)
    total = np.zeros((h, w), np.float32)
    for count, radius, blur, strength in _FLAKES:
        layer = np.zeros((h, w), np.float32)
        for x, y, s in rng.random((int(count * amount), 3)):
            r = max(round(radius * w * (0.6 + 0.8 * float(s))), 1)
            cv2.circle(layer, (round(x * w), round(y * h)), r, 1.0, -1, cv2.LINE_AA)
        total = np.maximum(total, strength * cv2.GaussianBlur(layer, (0, 0), max(blur * w, 0.5)))
    return np.clip(total, 0, 1)


def _frost(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    needles = _needles((h, w), ground.seed)
    luma = ground.image @ _LUMA
    edge = np.abs(luma - cv2.GaussianBlur(luma, (0, 0), w / 200))
    rim = np.clip(7 * cv2.GaussianBlur(edge, (0, 0), w / 400), 0, 1)
    want = 0.6 * ground.facing + 0.9 * rim + 0.20 * noise((h, w), w / 10, ground.seed + 9)
    mask = _smooth(-0.35, 0.55, _over(want, 0.58 * amount)) * (0.62 + 0.38 * _smooth(-0.1, 0.9, needles))
    tone = (0.50 + 0.55 * np.sqrt(np.clip(_light_of(ground, 0.6), 0, 1))) * np.exp(0.16 * needles)
    cover = (np.array([0.72, 0.80, 0.90]) * tone[..., None]).astype(np.float32)
    cold = luma[..., None] * np.array([0.93, 1.0, 1.09], np.float32)
    muted = (ground.image + 0.45 * (cold - ground.image)).astype(np.float32)
    return _covered(muted, np.clip(cover, 0, 1), (0.80 * mask).astype(np.float32), 0.15)


def _needles(shape: tuple[int, int], seed: int) -> FloatArray:
    """Ice needles in four directions."""
    best = np.zeros(shape, np.float32)
    for k in range(4):
        kernel = np.zeros((11, 11), np.float32)
        dx, dy = 5 * np.cos(np.radians(20 + 45 * k)), 5 * np.sin(np.radians(20 + 45 * k))
        cv2.line(kernel, (round(5 - dx), round(5 - dy)), (round(5 + dx), round(5 + dy)), 1.0)
        grain = noise(shape, 2.5, seed + k, 2)
        best = np.maximum(best, cv2.filter2D(grain, -1, kernel / kernel.sum()))
    return best * np.float32(1.5)


def dew_on(image: FloatArray, relief: FloatArray, amount: float, seed: int) -> Dew:
    """Returns the drops that `changed_by` draws."""
    return _dew_of(Ground.of(image, relief, seed), amount)


def _dew_of(ground: Ground, amount: float) -> Dew:
    h, w = ground.facing.shape
    light = light_from_photo(ground.image, (w / 2, h / 2), w / 4)
    drops = scattered(ground.facing, amount, ground.seed)
    x, y, radius = drops.T[:3]
    border = np.minimum(np.minimum(x, w - x), np.minimum(y, h - y)) - 1.3 * radius  # and its shadow
    return Dew(drops[border > border_px((h, w))], light)


def _dew(ground: Ground, amount: float) -> FloatArray:
    dew = _dew_of(ground, amount)
    return bedewed(ground.image, dew.drops, dew.light.direction)


def _rain(ground: Ground, amount: float) -> FloatArray:
    """Wet surfaces are darker, more colourful and mirror the sky where they lie flat; streaks in the air."""
    h, w = ground.facing.shape
    lin = linear_from_srgb(ground.image)
    wet = lin ** (1 + 0.45 * amount) * np.float32(0.92)
    luma = (wet @ _LUMA)[..., None]
    wet = luma + 1.18 * (wet - luma)
    pools = _smooth(0.5, 0.9, ground.facing + 0.25 * noise((h, w), w / 10, ground.seed))[..., None]
    sky = cv2.GaussianBlur(lin[::-1], (0, 0), w / 40)
    wet = wet + 0.10 * amount * pools * sky
    rng = np.random.default_rng(ground.seed + 3)
    fall = np.zeros((h, w), np.float32)
    for x, y, s in rng.random((int(330 * amount), 3)):
        long = (0.02 + 0.05 * s) * h
        start = (round(x * w), round(y * h))
        cv2.line(
            fall,
            start,
            (round(x * w - 0.12 * long), round(y * h + long)),
            0.25 + 0.5 * float(s),
            1,
            cv2.LINE_AA,
        )
    fall = cv2.GaussianBlur(fall, (0, 0), max(w / 1400, 0.5))[..., None]
    grey = srgb_from_linear(np.clip(wet, 0, 1))
    grey = grey + 0.12 * amount * ground.away[..., None] * (np.float32(0.62) - grey)
    return np.asarray(grey + 0.42 * fall * (np.float32(0.88) - grey), np.float32)


def _fog(ground: Ground, amount: float) -> FloatArray:
    h, w = ground.facing.shape
    drift = 0.14 * noise((h, w), w / 2.5, ground.seed, 3)
    thick = 1 - np.exp(-amount * (0.35 + 2.1 * np.clip(ground.away + drift, 0, 1.3)))
    lin = linear_from_srgb(ground.image)
    bright = np.percentile(lin @ _LUMA, 90)
    veil = np.array([0.93, 0.97, 1.0], np.float32) * np.float32(np.clip(0.25 + 0.75 * bright, 0.3, 0.85))
    soft = cv2.GaussianBlur(lin, (0, 0), max(w / 300, 0.8))
    seen = lin + (soft - lin) * (0.8 * thick)[..., None]
    return srgb_from_linear(seen + (veil - seen) * thick[..., None])


def _sunset(ground: Ground, amount: float) -> FloatArray:
    h = ground.facing.shape[0]
    lin = linear_from_srgb(ground.image)
    luma = np.clip(lin @ _LUMA, 0, 1)
    bright = _smooth(0.05, 0.75, np.sqrt(luma))[..., None]
    gain = (
        np.array([0.62, 0.48, 0.62], np.float32) * (1 - bright)
        + np.array([1.35, 0.86, 0.46], np.float32) * bright
    )
    low = np.linspace(0, 1, h, dtype=np.float32)[:, None, None]
    glow = (1 - low) ** 1.5 * np.array([0.26, 0.10, 0.015], np.float32) * (0.3 + ground.away[..., None])
    return srgb_from_linear((lin + amount * 1.15 * (lin * gain + 0.6 * glow - lin)).astype(np.float32))


def _night(ground: Ground, amount: float) -> FloatArray:
    lin = linear_from_srgb(ground.image)
    luma = (lin @ _LUMA)[..., None]
    moon = (0.35 * lin + 0.65 * luma) * np.array([0.30, 0.46, 0.82], np.float32)
    dark = 0.42 * moon ** np.float32(1.15) + 0.004
    return srgb_from_linear(lin + min(1.15 * amount, 1.0) * (dark - lin))


_CHANGES: dict[str, Callable[[Ground, float], FloatArray]] = {
    "moss": _moss,
    "rust": _rust,
    "dust": _dust,
    "snow": _snow,
    "frost": _frost,
    "dew": _dew,
    "rain": _rain,
    "fog": _fog,
    "sunset": _sunset,
    "night": _night,
}
