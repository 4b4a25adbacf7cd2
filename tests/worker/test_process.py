"""The whole loop with the real worker, on a small picture."""

import os
import signal
import time

import numpy as np
import pytest

from wzviewer.core.scene import PHOTO, Scene
from wzviewer.worker.client import (
    LevelDropped,
    LevelFinished,
    LevelPreviewed,
    StageProgressed,
    WorkerClient,
    WorkerLost,
    WorkerStarted,
)
from wzviewer.worker.models.builtin.objects import grammar

START_LIMIT_S = 300.0  # a cold machine compiles every kernel here
LEVEL_LIMIT_S = 300.0


def photo():
    """A small landscape: sky, ground, a box."""
    rng = np.random.default_rng(3)
    y = np.mgrid[0:112, 0:160][0]
    image = np.where(y[..., None] < 45, [150, 180, 220], [90, 120, 60]).astype(float)
    image[30:80, 60:95] = [170, 90, 60]
    image += rng.normal(0, 6, image.shape) * (y[..., None] > 45)
    return np.clip(image, 0, 255).astype(np.uint8)


def finer():
    """The same with more pixels: what a camera with a better sensor saw."""
    return np.repeat(np.repeat(photo(), 3, axis=0), 3, axis=1)


def digest(level):
    arrays = [*level.surfels.arrays().values(), level.image, level.relief, *level.maps.values()]
    return [a.tobytes() for a in arrays]


class Session:
    """A client with the scene that its finished levels make up."""

    def __init__(self):
        self.client = WorkerClient()
        self.client.start()
        self.started = self.wait_for(WorkerStarted, START_LIMIT_S)
        self.scene = Scene()

    def wait_for(self, kind, limit_s=LEVEL_LIMIT_S, when=lambda e: True):
        """Returns the first event of a kind; ``seen`` then holds all that came with and before it."""
        deadline, self.seen = time.perf_counter() + limit_s, []
        while time.perf_counter() < deadline:
            for event in self.client.poll(0.02):
                self.seen.append(event)
                if isinstance(event, LevelFinished):
                    self.scene.append(event.level)
                    self.scene.commit(event.level.index)
            found = [e for e in self.seen if isinstance(e, kind) and when(e)]
            if found:
                return found[0]
            self.client.channel_wait(0.02)
        raise AssertionError(f"no {kind.__name__} among {[type(e).__name__ for e in self.seen]}")

    def ask(self, prompt="", parent=0, seed=1):
        camera = self.scene[parent].camera.zoomed_to_region(0.48, 0.5, 8.0)
        return self.client.synthesize(parent, camera, prompt, seed)


@pytest.fixture(scope="module")
def session():
    session = Session()
    session.client.reconstruct(photo(), 5, finer())
    session.wait_for(LevelFinished)
    yield session
    session.client.close()


def test_a_level_is_previewed_refined_and_finished(session):
    before = digest(session.scene[0])
    session.ask("a ladybug")
    level = session.wait_for(LevelFinished).level
    stages = [e.stage for e in session.seen if isinstance(e, StageProgressed)]
    revisions = [e.revision for e in session.seen if isinstance(e, LevelPreviewed)]
    assert sorted(set(stages)) == [1, 2, 3, 4, 5]
    assert stages == sorted(stages)
    assert revisions == [0, 1, 2, 3]  # as it is, with what was asked for, complete, optimised
    assert digest(session.scene[0]) == before
    assert (level.index, level.parent, level.prompt) == (1, 0, "a ladybug")
    assert set(level.stages) >= {"new scale image", "depth registration", "optimisation"}
    assert level.notes["placements"][0]["name"] == "ladybug"
    assert level.notes["consistency_db"] >= 40.0
    assert np.isfinite(level.relief).all()
    assert len(level.surfels) >= 160 * 112


def test_the_first_level_keeps_the_photograph_for_the_zooms(session):
    np.testing.assert_array_equal(session.scene[0].maps[PHOTO], finer())


def test_a_worker_that_is_ready_says_which_words_it_knows(session):
    assert session.started.vocabulary == grammar.vocabulary()


@pytest.mark.parametrize("stage", [1, 2, 3, 4, 5])
def test_a_worker_killed_in_any_stage_loses_no_finished_level(session, stage):
    count, before = len(session.scene), [digest(level) for level in session.scene]
    request_id = session.ask("a ladybug", seed=40 + stage)
    session.wait_for(StageProgressed, when=lambda e: e.stage == stage)
    os.kill(session.client.pid, signal.SIGKILL)
    dropped = session.wait_for(LevelDropped)
    assert dropped.request_id == request_id
    assert "signal 9" in dropped.why
    assert any(isinstance(e, WorkerLost) for e in session.seen)
    assert [digest(level) for level in session.scene] == before
    session.wait_for(WorkerStarted)
    assert len(session.scene) == count


def test_after_a_restart_levels_are_replayed_and_the_same_seed_gives_the_same_bytes(session):
    session.ask(seed=77)
    first = session.wait_for(LevelFinished).level
    os.kill(session.client.pid, signal.SIGKILL)
    session.wait_for(WorkerStarted)
    session.ask(seed=77)
    assert digest(session.wait_for(LevelFinished).level) == digest(first)


@pytest.mark.parametrize("stage", [1, 2, 4, 5])
def test_a_cancel_is_answered_within_a_second(session, stage):
    session.ask("a ladybug", seed=60 + stage)
    session.wait_for(StageProgressed, when=lambda e: e.stage == stage)
    start_s = time.perf_counter()
    session.client.cancel()
    dropped = session.wait_for(LevelDropped)
    assert dropped.cancelled
    assert time.perf_counter() - start_s < 1.0  # grace 0.7 s, then the process is replaced
    if not session.client.ready:
        session.wait_for(WorkerStarted)


def test_a_prompt_that_is_not_understood_is_refused_with_the_known_words(session):
    session.ask("a zeppelin made of soup")
    dropped = session.wait_for(LevelDropped)
    assert dropped.bad_input
    assert "ladybug" in dropped.hint


def test_a_cutout_travels_to_the_worker_and_becomes_a_level(session):
    pixels = np.zeros((40, 30, 4), np.uint8)
    pixels[5:35, 5:25] = (250, 20, 240, 255)
    camera = session.scene[0].camera.zoomed_to_region(0.3, 0.7, 8.0)
    session.client.synthesize(0, camera, "a magenta card, not read", 4, pixels)
    level = session.wait_for(LevelFinished).level
    red, green, blue = level.image.astype(int).transpose(2, 0, 1)
    share = ((red > green + 80) & (blue > green + 80)).mean()
    assert 0.05 < share < 0.4  # measured 0.16 of the picture
    assert level.prompt == "a magenta card, not read"
    assert level.notes["cutout"] is True
    session.client.synthesize(0, camera, "nothing", 4, np.zeros((40, 30, 4), np.uint8))
    assert session.wait_for(LevelDropped).bad_input


def test_a_level_over_an_older_one_shows_it(session):
    card = session.scene[-1]
    assert card.notes["cutout"] is True
    aside = session.scene[0].camera.zoomed_to_region(0.32, 0.7, 8.0)
    session.client.synthesize(0, aside, "", 5, beside=[card.index])
    level = session.wait_for(LevelFinished).level
    shift = round(0.02 * 8 * 160)
    before, after = card.image[:, shift:].astype(int), level.image[:, :-shift].astype(int)
    there = (before[..., 0] > before[..., 1] + 80) & (before[..., 2] > before[..., 1] + 80)
    assert there.mean() > 0.1  # measured .183
    assert (np.abs(before - after).max(-1) < 30)[there].mean() > 0.95  # measured .999
