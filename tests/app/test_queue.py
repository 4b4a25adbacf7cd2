"""What is asked for while a request runs waits for its end."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.auto import is_waiting
from wzviewer.app.layout import arrange
from wzviewer.app.panels.waiting import wish_text
from wzviewer.app.viewing import advance
from wzviewer.app.wishes import MAX_WAITING


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def state(services):
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    return state


def at(state, x):
    camera = state.view.home.zoomed_to_region(x, 0.5, 8.0)
    return replace(state, view=replace(state.view, camera=camera, flight=None))


def ask(services, state, *wishes):
    for x, prompt in wishes:
        state = apply(services, at(state, x), [cmd.EditPrompt(prompt), cmd.Generate()])
    return state


def settle(services, state, frames=60):
    for _ in range(frames):
        state = replace(state, now_s=state.now_s + 1 / 30)
        state = drain(services, advance(state, 1 / 30), 0.0)
    return state


THREE = ((0.2, "a bird"), (0.5, "a cat"), (0.8, "a key"))


def test_wishes_are_made_one_after_the_other_where_they_were_asked_for(services, state):
    state = ask(services, state, *THREE)
    assert state.prompt == ""  # the line is free for the next one
    assert [goal.prompt for goal in state.queue.goals] == ["a cat", "a key"]
    camera = state.view.camera
    state = settle(services, state)
    assert [level.prompt for level in state.scene] == ["", "a bird", "a cat", "a key"]
    assert [level.parent for level in state.scene] == [None, 0, 0, 0]
    assert state.view.camera is camera  # nobody was flown about
    assert state.queue.goals == ()
    assert [e.kind for e in state.history.entries] == ["make"] * 3


def test_the_queue_has_an_end(services, state):
    state = ask(services, state, *((0.1 + 0.08 * k, f"a bird {k}") for k in range(MAX_WAITING + 2)))
    assert len(state.queue.goals) == MAX_WAITING
    assert "waiting already" in state.toasts[-1].text
    assert state.prompt == f"a bird {MAX_WAITING + 1}"  # nothing typed is lost


def test_one_can_be_taken_out(services, state):
    state = apply(services, ask(services, state, *THREE), [cmd.DropWish(0), cmd.DropWish(7)])
    assert [level.prompt for level in settle(services, state).scene] == ["", "a bird", "a key"]


@pytest.mark.parametrize("is_twice", [False, True])
def test_cancel_goes_on_with_the_next_and_a_second_one_ends_all(services, state, is_twice):
    state = apply(services, ask(services, state, *THREE), [cmd.Escape()])
    assert state.job.is_cancelling
    assert len(state.queue.goals) == 2
    later = settle(services, state, 2)
    assert later.job.prompt == "a cat"
    ended = settle(services, apply(services, later, [cmd.Escape()] if is_twice else []))
    assert [level.prompt for level in ended.scene][1:] == ([] if is_twice else ["a cat", "a key"])
    assert ended.queue.goals == ()
    assert ended.job is None


def test_a_late_second_escape_is_a_first_one(services, state):
    state = apply(services, ask(services, state, *THREE), [cmd.Escape()])
    state = replace(settle(services, state, 1), now_s=state.now_s + 3.0)
    state = settle(services, apply(services, state, [cmd.Escape()]))
    assert [level.prompt for level in state.scene][1:] in (["a cat", "a key"], ["a key"])
    assert state.queue.goals == ()


def test_a_refusal_does_not_hold_up_the_others(services, state):
    services.client.refuses.add("a bird")
    state = settle(services, ask(services, state, *THREE))
    assert [level.prompt for level in state.scene] == ["", "a cat", "a key"]


def test_a_cancelled_prompt_comes_back_to_the_empty_line(services, state):
    state = apply(services, ask(services, state, THREE[0]), [cmd.Escape()])
    assert settle(services, state, 3).prompt == "a bird"


def test_auto_detail_waits_until_nothing_waits(services, state):
    state = ask(services, state, *THREE)
    view = replace(state.view, focused=state.view.camera)
    state = replace(state, view=view, is_worker_ready=True, job=None)
    assert not is_waiting(state)
    assert is_waiting(apply(services, state, [cmd.ClearQueue()]))


def test_the_place_of_a_wish_may_have_become_finer_meanwhile(services, state):
    state = ask(services, state, (0.5, "a bird"), (0.5, "a cat"))
    state = at(state, 0.1)  # the user goes on
    state = settle(services, state)
    assert [level.parent for level in state.scene] == [None, 0, 1]
    assert state.scene.magnification(2) / state.scene.magnification(1) == pytest.approx(8.0, rel=0.05)


def test_chips_name_what_waits_and_take_it_out(screen, services, state):
    state = ask(services, state, *THREE)
    state = replace(state, view=state_with(state.scene, 1280, 800).view)
    assert [wish_text(state.scene, g) for g in state.queue.goals] == ["a cat", "a key"]
    for _ in range(3):
        screen.frame(state)
    found = set()
    rect = arrange(1280, 800, 1.0).prompt
    for x in range(int(rect.x) + 55, int(rect.right), 40):
        for y in range(int(rect.y) - 130, int(rect.y) - 70, 12):
            found |= set(screen.click(state, x, y))
    assert {cmd.DropWish(0), cmd.DropWish(1), cmd.ClearQueue()} <= found
