"""Whole walks through the app, as a user takes them, off screen and with a worker that answers at once.

They push events into imgui and not into its test engine.  The engine (imgui-bundle 1.93.0) runs a test
in a thread of its own and `new_frame` waits for it; called from a loop in Python, `new_frame` holds the
interpreter lock that the test's Python needs, so the first frame never ends (imgui_bundle issue 149;
tried here).  It works inside hello_imgui's loop only, which is not the loop that these walks are about.

Pictures: ``WZVIEWER_WALK_SHOTS=FOLDER python -m pytest tests/app/test_walks.py``.
"""

from dataclasses import replace

import pytest
from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from tests.app.fakes import FakeDialogs, checker, make_scene
from tests.app.walker import HeldClient, Walker
from wzviewer.app.loop import App
from wzviewer.app.recents import RecentFolder
from wzviewer.app.settings import SettingsFile
from wzviewer.app.window import OffscreenWindow
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.photos import encode_png
from wzviewer.errors import ContextError

pytestmark = pytest.mark.gl
K = imgui.Key
CTRL, SHIFT = K.mod_ctrl, K.mod_shift
CENTRE = (360.0, 250.0)


@pytest.fixture
def walk(tmp_path, monkeypatch, request):
    try:
        window = OffscreenWindow((720, 480))
    except ContextError as error:
        pytest.skip(f"no EGL here: {error}")
    kept = {
        "store": SettingsFile(tmp_path / "config" / "settings.json"),
        "recents": RecentFolder(tmp_path / "state"),
    }
    app = App(window, HeldClient(), **kept)
    app.services = replace(app.services, dialogs=FakeDialogs())
    app.run(None, 3)
    yield Walker(app, request.node.name.removeprefix("test_"), monkeypatch)
    app.close()


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    path.write_bytes(encode_png(checker(320, 240)))
    return path


def near(walk, photo):
    """The photo as a scene, seen from where a level would show more; auto detail is off."""
    walk.drop(photo)
    walk.wait_until(lambda state: state.job is None and len(state.scene) == 1)
    walk.press(K.x)
    walk.scroll(CENTRE, 9)


def made(walk, photo):
    """The photo as a scene, and one level more."""
    walk.drop(photo)
    walk.wait_until(lambda state: state.job is None and len(state.scene) == 1)
    walk.scroll(CENTRE, 9)
    walk.wait_until(lambda state: state.job is None and len(state.scene) == 2)  # auto detail
    return walk.state.scene


def test_drop_zoom_prompt_cancel_undo_save_reopen(walk, photo, tmp_path):
    walk.shoot()
    walk.drop(photo)
    walk.wait_until(lambda state: state.job is None and state.scene.is_committed(0))
    walk.shoot()
    walk.press(K.x)  # auto detail off
    walk.scroll(CENTRE, 9)
    assert walk.state.view.magnification == pytest.approx(1.2**9, rel=0.02)
    assert walk.state.settings.hint_seen

    walk.press(K.slash)
    walk.type("a bird")
    assert walk.state.prompt == "a bird"
    walk.app.services.client.is_held = True
    walk.press(K.enter)
    assert walk.state.job.prompt == "a bird"
    walk.shoot()
    walk.click("Cancel")
    walk.wait_until(lambda state: state.job is None)
    assert len(walk.state.scene) == 1
    assert walk.state.prompt == "a bird"

    walk.press(K.g)
    walk.wait_until(lambda state: state.num_finished == 2)
    assert [level.prompt for level in walk.state.scene] == ["", "a bird"]
    assert walk.state.is_dirty
    walk.press(K.z, CTRL)
    assert walk.state.scene.visible() == [0]
    walk.press(K.z, CTRL, SHIFT)
    assert walk.state.scene.visible() == [0, 1]
    walk.press(K.z, CTRL)
    walk.shoot()

    walk.press(K.s, CTRL)
    assert walk.state.panels.dialog == "save"
    walk.press(K.a, CTRL)
    walk.type(str(tmp_path / "kept.wz"))
    walk.shoot()
    walk.press(K.enter)
    assert walk.state.name == "kept.wz"
    assert not walk.state.is_dirty
    assert load_scene(tmp_path / "kept.wz").visible() == [0]

    walk.drop(tmp_path / "kept.wz")
    assert walk.state.name == "kept.wz"
    assert walk.state.scene.visible() == [0]
    walk.press(K.y, CTRL)
    assert walk.state.scene.visible() == [0, 1]
    walk.shoot()


def test_leaving_asks_and_can_be_thought_over(walk, photo):
    made(walk, photo)
    walk.press(K.q, CTRL)
    walk.shoot()
    walk.click("Stay")
    assert not walk.state.panels.dialog
    walk.press(K.q, CTRL)
    walk.press(K.escape)
    assert not walk.state.is_closing
    walk.press(K.q, CTRL)
    walk.click("Don't save")
    assert walk.state.is_closing


def test_a_recent_file_is_one_click_away(walk, photo, tmp_path):
    save_scene(make_scene(2), tmp_path / "s.wz")
    walk.drop(tmp_path / "s.wz")
    walk.drop(photo)
    walk.click("Open it")  # and not into the scene that is open
    walk.wait_until(lambda state: state.job is None and state.name == "photo.png")
    walk.app.services.recents.wait()
    again = RecentFolder(tmp_path / "state")
    again.wait()
    files = again.poll().files
    again.close()
    assert [file.path.name for file in files] == ["photo.png", "s.wz"]
    assert all(file.picture is not None for file in files)


def test_the_start_page_opens_and_forgets(walk, photo, tmp_path):
    save_scene(make_scene(2), tmp_path / "s.wz")
    recents = walk.app.services.recents
    for path in (tmp_path / "gone.png", tmp_path / "s.wz", photo):
        recents.note(path, checker(320, 240))
    recents.wait()
    walk.wait()
    assert [file.is_missing for file in walk.state.recents.files] == [False, False, True]
    walk.shoot()
    walk.click(f"recent {tmp_path / 'gone.png'}")
    assert "no such file" in walk.state.toasts[-1].text
    walk.click(icons.ICON_FA_XMARK)  # of the card under the cursor
    assert [file.path.name for file in walk.state.recents.files] == ["photo.png", "s.wz"]
    walk.click(f"recent {tmp_path / 's.wz'}")
    assert walk.state.name == "s.wz"


def test_the_palette_runs_what_is_typed(walk):
    walk.press(K.k, CTRL)
    walk.type("demo")
    walk.shoot()
    walk.press(K.enter)
    walk.wait_until(lambda state: state.job is None and state.num_finished == 1)
    assert walk.state.name == "meadow.png"
    walk.press(K.p, CTRL, SHIFT)
    walk.type("light")
    walk.press(K.enter)
    assert walk.state.settings.theme == "light"
    assert walk.app.services.store.load()[0].theme == "light"
    walk.shoot()


def test_the_keys_of_the_authors(walk, photo):
    made(walk, photo)
    walk.click(icons.ICON_FA_GEAR)
    walk.click("WonderZoom")
    walk.shoot()
    walk.press(K.escape)
    before = walk.state.view.camera
    walk.press(K.d)
    assert (walk.state.view.camera.position == before.position).all()
    assert (walk.state.view.camera.rotation != before.rotation).any()
    walk.press(K.z)
    assert walk.state.scene.visible() == [0]
    walk.press(K.f1)
    walk.shoot()


def test_a_touchpad_turns_and_shifts(walk, photo):
    walk.drop(photo)
    walk.wait_until(lambda state: state.job is None and len(state.scene) == 1)
    home = walk.state.view.camera
    walk.scroll(CENTRE, 3, SHIFT)
    assert walk.state.view.camera.cy - home.cy == pytest.approx(90.0)
    assert (walk.state.view.camera.rotation == home.rotation).all()
    walk.scroll(CENTRE, 3, CTRL)
    assert (walk.state.view.camera.rotation != home.rotation).any()
    assert walk.state.view.camera.focal_px == home.focal_px


def test_a_worker_that_dies_leaves_everything(walk, photo):
    near(walk, photo)
    client = walk.app.services.client
    client.is_held = True
    walk.press(K.slash)
    walk.type("a bird")
    walk.press(K.enter)
    walk.wait_until(lambda state: state.job is not None)
    client.lose()
    walk.wait_until(lambda state: state.job is None)
    walk.shoot()
    assert walk.state.num_finished == 1
    assert "killed" in walk.state.toasts[-1].text
    walk.click("Retry")
    walk.wait_until(lambda state: state.num_finished == 2)
    assert walk.state.scene[1].prompt == "a bird"


def test_a_small_window_has_room_for_all(walk, photo):
    near(walk, photo)
    walk.app.window.resize(480, 360)
    walk.wait()
    walk.shoot()
    walk.click("Generate")
    walk.wait_until(lambda state: state.num_finished == 2)
    walk.app.window.resize(720, 480)
    walk.wait()
    assert walk.state.view.camera.width == 720
    walk.drag(CENTRE, (420.0, 280.0))
    walk.shoot()


def test_a_slash_that_a_moving_mouse_keeps_from_its_key_is_not_typed(walk, photo):
    near(walk, photo)
    walk.io.add_mouse_pos_event(300.0, 200.0)  # imgui hands out signs a frame after that
    walk.io.add_key_event(K.slash, True)
    walk.io.add_input_characters_utf8("/")
    walk.io.add_key_event(K.slash, False)
    for letter in "bee":
        walk.io.add_input_characters_utf8(letter)
    walk.wait(6)
    assert walk.state.prompt == "bee"


@pytest.mark.parametrize("at_frame", [0, 1, 2, 3, 4])
def test_what_is_typed_right_after_the_slash_is_a_prompt_and_flies_nowhere(walk, photo, at_frame):
    near(walk, photo)
    camera = walk.state.view.camera
    walk.io.add_key_event(K.slash, True)
    walk.io.add_input_characters_utf8("/")
    for _ in range(at_frame):  # between the slash and the words
        walk.app.run(None, 1)
    for letter, key in (("w", K.w), ("a", K.a), ("x", K.x), ("g", K.g)):  # they fly, switch and generate
        walk.io.add_key_event(key, True)
        walk.io.add_input_characters_utf8(letter)
    walk.app.run(None, 1)
    for key in (K.w, K.a, K.x, K.g, K.slash):
        walk.io.add_key_event(key, False)
    walk.wait(4)
    assert walk.state.prompt == "waxg"
    assert walk.state.view.camera is camera
    assert walk.state.job is None
    assert not walk.state.settings.auto_detail
