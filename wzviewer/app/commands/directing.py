"""What may be asked of the timeline."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from wzviewer.app.commands.base import Command
from wzviewer.core.keyframes import Pace

KeySource = Literal["way", "levels", "orbit"]


@dataclass(frozen=True)
class AddKey(Command):
    """Make the present view a key."""


@dataclass(frozen=True)
class UpdateKey(Command):
    """Give the selected key the present view."""


@dataclass(frozen=True)
class DeleteKey(Command):
    """Remove the selected key."""


@dataclass(frozen=True)
class SelectKey(Command):
    """Go to a key; None is none."""

    index: int | None


@dataclass(frozen=True)
class StepKey(Command):
    """Go to the next or the previous key."""

    step: int


@dataclass(frozen=True)
class RetimeKey(Command):
    """Reach a key at another moment; while a hand still drags it, the ruler stays."""

    index: int
    time_s: float
    is_done: bool = False


@dataclass(frozen=True)
class SetKeySeconds(Command):
    """Take another time from a key to the next; until a hand has let go, it is one change."""

    index: int
    seconds: float
    is_done: bool = True


@dataclass(frozen=True)
class SetKeyPace(Command):
    """Go through a key smoothly, stop there, or turn at once."""

    index: int
    pace: Pace


@dataclass(frozen=True)
class ScrubTo(Command):
    """Show a moment of the path."""

    time_s: float


@dataclass(frozen=True)
class TogglePlay(Command):
    """Let the preview run, or stop it."""


@dataclass(frozen=True)
class ToggleLoop(Command):
    """Lead the last key to the first, or not."""


@dataclass(frozen=True)
class FillKeys(Command):
    """Begin with keys of the way here, of the levels, or of an orbit."""

    source: KeySource


@dataclass(frozen=True)
class PlanKeysFilm(Command):
    """Show the Keep panel, with a film through the keys."""


@dataclass(frozen=True)
class ClearKeys(Command):
    """Remove all keys."""


@dataclass(frozen=True)
class BringBackKeys(Command):
    """Take back the last change of the keys."""


@dataclass(frozen=True)
class AskPath(Command):
    """Show the dialog for a camera path: to open one, or to write it."""

    is_opening: bool


@dataclass(frozen=True)
class OpenCameraPath(Command):
    """Take over the keys of a file."""

    path: Path


@dataclass(frozen=True)
class SaveCameraPath(Command):
    """Write the keys and all frames to a file."""

    path: Path
