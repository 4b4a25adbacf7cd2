"""A level is no even sheet: what lies in the dark lines of the level before is something else.

The walls of a cell are bundles of fibrils, its inside is grains.  What is a wall is seen in the observation:
darker than its surroundings, and thin.  And a texture is richer on forms than on the ground, here busy and
there calm.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.detail.amplitude import wet_places
from wzviewer.worker.models.builtin.detail.flow import GRAINS
from wzviewer.worker.models.builtin.detail.materials import MATERIALS
from wzviewer.worker.models.builtin.detail.measures import blurred, local_rms, luma, orientation, ramp

SURROUNDINGS_PX = 6.0  # of the observation
DARKER = 0.7  # deviations of the surroundings
LEAST_DARKER = 2.5  # grey levels: below that nobody sees a line
PATCH_PX = 34.0  # of the observation, from a busy place to a calm one
BORDER_SHARE, AT_BORDER = 0.17, 0.15
"""Of the shorter side: over how much of it texture fades in; its contrast at the very border."""
PATCHES, ON_FORMS = 0.35, 0.3
GATHERED = 0.6  # as a logarithm, per deviation
WHITE, ROOM_SHARE = 262.0, 0.3
BLADES, BLADES_PX = 0.53, 3.0
LEAST_PX = 60  # of the observation; fewer are specks

WET = "wet"
"""The material of an eye or a nose, of which only its gloss tells."""


def with_seams(
    grey: FloatArray, labels: ByteArray, names: tuple[str, ...]
) -> tuple[ByteArray, tuple[str, ...]]:
    """Returns labels and names in which the dark lines are of the material that fills them.

    Args:
        grey: ``(h, w, 3)`` the observation in grey levels.
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
    """
    result, all_names = labels, names
    dark = None
    for label in np.unique(labels):
        between = MATERIALS[names[label]].between
        if not between:
            continue
        dark = dark_lines(luma(grey)) if dark is None else dark
        seams = dark & (labels == label)
        if seams.sum() >= LEAST_PX:
            result = np.where(seams, len(all_names), result).astype(np.uint8)
            all_names = (*all_names, between)
    return result, all_names


def dark_lines(plane: FloatArray) -> BoolArray:
    """Returns ``(h, w)``: what is darker than its surroundings; ``plane`` is luma in grey levels."""
    away = plane - blurred(plane, SURROUNDINGS_PX)
    least = np.maximum(np.float32(DARKER) * local_rms(away, 2 * SURROUNDINGS_PX), np.float32(LEAST_DARKER))
    return np.asarray(blurred(away, 0.7) < -least)


def bare(plane: FloatArray) -> FloatArray:
    """Returns ``(h, w)`` in 0..1: where the observation has no forms; ``plane`` is luma in grey levels."""
    return 1 - ramp(local_rms(plane - blurred(plane, SURROUNDINGS_PX), SURROUNDINGS_PX), 2.0, 5.0)


def unevenness(plane: FloatArray, seeds: tuple[int, ...], forms: FloatArray | None = None) -> FloatArray:
    """Returns ``(h, w)`` about 1: factors on the contrast of new detail.

    Args:
        plane: ``(h, w)`` luma of the observation in grey levels.
        forms: ``(h, w)`` in deviations, which the detail gathers on.
        seeds: of the randomness; the same seeds give the same bytes.
    """
    height, width = plane.shape
    rng = np.random.default_rng([*seeds, 11])
    knots = rng.standard_normal((round(height / PATCH_PX) + 2, round(width / PATCH_PX) + 2)).astype(
        np.float32
    )
    patches = cv2.resize(knots, (width, height), interpolation=cv2.INTER_CUBIC)
    away = plane - blurred(plane, SURROUNDINGS_PX)
    form = np.tanh(away / (local_rms(away, 2 * SURROUNDINGS_PX) + np.float32(2)))
    factor: FloatArray = 1 + np.float32(PATCHES) * patches + np.float32(ON_FORMS) * form
    if forms is not None:
        factor *= np.exp(np.float32(GATHERED) * forms)
    return factor.clip(0.25, 1.8)


def faded_border(width: int, height: int) -> FloatArray:
    """Returns ``(h, w)``: 1 inside, `AT_BORDER` at the border, a smooth step between.

    From farther away a level lies in its parent, which has none of its texture: a rectangle of cells on a
    smooth petal.
    """
    x, y = (np.minimum(np.arange(n), np.arange(n)[::-1]) + 0.5 for n in (width, height))
    t = np.clip(np.minimum(y[:, None], x[None]) / (BORDER_SHARE * min(width, height)), 0, 1)
    return (AT_BORDER + (1 - AT_BORDER) * t * t * (3 - 2 * t)).astype(np.float32)


def most_in_light(grey: FloatArray) -> FloatArray:
    """Returns ``(h, w)``: the most contrast there may be, by the room to white, or a descent ends in it.

    Args:
        grey: ``(h, w, 3)`` the observation in grey levels.
    """
    room = np.float32(WHITE) - 0.5 * (grey.max(2) + luma(grey))
    return np.float32(ROOM_SHARE) * room + np.float32(0.8)


def whole_forms(mask: BoolArray) -> BoolArray:
    """Returns the mask with every piece filled up to its convex outline: the light in an eye is of the eye.

    Args:
        mask: ``(h, w)``.
    """
    filled = np.zeros(mask.shape, np.uint8)
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        cv2.fillConvexPoly(filled, cv2.convexHull(outline), 1)
    return np.asarray(filled > 0)


def without_strands_on_gloss(
    grey: FloatArray, labels: ByteArray, names: tuple[str, ...]
) -> tuple[ByteArray, tuple[str, ...]]:
    """Returns labels and names in which an eye amid fur is `WET`: deeper levels inherit it and grow no hair.

    Args:
        grey: ``(h, w, 3)`` the observation in grey levels.
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
    """
    strands = np.array([name in GRAINS for name in names])[labels]
    if not strands.any():
        return labels, names
    bare = np.array([name == "skin" for name in names])[labels]
    wet = whole_forms(wet_places(luma(grey), strands | bare)) & (strands | bare)
    if not wet.any():
        return labels, names
    return np.where(wet, len(names), labels).astype(np.uint8), (*names, WET)


def without_leaves_on_grass(
    grey: FloatArray, labels: ByteArray, names: tuple[str, ...]
) -> tuple[ByteArray, tuple[str, ...]]:
    """Returns labels and names in which a meadow is single blades, larger than leaves: none grow on them.

    The structure tensor is coherent there, .55 to .72 over a region; in woods and on wooded slopes it is .33
    to .51.

    Args:
        grey: ``(h, w, 3)`` the observation in grey levels.
        labels: ``(h, w)`` u8, index into `names`.
        names: material per label.
    """
    straight = None
    blades = np.zeros(labels.shape, bool)
    for label in np.unique(labels):
        if names[label] == "foliage":
            straight = orientation(luma(grey), 1.0, BLADES_PX).coherence if straight is None else straight
            region = labels == label
            blades |= region & bool(straight[region].mean() > BLADES)
    if not blades.any():
        return labels, names
    return np.where(blades, len(names), labels).astype(np.uint8), (*names, "venation")
