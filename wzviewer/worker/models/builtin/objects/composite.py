"""Putting a rendered body into a picture so that it belongs there.

The shadow is a multiplication of the background; the body takes on the background's sharpness,
grain and black and white points.  Beyond body and shadow no pixel changes.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.border import within
from wzviewer.worker.models.builtin.objects.lighting import Light, linear_from_srgb, srgb_from_linear
from wzviewer.worker.models.builtin.objects.render import Layer

_LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)
_MUTED = 0.5  # of the chroma that nothing else in the picture has
_BLURRED_PX = 4  # beyond a body, more than a soft outline reaches
_BRIGHT, _DIM_RANGE = 0.5, 0.25  # sRGB: of a picture's middle, from which on it mutes nothing, and below
_FADE = 0.2  # of the shorter side: so wide a shadow ends, which its parent lacks, before the border
_LEAST = 2.0 / 255  # a shadow weaker than this is none: the picture stays as it was


@dataclass(frozen=True)
class Finish:
    """How sharp and how grainy the picture is: blur sigma px, grain sigma in sRGB units."""

    blur_px: float
    grain: float

    @classmethod
    def of(cls, image: FloatArray) -> "Finish":
        """Measures a picture (h, w, 3): the energy of its finest band beside the next one."""
        luma = cv2.cvtColor(np.ascontiguousarray(image, np.float32), cv2.COLOR_RGB2GRAY)
        soft, softer = cv2.GaussianBlur(luma, (0, 0), 0.8), cv2.GaussianBlur(luma, (0, 0), 1.6)
        fine, coarse = float(np.std(luma - soft)), float(np.std(soft - softer))
        ratio = fine / max(coarse, 1e-4)
        grain = 1.48 * float(np.median(np.abs(luma - soft)))
        return cls(float(np.clip(1.15 - 0.85 * ratio, 0.35, 0.95)), float(min(0.8 * grain, 0.012)))


@dataclass(frozen=True)
class Harmony:
    """What pulls a body's black and white points, its hue and its chroma a little towards the picture's."""

    low: float = 0.0
    high: float = 1.0
    hue: tuple[float, float, float] = (0.0, 0.0, 0.0)
    chroma: float = 1.0

    @classmethod
    def of(cls, body: FloatArray, alpha: FloatArray, image: FloatArray) -> "Harmony":
        """Compares a body (h, w, 3) sRGB where it covers with a picture (h, w, 3)."""
        inside = alpha > 0.5
        if not inside.any():
            return cls()
        thumb = image[::4, ::4].reshape(-1, 3)
        black, white = np.percentile(thumb, 1), np.percentile(thumb, 99)
        own_black, own_white = np.percentile(body[inside], 1), np.percentile(body[inside], 99.5)
        low = 0.10 * max(float(black - own_black), 0.0)
        high = 1 - 0.18 * max(float(own_white - white), 0.0) / max(float(own_white), 1e-3)
        red, green, blue = (0.02 * (thumb.mean(0) - thumb.mean())).tolist()
        return cls(low, high, (red, green, blue), _kept_chroma(body[inside], thumb))

    def __call__(self, body: FloatArray) -> FloatArray:
        """Returns a body's colours (..., 3) in harmony."""
        gray = np.asarray(body @ _LUMA, np.float32)[..., None]
        muted = gray + np.float32(self.chroma) * (body - gray)
        hue = np.asarray(self.hue, np.float32) * (1 - muted)
        return np.clip(self.low + muted * (self.high - self.low) + hue, 0, 1).astype(np.float32)


def _kept_chroma(body: FloatArray, picture: FloatArray) -> float:
    """Returns how much of the chroma of colours (n, 3) is kept beside a picture's (m, 3), sRGB.

    What is as vivid as the most vivid there stays so: a red robin in the dusk looks pasted, in a garden not.
    Nor does a ladybug on white paper: in bright light everything has all of its colour.
    """
    own, around = (float(np.percentile(np.ptp(c, axis=1), 97)) for c in (body, picture))
    dim = float(np.clip((_BRIGHT - np.median(picture @ _LUMA)) / _DIM_RANGE, 0, 1))
    return round(1 - _MUTED * dim * max(1 - (around + 0.05) / max(own, 1e-3), 0.0), 6)


def shadow_gain(ground: FloatArray, light: Light, alpha: FloatArray) -> FloatArray:
    """Returns (h, w) what the support keeps of its light: key and sky by their shares, contact darker.

    Args:
        ground: (h, w, 2) shares of sky and key that arrive.
        light: its ratio splits the two.
        alpha: (h, w) the body, under which nothing is seen.
    """
    sky, key = ground[..., 0], ground[..., 1]
    share = light.ratio / (1 + light.ratio)
    gain = (key * share + (1 - share) * sky) * (0.35 + 0.65 * sky)
    gain = 1 - (1 - gain) * within(alpha.shape, _FADE)
    # Subtracted, not cut off: a step would draw a contour around every foot.
    return np.asarray(1 - np.maximum(1 - gain - _LEAST, 0) / (1 - _LEAST), np.float32)


def composite(
    ground: FloatArray, layer: Layer, finish: Finish, seed: int, harmony: Harmony
) -> tuple[FloatArray, FloatArray]:
    """Returns (picture, alpha) with an opaque body over the ground.

    Args:
        ground: (h, w, 3) sRGB, in the body's shadow.
        layer: the rendered body.
        finish: sharpness and grain to match.
        seed: of the grain.
        harmony: of the body with the picture.
    """
    color, alpha = soften(layer.color, layer.alpha, finish.blur_px)
    noise = grain(alpha.shape[:2], finish.grain, seed)
    result, box = ground.copy(), _box(alpha > 0)
    cover = alpha[box][..., None]
    lit = np.asarray(color[box] / np.maximum(cover, 1e-4), np.float32)
    body = np.asarray(harmony(developed(lit)) + noise[box][..., None], np.float32)
    mixed = linear_from_srgb(body) * cover + linear_from_srgb(ground[box]) * (1 - cover)
    result[box] = np.where(cover > 0, srgb_from_linear(mixed), ground[box])
    return np.clip(result, 0, 1).astype(np.float32), alpha


def _box(there: BoolArray, margin_px: int = 0) -> tuple[slice, slice]:
    """Returns the smallest part of an image that holds what is there; nothing if there is nothing."""
    rows, columns = np.flatnonzero(there.any(1)), np.flatnonzero(there.any(0))
    if not len(rows):
        return slice(0, 0), slice(0, 0)
    top, left = max(rows[0] - margin_px, 0), max(columns[0] - margin_px, 0)
    return slice(top, rows[-1] + 1 + margin_px), slice(left, columns[-1] + 1 + margin_px)


def soften(color: FloatArray, alpha: FloatArray, sigma_px: float) -> tuple[FloatArray, FloatArray]:
    """Blurs a premultiplied body; returns (colour, alpha), exactly 0 where nothing was near."""
    whole = np.zeros((*alpha.shape, 4), np.float32)
    box = _box(alpha > 0, margin_px=_BLURRED_PX + int(4 * sigma_px))
    near = cv2.dilate((alpha[box] > 0).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    soft = cv2.GaussianBlur(np.dstack([color[box], alpha[box]]), (0, 0), sigma_px)
    whole[box] = np.where((near & (soft[..., 3] >= 1e-3))[..., None], soft, 0)
    return np.ascontiguousarray(whole[..., :3]), np.clip(whole[..., 3], 0, 1)


def shadowed(image: FloatArray, gain: FloatArray, light: Light) -> FloatArray:
    """Darkens the background; deep shadow leans to the picture's own dark colours and the sky's.

    A product alone turns saturated yellow into olive.
    """
    lin = linear_from_srgb(image)
    dark = lin * gain[..., None]
    around = lin[cv2.dilate((gain < 0.97).astype(np.uint8), np.ones((9, 9), np.uint8)) > 0]
    if not len(around):
        return image
    luma = around @ _LUMA
    hue = (
        around[luma <= np.percentile(luma, 40)].mean(0)
        + 0.06 * light.ambient.astype(np.float32) * luma.mean()
    )
    hue = hue / max(float(hue @ _LUMA), 1e-4)
    share = (0.35 * (1 - gain))[..., None]
    mixed = dark + share * ((dark @ _LUMA)[..., None] * hue - dark)
    return np.where(gain[..., None] < 1, srgb_from_linear(mixed), image).astype(np.float32)


def developed(lit: FloatArray) -> FloatArray:
    """Returns sRGB of linear radiance (..., 3), its highlights rolled off."""
    return srgb_from_linear(np.asarray(1.05 * lit / (1 + 0.12 * lit), np.float32))


def harmony_of(image: FloatArray, layer: Layer) -> Harmony:
    """Returns what `composite` brings a rendered body into harmony with."""
    box = _box(layer.alpha > 0)
    alpha = layer.alpha[box]
    lit = np.asarray(layer.color[box] / np.maximum(alpha, 1e-4)[..., None], np.float32)
    return Harmony.of(developed(lit), alpha, image)


def rippled(picture: FloatArray, image: FloatArray, alpha: FloatArray) -> FloatArray:
    """Returns a body (h, w, 3) under the ripples and glints of the water (h, w, 3) above it."""
    waves = image - cv2.GaussianBlur(image, (0, 0), image.shape[1] / 160)
    return np.clip(picture + 0.6 * waves * alpha[..., None], 0, 1).astype(np.float32)


def reflected(
    parent: FloatArray, image: FloatArray, layer: Layer, finish: Finish
) -> tuple[FloatArray, FloatArray]:
    """Returns (picture, alpha) with a clear body at a deeper level: what is seen through it is known already.

    Args:
        parent: (h, w, 3) sRGB, the parent's picture enlarged: its background is bent already.
        image: (h, w, 3) sRGB around the body.
        layer: the body; of its reflections only the finer ones are new.
        finish: sharpness to match.
    """
    color, alpha = soften(layer.color, layer.alpha, finish.blur_px)
    fine = color - cv2.GaussianBlur(color, (0, 0), 6.0) * (alpha[..., None] > 0)
    body = np.clip(linear_from_srgb(parent) + fine, 0, 1) * alpha[..., None]
    mixed = body + linear_from_srgb(image) * (1 - alpha[..., None])
    return np.where(alpha[..., None] > 0, srgb_from_linear(mixed), image).astype(np.float32), alpha


def grain(shape: tuple[int, int], sigma: float, seed: int) -> FloatArray:
    """Returns (h, w) noise as soft as a camera's."""
    noise = np.random.default_rng(seed).standard_normal(shape, np.float32)
    return np.asarray(cv2.GaussianBlur(noise, (0, 0), 0.55) * (1.9 * sigma), np.float32)


def refract(
    image: FloatArray,
    layer: Layer,
    ground: FloatArray,
    finish: Finish,
    to_light: DoubleArray,
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> tuple[FloatArray, FloatArray]:
    """Returns (picture, alpha) with a clear body: the background bent, light gathered opposite the key.

    Args:
        image: (h, w, 3) sRGB background.
        layer: the rendered body; its colour is what it reflects.
        ground: (h, w, 3) sRGB, the background in the body's shadow.
        finish: sharpness to match.
        to_light: (3,) key direction, camera axes.
        tint: (3,) share of light that the body lets through.
    """
    h, w = image.shape[:2]
    columns = np.flatnonzero((layer.alpha > 0).any(0))
    reach = 0.5 * max(float(np.ptp(columns)), 1.0) if len(columns) else 1.0
    normal = cv2.GaussianBlur(layer.normal, (0, 0), 1.0)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    bend = np.float32(0.34 * reach) * normal[..., :2]
    seen = cv2.remap(
        linear_from_srgb(image),
        x - bend[..., 0],
        y - bend[..., 1],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REFLECT,
    )
    facing = np.clip(-normal[..., 2], 0, 1)
    across = to_light[:2] / max(float(np.linalg.norm(to_light[:2])), 1e-6)
    side = normal[..., :2] @ across.astype(np.float32)
    rim = 1 - 0.75 * (1 - facing) ** 3
    gathered = 1 + 2.2 * np.clip(-side, 0, 1) ** 1.6 * facing**0.3 - 0.55 * np.clip(side, 0, 1)
    clear = (
        seen * np.asarray(tint, np.float32) * (rim * gathered)[..., None]
        + layer.color / np.maximum(layer.alpha, 1e-3)[..., None]
    )
    color, alpha = soften(clear * layer.alpha[..., None], layer.alpha, finish.blur_px)
    mixed = color + linear_from_srgb(ground) * (1 - alpha[..., None])
    return np.where(alpha[..., None] > 0, srgb_from_linear(mixed), ground).astype(np.float32), alpha
