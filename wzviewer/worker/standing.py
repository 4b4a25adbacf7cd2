"""Objects of a level as surfels of their own, in front of the surface that they stand on.

Of a pixel that shows an object with coverage alpha, the ground is one surfel and the object another,
so that nothing of mixed colour is at the depth of either.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.anchor import AnchoredView
from wzviewer.core.constants import SURFEL_OPACITY, SURFEL_SIGMA_PX
from wzviewer.core.lift import lift_spanned
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.kernels.lifting import lift
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part, solid
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels

OPAQUE = 0.97  # coverage by an object, from which on nothing is seen through it
HIDES = 0.9  # coverage by an object, from which on what it hides is left as it is
SHEER = 0.9  # opacity, below which a surfel is meant to be seen through
RIM_SIGMA_PX, RIM_STEP_PX = 0.45, 12.0  # of flanks at an outline: that far down to the next pixel
BURIED_PX = 3  # from what is seen: no footprint reaches as far
HIDDEN_SIGMA_PX = 0.75  # not optimised: softer than the front, and closed
CONTACT_PX = 0.25  # that an object is in front of its ground
ASIDE_SLOPE, ASIDE_PX = 0.5, 8.0  # a camera 26 degrees aside sees so far past an outline, and a bit
DEEP_PX = 128.0  # from an outline: so far a camera sees into gaps of a body, whatever its flanks hide
UNKNOWN = np.float32(-9.0)  # a colour that stands for none
_ROOM_PX, _NOWHERE = 15, np.float32(-1e6)
_REACH = 4  # pixels whose footprints reach into one


@dataclass(frozen=True, eq=False)
class Front:
    """What a level's own camera sees.

    Attributes:
        surfels: the ground, and in front of it the objects' parts.
        kept: (n,) those that are no one's to optimise: what is covered, and what is seen through.
        buried: (n,) those among them that touch nothing which is seen.
    """

    surfels: Surfels
    kept: BoolArray
    buried: BoolArray


def front_surfels(draft: Draft) -> Front:
    """Lifts a draft; what an object hides of the ground or of itself is closed, as it is not optimised."""
    image = draft.image if draft.ground is None else draft.ground
    shown = np.where(out_of_sight(draft, draft.relief), np.float32(np.nan), draft.relief)
    sets = [generate_surfels(image, shown, draft.camera)]
    sets += [_part_surfels(part, draft) for part in draft.parts]
    fronts = _fronts(draft)
    hidden = [_is_at(s, front > _NOWHERE, draft) for s, front in zip(sets, fronts, strict=True)]
    buried = [_is_at(s, places, draft) for s, places in zip(sets, _buried(draft, fronts), strict=True)]
    sets = [_closed(sets[0], hidden[0]), *sets[1:]]  # a body's own detail goes on under its hairs
    surfels = Surfels.concatenate(sets)
    return Front(surfels, np.concatenate(hidden) | (surfels.opacities < SHEER), np.concatenate(buried))


def _fronts(draft: Draft) -> list[FloatArray]:
    """Returns the relief (h, w) of what hides the ground, and then each part: the nearest after it."""
    fronts = [np.full(draft.relief.shape, _NOWHERE)]
    for part in reversed(draft.parts):
        (x, y), (h, w) = part.offset_px, part.alpha.shape
        front = fronts[0].copy()
        window = front[y : y + h, x : x + w]
        hides = np.isfinite(part.relief) & (part.alpha >= HIDES)
        nearer = hides & ((window == _NOWHERE) | (part.relief < window))
        window[nearer] = part.relief[nearer]
        fronts.insert(0, front)
    return fronts


def _buried(draft: Draft, fronts: list[FloatArray]) -> list[BoolArray]:
    """Tells where (h, w) the ground, and then each part, is behind all that is seen within a footprint."""
    window = np.ones((2 * BURIED_PX + 1,) * 2, np.uint8)
    places = []
    for front, part in zip(fronts, (None, *draft.parts), strict=True):
        (x, y), (h, w) = ((0, 0), front.shape) if part is None else (part.offset_px, part.alpha.shape)
        own = draft.relief if part is None else part.relief
        nearest = cv2.erode(np.where(np.isnan(own), -_NOWHERE, own), window)
        covered = cv2.erode((front > _NOWHERE).astype(np.uint8), window, borderValue=1) > 0
        behind = np.zeros(front.shape, bool)
        behind[y : y + h, x : x + w] = nearest > cv2.dilate(front, window)[y : y + h, x : x + w]
        places.append(covered & behind)
    return places


def _is_at(surfels: Surfels, places: BoolArray, draft: Draft) -> BoolArray:
    """Tells which pixel-aligned surfels (n,) are of pixels marked (h, w)."""
    if not places.any():
        return np.zeros(len(surfels), bool)
    pixels = AnchoredView.expand(draft.camera, draft.frame).project(surfels.means)
    h, w = places.shape
    column, row = np.floor(pixels).astype(np.int64).T
    return places[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)]


def _closed(surfels: Surfels, hidden: BoolArray) -> Surfels:
    factor = np.where(hidden, np.float32(HIDDEN_SIGMA_PX / SURFEL_SIGMA_PX), np.float32(1))
    return surfels.with_(scales=surfels.scales * factor[:, None])


def flank_surfels(draft: Draft) -> list[Surfels]:
    """Lifts what is hidden of the objects; smaller at outlines, beside which it would look out."""
    if not draft.flanks:
        return []
    seen = seen_relief(draft)
    rim = cv2.dilate(seen, np.ones((3, 3), np.uint8)) - seen > RIM_STEP_PX
    return [_flank_surfels(flanks, rim, draft) for flanks in draft.flanks if len(flanks.alpha)]


def _flank_surfels(flanks: Flanks, rim: BoolArray, draft: Draft) -> Surfels:
    column, row = np.floor(flanks.corners[0, :, :2]).astype(np.int64).T
    surfels = lift_spanned(
        flanks.corners, flanks.color, opacity_of(flanks.alpha), draft.camera, HIDDEN_SIGMA_PX
    )
    factor = np.where(rim[row, column], np.float32(RIM_SIGMA_PX / HIDDEN_SIGMA_PX), np.float32(1))
    return surfels.with_(scales=surfels.scales * factor[:, None])


def _part_surfels(part: Part, draft: Draft) -> Surfels:
    return lift(
        part.color,
        part.relief,
        draft.camera,
        opacity=opacity_of(part.alpha),
        offset_px=part.offset_px,
    )


def opacity_of(coverage: FloatArray) -> FloatArray:
    """Returns the opacity of pixel-aligned surfels that together cover so much of a pixel."""
    steps = np.arange(-_REACH, _REACH + 1)
    x, y = np.meshgrid(steps, steps)
    footprint = np.exp(-0.5 * (x * x + y * y) / SURFEL_SIGMA_PX**2).ravel()
    opacity = np.linspace(0, SURFEL_OPACITY, 64)
    covered = 1 - np.prod(1 - opacity[:, None] * footprint, axis=1)
    covered[-1] = 1.0
    return np.interp(coverage, covered, opacity).astype(np.float32)


def settled(draft: Draft) -> Draft:
    """Returns a draft whose objects are in front of its registered surface.

    Where the surface was guessed, because coarser levels show the object there, it is what makes room.
    """
    relief, guessed = draft.relief, draft.extra.get("guessed")
    if guessed is not None and draft.parts:
        far = _farthest(draft)
        window = np.ones((_ROOM_PX, _ROOM_PX), np.uint8)
        room = cv2.dilate(far, window)
        behind = np.fmax(relief, room + np.float32(CONTACT_PX))
        relief = np.where(guessed & (far > _NOWHERE), behind, relief).astype(np.float32)
    return replace(draft, relief=relief, parts=tuple(_in_front(part, relief) for part in draft.parts))


def _farthest(draft: Draft) -> FloatArray:
    """Returns how far objects reach (h, w), flanks too."""
    far = np.full(draft.relief.shape, _NOWHERE, np.float32)
    for part in draft.parts:
        (x, y), (h, w) = part.offset_px, part.alpha.shape
        np.fmax(far[y : y + h, x : x + w], part.relief, out=far[y : y + h, x : x + w])
    for flank in draft.flanks:
        column, row = np.floor(flank.corners[0, :, :2]).astype(np.int64).T
        np.maximum.at(far, (row, column), flank.corners[0, :, 2].astype(np.float32))
    return far


def _in_front(part: Part, relief: FloatArray) -> Part:
    (x, y), (h, w) = part.offset_px, part.alpha.shape
    ground = relief[y : y + h, x : x + w]
    limit = np.where(np.isfinite(ground), ground - np.float32(CONTACT_PX), np.float32(np.inf))
    return replace(part, relief=np.minimum(part.relief, limit))


def seen_relief(draft: Draft) -> FloatArray:
    """Returns the relief (h, w) with the objects, where they cover half of a pixel."""
    covered, nearest = solid(draft.parts, draft.relief.shape, 0.5)
    return np.where(covered, nearest, draft.relief).astype(np.float32)


def covering_relief(draft: Draft) -> FloatArray:
    """Returns the relief (h, w) with the objects, where nothing is seen through them."""
    covered, nearest = solid(draft.parts, draft.relief.shape, OPAQUE)
    core = cv2.erode(covered.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1) > 0
    return np.where(core, nearest, draft.relief).astype(np.float32)


def out_of_sight(draft: Draft, relief: FloatArray) -> BoolArray:
    """Tells which points (h, w) of something behind objects no neighbouring camera sees past them.

    Args:
        draft: with its objects.
        relief: (h, w) native px, of what is behind.
    """
    front = covering_relief(draft)
    covered = (front < draft.relief).astype(np.uint8)
    if not covered.any():
        return np.zeros(relief.shape, bool)
    framed = cv2.copyMakeBorder(covered, 1, 1, 1, 1, cv2.BORDER_REPLICATE)  # an object goes on beyond it
    inside = cv2.distanceTransform(framed, cv2.DIST_L2, cv2.DIST_MASK_5)[1:-1, 1:-1]
    # A body keeps a view out that passes through it; a wing high above the ground does not.
    air = np.maximum(relief - np.fmax(_farthest(draft), front), 0)
    reach = np.minimum(ASIDE_SLOPE * (relief - front), DEEP_PX + ASIDE_SLOPE * air) + ASIDE_PX
    return np.asarray((covered > 0) & (inside > reach))


def in_sight(layer: Layer, draft: Draft) -> Layer:
    """Returns a layer less what is `out_of_sight`."""
    h, w = draft.relief.shape
    rows, columns = (np.arange(n) * layer.stride + layer.stride // 2 for n in layer.mask.shape)
    rows, columns = rows + layer.offset_px[1], columns + layer.offset_px[0]
    here = np.ix_(*(np.flatnonzero((at >= 0) & (at < n)) for at, n in ((rows, h), (columns, w))))
    relief = np.full((h, w), np.inf, np.float32)
    at = np.ix_(rows[here[0].ravel()], columns[here[1].ravel()])
    relief[at] = layer.relief[here]
    mask = layer.mask.copy()
    mask[here] &= ~out_of_sight(draft, relief)[at]
    return replace(layer, mask=mask)


def ground_target(draft: Draft) -> FloatArray:
    """Returns the picture of the ground (h, w, 3); what is buried is marked as `UNKNOWN`."""
    image = draft.image if draft.ground is None else draft.ground
    return np.where(_buried(draft, _fronts(draft))[0][..., None], UNKNOWN, image) if draft.parts else image


def part_layers(draft: Draft, least: float) -> tuple[Layer, ...]:
    """Returns the parts as layers for `warp_view`; what covers less, or is buried, is marked as `UNKNOWN`."""
    layers = []
    for part, cover in zip(draft.parts, _buried(draft, _fronts(draft))[1:], strict=True):
        (x, y), (h, w) = part.offset_px, part.alpha.shape
        known = (part.alpha >= least) & ~cover[y : y + h, x : x + w]
        mask = np.isfinite(part.relief) & (part.alpha >= 0.5 * (1 - least))
        color = np.where(known[..., None], part.color, UNKNOWN)
        layers.append(Layer(color, np.nan_to_num(part.relief), mask, part.offset_px))
    return tuple(layers)
