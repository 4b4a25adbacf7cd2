"""Strokes: the second zoom finds what the first could only hint at, leaf by leaf and hair by hair.

An enlarged texture is a camouflage: rounded blots that mean nothing.  But every blot can be a thing, a leaf,
a face of stone or the mark of a brush, that lies where the picture is of one colour (painterly rendering with
strokes fitted to a picture: Haeberli 1990, Hertzmann 1998).  What is seen of every stroke then gets the
colour with which the whole, shrunk, is the picture again.  Hairs follow the picture's own direction.

::

    observation ──► what is it made of? ─► sites ──► fit: angle and size ──► lay, dark ones first ─┐
         ▲                                   ▲                                   top, shade        │
         │                                   └───── where it is not yet right ◄──── colours ◄──────┤
         └──────────────────────────── shrunk ◄────────────────────────────────────────────────────┘
"""

from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray, IntArray
from wzviewer.worker.models.builtin.detail.brushes import FACET, LEAF, MARK, comb, fit, lay
from wzviewer.worker.models.builtin.detail.flow import CALM_VOTES, voted_direction
from wzviewer.worker.models.builtin.detail.measures import (
    area_down,
    blurred,
    enlarged,
    luma,
    over_rows,
)

CANDIDATES = 12
COLOUR_TURNS = 6
TURN = 2.399963
"""In rad, the golden angle: candidates of a stroke point anywhere, and no two alike."""
ORDER_NOISE = 14.0
"""In grey levels: what is lighter lies in front, as sun reaches it first; but not always."""
UNLIKE = 6.0
"""In grey levels: where the picture differs by less from what is laid so far, smaller strokes do not help."""
BEHIND = 0.6
"""Of the light: what is seen between strokes."""
LIGHT_TURNS, GAIN = 2, 1.35
"""Most that a turn of the last correction, by light, changes."""


@dataclass(frozen=True)
class Brush:
    """What strokes of a material look like.

    Attributes:
        kind: of `brushes`.
        halves_px: mean half length of every layer, in px of the observation, the largest first.
        step: distance of neighbouring strokes, as a share of that.
        slim: least and most half width, as a share of the half length.
        bend: most bend, as a share of the half length.
        aligned: strokes follow the picture's own direction this closely, in rad; None if they point anywhere.
    """

    kind: int
    halves_px: tuple[float, ...]
    step: float
    slim: tuple[float, float]
    bend: float = 0.0
    aligned: float | None = None


BRUSHES = {
    "venation": Brush(LEAF, (5.0, 3.0), 0.44, (0.36, 0.56), 0.25),
    "stone": Brush(FACET, (8.0, 4.2), 0.40, (0.35, 0.8), 0.0, 0.5),
    "bristle": Brush(MARK, (10.0, 5.5), 0.32, (0.16, 0.26), 0.12, 0.25),
}
"""By name of the material as it is seen in the new image."""
LEAST_SHARE = 0.2
HAIRY = "hair"
HAIR_WIDTH_PX, HAIR_LENGTH_PX = (2.4, 4.8), (90.0, 190.0)
"""In px of an image that is eight times the observation."""
BRIGHTNESS, STRAY_RAD = 0.1, 0.1
HAIRS_DEEP = 5.0
"""How many hairs lie over one another."""


@dataclass(frozen=True)
class Painting:
    """A picture of strokes.

    Attributes:
        image: ``(H, W, 3)`` in grey levels.
        cover: ``(H, W)`` in 0..1: where there are any.
    """

    image: FloatArray
    cover: FloatArray


def in_strokes(
    base: FloatArray,
    seen: FloatArray,
    shares: dict[str, FloatArray],
    seeds: tuple[int, ...],
) -> Painting:
    """Returns the picture in strokes wherever there is a material that consists of such.

    Args:
        base: ``(H, W, 3)`` the crisp base in grey levels.
        seen: ``(h, w, 3)`` the observation in grey levels.
        shares: per material ``(h, w)`` in 0..1, where it is.
        seeds: of the randomness; the same seeds give the same bytes.
    """
    image, cover = base, np.zeros(base.shape[:2], np.float32)
    for name in sorted(shares.keys() & (BRUSHES.keys() | {HAIRY})):
        where = shares[name]
        if where.max() < LEAST_SHARE:
            continue
        if name == HAIRY:
            painting = combed(image, seen, where, seeds)
        else:
            painting = stroked(image, seen, where, BRUSHES[name], seeds)
        image, cover = painting.image, np.maximum(cover, painting.cover)
    return Painting(image, cover)


def warm_up() -> None:
    """Compiles the kernels, so that the first strokes are as fast as the others."""
    seen = np.random.default_rng(0).uniform(0, 255, (12, 16, 3)).astype(np.float32)
    everywhere = np.ones(seen.shape[:2], np.float32)
    base = enlarged(seen, 32, 24)
    for name in (*BRUSHES, HAIRY):
        in_strokes(base, seen, {name: everywhere}, (0,))


def stroked(
    base: FloatArray, seen: FloatArray, where: FloatArray, brush: Brush, seeds: tuple[int, ...]
) -> Painting:
    """Returns the picture painted in strokes.

    Args:
        base: ``(H, W, 3)`` the crisp base in grey levels, kept where no stroke lies.
        seen: ``(h, w, 3)`` the observation in grey levels.
        where: ``(h, w)`` in 0..1, how likely a stroke is laid.
        brush: what they look like.
        seeds: of the randomness; the same seeds give the same bytes.
    """
    rng = np.random.default_rng([*seeds, 31])
    seen = np.ascontiguousarray(seen, np.float32)
    top, shade = np.zeros(base.shape[:2], np.int32), np.ones(base.shape[:2], np.float32)
    colors = np.zeros((1, 3), np.float32)
    along = (
        None if brush.aligned is None else voted_direction(luma(seen), 4 * seen.shape[1], 4 * seen.shape[0])
    )
    for half_px in brush.halves_px:
        sites = _sites(seen, where, half_px * brush.step, rng)
        if len(colors) > 1:
            sites = sites[_unlike(_painted(*_halved(base, top, shade), colors), seen, sites)]
        strokes, own = _chosen(seen, sites, brush, half_px, along, rng)
        strokes[:, [0, 1, 4, 5, 6]] *= base.shape[1] / seen.shape[1]
        _laid(brush.kind, strokes.astype(np.float32), len(colors), top, shade)
        colors = np.concatenate([colors, own])
    colors = _matched(*_halved(base, top, shade), colors, seen)
    cover = blurred((top > 0).astype(np.float32), 0.6)
    return Painting(_relit(_smooth_rims(_painted(base, top, shade, colors), top), seen, cover), cover)


def _halved(base: FloatArray, top: IntArray, shade: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Returns every other pixel: enough to see which colours are right."""
    base, top, shade = base[::2, ::2], top[::2, ::2], shade[::2, ::2]
    return np.ascontiguousarray(base), np.ascontiguousarray(top), np.ascontiguousarray(shade)


def _sites(seen: FloatArray, where: FloatArray, step_px: float, rng: np.random.Generator) -> FloatArray:
    """Returns ``(n, 2)`` places in px of the observation, jittered off a grid, that the chance lets pass."""
    rows, columns = seen.shape[:2]
    x, y = np.meshgrid(np.arange(-1, columns / step_px + 1), np.arange(-1, rows / step_px + 1))
    sites = np.stack([x.ravel(), y.ravel()], 1) * step_px
    sites += rng.uniform(-0.55, 0.55, sites.shape) * step_px
    places: FloatArray = sites.astype(np.float32)
    return places[rng.random(len(places)) < _at(where, places)]


def _at(plane: FloatArray, sites: FloatArray) -> FloatArray:
    rows, columns = plane.shape[:2]
    x = np.clip(sites[:, 0].astype(int), 0, columns - 1)
    return plane[np.clip(sites[:, 1].astype(int), 0, rows - 1), x]


def _unlike(painted: FloatArray, seen: FloatArray, sites: FloatArray) -> BoolArray:
    away = np.abs(blurred(seen - area_down(painted, seen.shape[1], seen.shape[0]), 0.7)).mean(2)
    return np.asarray(_at(away, sites) > UNLIKE)


def _chosen(
    seen: FloatArray,
    sites: FloatArray,
    brush: Brush,
    half_px: float,
    along: tuple[FloatArray, FloatArray] | None,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Returns ``(n, 8)`` strokes in px of the observation, in their order, and their ``(n, 3)`` colours."""
    count = (len(sites), CANDIDATES)
    angles = rng.uniform(0, 2 * np.pi, (len(sites), 1)) + TURN * np.arange(CANDIDATES)
    if along is not None and brush.aligned is not None:
        x, y = along
        angles = np.arctan2(_at(y, sites), _at(x, sites))[:, None] + brush.aligned * rng.standard_normal(
            count
        )
    halves = (half_px * rng.uniform(0.65, 1.35, count)).astype(np.float32)
    slim = rng.uniform(*brush.slim, count).astype(np.float32)
    found = np.zeros((len(sites), 6), np.float32)
    args = seen, sites, angles.astype(np.float32), halves, slim
    over_rows(lambda a, b: fit(*args, a, b, found), len(sites))
    order = np.argsort(luma(found[:, 3:]) + rng.normal(0, ORDER_NOISE, len(sites)), kind="stable")
    bend = brush.bend * rng.uniform(-1, 1, len(sites)) * found[:, 1]
    turned = np.cos(found[:, 0]), np.sin(found[:, 0])
    strokes = np.stack(
        [sites[:, 0], sites[:, 1], *turned, found[:, 1], found[:, 2], bend, rng.random(len(sites))], 1
    )
    return strokes[order], found[order, 3:]


def _laid(kind: int, strokes: FloatArray, offset: int, top: IntArray, shade: FloatArray) -> None:
    over_rows(lambda a, b: lay(kind, strokes, offset, top, shade, a, b), len(top))


def _painted(ground: FloatArray, top: IntArray, shade: FloatArray, colors: FloatArray) -> FloatArray:
    image = np.where((top > 0)[..., None], colors[top], ground)
    image *= shade[..., None]
    return image


def _matched(
    ground: FloatArray, top: IntArray, shade: FloatArray, colors: FloatArray, seen: FloatArray
) -> FloatArray:
    """Returns the colours with which the painting, shrunk, is nearest to what was seen (Landweber)."""
    height, width = top.shape
    flat = top.ravel()
    weights = np.bincount(flat, shade.ravel(), len(colors)) + 1e-3
    least, most = 0.7 * colors - 6, 1.35 * colors + 10
    for _ in range(COLOUR_TURNS):
        away = seen - area_down(_painted(ground, top, shade, colors), seen.shape[1], seen.shape[0])
        away = cv2.resize(away, (width, height), interpolation=cv2.INTER_NEAREST).reshape(-1, 3)
        moved = [np.bincount(flat, away[:, c], len(colors)) / weights for c in range(3)]
        colors = np.clip(colors + np.stack(moved, 1), least, most).astype(np.float32)
    return np.clip(colors, 0, 255)


def _smooth_rims(image: FloatArray, top: IntArray) -> FloatArray:
    """Returns the image with the steps of its outlines smoothed."""
    rims = np.zeros(top.shape, np.uint8)
    across, down = top[:, 1:] != top[:, :-1], top[1:] != top[:-1]
    rims[:, 1:] |= across
    rims[:, :-1] |= across
    rims[1:] |= down
    rims[:-1] |= down
    return np.where(rims[..., None] > 0, blurred(image, 0.6), image)


def _relit(image: FloatArray, seen: FloatArray, cover: FloatArray) -> FloatArray:
    """Returns the image with light and shade in which, shrunk, it is nearer still to what was seen."""
    rows, columns = seen.shape[:2]
    for _ in range(LIGHT_TURNS):
        gain = (luma(seen) + 6) / (luma(area_down(image, columns, rows)) + 6)
        gain = enlarged(gain.clip(1 / GAIN, GAIN), image.shape[1], image.shape[0])
        image = image * (1 + cover * (gain - 1))[..., None]
    return image


def combed(base: FloatArray, seen: FloatArray, where: FloatArray, seeds: tuple[int, ...]) -> Painting:
    """Returns the picture as a coat of hairs that follow its direction; arguments as of `stroked`."""
    rng = np.random.default_rng([*seeds, 32])
    height, width = base.shape[:2]
    grow = width / seen.shape[1] / 8
    calm = np.ascontiguousarray(blurred(seen, 0.8), np.float32)
    field = [np.ascontiguousarray(v) for v in voted_direction(luma(seen), width, height, CALM_VOTES)]
    hairs = _hairs(width, height, grow, rng)
    hairs = hairs[rng.random(len(hairs)) < _at(where, hairs[:, :2] * (seen.shape[1] / width))]
    image, cover = enlarged(calm, width, height) * np.float32(BEHIND), np.zeros((height, width), np.float32)
    share = enlarged(where, width, height).clip(0, 1)
    image = base + share[..., None] * (image - base)
    over_rows(lambda a, b: comb(hairs, *field, calm, image, cover, a, b), height)
    cover = np.maximum(cover, share)
    return Painting(_relit(image, seen, cover), cover)


def _hairs(width: int, height: int, grow: float, rng: np.random.Generator) -> FloatArray:
    """Returns ``(n, 6)`` hairs, see `comb`: the brighter ones rather in front."""
    each_px = float(np.mean(HAIR_WIDTH_PX) * np.mean(HAIR_LENGTH_PX)) * grow * grow
    count = int(HAIRS_DEEP * height * width / each_px)
    margin = HAIR_LENGTH_PX[1] * grow
    hairs = np.empty((count, 6), np.float32)
    hairs[:, 0] = rng.uniform(-margin, width + margin, count)
    hairs[:, 1] = rng.uniform(-margin, height, count)
    hairs[:, 2] = grow * rng.uniform(*HAIR_LENGTH_PX, count)
    hairs[:, 3] = grow * rng.uniform(*HAIR_WIDTH_PX, count)
    hairs[:, 4] = np.exp(rng.normal(0, BRIGHTNESS, count))
    hairs[:, 5] = rng.normal(0, STRAY_RAD, count)
    return hairs[np.argsort(hairs[:, 4] + rng.normal(0, BRIGHTNESS, count), kind="stable")]
