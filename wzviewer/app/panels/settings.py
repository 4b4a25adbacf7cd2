"""Below the toolbar, on request: what the user prefers."""

from dataclasses import replace
from typing import Any

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.panels.surface import Ui, choice, face, plate, small, switch, tooltip
from wzviewer.app.settings import Settings
from wzviewer.app.state import AppState

WIDTH_PT = 300.0
THEMES = (("Dark", "dark"), ("Light", "light"))
SIZES = (("Small", 14.0), ("Normal", 16.0), ("Large", 18.0), ("Huge", 20.0))
KEYMAPS = (("Standard", "wzviewer"), ("WonderZoom", "authors"))
RASTERIZERS = (("Auto", "auto"), ("Graphics", "shaders"), ("Processor", "kernels"))

SWITCHES = (
    (
        "Auto detail",
        "auto_detail",
        "Where the view rests and detail is missing, it is made without being asked for",
    ),
    ("Reduced motion", "reduced_motion", "Jump to other views instead of flying there"),
)


def draw_settings(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel."""
    if not state.panels.settings:
        return []
    side, now = ui.layout.side, state.settings
    rect = replace(side, width=min(ui.pt(WIDTH_PT), side.width))
    changes: dict[str, Any] = {}
    with plate("settings", rect, grows="down", alpha=0.97, scrolls=True, is_front=True):
        with face(ui.fonts.bold):
            imgui.text_unformatted("Settings")
        rows: tuple[tuple[str, str, tuple[tuple[str, Any], ...]], ...] = (
            ("Theme", "theme", THEMES),
            ("Size of the text", "font_pt", SIZES),
            ("Keys", "keymap", KEYMAPS),
            ("Drawn by, from the next start on", "rasterizer", RASTERIZERS),
        )
        for name, key, options in rows:
            small(ui, name)
            picked = choice(ui, key, options, getattr(now, key))
            if key == "keymap":
                tooltip("W A S D look around, V and B zoom, R makes detail, Z undoes")
            if picked is not None:
                changes[key] = picked
        for name, key, about in SWITCHES:
            is_changed, is_on = switch(ui, name, getattr(now, key))
            tooltip(about)
            if is_changed:
                changes[key] = is_on
    return [cmd.ChangeSettings(_changed(now, changes))] if changes else []


def _changed(settings: Settings, changes: dict[str, Any]) -> Settings:
    return replace(settings, **changes)
