"""Instead of all, while there is no document: drop a photo, open one, or try the demo."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.notices import START_PT
from wzviewer.app.panels.prompt import draw_bar
from wzviewer.app.panels.recents import draw_leftover, draw_recents, extra_height
from wzviewer.app.panels.surface import Ui, colored, elided, face, plate, primary, shade
from wzviewer.app.state import AppState
from wzviewer.app.theme import u32

SIZE_PT = (520.0, 274.0)


def draw_start(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the start page."""
    _backdrop(ui)
    return [] if state.panels.dialog else _page(state, ui)  # which would look out from behind the dialog


def draw_start_over(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the same over a document, on request; a click beside it goes back to the document."""
    if not state.panels.start or not state.has_document:
        return []
    is_left = shade(ui)
    return [cmd.Toggle("start")] if is_left else _page(state, ui)


def _page(state: AppState, ui: Ui) -> list[cmd.Command]:
    window = ui.layout.window
    extra, rows = extra_height(state, ui)
    wide = START_PT if rows else SIZE_PT[0]
    sides = (ui.pt(wide), ui.pt(SIZE_PT[1]) + extra)
    width, height = (min(side, room) for side, room in zip(sides, _room(window), strict=True))
    rect = Rect((window.width - width) / 2, (window.height - height) / 2, width, height)
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(32), ui.pt(28)))
    commands: list[cmd.Command] = []
    with plate("start", rect, alpha=0.97 if state.has_document else 0.90, is_front=state.has_document):
        with face(ui.fonts.bold, theme.TITLE_PT):
            _centred("wzviewer")
        with colored(ui.colors.muted):
            _centred("One photograph becomes a 3D world to zoom into.")
        commands += _drop_zone(state, ui, imgui.get_content_region_avail().x)
        commands += _links(ui)
        commands += draw_leftover(state, ui) + draw_recents(state, ui, rows)
    imgui.pop_style_var()
    return commands


def _room(window: Rect) -> tuple[float, float]:
    return window.width - 16.0, window.height - 16.0


def _backdrop(ui: Ui) -> None:
    """The bundled picture fills the window, dimmed, so that the page says what this is about."""
    window, picture = ui.layout.window, ui.backdrop
    draw = imgui.get_background_draw_list()
    if picture is not None:
        excess = picture.aspect / (window.width / max(window.height, 1.0))
        u, v = (0.5 - 0.5 / excess, 0.0) if excess > 1 else (0.0, 0.5 - 0.5 * excess)
        draw.add_image(picture.ref, (0, 0), (window.width, window.height), (u, v), (1 - u, 1 - v))
    top, bottom = u32((0.03, 0.035, 0.045, 0.45)), u32((0.03, 0.035, 0.045, 0.80))
    draw.add_rect_filled_multi_color((0, 0), (window.width, window.height), top, top, bottom, bottom)


def _drop_zone(state: AppState, ui: Ui, width: float) -> list[cmd.Command]:
    imgui.dummy((1.0, ui.pt(10)))
    with primary(ui), face(ui.fonts.bold, 17.0):
        pressed = imgui.button(f"{icons.ICON_FA_IMAGE}   Open a photo", (width, ui.pt(52)))
    if state.errand is not None:
        with colored(ui.colors.accent):
            _centred(elided(f"{state.errand.line} …", width))
    else:
        with colored(ui.colors.muted):
            _centred("or drop a photo or a scene anywhere on this window")
    at = imgui.get_cursor_pos()
    if state.errand is not None:
        draw_bar(ui, 0.0, state.now_s, is_unknown=True)
        imgui.set_cursor_pos(at)  # nothing moves below it
    imgui.dummy((1.0, ui.pt(8)))
    return [cmd.AskOpen()] if pressed else []


def _links(ui: Ui) -> list[cmd.Command]:
    commands: list[cmd.Command] = []
    gap = ui.pt(8)
    width = (imgui.get_content_region_avail().x - 2 * gap) / 3
    buttons: tuple[tuple[str, str, cmd.Command], ...] = (
        (icons.ICON_FA_FOLDER_OPEN, "Open a scene", cmd.AskOpen()),
        (icons.ICON_FA_SEEDLING, "Try the demo", cmd.OpenDemo()),
        (icons.ICON_FA_KEYBOARD, "Keys", cmd.Toggle("help")),
    )
    for number, (icon, label, command) in enumerate(buttons):
        if number:
            imgui.same_line(0.0, gap)
        if imgui.button(f"{icon}  {label}", (width, ui.pt(40))):
            commands.append(command)
    return commands


def _centred(text: str) -> None:
    room = imgui.get_content_region_avail().x
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + (room - imgui.calc_text_size(text).x) / 2)
    imgui.text_unformatted(text)
