"""What panels and input may ask for: frozen, imperative, plain.  `app.apply` carries them out."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from wzviewer.app.look import Look
from wzviewer.app.settings import Settings

Panel = Literal["tree", "statistics", "help", "keep", "settings"]


@dataclass(frozen=True)
class Command:
    """Base of all commands."""


# ------------------------------------------------------------------ viewing


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


# ------------------------------------------------------------------ generation


@dataclass(frozen=True)
class EditPrompt(Command):
    """The prompt line holds another text."""

    text: str


@dataclass(frozen=True)
class TakeOffer(Command):
    """Put an offered prompt into the line, and the cursor behind it."""

    prompt: str


@dataclass(frozen=True)
class ChooseOffer(Command):
    """Mark the next or the previous offer."""

    step: int


@dataclass(frozen=True)
class FocusPrompt(Command):
    """Put the cursor into the prompt line, or take it out again."""

    is_wanted: bool = True


@dataclass(frozen=True)
class Generate(Command):
    """Make new detail where the user looks."""


@dataclass(frozen=True)
class ToggleAuto(Command):
    """Switch auto detail on or off."""


@dataclass(frozen=True)
class CancelJob(Command):
    """Stop the running request."""


@dataclass(frozen=True)
class Undo(Command):
    """Hide the newest level."""


@dataclass(frozen=True)
class Redo(Command):
    """Show the level that was hidden last."""


# ------------------------------------------------------------------ documents


@dataclass(frozen=True)
class Open(Command):
    """Open a photo or a scene."""

    path: Path


@dataclass(frozen=True)
class OpenDemo(Command):
    """Open the bundled picture."""


@dataclass(frozen=True)
class AskOpen(Command):
    """Show the open dialog."""


@dataclass(frozen=True)
class Save(Command):
    """Save to the scene's file, or ask where."""

    asks: bool = False


@dataclass(frozen=True)
class SaveTo(Command):
    """Save to a file."""

    path: Path


@dataclass(frozen=True)
class AskPicture(Command):
    """Show the dialog for saving the picture on screen."""


@dataclass(frozen=True)
class SavePicture(Command):
    """Write the picture on screen, without panels."""

    path: Path


@dataclass(frozen=True)
class SetPictureSize(Command):
    """Choose the size of pictures and films, px; None is the window's."""

    size: tuple[int, int] | None


@dataclass(frozen=True)
class CopyView(Command):
    """Put the command that renders the view on the clipboard."""


@dataclass(frozen=True)
class AskFilm(Command):
    """Show the dialog for the film from the photo to here."""


@dataclass(frozen=True)
class MakeFilm(Command):
    """Film the way from the photo to here."""

    path: Path


@dataclass(frozen=True)
class CancelFilm(Command):
    """End the film in the making."""


@dataclass(frozen=True)
class Close(Command):
    """Close the window; asks about unsaved changes."""


@dataclass(frozen=True)
class SettleUnsaved(Command):
    """The answer to the question about unsaved changes."""

    answer: Literal["save", "discard", "stay"]


@dataclass(frozen=True)
class SettleRecovery(Command):
    """The answer to the question about levels that a crash left behind."""

    answer: Literal["recover", "discard"]


# ------------------------------------------------------------------ panels


@dataclass(frozen=True)
class Toggle(Command):
    """Show or hide a panel."""

    panel: Panel


@dataclass(frozen=True)
class Escape(Command):
    """Leave whatever is in the foreground: dialog, help, job."""


@dataclass(frozen=True)
class ChangeSettings(Command):
    """Prefer something else, from now on and at the next start."""

    settings: Settings


@dataclass(frozen=True)
class EditPath(Command):
    """The path line of the text dialog holds another text."""

    text: str


@dataclass(frozen=True)
class ConfirmPath(Command):
    """Take the path of the text dialog."""


@dataclass(frozen=True)
class ExpandToast(Command):
    """Show or hide the details of a notice, which then stays."""

    text: str


@dataclass(frozen=True)
class Retry(Command):
    """Ask again for what a notice says has failed."""

    text: str


@dataclass(frozen=True)
class DismissToast(Command):
    """Remove a notice."""

    text: str
