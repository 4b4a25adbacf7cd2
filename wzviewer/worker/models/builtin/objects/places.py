"""Where "on the sunflower" is: a place word becomes a map of the picture, the map a spot.

What a word looks like is said by its colour, by where the surface faces and by the sky: yellow petals
around a dark disc, green, what lies, what stands.  The spot is where a body of its size finds most of
that look, near the middle of the view, because that is what the user looks at.  A look that is hardly
there is not found, and the result says so.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.objects.placement import Support
from wzviewer.worker.models.builtin.objects.words import ALOFT, COLORS, LOOKS

_THUMB_PX = 256
_LEAST = 0.30  # of a body's footprint that has the look, so that the place is found
_SHRUNK = 0.40  # of the usual size: no body is made smaller to fit its place
_ROOMY = 0.75  # of the usual size, on a place that is large enough
_GOOD = 0.60  # of the footprint: good enough to stay where the user looks
_CENTRE = 0.45  # spread of the preference for the view's middle, of the half diagonal
Spot = tuple[tuple[float, float], float]


@dataclass(frozen=True, eq=False)
class View:
    """What places are read from, all (h, w) of a thumbnail.

    Attributes:
        lightness: CIELAB L, 0..100.
        chroma: distance from grey.
        hue: degrees; 30 red, 90 yellow, 140 green, 270 blue.
        lab: (h, w, 3).
        lying: -1 (overhead) to 1, how much the surface faces the sky.
        near: 0 (farthest) to 1 (nearest).
        rough: contrast of the finest octaves, L.
        ground: 1 where a body can stand: all but the sky.
    """

    lightness: FloatArray
    chroma: FloatArray
    hue: FloatArray
    lab: FloatArray
    lying: FloatArray
    near: FloatArray
    rough: FloatArray
    ground: FloatArray

    @classmethod
    def of(cls, image: FloatArray, support: Support) -> "View":
        """Reads a picture (h, w, 3) and the support under it."""
        h, w = image.shape[:2]
        size = (_THUMB_PX, max(round(_THUMB_PX * h / w), 8))
        thumb = cv2.resize(np.ascontiguousarray(image, np.float32), size, interpolation=cv2.INTER_AREA)
        lab = cv2.cvtColor(np.clip(thumb, 0, 1), cv2.COLOR_RGB2LAB)
        relief, known = _thumb_relief(support, size)
        smooth = cv2.GaussianBlur(relief, (0, 0), 1.5)
        gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0) / 8, cv2.Sobel(smooth, cv2.CV_32F, 0, 1) / 8
        order = np.argsort(np.argsort(relief.ravel())).reshape(relief.shape)
        sky = np.zeros(size[::-1], np.float32)
        if support.sky is not None:
            sky = cv2.resize(support.sky.astype(np.float32), size, interpolation=cv2.INTER_AREA)
        light = np.ascontiguousarray(lab[..., 0])
        return cls(
            light,
            np.hypot(lab[..., 1], lab[..., 2]),
            np.degrees(np.arctan2(lab[..., 2], lab[..., 1])) % 360,
            lab,
            (-gy / np.sqrt(gx**2 + gy**2 + 1)).astype(np.float32),
            (1 - order / order.size).astype(np.float32) if known else np.ones_like(light),
            np.sqrt(cv2.blur((light - cv2.GaussianBlur(light, (0, 0), 2.0)) ** 2, (7, 7))),
            (1 - sky).astype(np.float32),
        )


def _thumb_relief(support: Support, size: tuple[int, int]) -> tuple[FloatArray, bool]:
    known = np.isfinite(support.relief)
    middle = np.float32(np.median(support.relief[known]) if known.any() else 0.0)
    filled = np.where(known, support.relief, middle)
    small = cv2.resize(filled.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    return small * np.float32(size[0] / filled.shape[1]), bool(known.any() and np.ptp(small) > 0)


def _ramp(x: FloatArray, low: float, high: float) -> FloatArray:
    t = np.clip((x - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t), np.float32)


def _between(x: FloatArray, low: float, high: float, soft: float) -> FloatArray:
    return np.minimum(_ramp(x, low - soft, low + soft), 1 - _ramp(x, high - soft, high + soft))


def _green(v: View) -> FloatArray:
    return _between(v.hue, 96, 170, 9) * _ramp(v.chroma, 6, 16) * v.ground


def _petal(v: View) -> FloatArray:
    """Colourful, and neither green nor the blue of water and sky."""
    color = (1 - _between(v.hue, 100, 290, 9)) * _ramp(v.chroma, 24, 42) * _ramp(v.lightness, 18, 34)
    white = 0.8 * _ramp(v.lightness, 74, 86) * (1 - _ramp(v.chroma, 10, 20))
    return np.maximum(color, white * (color.mean() < 0.04)) * v.ground


def _disc(v: View) -> FloatArray:
    """Dark and brown, with petals around it."""
    dark = (1 - _ramp(v.lightness, 34, 50)) * (1 - _green(v))
    around = cv2.GaussianBlur(_petal(v), (0, 0), 9.0)
    return dark * _ramp(around, 0.10, 0.30) * v.ground


def _sunflower(v: View) -> FloatArray:
    yellow = _between(v.hue, 64, 100, 8) * _ramp(v.chroma, 34, 50) * _ramp(v.lightness, 40, 55) * v.ground
    around = cv2.GaussianBlur(yellow, (0, 0), 7.0)
    disc = (1 - _ramp(v.lightness, 40, 58)) * (1 - _green(v)) * _ramp(around, 0.12, 0.30)
    return np.maximum(yellow, disc)


def _flower(v: View) -> FloatArray:
    return np.maximum(_petal(v), _disc(v))


def _white(v: View) -> FloatArray:
    return _ramp(v.lightness, 66, 82) * (1 - _ramp(v.chroma, 9, 18)) * v.ground


def _stone(v: View) -> FloatArray:
    return (1 - _ramp(v.chroma, 12, 24)) * _between(v.lightness, 18, 84, 8) * v.ground


def _wood(v: View) -> FloatArray:
    return (
        _between(v.hue, 30, 88, 10)
        * _between(v.chroma, 10, 48, 5)
        * _between(v.lightness, 14, 74, 8)
        * v.ground
    )


def _water(v: View) -> FloatArray:
    """Blue or grey, smooth, in the lower part."""
    blue = np.maximum(
        _between(v.hue, 165, 290, 10) * _ramp(v.chroma, 3, 9), 0.5 * (1 - _ramp(v.chroma, 8, 14))
    )
    return blue * (1 - _ramp(v.rough, 5, 10)) * _ramp(_rows(v), 0.25, 0.5) * _flat(v) * v.ground


def _lying(v: View) -> FloatArray:
    return _flat(v) * v.ground


def _bare(v: View) -> FloatArray:
    """A floor, a path: lying, low in the picture, without a green cover."""
    return _lying(v) * (1 - _green(v)) * (0.3 + 0.7 * _ramp(_rows(v), 0.45, 0.8))


def _rows(v: View) -> FloatArray:
    return np.broadcast_to(np.linspace(0, 1, len(v.hue), dtype=np.float32)[:, None], v.hue.shape)


def _flat(v: View) -> FloatArray:
    """What faces the sky; of a picture without relief the lower part."""
    return _ramp(v.lying, 0.25, 0.65) if np.ptp(v.lying) > 0.1 else _ramp(_rows(v), 0.3, 0.7)


def _standing(v: View) -> FloatArray:
    """A wall, a house: upright by its depth or, which is often wrong of walls, high up; rather even."""
    upright = np.maximum(1 - _ramp(v.lying, 0.45, 0.85), 0.75 * (1 - _ramp(_rows(v), 0.45, 0.8)))
    return upright * (1 - _ramp(v.rough, 4, 10)) * (1 - _green(v)) * v.ground


def _sky(v: View) -> FloatArray:
    return 1 - v.ground


_MAPS: dict[str, Callable[[View], FloatArray]] = {
    "green": _green,
    "petal": _petal,
    "disc": _disc,
    "sunflower": _sunflower,
    "flower": _flower,
    "white": _white,
    "stone": _stone,
    "wood": _wood,
    "water": _water,
    "lying": _lying,
    "bare": _bare,
    "standing": _standing,
    "sky": _sky,
}


def look_of(place: tuple[str, ...], view: View) -> FloatArray | None:
    """Returns (h, w) 0..1 how much each pixel looks like the place words; None for words without a look."""
    look = next((LOOKS[word] for word in place if word in LOOKS), None)
    if look is None:
        return None
    found = _MAPS[look](view)
    for word in place:
        if word in COLORS:
            wanted = cv2.cvtColor(np.array([[COLORS[word]]], np.float32) / 255, cv2.COLOR_RGB2LAB)[0, 0]
            off = np.linalg.norm((view.lab - wanted) * np.array([0.35, 1, 1], np.float32), axis=2)
            found = found * np.exp(-((off / 38) ** 2))
    return np.asarray(found, np.float32)


def spots(
    place: tuple[str, ...],
    relation: str,
    wanted: tuple[float, float],
    width_px: float,
    view: View,
    shape: tuple[int, int],
    *,
    count: int = 1,
    usual_px: float | None = None,
    seed: int = 0,
) -> tuple[list[Spot], bool]:
    """Returns where bodies go, ((x, y) px, width px) each, and whether the place was found.

    Args:
        place: the words of the place; without any, or if it is not found, any ground will do.
        relation: "on", "beside" or "under" the place.
        wanted: (x, y) px that a spot should be close to.
        width_px: of one body.
        view: the picture.
        shape: (h, w) of the picture.
        count: how many.
        usual_px: from which bodies are made as small as the place asks; None if they are not.
        seed: of the disorder of several.
    """
    look = look_of(place, view)
    ratio = view.hue.shape[1] / shape[1]
    small = (width_px if usual_px is None else _SHRUNK * usual_px) * ratio
    footprint = max(0.20 * small, 1.0)
    found = False
    if look is not None:
        share = (
            _beside(look, small, relation) if relation != "on" else cv2.GaussianBlur(look, (0, 0), footprint)
        )
        found = bool(share.max() >= _LEAST)
    if look is None or not found:
        look = view.ground
        share = cv2.GaussianBlur(look, (0, 0), footprint)
        if count == 1 and (share.max() < 0.05 or _at(share, wanted, ratio) > 0.55):
            return [(wanted, width_px)], found
    over_sky = look_of(("sky",), view) if place and not ALOFT & set(place) else None
    if over_sky is not None:
        share = share * np.clip(1 - 3 * cv2.GaussianBlur(over_sky, (0, 0), footprint), 0.02, 1)
    scored = share * (0.70 + 0.30 * view.near) * _prior(share.shape, wanted, ratio, count)
    room = _room(look)
    ample = np.ones_like(share)
    if usual_px is not None and found:
        ample = np.clip(room / (_ROOMY * usual_px * ratio), 0.2, 1)
    scored = scored * ample
    rng = np.random.default_rng([seed, 77])
    if count > 1:
        disorder = rng.random((7, 10), np.float32)
        scored = scored * (0.4 + cv2.resize(disorder, scored.shape[::-1], interpolation=cv2.INTER_CUBIC))
    taken: list[Spot] = []
    rows, columns = np.mgrid[: scored.shape[0], : scored.shape[1]]
    for _ in range(count):
        y, x = divmod(int(np.argmax(scored)), scored.shape[1])
        centre = float(x + 0.5) / ratio, float(y + 0.5) / ratio
        if count == 1 and _at(share * ample, wanted, ratio) > _GOOD:  # what is looked at is the place
            centre, x, y = wanted, int(wanted[0] * ratio), int(wanted[1] * ratio)
        body = width_px * (1.0 if count == 1 else rng.uniform(0.85, 1.15))
        if usual_px is not None and found:
            fitted = np.clip(room[y, x] / ratio, _SHRUNK * usual_px, _ROOMY * usual_px)
            body *= float(fitted) / width_px
        taken.append((centre, float(body)))
        far = np.hypot(columns - x, rows - y) / (1.15 * max(width_px * ratio, 1.0))
        scored = scored * (1 - np.exp(-(far**4)))
    if _crowded(taken) and width_px > 8:
        again = 0.8 * width_px
        fitted = None if usual_px is None else 0.8 * usual_px
        return spots(place, relation, wanted, again, view, shape, count=count, usual_px=fitted, seed=seed)
    return sorted(taken, key=lambda s: s[0][1]), found


def _crowded(taken: list[Spot]) -> bool:
    """Tells whether two bodies would be drawn over each other."""
    return any(
        np.hypot(a[0][0] - b[0][0], a[0][1] - b[0][1]) < 0.45 * (a[1] + b[1])
        for k, a in enumerate(taken)
        for b in taken[:k]
    )


def cover_of(place: tuple[str, ...], view: View, shape: tuple[int, int]) -> FloatArray:
    """Returns (h, w) 0..1 where a place really is, soft at its edge: water hides only what is in it."""
    look = look_of(place, view)
    if look is None or look.max() < _LEAST:
        return np.ones(shape, np.float32)
    closed = cv2.morphologyEx((look > _LEAST).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    large = cv2.resize(closed.astype(np.float32), shape[::-1], interpolation=cv2.INTER_CUBIC)
    return np.clip(cv2.GaussianBlur(large, (0, 0), shape[1] / 400) * 2 - 0.6, 0, 1)


def _at(share: FloatArray, wanted: tuple[float, float], ratio: float) -> float:
    y = int(np.clip(wanted[1] * ratio, 0, share.shape[0] - 1))
    x = int(np.clip(wanted[0] * ratio, 0, share.shape[1] - 1))
    return float(share[y, x])


def _prior(shape: tuple[int, ...], wanted: tuple[float, float], ratio: float, count: int) -> FloatArray:
    """Prefers the point that is looked at; weakly, if many bodies share the place."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
    far = np.hypot(x + 0.5 - wanted[0] * ratio, y + 0.5 - wanted[1] * ratio) / (
        0.5 * np.hypot(shape[0], shape[1])
    )
    inside = 0.5 - np.maximum(np.abs(x / shape[1] - 0.5), np.abs(y / shape[0] - 0.5))
    return np.exp(-0.5 * (far / (_CENTRE if count == 1 else 1.2)) ** 2) * _ramp(inside, 0.03, 0.12)


def _beside(look: FloatArray, small: float, relation: str) -> FloatArray:
    """What is next to a look, or below it in the picture, but not on it."""
    near = cv2.GaussianBlur(look, (0, 0), 0.45 * small)
    if relation == "under":
        near = np.asarray(np.roll(near, round(0.6 * small), 0), np.float32)
        near[: round(0.6 * small)] = 0
    return np.asarray(1.6 * near * (1 - cv2.GaussianBlur(look, (0, 0), max(0.15 * small, 1.0))), np.float32)


def _room(look: FloatArray) -> FloatArray:
    """Returns (h, w) how wide the place is around each pixel, thumbnail px; small gaps do not end it."""
    mask = cv2.morphologyEx((look > 0.3).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    away = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    return np.asarray(2.6 * cv2.dilate(away, np.ones((5, 5), np.uint8)), np.float32)
