"""What a crash leaves behind, and what it does not."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, tick
from wzviewer.app.errands import AtOnce
from wzviewer.app.journal import JournalFolder
from wzviewer.app.recovery import ask_to_recover, keep
from wzviewer.app.state import empty_state
from wzviewer.app.timeline import FIELD
from wzviewer.core.files import load_scene

ROOT = Path(__file__).parents[2]


@pytest.fixture
def journal(tmp_path):
    journal = JournalFolder(tmp_path, "one")
    yield journal
    journal.close()


def crashed(folder, scene, name="meadow.png"):
    """A session that nobody closed: its lock is free, its levels lie there."""
    journal = JournalFolder(folder, "crashed")
    journal.keep(scene, name)
    journal.wait()
    journal._lock.close()
    return folder / "crashed"


def test_a_session_is_read_again_bit_by_bit(tmp_path, journal):
    scene = make_scene(3)
    scene.hide(2)
    crashed(tmp_path, scene)
    left = journal.leftover()
    assert (left.name, left.count) == ("meadow.png", 3)
    assert left.what == "2 levels of meadow.png"  # one was hidden
    again = journal.recover(left)
    assert [level.prompt for level in again] == [level.prompt for level in scene]
    assert again.hidden == {2}
    assert np.array_equal(again[1].surfels.means, scene[1].surfels.means)
    assert np.array_equal(again[2].image, scene[2].image)


def test_a_new_level_is_written_once(tmp_path, journal):
    scene = make_scene(2)
    journal.keep(scene, "a")
    journal.wait()
    times = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "one").glob("*.level")}
    deeper = make_scene(3)[2]
    scene.append(deeper)
    journal.keep(scene, "a")  # still in the making: not kept
    journal.wait()
    assert len(list((tmp_path / "one").glob("*.level"))) == 2
    scene.commit(2)
    journal.keep(scene, "a")
    journal.wait()
    after = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "one").glob("*.level")}
    assert len(after) == 3
    assert times.items() <= after.items()


def test_a_saved_document_needs_none(tmp_path):
    services = replace(fake_services(), journal=JournalFolder(tmp_path / "journal", "own"))
    state = replace(state_with(make_scene(2)), saved=(1, frozenset()))
    tick(services, state, False)
    services.journal.wait()
    assert len(list((tmp_path / "journal" / "own").glob("*.level"))) == 2
    state = apply(services, state, [cmd.SaveTo(tmp_path / "x.wz")])
    tick(services, state, False)
    services.journal.wait()
    assert list((tmp_path / "journal" / "own").glob("*.level")) == []
    services.journal.close()
    assert list((tmp_path / "journal").iterdir()) == []


def test_a_session_that_lives_is_left_alone(tmp_path, journal):
    other = JournalFolder(tmp_path, "other")
    other.keep(make_scene(1), "a")
    other.wait()
    assert journal.leftover() is None
    other.close()
    assert journal.leftover() is None


def test_a_level_that_is_not_whole_ends_the_recovery(tmp_path, journal):
    folder = crashed(tmp_path, make_scene(3))
    (folder / "001.level").write_bytes(b"PK half of it")
    assert len(journal.recover(journal.leftover())) == 1
    (folder / "000.level").write_bytes(b"")
    (folder / "state.json").write_text("[" * 5000)
    with pytest.raises(ValueError, match="nothing"):
        journal.recover(journal.leftover())


@pytest.mark.parametrize("answer", ["recover", "discard"])
def test_the_question_and_its_answers(tmp_path, journal, answer):
    folder = crashed(tmp_path, make_scene(3))
    services = replace(fake_services(), journal=journal)
    state = ask_to_recover(services, empty_state(640, 420))
    assert state.panels.dialog == "recover"
    state = apply(services, state, [cmd.SettleRecovery(answer)])
    assert state.panels.dialog == ""
    journal.wait()
    assert not folder.exists()
    if answer == "recover":
        assert len(state.scene) == 3
        assert state.is_dirty
        assert len(list((tmp_path / "one").glob("*.level"))) == 3
    else:
        assert not state.has_document


def test_no_frame_waits_for_what_is_recovered_and_nothing_readable_is_a_notice(tmp_path, journal):
    class Held(AtOnce):
        def poll(self):
            return None

    crashed(tmp_path, make_scene(2))
    services = fake_services(journal=journal, errands=Held())
    asked = ask_to_recover(services, empty_state(640, 420))
    state = apply(services, asked, [cmd.SettleRecovery("recover")])
    assert state.errand.line.startswith("Bringing back ")
    assert not state.has_document
    for path in journal.leftover().folder.glob("*.level"):
        path.write_bytes(b"no level")
    services = replace(services, errands=AtOnce())
    state = apply(services, asked, [cmd.SettleRecovery("recover")])
    assert not state.has_document
    assert state.toasts[-1].text == "The levels could not be recovered: nothing in it can be read."


def test_what_was_recovered_is_saved_where_it_came_from(tmp_path, journal):
    source = Path("/photos/meadow.png")
    first = JournalFolder(tmp_path, "crashed")
    services = replace(fake_services(), journal=first)
    keep(services, replace(state_with(make_scene(2)), name="meadow.png", saved=(0, {}), source=source))
    first.wait()
    first._lock.close()
    services = replace(services, journal=journal)
    state = apply(services, ask_to_recover(services, empty_state(640, 420)), [cmd.SettleRecovery("recover")])
    assert state.source == source
    assert apply(services, state, [cmd.Save()]).panels.dialog_path == "/photos/meadow.wz"


def test_later_leaves_it_for_the_next_start(tmp_path, journal):
    crashed(tmp_path, make_scene(1))
    services = replace(fake_services(), journal=journal)
    state = apply(services, ask_to_recover(services, empty_state(640, 420)), [cmd.Escape()])
    assert state.panels.dialog == ""
    assert journal.leftover() is not None


def test_keys_of_the_timeline_come_back_after_a_crash(tmp_path, journal):
    crash = JournalFolder(tmp_path, "crashed")
    services = replace(fake_services(), journal=crash)
    state = replace(state_with(make_scene(2)), saved=(0, {}))
    state = apply(services, state, [cmd.AddKey()])
    tick(services, state, False)
    state = replace(state, view=replace(state.view, camera=state.view.camera.zoomed(300.0, 200.0, 4.0)))
    state = apply(services, state, [cmd.AddKey()])
    tick(services, state, False)  # the second key is the only change
    crash.wait()
    crash._lock.close()
    services = replace(fake_services(), journal=journal)
    again = apply(services, ask_to_recover(services, empty_state(640, 420)), [cmd.SettleRecovery("recover")])
    focals = [[key.camera.focal_px for key in s.timeline.path.keys] for s in (again, state)]
    assert len(focals[0]) == 2
    assert focals[0] == pytest.approx(focals[1])
    again = apply(services, again, [cmd.SaveTo(tmp_path / "again.wz")])
    assert FIELD in load_scene(tmp_path / "again.wz").unknown_fields


KILLED = """
import os, sys
from pathlib import Path
from tests.app.fakes import make_scene
from wzviewer.app.journal import JournalFolder
journal = JournalFolder(Path(sys.argv[1]), "killed")
journal.keep(make_scene(2), "photo.jpg")
journal.wait()
os._exit(9)
"""


def test_a_process_that_is_killed_leaves_its_levels(tmp_path, journal):
    command = [sys.executable, "-c", KILLED, str(tmp_path)]
    assert subprocess.run(command, cwd=ROOT, timeout=60).returncode == 9
    assert journal.leftover().count == 2
    assert len(journal.recover(journal.leftover())) == 2
