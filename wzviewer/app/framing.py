"""Drawing the frame of the next level, and finding where Enter would go where none was drawn."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app import viewing
from wzviewer.app.aiming import closer, inside, plan_level
from wzviewer.app.region import SMALLEST_PX, Region, drawn_frame, framed
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, Goal

HINT = "Drag a frame around what should become finer. Esc leaves it."


def toggle(services: Services, state: AppState, command: cmd.ToggleRegion) -> AppState:
    """Lets the next drag draw a frame, or takes the frame away."""
    region = state.region
    if region.is_drawing or region.camera is not None:
        return replace(state, region=Region())
    if not len(state.scene):
        return state
    return replace(state, region=Region(is_drawing=True)).with_toast(HINT)


def begin_drag(services: Services, state: AppState, command: cmd.BeginDrag) -> AppState:
    """Begins a frame, or takes hold of the picture."""
    if not state.region.is_drawing or command.kind != "orbit":
        return viewing.begin_drag(services, state, command)
    at = (command.x_px, command.y_px)
    view = viewing.stopped(state.view)
    return replace(state, view=view, region=replace(state.region, start_px=at, end_px=at))


def drag_to(services: Services, state: AppState, command: cmd.DragTo) -> AppState:
    """Draws the frame on, or moves the picture."""
    if state.region.start_px is None:
        return viewing.drag_to(services, state, command)
    return replace(state, region=replace(state.region, end_px=(command.x_px, command.y_px)))


def end_drag(services: Services, state: AppState, command: cmd.EndDrag) -> AppState:
    """Takes the frame, and puts the cursor into the prompt line: what should be there?"""
    region, camera = state.region, state.view.camera
    if region.start_px is None or region.end_px is None:
        return viewing.end_drag(services, state, command)
    frame = drawn_frame(region.start_px, region.end_px, (camera.width, camera.height))
    if frame[2] < SMALLEST_PX:
        return replace(state, region=Region(is_drawing=True))
    centre = (frame[0] + frame[2] / 2, frame[1] + frame[3] / 2)
    focus = viewing.point_at(services, state, *centre)
    panels = replace(state.panels, prompt_focus=cmd.FocusPrompt().frames)
    return replace(state, region=Region(camera=framed(camera, frame), focus=focus), panels=panels)


def about(services: Services, state: AppState, x_px: float, y_px: float) -> Region:
    """Returns the frame about a place on the picture, for what is dropped there; none beside the picture."""
    camera = state.view.camera
    focus = viewing.point_at(services, state, x_px, y_px)
    goal = Goal(camera.zoomed_to_region(x_px / camera.width, y_px / camera.height, 1.0), "", focus)
    near = inside(state.scene, goal)
    return Region() if near is None else Region(camera=near.camera, focus=focus, is_of_drop=True)


def aim(state: AppState) -> AppState:
    """Finds where Enter would fly to; once for every place where the view rests."""
    view, region = state.view, state.region
    if not len(state.scene) or view.focused is not view.camera or region.is_drawing:
        return state
    aimed_for = (view.camera, state.scene.revision, region.camera)
    if region.aimed_for == aimed_for:
        return state
    camera = region.camera if region.camera is not None else view.camera
    goal = Goal(camera, "", region.focus if region.focus is not None else view.focus)
    plan = plan_level(state.scene, goal)
    near = closer(goal, plan) if plan is not None else goal
    return replace(state, region=region.with_aim(near.camera if near is not goal else None, aimed_for))
