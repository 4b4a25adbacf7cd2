"""The one table of keys and gestures: input obeys it, help and palette show it.

::

    BINDINGS   the keys of wzviewer           ┐  keymap_of(name, letters): what counts now
    AUTHORS    those of the authors' viewer   ┘  (theirs first, ours where a key is free)

Keys that fly are places on the keyboard and not letters: ``letters`` says what is printed there.  All
other keys go by their letter, as in every program.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.settings import KeymapName

MODIFIER = "⌘" if sys.platform == "darwin" else "Ctrl"
Modifiers = Mapping[imgui.Key, tuple[bool, bool]]  # whether Ctrl and Shift were held at the press
LETTERS = "wasdqe"  # at the places that fly, on an American keyboard
FAST, SLOW = 3.0, 0.25  # with Shift, with Alt
EDITING = frozenset((imgui.Key.z, imgui.Key.y, imgui.Key.c, imgui.Key.delete))  # with Ctrl, in a field
SIGNS = {
    "`": "grave_accent",
    "-": "minus",
    "=": "equal",
    "[": "left_bracket",
    "]": "right_bracket",
    "\\": "backslash",
    ",": "comma",
    ";": "semicolon",
    "'": "apostrophe",
    ".": "period",
    "/": "slash",
}


@dataclass(frozen=True)
class Binding:
    """A key and what it does.

    Attributes:
        label: as help shows it.
        what: what it does, a few words.
        group: heading in the help; empty is not shown.
        keys: any of these; none for a gesture of the mouse.
        command: makes the command.
        ctrl: with Ctrl (Cmd on a Mac).
        shift: with Shift.
    """

    label: str
    what: str
    group: str
    keys: tuple[imgui.Key, ...] = ()
    command: Callable[[], cmd.Command] | None = None
    ctrl: bool = False
    shift: bool = False


@dataclass(frozen=True)
class Held:
    """What a key does as long as it is held; each in about [-1, 1].

    Attributes:
        fly: right, down, forward.
        turn: right, down.
        zoom: closer.
    """

    fly: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float] = (0.0, 0.0)
    zoom: float = 0.0


@dataclass(frozen=True)
class Keymap:
    """Everything that keys do.

    Attributes:
        bindings: pressed once.
        held: as long as they are down.
    """

    bindings: tuple[Binding, ...]
    held: Mapping[imgui.Key, Held]


K = imgui.Key
FLY_LABEL = "W A S D, Q E"  # stands for the letters at these places
BINDINGS: tuple[Binding, ...] = (
    Binding("Scroll", "Zoom to the cursor", "Look"),
    Binding("Drag", "Orbit about what is there", "Look"),
    Binding("Right drag, Shift drag", "Pan", "Look"),
    Binding(f"{MODIFIER} scroll, Shift scroll", "Orbit, pan (touchpad)", "Look"),
    Binding("Double click", "Fly there and closer", "Look"),
    Binding(FLY_LABEL, "Fly; Shift fast, Alt slow", "Look"),
    Binding("Home", "The whole picture", "Look", (K.home, K.h), cmd.GoHome),
    Binding("[, Backspace", "The view before", "Look", (K.left_bracket, K.backspace), cmd.GoBack),
    Binding("]", "The view after", "Look", (K.right_bracket,), cmd.GoForward),
    Binding("Enter, G", "New detail where you look", "Make", (K.enter, K.keypad_enter, K.g), cmd.Generate),
    Binding("R", "Draw the frame of the next level", "Make", (K.r,), cmd.ToggleRegion),
    Binding("N", "Another variant of the newest level", "Make", (K.n,), cmd.Another),
    Binding("PgUp, PgDn", "Go through variants", "Make", (K.page_down,), lambda: cmd.StepVariant(1)),
    Binding("PgUp", "The variant before", "", (K.page_up,), lambda: cmd.StepVariant(-1)),
    Binding("M", "Materials and weather", "Make", (K.m,), lambda: cmd.Toggle("materials")),
    Binding("/", "Type what should be there", "Make", (K.slash,), cmd.FocusPrompt),
    Binding("X", "Auto detail on or off", "Make", (K.x,), cmd.ToggleAuto),
    Binding("Esc", "Cancel, close; twice: the queue", "Make", (K.escape,), cmd.Escape),
    Binding(f"{MODIFIER} Z", "Undo", "Make", (K.z,), cmd.Undo, ctrl=True),
    Binding(f"{MODIFIER} Shift Z", "Redo", "Make", (K.z,), cmd.Redo, ctrl=True, shift=True),
    Binding(f"{MODIFIER} Y", "Redo", "", (K.y,), cmd.Redo, ctrl=True),  # the same on Windows
    Binding(f"{MODIFIER} O", "Open, or drop a file here", "File", (K.o,), cmd.AskOpen, True),
    Binding(f"{MODIFIER} Shift O", "Recent files", "File", (K.o,), lambda: cmd.Toggle("start"), True, True),
    Binding(f"{MODIFIER} S", "Save", "File", (K.s,), cmd.Save, ctrl=True),
    Binding(f"{MODIFIER} Shift S", "Save as", "File", (K.s,), lambda: cmd.Save(True), True, True),
    Binding(f"{MODIFIER} P", "Save the picture", "File", (K.p,), cmd.AskPicture, ctrl=True),
    Binding(f"{MODIFIER} C", "Copy view as command", "File", (K.c,), cmd.CopyView, ctrl=True),
    Binding(f"{MODIFIER} M", "Save the film", "File", (K.m,), cmd.AskFilm, ctrl=True),
    Binding("T", "Levels", "Panels", (K.t,), lambda: cmd.Toggle("tree")),
    Binding("F2", "Rename the level here", "Panels", (K.f2,), cmd.BeginRename),
    Binding(f"{MODIFIER} Del", "Delete the level here", "Panels", (K.delete,), cmd.DeleteHere, ctrl=True),
    Binding("U", "History", "Panels", (K.u,), lambda: cmd.Toggle("history")),
    Binding("O", "Where you are in the photo", "Panels", (K.o,), lambda: cmd.Toggle("locator")),
    Binding("V", "Picture, levels, depth, coverage", "Panels", (K.v,), cmd.NextMode),
    Binding("F3", "Look behind, statistics", "Panels", (K.f3,), lambda: cmd.Toggle("statistics")),
    Binding(f"{MODIFIER} ,", "Settings", "Panels", (K.comma,), lambda: cmd.Toggle("settings"), True),
    Binding("K", "Save a picture or a film", "Panels", (K.k,), lambda: cmd.Toggle("keep")),
    Binding(f"{MODIFIER} K", "All commands by name", "Panels", (K.k,), cmd.OpenPalette, ctrl=True),
    Binding(f"{MODIFIER} Shift P", "All commands by name", "", (K.p,), cmd.OpenPalette, True, True),
    Binding("F12", "Log", "Panels", (K.f12,), cmd.ToggleLog),
    Binding("F1", "This help", "Panels", (K.f1,), lambda: cmd.Toggle("help")),
    Binding("L", "Timeline of a film", "Film", (K.l,), lambda: cmd.Toggle("timeline")),
    Binding("I", "Add the view as a key", "Film", (K.i,), cmd.AddKey),
    Binding("Del", "Delete the selected key", "Film", (K.delete,), cmd.DeleteKey),
    Binding(",", "The key before", "", (K.comma,), lambda: cmd.StepKey(-1)),
    Binding(", and .", "The key before and after", "Film", (K.period,), lambda: cmd.StepKey(1)),
    Binding("Space", "Play the timeline, stop", "Film", (K.space,), cmd.TogglePlay),
    Binding(f"{MODIFIER} Q", "Close", "File", (K.q,), cmd.Close, ctrl=True),
)
# Keys of the viewer that the paper's authors released; what they have and we do not has no key here.
LOOK_LABEL = "W A S D"
AUTHORS: tuple[Binding, ...] = (
    Binding("V, B", "Zoom in, zoom out", "Look"),
    Binding(LOOK_LABEL, "Look around; Shift fast, Alt slow", "Look"),
    Binding("Arrows, N M", "Move; up and down", "Look"),
    Binding("P", "The nearest level", "Look", (K.p,), cmd.GoToNearest),
    Binding("R", "New detail where you look", "Make", (K.r,), cmd.Generate),
    Binding("Z", "Undo", "Make", (K.z,), cmd.Undo),
    Binding("F2", "Auto detail on or off", "Make", (K.f2,), cmd.ToggleAuto),
    Binding("F6", "Draw the frame of the next level", "Make", (K.f6,), cmd.ToggleRegion),
    Binding("F7", "Another variant of the newest level", "Make", (K.f7,), cmd.Another),
    Binding("F8", "Materials and weather", "Make", (K.f8,), lambda: cmd.Toggle("materials")),
    Binding("X", "Save", "File", (K.x,), cmd.Save),
    Binding("F9", "Rename the level here", "Panels", (K.f9,), cmd.BeginRename),
    Binding("F4", "Picture, levels, depth, coverage", "Panels", (K.f4,), cmd.NextMode),
)
FLY_STEPS = (
    Held((0.0, 0.0, 1.0)),
    Held((-1.0, 0.0, 0.0)),
    Held((0.0, 0.0, -1.0)),
    Held((1.0, 0.0, 0.0)),
    Held((0.0, 1.0, 0.0)),
    Held((0.0, -1.0, 0.0)),
)
LOOK_STEPS = (Held(turn=(0.0, -1.0)), Held(turn=(-1.0, 0.0)), Held(turn=(0.0, 1.0)), Held(turn=(1.0, 0.0)))
AUTHORS_HELD: dict[imgui.Key, Held] = {
    K.up_arrow: Held((0.0, 0.0, 1.0)),
    K.down_arrow: Held((0.0, 0.0, -1.0)),
    K.left_arrow: Held((-1.0, 0.0, 0.0)),
    K.right_arrow: Held((1.0, 0.0, 0.0)),
    K.n: Held((0.0, -1.0, 0.0)),
    K.m: Held((0.0, 1.0, 0.0)),
    K.v: Held(zoom=1.0),
    K.b: Held(zoom=-1.0),
}


@cache
def keymap_of(name: KeymapName, letters: str = LETTERS) -> Keymap:
    """Returns what keys do.

    Args:
        name: whose keys.
        letters: printed at the places of W A S D Q E.
    """
    keys = [_key_of(sign, usual) for sign, usual in zip(letters, LETTERS, strict=True)]
    if name == "wzviewer":
        held = dict(zip(keys, FLY_STEPS, strict=True))
        return Keymap(_without(_spelled(BINDINGS, letters), set(held)), held)
    held = {**AUTHORS_HELD, **dict(zip(keys, LOOK_STEPS, strict=False))}
    theirs = _without(_spelled(AUTHORS, letters), set(held))
    taken = set(held) | {key for binding in theirs for key in binding.keys}
    ours = tuple(b for b in BINDINGS if b.label != FLY_LABEL)
    commands = {b.command for b in theirs if b.keys}
    rest = (replace(b, group="") if b.command in commands else b for b in _without(ours, taken))
    return Keymap((*theirs, *rest), held)


def _spelled(bindings: tuple[Binding, ...], letters: str) -> tuple[Binding, ...]:
    """The rows with the letters that are printed on this keyboard."""
    spaced = " ".join(letters.upper())  # W A S D Q E
    labels = {FLY_LABEL: f"{spaced[:7]}, {spaced[8:]}", LOOK_LABEL: spaced[:7]}
    return tuple(replace(b, label=labels.get(b.label, b.label)) for b in bindings)


def _without(bindings: tuple[Binding, ...], taken: set[imgui.Key]) -> tuple[Binding, ...]:
    """The rows without bare keys that do something else; a row without any key is not shown."""
    rows: list[Binding] = []
    for binding in bindings:
        left = tuple(key for key in binding.keys if binding.ctrl or key not in taken)
        if left != binding.keys:
            label = ", ".join(imgui.get_key_name(key) for key in left)
            binding = replace(binding, keys=left, label=label, group=binding.group if left else "")
        rows.append(binding)
    return tuple(rows)


def _key_of(sign: str, usual: str) -> imgui.Key:
    """The key that imgui reports where a sign is printed; a letter it does not know is the American one."""
    sign = sign if sign in SIGNS or ("a" <= sign <= "z") else usual
    return getattr(imgui.Key, SIGNS.get(sign, sign))


def key_named(name: str) -> imgui.Key | None:
    """Returns the key that imgui reports where a letter or sign is printed; None for any other name."""
    name = name.lower()
    return _key_of(name, name) if name in SIGNS or (len(name) == 1 and "a" <= name <= "z") else None


def label_of(command: type[cmd.Command], keymap: KeymapName = "wzviewer") -> str:
    """Returns the key that gives a command, for tooltips; empty when there is none."""
    return next((b.label for b in keymap_of(keymap).bindings if b.command is command), "")


def label_for(command: cmd.Command, keymap: KeymapName = "wzviewer") -> str:
    """Returns the key that gives exactly this command; empty when there is none."""
    made = ((b.label, b.command()) for b in keymap_of(keymap).bindings if b.command is not None)
    return next((label for label, other in made if other == command), "")


def works_while_typing(binding: Binding) -> bool:
    """Whether a binding works while typing, too: with Ctrl, and not one of those that edit a text."""
    return binding.ctrl and not EDITING.intersection(binding.keys)


def matches(binding: Binding, ctrl: bool, shift: bool) -> bool:
    """Whether the modifiers held are those of a binding."""
    return binding.ctrl == ctrl and (binding.shift == shift or not binding.ctrl)
