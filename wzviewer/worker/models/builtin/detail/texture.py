"""The texture of every material in the picture, put together along the picture's own contours."""

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.drifts import drifting
from wzviewer.worker.models.builtin.detail.flow import (
    CALM_VOTES,
    GRAINS,
    NEAR_VOTES,
    Grain,
    grain_texture,
    voted_direction,
)
from wzviewer.worker.models.builtin.detail.library import INT8_PER_DEVIATION, TILE_PX, TileLibrary
from wzviewer.worker.models.builtin.detail.measures import area_down, luma, stretched
from wzviewer.worker.models.builtin.detail.octaves import GRAIN_OCTAVES, SPECTRA, evened

SMOOTH = frozenset({"smooth", "sky", "blur", "glaze", "wet", "tear"})
SMOOTH_TILE = "plaster"
"""The tile that smooth materials show, at next to no contrast."""
SHOWS_AS = {"metal": "polish", "jelly": "cytoplasm"}
"""Materials that are seen by the tile of another: hairlines and smudges on metal."""
TURN_RAD = 0.4
"""A tile is smaller than the picture: turned, it does not repeat along a row, and its light hardly turns."""
NARROW = 0.4  # of the picture
FORM_SIZE = 6.0
LOCK_PX = 0.6  # of the observation, per px of the strands
EVEN = frozenset({"yarn", "weave", "lattice", "polish", "metal", "salt", "shell"})
"""What is laid in rows or glossy, and gathers nowhere."""
TURNABLE = frozenset(
    {"foliage", "cell", "granite", "weave", "cornea", "alloy", "frost", "haze", "air", "froth"}
    | {"orbital", "shell", "sea", "helix", "strings"}
)  # unlit tiles: a quarter turn does not move the light


@dataclass(frozen=True)
class Layout:
    """Where which material is.

    Attributes:
        labels: ``(H, W)`` u8, the strongest label.
        shares: per label that occurs, ``(H, W)`` in 0..1; they sum to 1.
    """

    labels: ByteArray
    shares: dict[int, FloatArray]


def layout(coarse_labels: ByteArray, guide: FloatArray) -> Layout:
    """Returns the label map moved onto the contours of the picture, by a guided filter (He et al. 2013).

    Args:
        coarse_labels: ``(h, w)`` u8 at the observation's size.
        guide: ``(H, W, 3)`` the crisp base in grey levels.
    """
    height, width = guide.shape[:2]
    present = [int(label) for label in np.unique(coarse_labels)]
    if len(present) == 1:
        full = np.full((height, width), present[0], np.uint8)
        return Layout(full, {present[0]: np.ones((height, width), np.float32)})
    size = (max(width // 4, 1), max(height // 4, 1))
    small_guide = cv2.resize(guide, size, interpolation=cv2.INTER_AREA)
    votes = []
    for label in present:
        member = stretched((coarse_labels == label).astype(np.float32), *size)
        votes.append(cv2.ximgproc.guidedFilter(small_guide, member, 8, 60.0))
    weights = np.maximum(np.stack([stretched(vote, width, height) for vote in votes]), 1e-4) ** 4
    weights /= weights.sum(0)
    labels = np.array(present, np.uint8)[weights.argmax(0)]
    return Layout(labels, dict(zip(present, weights, strict=True)))


def shrunk(place: Layout, width: int, height: int) -> Layout:
    """Returns the layout as a coarser camera would see it."""
    labels = cv2.resize(place.labels, (width, height), interpolation=cv2.INTER_NEAREST)
    return Layout(labels, {label: area_down(share, width, height) for label, share in place.shares.items()})


def shares_by_name(place: Layout, names: tuple[str, ...]) -> dict[str, FloatArray]:
    """Returns per material ``(H, W)`` in 0..1: where it is."""
    found: dict[str, FloatArray] = {}
    for label, share in place.shares.items():
        name = names[label]
        found[name] = found[name] + share if name in found else share
    return found


def painted_texture(
    place: Layout,
    names: tuple[str, ...],
    observation: FloatArray,
    library: TileLibrary,
    seeds: tuple[int, ...],
    stride: int = 1,
    is_deep: bool = False,
) -> FloatArray:
    """Returns the texture of all materials, ``(H, W)``: local mean 0, local RMS 1.

    Args:
        place: where which label is.
        names: material name per label.
        observation: ``(h, w, 3)`` in grey levels; gives the grain its direction.
        library: source of the tiles.
        seeds: of the randomness; the same seeds give the same bytes.
        stride: texture px per image px; 2 for a preview of half the size.
        is_deep: beyond the photograph: its blurs are no strands to follow one by one.
    """
    height, width = place.labels.shape
    by_name = shares_by_name(place, names)
    direction = None
    if GRAINS.keys() & by_name.keys():
        votes = CALM_VOTES if is_deep else NEAR_VOTES
        direction = voted_direction(luma(observation), width, height, votes)
    total = np.zeros((height, width), np.float32)
    for name in sorted(by_name):
        rng = np.random.default_rng([*seeds, *name.encode()])
        if direction is not None and name in GRAINS:
            layer = _strands(GRAINS[name], direction, by_name[name], rng, stride)
        else:
            layer = tile_texture(
                library.tile(SMOOTH_TILE if name in SMOOTH else SHOWS_AS.get(name, name)),
                name,
                width,
                height,
                rng,
                stride,
            )
        total += by_name[name] * layer
    return total


def coarse_forms(
    place: Layout,
    names: tuple[str, ...],
    observation: FloatArray,
    library: TileLibrary,
    seeds: tuple[int, ...],
) -> FloatArray:
    """Returns ``(h, w)`` in deviations: the forms of every material once more, `FORM_SIZE` times as large.

    Cells lie together in cells, motes in swarms, hairs in locks: what has one size only is a carpet.

    Args:
        place: where which label is, at the observation's size.
        names: material name per label.
        observation: ``(h, w, 3)`` in grey levels; gives the grain its direction.
        library: source of the tiles.
        seeds: of the randomness; the same seeds give the same bytes.
    """
    height, width = place.labels.shape
    total = np.zeros((height, width), np.float32)
    for label, share in place.shares.items():
        name = names[label]
        if name in SMOOTH or name in EVEN:
            continue
        rng = np.random.default_rng([*seeds, 13, *name.encode()])
        drift = drifting(name, height, width, rng)
        if drift is not None:
            total += share * drift
        elif name in GRAINS:
            total += share * _locks(GRAINS[name], luma(observation), rng)
        else:
            tile = library.tile(SHOWS_AS.get(name, name))
            total += share * tile_texture(tile, name, width, height, rng, 8 / FORM_SIZE)
    return total


def _locks(grain: Grain, plane: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Returns wide strands along the plane's own grain, of unit deviation and of its size."""
    height, width = plane.shape
    direction = voted_direction(plane, 8 * width, 8 * height, CALM_VOTES)
    wide = replace(
        grain, width_px=LOCK_PX * grain.width_px, half_length_px=width // 3, vessels=0.0, velvet=0.0
    )
    strands = grain_texture(wide, direction, np.ones(plane.shape, bool), rng)
    return strands / (strands.std() + np.float32(1e-6))


def _strands(
    grain: Grain,
    direction: tuple[FloatArray, FloatArray],
    share: FloatArray,
    rng: np.random.Generator,
    stride: int,
) -> FloatArray:
    """Returns strands where their share is; in seams they are short bundles, drawn at half the size."""
    mask = share > 0.02
    if share.mean() >= NARROW:
        return evened(grain_texture(grain, direction, mask, rng, stride), GRAIN_OCTAVES, stride)
    height, width = mask.shape
    half = (max(width // 2, 1), max(height // 2, 1))
    small = cv2.resize(mask.astype(np.uint8), half, interpolation=cv2.INTER_NEAREST) > 0
    short = replace(grain, half_length_px=grain.half_length_px // 2)
    layer = evened(grain_texture(short, direction, small, rng, stride), GRAIN_OCTAVES, 2 * stride)
    return cv2.resize(layer, (width, height), interpolation=cv2.INTER_CUBIC)


def tile_texture(
    tile: np.ndarray, name: str, width: int, height: int, rng: np.random.Generator, stride: float = 1
) -> FloatArray:
    """Returns a piece of the endless tile, shifted and gently bent, ``(height, width)`` in deviations."""
    source = np.rot90(tile, int(rng.integers(4))) if name in TURNABLE else tile
    angle = rng.uniform(-TURN_RAD, TURN_RAD) if name in SPECTRA else 0.0
    offset_x, offset_y = rng.uniform(0, TILE_PX, 2)
    bend = rng.standard_normal((2, 6, 8)).astype(np.float32) * np.float32(
        4.0
    )  # more would stretch cells to hairs
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) * np.float32(stride)
    bend_x, bend_y = (cv2.resize(plane, (width, height), interpolation=cv2.INTER_CUBIC) for plane in bend)
    if angle:
        c, s = np.float32(math.cos(angle)), np.float32(math.sin(angle))
        x, y = c * x - s * y, s * x + c * y
    map_x = np.mod(x + bend_x + np.float32(offset_x), TILE_PX)
    map_y = np.mod(y + bend_y + np.float32(offset_y), TILE_PX)
    floats = np.ascontiguousarray(source).astype(np.float32) * np.float32(1 / INT8_PER_DEVIATION)
    return cv2.remap(floats, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
