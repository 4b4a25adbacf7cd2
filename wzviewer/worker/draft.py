"""A level in the making, as it passes from stage to stage of `synthesis`."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import WEIGHT_MIN
from wzviewer.core.opacity import Cover, Modulation, ramp_start, stored_coverage, weights
from wzviewer.core.reference import Blend, setback
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.in_view import surfels_in_view
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part
from wzviewer.worker.rasterize import LevelPart


@dataclass(frozen=True, eq=False)
class Draft:
    """What is known of a level so far.

    Attributes:
        camera: C_i.
        frame: its local frame.
        path: the levels from the root to the parent; empty for E_0.
        image: I_i, (h, w, 3) float32 in [0, 1].
        relief: D_i in native pixels about the anchor, (h, w) float32; nan where undefined.
        sky: (h, w) bool.
        layers: background layers of stage 4.
        context: S, the description that guided stage 1, in the super-resolver's own type.
        extra: intermediate results that a later stage needs, by name.
        notes: JSON-able facts kept with the level.
        hidden: surfels of coarser levels behind what is seen, in this frame; see `worker.inherited`.
        ground: (h, w, 3) float32, the image without the objects; None if there are none.
        parts: of the objects, which stand in front of `relief`; see `worker.standing`.
        flanks: of the objects.
    """

    camera: Camera
    frame: LevelFrame
    path: Sequence[Level]
    image: FloatArray
    relief: FloatArray
    sky: BoolArray
    layers: tuple[Any, ...] = ()
    context: Any = None
    extra: dict[str, Any] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)
    hidden: Surfels = field(default_factory=Surfels.empty)
    ground: FloatArray | None = None
    parts: tuple[Part, ...] = ()
    flanks: tuple[Flanks, ...] = ()


def path_modulation(path: Sequence[Level], position: int) -> Modulation:
    """Eq. 3 along a chain of levels: the parent before, the child after."""
    level = path[position]
    parent_rows = None
    if position > 0:
        start = ramp_start(path[position - 1].camera, level.camera, level.frame)
        parent_rows = AnchoredView.expand(start, level.frame).rows[2]
    covers: tuple[Cover, ...] = ()
    if position + 1 < len(path):
        child = path[position + 1]
        start = ramp_start(level.camera, child.camera, child.frame)
        covers = (Cover.expand(child.camera, start, level.frame),)
    return Modulation(parent_rows, covers)


def visible_parts(path: Sequence[Level], camera: Camera, blend: Blend = "transmittance") -> list[LevelPart]:
    """The surfels of a chain that a camera sees, with their Eq. 3 weights for a blend."""
    parts = (_visible_part(path, position, camera, blend) for position in range(len(path)))
    return [part for part in parts if len(part.surfels)]


def _visible_part(path: Sequence[Level], position: int, camera: Camera, blend: Blend) -> LevelPart:
    return seen_part(path[position], path_modulation(path, position), camera, blend=blend)


def seen_part(
    level: Level,
    modulation: Modulation,
    camera: Camera,
    finer: float = 1.0,
    blend: Blend = "transmittance",
) -> LevelPart:
    """The surfels of a level that a camera sees, with their Eq. 3 weights for a blend.

    Args:
        level: of a scene.
        modulation: of the level.
        camera: the view.
        finer: weights are those at so many times the camera's resolution.
        blend: see `rasterize.render`.
    """
    view = AnchoredView.expand(camera, level.frame)
    near, surfels = surfels_in_view(level.surfels, view, camera), level.surfels
    if finer != 1.0:
        view, modulation = view.finer(finer), replace(modulation, cell_px=1.0 / finer)
    arrays = (surfels.means[near], surfels.native_scales[near], surfels.coverage[near])
    weight = weights(*arrays, view, modulation, blend == "transmittance")
    keep = weight > WEIGHT_MIN
    frame = level.frame
    back = setback(level.camera)
    return LevelPart(surfels.take(near[keep]), frame.origin, frame.axes, frame.unit, weight[keep], back)


def coverage_of(path: Sequence[Level], camera: Camera, frame: LevelFrame, means: FloatArray) -> FloatArray:
    """Product of m of a new level and its ancestors at its surfels, (n,); 1 for the root."""
    if not path:
        return np.ones(len(means), np.float32)
    return stored_coverage(means, frame, [*(level.camera for level in path[1:]), camera])
