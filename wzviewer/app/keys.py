"""The one table of keys and gestures: input obeys it, help shows it."""

import sys
from collections.abc import Callable
from dataclasses import dataclass

from imgui_bundle import imgui

from wzviewer.app import commands as cmd

MODIFIER = "⌘" if sys.platform == "darwin" else "Ctrl"
FLY_KEYS: dict[imgui.Key, tuple[float, float, float]] = {
    imgui.Key.w: (0.0, 0.0, 1.0),
    imgui.Key.s: (0.0, 0.0, -1.0),
    imgui.Key.a: (-1.0, 0.0, 0.0),
    imgui.Key.d: (1.0, 0.0, 0.0),
    imgui.Key.q: (0.0, 1.0, 0.0),
    imgui.Key.e: (0.0, -1.0, 0.0),
}
FAST, SLOW = 3.0, 0.25  # with Shift, with Alt


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


K = imgui.Key
BINDINGS: tuple[Binding, ...] = (
    Binding("Wheel", "Zoom to the cursor", "Look"),
    Binding("Drag", "Orbit about what is there", "Look"),
    Binding("Right drag, Shift drag", "Pan", "Look"),
    Binding("Double click", "Fly there and closer", "Look"),
    Binding("W A S D, Q E", "Fly; Shift fast, Alt slow", "Look"),
    Binding("Home", "The whole picture", "Look", (K.home, K.h), cmd.GoHome),
    Binding("[, Backspace", "The view before", "Look", (K.left_bracket, K.backspace), cmd.GoBack),
    Binding("]", "The view after", "Look", (K.right_bracket,), cmd.GoForward),
    Binding("Enter, G", "New detail where you look", "Make", (K.enter, K.keypad_enter, K.g), cmd.Generate),
    Binding("/", "Type what should be there", "Make", (K.slash,), cmd.FocusPrompt),
    Binding("X", "Auto detail on or off", "Make", (K.x,), cmd.ToggleAuto),
    Binding("Esc", "Cancel, close", "Make", (K.escape,), cmd.Escape),
    Binding(f"{MODIFIER} Z", "Undo a level", "Make", (K.z,), cmd.Undo, ctrl=True),
    Binding(f"{MODIFIER} Shift Z", "Redo", "Make", (K.z,), cmd.Redo, ctrl=True, shift=True),
    Binding(f"{MODIFIER} Y", "Redo", "", (K.y,), cmd.Redo, ctrl=True),  # the same on Windows
    Binding(f"{MODIFIER} O", "Open, or drop a file here", "File", (K.o,), cmd.AskOpen, True),
    Binding(f"{MODIFIER} S", "Save", "File", (K.s,), cmd.Save, ctrl=True),
    Binding(f"{MODIFIER} Shift S", "Save as", "File", (K.s,), lambda: cmd.Save(True), True, True),
    Binding(f"{MODIFIER} P", "Save the picture", "File", (K.p,), cmd.AskPicture, ctrl=True),
    Binding(f"{MODIFIER} C", "Copy view as command", "File", (K.c,), cmd.CopyView, ctrl=True),
    Binding(f"{MODIFIER} M", "Save the film", "File", (K.m,), cmd.AskFilm, ctrl=True),
    Binding("T", "Levels", "Panels", (K.t,), lambda: cmd.Toggle("tree")),
    Binding("V", "Picture, levels, depth, coverage", "Panels", (K.v,), cmd.NextMode),
    Binding("F3", "Look behind, statistics", "Panels", (K.f3,), lambda: cmd.Toggle("statistics")),
    Binding(f"{MODIFIER} ,", "Settings", "Panels", (K.comma,), lambda: cmd.Toggle("settings"), True),
    Binding("K", "Keep: picture, film, command", "Panels", (K.k,), lambda: cmd.Toggle("keep")),
    Binding("F1", "This help", "Panels", (K.f1,), lambda: cmd.Toggle("help")),
    Binding("L", "Timeline of a film", "Film", (K.l,), lambda: cmd.Toggle("timeline")),
    Binding("I", "Add the view as a key", "Film", (K.i,), cmd.AddKey),
    Binding("Del", "Delete the selected key", "Film", (K.delete,), cmd.DeleteKey),
    Binding(",", "The key before", "", (K.comma,), lambda: cmd.StepKey(-1)),
    Binding(", and .", "The key before and after", "Film", (K.period,), lambda: cmd.StepKey(1)),
    Binding("Space", "Play the timeline, stop", "Film", (K.space,), cmd.TogglePlay),
    Binding(f"{MODIFIER} Q", "Close", "File", (K.q,), cmd.Close, ctrl=True),
)


def label_of(command: type[cmd.Command]) -> str:
    """Returns the key that gives a command, for tooltips; empty when there is none."""
    return next((b.label for b in BINDINGS if b.command is command), "")


def matches(binding: Binding, ctrl: bool, shift: bool) -> bool:
    """Whether the modifiers held are those of a binding."""
    return binding.ctrl == ctrl and (binding.shift == shift or not binding.ctrl)
