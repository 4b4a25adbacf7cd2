"""The scene: an append-only log of levels E_0 .. E_n that form a tree.

Viewer, worker and file are replicas that replay the same log::

    append(level)     a new level, at first perhaps a preview
    replace(level)    only while that level is still being made
    commit(index)     its bytes never change again
    hide(index)       undo: the level and its descendants stay, unseen
    show(index)       redo
    set_mark(index)   the same, and names (`core.marks`): said about a level, not part of it

Nothing of an older level changes when a child is appended: what Eq. 3 needs of the children is
computed from their cameras (`modulation`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import MAX_LEVELS
from wzviewer.core.marks import UNMARKED, Mark
from wzviewer.core.opacity import Cover, Modulation, ramp_start, stored_coverage
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import ByteArray, DoubleArray, FloatArray

PHOTO = "photo"  # map of E_0: (H, W, 3) uint8, the same picture with more pixels
FINER = 0.7  # as large as a pixel of the other level: clearly finer


@dataclass(frozen=True)
class StageRecord:
    """Who made a stage of a level, and how long it took."""

    backend: str
    seconds: float


@dataclass(frozen=True, eq=False)
class Level:
    """E_i with all that was used to make it.

    Attributes:
        index: position in the log.
        parent: index of the parent level, or None for E_0.
        camera: C_i.
        frame: the local frame of the surfels.
        surfels: E_i.
        image: I_i, (h, w, 3) uint8 sRGB.
        relief: (h, w) float32, (D_i - depth of the anchor) / unit; nan where undefined.
        prompt: U_i, perhaps empty.
        seed: of the generators.
        stages: provenance by stage name.
        maps: further images aligned with ``image`` (uint8 or float32), such as material labels;
            E_0 has `PHOTO` where the photograph is finer than its working image.
        notes: JSON-able facts of the synthesizer, such as the placements of inserted objects.
    """

    index: int
    parent: int | None
    camera: Camera
    frame: LevelFrame
    surfels: Surfels
    image: ByteArray
    relief: FloatArray
    prompt: str = ""
    seed: int = 0
    stages: dict[str, StageRecord] = field(default_factory=dict)
    maps: dict[str, NDArray[Any]] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)

    @property
    def anchor_depth(self) -> float:
        """Depth of the anchor from C_i, world units."""
        return float(self.camera.to_camera(self.frame.origin)[2])

    @property
    def depth(self) -> DoubleArray:
        """D_i, (h, w) float64, world units along +z of C_i; nan where undefined."""
        return self.anchor_depth + self.frame.unit * self.relief.astype(np.float64)

    def with_surfels(self, surfels: Surfels) -> "Level":
        """Returns the level with other surfels."""
        return replace(self, surfels=surfels)


class Scene:
    """The tree of levels; see the module docstring for its log."""

    def __init__(self) -> None:
        self._levels: list[Level] = []
        self._committed: list[bool] = []
        self._marks: dict[int, Mark] = {}
        self._hidden: set[int] = set()
        self.unknown_fields: dict[str, Any] = {}  # of the file it came from; kept when saved
        self.revision = 0  # grows with every change, so that a renderer knows when to look

    def copy(self) -> "Scene":
        """Returns a scene of the same levels that does not follow what becomes of this one."""
        other = Scene()
        other._levels, other._committed = list(self._levels), list(self._committed)
        other._marks, other._hidden = dict(self._marks), set(self._hidden)
        other.unknown_fields, other.revision = dict(self.unknown_fields), self.revision
        return other

    @classmethod
    def load(cls, path: str | Path) -> "Scene":
        """Reads a scene file; see `core.files.load_scene`."""
        from wzviewer.core.files import load_scene

        return load_scene(Path(path))

    def save(self, path: str | Path) -> None:
        """Writes the finished levels; see `core.files.save_scene`."""
        from wzviewer.core.files import save_scene

        save_scene(self, Path(path))

    def __len__(self) -> int:
        return len(self._levels)

    def __iter__(self) -> Iterator[Level]:
        return iter(self._levels)

    def __getitem__(self, index: int) -> Level:
        return self._levels[index]

    def append(self, level: Level) -> None:
        """Adds a level at the end of the log.

        Raises:
            ValueError: when its index is not the next one, its parent is unknown, or the log is full.
        """
        expected = len(self._levels)
        if level.index != expected or len(self) >= MAX_LEVELS:
            raise ValueError(f"level index is {level.index}, expected {expected} (at most {MAX_LEVELS})")
        if (level.parent is None) != (level.index == 0) or (level.parent or 0) >= max(expected, 1):
            raise ValueError(f"parent of level {level.index} is {level.parent}")
        self._levels.append(level)
        self._committed.append(False)
        self.revision += 1

    def replace(self, level: Level) -> None:
        """Exchanges a level that is still being made.

        Raises:
            ValueError: when the level is finished: its bytes never change.
        """
        if self._committed[level.index]:
            raise ValueError(f"level {level.index} is finished")
        self._levels[level.index] = level
        self.revision += 1

    def commit(self, index: int) -> None:
        """Declares a level finished."""
        self._committed[index] = True

    def abort(self, index: int) -> None:
        """Drops the last level, which was never committed.

        Raises:
            ValueError: when it is finished or not the last.
        """
        if self._committed[index] or index != len(self) - 1:
            raise ValueError(f"level {index} cannot be dropped")
        self._levels.pop()
        self._committed.pop()
        self._hidden.discard(index)
        self._marks.pop(index, None)
        self.revision += 1

    def is_committed(self, index: int) -> bool:
        """Whether the level is finished."""
        return self._committed[index]

    def hide(self, index: int) -> None:
        """Undoes a level: it and its descendants are no longer seen."""
        self.set_mark(index, replace(self.mark(index), sight="hidden"))

    def show(self, index: int) -> None:
        """Redoes a hidden level."""
        self.set_mark(index, replace(self.mark(index), sight="shown"))

    def mark(self, index: int) -> Mark:
        """What is said about a level."""
        return self._marks.get(index, UNMARKED)

    def set_mark(self, index: int, mark: Mark) -> None:
        """Says something else about a level."""
        self._marks.pop(index, None)
        if mark != UNMARKED:
            self._marks[index] = mark
        (self._hidden.discard if mark.sight == "shown" else self._hidden.add)(index)
        self.revision += 1

    @property
    def marks(self) -> dict[int, Mark]:
        """All that is said about levels."""
        return dict(self._marks)

    @property
    def hidden(self) -> frozenset[int]:
        """Indices hidden by themselves (descendants not listed)."""
        return frozenset(self._hidden)

    def is_visible(self, index: int) -> bool:
        """Whether neither the level nor an ancestor is hidden."""
        return not any(i in self._hidden for i in self.path(index))

    def visible(self) -> list[int]:
        """Indices of the levels that are drawn."""
        return [level.index for level in self if self.is_visible(level.index)]

    def path(self, index: int) -> list[int]:
        """Indices from the root to a level, both included."""
        chain = [index]
        while (parent := self._levels[chain[-1]].parent) is not None:
            chain.append(parent)
        return chain[::-1]

    def children(self, index: int) -> list[int]:
        """Indices of the visible children, oldest first."""
        return [lv.index for lv in self if lv.parent == index and self.is_visible(lv.index)]

    def magnification(self, index: int) -> float:
        """Focal length of a level over that of E_0."""
        return self[index].camera.focal_px / self[0].camera.focal_px

    @property
    def num_surfels(self) -> int:
        """Surfels of all levels, hidden ones included."""
        return sum(len(level.surfels) for level in self)


def siblings_before(scene: Scene, index: int, parent: int) -> list[int]:
    """Visible siblings of a visible level that take their share of what they overlap before it does.

    The newer first.  But plain detail, which nobody put anything into, stays behind older siblings that are
    finer: it would wipe out what was put there, as its picture holds nothing but the parent.  Every level is
    put into the order once, so that it stays an order, and the weights at a point sum to 1.
    """
    order = order_of(scene, parent)
    return sorted(order[: order.index(index)])


def order_of(scene: Scene, parent: int) -> list[int]:
    """Visible children of a level, in the order in which they take their shares; see `siblings_before`."""
    order: list[int] = []
    for sibling in scene.children(parent):
        level = scene[sibling]
        is_plain = not level.prompt and not level.notes.get("cutout")
        order.insert(num_before(scene, order, is_plain, level.frame.unit), sibling)
    return order


def num_before(scene: Scene, order: Sequence[int], is_plain: bool, unit: float) -> int:
    """Returns how many siblings come before one that is added to them; see `siblings_before`.

    Args:
        scene: that they are in.
        order: of the older siblings, what comes first first.
        is_plain: whether nobody put anything into the new one.
        unit: of its frame.
    """
    finer = [i for i in order if is_plain and scene[i].frame.unit < FINER * unit]
    return order.index(finer[-1]) + 1 if finer else 0


def modulation(scene: Scene, index: int) -> Modulation:
    """Returns what Eq. 3 needs for one visible level: its parent and everything that covers it."""
    level = scene[index]
    if level.parent is None:
        parent_rows = None
    else:
        start = ramp_start(scene[level.parent].camera, level.camera, level.frame)
        parent_rows = AnchoredView.expand(start, level.frame).rows[2]
    covers = [_cover(scene, child, level.frame) for child in scene.children(index)]
    for ancestor in scene.path(index)[1:]:
        parent = scene[ancestor].parent
        assert parent is not None  # the root is not in path[1:]
        before = siblings_before(scene, ancestor, parent)
        covers += [_cover(scene, s, level.frame) for s in before]
    return Modulation(parent_rows, tuple(covers))


def _cover(scene: Scene, index: int, frame: LevelFrame) -> Cover:
    level, parent = scene[index], scene[index].parent
    assert parent is not None  # only children cover
    start = ramp_start(scene[parent].camera, level.camera, level.frame)
    return Cover.expand(level.camera, start, frame)


def coverage_for(
    scene: Scene, parent: int | None, camera: Camera, frame: LevelFrame, means: FloatArray
) -> FloatArray:
    """Product of m of a new level and its ancestors at its surfels, (n,); 1 for the root."""
    if parent is None:
        return np.ones(len(means), np.float32)
    ancestors = [scene[i].camera for i in scene.path(parent)[1:]]
    return stored_coverage(means, frame, [*ancestors, camera])
