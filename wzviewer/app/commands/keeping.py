"""What may be asked of pictures and films."""

from dataclasses import dataclass
from pathlib import Path

from wzviewer.app.commands.base import Command
from wzviewer.app.plan import KeepPlan


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
class SetPlan(Command):
    """Choose what the next picture or film will be."""

    plan: KeepPlan


@dataclass(frozen=True)
class CopyView(Command):
    """Put the command that renders the view on the clipboard."""


@dataclass(frozen=True)
class AskFilm(Command):
    """Show the dialog for the planned film."""


@dataclass(frozen=True)
class MakeFilm(Command):
    """Make the planned film."""

    path: Path


@dataclass(frozen=True)
class CancelFilm(Command):
    """End the film in the making."""
