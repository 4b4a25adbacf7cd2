"""Top right, on request: what is drawn and how, frame times, and numbers of picture and scene."""

from itertools import pairwise

import numpy as np
from imgui_bundle import imgui, implot

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.look import MODES, RAMP, Look, level_color
from wzviewer.app.panels.surface import Ui, choice, colored, face, plate, small, switch
from wzviewer.app.panels.wording import UNIT
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

PLOT_PT = 46.0
LEGEND_PT = 10.0
SWATCHES = 12  # levels in the legend


def draw_look(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel."""
    if not state.panels.statistics:
        return []
    commands: list[cmd.Command] = []
    rect = ui.layout.statistics
    with plate("look", rect, grows="down", scrolls=True), face(ui.fonts.regular, theme.SMALL_PT):
        imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(6), ui.pt(3)))
        imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (ui.pt(6), ui.pt(4)))
        commands += _modes(state.look, ui) + _switches(state.look, ui)
        _legend(state, ui)
        _plot(ui)
        _numbers(state, ui)
        imgui.pop_style_var(2)
    return commands


def _modes(look: Look, ui: Ui) -> list[cmd.Command]:
    mode = choice(ui, "mode", [(name, mode) for mode, name in MODES], look.mode)
    return [] if mode is None else [cmd.SetLook(_with(look, mode=mode))]


def _switches(look: Look, ui: Ui) -> list[cmd.Command]:
    """The switches, each with the look that it would give."""
    commands: list[cmd.Command] = []
    is_linear = look.blend == "linear"
    rows = (
        ("Levels hand over (Eq. 3)", look.modulation, _with(look, modulation=not look.modulation)),
        ("Linear blend (Eq. 2)", is_linear, _with(look, blend="transmittance" if is_linear else "linear")),
        ("Merge surfels below a pixel", look.merged, _with(look, merged=not look.merged)),
        ("Leave out what is too faint", look.skips_faint, _with(look, skips_faint=not look.skips_faint)),
    )
    for name, is_on, after in rows:
        if switch(ui, name, is_on)[0]:
            commands.append(cmd.SetLook(after))
    return commands


def _with(look: Look, **changes: object) -> Look:
    return Look(**{**vars(look), **changes})


def _legend(state: AppState, ui: Ui) -> None:
    """What the colours stand for."""
    draw, at = imgui.get_window_draw_list(), imgui.get_cursor_screen_pos()
    width, height = imgui.get_content_region_avail().x, ui.pt(LEGEND_PT)
    lower = at.y + height
    if state.look.mode == "levels":
        indices = state.scene.visible()[:SWATCHES]
        part = width / max(len(indices), 1)
        for place, index in enumerate(indices):
            x, color = at.x + place * part, (*level_color(index), 1.0)
            draw.add_rect_filled((x, at.y), (x + part - ui.pt(2), lower), u32(color), ui.pt(2))
        ends = ("photo", "newest")
    elif state.look.mode == "depth":
        part = width / (len(RAMP) - 1)
        colors = [u32((*(c / 255.0), 1.0)) for c in RAMP]
        for place, (a, b) in enumerate(pairwise(colors)):
            x = at.x + place * part
            draw.add_rect_filled_multi_color((x, at.y), (x + part, lower), a, b, b, a)
        ends = ("near", "far")
    else:
        return
    imgui.dummy((width, height))
    small(ui, ends[0])
    imgui.same_line(at.x - imgui.get_window_pos().x + width - imgui.calc_text_size(ends[1]).x)
    small(ui, ends[1])


def _plot(ui: Ui) -> None:
    """Times of the last pictures in motion, with the time that they may take."""
    times = np.asarray(ui.frame_times_ms, np.float32)
    if len(times) < 2:
        return
    limit = 1.15 * max(float(times.max()), ui.target_ms)
    flags = implot.Flags_.canvas_only.value | implot.Flags_.no_inputs.value
    implot.push_style_color(implot.Col_.frame_bg.value, imgui.ImVec4(0, 0, 0, 0))
    implot.push_style_color(implot.Col_.plot_bg.value, imgui.ImVec4(*ui.colors.field))
    implot.push_style_color(implot.Col_.plot_border.value, imgui.ImVec4(0, 0, 0, 0))
    implot.push_style_var(implot.StyleVar_.plot_padding.value, imgui.ImVec2(0.0, 0.0))
    if implot.begin_plot("##frame times", imgui.ImVec2(-1.0, ui.pt(PLOT_PT)), flags):
        bare = implot.AxisFlags_.no_decorations.value
        implot.setup_axes("", "", bare, bare)
        implot.setup_axes_limits(0.0, len(times) - 1.0, 0.0, limit, imgui.Cond_.always.value)
        target = np.full(2, ui.target_ms, np.float32)
        implot.plot_line("target", target, float(len(times) - 1), 0.0, _line(ui.colors.muted, 1.0))
        implot.plot_line("frames", times, 1.0, 0.0, _line(ui.colors.accent, ui.pt(1.5)))
        implot.end_plot()
    implot.pop_style_var()
    implot.pop_style_color(3)
    small(ui, f"frames in motion, up to {limit / 1.15:.0f} ms; the line is {ui.target_ms:.0f} ms")


def _line(color: theme.Rgba, weight: float) -> implot.Spec:
    spec = implot.Spec()
    spec.line_color, spec.line_weight = imgui.ImVec4(*color), weight
    return spec


def _numbers(state: AppState, ui: Ui) -> None:
    right = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x  # before a scroll bar
    for name, value in {**ui.statistics, **_of_scene(state)}.items():
        with colored(ui.colors.muted):
            imgui.text_unformatted(name)
        width = imgui.calc_text_size(value).x
        imgui.same_line(right - width)
        imgui.text_unformatted(value)


def _of_scene(state: AppState) -> dict[str, str]:
    if not len(state.scene):
        return {}
    return {
        "Levels": f"{len(state.scene.visible())} of {len(state.scene)}",
        "Surfels in all": f"{state.scene.num_surfels:,}",
        "Focal length": f"{state.view.camera.focal_px:,.0f} px",
        "Distance of the focus": f"{state.view.focus_depth:.3g} {UNIT}",
    }
