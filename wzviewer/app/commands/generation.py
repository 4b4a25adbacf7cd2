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
    """Put the cursor into the prompt line, which takes imgui so many frames."""

    frames: int = 2


@dataclass(frozen=True)
class Generate(Command):
    """Make new detail where the user looks, in a number of variants."""

    count: int = 1


@dataclass(frozen=True)
class ToggleAuto(Command):
    """Switch auto detail on or off."""


@dataclass(frozen=True)
class CancelJob(Command):
    """Stop the running request; a second time at once, also what waits."""


@dataclass(frozen=True)
class DropWish(Command):
    """Take a goal out of the queue."""

    place: int


@dataclass(frozen=True)
class ClearQueue(Command):
    """Take all goals out of the queue."""


@dataclass(frozen=True)
class AddPhrase(Command):
    """Put a material or the like into the prompt line."""

    phrase: str
