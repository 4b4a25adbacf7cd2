"""Looks: a calm dark theme, so that the picture is what one sees.

Sizes are in points; `scale` turns them into what imgui counts in on a dense screen.
"""

from dataclasses import dataclass
from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui

Rgba = tuple[float, float, float, float]

TEXT: Rgba = (0.93, 0.94, 0.95, 1.0)
MUTED: Rgba = (0.93, 0.94, 0.95, 0.58)
FAINT: Rgba = (0.93, 0.94, 0.95, 0.14)
ACCENT: Rgba = (0.96, 0.74, 0.42, 1.0)
ON_ACCENT: Rgba = (0.12, 0.09, 0.05, 1.0)
PANEL: Rgba = (0.055, 0.060, 0.070, 0.80)
SOLID: Rgba = (0.075, 0.080, 0.092, 0.98)
FIELD: Rgba = (1.0, 1.0, 1.0, 0.07)
HOVER: Rgba = (1.0, 1.0, 1.0, 0.12)
PRESSED: Rgba = (1.0, 1.0, 1.0, 0.18)
DONE: Rgba = (0.55, 0.82, 0.62, 1.0)
ERROR: Rgba = (0.98, 0.56, 0.50, 1.0)
SHADE: Rgba = (0.0, 0.0, 0.0, 0.55)

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
    style = imgui.get_style()
    _set_shape(style)
    _set_colors(style)
    style.scale_all_sizes(scale)
    style.font_size_base = BODY_PT
    style.font_scale_dpi = scale
    return Fonts(_load("Roboto-Regular.ttf"), _load("Roboto-Bold.ttf"))


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


def _set_shape(style: imgui.Style) -> None:
    style.window_padding = imgui.ImVec2(14.0, 12.0)
    style.frame_padding = imgui.ImVec2(10.0, 7.0)
    style.item_spacing = imgui.ImVec2(8.0, 7.0)
    style.item_inner_spacing = imgui.ImVec2(7.0, 5.0)
    style.window_rounding = ROUNDING_PT
    style.child_rounding = style.popup_rounding = style.frame_rounding = 7.0
    style.window_border_size = style.popup_border_size = style.frame_border_size = 0.0
    style.child_border_size = 0.0
    style.scrollbar_size, style.scrollbar_rounding = 8.0, 4.0
    style.hover_delay_normal = 0.5
    style.window_min_size = imgui.ImVec2(8.0, 8.0)


def _set_colors(style: imgui.Style) -> None:
    C = imgui.Col_
    clear = (0.0, 0.0, 0.0, 0.0)
    for slot, color in (
        (C.text, TEXT),
        (C.text_disabled, MUTED),
        (C.window_bg, PANEL),
        (C.popup_bg, SOLID),
        (C.child_bg, clear),
        (C.border, FAINT),
        (C.frame_bg, FIELD),
        (C.frame_bg_hovered, HOVER),
        (C.frame_bg_active, HOVER),
        (C.button, FIELD),
        (C.button_hovered, HOVER),
        (C.button_active, PRESSED),
        (C.header, HOVER),
        (C.header_hovered, HOVER),
        (C.header_active, PRESSED),
        (C.separator, FAINT),
        (C.scrollbar_bg, clear),
        (C.scrollbar_grab, HOVER),
        (C.scrollbar_grab_hovered, PRESSED),
        (C.scrollbar_grab_active, PRESSED),
        (C.text_selected_bg, (ACCENT[0], ACCENT[1], ACCENT[2], 0.35)),
        (C.input_text_cursor, ACCENT),
        (C.check_mark, ACCENT),
        (C.modal_window_dim_bg, SHADE),
        (C.nav_cursor, clear),
    ):
        style.set_color_(slot, color)
