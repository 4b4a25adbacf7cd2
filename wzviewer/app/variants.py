"""Variants: levels of the same parent, camera and prompt, made with other seeds; one of them is shown.

Nothing says so in the scene: siblings that were asked for alike are variants of each other, also in a file
that was opened again.
"""

from wzviewer.core.scene import Level, Scene

CUTOUT = "cutout"  # in the notes of a level that a picture was put into: its seed changes next to nothing
SEED_STRIDE = 1009  # beyond the number of levels, so that no variant has the seed of another level


def are_variants(one: Level, other: Level) -> bool:
    """Whether two levels were asked for alike."""
    if one.parent is None or one.parent != other.parent or one.prompt != other.prompt:
        return False
    return one.camera.key == other.camera.key


def group_of(scene: Scene, index: int) -> tuple[int, ...]:
    """Returns the finished variants of a level that were not deleted, itself included, oldest first."""
    one = scene[index]
    found = [lv.index for lv in scene if are_variants(one, lv) and scene.is_committed(lv.index)]
    return tuple(i for i in found if scene.mark(i).sight != "removed")


def next_seed(scene: Scene, like: int) -> int:
    """Returns the seed of the next variant: it follows from the first one's and their number."""
    group = [level for level in scene if are_variants(scene[like], level)]
    return group[0].seed + SEED_STRIDE * len(group)


def can_vary(scene: Scene, index: int) -> bool:
    """Whether another of a level can be made."""
    if not 0 < index < len(scene) or not scene.is_committed(index):
        return False
    parent = scene[index].parent
    return parent is not None and scene.is_visible(parent) and CUTOUT not in scene[index].notes


def newest(scene: Scene) -> int | None:
    """Returns the newest finished level that is seen, the photo apart; None when there is none."""
    return max((i for i in scene.visible() if i > 0 and scene.is_committed(i)), default=None)
