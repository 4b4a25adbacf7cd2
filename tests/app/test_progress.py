"""The progress plate and the button beside the prompt line."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from tests.app.fakes import WORDS, fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.layout import arrange
from wzviewer.app.panels.prompt import LONG_STEP_S, below_bar, headline, is_first, newest
from wzviewer.app.prompting import with_vocabulary
from wzviewer.app.state import Job, Panels, StageNote
from wzviewer.worker.models.builtin.objects import grammar

NOTES = (StageNote(1, "new scale image", 0.0), StageNote(2, "depth registration", 1.0))


def making(**changes):
    job = replace(Job(1, "level", "a bird", 0.0, NOTES, 0.3), **changes)
    return replace(state_with(make_scene(2)), job=job, now_s=2.0)


def test_a_long_step_in_the_middle_says_that_the_first_time_is_long():
    assert below_bar(making().job, 1.0, True) == "painting finer detail 1.0 s"
    assert "the first time" in below_bar(making().job, LONG_STEP_S + 1.0, True)
    assert below_bar(making().job, LONG_STEP_S + 1.0, False) == "9.0 s in this step"
    first, third = (replace(making(), scene=make_scene(count)) for count in (1, 2))
    assert is_first(first.scene, first.job)
    assert not is_first(third.scene, third.job)
    assert is_first(third.scene, replace(third.job, prompt=""))  # the other had words


@pytest.mark.parametrize(("is_auto", "says"), [(True, "Generate"), (False, "Queue")])
def test_what_is_typed_goes_before_auto_detail_and_behind_all_else(screen, monkeypatch, is_auto, says):
    state = replace(making(is_auto=is_auto), prompt="a bird")
    labels, draw = [], imgui.button
    monkeypatch.setattr(imgui, "button", lambda label, *size: labels.append(label) or draw(label, *size))
    screen.frame(state)
    assert [label.split()[-1] for label in labels if label.endswith(("Generate", "Queue"))] == [says]


def test_what_makes_auto_detail_stop_is_not_said_to_stop_itself(screen):
    services, state = fake_services(), making(is_auto=True)
    assert headline(state, state.job) == "Auto detail: giving it depth"
    asked = apply(services, replace(state, prompt="a beetle"), [cmd.Generate()])
    assert asked.job.is_cancelling
    assert headline(asked, asked.job) == "“a beetle” comes next"
    rect = arrange(1280, 800, 1.0).prompt
    assert screen.click(asked, rect.right - 50, rect.y + 23) == [cmd.CancelJob()]
    given_up = apply(services, asked, [cmd.CancelJob()])
    assert headline(given_up, given_up.job) == "Stopping …"


def test_two_prompts_while_auto_detail_makes_room_are_both_made():
    services, state = fake_services(), state_with(make_scene(1))
    services.client.load(state.scene)
    view = replace(state.view, camera=state.view.camera.zoomed(320.0, 210.0, 8.0))
    state = apply(services, state.with_view(view), [cmd.Generate()])
    state = replace(state, job=replace(state.job, is_auto=True))
    for words in ("a bird", "a beetle"):
        state = apply(services, state, [cmd.EditPrompt(words), cmd.Generate()])
    assert state.goal.prompt == "a bird"
    assert [goal.prompt for goal in state.queue.goals] == ["a beetle"]


def test_a_refused_prompt_keeps_the_cursor_so_that_it_can_be_put_right():
    services, state = fake_services(), replace(state_with(make_scene(1)), vocabulary=WORDS)
    state = apply(services, state, [cmd.EditPrompt("a dragon"), cmd.Generate()])
    assert "dragon" in state.refusal
    assert state.panels.prompt_focus == cmd.FocusPrompt().frames


def test_files_can_be_saved_with_the_cursor_in_the_line(screen):
    state = replace(state_with(make_scene(1)), panels=Panels(prompt_focus=cmd.FocusPrompt().frames))
    for _ in range(3):
        asked = [c for c in screen.frame(state) if isinstance(c, cmd.FocusPrompt)]
        state = replace(state, panels=Panels(prompt_focus=asked[0].frames if asked else 0))
    assert screen.io.want_text_input
    ctrl, alt, key = imgui.Key.mod_ctrl, imgui.Key.mod_alt, imgui.Key
    assert screen.press(state, key.s, ctrl) == [cmd.Save()]
    assert screen.press(state, key.z, ctrl) == []  # of the line
    assert screen.press(state, key.q, ctrl, alt) == []  # AltGr Q, which is @ on some keyboards


@pytest.mark.parametrize(("size", "is_scrolled"), [((1280, 800), False), ((600, 400), True)])
def test_materials_stay_below_the_toolbar(screen, size, is_scrolled):
    screen.width, screen.height = size
    state = with_vocabulary(state_with(make_scene(1)), grammar.vocabulary())
    state = replace(state, panels=Panels(materials=True, timeline=True))
    for _ in range(6):
        screen.frame(state)
    window = imgui.internal.find_window_by_name("materials")
    assert window.pos.y >= arrange(*size, 1.0).tree.y
    assert (window.scroll_max.y > 0) is is_scrolled


def test_materials_say_that_the_words_are_still_to_come(screen):
    state = replace(state_with(make_scene(1)), panels=Panels(materials=True))
    for _ in range(3):
        screen.frame(state)
    assert imgui.internal.find_window_by_name("materials").size.x > 100
    assert imgui.internal.find_window_by_name("materials").size.y > 30  # measured 35, and 20 when empty


def test_a_line_that_is_too_long_loses_its_oldest_steps_and_keeps_the_newest_whole(screen):
    line, found = "giving it depth 1.5 s · building it in 3D 3.3 s · filling in what is behind 5.1 s", {}

    def draw(state, ui):
        full = imgui.calc_text_size(line).x
        found.update({share: newest(line, share * full) for share in (1.0, 0.9, 0.5, 0.1)})
        return []

    screen.frame(making(), draw)
    assert found[1.0] == line
    assert found[0.9] == "building it in 3D 3.3 s · filling in what is behind 5.1 s"
    assert found[0.5] == "filling in what is behind 5.1 s"
    assert found[0.1].startswith("f")
    assert found[0.1].endswith("…")
