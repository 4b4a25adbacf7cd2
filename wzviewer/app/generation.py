"""Asking Thread 2 for levels, and taking over what it makes (Algorithm 1, lines 1 and 10-32).

What is on the screen is the next level's frame: C_{i+1} is C_render.  A level wants to be about x8
finer than its parent.  Where the view is not close enough the app flies there first; where it is much
closer it asks for the levels between, one after the other.
"""

from dataclasses import dataclass, replace

import numpy as np

from wzviewer.app import commands as cmd
from wzviewer.app.history import noted
from wzviewer.app.picking import world_point
from wzviewer.app.prompting import refusal_of, with_prompt, with_vocabulary
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Goal, Job, StageNote, View
from wzviewer.app.viewing import fly_to
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.core.scene import Level, Scene
from wzviewer.core.types import DoubleArray
from wzviewer.errors import WzError
from wzviewer.worker import client as ev

STEP_MIN = 2.0  # finer than its parent, or a level shows nothing new
STEP_MAX = 12.0  # beyond it a level between gives the better picture
EXTEND_SHARE = 0.12  # of the view beyond the picture's border, from which on the border is what is meant
EXTEND_STEPS = (0.6, 1.5)  # an extension is about as fine as its parent
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
    step = coarser[parent]
    if step > STEP_MAX:
        frame = frame.zoomed(frame.width / 2, frame.height / 2, ZOOM_FACTOR / step)
    return Plan(parent, frame, step)


def _plan_extension(scene: Scene, frame: Camera, focus: DoubleArray) -> Plan | None:
    """How to continue the picture in a view that goes beyond its border; None where it does not.

    The parent is the level in view whose scale is nearest to the view's.
    """
    depth = max(float(frame.to_camera(focus)[2]), 1e-12)
    places = [(x, y) for y in np.linspace(0.02, 0.98, 9) for x in np.linspace(0.02, 0.98, 13)]
    points = [frame.unproject(x * frame.width, y * frame.height, depth) for x, y in places]
    shown = {i: sum(_shows(scene[i], point) for point in points) for i in scene.visible()}
    if max(shown.values(), default=0) in (0, len(points)) or 1 - shown[0] / len(points) < EXTEND_SHARE:
        return None
    steps = {i: _step(scene[i], frame, focus) for i, count in shown.items() if count}
    parent = min(steps, key=lambda i: (abs(np.log2(steps[i])), -i))
    if not EXTEND_STEPS[0] < steps[parent] < EXTEND_STEPS[1]:
        return None
    return Plan(parent, frame, steps[parent], is_extension=True)


def level_camera(scene: Scene, camera: Camera) -> Camera:
    """Returns a view's camera in the size of a level's image: the window's aspect, E_0's long side."""
    root = scene[0].camera
    ratio = max(root.width, root.height) / max(camera.width, camera.height)
    width, height = (2 * max(round(side * ratio / 2), 8) for side in (camera.width, camera.height))
    return camera.resized(width, height)


def _shows(level: Level, focus: DoubleArray) -> bool:
    x, y, z = level.camera.project(focus)
    return bool(z > 0 and 0 <= x <= level.camera.width and 0 <= y <= level.camera.height)


def _step(level: Level, frame: Camera, focus: DoubleArray) -> float:
    """How much smaller a pixel of a frame is than one of a level, at a world point (Eq. 1)."""
    coarse = level.camera.pixel_scale(float(level.camera.to_camera(focus)[2]))
    return coarse / frame.pixel_scale(float(frame.to_camera(focus)[2]))


# ------------------------------------------------------------------ requests


def generate(services: Services, state: AppState, command: cmd.Generate) -> AppState:
    """Asks for new detail where the user looks; flies closer first where that is needed."""
    if state.job is not None and not state.job.is_auto:
        return state.with_toast("One moment: the last request is still running. Esc cancels it.")
    if not len(state.scene):
        return reconstruct(services, state) if state.photo is not None else state
    refusal = refusal_of(state.prompt, state.reading)
    if refusal:  # at once, and not after a flight
        return replace(state, refusal=refusal)
    view = state.view
    camera = view.flight.end if view.flight is not None else view.camera
    x_px, y_px = camera.width / 2, camera.height / 2
    focus = view.focus
    if view.flight is None:
        focus = world_point(state.scene, services.renderer, camera, x_px, y_px, view.focus_depth)
    goal = Goal(camera, state.prompt.strip(), focus)
    plan = plan_level(state.scene, goal)
    if plan is None:
        return state.with_toast("There is no picture at the centre of the view. Pan onto it first.", "error")
    state = replace(state, refusal="")
    if state.job is not None:  # of auto detail: it makes room for what was asked for
        services.client.cancel()
        job = replace(state.job, is_cancelling=True)
        return replace(state, job=job, goal=goal, is_goal_waiting=True)
    if plan.step < STEP_MIN and not plan.is_extension:
        return _closer(state, goal, plan)
    return request(services, state, goal)


def _closer(state: AppState, goal: Goal, plan: Plan) -> AppState:
    factor = ZOOM_FACTOR / plan.step
    near = goal.camera.zoomed(goal.camera.width / 2, goal.camera.height / 2, factor)
    state = fly_to(state, near, goal.focus)
    state = replace(state, goal=replace(goal, camera=near), is_goal_waiting=True)
    return state.with_toast(f"Moved ×{factor:.0f} closer: new detail appears where you zoom in.")


def request(services: Services, state: AppState, goal: Goal, is_auto: bool = False) -> AppState:
    """Asks for the next level on the way to a goal."""
    state = replace(state, goal=None, is_goal_waiting=False)
    plan = plan_level(state.scene, goal)
    if plan is None:
        return state
    is_last = plan.step <= STEP_MAX
    prompt = goal.prompt if is_last else ""
    index = len(state.scene)
    try:
        request_id = services.client.synthesize(plan.parent, plan.camera, prompt, seed=index)
    except (WzError, OSError, RuntimeError) as error:
        return state.with_toast(str(error), "error")
    job = Job(request_id, "level", prompt, state.now_s, is_auto=is_auto)
    return replace(state, job=job, goal=None if is_last else goal)


def is_goal_reached(state: AppState) -> bool:
    """Whether the flight to a goal has ended, so that it can be asked for."""
    return state.is_goal_waiting and state.view.flight is None and state.job is None


def reconstruct(services: Services, state: AppState) -> AppState:
    """Asks for E_0 from the photo (line 1)."""
    if state.photo is None:
        return state
    try:
        request_id = services.client.reconstruct(state.photo, photo=state.finer_photo)
    except (WzError, OSError, RuntimeError) as error:
        return state.with_toast(str(error), "error")
    return replace(state, job=Job(request_id, "photo", "", state.now_s))


def cancel(services: Services, state: AppState, command: cmd.CancelJob) -> AppState:
    """Stops the running request and what was to follow it."""
    state = replace(state, goal=None, is_goal_waiting=False, asked_for=state.view.camera)
    if state.job is None:
        return state
    services.client.cancel()
    return replace(state, job=replace(state.job, is_cancelling=True))


# ------------------------------------------------------------------ events


def on_event(services: Services, state: AppState, event: ev.Event) -> AppState:
    """Takes over something that the worker reported."""
    if isinstance(event, ev.WorkerStarted):
        return with_vocabulary(replace(state, is_worker_ready=True), event.vocabulary)
    if isinstance(event, ev.WorkerLost):
        state = replace(state, is_worker_ready=False)
        if any(t.kind == "error" and t.born_s == state.now_s for t in state.toasts):
            return state  # the request that it took with it has just said so
        again = "" if "not started again" in event.why else " It was started again."
        return state.with_toast(f"The worker {event.why}.{again} Nothing is lost.", "error")
    if state.job is None or event.request_id != state.job.request_id:
        return state  # of a document that was closed meanwhile
    if isinstance(event, ev.StageProgressed):
        return replace(state, job=_progressed(state.job, event, state.now_s))
    if isinstance(event, ev.LevelPreviewed):
        return _take(state, event.level)
    if isinstance(event, ev.LevelFinished):
        return _finish(services, state, event.level)
    if isinstance(event, ev.LevelDropped):
        return _drop(state, event)
    return state


def _progressed(job: Job, event: ev.StageProgressed, now_s: float) -> Job:
    stages = job.stages
    if not stages or stages[-1].name != event.name:
        stages = (*stages, StageNote(event.stage, event.name, now_s))
    return replace(job, stages=stages, fraction=max(job.fraction, event.fraction))


def _take(state: AppState, level: Level) -> AppState:
    """A preview swaps in, in place of the one before."""
    scene = state.scene
    if level.index == len(scene):
        scene.append(level)
    else:
        scene.replace(level)
    if level.index == 0:
        state = _with_first_level(state, level)
    job = replace(state.job, level=level.index) if state.job is not None else None
    return replace(state, job=job)


def _with_first_level(state: AppState, level: Level) -> AppState:
    """The flat picture becomes E_0 under the user's hand: the view stays where it is."""
    view = state.view
    fresh = View.at_home(level.camera, view.camera.width, view.camera.height)
    focus = fresh.camera.unproject(view.camera.width / 2, view.camera.height / 2, level.anchor_depth)
    same = abs(fresh.home.focal_px / view.home.focal_px - 1.0) < 1e-3
    view = replace(view, home=fresh.home, focus=focus) if same else replace(fresh, focus=focus)
    return state.with_view(view)


def _finish(services: Services, state: AppState, level: Level) -> AppState:
    job = state.job
    started_s = job.started_s if job is not None else state.now_s
    state = _take(state, level)
    state.scene.commit(level.index)
    state = replace(state, job=None)
    if level.index == 0:
        return state
    seconds = state.now_s - started_s
    name = f"“{level.prompt}”" if level.prompt else "New detail"
    state = noted(state).with_toast(f"{name} is ready: {seconds:.1f} s.", "done")
    if level.prompt and level.prompt == state.prompt.strip():
        state = with_prompt(state, "")
    is_auto = job is not None and job.is_auto
    return request(services, state, state.goal, is_auto) if state.goal is not None else state


def _drop(state: AppState, event: ev.LevelDropped) -> AppState:
    index = len(state.scene) - 1
    if state.job is not None and state.job.level == index and not state.scene.is_committed(index):
        state.scene.abort(index)
    job = state.job
    if job is not None and job.is_auto and event.cancelled and state.is_goal_waiting:
        return replace(state, job=None)  # it made room
    state = replace(state, job=None, goal=None, is_goal_waiting=False, asked_for=state.view.camera)
    if event.cancelled:
        return state if state.next_path is not None else state.with_toast("Cancelled.")
    line = _sentence(event)
    if event.bad_input and len(state.scene):
        return replace(state, refusal=line)
    can_retry = job is not None and not job.is_auto and not event.bad_input
    retry = job.prompt if can_retry and job is not None else None
    return state.with_toast(line, "error", event.detail, retry)


def _sentence(event: ev.LevelDropped) -> str:
    if event.what == "worker":  # its reasons are sentences about the worker already
        return f"{event.why[:1].upper()}{event.why[1:].rstrip('.')}. {event.hint}".strip()
    return WzError(event.what, event.why, event.hint).line()
