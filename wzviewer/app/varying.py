"""Variants: another of a level, with another seed; which of them is seen; several at once."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.generation import ask
from wzviewer.app.history import changed
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Goal
from wzviewer.app.variants import CUTOUT, can_vary, group_of, newest

MAX_COUNT = 4  # asked for at once


def another(services: Services, state: AppState, command: cmd.Another) -> AppState:
    """Asks for a level again, with another seed."""
    index = command.index if command.index is not None else _present(state)
    if index is None or not can_vary(state.scene, index):
        return state.with_toast(_why_none(state, index))
    level = state.scene[index]
    count = min(max(command.count, 1), MAX_COUNT)
    goal = Goal(level.camera, level.prompt, level.frame.origin, count, like=index)
    return replace(ask(services, state, goal), variants=index)


def _why_none(state: AppState, index: int | None) -> str:
    """Why there can be no other of a level."""
    if index is not None and 0 < index < len(state.scene) and CUTOUT in state.scene[index].notes:
        return "A picture that was put in has no variants: it would be the same again."
    return "There is no level here to make another of."


def open_variants(services: Services, state: AppState, command: cmd.OpenVariants) -> AppState:
    """Shows the variants of a level side by side, or no longer."""
    return replace(state, variants=command.index)


def choose(services: Services, state: AppState, command: cmd.ChooseVariant) -> AppState:
    """Shows one of the variants, and hides the others."""
    scene, index = state.scene, command.index
    if not 0 < index < len(scene) or not scene.is_committed(index):
        return state
    marks = {
        i: replace(scene.mark(i), sight="shown" if i == index else "hidden") for i in group_of(scene, index)
    }
    return replace(changed(services, state, "choose", index, marks), variants=index)


def _present(state: AppState) -> int | None:
    """The level that is meant where none is named: of the strip that is open, or the newest."""
    index = state.variants
    if index is None or not index < len(state.scene) or not group_of(state.scene, index):
        return newest(state.scene)
    shown = [i for i in group_of(state.scene, index) if state.scene.mark(i).sight == "shown"]
    return shown[-1] if shown else index


def step(services: Services, state: AppState, command: cmd.StepVariant) -> AppState:
    """Shows the next or the previous variant; after the last comes the first."""
    index = _present(state)
    if index is None:
        return state.with_toast("There is no level here to make another of.")
    group = group_of(state.scene, index)
    shown = [k for k, i in enumerate(group) if state.scene.mark(i).sight == "shown"]
    if len(group) < 2:
        return state.with_toast("There is one only. N makes another.")
    at = shown[-1] if shown else 0
    return choose(services, state, cmd.ChooseVariant(group[(at + command.step) % len(group)]))
