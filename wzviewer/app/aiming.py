"""How the next level is made: which level it refines, and what it shows.

What is on the screen is the next level's frame: C_{i+1} is C_render.  A level wants to be about x8
finer than its parent.  Where the view is not close enough the goal is moved closer; where it is much
closer, levels between come first, one after the other.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from wzviewer.app.wishes import Goal
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.core.scene import Level, Scene, siblings_before
from wzviewer.core.types import BoolArray, DoubleArray

STEP_MIN = 2.0  # finer than its parent, or a level shows nothing new
STEP_MAX = 12.0  # beyond it a level between gives the better picture
EXTEND_SHARE = 0.12  # of the view beyond the picture's border, from which on the border is what is meant
EXTEND_STEPS = (0.6, 1.5)  # an extension is about as fine as its parent
CLOSER, MOST_CLOSER = 1.25, 9  # by how much, and how often, until a frame shows nothing but the photo
SAME_SCALE = 0.7  # a level this close to the view's scale still counts as its parent


@dataclass(frozen=True, eq=False)
class Plan:
    """How the level for a goal is made.

    Attributes:
        parent: index of the level that it refines.
        camera: C_{i+1}, in the size of a level's image.
        step: how much finer than the parent the goal is.
        is_extension: whether the picture is to be continued where the view goes beyond its border.
    """

    parent: int
    camera: Camera
    step: float
    is_extension: bool = False


def plan_level(scene: Scene, goal: Goal) -> Plan | None:
    """Chooses the parent and the camera of the next level; None where no level shows the goal.

    The parent is the finest visible level that shows the centre of the view and is not finer.
    """
    frame = level_camera(scene, goal.camera)
    steps = {i: _step(scene[i], frame, goal.focus) for i in scene.visible() if _shows(scene[i], goal.focus)}
    coarser = {i: step for i, step in steps.items() if step > SAME_SCALE}
    extension = _plan_extension(scene, frame, goal.focus)
    if extension is not None and (not coarser or min(coarser.values()) < STEP_MIN):
        return extension
    if not coarser:
        return None
    parent = min(coarser, key=lambda i: (coarser[i], -i))
    if goal.prompt or goal.cutout is not None:
        parent = _uncovered(scene, parent, frame, goal.focus, coarser)
    step = coarser[parent]
    if step > STEP_MAX:
        frame = frame.zoomed(frame.width / 2, frame.height / 2, ZOOM_FACTOR / step)
    return Plan(parent, frame, step)


def _uncovered(scene: Scene, parent: int, frame: Camera, focus: DoubleArray, steps: dict[int, float]) -> int:
    """Returns the parent, or an ancestor below which nothing comes before what is put into a frame.

    Plain detail stays behind older siblings that are finer, with all that is below it: what was asked for
    would be cut off at their borders.
    """
    points = _grid(frame, focus)
    path = scene.path(parent)
    for above, ancestor in pairwise(path):
        before = siblings_before(scene, ancestor, above)
        if any(_shown(scene[i], points).any() for i in before):
            return above if steps.get(above, np.inf) <= STEP_MAX else parent
    return parent


def _grid(frame: Camera, focus: DoubleArray) -> DoubleArray:
    """World points (n, 3) all over a frame, at the depth of the focus."""
    depth = max(float(frame.to_camera(focus)[2]), 1e-12)
    places = [(x, y) for y in np.linspace(0.02, 0.98, 9) for x in np.linspace(0.02, 0.98, 13)]
    return np.array([frame.unproject(x * frame.width, y * frame.height, depth) for x, y in places])


def _plan_extension(scene: Scene, frame: Camera, focus: DoubleArray) -> Plan | None:
    """How to continue the picture in a view that goes beyond its border; None where it does not.

    The parent is the level in view whose scale is nearest to the view's.
    """
    points = _grid(frame, focus)
    shown = {i: int(_shown(scene[i], points).sum()) for i in scene.visible()}
    if max(shown.values(), default=0) in (0, len(points)) or 1 - shown[0] / len(points) < EXTEND_SHARE:
        return None
    steps = {i: _step(scene[i], frame, focus) for i, count in shown.items() if count}
    parent = min(steps, key=lambda i: (abs(np.log2(steps[i])), -i))
    if not EXTEND_STEPS[0] < steps[parent] < EXTEND_STEPS[1]:
        return None
    return Plan(parent, frame, steps[parent], is_extension=True)


def closer(goal: Goal, plan: Plan) -> Goal:
    """Returns the goal, about its centre as close as a level has to be; the same one if it is."""
    if plan.step >= STEP_MIN or plan.is_extension:
        return goal
    camera = goal.camera
    near = camera.zoomed(camera.width / 2, camera.height / 2, ZOOM_FACTOR / plan.step)
    return replace(goal, camera=near)


def inside(scene: Scene, goal: Goal) -> Goal | None:
    """Returns the goal, about its centre so close that it shows something new, and nothing but the photo.

    None where the photo does not show its centre.
    """
    parents = [i for i in scene.visible() if _shows(scene[i], goal.focus)]
    if not parents:
        return None
    frame = level_camera(scene, goal.camera)
    steps = [step for i in parents if (step := _step(scene[i], frame, goal.focus)) > SAME_SCALE]
    step, factor = min(steps, default=ZOOM_FACTOR), 1.0
    if step < STEP_MIN:
        factor = ZOOM_FACTOR / step
    camera = goal.camera.zoomed(goal.camera.width / 2, goal.camera.height / 2, factor)
    for _ in range(MOST_CLOSER):
        if _shown(scene[0], _grid(camera, goal.focus)).all():
            break
        camera = camera.zoomed(camera.width / 2, camera.height / 2, CLOSER)
    return replace(goal, camera=camera)


def plan_variant(scene: Scene, like: int) -> Plan | None:
    """Plans another of a level; None when its parent is not seen."""
    level = scene[like]
    if level.parent is None or not scene.is_visible(level.parent):
        return None
    return Plan(level.parent, level.camera, ZOOM_FACTOR)


def level_camera(scene: Scene, camera: Camera) -> Camera:
    """Returns a view's camera in the size of a level's image: the window's aspect, E_0's long side."""
    root = scene[0].camera
    ratio = max(root.width, root.height) / max(camera.width, camera.height)
    width, height = (2 * max(round(side * ratio / 2), 8) for side in (camera.width, camera.height))
    return camera.resized(width, height)


def _shows(level: Level, focus: DoubleArray) -> bool:
    return bool(_shown(level, focus))


def _shown(level: Level, points: DoubleArray) -> BoolArray:
    """Which of some world points (..., 3) lie in a level's picture."""
    x, y, z = np.moveaxis(level.camera.project(points), -1, 0)
    return np.asarray((z > 0) & (x >= 0) & (x <= level.camera.width) & (y >= 0) & (y <= level.camera.height))


def _step(level: Level, frame: Camera, focus: DoubleArray) -> float:
    """How much smaller a pixel of a frame is than one of a level, at a world point (Eq. 1)."""
    coarse = level.camera.pixel_scale(float(level.camera.to_camera(focus)[2]))
    return coarse / frame.pixel_scale(float(frame.to_camera(focus)[2]))
