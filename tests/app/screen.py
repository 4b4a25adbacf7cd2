"""A hand and a keyboard for panels that have no window."""

from imgui_bundle import imgui

from wzviewer.app.input import Hand, read_input
from wzviewer.app.keys import LETTERS
from wzviewer.app.layout import arrange
from wzviewer.app.panels.screen import draw_screen
from wzviewer.app.panels.surface import Ui


class Screen:
    """Runs frames of the panels; collects the commands of the last one."""

    def __init__(self, fonts, width=1280, height=800):
        self.fonts, self.width, self.height, self.scale = fonts, width, height, 1.0
        self.hand, self.letters, self.log, self.modifiers = Hand(), LETTERS, (), {}
        self.io = imgui.get_io()
        self.move(-1000, -1000)

    def ui(self):
        layout = arrange(self.width, self.height, self.scale)
        times = (10.0, 14.0, 12.0)
        numbers = {"Frame": "1 ms"}
        return Ui(layout, self.fonts, statistics=numbers, frame_times_ms=times, log=self.log)

    def frame(self, state, draw=draw_screen):
        """One frame of the panels; returns their commands and those of the input."""
        self.io.display_size = imgui.ImVec2(float(self.width), float(self.height))
        self.io.delta_time = 1 / 60
        imgui.new_frame()
        commands = list(draw(state, self.ui()))
        self.hand, asked = read_input(state, self.hand, self.letters, self.modifiers)
        imgui.render()
        return commands + asked

    def move(self, x, y):
        self.io.add_mouse_pos_event(x, y)

    def click(self, state, x, y, button=0):
        """Moves, presses and releases; returns all commands of it."""
        self.move(x, y)
        commands = self.frame(state) + self.frame(state)
        for is_down in (True, False):
            self.io.add_mouse_button_event(button, is_down)
            commands += self.frame(state)
        return commands

    def press(self, state, key, *modifiers):
        """Presses a key for a frame."""
        for k in (*modifiers, key):
            self.io.add_key_event(k, True)
        commands = self.frame(state)
        for k in (key, *modifiers):
            self.io.add_key_event(k, False)
        self.frame(state)
        return commands
