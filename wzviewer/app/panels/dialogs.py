"""Modal: unsaved changes, and a line of text for a path where the system has no file dialogs."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.folder import draw_folder
from wzviewer.app.panels.frame import seen_rect
from wzviewer.app.panels.notices import draw_notices_over
from wzviewer.app.panels.surface import Ui, elided, face, plate, primary, shade, wrapped
from wzviewer.app.state import AppState

WIDTH_PT, HEIGHT_PT = 460.0, 150.0
LABEL_PT = 34.0  # below a frame stands how close it is
LIST_PT = 230.0  # of what stands in a folder
TITLES = {
    "open": "Open a photo or a scene",
    "save": "Save the scene",
    "picture": "Save the picture",
    "film": "Save the film",
    "open path": "Open a camera path",
    "save path": "Save the camera path",
}


def draw_dialogs(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the dialog that is open, if any."""
    kind = state.panels.dialog
    if not kind:
        return []
    window = ui.layout.window
    shade(ui)
    draw_notices_over(state, ui)  # below the dialog itself
    width = min(ui.pt(WIDTH_PT), window.width - ui.pt(24))
    height = ui.pt(HEIGHT_PT + (LIST_PT if state.panels.dialog_list is not None else 0.0))
    top = max(window.height * 0.38 - height / 2, ui.pt(12))
    rect = Rect((window.width - width) / 2, top, width, height)
    if kind == "drop" and state.region.camera is not None:
        rect = beside(rect, seen_rect(state, state.region.camera), window, ui.pt(LABEL_PT))
    rect = replace(rect, height=0.0)  # it grows with what it has to say
    name = "path" if kind in TITLES else "dialog"  # another one: it appears, and its line takes the cursor
    with plate(name, rect, alpha=0.98, grows="down", is_front=True):
        if kind == "unsaved":
            return _unsaved(state, ui)
        if kind == "making":
            return _making(state, ui)
        if kind == "recover":
            return _recover(state, ui)
        if kind == "drop":
            return _drop(state, ui)
        return _path(state, ui, TITLES[kind])


def beside(rect: Rect, frame: Rect | None, window: Rect, gap: float) -> Rect:
    """Returns where a question hides no frame: below it, above it, or where it was when neither has room."""
    if frame is None or not rect.overlaps(replace(frame, height=frame.height + gap)):
        return rect
    below, above = frame.bottom + gap, frame.y - gap - rect.height
    if below + rect.height <= window.bottom - gap / 2:
        return replace(rect, y=below)
    return replace(rect, y=above) if above >= gap / 2 else rect


def _unsaved(state: AppState, ui: Ui) -> list[cmd.Command]:
    with face(ui.fonts.bold, theme.HEAD_PT):
        imgui.text_unformatted("Save the scene?")
    wrapped(ui, unsaved_text(state), ui.colors.muted)
    return _buttons(
        ui,
        ("Stay", cmd.SettleUnsaved("stay")),
        ("Don't save", cmd.SettleUnsaved("discard")),
        ("Save", cmd.SettleUnsaved("save")),
    )


def unsaved_text(state: AppState) -> str:
    """Returns what would be lost, as far as the user sees it."""
    num_saved = state.saved[0]
    fresh = range(num_saved, state.num_finished)
    count = sum(state.scene.mark(index).sight == "shown" for index in fresh)
    if count <= (num_saved == 0):  # no level, or the photo alone
        what = "Your last changes have" if num_saved else "The scene has"
        return f"{what} not been saved. Without saving {'they are' if num_saved else 'it is'} lost."
    levels = "1 level has" if count == 1 else f"{count} levels have"
    return f"{levels} not been saved. Without saving {'it is' if count == 1 else 'they are'} lost."


def _making(state: AppState, ui: Ui) -> list[cmd.Command]:
    with face(ui.fonts.bold, theme.HEAD_PT):
        imgui.text_unformatted("Close while something is being made?")
    wrapped(ui, making_text(state), ui.colors.muted)
    return _buttons(ui, ("Close", cmd.Close(gives_up=True)), ("Wait", cmd.Escape()))


def making_text(state: AppState) -> str:
    """Returns what closing would give up."""
    goal = state.job.goal if state.job is not None else state.goal
    what = f"“{goal.prompt}”" if goal is not None and goal.prompt else "New detail"
    waiting = len(state.queue.goals)
    if not waiting:
        return f"{what} is not ready yet. Closing gives it up."
    return f"{what} is not ready yet, and {waiting} more waiting. Closing gives them up."


def _recover(state: AppState, ui: Ui) -> list[cmd.Command]:
    left = state.leftover
    with face(ui.fonts.bold, theme.HEAD_PT):
        imgui.text_unformatted("Bring back what was not saved?")
    what = left.what if left is not None else "nothing"
    wrapped(ui, f"wzviewer ended unexpectedly. It had kept {what}.", ui.colors.muted)
    discard, recover = cmd.SettleRecovery("discard"), cmd.SettleRecovery("recover")
    return _buttons(ui, ("Later", cmd.Escape()), ("Delete", discard), ("Recover", recover))


def _drop(state: AppState, ui: Ui) -> list[cmd.Command]:
    with face(ui.fonts.bold, theme.HEAD_PT):
        imgui.text_unformatted("What is this picture for?")
    name = elided(Path(state.panels.dialog_path).name, ui.pt(190))
    where = "in the frame you drew" if state.region.camera is not None else "in the middle of the view"
    where = "where you dropped it" if state.region.is_of_drop else where
    text = f"{name} can become a new level: it is put into the picture, {where}. Or open it by itself."
    wrapped(ui, text, ui.colors.muted)
    put, opened = cmd.SettleDrop("insert"), cmd.SettleDrop("open")
    return _buttons(ui, ("Cancel", cmd.Escape()), ("Open it", opened), ("Put it in", put))


def _path(state: AppState, ui: Ui, title: str) -> list[cmd.Command]:
    with face(ui.fonts.bold, theme.HEAD_PT):
        imgui.text_unformatted(title)
    note = state.panels.dialog_note
    is_left = bool(note) and not (imgui.is_any_item_active() or imgui.is_mouse_down(0))
    if imgui.is_window_appearing() or is_left:  # Enter takes the cursor out: what was wrong can be typed anew
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(-1.0)
    commands: list[cmd.Command] = []
    hint = "Path of a file"
    changed, text = imgui.input_text_with_hint("##path", hint, state.panels.dialog_path)
    if changed:
        commands.append(cmd.EditPath(text))
    if imgui.is_item_deactivated() and imgui.is_key_pressed(imgui.Key.enter, repeat=False):
        commands.append(cmd.ConfirmPath())
    if note:
        wrapped(ui, note, ui.colors.error, theme.SMALL_PT)
    if state.panels.dialog_list is not None:
        imgui.dummy((1.0, ui.pt(2)))
        commands += draw_folder(ui, state.panels.dialog_list, state.panels.dialog_path)
    verb = "Open" if state.panels.dialog.startswith("open") else "Save"
    return commands + _buttons(ui, ("Cancel", cmd.Escape()), (verb, cmd.ConfirmPath()))


def _buttons(ui: Ui, *choices: tuple[str, cmd.Command]) -> list[cmd.Command]:
    """A row at the lower right; the last is the primary one."""
    commands: list[cmd.Command] = []
    width, gap = ui.pt(108), ui.pt(8)
    width_all, padding = imgui.get_window_size().x, imgui.get_style().window_padding
    total = len(choices) * (width + gap) - gap
    top = max(imgui.get_cursor_pos_y() + ui.pt(7), ui.pt(HEIGHT_PT - 34) - padding.y)
    imgui.set_cursor_pos((width_all - padding.x - total, top))
    for number, (label, command) in enumerate(choices):
        if number:
            imgui.same_line(0.0, gap)
        if number == len(choices) - 1:
            with primary(ui), face(ui.fonts.bold):
                pressed = imgui.button(label, (width, ui.pt(34)))
        else:
            pressed = imgui.button(label, (width, ui.pt(34)))
        if pressed:
            commands.append(command)
    return commands
