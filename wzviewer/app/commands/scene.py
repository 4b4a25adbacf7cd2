"""What may be asked of the levels that are there: their marks, variants, and the history."""

from dataclasses import dataclass

from wzviewer.app.commands.base import Command


@dataclass(frozen=True)
class Undo(Command):
    """Take back the newest change."""


@dataclass(frozen=True)
class Redo(Command):
    """Bring back the change that was taken back last."""


@dataclass(frozen=True)
class JumpInHistory(Command):
    """Undo or redo until so many entries hold."""

    at: int


@dataclass(frozen=True)
class ShowLevel(Command):
    """Show a level, or hide it."""

    index: int
    is_shown: bool


@dataclass(frozen=True)
class DeleteLevel(Command):
    """Take a level out of the tree."""

    index: int


@dataclass(frozen=True)
class DeleteHere(Command):
    """Take the level that the view is in out of the tree."""


@dataclass(frozen=True)
class BeginRename(Command):
    """Edit the name of a level in place; None is the one that the view is in."""

    index: int | None = None


@dataclass(frozen=True)
class EndRename(Command):
    """Leave the name as it was."""


@dataclass(frozen=True)
class RenameLevel(Command):
    """Give a level another name."""

    index: int
    name: str


@dataclass(frozen=True)
class Another(Command):
    """Make a level again with another seed; None is the newest."""

    index: int | None = None
    count: int = 1


@dataclass(frozen=True)
class OpenVariants(Command):
    """Show the variants of a level side by side, or no longer (None)."""

    index: int | None = None


@dataclass(frozen=True)
class ChooseVariant(Command):
    """Show this one of its variants, and no other."""

    index: int


@dataclass(frozen=True)
class StepVariant(Command):
    """Show the next or the previous variant."""

    step: int
