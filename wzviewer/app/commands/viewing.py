"""What may be asked of the camera and of how the scene is drawn."""

from dataclasses import dataclass
from typing import Literal

from wzviewer.app.commands.base import Command
from wzviewer.app.look import Look


@dataclass(frozen=True)
class Zoom(Command):
    """Turn the wheel over a pixel; positive is closer."""

    x_px: float
    y_px: float
    notches: float


@dataclass(frozen=True)
class BeginDrag(Command):
    """Take hold of the picture at a pixel."""

    kind: Literal["orbit", "pan"]
    x_px: float
    y_px: float


@dataclass(frozen=True)
class DragTo(Command):
    """Move the hand that holds the picture."""

    x_px: float
    y_px: float


@dataclass(frozen=True)
class EndDrag(Command):
    """Let go."""


@dataclass(frozen=True)
class Fly(Command):
    """Hold direction keys for a frame of ``dt_s`` seconds; each step in about [-1, 1]."""

    right: float
    down: float
    forward: float
    dt_s: float


@dataclass(frozen=True)
class Turn(Command):
    """Hold keys that look around for a frame of ``dt_s`` seconds; each step in about [-1, 1]."""

    right: float
    down: float
    dt_s: float


@dataclass(frozen=True)
class ZoomTo(Command):
    """Fly to a pixel and closer (double click)."""

    x_px: float
    y_px: float


@dataclass(frozen=True)
class GoHome(Command):
    """Fly to the whole picture."""


@dataclass(frozen=True)
class GoBack(Command):
    """Fly to the place before."""


@dataclass(frozen=True)
class GoForward(Command):
    """Fly to the place that was left by going back."""


@dataclass(frozen=True)
class GoToLevel(Command):
    """Fly to the camera of a level."""

    index: int


@dataclass(frozen=True)
class GoToNearest(Command):
    """Fly to the camera of the level that one is in."""


@dataclass(frozen=True)
class GoToPhoto(Command):
    """Fly to a place in the photo, a fraction of its width and height."""

    x: float
    y: float


@dataclass(frozen=True)
class ToggleRegion(Command):
    """Let the next drag draw the frame of the next level, or take the frame away."""


@dataclass(frozen=True)
class SetLook(Command):
    """Draw the scene another way."""

    look: Look


@dataclass(frozen=True)
class NextMode(Command):
    """Go on to the next of picture, levels, depth and coverage."""


@dataclass(frozen=True)
class Resize(Command):
    """The window has another size, px."""

    width: int
    height: int
