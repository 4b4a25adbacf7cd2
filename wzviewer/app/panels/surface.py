"""What all panels share: the picture of the interface that they draw into, and its plates."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from imgui_bundle import imgui

from wzviewer.app import theme
from wzviewer.app.keys import LETTERS
from wzviewer.app.layout import Layout, Rect
from wzviewer.app.logbook import LogLine
from wzviewer.app.theme import Fonts
from wzviewer.app.thumbnails import Thumbnail

T = TypeVar("T")
F = imgui.WindowFlags_
PLATE = (
    F.no_decoration.value
    | F.no_move.value
    | F.no_saved_settings.value
    | F.no_nav.value
    | F.no_focus_on_appearing.value
    | F.no_bring_to_front_on_focus.value
)


@dataclass(frozen=True, eq=False)
class Ui:
    """All that a panel needs beside the state.

    Attributes:
        layout: where the panels stand.
        fonts: the faces in use.
        thumbnails: by level index.
        photo: the flat picture, before E_0 exists.
        backdrop: the picture behind the start page.
        recents: pictures of recent files.
        statistics: lines for the statistics panel.
        frame_times_ms: of the last pictures in motion.
        target_ms: that such a picture may take.
        colors: of the panels.
        log: messages, while their window is open.
        letters: printed at the places of W A S D Q E.
    """

    layout: Layout
    fonts: Fonts
    thumbnails: Mapping[int, Thumbnail] = field(default_factory=dict)
    photo: Thumbnail | None = None
    backdrop: Thumbnail | None = None
    statistics: Mapping[str, str] = field(default_factory=dict)
    frame_times_ms: Sequence[float] = ()
    target_ms: float = 16.7
    colors: theme.Palette = theme.DARK
    recents: Mapping[Path, Thumbnail] = field(default_factory=dict)
    letters: str = LETTERS
    log: Sequence[LogLine] = ()

    def pt(self, points: float) -> float:
        """Points to imgui units."""
        return points * self.layout.scale


@contextmanager
def plate(
    name: str,
    rect: Rect,
    flags: int = 0,
    alpha: float | None = None,
    grows: str = "",
    scrolls: bool = False,
    is_front: bool = False,
) -> Iterator[None]:
    """A panel at a place.

    Args:
        name: unique.
        rect: its place; where the height follows the contents, the height is the most it may be, if any.
        flags: further window flags of imgui.
        alpha: opacity of its ground; the theme's when None.
        grows: "down" or "up" lets the height follow the contents.
        scrolls: whether contents that do not fit can be scrolled.
        is_front: whether it stands before all panels drawn earlier.
    """
    pivot = (0.0, 1.0) if grows == "up" else (0.0, 0.0)
    imgui.set_next_window_pos((rect.x, rect.bottom if grows == "up" else rect.y), pivot=pivot)
    imgui.set_next_window_size((rect.width, 0.0 if grows else rect.height))
    if grows and rect.height > 0:
        imgui.set_next_window_size_constraints((rect.width, 0.0), (rect.width, rect.height))
    if alpha is not None:
        imgui.set_next_window_bg_alpha(alpha)
    shape = PLATE & ~F.no_scrollbar.value if scrolls else PLATE
    if is_front:
        shape &= ~F.no_bring_to_front_on_focus.value
    imgui.begin(name, None, shape | flags)
    if is_front:  # without the focus, which would take the cursor out of a line being typed
        imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
    try:
        yield
    finally:
        imgui.end()


def shade(ui: Ui) -> bool:
    """Darkens all that was drawn before and keeps the mouse from it; returns whether it was clicked."""
    imgui.push_style_var(imgui.StyleVar_.window_rounding.value, 0.0)
    with colored(ui.colors.shade, imgui.Col_.window_bg), plate("shade", ui.layout.window, is_front=True):
        is_clicked = imgui.is_window_hovered() and imgui.is_mouse_clicked(0)
    imgui.pop_style_var()
    return is_clicked


@contextmanager
def menu(ui: Ui, name: str, is_context: bool = False) -> Iterator[bool]:
    """A menu that has been opened; it takes Escape (`input`).

    Args:
        ui: what to draw with.
        name: as it is opened with.
        is_context: whether the right button on the last item opens it.
    """
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(12), ui.pt(10)))
    imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (ui.pt(14), ui.pt(8)))
    is_open = imgui.begin_popup_context_item(name) if is_context else imgui.begin_popup(name)
    try:
        yield is_open
    finally:
        if is_open:
            imgui.end_popup()
        imgui.pop_style_var(2)


@contextmanager
def face(font: imgui.ImFont, size_pt: float = theme.BODY_PT) -> Iterator[None]:
    """Text in another face or size."""
    imgui.push_font(font, size_pt)
    try:
        yield
    finally:
        imgui.pop_font()


@contextmanager
def colored(color: theme.Rgba, *slots: imgui.Col_) -> Iterator[None]:
    """Text, or other slots, in another colour."""
    chosen = slots or (imgui.Col_.text,)
    for slot in chosen:
        imgui.push_style_color(slot, color)
    try:
        yield
    finally:
        imgui.pop_style_color(len(chosen))


@contextmanager
def primary(ui: Ui) -> Iterator[None]:
    """Buttons in the accent colour: one on the screen at a time."""
    r, g, b, _ = ui.colors.accent
    lighter = (min(r + 0.03, 1.0), min(g + 0.06, 1.0), min(b + 0.10, 1.0), 1.0)
    C = imgui.Col_
    with (
        colored(ui.colors.accent, C.button),
        colored(lighter, C.button_hovered, C.button_active),
        colored(ui.colors.on_accent),
    ):
        yield


@contextmanager
def quiet() -> Iterator[None]:
    """Buttons without a face until the cursor is over them."""
    with colored((0.0, 0.0, 0.0, 0.0), imgui.Col_.button):
        yield


def choice(
    ui: Ui, key: str, options: Sequence[tuple[str, T]], present: object, room: float | None = None
) -> T | None:
    """Draws a row of buttons, one of them lit; returns the value that was pressed."""
    picked: T | None = None
    gap = ui.pt(4)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (ui.pt(4), ui.pt(4)))
    room = imgui.get_content_region_avail().x if room is None else room
    width = (room - gap * (len(options) - 1)) / len(options)
    for number, (name, value) in enumerate(options):
        if number:
            imgui.same_line(0.0, gap)
        is_on = value == present
        back = ui.colors.pressed if is_on else ui.colors.field
        with colored(ui.colors.accent if is_on else ui.colors.text), colored(back, imgui.Col_.button):
            if imgui.button(f"{name}##{key}", (width, 0.0)):
                picked = value
    imgui.pop_style_var()
    return picked


def tooltip(text: str) -> None:
    """Explains the last item after a moment."""
    if imgui.is_item_hovered(imgui.HoveredFlags_.delay_normal.value):
        line = imgui.get_font_size()  # not the padding of the panel that it is for
        imgui.push_style_var(imgui.StyleVar_.window_padding.value, (0.7 * line, 0.5 * line))
        imgui.set_tooltip(text)
        imgui.pop_style_var()


def small(ui: Ui, text: str, color: theme.Rgba | None = None) -> None:
    """A small line in a quiet colour."""
    with face(ui.fonts.regular, theme.SMALL_PT), colored(color or ui.colors.muted):
        imgui.text_unformatted(text)


def wrapped(ui: Ui, text: str, color: theme.Rgba | None = None, size_pt: float = theme.BODY_PT) -> None:
    """A text that breaks at the right edge."""
    with face(ui.fonts.regular, size_pt), colored(color or ui.colors.text):
        imgui.push_text_wrap_pos(0.0)
        imgui.text_unformatted(text)
        imgui.pop_text_wrap_pos()


def elided(text: str, width: float) -> str:
    """Returns a text shortened to a width in the current face."""
    if imgui.calc_text_size(text).x <= width:
        return text
    while text and imgui.calc_text_size(text + "…").x > width:
        text = text[:-1]
    return text.rstrip() + "…"


def picture(
    ui: Ui,
    thumbnail: Thumbnail | None,
    rect: tuple[float, float, float, float],
    is_here: bool,
    opacity: float = 1.0,
) -> None:
    """Draws a level's picture, cropped to a frame (x, y, width, height); a border says "here"."""
    x, y, width, height = rect
    draw = imgui.get_window_draw_list()
    if thumbnail is None:
        draw.add_rect_filled((x, y), (x + width, y + height), theme.u32(ui.colors.field), ui.pt(5))
    else:
        excess = thumbnail.aspect / (width / height)
        u, v = (0.5 - 0.5 / excess, 0.0) if excess > 1 else (0.0, 0.5 - 0.5 * excess)
        corners = ((x, y), (x + width, y + height), (u, v), (1 - u, 1 - v))
        draw.add_image_rounded(thumbnail.ref, *corners, theme.u32((1, 1, 1, opacity)), ui.pt(5))
    if is_here:
        draw.add_rect((x, y), (x + width, y + height), theme.u32(ui.colors.accent), ui.pt(5), ui.pt(1.5))
