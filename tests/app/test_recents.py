"""Recent files: kept with a picture, and never a reason not to start."""

import json
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from tests.app.fakes import checker, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, tick
from wzviewer.app.journal import Leftover
from wzviewer.app.panels.recents import COLUMNS, extra_height
from wzviewer.app.recents import LIST, MAX_FILES, PICTURE_PX, PICTURES, RecentFile, RecentFolder, Recents
from wzviewer.app.state import Panels, empty_state
from wzviewer.core.files import save_scene
from wzviewer.core.photos import encode_png


@pytest.fixture
def folder(tmp_path):
    folder = RecentFolder(tmp_path / "state", clock=lambda: 1e9)
    yield folder
    folder.close()


def newest(folder):
    folder.wait()
    return folder.poll()


def test_a_file_is_at_the_top_with_its_picture(folder, tmp_path):
    names = ["a.png", "b.png", "a.png"]
    for seed, name in enumerate(names):
        (tmp_path / name).touch()
        folder.note(tmp_path / name, checker(800, 600, seed))
    files = newest(folder).files
    assert [f.path.name for f in files] == ["a.png", "b.png"]
    assert max(files[0].picture.shape) == PICTURE_PX
    folder.close()
    again = RecentFolder(folder._folder)
    kept = newest(again).files
    again.close()
    assert [f.path for f in kept] == [f.path for f in files]
    assert np.array_equal(kept[0].picture, files[0].picture)
    assert kept[0].opened_s == 1e9


def test_the_list_and_its_pictures_are_bounded(folder, tmp_path):
    for number in range(MAX_FILES + 3):
        folder.note(tmp_path / f"{number}.png", checker(64, 48))
    files = newest(folder).files
    assert [f.path.name for f in files] == [f"{n}.png" for n in range(MAX_FILES + 2, 2, -1)]
    assert len(list((folder._folder / PICTURES).iterdir())) == MAX_FILES
    assert all(f.is_missing for f in files)


def test_off_the_list_and_empty(folder, tmp_path):
    for name in ("a.png", "b.png"):
        folder.note(tmp_path / name, checker(64, 48))
    folder.remove(tmp_path / "a.png")
    assert [f.path.name for f in newest(folder).files] == ["b.png"]
    folder.clear()
    assert newest(folder).files == ()
    assert list((folder._folder / PICTURES).iterdir()) == []


def test_two_windows_share_the_list(folder, tmp_path):
    other = RecentFolder(folder._folder)
    other.note(tmp_path / "other.png", checker(64, 48))
    other.wait()
    folder.note(tmp_path / "own.png", checker(64, 48))
    assert [f.path.name for f in newest(folder).files] == ["own.png", "other.png"]
    other.close()


@pytest.mark.parametrize("text", ["", "{", "[]", "[" * 5000, '{"files": 3}', "\x00", "x" * (1 << 19)])
def test_a_damaged_list_begins_anew_and_says_so(tmp_path, text):
    (tmp_path / LIST).write_text(text)
    folder = RecentFolder(tmp_path)
    news = newest(folder)
    assert news.files == ()
    assert "begins anew" in news.complaint
    folder.note(tmp_path / "a.png", checker(64, 48))
    assert [f.path.name for f in newest(folder).files] == ["a.png"]
    folder.close()


def test_malformed_entries_are_left_out(tmp_path):
    good = {"path": str(tmp_path / "a.png"), "opened_s": 5}
    bad = [{"path": "relative.png"}, {"path": "\0"}, {"path": 3}, {"path": "/" + "x" * 9999}, 7, None]
    bad += [{"path": "/x", "opened_s": value} for value in ("1", None, True, 10**400, -1, float("nan"))]
    entries = [*({"opened_s": 1, **b} if isinstance(b, dict) else b for b in bad), good, good]
    (tmp_path / LIST).write_text(json.dumps({"files": entries}))
    folder = RecentFolder(tmp_path)
    news = newest(folder)
    folder.close()
    assert [(f.path.name, f.opened_s) for f in news.files] == [("a.png", 5.0)]
    assert news.complaint == ""


def test_a_damaged_picture_is_no_picture(tmp_path):
    folder = RecentFolder(tmp_path)
    folder.note(tmp_path / "a.png", checker(64, 48))
    folder.close()
    (place,) = (tmp_path / PICTURES).iterdir()
    place.write_bytes(place.read_bytes()[:60])
    again = RecentFolder(tmp_path)
    assert newest(again).files[0].picture is None
    again.close()


def test_a_folder_that_cannot_be_written_stops_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    folder = RecentFolder(tmp_path / "file" / "state")
    folder.note(tmp_path / "a.png", checker(64, 48))
    folder.wait()
    folder.clear()
    folder.wait()
    folder.close()


def test_opening_and_saving_are_noted_and_the_demo_is_not(folder, tmp_path):
    services = replace(fake_services(), recents=folder)
    (tmp_path / "photo.png").write_bytes(encode_png(checker(320, 200)))
    save_scene(make_scene(2), tmp_path / "s.wz")
    for command in (cmd.OpenDemo(), cmd.Open(tmp_path / "photo.png"), cmd.Open(tmp_path / "s.wz")):
        state = apply(services, empty_state(640, 420), [command])
    state = apply(services, state, [cmd.SaveTo(tmp_path / "t.wz"), cmd.Open(tmp_path / "missing.wz")])
    folder.wait()
    state = tick(services, state, False)
    assert [f.path.name for f in state.recents.files] == ["t.wz", "s.wz", "photo.png"]
    assert not any(f.is_missing for f in state.recents.files)
    state = apply(services, state, [cmd.RemoveRecent(tmp_path / "s.wz")])
    assert [f.path.name for f in state.recents.files] == ["t.wz", "photo.png"]
    state = apply(services, state, [cmd.Open(tmp_path / "photo.png")])
    assert len(state.recents.files) == 2
    assert apply(services, state, [cmd.ClearRecents()]).recents.files == ()


def test_the_complaint_is_a_notice(tmp_path):
    (tmp_path / LIST).write_text("{")
    services = replace(fake_services(), recents=RecentFolder(tmp_path))
    services.recents.wait()
    state = tick(services, state_with(make_scene(1)), False)
    services.recents.close()
    assert "begins anew" in state.toasts[-1].text


def page(count=5, missing=False):
    files = tuple(RecentFile(Path(f"/photos/{n}.jpg"), 1e9, None, missing) for n in range(count))
    return replace(empty_state(1280, 800), recents=Recents(files))


def card(screen, state, number):
    """The upper left corner of a card of the first row, imgui units."""
    extra, _ = extra_height(state, screen.ui())
    top = (800 - 274 - extra) / 2
    width = (660 - 64 - 30) / COLUMNS
    return (1280 - 660) / 2 + 32 + number * (width + 10), top + 274 + 40 - 16, width


def test_a_card_opens_its_file_and_its_cross_takes_it_off(screen):
    state = page()
    x, y, width = card(screen, state, 1)
    assert screen.click(state, x + 30, y + 50) == [cmd.Open(Path("/photos/1.jpg"))]
    assert screen.click(state, x + width - 14, y + 14) == [cmd.RemoveRecent(Path("/photos/1.jpg"))]
    assert screen.click(state, 1280 / 2 + 330 - 32 - 30, y - 18) == [cmd.ClearRecents()]


def test_what_a_crash_left_behind_stays_at_hand(screen):
    state = replace(page(0), leftover=Leftover(Path("x"), "meadow.png", 3), panels=Panels())
    assert screen.click(state, 640, (800 + 274 + 48) / 2 - 28 - 16) == [cmd.SettleRecovery("recover")]


def test_the_page_comes_over_a_document_and_goes(screen):
    opened = state_with(make_scene(1), 1280, 800)
    K = imgui.Key
    assert screen.press(opened, K.o, K.mod_ctrl, K.mod_shift) == [cmd.Toggle("start")]
    state = apply(fake_services(), replace(opened, recents=page().recents), [cmd.Toggle("start")])
    x, y, _ = card(screen, state, 1)
    assert screen.click(state, x + 30, y + 50) == [cmd.Open(Path("/photos/1.jpg"))]
    assert screen.click(state, 40, 700) == [cmd.Toggle("start")]
    assert not apply(fake_services(), state, [cmd.Escape()]).panels.start


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
@pytest.mark.parametrize("missing", [False, True])
def test_the_page_draws_at_any_size(screen, size, missing):
    screen.width, screen.height = size
    state = replace(page(12, missing), leftover=Leftover(Path("x"), "", 1))
    for _ in range(3):
        assert screen.frame(state) == []
    extra, rows = extra_height(state, screen.ui())
    assert 274 + extra <= size[1] - 16 or rows == 0


def test_nothing_is_read_before_the_first_frame(tmp_path):
    before = threading.active_count()
    folder = RecentFolder(tmp_path)
    assert threading.active_count() == before  # a worker may be started now: nothing is being imported
    folder.poll()
    assert threading.active_count() == before + 1
    folder.close()
