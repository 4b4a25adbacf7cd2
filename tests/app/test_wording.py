"""What panels say at a time, and the room that they take for it."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.errands import Errand
from wzviewer.app.layout import arrange
from wzviewer.app.overlays import PaletteView
from wzviewer.app.panels.frame import is_asking
from wzviewer.app.panels.status import status_line
from wzviewer.app.state import Panels, empty_state

NOTE = "The folder /home/me/pictures/of/a/long/way/that/is/not/there does not exist. Choose another folder. "


def asked(screen, state, question):
    """What a question that needs a frame is answered, a frame after the panels were drawn."""
    answers = []
    screen.frame(state)
    screen.frame(state, lambda state, ui: answers.append(question(state, ui)) or [])
    return answers[0]


def test_what_is_done_to_a_file_is_said_before_all_else(screen):
    errand = Errand("Saving a scene with a name", lambda *_: None, lambda *_: None)
    state = replace(state_with(make_scene(2)), errand=errand, name="a scene with a name.wz")
    for room in (110.0, 190.0, 400.0):
        assert asked(screen, state, lambda state, _, room=room: status_line(state, room)).startswith("Saving")


def test_what_is_not_the_picture_is_said_and_left_with_escape(screen):
    services, state = fake_services(), state_with(make_scene(2))
    for name in ("levels", "depth", "coverage"):
        state = apply(services, state, [cmd.NextMode()])
        assert [t.text.split(".")[0] for t in state.toasts] == [f"View: {name}"]  # the last one alone
        line = asked(screen, state, lambda state, _: status_line(state, 400.0))
        assert line == f"{name.capitalize()} · Esc for the picture"
    assert apply(services, state, [cmd.Escape()]).look.mode == "picture"


@pytest.mark.parametrize(
    ("count", "least", "most"), [(0, 148.0, 152.0), (1, 155.0, 175.0), (4, 200.0, 300.0)]
)
def test_a_dialog_is_as_high_as_what_it_says(screen, count, least, most):
    state = replace(state_with(make_scene(1)), panels=Panels(dialog="save", dialog_note=NOTE * count))
    for _ in range(3):
        screen.frame(state)
    dialog = imgui.internal.find_window_by_name("path")
    assert dialog.scroll_max.y == 0
    assert least < dialog.size.y < most  # measured: 150, 162, 234


def test_the_frame_of_the_next_level_is_about_the_prompt_alone(screen):
    state = replace(state_with(make_scene(2)), prompt="a bird")
    assert asked(screen, state, is_asking)
    for elsewhere in (
        replace(state, panels=Panels(dialog="save")),
        replace(state, palette=PaletteView(True)),
        replace(state, renaming=1),
    ):
        assert not asked(screen, elsewhere, is_asking)


def test_the_start_page_does_not_look_out_from_behind_a_dialog(screen):
    state = replace(empty_state(1280, 800), panels=Panels(dialog="open"))
    for _ in range(2):
        screen.frame(state)
    assert imgui.internal.find_window_by_name("start") is None
    assert imgui.internal.find_window_by_name("path").active


def test_also_what_cannot_be_pressed_now_is_explained(screen):
    bar = arrange(1280, 800, 1.0).toolbar
    state = state_with(make_scene(1))
    screen.move(bar.x + 8 + 106 + 15 + 17, bar.y + 23)  # Undo, of nothing
    for _ in range(60):
        screen.frame(state)
    tips = [window for window in imgui.get_current_context().windows if window.name.startswith("##Tooltip")]
    assert any(tip.active for tip in tips)
