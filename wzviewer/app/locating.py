"""Where the view lies in the photo, and flights to a place in it."""

from dataclasses import dataclass

import numpy as np

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.app.viewing import fly_to
from wzviewer.core.types import DoubleArray

HOME_FACTOR = 1.25  # magnification up to which all of the photo is seen anyway
NEAR_FACTOR = 8.0  # closer than that there may be nothing at another place


@dataclass(frozen=True)
class Location:
    """A part of the photo, as fractions of its width and height; it may go beyond the border."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def centre(self) -> tuple[float, float]:
        """Its middle."""
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2


def location(state: AppState) -> Location | None:
    """Returns the part of the photo that the view shows; None where it shows none of it, or all."""
    view, root = state.view, state.scene[0].camera
    if view.magnification < HOME_FACTOR or view.focus_depth <= 0:
        return None
    width, height = view.camera.width, view.camera.height
    corners = [(0, 0), (width, 0), (0, height), (width, height)]
    points = np.array([view.camera.unproject(x, y, view.focus_depth) for x, y in corners])
    seen: DoubleArray = root.project(points)
    if (seen[:, 2] <= 0).any():
        return None
    x, y = seen[:, 0] / root.width, seen[:, 1] / root.height
    # The edges of an oblique view are no rectangle: its mean one is what a reader expects.
    return Location(
        float(x[[0, 2]].mean()), float(y[:2].mean()), float(x[[1, 3]].mean()), float(y[2:].mean())
    )


def go_to_photo(services: Services, state: AppState, command: cmd.GoToPhoto) -> AppState:
    """Flies to a place in the photo, as close as one is, but not where nothing was made yet."""
    if not len(state.scene):
        return state
    view, root = state.view, state.scene[0]
    factor = min(max(view.magnification, 1.0), NEAR_FACTOR)
    x_px, y_px = command.x * root.camera.width, command.y * root.camera.height
    relief = float(
        root.relief[min(int(y_px), len(root.relief) - 1), min(int(x_px), root.relief.shape[1] - 1)]
    )
    depth = root.anchor_depth + root.frame.unit * (relief if np.isfinite(relief) else 0.0)
    point = root.camera.unproject(x_px, y_px, depth)
    home = view.home
    at_x, at_y, _ = home.project(point)
    camera = home.zoomed_to_region(float(at_x) / home.width, float(at_y) / home.height, factor)
    return fly_to(state, camera, point)
