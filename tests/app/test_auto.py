"""Auto detail: asks where the view rests, and only there."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain, tick
from wzviewer.app.auto import AUTO_REST_S
from wzviewer.app.errands import Errand
from wzviewer.app.state import Drag, Panels
from wzviewer.app.viewing import refocus
from wzviewer.worker.client import PATIENT_S

REST_S = AUTO_REST_S + 0.01


def close_up(services, factor=6.0):
    """A finished photo, seen much closer than it is sharp, just after the motion."""
    state = replace(state_with(make_scene(1)), is_worker_ready=True)
    services.client.load(state.scene)
    camera = state.view.camera.zoomed(320.0, 210.0, factor)
    return state.with_view(replace(state.view, camera=camera))


def rested(services, state, seconds=REST_S, is_typing=False):
    state = replace(state, now_s=state.now_s + seconds)
    return tick(services, refocus(services, state), is_typing)


def asked(services):
    return [call for call in services.client.calls if call[0] == "synthesize"]


def test_rest_beyond_native_resolution_asks_once():
    services = fake_services()
    state = rested(services, close_up(services))
    assert asked(services) == [("synthesize", 0, "")]
    assert state.job.is_auto
    while state.job is not None:
        state = drain(services, state, 0.0)
    state = rested(services, rested(services, state))
    assert len(asked(services)) == 1  # there is a level as fine as the view now
    assert len(state.scene) == 2


def test_no_rest_no_request():
    services = fake_services()
    rested(services, close_up(services), 0.3)
    assert asked(services) == []


def test_a_sharp_view_asks_for_nothing():
    services = fake_services()
    rested(services, close_up(services, 1.5))
    assert asked(services) == []


BUSY = {
    "off": lambda s: replace(s, settings=replace(s.settings, auto_detail=False)),
    "opening": lambda s: replace(s, errand=Errand("Opening x.wz", None, None)),
    "words": lambda s: replace(s, prompt="a bird"),
    "dialog": lambda s: replace(s, panels=Panels(dialog="open")),
    "help": lambda s: replace(s, panels=Panels(help=True)),
    "drag": lambda s: replace(
        s, view=replace(s.view, drag=Drag("pan", s.view.camera, s.view.focus, 0.0, 0.0))
    ),
    "worker": lambda s: replace(s, is_worker_ready=False),
}


@pytest.mark.parametrize("why", BUSY)
def test_never_while_something_else_goes_on(why):
    services = fake_services()
    rested(services, BUSY[why](close_up(services)))
    assert asked(services) == []


def test_never_while_typing():
    services = fake_services()
    rested(services, close_up(services), is_typing=True)
    assert asked(services) == []


def test_undo_is_not_made_undone():
    services = fake_services()
    state = rested(services, close_up(services))
    while state.job is not None:
        state = drain(services, state, 0.0)
    state = apply(services, state, [cmd.Undo()])
    state = rested(services, state)
    assert len(asked(services)) == 1
    moved = state.view.camera.zoomed(320.0, 210.0, 1.1)
    rested(services, state.with_view(replace(state.view, camera=moved)))
    assert len(asked(services)) == 2


def test_a_cancelled_place_is_left_alone():
    services = fake_services()
    state = apply(services, rested(services, close_up(services)), [cmd.CancelJob()])
    while state.job is not None:
        state = drain(services, state, 0.0)
    assert rested(services, state).job is None


def test_a_request_of_ones_own_takes_the_place_of_an_auto_one():
    services = fake_services()
    state = rested(services, close_up(services))
    state = apply(services, state, [cmd.EditPrompt("a bird"), cmd.Generate()])
    assert state.job.is_cancelling
    assert services.client.grace_s == PATIENT_S  # to end the worker would cost more than to wait for it
    for _ in range(12):
        state = drain(services, state, 0.0)
    assert [level.prompt for level in state.scene] == ["", "a bird"]
    assert asked(services)[-1] == ("synthesize", 0, "a bird")


def test_the_key_switches_it_and_it_is_kept():
    class Store:
        kept = None

        def load(self):
            raise AssertionError

        def save(self, settings):
            self.kept = settings
            return "no room"

    services = replace(fake_services(), store=Store())
    state = apply(services, close_up(services), [cmd.ToggleAuto()])
    assert not state.settings.auto_detail
    assert services.store.kept == state.settings
    assert [t.kind for t in state.toasts] == ["error", "info"]
