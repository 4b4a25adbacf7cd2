"""Which levels a new one will lie over although it does not refine them: older siblings, and what is in them.

A new level takes its share before its older siblings (`core.opacity`), so that where their frames overlap it
hides what they show.  What they show is therefore part of what is there (line 12 of Algorithm 1), and is
handed to whoever makes the new level.
"""

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.foreground import depth_on_relief
from wzviewer.core.scene import Level, Scene, num_before, order_of
from wzviewer.core.types import BoolArray, DoubleArray

MIDWAY_OCTAVES = 0.15  # so much coarser than midway to its parent is a level still seen
FADED_IN = 1.05  # of a level's pixel: seen by so much smaller ones, nothing shows through it
SURELY = 0.7  # of the guessed unit: a level that is kept for nothing does no harm
PLACES = (np.linspace(0.02, 0.98, 9), np.linspace(0.02, 0.98, 13))  # rows and columns of a picture


def levels_beside(
    scene: Scene, parent: int, camera: Camera, prompt: str = "", cutout: bool = False
) -> list[int]:
    """Returns the visible levels that a new child will hide, though they show something in its view.

    Those that come before it (`siblings_before`) go on being seen, and need not be kept.  Nor does one that
    was asked for alike: the new one is another version of it.

    Args:
        scene: all levels.
        parent: of the new level.
        camera: of the new level.
        prompt: of the new level.
        cutout: whether a picture is put into it.

    Returns:
        Indices in ascending order; with a level also those between it and the parent.
    """
    order = order_of(scene, parent)
    unit = _unit_in_middle(scene, parent, camera)
    found = order[num_before(scene, order, not prompt and not cutout, SURELY * unit) :]
    found = [i for i in found if scene.is_committed(i) and not _is_version(scene[i], camera, prompt)]
    beside, queue = [], _not_hidden(scene, found, camera)
    while queue:
        beside.append(queue.pop())
        queue += [i for i in scene.children(beside[-1]) if _is_seen(scene, i, camera)]
    return sorted(beside)


def _is_version(level: Level, camera: Camera, prompt: str) -> bool:
    return level.camera.key == camera.key and level.prompt == prompt


def _not_hidden(scene: Scene, order: list[int], camera: Camera) -> list[int]:
    """Returns those siblings that show something in a camera's picture, what comes first first.

    Whoever walks over a leaf leaves many behind, and only the last of them are seen.
    """
    free = np.ones(PLACES[0].size * PLACES[1].size, bool)
    found = []
    for level in (scene[index] for index in order if _is_seen(scene, index, camera)):
        places = _places(camera, float(camera.to_camera(level.frame.origin)[2]))
        shown = _inside(places, level.camera)
        if not shown.any() or (shown & free).any():  # a small one may lie between the places
            found.append(level.index)
            if level.frame.unit_seen_by(camera) < FADED_IN * level.frame.unit:
                free &= ~shown
    return found


def _unit_in_middle(scene: Scene, parent: int, camera: Camera) -> float:
    """World length of a camera's pixel where the middle of its picture lies, about that of the new frame."""
    depth = depth_on_relief(scene, camera, camera.width / 2, camera.height / 2)
    return scene[parent].frame.unit_seen_by(camera) if depth is None else camera.pixel_scale(depth)


def _is_seen(scene: Scene, index: int, camera: Camera) -> bool:
    """Whether a camera is so close that a level has faded in by half, and they look at the same place."""
    level, above = scene[index], scene[scene[index].parent or 0]
    unit = level.frame.unit_seen_by(camera)
    if not unit > 0:
        return False
    midway = 0.5 * np.log2(level.frame.unit * above.frame.unit)
    return bool(np.log2(unit) <= midway + MIDWAY_OCTAVES) and _overlap(level, camera)


def _overlap(level: Level, camera: Camera) -> bool:
    depth = float(camera.to_camera(level.frame.origin)[2])
    theirs, own = _places(level.camera, level.anchor_depth), _places(camera, depth)
    return bool(_inside(theirs, camera).any() or _inside(own, level.camera).any())


def _places(camera: Camera, depth: float) -> DoubleArray:
    """World points (n, 3) all over a camera's picture, at a depth."""
    y, x = (share.ravel() for share in np.meshgrid(*PLACES, indexing="ij"))
    rays = [(x * camera.width - camera.cx) / camera.fx, (y * camera.height - camera.cy) / camera.fy]
    return camera.to_world(depth * np.stack([*rays, np.ones(x.size)], 1))


def _inside(points: DoubleArray, camera: Camera) -> BoolArray:
    """Which of some world points (n, 3) a camera's picture shows."""
    x, y, z = np.moveaxis(camera.project(points), -1, 0)
    return np.asarray((z > 0) & (x >= 0) & (x <= camera.width) & (y >= 0) & (y <= camera.height))
