"""The palette: every command by its name, found by a few of its letters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from wzviewer.app import commands as cmd
from wzviewer.app.keys import LETTERS, keymap_of
from wzviewer.app.look import MODES
from wzviewer.app.state import AppState
from wzviewer.core.scene import Level

HIDDEN = (cmd.OpenPalette, cmd.Escape)
ON_START_PAGE = (
    cmd.AskOpen,
    cmd.ChangeSettings,
    cmd.ClearRecents,
    cmd.Close,
    cmd.Open,
    cmd.OpenDemo,
    cmd.ToggleAuto,
    cmd.ToggleLog,
)
TEXT_SIZES = (("small", 14.0), ("normal", 16.0), ("large", 18.0), ("huge", 20.0))
AT_START, INSIDE, SCATTERED = 3.0, 2.0, 0.5  # score of a letter, by where its word is found
FIRST = 0.5  # more for the first word of a title


@dataclass(frozen=True)
class Entry:
    """A command that can be run by name.

    Attributes:
        title: what it does.
        keys: that do the same; empty when there are none.
        command: what is run.
    """

    title: str
    keys: str
    command: cmd.Command


def entries_of(state: AppState, letters: str = LETTERS) -> list[Entry]:
    """Returns every command that makes sense now: those with keys first."""
    entries: dict[str, Entry] = {}
    for binding in keymap_of(state.settings.keymap, letters).bindings:
        if binding.command is not None and binding.command not in HIDDEN:
            entries.setdefault(binding.what, Entry(binding.what, binding.label, binding.command()))
    for title, command in [*_views(state), *_running(state), *_files(state), *_preferences(state)]:
        entries.setdefault(title, Entry(title, "", command))
    return [e for e in entries.values() if state.has_document or _is_for_start_page(e.command)]


def _is_for_start_page(command: cmd.Command) -> bool:
    if isinstance(command, cmd.Toggle):
        return command.panel in ("settings", "help")
    return isinstance(command, ON_START_PAGE)


def _views(state: AppState) -> list[tuple[str, cmd.Command]]:
    looks = [(f"View: {name.lower()}", cmd.SetLook(replace(state.look, mode=mode))) for mode, name in MODES]
    goals = [(f"Go to {_name(state.scene[i])}", cmd.GoToLevel(i)) for i in state.scene.visible()]
    return [*looks, ("Go to the nearest level", cmd.GoToNearest()), *goals]


def _name(level: Level) -> str:
    if level.parent is None:
        return "the photo"
    return f"level {level.index}: {level.prompt}" if level.prompt else f"level {level.index}"


def _running(state: AppState) -> list[tuple[str, cmd.Command]]:
    commands: list[tuple[str, cmd.Command]] = []
    if state.job is not None:
        commands.append(("Cancel the request", cmd.CancelJob()))
    if state.film is not None:
        commands.append(("Cancel the film", cmd.CancelFilm()))
    return commands


def _files(state: AppState) -> list[tuple[str, cmd.Command]]:
    files = [(f"Open {file.path.name}", cmd.Open(file.path)) for file in state.recents.files]
    clear = [("Clear the list of recent files", cmd.ClearRecents())] if files else []
    return [("Open the demo", cmd.OpenDemo()), *files, *clear]


def _preferences(state: AppState) -> list[tuple[str, cmd.Command]]:
    now = state.settings
    motion = "off" if now.reduced_motion else "on"
    changes = [
        ("Panels: dark", replace(now, theme="dark")),
        ("Panels: light", replace(now, theme="light")),
        *((f"Text: {name}", replace(now, font_pt=size)) for name, size in TEXT_SIZES),
        ("Keys: wzviewer", replace(now, keymap="wzviewer")),
        ("Keys: the authors' release", replace(now, keymap="authors")),
        (f"Reduced motion: {motion}", replace(now, reduced_motion=not now.reduced_motion)),
        ("Show the hint on photos", replace(now, hint_seen=False)),
    ]
    return [(title, cmd.ChangeSettings(after)) for title, after in changes if after != now]


# ------------------------------------------------------------------ finding


def found(entries: Sequence[Entry], text: str) -> list[Entry]:
    """Returns the entries that a text may mean, the best first; all of them for no text."""
    scored = [(score(text, entry.title, entry.keys), entry) for entry in entries]
    hits = [(value, entry) for value, entry in scored if value is not None]
    return [entry for _, entry in sorted(hits, key=lambda hit: -hit[0])]  # stable: equals keep their order


@lru_cache(maxsize=4096)
def score(text: str, title: str, keys: str = "") -> float | None:
    """How well a text names a title: every word of it must be found; None when one is not.

    A word counts most at the start of a word, less inside one, least as scattered letters; of keys
    only their first letters count.
    """
    total = 0.0
    for word in text.lower().split():
        value = _score_of_word(word, title.lower())
        if any(key.startswith(word) for key in keys.lower().split()):
            value = max(value or 0.0, AT_START * len(word))
        if value is None:
            return None
        total += value
    return total - 1e-3 * len(title) if total else 0.0


def _score_of_word(word: str, title: str) -> float | None:
    starts = [i for i in range(len(title)) if title[i] != " " and (i == 0 or not title[i - 1].isalnum())]
    if any(title.startswith(word, i) for i in starts):
        return AT_START * len(word) + (FIRST if title.startswith(word) else 0.0)
    if word in title:
        return INSIDE * len(word)
    values = [value for i in starts if (value := _scattered(word, title, i, starts)) is not None]
    return max(values, default=None)


def _scattered(word: str, title: str, start: int, starts: list[int]) -> float | None:
    """The letters of a word in order, the first of them at a word's start; more of those count more."""
    at, at_starts = start - 1, 0
    for letter in word:
        at = title.find(letter, at + 1)
        if at < 0 or (at_starts == 0 and at != start):
            return None
        at_starts += at in starts
    return SCATTERED * (len(word) + at_starts)
