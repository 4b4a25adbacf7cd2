"""Panels without a window: state in, commands out."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui

from tests.app.fakes import WORDS, fake_services, make_level, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, drain
from wzviewer.app.journal import Leftover
from wzviewer.app.keys import BINDINGS, keymap_of, label_of
from wzviewer.app.layout import arrange
from wzviewer.app.naming import name_in
from wzviewer.app.panels.branches import tree_rows
from wzviewer.app.panels.dialogs import unsaved_text
from wzviewer.app.panels.help import COLUMNS, rows_of
from wzviewer.app.panels.prompt import LONG_STEP_S, so_far
from wzviewer.app.panels.wording import STAGES, stage_text
from wzviewer.app.prompting import with_phrase, with_prompt, with_vocabulary
from wzviewer.app.region import Region
from wzviewer.app.settings import Settings
from wzviewer.app.state import Film, Goal, Job, Panels, StageNote, empty_state
from wzviewer.app.wishes import Queue
from wzviewer.core.marks import Mark
from wzviewer.worker.models.builtin.objects import grammar

CENTRE = (640, 400)


def making(state):
    notes = (StageNote(1, "new scale image", 0.0), StageNote(2, "depth registration", 1.0))
    return replace(state, job=Job(1, "level", "a bird", 0.0, notes, 0.3), now_s=2.0)


def goal(prompt):
    camera = state_with(make_scene(1)).view.home.zoomed_to_region(0.4, 0.4, 8.0)
    return Goal(camera, prompt, camera.unproject(320, 210, 1.0))


STATES = {
    "start": lambda: empty_state(1280, 800),
    "photo": lambda: replace(making(empty_state(1280, 800)), photo=make_scene()[0].image),
    "levels": lambda: state_with(make_scene(4)),
    "making": lambda: making(state_with(make_scene(2))),
    "refused": lambda: replace(state_with(make_scene(2)), refusal="prompt: no such thing. Try a bird."),
    "refused while making": lambda: replace(making(state_with(make_scene(2))), refusal="no such thing"),
    "toasts": lambda: state_with(make_scene(2)).with_toast("one").with_toast("two " * 60, "error"),
    "numbers": lambda: replace(state_with(make_scene(2)), panels=Panels(statistics=True, help=True)),
    "unsaved": lambda: replace(state_with(make_scene(2)), panels=Panels(dialog="unsaved")),
    "closing": lambda: replace(making(state_with(make_scene(2))), panels=Panels(dialog="making")),
    "recover": lambda: replace(
        empty_state(1280, 800),
        leftover=Leftover(Path("x"), "meadow.png", 3),
        panels=Panels(dialog="recover"),
    ),
    "keep": lambda: replace(
        state_with(make_scene(2)), panels=Panels(keep=True), film=Film(Path("a/b.mp4"), 0.0, 0.4)
    ),
    "settings": lambda: replace(state_with(make_scene(2)), panels=Panels(settings=True)),
    "failed": lambda: state_with(make_scene(2)).with_toast("It failed.", "error", "Traceback " * 30, ""),
    "waiting": lambda: replace(
        making(state_with(make_scene(3))),
        queue=Queue(tuple(goal(f"a thing with a long name {k}") for k in range(8))),
        variants=2,
    ),
    "history": lambda: replace(state_with(make_scene(9)), panels=Panels(history=True)),
    "materials": lambda: replace(
        with_vocabulary(state_with(make_scene(2)), grammar.vocabulary()), panels=Panels(materials=True)
    ),
    "frame": lambda: replace(state_with(make_scene(2)), region=Region(camera=goal("").camera)),
    "drawing": lambda: replace(
        state_with(make_scene(2)), region=Region(is_drawing=True, start_px=(90.0, 80.0), end_px=(9.0, 2.0))
    ),
    "drop": lambda: replace(
        state_with(make_scene(2)), panels=Panels(dialog="drop", dialog_path="/a/" + 9 * "long name " + ".png")
    ),
    "renaming": lambda: replace(state_with(make_scene(2)), renaming=1),
    "path": lambda: replace(state_with(make_scene(2)), panels=Panels(dialog="save", dialog_path="/x")),
}


@pytest.mark.parametrize("name", STATES)
@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
def test_every_state_draws_and_asks_for_nothing(screen, name, size):
    screen.width, screen.height = size
    state = STATES[name]()
    for _ in range(3):
        assert screen.frame(state) == []


def test_click_on_generate(screen):
    state = state_with(make_scene(1))
    rect = arrange(1280, 800, 1.0).prompt
    assert screen.click(state, rect.right - 50, rect.y + 23) == [cmd.Generate()]


def test_click_on_cancel_while_making(screen):
    rect = arrange(1280, 800, 1.0).prompt
    assert screen.click(making(state_with(make_scene(1))), rect.right - 50, rect.y + 23) == [cmd.CancelJob()]


def test_typing_edits_the_prompt_and_enter_generates(screen):
    state = state_with(make_scene(1))
    rect = arrange(1280, 800, 1.0).prompt
    screen.click(state, rect.x + 60, rect.y + 23)
    screen.io.add_input_characters_utf8("a wasp")
    assert screen.frame(state) == [cmd.EditPrompt("a wasp")]
    state = replace(state, prompt="a wasp")
    assert screen.press(state, imgui.Key.w) == []  # keys are dead while typing
    assert screen.press(state, imgui.Key.enter) == [cmd.Generate()]
    assert screen.press(state, imgui.Key.t) == [cmd.Toggle("tree")]  # and alive again


def test_slash_puts_the_cursor_into_the_prompt(screen):
    state = state_with(make_scene(1))
    assert screen.press(state, imgui.Key.slash) == [cmd.FocusPrompt()]
    wanting = replace(state, panels=replace(state.panels, prompt_focus=2))
    assert screen.frame(wanting) == [cmd.FocusPrompt(1)]
    coming = replace(state, panels=replace(state.panels, prompt_focus=1))
    assert screen.frame(coming) == [cmd.FocusPrompt(0)]
    screen.io.add_input_characters_utf8("x")
    assert cmd.EditPrompt("x") in screen.frame(state) + screen.frame(state)


def test_click_on_a_row_of_the_tree_flies_there(screen):
    state = state_with(make_scene(3))
    rect = arrange(1280, 800, 1.0).tree
    assert screen.click(state, rect.x + 150, rect.y + 6 + 62 + 30) == [cmd.GoToLevel(1)]
    hidden = replace(state, panels=Panels(tree=False))
    assert not any(isinstance(c, cmd.GoToLevel) for c in screen.click(hidden, rect.x + 150, rect.y + 98))


def test_the_tree_lists_children_below_their_parent():
    scene = make_scene(3)
    assert [(row.index, row.depth) for row in tree_rows(scene)] == [(0, 0), (1, 1), (2, 2)]
    assert [name_in(scene, i) for i in range(3)] == ["Photo", "thing 1", "thing 2"]
    scene.hide(1)
    assert [row.is_seen for row in tree_rows(scene)] == [True, False, False]
    scene.set_mark(1, Mark("removed"))
    assert [row.index for row in tree_rows(scene)] == [0]


def test_click_on_the_start_page_opens(screen):
    state = empty_state(1280, 800)
    assert screen.click(state, 640, 400 - 8) == [cmd.AskOpen()]
    assert screen.click(state, 640, 400 + 85) == [cmd.OpenDemo()]


def test_toolbar_offers_only_what_is_possible(screen):
    rect = arrange(1280, 800, 1.0).toolbar
    save, undo = (rect.x + 8 + 36 + 17, rect.y + 23), (rect.x + 8 + 106 + 15 + 17, rect.y + 23)
    assert screen.click(state_with(make_scene(2)), *save) == [cmd.Save()]
    assert screen.click(state_with(make_scene(2)), *undo) == [cmd.Undo()]
    assert screen.click(state_with(make_scene(1)), *undo) == []


def test_a_dialog_keeps_the_mouse_from_what_lies_behind(screen):
    state = replace(state_with(make_scene(2)), panels=Panels(dialog="unsaved"))
    rect = arrange(1280, 800, 1.0).prompt
    assert screen.click(state, rect.right - 50, rect.y + 23) == []
    x, y = 640 + 230 - 14 - 54, 0.38 * 800 + 75 - 12 - 17
    assert screen.click(state, x, y) == [cmd.SettleUnsaved("save")]


def test_a_click_closes_the_help(screen):
    state = replace(state_with(make_scene(1)), panels=Panels(help=True))
    assert screen.click(state, 30, 700) == [cmd.Toggle("help")]


def test_a_click_removes_a_toast(screen):
    state = replace(state_with(make_scene(1)).with_toast("gone"), now_s=1.0)
    rect = arrange(1280, 800, 1.0).toasts
    assert screen.click(state, rect.x + 40, rect.y + 15) == [cmd.DismissToast("gone")]


def test_toasts_end_by_themselves():
    state = state_with(make_scene(1)).with_toast("one").with_toast("one")
    assert len(state.toasts) == 1
    assert state.toasts[0].is_alive(4.9)
    assert not state.toasts[0].is_alive(5.1)


def test_help_shows_every_key():
    shown = {b.label for column in COLUMNS for group in column for b in rows_of(group)}
    assert shown == {b.label for b in BINDINGS if b.group}


@pytest.mark.parametrize("letters", ["wasdqe", "zqsdae", ",aoe'.", "цфывйу"])
@pytest.mark.parametrize("name", ["wzviewer", "authors"])
def test_no_key_does_two_things(name, letters):
    keymap = keymap_of(name, letters)
    chords = [(key, b.ctrl, b.ctrl and b.shift) for b in keymap.bindings for key in b.keys]
    chords += [(key, False, False) for key in keymap.held]
    assert len(chords) == len(set(chords))
    assert len(keymap.held) == (6 if name == "wzviewer" else 12)


@pytest.mark.parametrize("name", ["wzviewer", "authors"])
def test_whatever_the_keys_everything_can_be_done(name):
    commands = {b.command() for b in keymap_of(name).bindings if b.keys and b.command is not None}
    assert commands >= {b.command() for b in BINDINGS if b.command is not None}


def test_help_shows_the_keys_that_count():
    theirs = [(b.label, b.what) for column in COLUMNS for group in column for b in rows_of(group, "authors")]
    assert ("R", "New detail where you look") in theirs
    assert [label for label, what in theirs if what == "New detail where you look"] == ["R"]
    assert rows_of("Look", "wzviewer", "zqsdae")[5].label == "Z Q S D, A E"
    assert label_of(cmd.Generate, "authors") == "R"


def test_escape_leaves_the_line_and_keeps_the_text(screen):
    state = replace(state_with(make_scene(1)), prompt="a wasp")
    rect = arrange(1280, 800, 1.0).prompt
    screen.click(state, rect.x + 60, rect.y + 23)
    screen.io.add_input_characters_utf8("p")
    (edit,) = screen.frame(state)
    state = replace(state, prompt=edit.text)
    assert screen.press(state, imgui.Key.escape) == []
    assert screen.press(state, imgui.Key.t) == [cmd.Toggle("tree")]


def typing(screen, text):
    """A state with the cursor in the prompt line, behind a text that is typed."""
    state = with_vocabulary(state_with(make_scene(1)), WORDS)
    rect = arrange(1280, 800, 1.0).prompt
    screen.click(state, rect.x + 60, rect.y + 23)
    screen.io.add_input_characters_utf8(text)
    (edit,) = screen.frame(state)
    return with_prompt(state, edit.text)


def test_tab_takes_the_marked_offer_and_the_arrows_mark_another(screen):
    state = typing(screen, "two b")
    assert state.offers[0].word == "butterflies"
    assert screen.press(state, imgui.Key.down_arrow) == [cmd.ChooseOffer(1)]
    second = replace(state, offer=1)
    assert screen.press(second, imgui.Key.tab) == [cmd.EditPrompt(state.offers[1].prompt)]


def test_a_click_takes_an_offer_and_typing_goes_on_behind_it(screen):
    state = typing(screen, "a dragon")
    assert state.reading.unknown == ((2, 8),)
    rect = arrange(1280, 800, 1.0).prompt
    (take,) = screen.click(state, rect.x + 210, rect.y - 8 - 20)
    assert take in [cmd.TakeOffer(offer.prompt) for offer in state.offers]
    state = apply(fake_services(), state, [take])
    for left in (1, 0):
        assert cmd.FocusPrompt(left) in screen.frame(state)
        state = replace(state, panels=replace(state.panels, prompt_focus=left))
    screen.io.add_input_characters_utf8("s")
    assert screen.frame(state) == [cmd.EditPrompt(take.prompt + "s")]


def test_the_arrows_go_round(screen):
    state = typing(screen, "two b")
    services = fake_services()
    steps = [cmd.ChooseOffer(-1)]
    assert apply(services, state, steps).offer == len(state.offers) - 1
    assert apply(services, state, [*steps, cmd.ChooseOffer(1)]).offer == 0


def test_an_unknown_word_is_refused_before_the_worker_is_asked():
    services = fake_services()
    state = with_prompt(with_vocabulary(state_with(make_scene(1)), WORDS), "a dragon")
    state = apply(services, state, [cmd.Generate()])
    assert "“dragon” is not known" in state.refusal
    assert services.client.calls == []


def test_a_refusal_is_seen_while_something_is_made(screen):
    state = replace(making(state_with(make_scene(1))), refusal="“dragon” is not known.")
    screen.frame(state)
    screen.frame(state)
    refusal, progress = map(imgui.internal.find_window_by_name, ("refusal", "progress"))
    assert refusal.active
    assert progress.active
    assert refusal.pos.y > progress.pos.y  # it stands at the line that it is about


def test_the_line_of_a_dialog_takes_the_cursor_back_when_its_path_is_refused(screen):
    state = replace(state_with(make_scene(1)), panels=Panels(dialog="open", dialog_path="/x"))
    for _ in range(3):
        screen.frame(state)
    assert cmd.ConfirmPath() in screen.press(state, imgui.Key.enter)
    state = replace(state, panels=replace(state.panels, dialog_note="There is no x in /."))
    for _ in range(3):
        screen.frame(state)
    screen.io.add_input_characters_utf8("/y")
    assert cmd.EditPath("/y") in screen.frame(state)


@pytest.mark.parametrize(("seconds", "is_said"), [(LONG_STEP_S - 1.0, False), (LONG_STEP_S + 1.0, True)])
def test_a_long_first_step_says_that_the_first_time_is_long(seconds, is_said):
    assert ("the first time" in so_far(seconds)) is is_said


def test_a_failure_offers_details_and_retry(screen):
    state = replace(state_with(make_scene(1)).with_toast("It failed.", "error", "why", "a bird"), now_s=1.0)
    rect = arrange(1280, 800, 1.0).toasts
    y = rect.y + 12 + 16 + 7 + 12
    assert screen.click(state, rect.x + 40, y) == [cmd.ExpandToast("It failed.")]
    assert screen.click(state, rect.x + 110, y) == [cmd.Retry("It failed.")]
    shown = apply(fake_services(), state, [cmd.ExpandToast("It failed.")])
    assert shown.toasts[0].is_alive(1e6)
    screen.frame(shown)


def test_retry_asks_again_with_the_same_words():
    services = fake_services()
    services.client.fails = True
    state = state_with(make_scene(1))
    services.client.load(state.scene)
    camera = state.view.camera.zoomed(320.0, 210.0, 8.0)
    state = state.with_view(replace(state.view, camera=camera))
    state = apply(services, state, [cmd.EditPrompt("a bird"), cmd.Generate()])
    state = drain(services, state, 0.0)
    (toast,) = state.toasts
    assert (toast.retry, toast.kind) == ("a bird", "error")
    services.client.fails = False
    state = apply(services, state, [cmd.EditPrompt(""), cmd.Retry(toast.text)])
    assert state.job.prompt == "a bird"
    assert state.toasts == ()


def test_settings_change_at_once_and_are_kept(screen):
    state = replace(state_with(make_scene(1)), panels=Panels(settings=True))
    bar = arrange(1280, 800, 1.0).toolbar
    commands = screen.click(state, bar.x + 14 + 210, bar.bottom + 8 + 12 + 16 + 7 + 14 + 7 + 12)
    assert commands == [cmd.ChangeSettings(Settings(theme="light"))]
    assert apply(fake_services(), state, commands).settings.theme == "light"


def test_reduced_motion_jumps():
    services = fake_services()
    state = replace(state_with(make_scene(2)), settings=Settings(reduced_motion=True))
    there = apply(services, state, [cmd.GoToLevel(1)])
    assert there.view.flight is None
    assert there.view.magnification == pytest.approx(8.0, rel=0.3)
    closer = apply(services, state, [cmd.Zoom(320.0, 210.0, 1.0)])
    assert closer.view.spring.is_resting
    assert closer.view.camera.focal_px > state.view.camera.focal_px


def test_one_panel_at_a_time_below_the_toolbar():
    state = apply(fake_services(), state_with(make_scene(1)), [cmd.Toggle("keep"), cmd.Toggle("settings")])
    assert state.panels.settings
    assert not state.panels.keep
    assert not apply(fake_services(), state, [cmd.Escape()]).panels.settings


def test_the_right_button_offers_a_menu_and_escape_closes_only_that(screen):
    state = state_with(make_scene(3))
    rect = arrange(1280, 800, 1.0).tree
    at = (rect.x + 100, rect.y + 6 + 62 + 30)
    screen.click(state, *at, button=1)
    assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup.value)
    assert screen.press(state, imgui.Key.escape) == []
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup.value)
    screen.click(state, *at, button=1)
    found = set()
    for y in range(0, 200, 14):
        found |= set(screen.click(state, at[0] + 30, at[1] + y))
        screen.click(state, *at, button=1)
    assert {cmd.BeginRename(1), cmd.ShowLevel(1, False), cmd.DeleteLevel(1), cmd.Another(1)} <= found


def test_the_eye_of_a_hidden_level_shows_it(screen):
    scene = make_scene(3)
    scene.hide(1)
    rect = arrange(1280, 800, 1.0).tree
    eye = (rect.right - 6 - 15, rect.y + 6 + 62 + 29)
    assert screen.click(state_with(scene), *eye) == [cmd.ShowLevel(1, True)]
    assert screen.click(state_with(make_scene(3)), *eye) == [cmd.ShowLevel(1, False)]


def test_a_name_is_edited_in_place(screen):
    state = replace(state_with(make_scene(3)), renaming=1)
    for _ in range(3):
        screen.frame(state)
    screen.io.add_input_characters_utf8("wing")  # in place of what is selected
    screen.frame(state)
    assert screen.press(state, imgui.Key.enter) == [cmd.RenameLevel(1, "wing")]
    screen.frame(replace(state, renaming=None))
    for _ in range(3):
        screen.frame(state)
    screen.io.add_input_characters_utf8("leg")
    screen.frame(state)
    assert screen.press(state, imgui.Key.escape) == [cmd.EndRename()]


def test_branches_know_where_lines_pass_by():
    scene = make_scene(3)
    for x in (0.2, 0.8):
        camera = scene[0].camera.zoomed_to_region(x, 0.5, 8.0)
        scene.append(make_level(scene, 0, camera, scene[1].image))
        scene.commit(len(scene) - 1)
    rows = {row.index: row for row in tree_rows(scene)}
    assert list(rows) == [0, 1, 2, 3, 4]
    assert rows[2].passing == {1}  # the line of the photo's other children
    assert [rows[i].is_last for i in (1, 2, 3, 4)] == [False, True, False, True]


def test_a_click_on_a_step_of_the_history_goes_there(screen):
    state = replace(state_with(make_scene(4)), panels=Panels(history=True))
    bar = arrange(1280, 800, 1.0).toolbar
    found = set()
    for y in range(int(bar.bottom) + 45, int(bar.bottom) + 200, 15):
        found |= set(screen.click(state, bar.x + 120, y))
    assert found >= {cmd.JumpInHistory(k) for k in range(4)}


def test_a_notice_may_offer_a_command(screen):
    state = state_with(make_scene(1)).with_toast("Deleted.", button="Undo", command=cmd.Undo())
    state = replace(state, now_s=1.0)
    rect = arrange(1280, 800, 1.0).toasts
    assert screen.click(state, rect.right - 30, rect.y + 20) == [cmd.Undo(), cmd.DismissToast("Deleted.")]
    assert state.toasts[0].is_alive(8.0)


def test_materials_go_into_the_line_and_out_again(screen):
    words = replace(WORDS, coverings=("covered in moss",), substances=("made of gold",))
    state = replace(with_vocabulary(state_with(make_scene(1)), words), panels=Panels(materials=True))
    rect = arrange(1280, 800, 1.0).stack
    found = set()
    for y in range(int(rect.y) - 110, int(rect.y) - 10, 8):
        found |= set(screen.click(state, rect.x + 30, y))
    assert found == {cmd.AddPhrase("covered in moss")}  # nothing is named that could be made of gold
    assert with_phrase("", "covered in moss") == "covered in moss"
    gold = with_phrase("a ladybug, covered in moss", "made of gold")
    assert gold == "a ladybug made of gold, covered in moss"
    assert with_phrase(gold, "made of ice") == "a ladybug made of ice, covered in moss"
    assert with_phrase(gold, "made of gold") == "a ladybug, covered in moss"
    assert with_phrase(gold, "covered in moss") == "a ladybug made of gold"


def test_closing_counts_the_levels_that_are_seen_and_in_no_file():
    state = replace(state_with(make_scene(1)), saved=(0, {}))
    assert unsaved_text(state).startswith("The scene has not")
    state = replace(state_with(make_scene(4)), saved=(0, {}))
    assert unsaved_text(state).startswith("4 levels have not")
    state.scene.hide(2)  # an older variant
    state.scene.set_mark(3, Mark("removed"))
    assert unsaved_text(state).startswith("2 levels have not")  # with the photo, as the tree
    assert unsaved_text(replace(state, saved=(2, {}))).startswith("Your last changes have not")
    state.scene.show(3)
    assert unsaved_text(replace(state, saved=(2, {}))).startswith("1 level has not")


def test_stages_are_told_in_plain_words():
    source = (Path(__file__).parents[2] / "wzviewer" / "worker" / "synthesis.py").read_text("utf-8")
    names = set(re.findall(r'clock\.stage\(\d, "([a-z ]+)"\)', source))
    assert names == set(STAGES)
    assert "3D" in stage_text("initial scene")
    assert stage_text("of another worker") == "of another worker"
