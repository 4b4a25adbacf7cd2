"""Back and forward through the places where the view came to rest, as in a browser."""

import math
from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Place, Trail
from wzviewer.app.viewing import fly_to
from wzviewer.core.camera import Camera

NOTE_REST_S = 0.6  # a place is one where the view stays
ZOOMED = math.log(1.3)  # magnification from which on it is another place
SHIFTED = 0.25  # of the picture's width
TURNED = 1.0 - math.cos(math.radians(4.0))
MAX_PLACES = 100


def note_place(state: AppState) -> AppState:
    """Remembers where the view rests, if that is another place than the last; called every frame."""
    view = state.view
    if view.focused is not view.camera or state.now_s - view.moved_s < NOTE_REST_S:
        return state
    trail = state.trail
    if trail.places and not differs(trail.places[trail.at], view.camera):
        return state
    places = (*trail.places[: trail.at + 1], Place(view.camera, view.focus))[-MAX_PLACES:]
    return replace(state, trail=Trail(places, len(places) - 1))


def differs(place: Place, camera: Camera) -> bool:
    """Whether a camera sees another place, and not the same one a little displaced."""
    if abs(math.log(camera.focal_px / camera.width * place.camera.width / place.camera.focal_px)) > ZOOMED:
        return True
    x, y, z = camera.project(place.focus)
    was_x, was_y, _ = place.camera.project(place.focus)
    shift_x = x / camera.width - was_x / place.camera.width
    shift_y = (y - camera.height / 2) / camera.width
    shift_y -= (was_y - place.camera.height / 2) / place.camera.width
    if z <= 0 or math.hypot(shift_x, shift_y) > SHIFTED:
        return True
    return bool(1.0 - camera.rotation[2] @ place.camera.rotation[2] > TURNED)


def go_back(services: Services, state: AppState, command: cmd.GoBack) -> AppState:
    """Flies to the place before; from a place that was not noted yet, to the last one."""
    trail = state.trail
    if not trail.places:
        return state
    is_away = differs(trail.places[trail.at], _camera(state))
    return _fly(state, trail.at if is_away else trail.at - 1)


def go_forward(services: Services, state: AppState, command: cmd.GoForward) -> AppState:
    """Flies to the place that was left by going back."""
    return _fly(state, state.trail.at + 1)


def can_go_back(state: AppState) -> bool:
    """Whether there is a place before."""
    trail = state.trail
    return trail.at > 0 or (bool(trail.places) and differs(trail.places[0], _camera(state)))


def can_go_forward(state: AppState) -> bool:
    """Whether a place was left by going back."""
    return state.trail.at + 1 < len(state.trail.places)


def _fly(state: AppState, at: int) -> AppState:
    trail = state.trail
    if not 0 <= at < len(trail.places):
        return state
    place = trail.places[at]
    camera = state.view.camera
    same = (place.camera.width, place.camera.height) == (camera.width, camera.height)
    goal = place.camera if same else place.camera.resized(camera.width, camera.height)
    return fly_to(replace(state, trail=Trail(trail.places, at)), goal, place.focus)


def _camera(state: AppState) -> Camera:
    """Where the view is, or is flying to."""
    flight = state.view.flight
    return flight.end if flight is not None else state.view.camera
