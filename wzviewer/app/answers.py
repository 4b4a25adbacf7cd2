"""What a file dialog, or the line that stands in for it, was answered."""

from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.directing import open_camera_path, save_camera_path
from wzviewer.app.documents import open_path, save_to, without_dialog
from wzviewer.app.keeping import make_film, save_picture
from wzviewer.app.services import Services
from wzviewer.app.state import AppState


def confirm_path(services: Services, state: AppState, command: cmd.ConfirmPath) -> AppState:
    """Takes the path of the text dialog."""
    kind, text = state.panels.dialog, state.panels.dialog_path.strip()
    state = without_dialog(state)
    return answered(services, state, kind, Path(text).expanduser()) if text else state


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
