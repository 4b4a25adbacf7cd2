"""Top right, on request: numbers of the picture and of the scene."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.panels.surface import Ui, colored, face, plate
from wzviewer.app.state import AppState


def draw_statistics(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the statistics panel."""
    if not state.panels.statistics:
        return []
    with plate("statistics", ui.layout.statistics, grows="down"), face(ui.fonts.regular, theme.SMALL_PT):
        for name, value in {**ui.statistics, **_of_scene(state)}.items():
            with colored(theme.MUTED):
                imgui.text_unformatted(name)
            width = imgui.calc_text_size(value).x
            imgui.same_line(ui.layout.statistics.width - width - imgui.get_style().window_padding.x)
            imgui.text_unformatted(value)
    return []


def _of_scene(state: AppState) -> dict[str, str]:
    if not len(state.scene):
        return {}
    return {
        "Levels": f"{len(state.scene.visible())} of {len(state.scene)}",
        "Surfels in all": f"{state.scene.num_surfels:,}",
        "Focal length": f"{state.view.camera.focal_px:,.0f} px",
        "Distance of the focus": f"{state.view.focus_depth:.3g} u",
    }
