"""Pictures at a size, the view as a command, and films."""

import shlex
import time
from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply, tick
from wzviewer.app.filming import FilmNews, FilmProcess, film_cameras, look_options, snapshot
from wzviewer.app.look import Look
from wzviewer.app.shooting import film_line, planned_film
from wzviewer.cli import build_parser
from wzviewer.commands.cameras import parse_camera
from wzviewer.core.files import save_scene
from wzviewer.core.photos import load_photo
from wzviewer.errors import InputError


class FakeFilmer:
    def __init__(self):
        self.asked, self.news, self.is_cancelled = None, [], False

    def start(self, scene, cameras, path, look, fps):
        self.asked = (len(scene), cameras, path, look, fps)

    def start_picture(self, scene, camera, path, look, transparent):
        self.asked = (len(scene), camera, path, look, transparent)

    def cancel(self):
        self.is_cancelled = True
        self.news.append(FilmNews(1.0, True, "terminated", True))

    def poll(self):
        news, self.news = self.news, []
        return news

    def close(self):
        pass


def test_a_picture_has_the_chosen_size(tmp_path):
    services, state = fake_services(), state_with(make_scene(1))
    state = apply(services, state, [cmd.SetPictureSize((320, 200)), cmd.SavePicture(tmp_path / "a.png")])
    assert load_photo(tmp_path / "a.png").shape == (200, 320, 3)
    assert "320 × 200" in state.toasts[-1].text
    apply(services, state, [cmd.SetPictureSize(None), cmd.SavePicture(tmp_path / "b.png")])
    assert load_photo(tmp_path / "b.png").shape == (420, 640, 3)


def test_the_copied_command_is_this_very_view(tmp_path):
    copied = []
    services = replace(fake_services(), copy=copied.append)
    state = state_with(make_scene(2))
    assert "Save the scene first" in apply(services, state, [cmd.CopyView()]).toasts[-1].text
    camera = state.view.camera.zoomed(123.0, 77.0, 5.3)
    state = replace(state.with_view(replace(state.view, camera=camera)), path=tmp_path / "it's a scene.wz")
    state = replace(state, look=Look(modulation=False, blend="linear"))
    apply(services, state, [cmd.CopyView()])
    options = build_parser().parse_args(shlex.split(copied[0])[1:])
    assert options.scene == tmp_path / "it's a scene.wz"
    assert options.blend == "linear"
    assert options.no_modulation
    assert parse_camera(options.camera).key == camera.key


def test_a_camera_that_is_none_is_refused_in_a_line():
    for text in ("", "{", "[]", "{}", "[" * 5000):
        with pytest.raises(InputError, match="is not a camera"):
            parse_camera(text)


def test_a_film_goes_from_the_photo_to_the_view():
    state = state_with(make_scene(2))
    home = state.view.home
    here = home.zoomed(300.0, 200.0, 64.0)
    cameras = film_cameras(home, here, state.view.focus, (320, 180))
    assert cameras[0].key == home.resized(320, 180).key
    assert cameras[-1].key == here.resized(320, 180).key
    focals = [camera.focal_px for camera in cameras]
    assert all(b >= a for a, b in pairwise(focals))
    assert len(cameras) == round(24 * 5.6)  # two levels at two seconds each, and the rests


def test_a_film_tells_how_it_goes_and_how_it_ended(tmp_path):
    services = replace(fake_services(), filmer=FakeFilmer())
    state = state_with(make_scene(2))
    state = apply(services, state, [cmd.MakeFilm(tmp_path / "zoom")])
    assert services.filmer.asked[2] == tmp_path / "zoom.mp4"
    again = apply(services, state, [cmd.AskFilm()])
    assert "One at a time" in again.toasts[-1].text
    services.filmer.news = [FilmNews(0.25), FilmNews(0.5)]
    state = tick(services, state, False)
    assert state.film.fraction == 0.5
    services.filmer.news = [FilmNews(1.0, True)]
    done = tick(services, state, False)
    assert done.film is None
    assert done.toasts[-1].kind == "done"
    services.filmer.news = [FilmNews(1.0, True, "no room")]
    assert "no room" in tick(services, state, False).toasts[-1].text
    cancelled = apply(services, state, [cmd.CancelFilm()])
    assert cancelled.film.is_cancelling
    assert tick(services, cancelled, False).toasts[-1].text == "The film was cancelled."


def test_a_typed_size_counts_once_it_is_one():
    services, state = fake_services(), state_with(make_scene(1))

    def typed(state, text):
        return apply(services, state, [cmd.SetPlan(replace(state.plan, size_text=text))])

    state = typed(state, "16")
    assert state.picture_size is None
    assert "1600x900" in state.plan.size_fault
    state = typed(state, "1600 × 900")
    assert state.picture_size == (1600, 900)
    assert not state.plan.size_fault
    state = typed(state, "1600x90000")
    assert state.picture_size == (1600, 900)
    assert "8192" in state.plan.size_fault
    assert typed(state, "").picture_size is None
    state = apply(services, state, [cmd.SetPictureSize((1920, 1080))])
    assert (state.plan.size_text, state.plan.size_fault) == ("", "")


def test_a_picture_without_a_background_has_alpha(tmp_path):
    services, state = fake_services(), state_with(make_scene(1))
    plan = replace(state.plan, is_transparent=True)
    state = apply(services, state, [cmd.SetPlan(plan), cmd.SavePicture(tmp_path / "a.png")])
    assert cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED).shape == (420, 640, 4)
    assert "without a background" in state.toasts[-1].text


def test_a_large_picture_does_not_hold_up_the_window(tmp_path):
    services = replace(fake_services(), filmer=FakeFilmer())
    state = apply(services, state_with(make_scene(1)), [cmd.SetPictureSize((7680, 4320))])
    state = apply(services, state, [cmd.SavePicture(tmp_path / "a")])
    assert state.film.is_picture
    _, camera, path, _, transparent = services.filmer.asked
    assert (camera.width, camera.height, transparent) == (7680, 4320, False)
    assert path == tmp_path / "a.png"
    assert "has to wait" in apply(services, state, [cmd.SavePicture(tmp_path / "b")]).toasts[-1].text
    services.filmer.news = [FilmNews(1.0, True, "no memory")]
    assert tick(services, state, False).toasts[-1].text == "No picture: no memory"
    levels = replace(state, film=None, look=Look(mode="levels"), picture_size=(2400, 1800))
    assert (
        apply(services, levels, [cmd.SavePicture(tmp_path / "c.png")]).film is None
    )  # false colours at once


@pytest.mark.gl
def test_a_real_picture_of_the_process(tmp_path):
    filmer, scene = FilmProcess(), make_scene(1, 64, 48)
    filmer.start_picture(scene, scene[0].camera.resized(96, 72), tmp_path / "a.png", Look(), True)
    news = finished(filmer)
    if "context" in news[-1].why_not.lower() or "EGL" in news[-1].why_not:
        pytest.skip(news[-1].why_not)
    assert news[-1] == FilmNews(1.0, True)
    assert cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED).shape == (72, 96, 4)
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize(
    ("changes", "count", "size"),
    [
        ({"source": "orbit"}, 96, (640, 420)),
        ({"source": "orbit", "suffix": ".gif"}, 80, (640, 420)),
        ({"source": "orbit", "suffix": ".gif", "seconds": 2.0}, 40, (640, 420)),
        ({"source": "way", "seconds": 3.0}, 72, (640, 420)),
        ({"source": "keys"}, 96, (640, 420)),
        ({"source": "keys", "seconds": 1.0}, 24, (640, 420)),
    ],
)
def test_the_planned_film_is_what_is_made(tmp_path, changes, count, size):
    services = replace(fake_services(), filmer=FakeFilmer())
    state = state_with(make_scene(2))
    for factor in (1.0, 8.0, 64.0):
        camera = state.view.home.zoomed(320.0, 210.0, factor)
        state = apply(services, state.with_view(replace(state.view, camera=camera)), [cmd.AddKey()])
    state = apply(services, state, [cmd.SetPlan(replace(state.plan, **changes))])
    assert film_line(state).startswith(f"{count} frames, {size[0]} × {size[1]}")
    apply(services, state, [cmd.MakeFilm(tmp_path / "a")])
    _, cameras, path, _, fps = services.filmer.asked
    assert len(cameras) == count
    assert (cameras[0].width, cameras[0].height) == size
    assert path == tmp_path / f"a{changes.get('suffix', '.mp4')}"
    assert fps == (20.0 if "suffix" in changes else 24.0)


def test_an_orbit_has_the_chosen_angle():
    state = state_with(make_scene(1))
    state = replace(state, plan=replace(state.plan, source="orbit", orbit_deg=30.0))
    turns = [np.degrees(np.arctan2(c.rotation[0, 2], c.rotation[0, 0])) for c in planned_film(state)]
    assert max(map(abs, turns)) == pytest.approx(30.0, abs=1e-6)


def test_films_that_cannot_be_are_refused_before_they_begin(tmp_path):
    services = replace(fake_services(), filmer=FakeFilmer())
    state = state_with(make_scene(1))
    state = apply(services, state, [cmd.SetPlan(replace(state.plan, source="keys"))])
    assert "needs two keys" in apply(services, state, [cmd.AskFilm()]).toasts[-1].text
    plan = replace(state.plan, source="orbit", suffix=".gif", seconds=60.0)
    state = apply(services, state, [cmd.SetPlan(plan), cmd.SetPictureSize((1920, 1080))])
    refused = apply(services, state, [cmd.MakeFilm(tmp_path / "a.gif")])
    assert "too large" in refused.toasts[-1].text
    assert services.filmer.asked is None
    as_mp4 = apply(services, state, [cmd.MakeFilm(tmp_path / "a.mp4")])  # the dialog's suffix counts
    assert as_mp4.film is not None
    assert as_mp4.plan.suffix == ".mp4"


def test_what_was_chosen_stays_with_the_next_document(tmp_path):
    services, state = fake_services(), state_with(make_scene(1))
    state = apply(services, state, [cmd.SetPlan(replace(state.plan, suffix=".gif", is_transparent=True))])
    save_scene(make_scene(1), tmp_path / "a.wz")
    after = apply(services, state, [cmd.Open(tmp_path / "a.wz")])
    assert after.plan == state.plan


@pytest.mark.parametrize("size", [(1280, 800), (900, 600), (480, 360)])
def test_the_keep_panel_asks_for_what_is_pressed(screen, size):
    screen.width, screen.height = size
    state = state_with(make_scene(1), 640, 420)
    state = replace(state, panels=replace(state.panels, keep=True))
    found = []
    for y in range(60, min(420, size[1]), 9):
        for x in (60, 110, 230):
            found += screen.click(state, x, y)
    assert any(isinstance(c, cmd.SetPlan) and c.plan.tab == "film" for c in found)
    assert cmd.SetPictureSize((1920, 1080)) in found
    assert any(isinstance(c, cmd.SetPlan) and c.plan.is_transparent for c in found)
    assert cmd.AskPicture() in found
    film = replace(state, plan=replace(state.plan, tab="film", source="orbit"))
    found = []
    for y in range(60, min(460, size[1]), 9):
        for x in (40, 110, 230):
            found += screen.click(film, x, y)
    if size[1] > 500:
        assert cmd.AskFilm() in found
    assert any(isinstance(c, cmd.SetPlan) and c.plan.suffix == ".gif" for c in found)
    assert any(isinstance(c, cmd.SetPlan) and c.plan.orbit_deg == 5.0 for c in found)


def test_a_snapshot_does_not_grow():
    scene = make_scene(3)
    scene.hide(2)
    copy = snapshot(scene)
    scene.show(2)
    assert len(copy) == 3
    assert copy.hidden == {2}


def test_looks_become_options():
    assert look_options(Look()) == []
    assert look_options(Look(blend="linear", merged=False)) == ["--blend", "linear", "--no-antialias"]


def finished(filmer, limit_s=120.0):
    news, until = [], time.monotonic() + limit_s
    while time.monotonic() < until and not (news and news[-1].is_over):
        news += filmer.poll()
        time.sleep(0.02)
    return news


@pytest.mark.gl
def test_a_real_film_and_a_cancelled_one(tmp_path):
    scene = make_scene(1, 64, 48)
    camera, filmer = scene[0].camera, FilmProcess()
    few, many = ([camera.zoomed(32.0, 24.0, 1.0 + i / n) for i in range(n)] for n in (12, 5000))
    filmer.start(scene, few, tmp_path / "a.mp4", Look())
    news = finished(filmer)
    if "context" in news[-1].why_not.lower() or "EGL" in news[-1].why_not:
        pytest.skip(news[-1].why_not)
    assert news[-1] == FilmNews(1.0, True)
    assert (tmp_path / "a.mp4").stat().st_size > 500
    assert [n.fraction for n in news] == sorted(n.fraction for n in news)
    filmer.start(scene, few, tmp_path / "c.gif", Look(), 20.0)
    assert finished(filmer)[-1] == FilmNews(1.0, True)
    (tmp_path / "c.gif").rename(tmp_path / "a.gif")
    filmer.start(scene, many, tmp_path / "b.mp4", Look())
    while not filmer.poll():
        time.sleep(0.02)
    filmer.cancel()
    assert finished(filmer, 5.0)[-1].is_cancelled
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gif", "a.mp4"]


def test_a_film_that_cannot_be_written_says_why(tmp_path):
    services = replace(fake_services(), filmer=FakeFilmer())
    state = apply(services, state_with(make_scene(1)), [cmd.MakeFilm(tmp_path / "no" / "zoom.mp4")])
    assert state.film is None
    assert state.toasts[-1].kind == "error"
    assert np.isfinite(state.now_s)
