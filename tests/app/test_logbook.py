"""The log: bounded, complete, and gone when the app is."""

import logging
import threading
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.logbook import MAX_CHARACTERS, Logbook
from wzviewer.app.overlays import LogView

LOG = logging.getLogger("wzviewer.tests")


@pytest.fixture
def book():
    book = Logbook(capacity=50)
    book.attach()
    yield book
    book.detach()


def test_the_last_messages_are_kept_from_any_thread(book):
    def talk():
        for number in range(40):
            LOG.info("%d", number)

    threads = [threading.Thread(target=talk) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(book.lines()) == 50
    LOG.debug("too fine")
    LOG.warning("look out")
    assert [line.text for line in book.lines(logging.WARNING)] == ["look out"]
    assert book.lines()[-1].source == "tests"


def test_a_traceback_is_kept_as_far_as_it_helps(book):
    try:
        raise ValueError("x" * 3 * MAX_CHARACTERS + "the end")
    except ValueError:
        LOG.exception("failed")
    (line,) = book.lines(logging.ERROR)
    assert len(line.text) == MAX_CHARACTERS + 1
    assert line.text.endswith("the end")


def test_nothing_stays_behind():
    logger = logging.getLogger("wzviewer")
    before = (logger.level, list(logger.handlers))
    book = Logbook()
    book.detach()
    book.attach()
    book.detach()
    assert (logger.level, list(logger.handlers)) == before
    LOG.error("unheard")
    assert book.lines() == ()


def test_notices_faults_and_the_workers_news_are_in_it(book):
    services = fake_services()
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    services.client.fails = True
    camera = state.view.camera.zoomed(320.0, 210.0, 8.0)
    state = state.with_view(replace(state.view, camera=camera))
    state = apply(services, state, [cmd.Save(), cmd.Generate()])
    state = drain(services, state, 0.0)
    services.client.fails = False
    state = apply(services, state, [cmd.Generate()])
    for _ in range(8):
        state = drain(services, state, 0.0)
    texts = "\n".join(line.text for line in book.lines())
    assert "no level: worker out of memory" in texts
    assert "level 1 is finished, 12240 surfels" in texts
    assert "New detail is ready" in texts
    assert len([line for line in book.lines() if "is ready" in line.text]) == 1


def test_the_window_filters_copies_and_closes(screen, book):
    LOG.info("one")
    LOG.error("two")
    copied = []
    services = replace(fake_services(), log=book, copy=copied.append)
    state = replace(state_with(make_scene(1)), log=LogView(is_open=True))
    bottom, right = 400 + 260 - 12 - 17, 640 + 450 - 14
    assert screen.click(state, right - 46, bottom) == [cmd.ToggleLog()]
    assert screen.click(state, right - 92 - 8 - 46, bottom) == [cmd.CopyLog()]
    assert screen.click(state, 640 - 450 + 14 + 225, bottom - 3) == [cmd.SetLogLevel(logging.ERROR)]
    assert screen.click(state, 20, 20) == [cmd.ToggleLog()]
    assert screen.press(state, imgui.Key.g) + screen.press(state, imgui.Key.w) == []  # behind it
    assert screen.press(state, imgui.Key.s, imgui.Key.mod_ctrl) == [cmd.Save()]
    assert screen.press(state, imgui.Key.f12) == [cmd.ToggleLog()]
    assert screen.press(state, imgui.Key.escape) == [cmd.Escape()]
    state = apply(services, state, [cmd.SetLogLevel(logging.ERROR), cmd.CopyLog()])
    assert "two" in copied[0]
    assert "one" not in copied[0]
    state = apply(services, state, [cmd.Escape()])
    assert not state.log.is_open
    assert apply(services, state, [cmd.ToggleLog()]).log == LogView(True, logging.ERROR)


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
def test_it_draws_at_any_size(screen, book, size):
    for number in range(60):
        LOG.warning("%d %s", number, "word " * number)
    screen.width, screen.height, screen.log = *size, book.lines()
    state = replace(state_with(make_scene(1)), log=LogView(is_open=True))
    for _ in range(4):
        assert screen.frame(state) == []
