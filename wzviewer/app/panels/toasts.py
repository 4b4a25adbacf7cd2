"""Top right: notices that go by themselves; a click removes one."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, plate
from wzviewer.app.state import TOAST_S, AppState, Toast

ICONS = {
    "info": (icons.ICON_FA_CIRCLE_INFO, theme.MUTED),
    "done": (icons.ICON_FA_CIRCLE_CHECK, theme.DONE),
    "error": (icons.ICON_FA_TRIANGLE_EXCLAMATION, theme.ERROR),
}
FADE_S = 0.25


def draw_toasts(state: AppState, ui: Ui, rect: Rect) -> list[cmd.Command]:
    """Draws the notices, the newest below.

    Args:
        state: of the app.
        ui: what to draw with.
        rect: where they may stand.
    """
    commands: list[cmd.Command] = []
    top = rect.y
    for number, toast in enumerate(t for t in state.toasts if t.is_alive(state.now_s)):
        imgui.push_style_var(imgui.StyleVar_.alpha.value, _opacity(toast, state.now_s))
        with plate(f"toast{number}", Rect(rect.x, top, rect.width, 0.0), grows="down"):
            _draw(ui, toast)
            top += imgui.get_window_height() + ui.pt(8)
            if imgui.is_window_hovered() and imgui.is_mouse_clicked(0):
                commands.append(cmd.DismissToast(toast.text))
        imgui.pop_style_var()
    return commands


def _draw(ui: Ui, toast: Toast) -> None:
    icon, color = ICONS[toast.kind]
    with colored(color):
        imgui.text_unformatted(icon)
    imgui.same_line(0.0, ui.pt(8))
    imgui.push_text_wrap_pos(0.0)
    imgui.text_unformatted(toast.text)
    imgui.pop_text_wrap_pos()


def _opacity(toast: Toast, now_s: float) -> float:
    age_s = now_s - toast.born_s
    return max(min(age_s / FADE_S, (TOAST_S[toast.kind] - age_s) / FADE_S, 1.0), 0.05)
