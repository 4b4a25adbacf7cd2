"""The timeline: keys from the present view, their times, and the preview of the film in the window."""

from dataclasses import replace
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.documents import ask
from wzviewer.app.folders import beginning
from wzviewer.app.places import level_here
from wzviewer.app.services import Services
from wzviewer.app.shooting import film_size
from wzviewer.app.state import AppState
from wzviewer.app.timeline import (
    natural_s,
    path_of_file,
    with_key,
    with_pace,
    with_seconds,
    with_time,
    with_view,
    without_key,
)
from wzviewer.core.camera import Camera
from wzviewer.core.foreground import turning_point
from wzviewer.core.keyframes import MAX_KEYS, Key, KeyPath, KeyTrack, swing
from wzviewer.core.navigation import ZoomSpring
from wzviewer.core.path_files import read_path_file, write_path
from wzviewer.core.types import DoubleArray
from wzviewer.errors import WzError

PATH_SUFFIX = ".json"
ORBIT_S = 4.0


def add_key(services: Services, state: AppState, command: cmd.AddKey) -> AppState:
    """Makes the present view a key, at the moment that is shown or at the end."""
    if not len(state.scene):
        return state
    line = state.timeline
    if len(line.path.keys) >= MAX_KEYS:
        return state.with_toast(f"A path has at most {MAX_KEYS} keys.", "error")
    path, index = with_key(line.path, state.view.camera, _focus(state), line.at_s)
    state = with_path(opened(state), path, index)
    return _at(state, path.times_s[index])


def update_key(services: Services, state: AppState, command: cmd.UpdateKey) -> AppState:
    """Gives the selected key the present view."""
    line = state.timeline
    if line.selected is None:
        return state.with_toast("Select a key of the timeline first.")
    path = with_view(line.path, line.selected, state.view.camera, _focus(state))
    return _at(with_path(state, path, line.selected), path.times_s[line.selected])


def delete_key(services: Services, state: AppState, command: cmd.DeleteKey) -> AppState:
    """Removes the selected key."""
    line = state.timeline
    if line.selected is None or not state.panels.timeline:
        return state
    path = without_key(line.path, line.selected)
    return with_path(state, path, min(line.selected, len(path.keys) - 1) if path.keys else None)


def select_key(services: Services, state: AppState, command: cmd.SelectKey) -> AppState:
    """Goes to a key."""
    line, index = state.timeline, command.index
    if index is None or not 0 <= index < len(line.path.keys):
        return replace(state, timeline=replace(line, selected=None))
    state = replace(state, timeline=replace(line, selected=index, is_playing=False))
    return shown(state, line.path.times_s[index])


def step_key(services: Services, state: AppState, command: cmd.StepKey) -> AppState:
    """Goes to the next or the previous key from the moment that is shown."""
    line = state.timeline
    times = line.path.times_s if line.path.keys else ()
    ahead = [i for i, t in enumerate(times) if (t - line.at_s) * command.step > 1e-6]
    if not ahead or not state.panels.timeline:
        return state
    return select_key(services, state, cmd.SelectKey(ahead[0 if command.step > 0 else -1]))


def retime_key(services: Services, state: AppState, command: cmd.RetimeKey) -> AppState:
    """Reaches a key at another moment; shows it there."""
    line = state.timeline
    if not 1 <= command.index <= line.path.num_pieces:
        return state
    path = with_time(line.path, command.index, min(command.time_s, line.span_s))
    line = line.retimed(path, (*path.times_s, path.duration_s)[command.index], command.is_done)
    return replace(state, timeline=line)


def set_key_seconds(services: Services, state: AppState, command: cmd.SetKeySeconds) -> AppState:
    """Takes another time from a key to the next."""
    line = state.timeline
    path = with_seconds(line.path, command.index, command.seconds)
    line = line.retimed(path, path.times_s[command.index], command.is_done)
    return replace(state, timeline=line)


def set_key_pace(services: Services, state: AppState, command: cmd.SetKeyPace) -> AppState:
    """Goes through a key in another way."""
    path = with_pace(state.timeline.path, command.index, command.pace)
    return with_path(state, path, state.timeline.selected)


def toggle_loop(services: Services, state: AppState, command: cmd.ToggleLoop) -> AppState:
    """Leads the last key to the first, or not."""
    path = state.timeline.path
    return with_path(state, replace(path, is_loop=not path.is_loop), state.timeline.selected)


# ------------------------------------------------------------------ preview


def scrub_to(services: Services, state: AppState, command: cmd.ScrubTo) -> AppState:
    """Shows a moment of the path."""
    line = state.timeline
    if not line.path.keys:
        return state
    time_s = min(max(command.time_s, 0.0), line.path.duration_s)
    return shown(replace(state, timeline=replace(line, selected=None, is_playing=False)), time_s)


def toggle_play(services: Services, state: AppState, command: cmd.TogglePlay) -> AppState:
    """Lets the preview run, from the start when it is at the end."""
    line = state.timeline
    if not line.path.num_pieces:
        is_asked = state.panels.timeline and len(state.scene) > 0
        return state.with_toast("Two keys make a film: I adds the view.") if is_asked else state
    if line.is_playing:
        return replace(state, timeline=replace(line, is_playing=False))
    at_s = 0.0 if line.at_s >= line.path.duration_s - 1e-6 else line.at_s
    state = replace(opened(state), timeline=replace(line, is_playing=True, selected=None))
    return shown(state, at_s)


def play(state: AppState, dt_s: float) -> AppState:
    """Lets time go on; called every frame.  A hand on the camera stops it."""
    line = state.timeline
    if not line.is_playing:
        return state
    if state.view.camera is not line.shown:
        return replace(state, timeline=replace(line, is_playing=False))
    at_s, length_s = line.at_s + dt_s, line.path.duration_s
    if line.path.is_loop:
        return shown(state, at_s % length_s)
    is_over = at_s >= length_s
    state = replace(state, timeline=replace(line, is_playing=not is_over))
    return shown(state, min(at_s, length_s))


def shown(state: AppState, time_s: float) -> AppState:
    """Returns the state with the view of a moment."""
    view = state.view
    camera, focus = state.timeline.camera_at(time_s, (view.camera.width, view.camera.height))
    state = replace(state, timeline=replace(state.timeline, at_s=time_s, shown=camera))
    return state.with_view(
        replace(view, camera=camera, focus=focus, flight=None, drag=None, spring=ZoomSpring())
    )


def is_previewing(state: AppState) -> bool:
    """Whether the view is the timeline's and not the user's."""
    return state.panels.timeline and state.timeline.shown is state.view.camera


# ------------------------------------------------------------------ keys to begin with


def fill_keys(services: Services, state: AppState, command: cmd.FillKeys) -> AppState:
    """Replaces the keys by those of the way here, of the levels, or of an orbit."""
    if not len(state.scene):
        return state
    path = {"way": _way, "levels": _levels, "orbit": _orbit}[command.source](state)
    if path is None:
        return state.with_toast("This view is the whole picture: zoom in first.")
    at_s = 0.0 if path.is_loop else path.duration_s  # where the view is
    return _at(with_path(opened(state), path, None), at_s)


def clear_keys(services: Services, state: AppState, command: cmd.ClearKeys) -> AppState:
    """Removes all keys."""
    return with_path(state, KeyPath(is_loop=state.timeline.path.is_loop), None)


def bring_back_keys(services: Services, state: AppState, command: cmd.BringBackKeys) -> AppState:
    """Takes back the last change of the keys."""
    past = state.timeline.past
    if not past:
        return state
    line = replace(state.timeline, path=past[-1], past=past[:-1], selected=None, is_playing=False)
    line = replace(line, at_s=min(line.at_s, line.path.duration_s)).fitted()
    return _with_source(state, replace(state, timeline=line))


def _way(state: AppState) -> KeyPath | None:
    view = state.view
    if view.camera.key == view.home.key:
        return None
    return _timed([(view.home, view.focus), (view.camera, view.focus)])


def _levels(state: AppState) -> KeyPath | None:
    """Home, then every level down to where one is, then the view itself."""
    view, scene = state.view, state.scene
    size = (view.camera.width, view.camera.height)
    levels = [scene[i] for i in scene.path(level_here(state))[1:]]
    stops = [(view.home, view.focus)]
    stops += [(level.camera.resized(*size), level.frame.origin) for level in levels]
    if len(stops) < 2:
        return _way(state)
    return _timed(stops)


def _orbit(state: AppState) -> KeyPath:
    pivot = turning_point(state.scene, state.view.camera, _focus(state))
    return swing(state.view.camera, pivot, state.plan.orbit_deg, ORBIT_S)


def _timed(stops: list[tuple[Camera, DoubleArray]]) -> KeyPath:
    """A path through views, each piece with its natural time."""
    cameras = [camera for camera, _ in stops]
    waits = [natural_s(a, b) for a, b in zip(cameras, [*cameras[1:], cameras[0]], strict=True)]
    return KeyPath(tuple(Key(*stop, wait) for stop, wait in zip(stops, waits, strict=True)))


def plan_keys_film(services: Services, state: AppState, command: cmd.PlanKeysFilm) -> AppState:
    """Shows the Keep panel, with a film through the keys."""
    panels = replace(state.panels, keep=True, settings=False)
    plan = replace(state.plan, tab="film", source="keys", seconds=None)
    return replace(state, panels=panels, plan=plan)


# ------------------------------------------------------------------ files


def ask_path(services: Services, state: AppState, command: cmd.AskPath) -> AppState:
    """Asks for a camera path to open, or where to write one."""
    if command.is_opening:
        folder = str(beginning(state))
        return ask(state, services.dialogs.ask_path(folder, is_opening=True), "open path", folder)
    if not state.timeline.path.keys:
        return state.with_toast("The timeline has no keys to write.")
    name = Path(state.name or "film").stem + "-path" + PATH_SUFFIX
    suggestion = str(beginning(state) / name)
    return ask(state, services.dialogs.ask_path(suggestion, is_opening=False), "save path", suggestion)


def open_camera_path(services: Services, state: AppState, command: cmd.OpenCameraPath) -> AppState:
    """Takes over the keys of a file."""
    if not len(state.scene):
        return state.with_toast("Open a photo or a scene first.")
    try:
        found = read_path_file(command.path)
    except WzError as error:
        return state.with_toast(error.line(), "error")
    path = path_of_file(found, found.fps or state.plan.fps)
    state = _at(with_path(opened(state), path, None), 0.0)
    what = f"{len(path.keys)} keys, {path.duration_s:.1f} s"
    sampled = "" if found.keys.keys else f", from {len(found.frames)} frames"
    return state.with_toast(f"Opened {command.path.name}: {what}{sampled}.", "done")


def save_camera_path(services: Services, state: AppState, command: cmd.SaveCameraPath) -> AppState:
    """Writes the keys and all frames to a file."""
    path = command.path if command.path.suffix else command.path.with_suffix(PATH_SUFFIX)
    keys, fps = state.timeline.path, state.plan.fps
    try:
        write_path(path, keys, KeyTrack(keys, film_size(state)).cameras(fps), fps)
    except (WzError, OSError, ValueError) as error:
        return state.with_toast(str(error), "error")
    return state.with_toast(f"Saved {path.name}: nerfstudio reads it, too.", "done")


# ------------------------------------------------------------------ parts


def with_path(state: AppState, path: KeyPath, selected: int | None) -> AppState:
    """Returns the state with other keys."""
    return _with_source(state, replace(state, timeline=state.timeline.edited(path, selected)))


def _with_source(before: AppState, after: AppState) -> AppState:
    """The next film is the timeline's as soon as its keys make one, and no longer once they do not."""
    had, has = (state.timeline.path.num_pieces > 0 for state in (before, after))
    if had == has or not (has or after.plan.source == "keys"):
        return after
    return replace(after, plan=replace(after.plan, source="keys" if has else "way", seconds=None))


def opened(state: AppState) -> AppState:
    """Returns the state with the timeline on the screen."""
    return replace(state, panels=replace(state.panels, timeline=True))


def _at(state: AppState, time_s: float) -> AppState:
    """The moment that is shown, without moving the view."""
    line = state.timeline
    return replace(state, timeline=replace(line, at_s=time_s))


def _focus(state: AppState) -> DoubleArray:
    """What is looked at; straight ahead where that lies behind."""
    view = state.view
    if view.focus_depth > 0:
        return view.focus
    return view.camera.unproject(view.camera.width / 2, view.camera.height / 2, 1.0)
