"""The palette and the log window: opened, used, closed."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.overlays import LogView, PaletteView
from wzviewer.app.services import Services
from wzviewer.app.state import AppState


def open_palette(services: Services, state: AppState, command: cmd.OpenPalette) -> AppState:
    """Shows the palette, empty."""
    return replace(state, palette=PaletteView(is_open=True))


def close_palette(services: Services, state: AppState, command: cmd.ClosePalette) -> AppState:
    """Hides the palette."""
    return replace(state, palette=PaletteView())


def edit_palette(services: Services, state: AppState, command: cmd.EditPalette) -> AppState:
    """The line holds another text; the best hit is marked."""
    return replace(state, palette=replace(state.palette, text=command.text, marked=0))


def mark_entry(services: Services, state: AppState, command: cmd.MarkEntry) -> AppState:
    """Marks another hit."""
    return replace(state, palette=replace(state.palette, marked=state.palette.marked + command.step))


def toggle_log(services: Services, state: AppState, command: cmd.ToggleLog) -> AppState:
    """Shows or hides the log window."""
    return replace(state, log=replace(state.log, is_open=not state.log.is_open))


def set_log_level(services: Services, state: AppState, command: cmd.SetLogLevel) -> AppState:
    """Shows more or fewer messages."""
    return replace(state, log=replace(state.log, level=command.level))


def copy_log(services: Services, state: AppState, command: cmd.CopyLog) -> AppState:
    """Puts the messages that are shown on the clipboard."""
    lines = services.log.lines(state.log.level)
    services.copy("\n".join(map(str, lines)))
    count = "1 message" if len(lines) == 1 else f"{len(lines)} messages"
    return state.with_toast(f"Copied {count}.", "done")


def is_summoned(state: AppState) -> bool:
    """Whether one of them has the keyboard."""
    return state.palette.is_open or state.log.is_open


def covers_picture(state: AppState) -> bool:
    """Whether something stands over the picture, so that keys must not move it or add to it."""
    return state.log.is_open or state.panels.help or (state.panels.start and state.has_document)


def dismissed(state: AppState) -> AppState:
    """Returns the state without them."""
    return replace(state, palette=PaletteView(), log=LogView(level=state.log.level))
