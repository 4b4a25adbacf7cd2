"""Looks: a calm dark theme, so that the picture is what one sees.

Sizes are in points; `scale` turns them into what imgui counts in on a dense screen.
"""

from dataclasses import dataclass
from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Palette:
    """Colours of the panels.

    Attributes:
        text: of everything that is read first.
        muted: of the rest.
        faint: thin lines.
        accent: what is chosen or waits to be pressed.
        on_accent: text on it.
        panel: behind panels; the picture shines through.
        solid: behind popups.
        field: behind lines of text and buttons.
        hover: the same under the cursor.
        pressed: the same under the finger.
        done: of good news.
        error: of bad news.
        shade: over all that is not in front.
    """

    text: Rgba
    muted: Rgba
    faint: Rgba
    accent: Rgba
    on_accent: Rgba
    panel: Rgba
    solid: Rgba
    field: Rgba
    hover: Rgba
    pressed: Rgba
    done: Rgba
    error: Rgba
    shade: Rgba

    @property
    def line(self) -> Rgba:
        """Of lines that join: between faint and muted."""
        return (*self.text[:3], 0.32)


DARK = Palette(
    text=(0.93, 0.94, 0.95, 1.0),
    muted=(0.93, 0.94, 0.95, 0.66),
    faint=(0.93, 0.94, 0.95, 0.14),
    accent=(0.96, 0.74, 0.42, 1.0),
    on_accent=(0.12, 0.09, 0.05, 1.0),
    panel=(0.055, 0.060, 0.070, 0.88),
    solid=(0.075, 0.080, 0.092, 0.98),
    field=(1.0, 1.0, 1.0, 0.07),
    hover=(1.0, 1.0, 1.0, 0.12),
    pressed=(1.0, 1.0, 1.0, 0.18),
    done=(0.55, 0.82, 0.62, 1.0),
    error=(1.0, 0.62, 0.57, 1.0),
    shade=(0.0, 0.0, 0.0, 0.55),
)
LIGHT = Palette(
    text=(0.10, 0.11, 0.13, 1.0),
    muted=(0.10, 0.11, 0.13, 0.68),
    faint=(0.10, 0.11, 0.13, 0.18),
    accent=(0.54, 0.235, 0.0, 1.0),
    on_accent=(1.0, 0.99, 0.97, 1.0),
    panel=(0.97, 0.97, 0.96, 0.93),
    solid=(0.98, 0.98, 0.97, 0.99),
    field=(0.0, 0.0, 0.0, 0.06),
    hover=(0.0, 0.0, 0.0, 0.10),
    pressed=(0.0, 0.0, 0.0, 0.13),
    done=(0.10, 0.48, 0.22, 1.0),
    error=(0.66, 0.10, 0.07, 1.0),
    shade=(0.0, 0.0, 0.0, 0.45),
)
PALETTES = {"dark": DARK, "light": LIGHT}
ON_PICTURE: Rgba = DARK.text  # with a shadow: readable on any

BODY_PT, SMALL_PT, HEAD_PT, TITLE_PT = 16.0, 13.5, 18.0, 34.0
ROUNDING_PT = 10.0


@dataclass(frozen=True, eq=False)
class Fonts:
    """The faces in use, each with the icons merged in.

    Attributes:
        regular: for everything.
        bold: for headings.
    """

    regular: imgui.ImFont
    bold: imgui.ImFont


def apply_theme(scale: float) -> Fonts:
    """Sets imgui's style and loads the fonts.

    Args:
        scale: imgui units per point: the content scale over the framebuffer scale.
    """
    imgui.get_style().scale_all_sizes(scale)  # once, for what is not set below
    restyle(scale, DARK)
    return Fonts(_load("Roboto-Regular.ttf"), _load("Roboto-Bold.ttf"))


def restyle(scale: float, palette: Palette) -> None:
    """Sets sizes and colours, between two frames.

    Args:
        scale: imgui units per point.
        palette: of the panels.
    """
    style = imgui.get_style()
    _set_shape(style, scale)
    _set_colors(style, palette)
    style.font_size_base = BODY_PT
    style.font_scale_dpi = scale


def u32(color: Rgba, alpha: float = 1.0) -> int:
    """Packs a colour for a draw list, with its opacity multiplied."""
    return int(imgui.get_color_u32((color[0], color[1], color[2], color[3] * alpha)))


def _load(name: str) -> imgui.ImFont:
    folder = Path(imgui_bundle.__file__).parent / "assets" / "fonts"
    fonts = imgui.get_io().fonts
    face, icons = folder / "Roboto" / name, folder / "Font_Awesome_6_Free-Solid-900.otf"
    if not face.is_file():
        return fonts.add_font_default()
    font = fonts.add_font_from_file_ttf(str(face), BODY_PT)
    if icons.is_file():
        config = imgui.ImFontConfig()
        config.merge_mode = True
        config.glyph_min_advance_x = BODY_PT * 1.1  # icons of one width, so that labels align
        config.glyph_offset = imgui.ImVec2(0.0, 1.0)
        fonts.add_font_from_file_ttf(str(icons), BODY_PT * 0.86, config)
    return font


def _set_shape(style: imgui.Style, scale: float) -> None:
    def pair(x_pt: float, y_pt: float) -> imgui.ImVec2:
        return imgui.ImVec2(round(x_pt * scale), round(y_pt * scale))

    style.window_padding = pair(14.0, 12.0)
    style.frame_padding = pair(10.0, 7.0)
    style.item_spacing = pair(8.0, 7.0)
    style.item_inner_spacing = pair(7.0, 5.0)
    style.window_rounding = ROUNDING_PT * scale
    style.child_rounding = style.popup_rounding = style.frame_rounding = 7.0 * scale
    style.window_border_size = style.popup_border_size = max(round(scale), 1.0)  # an edge on any picture
    style.child_border_size = style.frame_border_size = 0.0
    style.scrollbar_size, style.scrollbar_rounding = 8.0 * scale, 4.0 * scale
    style.hover_delay_normal = 0.5
    style.window_min_size = pair(8.0, 8.0)


def _set_colors(style: imgui.Style, palette: Palette) -> None:
    C = imgui.Col_
    clear = (0.0, 0.0, 0.0, 0.0)
    for slot, color in (
        (C.text, palette.text),
        (C.text_disabled, palette.muted),
        (C.window_bg, palette.panel),
        (C.popup_bg, palette.solid),
        (C.child_bg, clear),
        (C.border, palette.faint),
        (C.frame_bg, palette.field),
        (C.frame_bg_hovered, palette.hover),
        (C.frame_bg_active, palette.hover),
        (C.button, palette.field),
        (C.button_hovered, palette.hover),
        (C.button_active, palette.pressed),
        (C.header, palette.hover),
        (C.header_hovered, palette.hover),
        (C.header_active, palette.pressed),
        (C.separator, palette.faint),
        (C.scrollbar_bg, clear),
        (C.scrollbar_grab, palette.hover),
        (C.scrollbar_grab_hovered, palette.pressed),
        (C.scrollbar_grab_active, palette.pressed),
        (C.text_selected_bg, (*palette.accent[:3], 0.35)),
        (C.input_text_cursor, palette.accent),
        (C.check_mark, palette.accent),
        (C.checkbox_selected_bg, palette.pressed),
        (C.modal_window_dim_bg, palette.shade),
        (C.nav_cursor, clear),
    ):
        style.set_color_(slot, color)
