"""What a file dialog, or the line that stands in for it, was answered."""

import os
from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.directing import PATH_SUFFIX, open_camera_path, save_camera_path
from wzviewer.app.documents import SCENE_SUFFIX, edit_path, open_path, save_to, without_dialog
from wzviewer.app.keeping import make_film, save_picture
from wzviewer.app.listing import matching
from wzviewer.app.services import Services
from wzviewer.app.state import AppState

REPLACE = "Save once more to replace it."


def confirm_path(services: Services, state: AppState, command: cmd.ConfirmPath) -> AppState:
    """Takes the path of the text dialog."""
    kind, text = state.panels.dialog, state.panels.dialog_path.strip()
    if not text:
        return without_dialog(state)
    path = _meant(state, Path(text).expanduser())
    if kind.startswith("open") and path.is_dir():
        return edit_path(services, state, cmd.EditPath(str(path).rstrip(os.sep) + os.sep))
    note = note_on(kind, path, state)
    if note and note != state.panels.dialog_note:
        return replace(state, panels=replace(state.panels, dialog_note=note))
    if note and not note.endswith(REPLACE):
        return state  # nothing has changed: it is as wrong as before
    return answered(services, without_dialog(state), kind, path)


def _meant(state: AppState, path: Path) -> Path:
    """The path that was typed, or what the list has narrowed down to when nothing has that name."""
    found = state.panels.dialog_list
    if found is None or path.exists():
        return path
    found = matching(found, state.panels.dialog_path)
    names = (*found.folders, *found.files)
    return found.folder / names[0] if len(names) == 1 else path


def note_on(kind: str, path: Path, state: AppState) -> str:
    """Returns why the text dialog stays open; a file that would be replaced is asked about once."""
    if kind.startswith("open"):
        return _missing(path)
    target = path if path.suffix else path.with_suffix(_usual_suffix(kind, state))
    if target.is_dir():
        return f"{path.name} is a folder: name a file in it."
    if not target.parent.is_dir():
        return f"There is no folder {target.parent}."
    is_own = kind == "save" and target == state.path
    return f"{target.name} is there already. {REPLACE}" if target.exists() and not is_own else ""


def _missing(path: Path) -> str:
    if path.exists():
        return ""
    where = next(folder for folder in path.absolute().parents if folder.is_dir())
    return (
        f"There is no {path.name} in {where}." if where == path.absolute().parent else f"There is no {path}."
    )


def _usual_suffix(kind: str, state: AppState) -> str:
    usual = {"save": SCENE_SUFFIX, "picture": ".png", "save path": PATH_SUFFIX}
    return usual.get(kind, state.plan.suffix)


def answered(services: Services, state: AppState, kind: str, path: Path) -> AppState:
    """Carries out the answer of a dialog."""
    if kind == "open":
        return open_path(services, state, cmd.Open(path))
    if kind == "save":
        return save_to(services, state, cmd.SaveTo(path))
    if kind == "film":
        return make_film(services, state, cmd.MakeFilm(path))
    if kind == "open path":
        return open_camera_path(services, state, cmd.OpenCameraPath(path))
    if kind == "save path":
        return save_camera_path(services, state, cmd.SaveCameraPath(path))
    return save_picture(services, state, cmd.SavePicture(path)) if kind == "picture" else state
