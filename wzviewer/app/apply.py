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
    dropping,
    framing,
    generation,
    hint,
    history,
    keeping,
    locating,
    notices,
    preferring,
    prompting,
    recovery,
    reopening,
    shooting,
    summoning,
    trail,
    varying,
    viewing,
)
from wzviewer.app import commands as cmd
from wzviewer.app.logbook import log_event, log_notices
from wzviewer.app.look import MEANINGS, MODES
from wzviewer.app.region import Region
from wzviewer.app.services import Services
from wzviewer.app.state import AppState

LOG = logging.getLogger(__name__)
EXCLUSIVE: frozenset[str] = frozenset({"keep", "settings", "history"})  # panels in one place
VIEW = "View: "
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
    others = tuple(t for t in state.toasts if not t.text.startswith(VIEW))  # of going through them
    state = replace(state, look=replace(state.look, mode=mode), toasts=others)
    return state.with_toast(f"{VIEW}{name.lower()}. {MEANINGS[mode]}".rstrip())


def escape(services: Services, state: AppState, command: cmd.Escape) -> AppState:
    """Leaves what is in the foreground: dialog, then help, then the running request."""
    panels = state.panels
    if panels.dialog:
        return documents.without_dialog(replace(state, after=None))
    if summoning.is_summoned(state):
        return summoning.dismissed(state)
    if panels.keep or panels.settings or panels.history or panels.materials:
        closed = replace(panels, keep=False, settings=False, history=False, materials=False)
        return replace(state, panels=closed)
    if panels.start:
        return replace(state, panels=replace(panels, start=False))
    if state.timeline.is_playing:
        return directing.toggle_play(services, state, cmd.TogglePlay())
    if panels.help:
        return replace(state, panels=replace(panels, help=False))
    if state.region.is_drawing or state.region.camera is not None:
        return replace(state, region=Region())
    if generation.is_busy(state) or state.queue.goals:
        return generation.cancel(services, state, cmd.CancelJob())
    if state.variants is not None:
        return replace(state, variants=None)
    if state.look.mode != "picture":
        return replace(state, look=replace(state.look, mode="picture"))
    return replace(state, refusal="", view=replace(state.view, flight=None))


HANDLERS: dict[type[cmd.Command], Handler] = {
    cmd.Zoom: viewing.zoom,
    cmd.BeginDrag: framing.begin_drag,
    cmd.DragTo: framing.drag_to,
    cmd.EndDrag: framing.end_drag,
    cmd.ToggleRegion: framing.toggle,
    cmd.GoToPhoto: locating.go_to_photo,
    cmd.Fly: viewing.fly,
    cmd.Turn: viewing.turn,
    cmd.ZoomTo: viewing.zoom_to,
    cmd.GoHome: viewing.go_home,
    cmd.GoBack: trail.go_back,
    cmd.GoForward: trail.go_forward,
    cmd.GoToLevel: viewing.go_to_level,
    cmd.GoToNearest: viewing.go_to_nearest,
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
    cmd.DropWish: generation.drop_wish,
    cmd.ClearQueue: generation.clear_queue,
    cmd.AddPhrase: prompting.add_phrase,
    cmd.Redo: history.redo,
    cmd.JumpInHistory: history.jump,
    cmd.ShowLevel: history.show_level,
    cmd.DeleteLevel: history.delete_level,
    cmd.DeleteHere: history.delete_here,
    cmd.RenameLevel: history.rename_level,
    cmd.BeginRename: history.begin_rename,
    cmd.EndRename: history.end_rename,
    cmd.Another: varying.another,
    cmd.OpenVariants: varying.open_variants,
    cmd.ChooseVariant: varying.choose,
    cmd.StepVariant: varying.step,
    cmd.Open: documents.open_path,
    cmd.Drop: dropping.drop,
    cmd.SettleDrop: dropping.settle_drop,
    cmd.OpenDemo: documents.open_demo,
    cmd.RemoveRecent: reopening.remove,
    cmd.ClearRecents: reopening.clear,
    cmd.AskOpen: documents.ask_open,
    cmd.Save: documents.save,
    cmd.SaveTo: documents.save_to,
    cmd.AskPicture: keeping.ask_picture,
    cmd.SavePicture: keeping.save_picture,
    cmd.SetPictureSize: shooting.set_size,
    cmd.CopyView: keeping.copy_view,
    cmd.AskFilm: keeping.ask_film,
    cmd.MakeFilm: keeping.make_film,
    cmd.CancelFilm: keeping.cancel_film,
    cmd.SetPlan: shooting.set_plan,
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
    cmd.DismissHint: hint.dismiss,
    cmd.OpenPalette: summoning.open_palette,
    cmd.ClosePalette: summoning.close_palette,
    cmd.EditPalette: summoning.edit_palette,
    cmd.MarkEntry: summoning.mark_entry,
    cmd.ToggleLog: summoning.toggle_log,
    cmd.SetLogLevel: summoning.set_log_level,
    cmd.CopyLog: summoning.copy_log,
    cmd.ChangeSettings: preferring.change_settings,
}


def apply(services: Services, state: AppState, commands: Iterable[cmd.Command]) -> AppState:
    """Carries out commands in order; a fault becomes a notice."""
    for command in commands:
        state = _guarded(HANDLERS[type(command)], services, state, command)
        state = documents.follow_listing(services, hint.after(services, state, command))
    return state


def drain(services: Services, state: AppState, budget_s: float) -> AppState:
    """Takes over what the worker made since the last frame, within a time budget."""
    try:
        events = services.client.poll(budget_s)
    except Exception as error:  # whatever the worker breaks, frames go on
        LOG.exception("poll failed")
        return state.with_toast(f"The worker cannot be reached: {error}", "error")
    for event in events:
        log_event(event)
        state = _guarded(generation.on_event, services, state, event)
    state = documents.follow_listing(services, documents.follow_errand(services, state))
    state = _guarded(documents.open_next, services, state, None)
    if generation.is_goal_reached(state):
        # Taken off first: a fault is told once, and not again every frame.
        goal, state = state.goal, replace(state, goal=None, is_goal_waiting=False)
        state = _guarded(generation.request, services, state, goal)
    return _guarded(generation.next_wish, services, state, None)


def preview(services: Services, state: AppState, dt_s: float) -> AppState:
    """Lets the timeline's preview go on for a frame."""
    return _guarded(lambda _, before, seconds: directing.play(before, seconds), services, state, dt_s)


def tick(services: Services, state: AppState, is_typing: bool) -> AppState:
    """What the app does by itself once a frame has been answered."""
    is_previewing = directing.is_previewing(state)
    state = state if is_previewing else framing.aim(trail.note_place(state))
    recovery.keep(services, state)
    state = keeping.follow_film(services, state)
    state = documents.follow_making(reopening.follow(services, state))
    if is_previewing:  # nobody has come to look: no detail is asked for
        return state
    return _guarded(auto.ask_for_detail, services, state, is_typing)


def _guarded(handler: Handler, services: Services, state: AppState, argument: object) -> AppState:
    try:
        after = handler(services, state, argument)
        log_notices(state, after)
        return after
    except Exception as error:  # the frame loop outlives every fault of a handler
        LOG.exception("%s failed", getattr(handler, "__name__", handler))
        name = getattr(handler, "__name__", "this").replace("_", " ")
        return state.with_toast(f"{name[:1].upper()}{name[1:]} failed: {error}", "error")
