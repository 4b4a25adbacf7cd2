"""The timeline: keys from views, their times, the preview, and the file they are kept in."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from imgui_bundle import imgui

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, tick
from wzviewer.app.directing import is_previewing, play
from wzviewer.app.layout import MARGIN_PT
from wzviewer.app.panels.timeline import HEIGHT_PT, draw_timeline, foot_height
from wzviewer.app.timeline import (
    FIELD,
    Timeline,
    path_of_file,
    timeline_of,
    with_key,
    with_seconds,
    with_time,
    without_key,
)
from wzviewer.core.camera import Camera
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.keyframes import KeyPath
from wzviewer.core.path_files import PathFile, path_record, read_path_file


@pytest.fixture
def services():
    return fake_services()


@pytest.fixture
def state():
    return state_with(make_scene(3))


def seen_at(state, factor):
    """The view, closer."""
    camera = state.view.home.zoomed(320.0, 210.0, factor)
    return state.with_view(replace(state.view, camera=camera))


def with_keys(services, state, *factors):
    for factor in factors:
        state = apply(services, seen_at(state, factor), [cmd.AddKey()])
    return state


def factors(state):
    home = state.view.home.focal_px
    return [round(key.camera.focal_px / home, 3) for key in state.timeline.path.keys]


def test_the_next_film_is_the_timelines_while_its_keys_make_one(services):
    state = apply(services, state_with(make_scene(2)), [cmd.AddKey()])
    assert state.plan.source == "way"
    near = replace(state.view, camera=state.view.camera.zoomed(300.0, 200.0, 4.0))
    two = apply(services, replace(state, view=near), [cmd.AddKey()])
    assert two.timeline.path.num_pieces == 1
    assert two.plan.source == "keys"
    chosen = replace(two, plan=replace(two.plan, source="orbit"))
    assert apply(services, chosen, [cmd.ClearKeys()]).plan.source == "orbit"  # the user's choice
    cleared = apply(services, two, [cmd.ClearKeys()])
    assert cleared.plan.source == "way"
    assert apply(services, cleared, [cmd.BringBackKeys()]).plan.source == "keys"
    other = apply(services, two, [cmd.OpenDemo(), cmd.SettleUnsaved("discard")])
    assert other.photo is not None
    assert other.plan.source == "way"


def test_views_become_keys_one_after_the_other(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    line = state.timeline
    assert factors(state) == [1.0, 8.0, 64.0]
    assert line.path.times_s == (0.0, 2.0, 4.0)  # 2 s for every x8
    assert (line.selected, line.at_s) == (2, 4.0)
    assert state.panels.timeline
    assert state.is_dirty


def test_a_view_at_a_moment_within_the_path_becomes_a_key_there(services, state):
    state = with_keys(services, state, 1.0, 8.0)
    state = apply(services, state, [cmd.ScrubTo(0.5)])
    state = with_keys(services, state, 3.0)
    assert factors(state) == [1.0, 3.0, 8.0]
    assert state.timeline.path.times_s == pytest.approx((0.0, 0.5, 2.0))
    state = apply(services, state, [cmd.SelectKey(0)])
    state = with_keys(services, state, 2.0)  # at a key: half way to the next
    assert factors(state) == [1.0, 2.0, 3.0, 8.0]
    assert state.timeline.path.times_s == pytest.approx((0.0, 0.25, 0.5, 2.0))


def test_the_preview_shows_the_path_and_stops_when_a_hand_takes_over(services, state):
    state = with_keys(services, state, 1.0, 8.0)
    state = apply(services, state, [cmd.ScrubTo(0.0), cmd.TogglePlay()])
    focals = []
    while state.timeline.is_playing:
        state = play(replace(state, now_s=state.now_s + 0.1), 0.1)
        focals.append(state.view.camera.focal_px)
    assert len(focals) == 20
    assert all(b > a for a, b in pairwise(focals))
    assert state.view.camera is state.timeline.path.keys[1].camera
    assert is_previewing(state)
    state = apply(services, state, [cmd.TogglePlay()])  # from the end: again from the start
    assert state.timeline.at_s == 0.0
    moved = apply(services, play(state, 0.3), [cmd.BeginDrag("pan", 10, 10), cmd.DragTo(40, 10)])
    moved = play(moved, 0.3)
    assert not moved.timeline.is_playing
    assert not is_previewing(moved)


def test_a_loop_goes_on_at_its_start(services, state):
    state = with_keys(services, state, 1.0, 8.0)
    state = apply(services, state, [cmd.ToggleLoop(), cmd.SetKeySeconds(1, 1.0), cmd.ScrubTo(2.5)])
    state = play(apply(services, state, [cmd.TogglePlay()]), 0.75)
    assert state.timeline.is_playing
    assert state.timeline.at_s == pytest.approx(0.25)


def test_keys_are_dragged_between_their_neighbours(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    for time_s, wanted in ((1.0, 1.0), (99.0, 3.95), (-3.0, 0.05)):
        state = apply(services, state, [cmd.RetimeKey(1, time_s)])
        assert state.timeline.path.times_s == pytest.approx((0.0, wanted, 4.0))
    span_s = state.timeline.span_s
    state = apply(services, state, [cmd.RetimeKey(2, 99.0)])
    assert state.timeline.path.times_s[2] == span_s  # the ruler stands still under the hand
    assert state.timeline.span_s == span_s
    state = apply(services, state, [cmd.RetimeKey(2, span_s, is_done=True)])
    assert state.timeline.span_s > span_s
    state = apply(services, state, [cmd.BringBackKeys()])  # the whole drag at once
    assert state.timeline.path.times_s == (0.0, 2.0, 4.0)
    assert apply(services, state, [cmd.RetimeKey(0, 3.0)]).timeline.path is state.timeline.path


def test_keys_are_deleted_updated_and_brought_back(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    state = apply(services, state, [cmd.SelectKey(1), cmd.DeleteKey()])
    assert factors(state) == [1.0, 64.0]
    assert state.timeline.path.times_s == (0.0, 4.0)  # the others keep their times
    state = apply(services, seen_at(state, 32.0), [cmd.UpdateKey()])
    assert factors(state) == [1.0, 32.0]
    state = apply(services, state, [cmd.BringBackKeys(), cmd.BringBackKeys()])
    assert factors(state) == [1.0, 8.0, 64.0]
    state = apply(services, state, [cmd.ClearKeys()])
    assert not state.timeline.path.keys


def test_pace_and_seconds_belong_to_a_key(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    state = apply(services, state, [cmd.SetKeyPace(1, "stop"), cmd.SetKeySeconds(0, 5.0)])
    assert state.timeline.path.keys[1].pace == "stop"
    assert state.timeline.path.times_s == (0.0, 5.0, 7.0)


def test_stepping_goes_to_the_next_and_the_previous_key(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    state = apply(services, state, [cmd.ScrubTo(2.5)])
    for step, wanted in ((1, 2), (1, 2), (-1, 1), (-1, 0), (-1, 0)):
        state = apply(services, state, [cmd.StepKey(step)])
        if state.timeline.selected is not None:
            assert state.timeline.selected == wanted
            assert state.view.camera is state.timeline.path.keys[wanted].camera


@pytest.mark.parametrize(("source", "count"), [("way", 2), ("levels", 3), ("orbit", 4)])
def test_ready_keys(services, state, source, count):
    deep = state.scene[2].camera.resized(640, 420)
    state = state.with_view(replace(state.view, camera=deep, focus=state.scene[2].frame.origin))
    state = apply(services, state, [cmd.FillKeys(source)])
    path = state.timeline.path
    assert len(path.keys) == count
    assert path.is_loop == (source == "orbit")
    if source != "orbit":
        assert path.keys[0].camera.key == state.view.home.key
        assert path.keys[-1].camera.key == deep.key


def test_nothing_to_fill_or_to_play_is_said(services, state):
    assert "zoom in first" in apply(services, state, [cmd.FillKeys("way")]).toasts[-1].text
    state = apply(services, state, [cmd.TogglePlay()])
    assert not state.toasts  # Space does nothing where there is no timeline
    state = apply(services, state, [cmd.Toggle("timeline"), cmd.TogglePlay()])
    assert "Two keys" in state.toasts[-1].text


def test_keys_are_saved_with_the_scene_and_come_back(services, state, tmp_path):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    state = apply(services, state, [cmd.SetKeyPace(1, "stop"), cmd.ToggleLoop()])
    state = apply(services, state, [cmd.SaveTo(tmp_path / "a.wz")])
    assert not state.is_dirty
    other = apply(services, state_with(make_scene(1)), [cmd.Open(tmp_path / "a.wz")])
    line = other.timeline
    assert [k.camera.key for k in line.path.keys] == [k.camera.key for k in state.timeline.path.keys]
    assert line.path.keys[1].pace == "stop"
    assert line.path.is_loop
    assert not other.is_dirty
    assert line.span_s >= line.path.duration_s
    moved = apply(services, other, [cmd.SetKeySeconds(0, 9.0)])
    assert moved.is_dirty
    cleared = apply(services, other, [cmd.ClearKeys(), cmd.Save()])
    assert not cleared.is_dirty
    assert FIELD not in load_scene(tmp_path / "a.wz").unknown_fields


def test_damaged_keys_do_not_keep_a_scene_from_opening(services, tmp_path):
    scene = make_scene(1)
    scene.unknown_fields[FIELD] = {"keyframes": [{"matrix": "nonsense"}]}
    save_scene(scene, tmp_path / "a.wz")
    state = apply(services, state_with(make_scene(1)), [cmd.Open(tmp_path / "a.wz")])
    assert state.name == "a.wz"
    assert not state.timeline.path.keys
    assert "damaged" in state.toasts[-1].text
    for record in (3, [], "x", {"keyframes": 3}, {"keyframes": [{}] * 9999}):
        assert timeline_of(record, (64, 48)) is None
    apply(services, state, [cmd.Save()])
    assert load_scene(tmp_path / "a.wz").unknown_fields[FIELD]  # and are not thrown away


def test_camera_paths_are_written_and_read(services, state, tmp_path):
    state = with_keys(services, state, 1.0, 8.0)
    state = apply(services, state, [cmd.SetPictureSize((320, 200)), cmd.SaveCameraPath(tmp_path / "p")])
    text = json.loads((tmp_path / "p.json").read_text())
    assert len(text["camera_path"]) == 48
    assert (text["render_width"], text["render_height"]) == (320, 200)
    other = apply(services, state_with(make_scene(1)), [cmd.OpenCameraPath(tmp_path / "p.json")])
    assert "2 keys" in other.toasts[-1].text
    assert [k.camera.key for k in other.timeline.path.keys] == [
        k.camera.key for k in state.timeline.path.keys
    ]
    bad = apply(services, other, [cmd.OpenCameraPath(tmp_path / "none.json")])
    assert bad.toasts[-1].kind == "error"
    assert bad.timeline.path is other.timeline.path


def test_a_file_of_frames_becomes_keys(tmp_path):
    camera = Camera.initial(64, 48)
    frames = [camera.zoomed(32.0, 24.0, 1.01**i) for i in range(241)]
    (tmp_path / "p.json").write_text(json.dumps(path_record(KeyPath(), frames, 24.0)))
    path = path_of_file(read_path_file(tmp_path / "p.json"), 24.0)
    assert len(path.keys) == 48
    assert path.duration_s == pytest.approx(10.0)
    assert path.keys[-1].camera.key == frames[-1].key
    assert len(path_of_file(PathFile([camera]), 24.0).keys) == 1


def test_dialogs_fall_back_to_a_line(services, state):
    state = with_keys(services, state, 1.0, 8.0)
    assert apply(services, state, [cmd.AskPath(True)]).panels.dialog == "open path"
    asked = apply(services, state, [cmd.AskPath(False)])
    assert asked.panels.dialog == "save path"
    assert asked.panels.dialog_path.endswith("fake-path.json")


def test_edits_keep_a_path_well_formed():
    rng = np.random.default_rng(0)
    camera = Camera.initial(64, 48)
    focus = np.array([0.0, 0.0, 1.0])
    path = KeyPath(is_loop=True)
    for _ in range(300):
        kind, place = rng.integers(0, 4), rng.uniform(-2.0, 30.0)
        count = len(path.keys)
        if kind == 0 or count < 2:
            path, index = with_key(path, camera.zoomed(5.0, 5.0, rng.uniform(0.5, 900.0)), focus, place)
            assert 0 <= index < len(path.keys)
        elif kind == 1 and count > 3:
            path = without_key(path, int(rng.integers(0, count)))
        elif kind == 2:
            path = with_time(path, int(rng.integers(1, path.num_pieces + 1)), place)
        else:
            path = with_seconds(path, int(rng.integers(0, count)), place)
        assert all(0.04 < key.seconds <= 600.0 for key in path.keys)
        times = path.times_s
        assert list(times) == sorted(times)


def test_a_number_that_is_dragged_is_one_change(services, state):
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    for seconds in (2.1, 2.2, 2.3):
        state = apply(services, state, [cmd.SetKeySeconds(0, seconds, is_done=False)])
    state = apply(services, state, [cmd.SetKeySeconds(0, 2.3)])
    assert state.timeline.path.times_s == pytest.approx((0.0, 2.3, 4.3))
    assert apply(services, state, [cmd.BringBackKeys()]).timeline.path.times_s == (0.0, 2.0, 4.0)


def test_escape_stops_the_preview(services, state):
    state = apply(services, with_keys(services, state, 1.0, 8.0), [cmd.TogglePlay(), cmd.Escape()])
    assert not state.timeline.is_playing
    assert state.panels.timeline


def test_no_detail_is_asked_for_while_the_preview_rests(services, state):
    services.client.load(state.scene)
    state = with_keys(services, state, 1.0, 500.0)
    state = replace(state, is_worker_ready=True, panels=replace(state.panels, timeline=True))
    state = apply(services, state, [cmd.SelectKey(1)])
    later = replace(state, now_s=state.now_s + 5.0)
    later = later.with_view(replace(later.view, focused=later.view.camera))
    assert tick(services, later, False).job is None
    moved = seen_at(later, 501.0)
    moved = replace(moved, view=replace(moved.view, focused=moved.view.camera), now_s=moved.now_s + 5.0)
    assert tick(services, moved, False).job is not None


# ------------------------------------------------------------------ panel


def press_and_drag(screen, state, start, end):
    """Drags; returns the state after, with all that was asked for applied."""
    services = fake_services()

    def step(state):
        return apply(services, state, screen.frame(state, draw_timeline))

    screen.move(*start)
    state = step(step(state))
    screen.io.add_mouse_button_event(0, True)
    state = step(state)
    for share in (0.3, 0.7, 1.0):
        screen.move(start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
        state = step(step(state))
    screen.io.add_mouse_button_event(0, False)
    return step(step(state))


def place_of(screen, state, time_s):
    """Where a moment lies on the ruler."""
    margin, pad = MARGIN_PT, 14.0 + 12.0
    width = screen.width - 2 * margin - 2 * pad
    y = screen.height - margin - HEIGHT_PT + (HEIGHT_PT - 66.0) + 31.0
    return margin + pad + width * time_s / state.timeline.span_s, y


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
def test_a_hand_drags_keys_and_scrubs(screen, services, state, size):
    screen.width, screen.height = size
    state = with_keys(services, state, 1.0, 8.0, 64.0)
    x, y = place_of(screen, state, 2.0)
    to = place_of(screen, state, 3.0)
    after = press_and_drag(screen, state, (x, y), to)
    assert after.timeline.path.times_s == pytest.approx((0.0, 3.0, 4.0), abs=0.02)
    assert after.timeline.selected == 1
    assert not after.timeline.is_retiming
    start, end = place_of(screen, after, 0.4), place_of(screen, after, 1.7)
    after = press_and_drag(screen, after, (start[0], y - 14), (end[0], y - 14))
    assert after.timeline.at_s == pytest.approx(1.7, abs=0.02)
    assert after.timeline.path.times_s == pytest.approx((0.0, 3.0, 4.0), abs=0.02)


def test_keys_of_the_keyboard(screen, services, state):
    shown = apply(services, state, screen.press(state, imgui.Key.l))
    assert shown.panels.timeline
    assert screen.press(shown, imgui.Key.i) == [cmd.AddKey()]
    for key, wanted in (
        (imgui.Key.space, cmd.TogglePlay()),
        (imgui.Key.comma, cmd.StepKey(-1)),
        (imgui.Key.period, cmd.StepKey(1)),
        (imgui.Key.delete, cmd.DeleteKey()),
    ):
        assert screen.press(shown, key) == [wanted]


def test_the_panel_takes_room_only_when_it_is_shown(screen, state):
    assert foot_height(state, 1.0) == 0.0
    assert screen.frame(state, draw_timeline) == []
    shown = replace(state, panels=replace(state.panels, timeline=True))
    assert foot_height(shown, 2.0) == 2 * (HEIGHT_PT + MARGIN_PT)
    assert screen.frame(shown, draw_timeline) == []
    assert not Timeline().is_changed
