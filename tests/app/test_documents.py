"""Opening, saving, closing."""

from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from tests.app.fakes import FakeDialogs, checker, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain, tick
from wzviewer.app.documents import demo_photo
from wzviewer.app.services import Services
from wzviewer.app.state import Film, Goal, Job, empty_state
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.marks import Mark
from wzviewer.core.photos import encode_png


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    path.write_bytes(encode_png(checker(320, 200)))
    return path


def unsaved():
    state = state_with(make_scene(2))
    state.scene.hide(1)
    assert state.is_dirty
    return state


def test_a_photo_is_on_the_screen_at_once(services, photo):
    state = apply(services, empty_state(640, 420), [cmd.Open(photo)])
    assert state.photo.shape == (200, 320, 3)
    assert state.name == "photo.png"
    assert state.job.kind == "photo"
    assert services.client.calls[-1][0] == "reconstruct"


def test_a_scene_is_opened_and_is_clean(services, tmp_path):
    path = tmp_path / "s.wz"
    scene = make_scene(3)
    scene.set_mark(2, Mark("removed"))
    save_scene(scene, path)
    state = apply(services, empty_state(640, 420), [cmd.Open(path)])
    assert len(state.scene) == 3
    assert not state.is_dirty
    assert state.scene.visible() == [0, 1]
    assert apply(services, state, [cmd.Redo()]).scene.visible() == [0, 1, 2]
    assert services.client.calls[-1] == ("load", 3)
    assert state.view.magnification == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", ["missing.png", "missing.wz", "notes.txt"])
def test_a_bad_file_is_a_notice_and_keeps_the_document(services, tmp_path, name):
    (tmp_path / "notes.txt").write_text("hello")
    before = state_with(make_scene(1))
    state = apply(services, before, [cmd.Open(tmp_path / name)])
    assert state.toasts[-1].kind == "error"
    assert state.scene is before.scene


def test_saving_asks_for_a_path_by_text_where_there_are_no_dialogs(services, tmp_path):
    state = apply(services, unsaved(), [cmd.Save()])
    assert state.panels.dialog == "save"
    target = tmp_path / "out"
    state = apply(services, state, [cmd.EditPath(str(target)), cmd.ConfirmPath()])
    assert state.panels.dialog == ""
    assert not state.is_dirty
    assert len(load_scene(tmp_path / "out.wz")) == 2
    (tmp_path / "out.wz").unlink()
    apply(services, state, [cmd.Save()])  # the second time it knows where
    assert (tmp_path / "out.wz").exists()


def test_system_dialogs_are_used_where_there_are_some(tmp_path):
    services = Services(fake_services().client, fake_services().renderer, FakeDialogs([]))
    assert apply(services, unsaved(), [cmd.Save(), cmd.AskOpen()]).panels.dialog == ""


def test_a_place_that_cannot_be_written_is_a_notice(services, tmp_path):
    state = apply(services, unsaved(), [cmd.SaveTo(tmp_path / "no" / "folder" / "x.wz")])
    assert state.toasts[-1].kind == "error"
    assert state.is_dirty


@pytest.mark.parametrize(("answer", "closes"), [("stay", False), ("discard", True), ("save", True)])
def test_closing_asks_about_unsaved_levels(services, tmp_path, answer, closes):
    state = apply(services, unsaved(), [cmd.SaveTo(tmp_path / "s.wz")])
    state.scene.show(1)
    state = apply(services, state, [cmd.Close()])
    assert not state.is_closing
    assert state.panels.dialog == "unsaved"
    state = apply(services, state, [cmd.SettleUnsaved(answer)])
    assert state.is_closing is closes
    assert len(load_scene(tmp_path / "s.wz").visible()) == (2 if answer == "save" else 1)


def test_closing_after_saving_through_the_text_dialog(services, tmp_path):
    state = apply(services, unsaved(), [cmd.Close(), cmd.SettleUnsaved("save")])
    assert state.panels.dialog == "save"
    path = cmd.EditPath(str(tmp_path / "x.wz"))
    assert apply(services, state, [path, cmd.ConfirmPath()]).is_closing
    assert not apply(services, state, [cmd.Escape(), cmd.SaveTo(tmp_path / "y.wz")]).is_closing


def test_a_clean_document_closes_at_once(services):
    assert apply(services, state_with(make_scene(2)), [cmd.Close()]).is_closing


def test_closing_asks_about_a_level_that_is_being_made(services):
    clean = state_with(make_scene(2))
    goal = Goal(clean.view.camera, "a bird", clean.view.focus)
    making = replace(clean, job=Job(7, "level", "a bird", 0.0, goal=goal))
    asked = apply(services, making, [cmd.Close()])
    assert asked.panels.dialog == "making"
    assert not asked.is_closing
    assert not apply(services, asked, [cmd.Escape()]).panels.dialog
    assert apply(services, asked, [cmd.Close(gives_up=True)]).is_closing
    assert apply(services, asked, [cmd.Close()]).is_closing  # the window's own button, once more
    assert not tick(services, replace(asked, job=None), False).panels.dialog  # it is there: nothing to ask
    for nobody_waits in (replace(making.job, is_auto=True), replace(making.job, kind="photo")):
        assert apply(services, replace(clean, job=nobody_waits), [cmd.Close()]).is_closing


def test_what_closing_gives_up_and_what_is_unsaved_are_asked_one_after_the_other(services):
    state = unsaved()
    state = replace(state, job=Job(7, "level", "a bird", 0.0))
    state = apply(services, state, [cmd.Close(), cmd.Close(gives_up=True)])
    assert state.panels.dialog == "unsaved"


def test_opening_another_asks_first(services, photo):
    state = apply(services, unsaved(), [cmd.Open(photo)])
    assert state.panels.dialog == "unsaved"
    state = apply(services, state, [cmd.SettleUnsaved("discard")])
    assert state.name == "photo.png"
    assert len(state.scene) == 0


def test_the_picture_on_screen_is_saved(services, tmp_path):
    state = apply(services, state_with(make_scene(1)), [cmd.SavePicture(tmp_path / "view")])
    assert (tmp_path / "view.png").stat().st_size > 100
    assert state.toasts[-1].kind == "done"


def test_the_demo_is_there(services):
    assert demo_photo() is not None
    state = apply(services, empty_state(640, 420), [cmd.OpenDemo()])
    assert state.photo is not None
    assert Path(state.name).suffix == ".png"


def test_opening_another_waits_until_the_running_request_has_stopped(services, photo):
    state = apply(services, empty_state(640, 420), [cmd.Open(photo), cmd.Open(photo)])
    assert state.job.is_cancelling
    assert [call[0] for call in services.client.calls] == ["reconstruct", "cancel"]
    for _ in range(10):
        state = drain(services, state, 0.0)
    assert [call[0] for call in services.client.calls] == ["reconstruct", "cancel", "reconstruct"]
    assert len(state.scene) == 1
    assert state.toasts == ()


def given(services, state, text):
    return apply(services, state, [cmd.EditPath(str(text)), cmd.ConfirmPath()])


def test_a_path_that_leads_nowhere_can_be_mended_in_the_line(services, tmp_path):
    state = given(services, apply(services, unsaved(), [cmd.AskOpen()]), tmp_path / "flwer.jpg")
    assert state.panels.dialog == "open"
    assert "There is no flwer.jpg" in state.panels.dialog_note
    assert apply(services, state, [cmd.ConfirmPath()]).panels.dialog == "open"
    assert apply(services, state, [cmd.EditPath("x")]).panels.dialog_note == ""
    assert apply(services, state, [cmd.Escape()]).panels.dialog_note == ""
    assert given(services, state, tmp_path).panels.dialog_list.folder == tmp_path  # a folder is entered


def test_saving_by_text_into_no_folder_says_so(services, tmp_path):
    state = given(services, apply(services, unsaved(), [cmd.Save()]), tmp_path / "no" / "x.wz")
    assert state.panels.dialog_note == f"There is no folder {tmp_path / 'no'}."


def test_another_file_is_replaced_only_when_asked_twice(services, tmp_path):
    (tmp_path / "x.wz").write_text("mine")
    state = given(services, apply(services, unsaved(), [cmd.Save()]), tmp_path / "x")
    assert "is there already" in state.panels.dialog_note
    assert (tmp_path / "x.wz").read_text() == "mine"
    state = apply(services, state, [cmd.ConfirmPath()])
    assert state.panels.dialog == ""
    state = apply(services, state, [cmd.Save(asks=True)])
    assert given(services, state, tmp_path / "x.wz").panels.dialog == ""  # its own file


def test_closing_while_a_film_is_made_asks_once_and_then_obeys(services, tmp_path):
    state = replace(state_with(make_scene(2)), film=Film(tmp_path / "zoom.mp4", 0.0))
    asked = apply(services, state, [cmd.Close()])
    assert not asked.is_closing
    assert "film is not ready" in asked.toasts[-1].text
    assert apply(services, asked, [asked.toasts[-1].command]).is_closing
    late = replace(asked, now_s=asked.now_s + 60.0)  # the notice has gone: it is said again
    assert not apply(services, late, [cmd.Close()]).is_closing
    assert apply(
        services, replace(state, film=replace(state.film, is_cancelling=True)), [cmd.Close()]
    ).is_closing


def test_the_line_that_asks_where_to_save_has_the_cursor_after_the_question(screen):
    state = apply(fake_services(), unsaved(), [cmd.Close()])
    for _ in range(3):
        screen.frame(state)
    state = apply(fake_services(), state, screen.press(state, imgui.Key.enter))
    assert state.panels.dialog == "save"
    for _ in range(3):
        screen.frame(state)
    assert screen.io.want_text_input
