"""In the prompt bar: choose a region, choose a material, and what Generate can do beside one level."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.keys import label_for, label_of
from wzviewer.app.layout import Rect
from wzviewer.app.naming import name_in
from wzviewer.app.panels.surface import Ui, colored, menu, quiet, tooltip
from wzviewer.app.state import AppState
from wzviewer.app.variants import can_vary, newest
from wzviewer.app.varying import MAX_COUNT

TOOL_PT, CHEVRON_PT = 32.0, 20.0
NARROWEST_PT = 400.0  # prompt bar with room for the tools; their keys work in any


def has_tools(ui: Ui, rect: Rect) -> bool:
    """Whether a prompt bar has room for the tools."""
    return rect.width >= ui.pt(NARROWEST_PT)


def draw_tools(state: AppState, ui: Ui, height: float) -> list[cmd.Command]:
    """Draws the tools, right of the line of text."""
    commands: list[cmd.Command] = []
    is_ready, keymap = len(state.scene) > 0, state.settings.keymap
    tools: tuple[tuple[str, str, cmd.Command, bool, bool], ...] = (
        (
            icons.ICON_FA_PALETTE,
            f"Materials and weather   {label_for(cmd.Toggle('materials'), keymap)}",
            cmd.Toggle("materials"),
            state.panels.materials,
            is_ready and bool(state.vocabulary.objects),
        ),
        (
            icons.ICON_FA_VECTOR_SQUARE,
            f"Draw a frame around what should become finer   {label_of(cmd.ToggleRegion, keymap)}",
            cmd.ToggleRegion(),
            state.region.is_drawing or state.region.camera is not None,
            is_ready,
        ),
    )
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    for number, (icon, what, command, is_on, is_possible) in enumerate(tools):
        imgui.same_line(0.0, ui.pt(4) if number == 0 else 0.0)
        imgui.begin_disabled(not is_possible)
        with quiet(), colored(ui.colors.accent if is_on else ui.colors.muted):
            if imgui.button(f"{icon}##tool{number}", (ui.pt(TOOL_PT - 2), height)):
                commands.append(command)
        imgui.end_disabled()
        tooltip(what)
    imgui.pop_style_var()
    return commands


def draw_more(state: AppState, ui: Ui, height: float) -> list[cmd.Command]:
    """Draws the arrow beside Generate, and what it opens."""
    imgui.same_line(0.0, ui.pt(2))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    imgui.begin_disabled(not len(state.scene))
    if imgui.button(f"{icons.ICON_FA_CARET_UP}##more", (ui.pt(CHEVRON_PT), height)):
        imgui.open_popup("more")
    imgui.end_disabled()
    imgui.pop_style_var()
    tooltip("Several variants, or another of the last")
    corner = imgui.get_item_rect_max()
    imgui.set_next_window_pos((corner.x, ui.layout.prompt.y - ui.pt(6)), pivot=(1.0, 1.0))
    with menu(ui, "more") as is_open:
        return _offers(state) if is_open else []


def _offers(state: AppState) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    for count in range(2, MAX_COUNT + 1):
        if imgui.menu_item(f"Make {count} variants", "", False)[0]:
            commands.append(cmd.Generate(count))
    imgui.separator()
    last = newest(state.scene)
    is_possible = last is not None and can_vary(state.scene, last)
    name = name_in(state.scene, last) if last is not None and is_possible else ""
    label = f"Another “{name}”" if name else "Another of the last level"
    if imgui.menu_item(label, label_of(cmd.Another, state.settings.keymap), False, is_possible)[0]:
        commands.append(cmd.Another(last))
    return commands
