"""Auto detail: where the view rests beyond what there is, detail is asked for by itself.

Never while anything else goes on: a motion, a request, a dialog, typing, or words in the prompt line,
which the user wants to send with a request of their own.  A place whose level was undone, cancelled or
refused is left alone until the view moves.
"""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.aiming import plan_level
from wzviewer.app.generation import request
from wzviewer.app.preferring import with_settings
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Goal

AUTO_REST_S = 0.4  # without motion
AUTO_STEP_MIN = 2.5  # how much finer than all there is the view has to be; below, little would be new


def ask_for_detail(services: Services, state: AppState, is_typing: bool) -> AppState:
    """Asks for a level where the view rests beyond native resolution; called every frame.

    Args:
        services: with the worker's client.
        state: of the app.
        is_typing: whether a line of text has the keyboard.
    """
    if is_typing or not is_waiting(state) or state.now_s - state.view.moved_s < AUTO_REST_S:
        return state
    view = state.view
    state = replace(state, asked_for=view.camera)
    goal = Goal(view.camera, "", view.focus)
    plan = plan_level(state.scene, goal)
    if plan is None or plan.is_extension or plan.step < AUTO_STEP_MIN:
        return state
    return request(services, state, goal, is_auto=True)


def is_waiting(state: AppState) -> bool:
    """Whether only rest is missing: nothing else goes on, and this place was not asked for before."""
    is_idle = state.job is None and state.goal is None and not state.queue.goals
    is_idle = is_idle and state.next_path is None and state.errand is None  # another document is on its way
    is_alone = not (state.panels.dialog or state.panels.help or state.prompt.strip())
    is_known = len(state.scene) > 0 and state.is_worker_ready and state.view.focused is state.view.camera
    is_fresh = state.asked_for is not state.view.camera
    return state.settings.auto_detail and is_idle and is_alone and is_known and is_fresh


def toggle_auto(services: Services, state: AppState, command: cmd.ToggleAuto) -> AppState:
    """Switches auto detail on or off, and says so."""
    is_on = not state.settings.auto_detail
    state = with_settings(services, state, replace(state.settings, auto_detail=is_on))
    what = "on: rest anywhere closer, and it appears" if is_on else "off: Enter asks for it"
    return state.with_toast(f"Auto detail is {what}.")
