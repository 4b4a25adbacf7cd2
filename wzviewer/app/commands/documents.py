"""What may be asked of files, and the answers to questions about them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from wzviewer.app.commands.base import Command


@dataclass(frozen=True)
class Open(Command):
    """Open a photo or a scene."""

    path: Path


@dataclass(frozen=True)
class Drop(Command):
    """Take a file that was dropped on the window, at a place in framebuffer px where that is known."""

    path: Path
    at_px: tuple[float, float] | None = None


@dataclass(frozen=True)
class SettleDrop(Command):
    """The answer to the question what a dropped picture is for."""

    answer: Literal["open", "insert"]


@dataclass(frozen=True)
class OpenDemo(Command):
    """Open the bundled picture."""


@dataclass(frozen=True)
class RemoveRecent(Command):
    """Take a file off the list of recent ones."""

    path: Path


@dataclass(frozen=True)
class ClearRecents(Command):
    """Empty the list of recent files."""


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
class Close(Command):
    """Close the window; asks about unsaved changes, and about what is being made.

    Attributes:
        gives_up: what is being made, which has been asked about.
    """

    gives_up: bool = False


@dataclass(frozen=True)
class SettleUnsaved(Command):
    """The answer to the question about unsaved changes."""

    answer: Literal["save", "discard", "stay"]


@dataclass(frozen=True)
class SettleRecovery(Command):
    """The answer to the question about levels that a crash left behind."""

    answer: Literal["recover", "discard"]
