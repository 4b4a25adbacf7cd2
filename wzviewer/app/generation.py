"""Asking Thread 2 for levels, and taking over what it makes (Algorithm 1, lines 1 and 10-32).

One request runs at a time.  What is asked for meanwhile waits in a queue (`wishes`); `aiming` says how
a goal is reached.
"""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.aiming import STEP_MAX, closer, plan_level, plan_variant
from wzviewer.app.history import made
from wzviewer.app.naming import name_in
from wzviewer.app.picking import world_point
from wzviewer.app.prompting import refusal_of, with_prompt, with_vocabulary
from wzviewer.app.region import Region
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Goal, Job, StageNote, View
from wzviewer.app.variants import can_vary, group_of, next_seed
from wzviewer.app.viewing import fly_to
from wzviewer.app.wishes import AGAIN_S, MAX_WAITING, Queue
from wzviewer.core.beside import levels_beside
from wzviewer.core.scene import Level, Scene
from wzviewer.errors import WzError
from wzviewer.worker import client as ev

# ------------------------------------------------------------------ requests


def generate(services: Services, state: AppState, command: cmd.Generate) -> AppState:
    """Asks for new detail where the user looks; flies closer first where that is needed."""
    refusal = refusal_of(state.prompt, state.reading)
    if refusal:  # at once, and not after a flight; what is typed to put it right must not reach the keys
        panels = replace(state.panels, prompt_focus=cmd.FocusPrompt().frames)
        return replace(state, refusal=refusal, panels=panels)
    if not len(state.scene):
        return _ask_early(services, state, command)
    state = replace(state, panels=replace(state.panels, materials=False))
    return ask_at(services, state, replace(goal_here(services, state), count=command.count))


def _ask_early(services: Services, state: AppState, command: cmd.Generate) -> AppState:
    """Asks before E_0 has a first preview: words wait for it; without words there is nothing to wait for."""
    prompt, camera = state.prompt.strip(), state.view.camera
    if state.photo is None:
        return state
    if state.job is None:
        state = reconstruct(services, state)
    elif not prompt:
        return state.with_toast("One moment: the photo is still being read. Esc cancels it.")
    if not prompt or state.job is None:
        return state
    return _wait(state, Goal(camera, prompt, state.view.focus, command.count, is_early=True))


def _found(services: Services, state: AppState, goal: Goal) -> Goal:
    """A goal that was asked for before there was a surface, with the point of it that it means."""
    if not goal.is_early:
        return goal
    camera, depth = goal.camera, state.scene[0].anchor_depth
    place = (camera.width / 2, camera.height / 2, depth)
    return replace(goal, focus=world_point(state.scene, services.renderer, camera, *place), is_early=False)


def ask_at(services: Services, state: AppState, goal: Goal) -> AppState:
    """Asks for a goal in the view or in the frame that was drawn, and flies to the frame."""
    if plan_level(state.scene, goal) is None:
        return state.with_toast("There is no picture at the centre of the view. Pan onto it first.", "error")
    has_frame = state.region.camera is not None
    state = ask(services, replace(state, refusal="", region=Region()), goal)
    if has_frame and is_busy(state) and not any(g is goal for g in state.queue.goals):
        going = state.job.goal if state.job is not None and state.job.goal is not None else state.goal
        return fly_to(state, (going or goal).camera, goal.focus)
    return state


def goal_here(services: Services, state: AppState) -> Goal:
    """Returns what Enter asks for: the frame or else the view, with the words in the prompt line."""
    view, region = state.view, state.region
    if region.camera is not None and region.focus is not None:
        return Goal(region.camera, state.prompt.strip(), region.focus)
    camera = view.flight.end if view.flight is not None else view.camera
    focus = view.focus
    if view.flight is None:
        x_px, y_px = camera.width / 2, camera.height / 2
        focus = world_point(state.scene, services.renderer, camera, x_px, y_px, view.focus_depth)
    return Goal(camera, state.prompt.strip(), focus)


def ask(services: Services, state: AppState, goal: Goal) -> AppState:
    """Asks for a goal: now, or once what runs has ended.  Then the prompt line is free again."""
    if state.job is not None and state.job.is_auto and _is_wanted(state.job, goal):
        return replace(state, job=replace(state.job, is_auto=False))
    if state.job is not None and makes_room(state):
        services.client.cancel(ev.PATIENT_S)
        job = replace(state.job, is_cancelling=True)
        return _taken(replace(state, job=job, goal=goal, is_goal_waiting=True), goal)
    if is_busy(state):
        return _wait(state, goal)
    after = begin(services, state, goal)
    return _taken(after, goal) if is_busy(after) else after


def makes_room(state: AppState) -> bool:
    """Whether auto detail runs, and nothing has been asked for since: what is asked for goes first."""
    return state.job is not None and state.job.is_auto and not is_next(state)


def is_next(state: AppState) -> bool:
    """Whether what was asked for begins once auto detail, which runs still, has stopped."""
    job = state.job
    return job is not None and job.is_auto and job.is_cancelling and state.is_goal_waiting


def _is_wanted(job: Job, goal: Goal) -> bool:
    """Whether auto detail is making what is now asked for."""
    is_same = job.goal is not None and _is_same(job.goal, goal)
    return is_same and goal.count == 1 and not job.is_cancelling


def _taken(state: AppState, goal: Goal) -> AppState:
    """The line is free again, if it holds what was asked for."""
    is_typed = goal.like is None and goal.cutout is None and goal.prompt == state.prompt.strip()
    return with_prompt(state, "") if is_typed else state


def is_busy(state: AppState) -> bool:
    """Whether something is being made, or will be once a flight has ended."""
    return state.job is not None or state.goal is not None


def _wait(state: AppState, goal: Goal) -> AppState:
    asked = [state.goal, state.job.goal if state.job is not None else None, *state.queue.goals]
    if any(other is not None and _is_same(other, goal) for other in asked):
        return state.with_toast("That is being made already. Move on, or type something to add.")
    if state.queue.is_full:
        return state.with_toast(f"{MAX_WAITING} are waiting already. One moment.")
    return _taken(replace(state, queue=state.queue.with_last(goal)), goal)


def _is_same(one: Goal, other: Goal) -> bool:
    words = (one.prompt, one.like, one.cutout is None) == (other.prompt, other.like, other.cutout is None)
    return words and one.like is None and one.camera.key == other.camera.key


def begin(services: Services, state: AppState, goal: Goal) -> AppState:
    """Begins with a goal: at once, or closer where the view would show nothing new."""
    if goal.like is not None:
        return request(services, state, goal)
    plan = plan_level(state.scene, goal)
    if plan is None:
        return state.with_toast("There is no picture there any more.", "error")
    view = state.view
    is_here = (view.flight.end if view.flight is not None else view.camera).key == goal.camera.key
    near = closer(goal, plan)
    if near is goal:
        return request(services, state, goal)
    if not is_here:  # it waited, and the user is elsewhere by now
        return request(services, state, near)
    state = fly_to(state, near.camera, goal.focus)
    state = replace(state, goal=near, is_goal_waiting=True)
    factor = near.camera.focal_px / goal.camera.focal_px
    return state.with_toast(f"Moved ×{factor:.0f} closer: new detail appears where you zoom in.")


def next_wish(services: Services, state: AppState, command: None = None) -> AppState:
    """Begins with what waits, once nothing runs; called every frame."""
    if not state.queue.goals or is_busy(state) or state.next_path is not None or not len(state.scene):
        return state
    goal, queue = _found(services, state, state.queue.goals[0]), state.queue.without(0)
    return begin(services, replace(state, queue=queue), goal)


def request(services: Services, state: AppState, goal: Goal, is_auto: bool = False) -> AppState:
    """Asks for the next level on the way to a goal."""
    state = replace(state, goal=None, is_goal_waiting=False)
    plan = plan_level(state.scene, goal) if goal.like is None else plan_variant(state.scene, goal.like)
    if plan is None:
        return state
    is_last = plan.step <= STEP_MAX
    prompt, cutout = (goal.prompt, goal.cutout) if is_last else ("", None)
    seed = len(state.scene) if goal.like is None else next_seed(state.scene, goal.like)
    beside = levels_beside(state.scene, plan.parent, plan.camera, prompt, cutout is not None)
    try:
        request_id = services.client.synthesize(plan.parent, plan.camera, prompt, seed, cutout, beside)
    except (WzError, OSError, RuntimeError) as error:
        return state.with_toast(str(error), "error")
    job = Job(request_id, "level", prompt, state.clock_s, is_auto=is_auto, parent=plan.parent, goal=goal)
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
    return replace(state, job=Job(request_id, "photo", "", state.clock_s))


def cancel(services: Services, state: AppState, command: cmd.CancelJob) -> AppState:
    """Stops the running request, and at the second time what waits as well."""
    queue, job = state.queue, state.job
    if queue.goals and (state.now_s - queue.cancelled_s < AGAIN_S or not is_busy(state)):
        return clear_queue(services, _stopped(services, state), cmd.ClearQueue())
    return _stopped(services, state) if job is not None or state.goal is not None else state


def _stopped(services: Services, state: AppState) -> AppState:
    queue = replace(state.queue, cancelled_s=state.now_s)
    state = replace(state, goal=None, is_goal_waiting=False, asked_for=state.view.camera, queue=queue)
    if state.job is None or state.job.is_cancelling:
        return state
    services.client.cancel()
    return replace(state, job=replace(state.job, is_cancelling=True))


def clear_queue(services: Services, state: AppState, command: cmd.ClearQueue) -> AppState:
    """Forgets what waits."""
    return replace(state, queue=Queue(cancelled_s=state.queue.cancelled_s)).with_toast("Nothing waits now.")


def drop_wish(services: Services, state: AppState, command: cmd.DropWish) -> AppState:
    """Takes a goal out of the queue."""
    return replace(state, queue=state.queue.without(command.place))


# ------------------------------------------------------------------ events


def on_event(services: Services, state: AppState, event: ev.Event) -> AppState:
    """Takes over something that the worker reported."""
    if isinstance(event, ev.WorkerStarted):
        services.words.keep(event.vocabulary)
        return with_vocabulary(replace(state, is_worker_ready=True), event.vocabulary)
    if isinstance(event, ev.WorkerLost):
        state = replace(state, is_worker_ready=False)
        is_said = any(t.kind == "error" and t.born_s == state.now_s for t in state.toasts)
        if is_said or event.is_after_cancel:
            return state  # the request that it took with it has just said so; or it was meant to end
        again = "" if "not started again" in event.why else " It was started again."
        return state.with_toast(f"The worker {event.why}.{again} Nothing is lost.", "error")
    if state.job is None or event.request_id != state.job.request_id:
        return state  # of a document that was closed meanwhile
    if isinstance(event, ev.StageProgressed):
        return replace(state, job=_progressed(state.job, event, state.clock_s))
    if isinstance(event, ev.LevelPreviewed):
        is_bare = state.job.goal is not None and state.job.goal.like is not None and not event.revision
        return state if is_bare else _stood_back(_take(state, event.level))
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


def _stood_back(state: AppState) -> AppState:
    """A variant whose preview stands is seen alone: two that overlap would show through each other."""
    job = state.job
    if job is None or job.goal is None or job.goal.like is None or job.instead_of is not None:
        return state
    seen = _seen_variant(state.scene, job.goal.like)
    if seen is None:
        return state
    state.scene.hide(seen)
    return replace(state, job=replace(job, instead_of=seen))


def _brought_back(state: AppState) -> AppState:
    """What stood back is seen again, unless something else was done to it meanwhile."""
    index = state.job.instead_of if state.job is not None else None
    if state.job is None or index is None:
        return state
    if state.scene.mark(index).sight == "hidden":
        state.scene.show(index)
    return replace(state, job=replace(state.job, instead_of=None))


def _seen_variant(scene: Scene, index: int) -> int | None:
    """The newest variant that is shown."""
    return max((i for i in group_of(scene, index) if scene.mark(i).sight == "shown"), default=None)


def _with_first_level(state: AppState, level: Level) -> AppState:
    """The flat picture becomes E_0 under the user's hand: the view stays where it is."""
    view = state.view
    fresh = View.at_home(level.camera, view.camera.width, view.camera.height)
    same = abs(fresh.home.focal_px / view.home.focal_px - 1.0) < 1e-3
    view = replace(view, home=fresh.home) if same else fresh
    camera = view.camera
    focus = camera.unproject(camera.width / 2, camera.height / 2, level.anchor_depth)
    return state.with_view(replace(view, focus=focus, focused=None))  # the surface there is another one


def _finish(services: Services, state: AppState, level: Level) -> AppState:
    job = state.job
    started_s = job.started_s if job is not None else state.clock_s
    state = _brought_back(_take(state, level))
    state.scene.commit(level.index)
    state = replace(state, job=None)
    if level.index == 0 or job is None:
        return state
    is_last = state.goal is None
    state = _noted(state, level, job.goal, is_last)
    seconds = state.clock_s - started_s
    name = f"“{name_in(state.scene, level.index)}”" if level.prompt else "New detail"
    has_offer = is_last and not job.is_auto and state.variants is None and can_vary(state.scene, level.index)
    offer = ("Another", cmd.Another(level.index)) if has_offer else ("", None)
    state = state.with_toast(f"{name} is ready: {seconds:.1f} s.", "done", button=offer[0], command=offer[1])
    return request(services, state, state.goal, job.is_auto) if state.goal is not None else state


def _noted(state: AppState, level: Level, goal: Goal | None, is_last: bool) -> AppState:
    """Remembers a finished level; a variant takes the place of the one that was seen."""
    if goal is None or not is_last:
        return made(state, level.index)
    group = group_of(state.scene, goal.like) if goal.like is not None else ()
    seen = [i for i in group if i != level.index and state.scene.mark(i).sight == "shown"]
    state = made(state, level.index, seen[-1] if seen else None)
    if goal.count > 1:
        more = replace(goal, count=goal.count - 1, like=level.index)
        state = replace(state, queue=state.queue.with_first(more))
    is_variant = goal.like is not None or goal.count > 1
    return replace(state, variants=level.index) if is_variant else state


def _drop(state: AppState, event: ev.LevelDropped) -> AppState:
    state = _brought_back(state)
    index = len(state.scene) - 1
    if state.job is not None and state.job.level == index and not state.scene.is_committed(index):
        state.scene.abort(index)
    job = state.job
    if event.cancelled and is_next(state):
        return replace(state, job=None)  # it made room
    state = replace(state, job=None, goal=None, is_goal_waiting=False, asked_for=state.view.camera)
    goal = job.goal if job is not None else None
    is_typed = goal is not None and goal.like is None and goal.cutout is None
    if goal is not None and is_typed and not state.prompt.strip() and not state.queue.goals:
        state = with_prompt(state, goal.prompt)  # so that it can be put right
    if event.cancelled:
        waiting = len(state.queue.goals)
        more = f" {waiting} more wait: Esc again ends them." if waiting else ""
        if state.next_path is not None or (job is not None and job.is_auto):
            return state  # nobody waited for it: that its bar goes says enough
        return state.with_toast(f"Cancelled.{more}")
    line = _sentence(event)
    if event.bad_input and len(state.scene):
        return replace(state, refusal=line)
    can_retry = is_typed and job is not None and not job.is_auto and not event.bad_input
    retry = job.prompt if can_retry and job is not None else None
    return state.with_toast(line, "error", event.detail, retry)


def _sentence(event: ev.LevelDropped) -> str:
    if event.what == "worker":  # its reasons are sentences about the worker already
        return f"{event.why[:1].upper()}{event.why[1:].rstrip('.')}. {event.hint}".strip()
    return WzError(event.what, event.why, event.hint).line()
