"""The history of a scene: what was changed, as marks before and after, so that all of it can be undone.

::

    entries   made “a bird” │ hid “a bird” │ renamed … │ …       oldest first
                                           ▲ at: how many of them hold; what follows, redo brings back

A change of the scene is a change of marks (`core.marks`): making a level turns it from removed to shown.
So undo and redo touch no bytes, and a history needs next to no memory.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from wzviewer.core.marks import Mark
from wzviewer.core.scene import Scene

EntryKind = Literal["make", "vary", "hide", "show", "remove", "rename", "choose"]


@dataclass(frozen=True)
class Change:
    """One level's mark before and after."""

    index: int
    before: Mark
    after: Mark


@dataclass(frozen=True)
class Entry:
    """A step of the history.

    Attributes:
        kind: what was done.
        what: to which level, by its name at that time.
        changes: the marks that it changed.
    """

    kind: EntryKind
    what: str
    changes: tuple[Change, ...]


@dataclass(frozen=True)
class History:
    """Everything that changed the scene, and how much of it holds.

    Attributes:
        entries: oldest first.
        at: the number of entries that hold.
    """

    entries: tuple[Entry, ...] = ()
    at: int = 0

    @property
    def undoable(self) -> Entry | None:
        """What undo takes back."""
        return self.entries[self.at - 1] if self.at else None

    @property
    def redoable(self) -> Entry | None:
        """What redo brings back."""
        return self.entries[self.at] if self.at < len(self.entries) else None

    def then(self, entry: Entry) -> "History":
        """Returns the history with one more entry; what redo could bring back ends there."""
        entries = (*self.entries[: self.at], entry)
        return History(entries, len(entries))

    def with_made(self, entry: Entry) -> "History":
        """Returns the history with a level that has just come; what redo can bring back stays.

        It comes in its own time, which must not end what the user is going back and forth through.
        """
        return History((*self.entries[: self.at], entry, *self.entries[self.at :]), self.at + 1)


def marked(scene: Scene, kind: EntryKind, what: str, marks: Mapping[int, Mark]) -> Entry:
    """Sets marks; returns the entry that remembers those before."""
    changes = tuple(Change(i, scene.mark(i), mark) for i, mark in marks.items() if scene.mark(i) != mark)
    for change in changes:
        scene.set_mark(change.index, change.after)
    return Entry(kind, what, changes)


def take_back(scene: Scene, entry: Entry) -> None:
    """Sets the marks before an entry."""
    for change in reversed(entry.changes):
        scene.set_mark(change.index, change.before)


def bring_back(scene: Scene, entry: Entry) -> None:
    """Sets the marks after an entry."""
    for change in entry.changes:
        scene.set_mark(change.index, change.after)
