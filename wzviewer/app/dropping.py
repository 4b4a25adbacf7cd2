"""A file that is dropped on the window: opened, or put into the picture that is open."""

from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app import framing
from wzviewer.app.documents import open_path, run_errand, without_dialog
from wzviewer.app.errands import Errand
from wzviewer.app.generation import ask_at, goal_here
from wzviewer.app.listing import PHOTOS
from wzviewer.app.region import Region
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.core.photos import load_cutout

QUESTIONS = ("unsaved", "making", "recover")  # what a file that is dropped must not answer
IMAGE_SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".webp"})


def drop(services: Services, state: AppState, command: cmd.Drop) -> AppState:
    """Opens a file, or asks whether a picture is to go into the one that is open."""
    if command.path.suffix.lower() not in PHOTOS and command.path.is_file():
        reason = f"{command.path.name} is neither a photo nor a scene of wzviewer."
        return state.with_toast(reason, "error")
    if state.panels.dialog in QUESTIONS:
        return state.with_toast(f"First the question, please: then drop {command.path.name} once more.")
    state = without_dialog(replace(state, after=None))
    is_image = command.path.suffix.lower() in IMAGE_SUFFIXES and command.path.is_file()
    if not is_image or not len(state.scene):
        return open_path(services, state, cmd.Open(command.path))
    if command.at_px is not None and state.region.camera is None and state.view.flight is None:
        state = replace(state, region=framing.about(services, state, *command.at_px))
    return replace(state, panels=replace(state.panels, dialog="drop", dialog_path=str(command.path)))


def settle_drop(services: Services, state: AppState, command: cmd.SettleDrop) -> AppState:
    """Carries out the answer: opens the picture, or makes a level with it in the middle."""
    path, region = Path(state.panels.dialog_path), replace(state.region, is_of_drop=False)
    if command.answer == "open":
        return open_path(services, without_dialog(state), cmd.Open(path))
    asked = replace(without_dialog(state), region=region)
    goal = replace(goal_here(services, asked), prompt=path.stem)
    errand = Errand(
        f"Reading {path.name}",
        lambda services, state, cutout: ask_at(
            services, replace(state, region=region), replace(goal, cutout=cutout)
        ),
        lambda services, state, line: replace(state.with_toast(line, "error"), region=Region()),
    )
    # Another file is being read or written: the question stands until that has ended.
    return run_errand(services, asked if state.errand is None else state, errand, lambda: load_cutout(path))
