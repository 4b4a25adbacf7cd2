"""What may be asked of panels, notices and settings."""

from dataclasses import dataclass
from typing import Literal

from wzviewer.app.commands.base import Command
from wzviewer.app.settings import Settings

Panel = Literal[
    "tree", "statistics", "help", "keep", "settings", "history", "materials", "locator", "start", "timeline"
]


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
class DismissHint(Command):
    """Take the hint on the first photo away for good."""


@dataclass(frozen=True)
class OpenPalette(Command):
    """Show every command by its name."""


@dataclass(frozen=True)
class ClosePalette(Command):
    """Hide them again."""


@dataclass(frozen=True)
class EditPalette(Command):
    """The line of the palette holds another text."""

    text: str


@dataclass(frozen=True)
class MarkEntry(Command):
    """Mark the next or the previous entry of the palette."""

    step: int


@dataclass(frozen=True)
class ToggleLog(Command):
    """Show or hide the log window."""


@dataclass(frozen=True)
class SetLogLevel(Command):
    """Show messages of the log from a level on."""

    level: int


@dataclass(frozen=True)
class CopyLog(Command):
    """Put the messages that the log shows on the clipboard."""


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
