"""Merged forms made beside the frames; whatever goes wrong, the exact surfels stand in."""

import logging
import threading
from dataclasses import replace

import pytest

from tests.core.builders import small_scene
from tests.gl.gates import PATIENCE_S, Gate
from tests.gl.surfaces import hill_scene
from wzviewer.gl import merging
from wzviewer.gl.arrivals import Arrivals
from wzviewer.gl.merging import MERGED_CELLS_PX, MergeQueue
from wzviewer.gl.pages import Pages
from wzviewer.gl.renderer import SurfelRenderer


class MergeGate(Gate):
    """Holds back `merged` on the thread; gives the first surfels of a level for its merged ones."""

    def __init__(self, monkeypatch):
        super().__init__()
        self.merged = []
        monkeypatch.setattr(merging, "merged", self)

    def __call__(self, surfels, camera, frame, cell_px):
        if cell_px == MERGED_CELLS_PX[0]:
            self.merged.append(surfels)
            self.pass_through()
        assert self.open.wait(PATIENCE_S)
        return surfels.take(slice(0, len(surfels) // cell_px**2 + 1))


@pytest.fixture
def gate(monkeypatch):
    made = MergeGate(monkeypatch)
    yield made
    made.open.set()


@pytest.fixture
def merges():
    made = MergeQueue()
    yield made
    made.close()


def finish(merges, num_levels=99):
    while merges.is_busy:
        merges.wait()
        merges.collect(num_levels)


def test_forms_come_back_finest_first(merges):
    level = small_scene(1)[0]
    merges.ask(level)
    merges.ask(level)  # once is enough
    finish(merges)
    forms = merges.forms(level)
    assert len(forms) == len(MERGED_CELLS_PX)
    assert len(level.surfels) >= len(forms[0]) >= len(forms[1]) > 0


def test_each_version_is_merged_once(merges, gate):
    level = small_scene(1)[0]
    for _ in range(3):
        merges.ask(level)
        finish(merges)
    assert gate.merged == [level.surfels]


def test_the_result_of_a_level_that_was_replaced_is_dropped(merges, gate):
    old = small_scene(1)[0]
    new = replace(old, surfels=old.surfels.take(slice(0, 30)))
    gate.open.clear()
    merges.ask(old)
    assert gate.entered.acquire(timeout=PATIENCE_S)
    merges.ask(new)
    gate.open.set()
    finish(merges)
    assert merges.forms(old) == ()
    assert len(merges.forms(new)[0]) == 30 // 4 + 1


def test_levels_that_are_gone_are_forgotten(merges, gate):
    scene = small_scene(2)
    for level in scene:
        merges.ask(level)
    finish(merges, num_levels=1)
    assert merges.forms(scene[0])
    assert merges.forms(scene[1]) == ()


def test_an_error_leaves_the_exact_surfels(merges, monkeypatch, caplog):
    scene = small_scene(2)

    def fails(surfels, *_):
        if surfels is scene[0].surfels:
            raise MemoryError("no room to merge")
        return surfels.take(slice(0, 5))

    monkeypatch.setattr(merging, "merged", fails)
    arrivals = Arrivals(Pages())
    with caplog.at_level(logging.ERROR):
        while not arrivals.sync(scene, None, merges) or merges.is_busy:
            merges.wait()
    assert [len(state.sets) for state in arrivals.states.values()] == [1, 1 + len(MERGED_CELLS_PX)]
    assert "no room to merge" in caplog.text
    for _ in range(3):  # and it is not tried again
        arrivals.sync(scene, None, merges)
        assert not merges.is_busy


def test_closing_drops_what_waits(gate):
    merges, scene = MergeQueue(), small_scene(3)
    gate.open.clear()
    for level in scene:
        merges.ask(level)
    assert gate.entered.acquire(timeout=PATIENCE_S)
    closing = threading.Thread(target=merges.close)
    closing.start()
    gate.open.set()
    closing.join(PATIENCE_S)
    assert not closing.is_alive()
    assert len(gate.merged) == 1
    assert not merges.is_busy
    merges.wait()  # for nothing
    assert all(thread.name != "merging" for thread in threading.enumerate())


def test_a_closed_queue_can_be_used_again(merges, gate):
    scene = small_scene(2)
    merges.ask(scene[0])
    finish(merges)
    merges.close()
    for level in scene:
        merges.ask(level)
    finish(merges)
    assert merges.forms(scene[0])
    assert merges.forms(scene[1])
    assert gate.merged == [scene[0].surfels, scene[1].surfels]


def test_forms_outlive_the_rasteriser_that_they_were_made_for(merges, gate):
    """The kernels take over from the shaders in the middle of a session."""
    scene = small_scene(2)
    for _ in range(2):
        arrivals = Arrivals(Pages())
        while not arrivals.sync(scene, None, merges) or merges.is_busy:
            merges.wait()
        assert [len(s.sets) for s in arrivals.states.values()] == [1 + len(MERGED_CELLS_PX)] * 2
    assert len(gate.merged) == 2


@pytest.mark.gl
@pytest.mark.parametrize("rasterizer", ["shaders", "kernels"])
def test_frames_that_want_forms_that_cannot_be_made_come_to_rest(gl_context, monkeypatch, rasterizer):
    def fails(*_):
        raise MemoryError("no room to merge")

    monkeypatch.setattr(merging, "merged", fails)
    scene = hill_scene()
    renderer = SurfelRenderer(gl_context, rasterizer)
    renderer.sync(scene)
    camera = scene[0].camera.zoomed(20.0, 14.0, 0.1)
    first = renderer.render(camera)
    version, picture = renderer.version, first.read_color()
    for _ in range(3):
        renderer.sync(scene)
        again = renderer.render(camera)
        assert (again.read_color() == picture).all()
        assert renderer.version == version
    assert picture[..., 3].max() > 0.5
    renderer.release()
