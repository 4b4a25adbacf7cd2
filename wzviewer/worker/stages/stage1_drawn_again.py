"""Objects of older levels in a new one: which of them it draws again, where they are in it, and how.

An object is kept by how it was placed, in the picture of the level that it was put into.  A level that lies
over siblings draws theirs again as well, and keeps them with the way from their pictures to its own, so that
levels below it find them.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.beside import grown
from wzviewer.worker.draft import Draft
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.models.builtin.objects.editor import EditResult, Placement, Support
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part
from wzviewer.worker.stages.stage1_whole_pixels import is_zoom

PLACEMENTS, BESIDE = "placements", "beside"  # notes of a level: its own objects, and those of its siblings
BLURRED_PX = 1.5  # of the coarser level: around an object its depth is a mixture
LEAST_GROUND = 0.01  # of a view: with less of it around an object nothing can be continued
HIDDEN_SHARE = 0.15  # of an object's length: by so much nearer, what a sibling shows is not the object
SPECK_PX, RIM_PX = 3, 2  # of what is hidden: smaller is noise of the depth; its soft outline
Mapping = tuple[float, float, float]  # (x0, y0, factor): a pixel here is (a pixel there - (x0, y0)) * factor
Check = Callable[[], None]


@dataclass(frozen=True, eq=False)
class Group:
    """Objects that were put into one picture.

    Attributes:
        records: of their placements.
        mapping: from that picture to the new one.
        factor: how much finer the new one is than what shows them to it.
        is_ancestral: whether an ancestor of the new level shows them.
        is_overlaid: whether they are in the overlay of its observation.
    """

    records: tuple[dict[str, Any], ...]
    mapping: Mapping
    factor: float
    is_ancestral: bool = False
    is_overlaid: bool = False

    @property
    def placements(self) -> tuple[Placement, ...]:
        """The objects."""
        return tuple(Placement.from_dict(record) for record in self.records)

    @property
    def length_px(self) -> float:
        """Of the longest of them, in the new picture."""
        return self.mapping[2] * max(placement.pose.size_px for placement in self.placements)

    def to_dict(self) -> dict[str, Any]:
        """Returns a JSON-able form, for the notes of the new level."""
        return {"mapping": list(self.mapping), PLACEMENTS: list(self.records)}


def drawn_again(draft: Draft, models: Synthesizer, support: Support, seed: int, check: Check) -> Draft:
    """Returns a draft with the objects that ancestors and siblings show, finer; the ancestors' first.

    Args:
        draft: I'.
        models: the backends.
        support: what is seen, objects included.
        seed: of the grain.
        check: called often; raises to cancel.
    """
    before, hidden = draft, _Hidden.nothing(draft)
    kept: list[dict[str, Any]] = []
    for group in groups_in_view(draft):
        shared = (group.placements, group.mapping, draft.image, support, seed)
        result = models.editor.continue_into(
            *shared, check=check, parent_factor=group.factor, ground=draft.ground
        )
        if result is None:
            continue
        if group.is_overlaid:
            hidden = hidden.with_objects(result, group.length_px)
            draft = with_objects(_before_siblings(draft, result), result)
        else:
            draft = with_objects(_behind(draft, result, group.factor), result)
            before = draft
        kept += [] if group.is_ancestral else [group.to_dict()]
    if kept:
        draft = replace(hidden.cut(draft, before), notes={**draft.notes, BESIDE: kept})
    return _with_standing(draft)


def groups_in_view(draft: Draft) -> list[Group]:
    """Returns the objects of ancestors, then those of siblings, each object once.

    From another place a sibling's objects are not where its picture has them: they stay as it shows them.
    """
    seen = draft.extra["observation"]
    overlaid = seen.overlay.levels if seen.overlay is not None else ()
    parent, found = draft.path[-1], []
    known: set[str] = set()
    for level in (*draft.path, *seen.joined, *overlaid):
        is_ancestral = level in draft.path
        if not is_ancestral and not is_zoom(level.camera, draft.camera):
            continue
        shown_by = parent if is_ancestral else level
        factor = draft.camera.focal_px / shown_by.camera.focal_px
        factor = factor if is_ancestral else max(factor, 1.0)
        for records, mapping in _kept(level, draft.camera):
            fresh = tuple(record for record in records if json.dumps(record) not in known)
            known.update(map(json.dumps, fresh))
            if fresh:
                found.append(Group(fresh, mapping, factor, is_ancestral, level in overlaid))
    return found


def _kept(level: Level, camera: Camera) -> Iterator[tuple[Sequence[dict[str, Any]], Mapping]]:
    """The records of a level's objects, and of those that it drew again, each with the way to a picture."""
    own = mapping_to(level.camera, camera)
    for group in level.notes.get(BESIDE, ()):
        x0, y0, factor = group["mapping"]
        yield group[PLACEMENTS], (x0 + own[0] / factor, y0 + own[1] / factor, factor * own[2])
    yield level.notes.get(PLACEMENTS, ()), own


def mapping_to(older: Camera, camera: Camera) -> Mapping:
    """Returns the way from an older picture to a new one, both taken from the same place."""
    factor = camera.focal_px / older.focal_px
    return older.cx - camera.cx / factor, older.cy - camera.cy / factor, factor


def with_objects(draft: Draft, result: EditResult) -> Draft:
    """Takes the edited image, with its objects apart from what they stand on."""
    parts, flanks = (*draft.parts, *result.parts), (*draft.flanks, *result.flanks)
    return replace(draft, image=result.image, ground=result.ground, parts=parts, flanks=flanks)


def _behind(draft: Draft, result: EditResult, factor: float) -> Draft:
    """Forgets the depth that coarser levels show where they show objects that are drawn again."""
    shown = _shown(result, factor)
    relief = np.where(shown, np.float32(np.nan), draft.relief)
    if np.isfinite(relief).mean() < LEAST_GROUND:
        farthest = np.nanmax(draft.relief) if np.isfinite(draft.relief).any() else 0.0
        relief = np.full_like(relief, farthest)
    guessed = draft.extra.get("guessed", np.zeros_like(shown)) | shown
    return replace(draft, relief=relief, extra={**draft.extra, "guessed": guessed})


def _before_siblings(draft: Draft, result: EditResult) -> Draft:
    """Takes the ground as it was before siblings were laid over it, where their objects are drawn again."""
    bare, shown = draft.extra["bare"], _shown(result, 1.0)
    relief, sky = np.where(shown, bare.relief, draft.relief), np.where(shown, bare.sky, draft.sky)
    unshaded = np.where(shown[..., None], bare.image, draft.extra["unshaded"])
    extra = {**draft.extra, "unshaded": unshaded, "stands": draft.extra["stands"] & ~shown}
    return replace(draft, relief=relief, sky=sky, extra=extra)


def _with_standing(draft: Draft) -> Draft:
    """Takes what siblings show in front of the ground, and nobody draws again, apart from the ground."""
    stands = draft.extra.get("stands")
    stands = None if stands is None else cv2.erode(stands.astype(np.uint8), np.ones((SPECK_PX,) * 2)) > 0
    if stands is None or not stands.any():
        return draft
    bare, image = draft.extra["bare"], draft.image if draft.ground is None else draft.ground
    stands = grown(stands, SPECK_PX // 2)
    behind = grown(draft.extra["stands"], RIM_PX)
    far = np.where(stands, draft.extra["observation"].overlay.relief, np.float32(np.inf))
    near = cv2.erode(far, np.ones((2 * RIM_PX + 1,) * 2, np.uint8))
    relief = np.where(stands, far, np.where(np.isinf(near), np.float32(np.nan), near))
    alpha = cv2.blur(grown(stands, 1).astype(np.float32), (3, 3))
    unshaded = np.where(behind[..., None], bare.image, draft.extra["unshaded"])
    return replace(
        draft,
        ground=np.where(behind[..., None], bare.image, image),
        relief=np.where(behind, bare.relief, draft.relief),
        sky=np.where(behind, bare.sky, draft.sky),
        parts=(_cropped(draft.image, alpha, relief), *draft.parts),
        extra={**draft.extra, "unshaded": unshaded},
    )


def _cropped(color: FloatArray, alpha: FloatArray, relief: FloatArray) -> Part:
    """Returns a part cut to the pixels (h, w) that it covers."""
    rows, columns = np.flatnonzero((alpha > 0).any(1)), np.flatnonzero((alpha > 0).any(0))
    cut = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    shown = np.where(alpha > 0, relief, np.float32(np.nan))
    return Part(color[cut], alpha[cut], shown[cut], (int(columns[0]), int(rows[0])))


def _shown(result: EditResult, factor: float) -> BoolArray:
    """Where (h, w) a level so many times as coarse shows objects, blurred as it is."""
    return grown(result.alpha > 0, round(BLURRED_PX * factor))


def covered_share(draft: Draft) -> FloatArray | None:
    """Returns the coverage (h, w) by the objects of a draft; None if it has none."""
    if not draft.parts:
        return None
    through = np.ones(draft.relief.shape, np.float32)
    for part in draft.parts:
        (x, y), (h, w) = part.offset_px, part.alpha.shape
        through[y : y + h, x : x + w] *= 1 - part.alpha
    return 1 - through


@dataclass(frozen=True, eq=False)
class _Hidden:
    """Finds what siblings do not show of their objects: there, their ground hides them.

    Attributes:
        nearest: (h, w) relief of the objects; inf where there are none.
        slack: (h, w) native px, by how much nearer their ground has to be.
    """

    nearest: FloatArray
    slack: FloatArray

    @classmethod
    def nothing(cls, draft: Draft) -> "_Hidden":
        """Returns the finder for no objects."""
        shape = draft.relief.shape
        return cls(np.full(shape, np.inf, np.float32), np.zeros(shape, np.float32))

    def with_objects(self, result: EditResult, length_px: float) -> "_Hidden":
        """Returns the finder for more objects."""
        nearer = result.object_mask & ~(result.object_relief >= self.nearest)
        nearest = np.where(nearer, result.object_relief, self.nearest)
        return _Hidden(nearest, np.where(nearer, np.float32(HIDDEN_SHARE * length_px), self.slack))

    def cut(self, draft: Draft, before: Draft) -> Draft:
        """Returns a draft whose objects end where siblings show something else; that is as it was before."""
        overlay = draft.extra["observation"].overlay
        if overlay is None:
            return draft
        with np.errstate(invalid="ignore"):
            nearer = np.isfinite(self.nearest) & (overlay.relief < self.nearest - self.slack)
        window = np.ones((SPECK_PX, SPECK_PX), np.uint8)
        opened = cv2.morphologyEx(nearer.astype(np.uint8), cv2.MORPH_OPEN, window) > 0
        cut = grown(opened, RIM_PX) & (nearer | np.isinf(self.nearest))
        if not cut.any():
            return draft
        ground = before.image if before.ground is None else before.ground
        return replace(
            draft,
            image=np.where(cut[..., None], before.image, draft.image),
            ground=None if draft.ground is None else np.where(cut[..., None], ground, draft.ground),
            parts=(*before.parts, *(_cut_part(part, cut) for part in draft.parts[len(before.parts) :])),
            flanks=(*before.flanks, *(_cut_flanks(f, cut) for f in draft.flanks[len(before.flanks) :])),
        )


def _cut_part(part: Part, cut: BoolArray) -> Part:
    (x, y), (h, w) = part.offset_px, part.alpha.shape
    here = cut[y : y + h, x : x + w]
    relief = np.where(here, np.float32(np.nan), part.relief)
    return replace(part, alpha=np.where(here, np.float32(0), part.alpha), relief=relief)


def _cut_flanks(flanks: Flanks, cut: BoolArray) -> Flanks:
    column, row = np.floor(flanks.corners[0, :, :2]).astype(np.int64).T
    keep = ~cut[row, column]
    return Flanks(flanks.corners[:, keep], flanks.color[keep], flanks.alpha[keep])
