"""Line 8 of Algorithm 1: commands that move C_render, and the motions that go on by themselves."""

import math
from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.picking import world_point
from wzviewer.app.places import level_here
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Drag, View, fitted
from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.foreground import BACKDROP, foreground_depth, is_sky
from wzviewer.core.navigation import Flight, ZoomSpring
from wzviewer.core.types import DoubleArray

ORBIT_RAD = math.radians(70.0)  # a drag across the width of the window
CLICK_FACTOR = 2.83  # double click: half a level
OUT_LIMIT = 0.25  # smallest magnification
FLY_DEPTH = 3.0  # world units; at the pace of the sky one would be below the ground in a tenth of a second
IN_LIMIT = 8.0**13.5  # float64 holds a pixel to a tenth there; the deepest level made is far above


def advance(state: AppState, dt_s: float) -> AppState:
    """Lets the running motions go on for a frame."""
    view = state.view
    if view.flight is not None:
        flight = view.flight.advanced(dt_s)
        view = replace(view, camera=flight.camera, flight=None if flight.is_over else flight)
    elif not view.spring.is_resting:
        spring, camera = view.spring.advanced(view.camera, dt_s)
        view = replace(view, camera=camera, spring=spring)
    return state.with_view(view)


def refocus(services: Services, state: AppState) -> AppState:
    """Looks where the view has come to rest: what lies at its centre is the new focus."""
    view = state.view
    if state.is_moving or not len(state.scene) or view.focused is view.camera:
        return state
    focus = point_at(services, state, view.camera.width / 2, view.camera.height / 2)
    return replace(state, view=replace(view, focus=focus, focused=view.camera))


def zoom(services: Services, state: AppState, command: cmd.Zoom) -> AppState:
    """Turns the wheel: the pixel under the cursor keeps its place."""
    view = replace(state.view, flight=None)
    spring = view.spring.turned(command.x_px, command.y_px, command.notches)
    limit = OUT_LIMIT if command.notches < 0 else IN_LIMIT
    room = math.log(limit / view.magnification)
    if (spring.log_factor - room) * command.notches > 0:  # beyond the limit: go there and no further
        spring = replace(spring, log_factor=room)
    if state.settings.reduced_motion:
        camera = view.camera.zoomed(command.x_px, command.y_px, math.exp(spring.log_factor))
        return state.with_view(replace(view, camera=camera, spring=ZoomSpring()))
    return state.with_view(replace(view, spring=spring))


def begin_drag(services: Services, state: AppState, command: cmd.BeginDrag) -> AppState:
    """Takes hold of the point under the cursor.

    A hand on the sky beside a flower wants to see the flower from the side: what lies far behind the middle
    of the view is turned at the depth that is there, where turning about itself would throw it out of sight.
    """
    view, camera = state.view, state.view.camera
    pivot = point_at(services, state, command.x_px, command.y_px)
    if command.kind == "orbit":
        near = _near_depth(services, state, pivot)
        if float(camera.to_camera(pivot)[2]) > BACKDROP * near > 0:
            pivot = camera.unproject(command.x_px, command.y_px, near)
    drag = Drag(command.kind, view.camera, pivot, command.x_px, command.y_px)
    return state.with_view(replace(view, drag=drag, focus=pivot, flight=None, spring=ZoomSpring()))


def _near_depth(services: Services, state: AppState, pivot: DoubleArray) -> float:
    """Returns the depth of what one looks at: of the middle of the view, of its foreground from the sky."""
    view, camera = state.view, state.view.camera
    middle = view.focus  # at rest it has been found already
    if view.focused is not camera:
        middle = point_at(services, state, camera.width / 2, camera.height / 2)
    near = float(camera.to_camera(middle)[2])
    if is_sky(state.scene, pivot):  # and so may be the middle
        near = min(near, foreground_depth(state.scene, camera))
    return near


def drag_to(services: Services, state: AppState, command: cmd.DragTo) -> AppState:
    """Turns or shifts the picture from where it was taken hold of."""
    drag = state.view.drag
    if drag is None:
        return state
    dx, dy = command.x_px - drag.x_px, command.y_px - drag.y_px
    if drag.kind == "pan":
        camera = navigation.panned(drag.camera, dx, dy)
    else:
        per_px = ORBIT_RAD / drag.camera.width
        camera = navigation.orbited(drag.camera, drag.pivot, dx * per_px, dy * per_px)
    return state.with_view(replace(state.view, camera=camera))


def end_drag(services: Services, state: AppState, command: cmd.EndDrag) -> AppState:
    """Lets go."""
    return state.with_view(replace(state.view, drag=None))


def fly(services: Services, state: AppState, command: cmd.Fly) -> AppState:
    """Flies for a frame; the focus is what lies ahead."""
    view = state.view
    steps = (command.right, command.down, command.forward)
    depth = min(view.focus_depth, FLY_DEPTH)
    camera = navigation.flown(view.camera, steps, command.dt_s, depth, view.magnification)
    return state.with_view(replace(view, camera=camera, flight=None, spring=ZoomSpring()))


def turn(services: Services, state: AppState, command: cmd.Turn) -> AppState:
    """Looks around for a frame; the focus is what lies ahead."""
    view = state.view
    camera = navigation.turned(view.camera, command.right * command.dt_s, command.down * command.dt_s)
    return state.with_view(replace(view, camera=camera, flight=None, spring=ZoomSpring()))


def zoom_to(services: Services, state: AppState, command: cmd.ZoomTo) -> AppState:
    """Flies to a pixel and closer."""
    view = state.view
    focus = point_at(services, state, command.x_px, command.y_px)
    camera = view.camera
    centre = (camera.width / 2, camera.height / 2)
    moved = navigation.panned(camera, centre[0] - command.x_px, centre[1] - command.y_px)
    return fly_to(state, moved.zoomed(*centre, CLICK_FACTOR), focus)


def go_home(services: Services, state: AppState, command: cmd.GoHome) -> AppState:
    """Flies to the whole picture."""
    return fly_to(state, state.view.home, state.view.focus)


def go_to_level(services: Services, state: AppState, command: cmd.GoToLevel) -> AppState:
    """Flies to the camera of a level."""
    if not 0 <= command.index < len(state.scene):
        return state
    level = state.scene[command.index]
    view = state.view
    if level.parent is None:
        return go_home(services, state, cmd.GoHome())
    camera = fitted(level.camera, view.camera.width, view.camera.height)
    deeper = camera.focal_px > view.camera.focal_px
    return fly_to(state, camera, level.frame.origin if deeper else view.focus)


def go_to_nearest(services: Services, state: AppState, command: cmd.GoToNearest) -> AppState:
    """Flies to the camera of the level that the view is in."""
    return go_to_level(services, state, cmd.GoToLevel(level_here(state))) if len(state.scene) else state


def fly_to(state: AppState, camera: Camera, focus: DoubleArray) -> AppState:
    """Starts a flight about a point that both cameras have in front of them."""
    start = state.view.camera
    if state.settings.reduced_motion:
        view = replace(state.view, camera=camera, flight=None, spring=ZoomSpring(), drag=None, focus=focus)
        return state.with_view(view)
    if start.to_camera(focus)[2] <= 0 or camera.to_camera(focus)[2] <= 0:
        return state.with_view(replace(state.view, camera=camera, flight=None))
    flight = Flight.between(start, camera, focus)
    view = replace(state.view, flight=flight, spring=ZoomSpring(), drag=None, focus=focus)
    return state.with_view(view)


def stopped(view: View) -> View:
    """Returns the view without its motions."""
    return replace(view, flight=None, spring=ZoomSpring(), drag=None)


def resize(services: Services, state: AppState, command: cmd.Resize) -> AppState:
    """Keeps the view when the window changes."""
    width, height = max(command.width, 1), max(command.height, 1)
    view = state.view
    if (view.camera.width, view.camera.height) == (width, height):
        return state
    base = state.scene[0].camera if len(state.scene) else view.home
    home = fitted(base, width, height)
    if view.camera is view.home and view.flight is None:
        camera = home
    else:
        camera = view.camera.resized(width, height)
    return state.with_view(View(camera, home, view.focus))


def point_at(services: Services, state: AppState, x_px: float, y_px: float) -> DoubleArray:
    """Returns the world point (3,) under a pixel of the window."""
    view = state.view
    depth = view.focus_depth if view.focus_depth > 0 else 1.0
    return world_point(state.scene, services.renderer, view.camera, x_px, y_px, depth)
