"""What is in the picture: S of Algorithm 1, line 11.  Colour, roughness and direction name a material.

The rules are those of a person with poor sight: green and rough are leaves, blue and even at the top is sky.
They know ten regions of a look, not things; a prompt word overrides them.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.blurs import with_blurs
from wzviewer.worker.models.builtin.detail.cloths import with_cloths
from wzviewer.worker.models.builtin.detail.clusters import Region, regions_of, split_off, statistics
from wzviewer.worker.models.builtin.detail.folds import with_folds
from wzviewer.worker.models.builtin.detail.materials import MATERIALS, closer
from wzviewer.worker.models.builtin.detail.rims import without_rims
from wzviewer.worker.models.builtin.detail.waters import with_waters

BUILT_SHARE = 0.35
"""From this share of contours along two axes on it is walls, roofs and windows, no stone that broke."""
PETAL_LIGHT, PETAL_SHADE, PETAL_COLOUR = 0.72, 0.5, 0.14
"""Of a white petal: in the light, at least in the shade, and the most of the channels' distance."""
PETAL_PX, PETAL_REACH = 9, 0.05
"""What is looked at, and how far the shade of a petal is from its light, as a share of the width."""
EVEN_FINE = 0.6  # grey levels; rougher is no even surface
LEAST_SOLID = 0.002  # of the picture
OBJECTS_SPREAD = 2.5
"""Above this ratio of the octaves it is objects that make the contrast, no texture: glass, metal, spokes."""

TEXTURE_TONES = 0.6
"""Below this share of tones between its light and its dark it is openwork, letters: no broken stone."""

LEAF_SPREAD = 1.6
"""Above this ratio of the octaves green is single leaves and stems, about 2; below it a wood, 1.0 to 1.2."""

PETAL_CHROMA, PETAL_HUES_DEG = 35.0, 25.0
MAY_BE_DISC = frozenset({"cell", "rock", "sand", "venation"})
DISC_CHROMA = 60.0  # of a daisy's; straw and stubble have 40 to 50
SCRAPS = 0.03  # of the picture: less is no field of straw, but the mixed hem of petals
GREEN_SHARE = 0.12  # of a picture of plants

RIM_TONES, RIM_SPREAD = 0.25, 1.8
METAL_CHROMA = 20.0
"""Iron and steel have less colour: 5 to 12 in the photographs looked at, a sunflower's kin 28."""


@dataclass(frozen=True)
class Context:
    """The description of one level's image, inherited by all that is seen inside it.

    Attributes:
        labels: ``(h, w)`` u8, index into `materials`.
        materials: per label, the name of the material that an enlargement of it shows.
        regions: per label, its statistics.
        words: the same for a person: "green leaves, grey rock, smooth sky".
        level: of the image that is described.
    """

    labels: ByteArray
    materials: tuple[str, ...]
    regions: tuple[Region, ...]
    words: str
    level: int = 0


def described(image: FloatArray, parent: Context | None = None) -> Context:
    """Returns the context of an image of which only the pixels are known.

    Args:
        image: ``(h, w, 3)`` in 0..1.
        parent: context of the level that it lies inside; its regions then take the parent's materials by
            likeness of colour, because a close-up of a leaf does not look like a tree.
    """
    labels, regions = regions_of(image)
    labels, regions = without_rims(image, labels, regions)
    if parent is None:
        names, level = classified(regions), 0
        labels, regions, names = with_waters(image, labels, regions, names)
        labels, regions, names = with_cloths(image, labels, regions, names)
        labels = with_folds(labels, names)
        labels, regions, names = with_blurs(image, labels, regions, names)
    else:
        names, level = tuple(_heir(region, parent) for region in regions), parent.level + 1
    return Context(labels, names, regions, words_for(regions, names), level)


def inherited(image: FloatArray, parent: Context, labels: ByteArray, names: tuple[str, ...]) -> Context:
    """Returns the context of an image made from known labels: materials become what they are made of."""
    regions = statistics(image, labels, len(names))
    return Context(labels, closer(names), regions, words_for(regions, names), parent.level + 1)


def below_sky(context: Context, image: FloatArray, sky: BoolArray) -> Context:
    """Returns the context in which nothing is sky that the depth of the scene knows is none: a white petal.

    Args:
        context: of the image.
        image: ``(h, w, 3)`` in 0..1.
        sky: ``(h, w)``, where the sky is; if that is nowhere, nothing is known of it.
    """
    named = np.array([name == "sky" for name in context.materials])[context.labels]
    solid = named & ~sky
    if not sky.any() or solid.mean() < LEAST_SOLID:
        return context
    petals = solid & _white_petals(image) & any(map(_green, context.regions))
    labels, regions, names = context.labels, context.regions, context.materials
    for mask, name in ((solid & ~petals, "smooth"), (petals, "petal")):
        if mask.mean() >= LEAST_SOLID / 2:
            labels, regions = split_off(image, labels, regions, mask)
            names = (*names, name)
    return Context(labels, names, regions, words_for(regions, names), context.level)


def _white_petals(image: FloatArray) -> BoolArray:
    """Where it is as light and plain as a white petal in the shade, and white nearby; far hills are not."""
    mean = cv2.blur(image, (PETAL_PX, PETAL_PX))
    darkest = mean.min(2)
    plain = (darkest > PETAL_SHADE) & (mean.max(2) - darkest < PETAL_COLOUR)
    reach = round(PETAL_REACH * image.shape[1])
    white = cv2.dilate((darkest > PETAL_LIGHT).astype(np.uint8), np.ones((reach, reach), np.uint8))
    return np.asarray(plain & (white > 0))


def _heir(region: Region, parent: Context) -> str:
    def distance(other: Region) -> float:
        return math.dist(_lab(region), _lab(other)) - 4 * math.sqrt(other.share)

    nearest = min(range(len(parent.regions)), key=lambda index: distance(parent.regions[index]))
    return MATERIALS[parent.materials[nearest]].closer


def _lab(region: Region) -> tuple[float, float, float]:
    return 0.5 * region.lightness, region.green_red, region.blue_yellow


def classified(regions: tuple[Region, ...]) -> tuple[str, ...]:
    """Returns a material name per region of a photograph; some regions are known by their company."""
    if is_painted(regions):
        return tuple("smooth" if region.fine < EVEN_FINE else "paint" for region in regions)
    names = [_material_name(region) for region in regions]
    skies = [region for region, name in zip(regions, names, strict=True) if name == "sky"]
    fur = sum(region.share for region, name in zip(regions, names, strict=True) if name == "fur")
    for index, region in enumerate(regions):
        if names[index] == "smooth" and any(math.dist(_lab(region), _lab(sky)) < 12 for sky in skies):
            names[index] = "sky"  # its lower end
        if skies and names[index] in ("plaster", "rock") and _cloudy(region):
            names[index] = "sky"  # clouds that do not reach the top
        if fur > 0.06 and names[index] in ("plaster", "rock", "metal"):  # an animal: its white and its black
            names[index] = "fur" if 3 < region.fine + region.middle < 12 else "skin"
        if names[index] == "plaster" and "foliage" in names and _dark_green(region):
            names[index] = "foliage"  # a wood's shade
        if names[index] in ("venation", "straw", "cell") and not any(map(_green, regions)):
            names[index] = _made_by_hand(region)  # nothing grows here
    return _with_plants(regions, names)


def _with_plants(regions: tuple[Region, ...], names: list[str]) -> tuple[str, ...]:
    """Where something grows, what has a petal's colour is petal; then its disc and the leaves are known."""
    green = sum(region.share for region in regions if _green(region))
    if not green:
        return tuple(names)
    petals = [
        region for region, name in zip(regions, names, strict=True) if name == "venation" and _petal(region)
    ]
    result = []
    for region, name in zip(regions, names, strict=True):
        if petals and name == "smooth" and any(_of_petal(region, petal) for petal in petals):
            result.append("petal")  # its calm parts
        elif _yellow_disc(region) or (petals and name in MAY_BE_DISC and _disc(region)):
            result.append("floret")
        elif _petal(region) and (
            name == "venation" or (petals and name == "straw" and region.share < SCRAPS)
        ):
            result.append("petal")
        elif name == "plaster" and green > GREEN_SHARE and _leaf_in_shade(region):
            result.append("venation")
        else:
            result.append(name)
    return tuple(result)


def _petal(region: Region) -> bool:
    return _chroma(region) > PETAL_CHROMA and not 95 < _hue(region) < 300


def _of_petal(region: Region, petal: Region) -> bool:
    return _petal(region) and abs((_hue(region) - _hue(petal) + 180) % 360 - 180) < PETAL_HUES_DEG


def _disc(region: Region) -> bool:
    rough = region.fine + region.middle > 12 and region.coherence < 0.55
    return rough and region.lightness < 45 and _chroma(region) > METAL_CHROMA and 20 < _hue(region) < 100


def _yellow_disc(region: Region) -> bool:
    dense = region.fine > 6 and region.wide < OBJECTS_SPREAD * region.fine
    return dense and _chroma(region) > DISC_CHROMA and 60 < _hue(region) < 100


def _leaf_in_shade(region: Region) -> bool:
    grown = region.built < 0.3 and region.wide > LEAF_SPREAD * region.fine
    return grown and region.lightness < 30 and region.centre_y > 0.45


def is_painted(regions: tuple[Region, ...]) -> bool:
    """Whether the picture is a painting: it has strokes also where a photograph would be even, in its lights.

    Nothing in it is out of focus, and it has many colours, as a heap of gravel has not.
    """
    stroked = [region for region in regions if region.fine > 2.5 and region.tones > 0.6]
    everywhere = sum(region.share for region in stroked) > 0.9 * sum(region.share for region in regions)
    light = any(region.lightness > 75 and region.share > 0.03 for region in stroked)
    colourful = sum(region.share * _chroma(region) for region in regions) > 22
    return everywhere and light and colourful


def _made_by_hand(region: Region) -> str:
    """Cloth or leather if it is red, else paint."""
    if not (_hue(region) < 50 or _hue(region) > 340):
        return "plaster"
    return "weave" if region.fine > 1.7 else "skin"


def _dark_green(region: Region) -> bool:
    return region.lightness < 30 and region.green_red < -1.5


def _green(region: Region) -> bool:
    return region.share > 0.03 and 95 < _hue(region) < 170 and _chroma(region) > 9


def _chroma(region: Region) -> float:
    return math.hypot(region.green_red, region.blue_yellow)


def _hue(region: Region) -> float:
    return math.degrees(math.atan2(region.blue_yellow, region.green_red)) % 360


def _cloudy(region: Region) -> bool:
    return region.centre_y < 0.42 and region.lightness > 55 and _chroma(region) < 14 and region.fine < 4


def _material_name(region: Region) -> str:
    chroma, hue = _chroma(region), _hue(region)
    if region.fine < 1.7 and region.middle < 3.0:
        return _even_material(region, chroma, hue)
    return _rough_material(region, chroma, hue)


def _even_material(region: Region, chroma: float, hue: float) -> str:
    high_up = region.centre_y < 0.45 and (region.at_top > 0.12 or region.centre_y < 0.3)
    if high_up and region.lightness > 40 and (chroma < 11 or 180 < hue < 315):
        return "sky"
    if region.fine < EVEN_FINE:
        return "smooth"
    if (chroma > 35 and (hue < 110 or hue > 350)) or (95 < hue < 170 and chroma > 12):
        return "venation"
    if 35 < hue < 85 and 18 < chroma < 50 and region.fine > 1.0:
        return "skin"
    return "plaster" if region.fine > 1.0 else "smooth"


def _rough_material(region: Region, chroma: float, hue: float) -> str:
    rough = region.fine + region.middle
    if region.tones < RIM_TONES and region.wide > RIM_SPREAD * region.fine:
        return "smooth"  # contours and their two sides
    spread = region.wide / (
        region.fine + 0.1
    )  # about 1 in dense texture, above 1.5 where objects make the contrast
    if 95 < hue < 170 and chroma > 10.5:
        return "foliage" if rough > 8 and spread < LEAF_SPREAD else "venation"
    blue = 180 < hue < 310
    if region.at_top > 0.25 and region.centre_y < 0.4 and region.lightness > 55 and (blue or chroma < 10):
        return "sky"  # with clouds
    if blue and chroma > 9:
        return "ripple" if region.centre_y > 0.45 and rough < 7 else "rock" if rough > 10 else "plaster"
    if chroma < 13:
        return _grey_material(region, rough, spread)
    if chroma > 30 and 70 < hue < 112:
        return "straw" if spread < 1.5 else "venation"
    if chroma > 45:
        return "venation"
    return _brown_material(region, chroma, rough, spread)


def _grey_material(region: Region, rough: float, spread: float) -> str:
    if region.lightness < 30 and region.green_red < -2.5:
        return "plaster" if rough <= 4 else "foliage" if spread < LEAF_SPREAD else "venation"
    if region.lightness < 30 and spread > OBJECTS_SPREAD:
        return _openwork(region)
    stony = rough > 10 and region.lightness < 66 and region.built < BUILT_SHARE  # else a building
    if stony and region.tones < TEXTURE_TONES:
        return _openwork(region)
    return "rock" if stony and spread < OBJECTS_SPREAD else "plaster"


def _brown_material(region: Region, chroma: float, rough: float, spread: float) -> str:
    if chroma > 34 and rough > 10 and region.coherence < 0.45:
        return "cell"  # a flower's disc, fruit: alive
    if region.coherence > 0.58:  # a grain, or the straight edges of something built
        return "fibre" if chroma > 17 and spread < 2.3 else "plaster"
    if spread > OBJECTS_SPREAD or (rough > 12 and region.built > BUILT_SHARE):
        return "plaster"
    if rough > 12 and region.tones < TEXTURE_TONES:
        return _openwork(region)
    if rough > 17:
        return "sand" if region.coherence < 0.5 and region.centre_y > 0.45 else "rock"
    return "rock" if rough > 12 else "fur"


def _openwork(region: Region) -> str:
    """A railing, a grille, spokes, a frame: dark, they are metal; of a strong colour a flower's disc."""
    if region.lightness >= 50:
        return "plaster"
    return "metal" if _chroma(region) < METAL_CHROMA else "venation"


def words_for(regions: tuple[Region, ...], names: tuple[str, ...]) -> str:
    """Returns the description for a person, the largest first: colour, then the material's word."""
    shares: dict[str, float] = {}
    for region, name in zip(regions, names, strict=True):
        word = MATERIALS[name].word
        phrase = word if word.startswith("smooth sky") else f"{colour_word(region)} {word}"
        shares[phrase] = shares.get(phrase, 0.0) + region.share
    ranked = sorted(shares, key=lambda phrase: -shares[phrase])
    return ", ".join(phrase for phrase in ranked[:5] if shares[phrase] > 0.03 or phrase == ranked[0])


def colour_word(region: Region) -> str:
    """Returns the plain English name of a region's mean colour."""
    chroma, hue = _chroma(region), _hue(region)
    if region.lightness < 12:
        return "black"
    if chroma < 9:
        return "white" if region.lightness > 82 else "dark grey" if region.lightness < 35 else "grey"
    if chroma < 40 and 30 < hue < 85:
        return "beige" if region.lightness > 60 else "brown"
    edges = ((25, "pink" if region.lightness > 60 else "red"), (48, "red"), (75, "orange"), (100, "yellow"))
    named = (*edges, (175, "green"), (215, "turquoise"), (295, "blue"), (335, "violet"), (361, "red"))
    name = next(word for edge, word in named if hue < edge)
    return f"dark {name}" if region.lightness < 25 else name


def cropped_labels(
    context: Context, region: tuple[float, float, float, float], width: int, height: int
) -> ByteArray:
    """Returns the labels inside a region of the described image, ``(height, width)``, nearest.

    Args:
        context: of the image.
        region: ``(x0, y0, x1, y1)`` as fractions of it; parts outside repeat the border.
        width: of the result in px.
        height: of the result in px.
    """
    rows, columns = context.labels.shape
    x0, y0, x1, y1 = region
    x = np.floor((x0 + (np.arange(width) + 0.5) / width * (x1 - x0)) * columns)
    y = np.floor((y0 + (np.arange(height) + 0.5) / height * (y1 - y0)) * rows)
    take_x = np.clip(x, 0, columns - 1).astype(np.intp)
    take_y = np.clip(y, 0, rows - 1).astype(np.intp)
    return context.labels[take_y[:, None], take_x[None]]
