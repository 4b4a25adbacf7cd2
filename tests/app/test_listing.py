"""Choosing a file where the desktop has no dialogs for it."""

import os
from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.errands import AtOnce
from wzviewer.app.listing import folder_of, listed, matching
from wzviewer.app.state import Panels, empty_state


@pytest.fixture
def folder(tmp_path):
    for name in ("Zoo.JPG", "a flower.png", "scene.wz", "notes.txt", ".hidden.png"):
        (tmp_path / name).touch()
    (tmp_path / "Holiday").mkdir()
    (tmp_path / "Holiday" / "beach.jpg").touch()
    return tmp_path


def test_a_folder_shows_what_can_be_opened(folder):
    found = listed("open", str(folder))
    assert found.folders == ("Holiday",)
    assert found.files == ("a flower.png", "scene.wz", "Zoo.JPG")
    assert listed("open path", str(folder)).files == ()
    assert listed("save", str(folder)) is None


def test_a_folder_is_read_once(folder):
    found = listed("open", str(folder))
    assert listed("open", str(folder / "a fl"), found) is found
    assert listed("open", str(folder / "Holiday") + os.sep, found).files == ("beach.jpg",)


def test_what_is_typed_narrows_the_list(folder):
    found = listed("open", str(folder))
    assert matching(found, str(folder / "flow")).files == ("a flower.png",)
    assert matching(found, str(folder / "ho")).folders == ("Holiday",)
    for whole in (folder, str(folder) + os.sep, folder / "scene.wz"):
        assert matching(found, str(whole)) == found


def test_nothing_is_a_folder_too(tmp_path):
    assert listed("open", str(tmp_path / "no" / "such")).files == ()
    assert folder_of("~").is_absolute()


def test_clicks_enter_choose_and_open(screen, folder, monkeypatch):
    monkeypatch.chdir(folder)
    services, state = fake_services(), empty_state(1280, 800)
    state = apply(services, state, [cmd.AskOpen()])
    assert state.panels.dialog == "open"
    for _ in range(3):
        screen.frame(state)
    rows = rows_of(screen, state)
    state = apply(services, state, screen.click(state, *rows["folder Holiday"]))
    assert state.panels.dialog_list.folder == folder / "Holiday"
    rows = rows_of(screen, state)
    state = apply(services, state, screen.click(state, *rows["file beach.jpg"]))
    assert state.panels.dialog_path == str(folder / "Holiday" / "beach.jpg")
    rows = rows_of(screen, state)
    state = apply(services, state, screen.click(state, *rows["up"]))
    assert state.panels.dialog_list.folder == folder


def rows_of(screen, state):
    """Where the rows of the list are drawn."""
    from imgui_bundle import imgui

    found, draw = {}, imgui.selectable

    def noting(label, *arguments):
        result = draw(label, *arguments)
        upper, lower = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        found[label.removeprefix("##")] = ((upper.x + lower.x) / 2, (upper.y + lower.y) / 2)
        return result

    imgui.selectable = noting
    try:
        screen.frame(state)
    finally:
        imgui.selectable = draw
    return found


def test_escape_closes_the_list(folder, monkeypatch):
    monkeypatch.chdir(folder)
    state = replace(state_with(make_scene(1)), panels=Panels())
    state = apply(fake_services(), state, [cmd.AskOpen(), cmd.Escape()])
    assert state.panels.dialog == ""


def test_a_folder_is_read_beside_the_frames(folder, monkeypatch):
    monkeypatch.chdir(folder)
    waiting = Waiting()
    services, state = replace(fake_services(), errands=waiting), empty_state(1280, 800)
    state = apply(services, state, [cmd.AskOpen()])
    assert state.errand is not None
    assert not state.panels.dialog_list.is_read
    assert apply(services, state, [cmd.EditPath(str(folder / "Zo"))]).errand is state.errand  # once
    waiting.work_now()
    state = drain(services, state, 0.0)
    assert state.errand is None
    assert state.panels.dialog_list.files == ("a flower.png", "scene.wz", "Zoo.JPG")
    # A question that is asked next would leave room for it.
    assert apply(services, state, [cmd.Escape()]).panels.dialog_list is None


class Waiting(AtOnce):
    """A disk that takes its time."""

    def start(self, errand, work):
        self._begun = errand, work

    def work_now(self):
        super().start(*self._begun)


@pytest.mark.parametrize(("typed", "goes_to"), [("flow", "a flower.png"), ("hol", "Holiday"), ("o", None)])
def test_the_one_name_that_is_left_in_the_list_is_meant(folder, monkeypatch, typed, goes_to):
    monkeypatch.chdir(folder)
    state = apply(fake_services(), empty_state(640, 420), [cmd.AskOpen()])
    state = apply(fake_services(), state, [cmd.EditPath(str(folder / typed)), cmd.ConfirmPath()])
    if goes_to == "a flower.png":  # it was opened, and is no picture
        assert state.panels.dialog == ""
        assert any(goes_to in toast.text for toast in state.toasts)
    elif goes_to:
        assert state.panels.dialog_path == str(folder / goes_to) + os.sep
    else:
        assert "There is no o" in state.panels.dialog_note


def test_enter_opens_the_file_that_was_clicked(screen, folder, monkeypatch):
    monkeypatch.chdir(folder)
    state = apply(fake_services(), empty_state(1280, 800), [cmd.AskOpen()])
    for _ in range(3):
        screen.frame(state)
    state = apply(fake_services(), state, screen.click(state, *rows_of(screen, state)["file Zoo.JPG"]))
    assert state.panels.dialog_path == str(folder / "Zoo.JPG")
    from imgui_bundle import imgui

    assert screen.press(state, imgui.Key.enter) == [cmd.ConfirmPath()]
