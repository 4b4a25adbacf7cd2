"""Files are read and written beside the frames: nothing waits, nothing is lost."""

import threading
from dataclasses import replace

import pytest

from tests.app.fakes import fake_services
from tests.app.test_documents import unsaved
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.errands import AtOnce, Errand, OnThread
from wzviewer.core.files import load_scene
from wzviewer.errors import InputError


@pytest.fixture
def gate():
    return threading.Event()


class Gated(OnThread):
    """Work that waits until the test lets it go."""

    def __init__(self, gate):
        super().__init__()
        self._gate = gate

    def start(self, errand, work):
        def late():
            assert self._gate.wait(10.0)
            return work()

        super().start(errand, late)


@pytest.fixture
def slow(gate):
    services = replace(fake_services(), errands=Gated(gate))
    yield services
    gate.set()
    services.errands.close()


def after(services, state):
    """The state of the first frame in which the errand has ended."""
    for _ in range(1000):
        state = drain(services, state, 0.0)
        if state.errand is None:
            return state
        threading.Event().wait(0.005)
    raise AssertionError("it never ends")


def test_a_save_holds_up_no_frame_and_is_of_the_moment_it_was_asked_for(slow, gate, tmp_path):
    state = apply(slow, unsaved(), [cmd.SaveTo(tmp_path / "s.wz")])
    assert state.errand is not None
    assert state.errand.line == "Saving s.wz"
    assert state.is_dirty
    state.scene.show(1)  # while it is being written: level 1 was hidden
    assert not list(tmp_path.iterdir())
    gate.set()
    state = after(slow, state)
    assert load_scene(tmp_path / "s.wz").visible() == [0]
    assert state.is_dirty  # of what is shown since
    assert state.path == tmp_path / "s.wz"


def test_leaving_waits_for_the_save(slow, gate, tmp_path):
    state = replace(unsaved(), path=tmp_path / "s.wz")
    state = apply(slow, state, [cmd.Close(), cmd.SettleUnsaved("save")])
    assert not state.is_closing
    gate.set()
    assert after(slow, state).is_closing
    assert len(load_scene(tmp_path / "s.wz")) == 2


def test_one_file_at_a_time(slow, tmp_path):
    state = apply(slow, unsaved(), [cmd.SaveTo(tmp_path / "s.wz"), cmd.SaveTo(tmp_path / "t.wz")])
    assert "saving s.wz" in state.toasts[-1].text


def test_a_save_that_fails_says_so_and_stays(slow, gate, tmp_path):
    state = apply(slow, unsaved(), [cmd.SaveTo(tmp_path / "no" / "s.wz")])
    gate.set()
    state = after(slow, state)
    assert state.toasts[-1].kind == "error"
    assert state.is_dirty
    assert state.path is None


@pytest.mark.parametrize("kind", [AtOnce, OnThread])
@pytest.mark.parametrize(
    ("error", "line"), [(None, ""), (InputError("x", "is odd"), "is odd"), (ValueError("deep"), "deep")]
)
def test_a_fault_of_the_work_is_a_line(kind, error, line):
    def work():
        if error is not None:
            raise error
        return 7

    errands = kind()
    errand = Errand("Working", None, None)
    errands.start(errand, work)
    ended = None
    for _ in range(1000):
        ended = errands.poll()
        if ended is not None:
            break
        threading.Event().wait(0.005)
    errands.close()
    assert ended[0] is errand
    assert ended[1] == (7 if error is None else None)
    assert line in ended[2]
    assert bool(ended[2]) == (error is not None)
    assert errands.poll() is None
