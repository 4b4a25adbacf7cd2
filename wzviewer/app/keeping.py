"""Keeping what is seen: a picture at a chosen size, the view as a command, a film of the way here."""

import json
import shlex
from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.documents import ask
from wzviewer.app.filming import look_options
from wzviewer.app.folders import suggested
from wzviewer.app.services import Services
from wzviewer.app.shooting import planned_film, why_no_film, with_suffix
from wzviewer.app.state import AppState, Film
from wzviewer.commands import films
from wzviewer.core.camera import Camera
from wzviewer.core.photos import check_writable, encode_png, whole_file
from wzviewer.core.records import camera_to_json
from wzviewer.errors import WzError

AT_ONCE_PIXELS = 4_000_000  # larger pictures are made beside the window


def size_of(state: AppState) -> tuple[int, int]:
    """Returns the size of pictures and films, px: the chosen one, or the window's."""
    camera = state.view.camera
    return state.picture_size or (camera.width, camera.height)


def sized_view(state: AppState) -> Camera:
    """Returns the view at the size of pictures."""
    camera, size = state.view.camera, size_of(state)
    return camera if size == (camera.width, camera.height) else camera.resized(*size)


def ask_picture(services: Services, state: AppState, command: cmd.AskPicture) -> AppState:
    """Asks where to write the picture."""
    suggestion = suggested(state, "view", ".png")
    return ask(state, services.dialogs.ask_picture(suggestion), "picture", suggestion)


def save_picture(services: Services, state: AppState, command: cmd.SavePicture) -> AppState:
    """Writes the picture, at full quality and without panels."""
    path = command.path if command.path.suffix else command.path.with_suffix(".png")
    if not len(state.scene):
        return state.with_toast("There is no scene to take a picture of.")
    camera = sized_view(state)
    if camera.width * camera.height > AT_ONCE_PIXELS and state.look.mode == "picture":
        return _large_picture(services, state, camera, path.absolute())
    try:
        image = services.renderer.picture(camera, state.look, state.plan.is_transparent)
        with whole_file(path) as file:
            file.write(encode_png(image))
    except MemoryError:
        return state.with_toast("There is not enough memory for a picture of this size.", "error")
    except (WzError, OSError, ValueError) as error:
        return state.with_toast(str(error), "error")
    clear = ", without a background" if image.shape[2] == 4 else ""
    return state.with_toast(f"Saved {path.name}, {image.shape[1]} × {image.shape[0]}{clear}.", "done")


def _large_picture(services: Services, state: AppState, camera: Camera, path: Path) -> AppState:
    """Begins a picture that would hold up the window for seconds."""
    if state.film is not None:
        return state.with_toast("A film is being made: a picture of this size has to wait for it.")
    try:
        check_writable(path)
    except WzError as error:
        return state.with_toast(error.line(), "error")
    services.filmer.start_picture(state.scene, camera, path, state.look, state.plan.is_transparent)
    return replace(state, film=Film(path, state.clock_s, is_picture=True))


def copy_view(services: Services, state: AppState, command: cmd.CopyView) -> AppState:
    """Puts the command line that renders the view on the clipboard."""
    if state.path is None:
        return state.with_toast("Save the scene first: the command needs its file.")
    services.copy(view_command(state, state.path))
    missing = " It does not have the levels made since the last save." if state.is_dirty else ""
    return state.with_toast(f"Copied: wzviewer render {state.path.name} …{missing}", "done")


def view_command(state: AppState, path: Path) -> str:
    """Returns the ``wzviewer render`` line that draws the view from a file."""
    camera = json.dumps(camera_to_json(sized_view(state)), separators=(",", ":"))
    parts = ["wzviewer", "render", str(path.absolute()), "-o", "view.png", "--camera", camera]
    parts += ["--transparent"] if state.plan.is_transparent else []
    return shlex.join([*parts, *look_options(state.look)])


# ------------------------------------------------------------------ film


def ask_film(services: Services, state: AppState, command: cmd.AskFilm) -> AppState:
    """Asks where to write the film."""
    if state.film is not None:
        return state.with_toast("A film is being made. One at a time.")
    reason = why_no_film(state)
    if reason:
        return state.with_toast(reason[:1].upper() + reason[1:].rstrip(".") + ".")
    suggestion = suggested(state, "zoom", state.plan.suffix)
    return ask(state, services.dialogs.ask_film(suggestion), "film", suggestion)


def make_film(services: Services, state: AppState, command: cmd.MakeFilm) -> AppState:
    """Begins the planned film; the window goes on meanwhile."""
    path = command.path.absolute()
    kind = path.suffix.lower()
    if kind in films.SUFFIXES and kind != state.plan.suffix:  # the dialog's answer has the last word
        state = with_suffix(state, kind)
    path = path if kind in films.SUFFIXES else path.with_name(path.name + state.plan.suffix)
    reason = "A film is being made." if state.film is not None else why_no_film(state)
    if reason:
        return state.with_toast(f"No film: {reason.rstrip('.')}.", "error")
    try:
        check_writable(path)
    except WzError as error:
        return state.with_toast(error.line(), "error")
    services.filmer.start(state.scene, planned_film(state), path, state.look, state.plan.fps)
    return replace(state, film=Film(path, state.clock_s))


def cancel_film(services: Services, state: AppState, command: cmd.CancelFilm) -> AppState:
    """Ends the film."""
    if state.film is None:
        return state
    services.filmer.cancel()
    return replace(state, film=replace(state.film, is_cancelling=True))


def follow_film(services: Services, state: AppState) -> AppState:
    """Takes over how the film goes; called every frame."""
    film = state.film
    if film is None:
        return state
    for news in services.filmer.poll():
        film = replace(film, fraction=news.fraction)
        if news.is_over:
            state = replace(state, film=None)
            if news.is_cancelled:
                return state.with_toast(f"The {film.kind} was cancelled.")
            if news.why_not:
                return state.with_toast(f"No {film.kind}: {news.why_not}", "error")
            seconds = state.clock_s - film.started_s
            return state.with_toast(f"{film.path.name} is ready: {seconds:.0f} s.", "done")
    return replace(state, film=film)
