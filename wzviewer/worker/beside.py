"""What older siblings show in a new level's view: it will lie over them, and shall not wipe them out.

::

    parent  ────────────────────────  O, at the parent's resolution        ──► I' of the ground
    coarse siblings  ─ ─ ─ ─ ─ ─ ─ ─  in O, like ancestors                       │
    fine siblings    ▄▄▄▄▄▄▄▄▄▄▄▄▄▄▄  at the new level's resolution: `Overlay` ──► over it

Their pictures are taken as they are; the objects in them are drawn again by the editor, with a shape and a
back side, as those of ancestors are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene, modulation
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.draft import seen_part
from wzviewer.worker.rasterize import LevelPart, render

FINE = 2.0  # pixels of a new level in one of a sibling's: up to that its picture is taken as it is
SOLID = 0.98  # coverage by surfels of a surface without a gap
STRIDE = 2  # px: who is seen where, and how far it is, is told at half the resolution
STANDS_SHARE = 0.05  # of the width: what is so much nearer than the ground stands on it


@dataclass(frozen=True, eq=False)
class Overlay:
    """What fine siblings show at a new camera.

    Attributes:
        levels: the siblings, and what is in them; oldest first.
        color: (h, w, 3) float32, what is seen there now.
        cover: (h, w) float32 in [0, 1], the siblings' share of that.
        relief: (h, w) float32 native px of the new level; nan where less than half is covered.
    """

    levels: tuple[Level, ...]
    color: FloatArray
    cover: FloatArray
    relief: FloatArray

    def over(self, image: FloatArray) -> FloatArray:
        """Returns a picture (h, w, 3) with what the siblings show over it."""
        return np.clip(image + self.cover[..., None] * (self.color - image), 0, 1).astype(np.float32)

    def standing(self, relief: FloatArray) -> BoolArray:
        """Tells where (h, w) siblings show what is clearly in front of this relief (h, w) of the ground."""
        with np.errstate(invalid="ignore"):
            nearer = self.relief < relief - STANDS_SHARE * relief.shape[1]
        return np.asarray(np.isfinite(self.relief) & (nearer | np.isnan(relief)))


def split(beside: Sequence[Level], camera: Camera) -> tuple[list[Level], list[Level]]:
    """Returns those levels that are too coarse for their pictures to be taken as they are, and the others."""
    coarse = [level for level in beside if level.frame.unit > FINE * level.frame.unit_seen_by(camera)]
    return coarse, [level for level in beside if level not in coarse]


def parts_among(
    path: Sequence[Level],
    beside: Sequence[Level],
    camera: Camera,
    sharp: Camera,
) -> list[tuple[Level, LevelPart]]:
    """The surfels of a tree that a camera sees, with the weights that they have where all have faded in.

    Args:
        path: the levels from the root to the parent.
        beside: others, each with those between it and the parent.
        camera: the view.
        sharp: the same view at the resolution of the new level.
    """
    levels = sorted([*path, *beside], key=lambda level: level.index)
    scene = _scene_of(levels)
    closer = max(1.0, *(level.frame.unit_seen_by(sharp) / level.frame.unit for level in beside))
    finer = closer * sharp.focal_px / camera.focal_px
    parts = [(level, seen_part(level, modulation(scene, k), camera, finer)) for k, level in enumerate(levels)]
    return [(level, part) for level, part in parts if len(part.surfels)]


def overlay_of(
    path: Sequence[Level], beside: Sequence[Level], camera: Camera, frame: LevelFrame
) -> Overlay | None:
    """Renders what fine siblings show at a new level's camera; None where they show nothing.

    Args:
        path: the levels from the root to the parent.
        beside: siblings, coarse ones too.
        camera: of the new level.
        frame: of the new level.
    """
    fine = split(beside, camera)[1]
    if not fine:
        return None
    parts = parts_among(path, beside, camera, camera)
    small = camera.resampled(*(max(side // STRIDE, 1) for side in (camera.width, camera.height)))
    anchor = (float(camera.to_camera(frame.origin)[2]), frame.unit)
    marked = render([_marked(part, level in fine) for level, part in parts], small, depth_anchor=anchor)
    share = np.clip(marked.color[..., 0] / np.float32(SOLID), 0, 1)
    if not (share > 0.5).any():
        return None
    shown = render([part for _, part in parts], camera, depth=False)
    size = (camera.width, camera.height)
    cover = cv2.resize(share, size, interpolation=cv2.INTER_LINEAR)
    relief = np.where(share > 0.5, marked.relief, np.float32(np.nan))
    relief = cv2.resize(relief, size, interpolation=cv2.INTER_NEAREST)
    color = np.asarray(shown.color / np.maximum(shown.coverage, np.float32(0.5))[..., None], np.float32)
    return Overlay(tuple(fine), color, cover, relief)


def _marked(part: LevelPart, is_wanted: bool) -> LevelPart:
    """Returns a part all white or all black."""
    colors = np.full_like(part.surfels.colors, float(is_wanted))
    return replace(part, surfels=part.surfels.with_(colors=colors))


def _scene_of(levels: Sequence[Level]) -> Scene:
    """Returns levels as a scene of their own, in their order."""
    places = {level.index: k for k, level in enumerate(levels)}
    scene = Scene()
    for k, level in enumerate(levels):
        scene.append(replace(level, index=k, parent=None if level.parent is None else places[level.parent]))
    return scene


def grown(mask: BoolArray, reach_px: int) -> BoolArray:
    """Returns a mask (h, w) wider by some pixels."""
    return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((2 * reach_px + 1,) * 2, np.uint8)) > 0)
