"""Above the prompt line, on request: materials and weather that the worker knows, by group."""

from dataclasses import replace

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, face, plate, small, tooltip
from wzviewer.app.state import AppState

LEAST_PT = 60.0  # of height, however little room there is


def draw_materials(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    """Draws the picker; returns what was asked for, and the height, imgui units."""
    words = state.vocabulary
    groups = (
        ("Covered in", words.coverings, True),
        ("Weather and light", words.weathers, True),
        (
            "Made of" if state.reading.has_object else "Made of (name a thing first)",
            words.substances,
            state.reading.has_object,
        ),
    )
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(9), ui.pt(4)))
    room = max(above.y - ui.layout.tree.y, ui.pt(LEAST_PT))  # up to the toolbar; the rest can be scrolled
    place = replace(above, y=above.y - room, height=room)
    with plate("materials", place, grows="up", alpha=0.96, scrolls=True):
        if not any(phrases for _, phrases, _ in groups):
            small(ui, "One moment: wzviewer is getting ready.")
        for name, phrases, is_possible in groups:
            if not phrases:
                continue
            small(ui, name)
            imgui.begin_disabled(not is_possible)
            commands += _phrases(state, ui, phrases)
            imgui.end_disabled()
        height = imgui.get_window_height()
    imgui.pop_style_var()
    return commands, height


def _phrases(state: AppState, ui: Ui, phrases: tuple[str, ...]) -> list[cmd.Command]:
    """Buttons in rows; those whose phrase is in the line already are lit."""
    commands: list[cmd.Command] = []
    gap = ui.pt(5)
    right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
    with face(ui.fonts.regular, theme.SMALL_PT + 1.0):
        for number, phrase in enumerate(phrases):
            word = phrase.split()[-1]
            width = imgui.calc_text_size(word).x + 2 * imgui.get_style().frame_padding.x
            if number:
                imgui.same_line(0.0, gap)
                if imgui.get_cursor_screen_pos().x + width > right:
                    imgui.new_line()
            with colored(ui.colors.accent if phrase in state.prompt else ui.colors.text):
                if imgui.button(f"{word}##{phrase}"):
                    commands.append(cmd.AddPhrase(phrase))
            tooltip(phrase)
    return commands
