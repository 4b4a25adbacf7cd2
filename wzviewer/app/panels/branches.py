"""The rows of the tree of levels: which levels are listed, how deep, and the lines that join them."""

from dataclasses import dataclass

from wzviewer.core.scene import Scene


@dataclass(frozen=True)
class Row:
    """A row of the tree.

    Attributes:
        index: of the level.
        depth: in the tree, 0 for the photo.
        is_seen: whether the level is drawn; hidden ones are greyed.
        passing: depths at which a line passes by, to a sibling further below.
        is_last: whether no sibling follows.
        variants: how many variants there are of it, itself included.
        number: which of them it is, from 1.
    """

    index: int
    depth: int
    is_seen: bool = True
    passing: frozenset[int] = frozenset()
    is_last: bool = True
    variants: int = 1
    number: int = 1


def tree_rows(scene: Scene) -> list[Row]:
    """Returns the rows, children below their parent; of variants one, removed levels not at all."""
    children: dict[int | None, list[int]] = {}
    counts: dict[int, tuple[int, int]] = {}
    for group in _groups(scene):
        index = next((i for i in group if scene.mark(i).sight == "shown"), group[-1])
        counts[index] = (len(group), group.index(index) + 1)
        children.setdefault(scene[index].parent, []).append(index)
    rows: list[Row] = []
    waiting = [(i, 0, True, frozenset[int](), True) for i in children.get(None, [])]
    while waiting:
        index, depth, is_seen, passing, is_last = waiting.pop()
        is_seen = is_seen and scene.mark(index).sight == "shown"
        rows.append(Row(index, depth, is_seen, passing, is_last, *counts[index]))
        below = sorted(children.get(index, []))
        on = passing if is_last else passing | {depth}
        waiting += [(i, depth + 1, is_seen, on, i == below[-1]) for i in reversed(below)]
    return rows


def _groups(scene: Scene) -> list[list[int]]:
    """Levels that were not removed, variants together, oldest first."""
    groups: dict[object, list[int]] = {}
    for level in scene:
        if scene.mark(level.index).sight == "removed":
            continue
        alike = (level.parent, level.prompt, level.camera.key)
        is_alone = level.parent is None or not scene.is_committed(level.index)
        groups.setdefault(level.index if is_alone else alike, []).append(level.index)
    return list(groups.values())
