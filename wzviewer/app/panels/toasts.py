"""Top right: notices that go by themselves; a click removes one."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, plate, wrapped
from wzviewer.app.state import AppState, Toast

ICONS = {
    "info": (icons.ICON_FA_CIRCLE_INFO, "muted"),
    "done": (icons.ICON_FA_CIRCLE_CHECK, "done"),
    "error": (icons.ICON_FA_TRIANGLE_EXCLAMATION, "error"),
}
FADE_S = 0.25
USUAL_PT = 58.0  # height of a notice of one or two lines, with the gap below
MAX_DETAILS = 900  # characters: the end of a traceback says what happened


def draw_toasts(state: AppState, ui: Ui, rect: Rect, is_front: bool = False) -> list[cmd.Command]:
    """Draws the notices, the newest below.

    Args:
        state: of the app.
        ui: what to draw with.
        rect: where they may stand.
        is_front: whether they stand before all that was drawn earlier, to be read only.
    """
    flags = imgui.WindowFlags_.no_inputs.value if is_front else 0
    in_front = is_front or not state.has_document
    commands: list[cmd.Command] = []
    top, usual = rect.y, ui.pt(USUAL_PT)
    alive = [toast for toast in state.toasts if toast.is_alive(state.now_s)]
    alive = alive[-max(int(rect.height / usual), 1) :]  # the older ones give way
    for number, toast in enumerate(alive):
        later = usual * (len(alive) - 1 - number)
        most = max(rect.bottom - top - later, usual)
        imgui.push_style_var(imgui.StyleVar_.alpha.value, _opacity(toast, state.now_s))
        place = Rect(rect.x, top, rect.width, most)
        with plate(f"toast{number}", place, flags, grows="down", scrolls=True, is_front=in_front):
            asked = _draw(ui, toast)
            top += imgui.get_window_height() + ui.pt(8)
            if not asked and imgui.is_window_hovered() and imgui.is_mouse_clicked(0):
                asked = [] if _is_on_button() else [cmd.DismissToast(toast.text)]
            commands += asked
        imgui.pop_style_var()
    return commands


def _draw(ui: Ui, toast: Toast) -> list[cmd.Command]:
    icon, color = ICONS[toast.kind]
    with colored(getattr(ui.colors, color)):
        imgui.text_unformatted(icon)
    imgui.same_line(0.0, ui.pt(8))
    room = imgui.get_content_region_avail().x
    imgui.push_text_wrap_pos(0.0)
    imgui.text_unformatted(toast.text)
    imgui.pop_text_wrap_pos()
    beside = _beside(ui, toast, room)
    commands = beside if beside is not None else _buttons(ui, toast)
    if toast.is_expanded:  # below the buttons, which so are in reach when it has to be scrolled
        wrapped(ui, toast.details[-MAX_DETAILS:], ui.colors.muted, theme.SMALL_PT - 1.0)
    return commands


def _beside(ui: Ui, toast: Toast, room: float) -> list[cmd.Command] | None:
    """The only button beside a short text; None where it has to stand below."""
    width = imgui.calc_text_size(toast.button).x + ui.pt(16)
    is_alone = bool(toast.button) and not toast.details and toast.retry is None
    if toast.command is None or not is_alone:
        return None
    if imgui.calc_text_size(toast.text).x + width + ui.pt(10) > room:
        return None
    left = imgui.get_window_width() - imgui.get_style().window_padding.x - width
    imgui.same_line(left)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(8), ui.pt(2)))
    imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() - ui.pt(2))
    with colored(ui.colors.accent):
        pressed = imgui.button(toast.button, (width, 0.0))
    imgui.pop_style_var()
    return [toast.command, cmd.DismissToast(toast.text)] if pressed else []


def _buttons(ui: Ui, toast: Toast) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(10), ui.pt(4)))
    if toast.details:
        if imgui.button("Less" if toast.is_expanded else "Details"):
            commands.append(cmd.ExpandToast(toast.text))
        imgui.same_line(0.0, ui.pt(6))
    if toast.retry is not None and imgui.button("Retry"):
        commands.append(cmd.Retry(toast.text))
    if toast.button and toast.command is not None and imgui.button(toast.button):
        commands += [toast.command, cmd.DismissToast(toast.text)]
    imgui.pop_style_var()
    return commands


def _is_on_button() -> bool:
    return bool(imgui.is_any_item_hovered())


def _opacity(toast: Toast, now_s: float) -> float:
    if toast.is_expanded:
        return 1.0
    age_s = now_s - toast.born_s
    return max(min(age_s / FADE_S, (toast.life_s - age_s) / FADE_S, 1.0), 0.05)
