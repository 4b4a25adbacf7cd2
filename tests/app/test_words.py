"""The worker's words, kept between runs: refusals and offers while it still starts."""

import json
from dataclasses import replace

import pytest

from tests.app.fakes import WORDS, checker, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.generation import on_event
from wzviewer.app.picking import world_point
from wzviewer.app.prompting import with_vocabulary
from wzviewer.app.state import empty_state
from wzviewer.app.viewing import advance
from wzviewer.app.words import MAX_FILE_BYTES, MAX_WORD_CHARS, MAX_WORDS, WordFile, read_words
from wzviewer.core.photos import encode_png
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.worker import client as ev
from wzviewer.worker.models.builtin.objects import grammar


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cache" / "words.json"


def kept(path, words, **origin):
    file = WordFile(path, **origin)
    file.keep(words)
    file.close()
    return file


@pytest.mark.parametrize("words", [WORDS, grammar.vocabulary()])
def test_what_the_worker_said_is_known_at_the_next_start(path, words):
    assert WordFile(path).load() == Vocabulary()
    kept(path, words)
    assert WordFile(path).load() == words


def test_words_of_another_version_or_synthesizer_are_none(path):
    kept(path, WORDS, version="1.0")
    assert WordFile(path, version="1.0").load() == WORDS
    assert WordFile(path, version="1.1").load() == Vocabulary()
    assert WordFile(path, "other", version="1.0").load() == Vocabulary()


def test_it_is_written_only_when_it_has_changed(path):
    kept(path, WORDS)
    path.write_text(path.read_text() + " ")
    size = path.stat().st_size
    again = WordFile(path)
    again.keep(again.load())
    again.close()
    assert path.stat().st_size == size
    kept(path, Vocabulary(objects=("key",)))
    assert WordFile(path).load().objects == ("key",)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "7", '{"words": 3}', "[" * 100_000, "\xff", " " * (MAX_FILE_BYTES + 1)]
)
def test_a_damaged_file_counts_as_none(path, text):
    kept(path, WORDS)
    path.write_bytes(text.encode("latin-1"))
    assert WordFile(path).load() == Vocabulary()


def test_what_a_stranger_wrote_is_no_word_unless_it_is_short_and_printable():
    objects = ["key", "", " ", 3, None, ["a"], "a\nb", "x" * (MAX_WORD_CHARS + 1), "\x1b[2J", "beetle"]
    record = {"objects": objects, "places": "leaf", "qualities": ["w"] * (2 * MAX_WORDS), "more": ["x"]}
    words = read_words(record)
    assert words.objects == ("key", "beetle")
    assert words.places == ()
    assert len(words.qualities) == MAX_WORDS


def test_a_folder_that_cannot_be_written_is_no_fault(tmp_path):
    (tmp_path / "cache").write_text("a file")
    file = kept(tmp_path / "cache" / "words.json", WORDS)
    assert WordFile(file.path).load() == Vocabulary()


def test_an_unknown_word_is_refused_before_the_worker_is_ready_and_its_answer_counts(path):
    kept(path, WORDS)
    services, state = fake_services(), state_with(make_scene(1))
    state = with_vocabulary(state, WordFile(path).load())
    assert not state.is_worker_ready
    state = apply(services, state, [cmd.EditPrompt("a dragon"), cmd.Generate()])
    assert state.refusal.startswith("“dragon” is not known.")
    assert state.job is None
    assert ("synthesize", 0, "a dragon") not in services.client.calls
    state = on_event(services, state, ev.WorkerStarted(0, Vocabulary(objects=("dragon",), fillers=("a",))))
    assert state.reading.unknown == ()
    assert state.refusal == ""
    assert state.vocabulary.objects == ("dragon",)


def test_words_typed_while_the_photo_is_read_are_checked_and_wait_for_it(tmp_path):
    (tmp_path / "photo.png").write_bytes(encode_png(checker(640, 420)))
    services = fake_services()
    state = with_vocabulary(empty_state(640, 420), WORDS)
    state = apply(services, state, [cmd.Open(tmp_path / "photo.png")])
    assert len(state.scene) == 0
    assert state.job.kind == "photo"
    state = apply(services, state, [cmd.EditPrompt("a dragon"), cmd.Generate()])
    assert state.refusal.startswith("“dragon” is not known.")
    state = apply(services, state, [cmd.EditPrompt("a bird"), cmd.Generate(), cmd.Generate()])
    assert [goal.prompt for goal in state.queue.goals] == ["a bird"]
    assert state.prompt == ""
    assert state.toasts[-1].text.startswith("One moment")  # of the second, that had no words
    for _ in range(120):
        state = drain(services, advance(replace(state, now_s=state.now_s + 1 / 30), 1 / 30), 0.0)
    assert [level.prompt for level in state.scene] == ["", "a bird"]
    point = world_point(state.scene, services.renderer, state.view.home, 320, 210, 1.0)
    x, y, z = state.scene[1].camera.project(point)
    assert z > 0
    assert (x, y) == pytest.approx((state.scene[1].camera.width / 2, state.scene[1].camera.height / 2), abs=1)


def test_a_photo_that_is_given_up_keeps_what_waits_until_it_is_asked_for_again(tmp_path):
    (tmp_path / "photo.png").write_bytes(encode_png(checker(640, 420)))
    services = fake_services()
    state = apply(services, empty_state(640, 420), [cmd.Open(tmp_path / "photo.png")])
    state = apply(services, state, [cmd.EditPrompt("a bird"), cmd.Generate(), cmd.CancelJob()])
    for _ in range(5):
        state = drain(services, state, 0.0)
    assert state.job is None
    assert len(state.queue.goals) == 1
    assert not [t for t in state.toasts if t.kind == "error"]
    state = apply(services, state, [cmd.Generate()])
    for _ in range(120):
        state = drain(services, advance(replace(state, now_s=state.now_s + 1 / 30), 1 / 30), 0.0)
    assert [level.prompt for level in state.scene] == ["", "a bird"]


def test_the_answer_is_kept(path):
    services = fake_services(words=WordFile(path))
    on_event(services, state_with(make_scene(1)), ev.WorkerStarted(0, WORDS))
    services.words.close()
    assert json.loads(path.read_text())["words"]["objects"] == list(WORDS.objects)
