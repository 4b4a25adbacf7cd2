"""Where file dialogs begin."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.app.fakes import checker, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.folders import beginning, suggested
from wzviewer.app.recents import RecentFile, Recents
from wzviewer.app.state import empty_state
from wzviewer.core.photos import encode_png


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "shots" / "flower.png"
    path.parent.mkdir()
    path.write_bytes(encode_png(checker(136, 90)))
    return path


def test_what_is_made_of_a_photo_is_kept_beside_it(photo):
    services = fake_services()
    state = apply(services, empty_state(640, 420), [cmd.Open(photo)])
    assert state.source == photo
    assert apply(services, state, [cmd.AskOpen()]).panels.dialog_path == str(photo.parent)
    assert suggested(state, "scene", ".wz") == str(photo.with_suffix(".wz"))
    assert suggested(replace(state, path=Path("/other/x.wz")), "scene", ".png") == "/other/flower.png"


def test_the_demo_has_no_folder_to_keep_anything_in(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    state = apply(fake_services(), empty_state(640, 420), [cmd.OpenDemo()])
    assert state.photo is not None
    assert beginning(state) == tmp_path


def test_a_desktop_starts_where_nobody_works(monkeypatch, tmp_path):
    state = state_with(make_scene(1))
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.chdir("/")
    assert beginning(state) == tmp_path
    (tmp_path / "Pictures").mkdir()
    assert beginning(state) == tmp_path / "Pictures"
    files = (RecentFile(Path("/gone/a.wz"), 2.0, is_missing=True), RecentFile(Path("/there/b.wz"), 1.0))
    state = replace(state, recents=Recents(files))
    assert beginning(state) == Path("/there")
    monkeypatch.chdir(tmp_path)
    assert beginning(state) == Path("/there")
    monkeypatch.chdir("/usr")
    assert beginning(state) == Path("/usr")
