"""A user made of imgui events: clicks what is named, types, scrolls, and takes pictures on the way."""

import os
from pathlib import Path

from imgui_bundle import imgui

from tests.app.fakes import FakeClient
from wzviewer.core.photos import encode_png

SHOTS = "WZVIEWER_WALK_SHOTS"  # environment: a folder for pictures of the walks


class HeldClient(FakeClient):
    """A worker that can be made to wait."""

    is_held = False

    def poll(self, budget_s=0.002):
        return [] if self.is_held and self.is_busy else super().poll(budget_s)

    def cancel(self, grace_s=0.7):
        super().cancel(grace_s)
        self.is_held = False

    def lose(self):
        if self.is_busy:  # its level goes with it
            self._scene.abort(len(self._scene) - 1)
        super().lose()
        self.is_held = False


class Walker:
    """Walks through an app that draws off screen.

    Args:
        app: to walk through.
        name: of the walk, for its pictures.
        monkeypatch: to learn where buttons are drawn.
    """

    def __init__(self, app, name, monkeypatch):
        self.app, self.name, self.io = app, name, imgui.get_io()
        self._places, self._count = {}, 0
        for kind in ("button", "invisible_button", "checkbox"):
            monkeypatch.setattr(imgui, kind, self._noting(getattr(imgui, kind)))

    def _noting(self, draw):
        def drawn(label, *arguments, **options):
            result = draw(label, *arguments, **options)
            upper, lower = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            words = "".join(c for c in label.split("##")[0] if c.isprintable() and ord(c) < 0xE000).strip()
            self._places[words or label.split("##")[0]] = ((upper.x + lower.x) / 2, (upper.y + lower.y) / 2)
            return result

        return drawn

    @property
    def state(self):
        return self.app.state

    def wait(self, frames=3):
        self.app.run(None, frames)
        self.app.run(None, 1)  # those that a file takes do not count: here the last one has come

    def wait_until(self, holds, frames=200):
        for _ in range(frames):
            if holds(self.state):
                return
            self.wait(1)
        raise AssertionError("it never came to be")

    def drop(self, path):
        self.app.window.drop(Path(path))
        self.wait()

    def click(self, name):
        """Clicks a button that is on the screen by its text, its icon, or its name."""
        self._places.clear()
        self.wait(2)
        assert name in self._places, f"{name!r} is not there: {sorted(self._places)}"
        self.click_at(*self._places[name])

    def click_at(self, x, y):
        self.io.add_mouse_pos_event(x, y)
        for is_down in (True, False):
            self.wait(1)
            self.io.add_mouse_button_event(0, is_down)
        self.wait(3)

    def drag(self, start, end):
        self.io.add_mouse_pos_event(*start)
        self.wait(1)
        self.io.add_mouse_button_event(0, True)
        for share in (0.0, 0.3, 0.6, 1.0):
            self.wait(1)
            self.io.add_mouse_pos_event(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
        self.wait(1)
        self.io.add_mouse_button_event(0, False)
        self.wait(2)

    def scroll(self, at, notches, *held):
        self.io.add_mouse_pos_event(*at)
        self._hold(held, True)
        for _ in range(abs(notches)):
            self.wait(1)
            self.io.add_mouse_wheel_event(0.0, 1.0 if notches > 0 else -1.0)
        self.wait(3)
        self._hold(held, False)
        self.wait_until(lambda state: not state.view.is_moving)

    def press(self, key, *held):
        self._hold(held, True)
        for is_down in (True, False):
            self.io.add_key_event(key, is_down)
            self.wait(2)
        self._hold(held, False)
        self.wait(3)

    def type(self, text):
        self.io.add_input_characters_utf8(text)
        self.wait(4)

    def shoot(self):
        """Takes a picture, where pictures are wanted."""
        if folder := os.environ.get(SHOTS):
            self._count += 1
            self.wait(20)
            path = Path(folder) / f"{self.name}-{self._count}.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(encode_png(self.app.window.read_pixels()))

    def _hold(self, keys, is_down):
        for key in keys:
            self.io.add_key_event(key, is_down)
        self.wait(1)
