"""The next picture and the next film, from what is chosen in the Keep panel."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.filming import film_cameras, natural_film_s
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.commands import cameras, films
from wzviewer.config import parse_size
from wzviewer.core.camera import Camera
from wzviewer.core.foreground import turning_point
from wzviewer.core.keyframes import KeyTrack
from wzviewer.errors import InputError

NO_KEYS = "The timeline needs two keys: L shows it, I adds this view."


def set_plan(services: Services, state: AppState, command: cmd.SetPlan) -> AppState:
    """Chooses what the next picture or film will be."""
    plan, was = command.plan, state.plan
    state = replace(state, plan=replace(plan, suffix=was.suffix))
    if plan.suffix != was.suffix:
        state = with_suffix(state, plan.suffix)
    return _with_typed_size(state) if plan.size_text != was.size_text else state


def with_suffix(state: AppState, suffix: str) -> AppState:
    """Returns the state with another kind of film, at a frame rate that it can have."""
    fps = films.GIF_FPS if suffix == ".gif" else cameras.FPS
    return replace(state, plan=replace(state.plan, suffix=suffix, fps=fps))


def set_size(services: Services, state: AppState, command: cmd.SetPictureSize) -> AppState:
    """Chooses the size of pictures and films by a button."""
    plan = replace(state.plan, size_text="", size_fault="")
    return replace(state, picture_size=command.size, plan=plan)


def _with_typed_size(state: AppState) -> AppState:
    """Takes a typed size as soon as it is one; an unfinished one changes nothing."""
    text = state.plan.size_text.strip().lower().replace("×", "x").replace(" ", "")
    if not text:
        return replace(state, picture_size=None, plan=replace(state.plan, size_fault=""))
    try:
        size = parse_size(text)
    except InputError as error:
        fault = "Type it as 1600x900" if "WxH" in error.why else error.why.capitalize()
        return replace(state, plan=replace(state.plan, size_fault=fault))
    return replace(state, picture_size=size, plan=replace(state.plan, size_fault=""))


# ------------------------------------------------------------------ film


def film_size(state: AppState) -> tuple[int, int]:
    """Returns the size of the film, px: the chosen one, or the window's; of a GIF less."""
    camera = state.view.camera
    if state.picture_size is not None:
        return state.picture_size
    size = (camera.width, camera.height)
    return films.gif_size(*size) if state.plan.suffix == ".gif" else size


def film_s(state: AppState) -> float:
    """Returns the length of the film, s."""
    plan, view = state.plan, state.view
    if plan.seconds is not None:
        return plan.seconds
    if plan.source == "keys":
        return state.timeline.path.duration_s
    return cameras.ORBIT_SECONDS if plan.source == "orbit" else natural_film_s(view.home, view.camera)


def why_no_film(state: AppState) -> str:
    """Returns why the planned film cannot be made; empty when it can."""
    if not state.num_finished:
        return "There is nothing to film yet."
    if state.plan.source == "keys" and not state.timeline.path.num_pieces:
        return NO_KEYS
    count = max(round(film_s(state) * state.plan.fps), 1)
    return films.why_not(state.plan.suffix, *film_size(state), count, state.plan.fps)


def planned_film(state: AppState) -> list[Camera]:
    """Returns the camera of every frame of the planned film."""
    plan, view, size, seconds = state.plan, state.view, film_size(state), film_s(state)
    if plan.source == "keys":
        return KeyTrack(state.timeline.path.lasting(seconds), size).cameras(plan.fps)
    if plan.source == "orbit":
        pivot = turning_point(state.scene, view.camera, view.focus)
        return cameras.swing(view.camera.resized(*size), pivot, plan.orbit_deg, plan.fps, seconds)
    return film_cameras(view.home, view.camera, view.focus, size, plan.fps, seconds)


def film_line(state: AppState) -> str:
    """Returns the film in a line: length, frames, size."""
    width, height = film_size(state)
    count = max(round(film_s(state) * state.plan.fps), 1)
    line = f"{count} frames, {width} × {height}"
    if state.plan.suffix == ".gif":
        line += f", about {films.gif_bytes(width, height, count) / 1e6:.0f} MB"
    return line
