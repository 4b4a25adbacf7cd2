"""Above the prompt line: what waits for the running request, as chips that can be taken out."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.naming import DETAIL, name_in
from wzviewer.app.panels.frame import draw_place
from wzviewer.app.panels.surface import Ui, colored, elided, face, plate, quiet, tooltip
from wzviewer.app.state import AppState, Goal
from wzviewer.core.scene import Scene

CHIP_PT = 118.0  # longest text in a chip
CLEAR_PT, MORE_PT = 64.0, 34.0


def draw_waiting(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    """Draws the queue; returns what was asked for, and the height, imgui units."""
    goals = state.queue.goals
    if not goals:
        return [], 0.0
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(12), ui.pt(6)))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(8), ui.pt(4)))
    with plate("waiting", above, grows="up"), face(ui.fonts.regular, theme.SMALL_PT + 1.0):
        right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
        imgui.align_text_to_frame_padding()
        with colored(ui.colors.muted):
            imgui.text_unformatted("Next")
        imgui.same_line(0.0, ui.pt(8))
        for place, goal in enumerate(goals):
            text = elided(wish_text(state.scene, goal), min(ui.pt(CHIP_PT), above.width / 5))
            needed = imgui.calc_text_size(f"{text}  {icons.ICON_FA_XMARK}").x + ui.pt(20 + CLEAR_PT)
            rest = ui.pt(MORE_PT) if place + 1 < len(goals) else 0.0
            if place and imgui.get_cursor_screen_pos().x + needed + rest > right:
                _more(ui, len(goals) - place)
                break
            if imgui.button(f"{text}  {icons.ICON_FA_XMARK}##wish{place}"):
                commands.append(cmd.DropWish(place))
            if imgui.is_item_hovered():
                draw_place(state, ui, goal.camera)
            tooltip("Take it out of the queue")
            imgui.same_line(0.0, ui.pt(4))
        imgui.same_line(right - imgui.get_window_pos().x - imgui.calc_text_size("Clear").x - ui.pt(16))
        with quiet(), colored(ui.colors.muted):
            if imgui.button("Clear##wishes"):
                commands.append(cmd.ClearQueue())
        tooltip("Empty the queue   Esc twice")
        height = imgui.get_window_height()
    imgui.pop_style_var(2)
    return commands, height


def wish_text(scene: Scene, goal: Goal) -> str:
    """Returns what a goal is called in the queue."""
    if goal.like is not None and goal.like < len(scene):
        what = name_in(scene, goal.like)
        name = "other detail" if what == DETAIL else f"another {what.removeprefix('a ').removeprefix('an ')}"
    else:
        name = goal.prompt or "finer detail"
    return f"{goal.count} × {name}" if goal.count > 1 else name  # in front: the end may be cut off


def _more(ui: Ui, count: int) -> None:
    imgui.align_text_to_frame_padding()
    with colored(ui.colors.muted):
        imgui.text_unformatted(f"+ {count}")
    imgui.same_line(0.0, ui.pt(4))
