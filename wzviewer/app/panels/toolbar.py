"""Top left: files, history, and what to show."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.history import wording
from wzviewer.app.keys import label_for
from wzviewer.app.panels.notices import is_side_taken
from wzviewer.app.panels.surface import Ui, colored, plate, tooltip
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

Button = tuple[str, str, cmd.Command, bool]  # icon, what, command, is it possible now
BUTTON_PT = (32.0, 30.0)


def draw_toolbar(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the toolbar."""
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(8), ui.pt(8)))
    with plate("toolbar", ui.layout.toolbar):
        for number, group in enumerate((_files(state), _history(state), _views(state))):
            if number:
                _divider(ui)
            for place, button in enumerate(group):
                if place:
                    imgui.same_line(0.0, ui.pt(2))
                commands += _button(state, ui, button)
    imgui.pop_style_var()
    return commands


def _files(state: AppState) -> tuple[Button, ...]:
    return (
        (icons.ICON_FA_FOLDER_OPEN, "Open a photo or a scene", cmd.AskOpen(), True),
        (icons.ICON_FA_FLOPPY_DISK, "Save", cmd.Save(), state.num_finished > 0),
        (icons.ICON_FA_CAMERA, "Save a picture or a film", cmd.Toggle("keep"), len(state.scene) > 0),
    )


def _history(state: AppState) -> tuple[Button, ...]:
    back, forth = state.history.undoable, state.history.redoable
    undo = f"Undo: {wording(back)}" if back is not None else "Undo"
    redo = f"Redo: {wording(forth)}" if forth is not None else "Redo"
    return (
        (icons.ICON_FA_ARROW_ROTATE_LEFT, undo, cmd.Undo(), back is not None),
        (icons.ICON_FA_ARROW_ROTATE_RIGHT, redo, cmd.Redo(), forth is not None),
        (icons.ICON_FA_CLOCK_ROTATE_LEFT, "History", cmd.Toggle("history"), bool(state.history.entries)),
    )


def _views(state: AppState) -> tuple[Button, ...]:
    return (
        (
            icons.ICON_FA_WAND_MAGIC_SPARKLES,
            f"Auto detail is {'on' if state.settings.auto_detail else 'off'}",
            cmd.ToggleAuto(),
            True,
        ),
        (icons.ICON_FA_HOUSE, "The whole picture", cmd.GoHome(), True),
        (icons.ICON_FA_LAYER_GROUP, "Levels", cmd.Toggle("tree"), len(state.scene) > 0),
        (icons.ICON_FA_TIMELINE, "Timeline of a film", cmd.Toggle("timeline"), len(state.scene) > 0),
        (icons.ICON_FA_GEAR, "Settings", cmd.Toggle("settings"), True),
        (icons.ICON_FA_CIRCLE_QUESTION, "Keys and gestures", cmd.Toggle("help"), True),
    )


def _is_marked(state: AppState, command: cmd.Command) -> bool:
    """What is on, or has something to do: unsaved levels, auto detail."""
    if isinstance(command, cmd.Save):
        return state.is_dirty
    return isinstance(command, cmd.ToggleAuto) and state.settings.auto_detail


def _is_open(state: AppState, command: cmd.Command) -> bool:
    """Whether the panel that a button opens is shown: a second press closes it."""
    if not isinstance(command, cmd.Toggle) or (command.panel == "tree" and is_side_taken(state)):
        return False
    return bool(getattr(state.panels, command.panel))


def _button(state: AppState, ui: Ui, button: Button) -> list[cmd.Command]:
    icon, what, command, is_enabled = button
    ground = ui.colors.hover if is_enabled and _is_open(state, command) else (0.0, 0.0, 0.0, 0.0)
    ink = ui.colors.accent if _is_marked(state, command) else ui.colors.text
    imgui.begin_disabled(not is_enabled)
    with colored(ink), colored(ground, imgui.Col_.button):
        pressed = imgui.button(f"{icon}##{icon}", (ui.pt(BUTTON_PT[0]), ui.pt(BUTTON_PT[1])))
    imgui.end_disabled()
    key = label_for(command, state.settings.keymap)
    tooltip(f"{what}   {key}" if key else what)
    return [command] if pressed else []


def _divider(ui: Ui) -> None:
    imgui.same_line(0.0, ui.pt(7))
    at = imgui.get_cursor_screen_pos()
    top, bottom = at.y + ui.pt(6), at.y + ui.pt(BUTTON_PT[1] - 6)
    imgui.get_window_draw_list().add_line((at.x, top), (at.x, bottom), u32(ui.colors.faint), ui.pt(1))
    imgui.dummy((ui.pt(1), ui.pt(BUTTON_PT[1])))
    imgui.same_line(0.0, ui.pt(7))
