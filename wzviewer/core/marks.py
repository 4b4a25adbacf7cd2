"""What is said about the levels of a scene without touching them: which are seen, and their names.

A level's bytes never change; a mark does, and undo brings the mark before back::

    shown      the level is drawn
    hidden     it is not, and the tree of levels greys it
    removed    it is not, and the tree does not list it either; its bytes stay, for undo
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Sight = Literal["shown", "hidden", "removed"]
MAX_NAME_CHARS = 80
FIELDS = ("hidden", "removed", "names")  # in the manifest of a scene


@dataclass(frozen=True)
class Mark:
    """What is said about one level.

    Attributes:
        sight: whether it is seen.
        name: that the user gave it; empty for its prompt.
    """

    sight: Sight = "shown"
    name: str = ""


UNMARKED = Mark()


def marks_to_json(marks: Mapping[int, Mark]) -> dict[str, Any]:
    """Returns the fields of a manifest; ``hidden`` lists removed levels too, for older readers."""
    unseen = sorted(i for i, mark in marks.items() if mark.sight != "shown")
    removed = [i for i in unseen if marks[i].sight == "removed"]
    names = {str(i): marks[i].name for i in sorted(marks) if marks[i].name}
    record: dict[str, Any] = {"hidden": unseen}
    record |= {"removed": removed} if removed else {}
    return record | ({"names": names} if names else {})


def marks_from_json(record: Mapping[str, Any], count: int) -> dict[int, Mark]:
    """Reads the fields of a manifest, and leaves out what is malformed.

    Args:
        record: the manifest.
        count: of levels; the first one, the photo, is always shown.
    """
    hidden, removed = _indices(record.get("hidden"), count), _indices(record.get("removed"), count)
    names = record.get("names")
    known = {str(i) for i in range(count)}
    named: dict[int, str] = {}
    for key, name in names.items() if isinstance(names, dict) else ():
        if isinstance(name, str) and key in known and clean_name(name):
            named[int(key)] = clean_name(name)
    marks: dict[int, Mark] = {}
    for index in sorted({*hidden, *removed, *named}):
        sight: Sight = "removed" if index in removed else "hidden" if index in hidden else "shown"
        marks[index] = Mark(sight, named.get(index, ""))
    return marks


def clean_name(name: str) -> str:
    """Returns a name on one line, within the limit."""
    return " ".join("".join(c if c.isprintable() else " " for c in name).split())[:MAX_NAME_CHARS].strip()


def _indices(value: object, count: int) -> set[int]:
    found = value if isinstance(value, list) else []
    return {i for i in found if isinstance(i, int) and not isinstance(i, bool) and 0 < i < count}
