"""What may be asked of the prompt line and of Thread 2, and taken back."""

from dataclasses import dataclass

from wzviewer.app.commands.base import Command


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
