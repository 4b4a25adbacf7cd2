"""Keeping what is seen: a picture at a chosen size, the view as a command, a film of the way here."""

import json
import shlex
from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.documents import ask
from wzviewer.app.filming import film_cameras, look_options
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Film
from wzviewer.core.camera import Camera
from wzviewer.core.photos import check_writable, encode_png, whole_file
from wzviewer.core.records import camera_to_json
from wzviewer.errors import WzError

FILM_SUFFIX = ".mp4"


def set_size(services: Services, state: AppState, command: cmd.SetPictureSize) -> AppState:
    """Chooses the size of pictures and films."""
    return replace(state, picture_size=command.size)


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
    suggestion = Path(state.name or "view").with_suffix(".png").name
    return ask(state, services.dialogs.ask_picture(suggestion), "picture", suggestion)


def save_picture(services: Services, state: AppState, command: cmd.SavePicture) -> AppState:
    """Writes the picture, at full quality and without panels."""
    path = command.path if command.path.suffix else command.path.with_suffix(".png")
    if not len(state.scene):
        return state.with_toast("There is no scene to take a picture of.")
    try:
        image = services.renderer.draw(sized_view(state), look=state.look).read_color8()
        with whole_file(path) as file:
            file.write(encode_png(image))
    except (WzError, OSError, ValueError) as error:
        return state.with_toast(str(error), "error")
    return state.with_toast(f"Saved {path.name}, {image.shape[1]} × {image.shape[0]}.", "done")


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
    return shlex.join([*parts, *look_options(state.look)])


# ------------------------------------------------------------------ film


def ask_film(services: Services, state: AppState, command: cmd.AskFilm) -> AppState:
    """Asks where to write the film."""
    if state.film is not None:
        return state.with_toast("A film is being made. One at a time.")
    suggestion = Path(state.name or "zoom").with_suffix(FILM_SUFFIX).name
    return ask(state, services.dialogs.ask_film(suggestion), "film", suggestion)


def make_film(services: Services, state: AppState, command: cmd.MakeFilm) -> AppState:
    """Begins the film from the photo to the view; the window goes on meanwhile."""
    path = command.path.absolute().with_suffix(FILM_SUFFIX)
    if not state.num_finished or state.film is not None:
        return state.with_toast("There is nothing to film yet.")
    try:
        check_writable(path)
    except WzError as error:
        return state.with_toast(error.line(), "error")
    view = state.view
    cameras = film_cameras(view.home, view.camera, view.focus, size_of(state))
    services.filmer.start(state.scene, cameras, path, state.look)
    return replace(state, film=Film(path, state.now_s))


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
                return state.with_toast("The film was cancelled.")
            if news.why_not:
                return state.with_toast(f"No film: {news.why_not}", "error")
            seconds = state.now_s - film.started_s
            return state.with_toast(f"{film.path.name} is ready: {seconds:.0f} s.", "done")
    return replace(state, film=film)
