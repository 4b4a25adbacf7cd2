"""Carries out commands: the only place where a new state comes from.

A handler takes (services, state, command) and returns the state after.  It never raises for what a
user can do wrong; should it raise all the same, the fault becomes a notice and the state stays.
"""

import logging
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from wzviewer.app import (
    answers,
    auto,
    directing,
    documents,
    generation,
    history,
    keeping,
    notices,
    planning,
    preferring,
    prompting,
    recovery,
    trail,
    viewing,
)
from wzviewer.app import commands as cmd
from wzviewer.app.look import MODES
from wzviewer.app.services import Services
from wzviewer.app.state import AppState

LOG = logging.getLogger(__name__)
EXCLUSIVE: frozenset[str] = frozenset({"keep", "settings"})  # panels in one place
Handler = Callable[[Services, AppState, Any], AppState]


def toggle(services: Services, state: AppState, command: cmd.Toggle) -> AppState:
    """Shows or hides a panel."""
    changes: dict[str, Any] = {command.panel: not getattr(state.panels, command.panel)}
    for other in EXCLUSIVE - {command.panel} if command.panel in EXCLUSIVE else ():
        changes[other] = False
    return replace(state, panels=replace(state.panels, **changes))


def set_look(services: Services, state: AppState, command: cmd.SetLook) -> AppState:
    """Draws the scene another way."""
    return replace(state, look=command.look)


def next_mode(services: Services, state: AppState, command: cmd.NextMode) -> AppState:
    """Goes on to the next of picture, levels, depth and coverage, and says which it is."""
    names = [mode for mode, _ in MODES]
    mode, name = MODES[(names.index(state.look.mode) + 1) % len(MODES)]
    state = replace(state, look=replace(state.look, mode=mode))
    return state.with_toast(f"View: {name.lower()}.")


def escape(services: Services, state: AppState, command: cmd.Escape) -> AppState:
    """Leaves what is in the foreground: dialog, then help, then the running request."""
    panels = state.panels
    if panels.dialog:
        return replace(state, after=None, panels=replace(panels, dialog="", dialog_path=""))
    if panels.keep or panels.settings:
        return replace(state, panels=replace(panels, keep=False, settings=False))
    if state.timeline.is_playing:
        return directing.toggle_play(services, state, cmd.TogglePlay())
    if panels.help:
        return replace(state, panels=replace(panels, help=False))
    if state.job is not None or state.goal is not None:
        return generation.cancel(services, state, cmd.CancelJob())
    return replace(state, refusal="", view=replace(state.view, flight=None))


HANDLERS: dict[type[cmd.Command], Handler] = {
    cmd.Zoom: viewing.zoom,
    cmd.BeginDrag: viewing.begin_drag,
    cmd.DragTo: viewing.drag_to,
    cmd.EndDrag: viewing.end_drag,
    cmd.Fly: viewing.fly,
    cmd.ZoomTo: viewing.zoom_to,
    cmd.GoHome: viewing.go_home,
    cmd.GoBack: trail.go_back,
    cmd.GoForward: trail.go_forward,
    cmd.GoToLevel: viewing.go_to_level,
    cmd.SetLook: set_look,
    cmd.NextMode: next_mode,
    cmd.Resize: viewing.resize,
    cmd.EditPrompt: prompting.edit_prompt,
    cmd.TakeOffer: prompting.take_offer,
    cmd.ChooseOffer: prompting.choose_offer,
    cmd.FocusPrompt: prompting.focus_prompt,
    cmd.Generate: generation.generate,
    cmd.ToggleAuto: auto.toggle_auto,
    cmd.CancelJob: generation.cancel,
    cmd.Undo: history.undo,
    cmd.Redo: history.redo,
    cmd.Open: documents.open_path,
    cmd.OpenDemo: documents.open_demo,
    cmd.AskOpen: documents.ask_open,
    cmd.Save: documents.save,
    cmd.SaveTo: documents.save_to,
    cmd.AskPicture: keeping.ask_picture,
    cmd.SavePicture: keeping.save_picture,
    cmd.SetPictureSize: planning.set_size,
    cmd.CopyView: keeping.copy_view,
    cmd.AskFilm: keeping.ask_film,
    cmd.MakeFilm: keeping.make_film,
    cmd.CancelFilm: keeping.cancel_film,
    cmd.SetPlan: planning.set_plan,
    cmd.AddKey: directing.add_key,
    cmd.UpdateKey: directing.update_key,
    cmd.DeleteKey: directing.delete_key,
    cmd.SelectKey: directing.select_key,
    cmd.StepKey: directing.step_key,
    cmd.RetimeKey: directing.retime_key,
    cmd.SetKeySeconds: directing.set_key_seconds,
    cmd.SetKeyPace: directing.set_key_pace,
    cmd.ScrubTo: directing.scrub_to,
    cmd.TogglePlay: directing.toggle_play,
    cmd.ToggleLoop: directing.toggle_loop,
    cmd.FillKeys: directing.fill_keys,
    cmd.PlanKeysFilm: directing.plan_keys_film,
    cmd.ClearKeys: directing.clear_keys,
    cmd.BringBackKeys: directing.bring_back_keys,
    cmd.AskPath: directing.ask_path,
    cmd.OpenCameraPath: directing.open_camera_path,
    cmd.SaveCameraPath: directing.save_camera_path,
    cmd.Close: documents.close,
    cmd.SettleUnsaved: documents.settle_unsaved,
    cmd.SettleRecovery: recovery.settle_recovery,
    cmd.Toggle: toggle,
    cmd.Escape: escape,
    cmd.EditPath: documents.edit_path,
    cmd.ConfirmPath: answers.confirm_path,
    cmd.DismissToast: notices.dismiss,
    cmd.ExpandToast: notices.expand,
    cmd.Retry: notices.retry,
    cmd.ChangeSettings: preferring.change_settings,
}


def apply(services: Services, state: AppState, commands: Iterable[cmd.Command]) -> AppState:
    """Carries out commands in order; a fault becomes a notice."""
    for command in commands:
        state = _guarded(HANDLERS[type(command)], services, state, command)
    return state


def drain(services: Services, state: AppState, budget_s: float) -> AppState:
    """Takes over what the worker made since the last frame, within a time budget."""
    try:
        events = services.client.poll(budget_s)
    except Exception as error:  # whatever the worker breaks, frames go on
        LOG.exception("poll failed")
        return state.with_toast(f"The worker cannot be reached: {error}", "error")
    for event in events:
        state = _guarded(generation.on_event, services, state, event)
    state = _guarded(documents.open_next, services, state, None)
    if generation.is_goal_reached(state):
        # Taken off first: a fault is told once, and not again every frame.
        goal, state = state.goal, replace(state, goal=None, is_goal_waiting=False)
        state = _guarded(generation.request, services, state, goal)
    return state


def preview(services: Services, state: AppState, dt_s: float) -> AppState:
    """Lets the timeline's preview go on for a frame."""
    return _guarded(lambda _, before, seconds: directing.play(before, seconds), services, state, dt_s)


def tick(services: Services, state: AppState, is_typing: bool) -> AppState:
    """What the app does by itself once a frame has been answered."""
    is_previewing = directing.is_previewing(state)
    state = state if is_previewing else trail.note_place(state)
    recovery.keep(services, state)
    state = keeping.follow_film(services, state)
    if is_previewing:  # nobody has come to look: no detail is asked for
        return state
    return _guarded(auto.ask_for_detail, services, state, is_typing)


def _guarded(handler: Handler, services: Services, state: AppState, argument: object) -> AppState:
    try:
        return handler(services, state, argument)
    except Exception as error:  # the frame loop outlives every fault of a handler
        LOG.exception("%s failed", getattr(handler, "__name__", handler))
        name = getattr(handler, "__name__", "this").replace("_", " ")
        return state.with_toast(f"{name[:1].upper()}{name[1:]} failed: {error}", "error")
