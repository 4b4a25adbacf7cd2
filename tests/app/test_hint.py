"""The hint on the first photo: once, until one has done what it says."""

from dataclasses import replace

import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.hint import is_shown
from wzviewer.app.panels.hint import place_of
from wzviewer.app.settings import Settings, SettingsFile
from wzviewer.app.state import empty_state

DOES = [cmd.Zoom(9.0, 9.0, 1.0), cmd.BeginDrag("pan", 9.0, 9.0), cmd.ZoomTo(9.0, 9.0), cmd.Generate()]


@pytest.mark.parametrize("command", [*DOES, cmd.DismissHint()])
def test_doing_what_it_says_takes_it_away_for_good(tmp_path, command):
    services = replace(fake_services(), store=SettingsFile(tmp_path / "settings.json"))
    state = state_with(make_scene(1))
    assert is_shown(state)
    assert is_shown(apply(services, state, [cmd.Toggle("help"), cmd.GoHome()]))
    state = apply(services, state, [command])
    assert not is_shown(state)
    assert services.store.load()[0].hint_seen


def test_it_waits_for_a_photo():
    state = apply(fake_services(), empty_state(640, 420), DOES[:1])
    assert not is_shown(state)
    assert not state.settings.hint_seen


def test_its_cross_takes_it_away(screen):
    state = state_with(make_scene(1))
    rect = place_of(screen.ui(), screen.ui().layout.tree.right, screen.width)
    assert screen.click(state, rect.right - 19, rect.y + 19) == [cmd.DismissHint()]
    seen = replace(state, settings=Settings(hint_seen=True))
    assert cmd.DismissHint() not in screen.click(seen, rect.right - 19, rect.y + 19)


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
def test_it_stands_clear_of_the_other_panels(screen, size):
    screen.width, screen.height = size
    ui = screen.ui()
    place, layout = place_of(ui, ui.layout.tree.right, size[0]), ui.layout
    for other in (layout.toolbar, layout.breadcrumb, layout.tree, layout.prompt, layout.status):
        assert not place.overlaps(other)
    assert place.right <= size[0]
