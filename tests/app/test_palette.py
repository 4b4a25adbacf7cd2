"""Every command by its name: what is found, and how it is run."""

from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import HANDLERS, apply
from wzviewer.app.keys import BINDINGS
from wzviewer.app.overlays import PaletteView
from wzviewer.app.palette import entries_of, found, score
from wzviewer.app.panels.palette import shown
from wzviewer.app.recents import RecentFile, Recents
from wzviewer.app.settings import Settings
from wzviewer.app.state import Job, empty_state


@pytest.fixture
def state():
    return replace(state_with(make_scene(3)), palette=PaletteView(is_open=True))


def best(state, text):
    return found(entries_of(state), text)[0].title


@pytest.mark.parametrize(
    ("text", "title"),
    [
        ("undo", "Undo"),
        ("film", "Save the film"),
        ("sapi", "Save the picture"),
        ("picture save", "Save the picture"),
        ("svas", "Save as"),
        ("dark", "Panels: dark"),
        ("thing 2", "Go to level 2: thing 2"),
        ("THE DEMO", "Open the demo"),
        ("depth view", "View: depth"),
        ("f3", "Look behind, statistics"),
    ],
)
def test_a_few_letters_find_a_command(state, text, title):
    state = replace(state, settings=replace(state.settings, theme="light"))
    assert best(state, text) == title


def test_what_matches_nothing_finds_nothing(state):
    assert found(entries_of(state), "xyzzy") == []
    assert found(entries_of(state), "undo xyzzy") == []
    assert found(entries_of(state), "  ") == entries_of(state)
    assert score("ndo", "Undo") < score("und", "Undo")


def test_every_binding_and_every_entry_can_be_run(state):
    files = Recents((RecentFile(Path("/x/y.png"), 1.0),))
    state = replace(state, job=Job(1, "level", "", 0.0), recents=files, settings=Settings(hint_seen=True))
    entries = entries_of(state)
    titles = {entry.title for entry in entries}
    assert titles >= {b.what for b in BINDINGS if b.command not in (None, cmd.OpenPalette, cmd.Escape)}
    assert titles >= {"Cancel the request", "Open y.png", "Go to the photo", "Show the hint on photos"}
    assert all(type(entry.command) in HANDLERS for entry in entries)
    assert len(titles) == len(entries)


def test_keys_are_those_that_count(state):
    theirs = replace(state, settings=replace(state.settings, keymap="authors"))
    assert {e.title: e.keys for e in entries_of(theirs)}["New detail where you look"] == "R"


def test_the_start_page_offers_what_it_can():
    titles = {entry.title for entry in entries_of(empty_state(640, 420))}
    assert titles >= {"Open the demo", "Settings", "Close", "Log"}
    assert not titles & {"Save", "Undo", "View: depth", "Look behind, statistics"}


def test_typing_marks_and_enter_runs(screen, state):
    services = fake_services()
    for _ in range(3):
        assert screen.frame(state) == []
    screen.io.add_input_characters_utf8("save")
    state = apply(services, state, screen.frame(state))
    assert state.palette.text == "save"
    assert screen.press(state, imgui.Key.down_arrow) == [cmd.MarkEntry(1)]
    state = apply(services, state, [cmd.MarkEntry(1)])
    hits = found(entries_of(state), "save")
    assert screen.press(state, imgui.Key.enter) == [cmd.ClosePalette(), hits[1].command]
    assert not apply(services, state, [cmd.ClosePalette()]).palette.is_open


def test_keys_are_the_palettes_alone(screen, state):
    for _ in range(3):
        screen.frame(state)
    assert screen.press(state, imgui.Key.t) == []
    assert screen.press(state, imgui.Key.escape) == [cmd.ClosePalette()]


def test_a_click_runs_and_a_click_beside_closes(screen, state):
    row = (640, 0.12 * 800 + 12 + 34 + 8 + 17)
    first = found(entries_of(state), "")[0]
    assert screen.click(state, *row) == [cmd.ClosePalette(), first.command]
    assert cmd.ClosePalette() in screen.click(state, 100, 700)


def test_two_keys_open_it(screen):
    state = state_with(make_scene(1))
    K = imgui.Key
    assert screen.press(state, K.k, K.mod_ctrl) == [cmd.OpenPalette()]
    assert screen.press(state, K.p, K.mod_ctrl, K.mod_shift) == [cmd.OpenPalette()]
    assert apply(fake_services(), state, [cmd.OpenPalette()]).palette == PaletteView(True)


def test_the_marked_entry_is_in_view():
    assert shown(0, 5, 9) == (0, 5)
    assert shown(0, 40, 9) == (0, 9)
    assert shown(20, 40, 9) == (16, 9)
    assert shown(-1, 40, 9) == (31, 9)
    assert shown(41, 40, 9) == (0, 9)


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
@pytest.mark.parametrize("text", ["", "xyzzy"])
def test_it_draws_at_any_size(screen, state, size, text):
    screen.width, screen.height = size
    state = replace(state, palette=replace(state.palette, text=text))
    for _ in range(3):
        assert screen.frame(state) == []
