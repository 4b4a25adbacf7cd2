"""Above the prompt line while one types: known words, the marked one a Tab away."""

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.surface import Ui, colored, face, plate
from wzviewer.app.state import AppState
from wzviewer.core.vocabulary import Offer


def draw_offers(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    """Draws the offers; returns what was asked for, and the height, imgui units."""
    commands: list[cmd.Command] = []
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(9), ui.pt(7)))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(8), ui.pt(4)))
    with plate("offers", above, grows="up"), face(ui.fonts.regular, theme.SMALL_PT + 1.0):
        right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
        _lead(state, ui)
        for number, offer in enumerate(state.offers):
            if number and not _has_room(ui, offer, right):
                break
            if _chip(ui, offer, is_marked=number == min(state.offer, len(state.offers) - 1)):
                commands.append(cmd.TakeOffer(offer.prompt))
            imgui.same_line(0.0, ui.pt(4))
        height = imgui.get_window_height()
    imgui.pop_style_var(2)
    return commands, height


def _lead(state: AppState, ui: Ui) -> None:
    """What is wrong, or which key takes the marked word."""
    imgui.align_text_to_frame_padding()
    if state.reading.unknown:
        first, last = state.reading.unknown[0]
        with colored(ui.colors.error):
            imgui.text_unformatted(f"“{state.prompt[first:last]}” is not known:")
    else:
        with colored(ui.colors.muted):
            imgui.text_unformatted("Tab")
    imgui.same_line(0.0, ui.pt(8))


def _has_room(ui: Ui, offer: Offer, right: float) -> bool:
    width = imgui.calc_text_size(offer.word).x + 2 * imgui.get_style().frame_padding.x
    return imgui.get_cursor_screen_pos().x + width <= right


def _chip(ui: Ui, offer: Offer, is_marked: bool) -> bool:
    face_color = ui.colors.pressed if is_marked else ui.colors.field
    with colored(ui.colors.accent if is_marked else ui.colors.text), colored(face_color, imgui.Col_.button):
        imgui.button(f"{offer.word}##offer")
    return imgui.is_item_hovered() and imgui.is_mouse_clicked(0)  # at the press: then the popup goes
