"""The whole app without a display, and in a real window where a virtual one can be had."""

import importlib.util
import shutil
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from tests.app.fakes import FakeClient, FakeDialogs, checker, make_scene
from wzviewer.app import commands as cmd
from wzviewer.app.journal import JournalFolder
from wzviewer.app.look import Look
from wzviewer.app.loop import App
from wzviewer.app.services import Services
from wzviewer.app.window import GlfwWindow, OffscreenWindow
from wzviewer.core.photos import encode_png, load_photo
from wzviewer.errors import ContextError

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.gl


@pytest.fixture
def app():
    try:
        window = OffscreenWindow((640, 480))
    except ContextError as error:
        pytest.skip(f"no EGL here: {error}")
    app = App(window, FakeClient())
    app.services = Services(app.services.client, app.services.renderer, FakeDialogs())
    yield app
    app.close()


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    path.write_bytes(encode_png(checker(320, 240)))
    return path


def centre_of(picture):
    """Where no panel stands: between the hint and the progress."""
    return picture[180:260, 300:420].reshape(-1, 3).astype(float)


def test_sixty_frames_of_a_scripted_zoom(app, photo):
    app.run(photo, 2)
    flat = app.window.read_pixels()
    app.run(None, 13)
    assert app.state.scene.is_committed(0)
    deep = app.window.read_pixels()
    # the photo becomes 3D where it is: measured difference of the means 0.36 of 255
    assert np.abs(centre_of(flat).mean(0) - centre_of(deep).mean(0)).max() < 2.0
    for _ in range(6):
        app.do(cmd.Zoom(320.0, 240.0, 2.0))
        app.run(None, 4)
    app.do(cmd.EditPrompt("a bird"), cmd.Generate())
    app.run(None, 21)
    assert [level.prompt for level in app.state.scene][1:] == ["a bird"]
    assert app.state.scene.is_committed(1)
    picture = app.window.read_pixels()
    assert picture.shape == (480, 640, 3)
    assert centre_of(picture).std() > 5.0
    assert np.abs(centre_of(picture) - centre_of(deep)).mean() > 5.0


def test_a_picture_at_rest_is_drawn_once(app, photo):
    app.run(photo, 20)
    app.run(None, 20)
    renderer = app.services.renderer
    renderer._renderer.is_ready(None)
    renderer._renderer.wait_for_merged(
        app.state.scene
    )  # what arrives in the background is worth a new picture
    first = renderer.draw(app.state.view.camera)
    app.run(None, 5)
    assert renderer.draw(app.state.view.camera) is first
    app.do(cmd.Zoom(320.0, 240.0, 1.0))
    app.run(None, 1)
    app.run(None, 1)
    assert renderer.draw(app.state.view.camera) is not first


def test_a_hand_that_holds_still_does_not_change_the_pace(app, photo, monkeypatch):
    app.run(photo, 20)
    app.do(cmd.BeginDrag("orbit", 320.0, 240.0), cmd.DragTo(330.0, 240.0))
    same = app.services.renderer.draw(app.state.view.camera)
    monkeypatch.setattr(app.services.renderer, "draw", lambda *arguments: same)
    app.run(None, 1)
    app.pace = replace(app.pace, step=3)  # as a slow machine has learned it
    app.run(None, 8)
    assert app.state.is_moving
    assert app.pace.step == 3


def test_a_graphics_card_that_is_reset_costs_a_window_and_nothing_else(photo):
    try:
        window = OffscreenWindow((640, 480))
    except ContextError as error:
        pytest.skip(f"no EGL here: {error}")
    app = App(window, FakeClient(), reopen=OffscreenWindow)
    app.do(cmd.ChangeSettings(replace(app.state.settings, theme="light")))
    app.run(photo, 20)
    app.services.renderer._renderer.is_ready(None)
    app.do(cmd.Toggle("tree"))
    app.run(None, 25)
    before, scene = centre_of(app.window.read_pixels()), app.state.scene
    window.is_lost = True
    app.run(None, 2)
    assert app.window is not window
    assert app.window.size_px == (640, 480)
    assert app.state.scene is scene
    assert "Nothing is lost" in app.state.toasts[-1].text
    app.services.renderer._renderer.is_ready(None)
    app.run(None, 25)
    assert np.abs(centre_of(app.window.read_pixels()) - before).max() <= 1.0  # measured 0
    app.close()


def test_the_start_page_and_a_new_size(app):
    app.run(None, 2)
    assert app.window.read_pixels().std() > 3.0
    app.window.resize(500, 360)
    app.run(None, 2)
    assert app.window.read_pixels().shape == (360, 500, 3)
    assert app.state.view.camera.width == 500


def test_a_worker_that_fails_never_stops_the_frames(app, photo):
    app.services.client.poll = lambda budget_s: (_ for _ in ()).throw(OSError("gone"))
    app.run(photo, 5)
    assert app.state.photo is not None
    assert "gone" in app.state.toasts[-1].text


def test_closing_ends_the_loop(app):
    app.do(cmd.Close())
    app.run(None, 10**6)
    assert ("close",) not in app.services.client.calls


def test_no_display_is_one_clear_line(monkeypatch):
    if not sys.platform.startswith("linux"):
        pytest.skip("only Linux can be without a display")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ContextError, match="there is no display") as caught:
        GlfwWindow()
    assert "\n" not in caught.value.line()


WINDOWED = """
import sys
from pathlib import Path
from tests.app.fakes import FakeClient
from wzviewer.app import commands as cmd
from wzviewer.app.loop import App
from wzviewer.app.window import GlfwWindow
from wzviewer.core.photos import encode_png

app = App(GlfwWindow((480, 360)), FakeClient())
app.run(Path(sys.argv[1]), 20)
app.do(cmd.Zoom(240.0, 180.0, 8.0))
app.run(None, 20)
Path(sys.argv[2]).write_bytes(encode_png(app.window.read_pixels()))
assert len(app.state.scene) >= 1, app.state.toasts  # auto detail may have brought one more
app.close()
"""


def test_sixty_frames_in_a_real_window(photo, tmp_path):
    if shutil.which("xvfb-run") is None:
        pytest.skip("xvfb-run is not installed")
    if importlib.util.find_spec("glfw") is None:
        pytest.skip("glfw is not installed")
    shot = tmp_path / "shot.png"
    screen = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24"]
    command = [*screen, sys.executable, "-c", WINDOWED, str(photo), str(shot)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert load_photo(shot).std() > 5.0


def test_false_colours_of_a_scene(app, photo):
    app.run(photo, 15)
    pictures = []
    for mode in ("picture", "levels", "depth", "coverage"):
        app.do(cmd.SetLook(Look(mode)))
        app.run(None, 3)
        pictures.append(centre_of(app.window.read_pixels()))
    assert all(np.abs(a - b).mean() > 10.0 for a, b in combinations(pictures, 2))  # measured 26 and more
    hues = pictures[1] / pictures[1].max(1, keepdims=True)
    assert hues.std(0).max() < 0.2  # one level, one hue: measured 0.06


@pytest.mark.parametrize("answer", ["recover", "discard"])
def test_the_question_after_a_crash_comes_before_the_file(photo, tmp_path, answer):
    left = JournalFolder(tmp_path / "journal", "crashed")
    left.keep(make_scene(2), "lost.png")
    left.wait()
    left._lock.close()
    try:
        window = OffscreenWindow((640, 480))
    except ContextError as error:
        pytest.skip(f"no EGL here: {error}")
    app = App(window, FakeClient(), journal=JournalFolder(tmp_path / "journal", "own"))
    app.services = replace(app.services, dialogs=FakeDialogs())
    app.run(photo, 3)
    assert not app.state.has_document
    app.do(cmd.SettleRecovery(answer))
    app.run(None, 2)
    assert app.state.name == ("lost.png" if answer == "recover" else "photo.png")
    app.run(None, 10)
    app.close()
    assert list((tmp_path / "journal").glob("*/*.level")) == []  # a clean end
