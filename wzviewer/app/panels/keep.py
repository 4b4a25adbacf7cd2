"""Below the toolbar, on request: picture, command and film of the view; and the film in the making."""

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.keys import label_of
from wzviewer.app.layout import Rect
from wzviewer.app.panels.prompt import draw_bar
from wzviewer.app.panels.surface import Ui, choice, elided, face, plate, small
from wzviewer.app.state import AppState

WIDTH_PT = 300.0
SIZES: tuple[tuple[str, tuple[int, int] | None], ...] = (
    ("Window", None),
    ("1080p", (1920, 1080)),
    ("4K", (3840, 2160)),
    ("Square", (2048, 2048)),
)


def draw_keep(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel."""
    if not state.panels.keep or not len(state.scene):
        return []
    bar = ui.layout.toolbar
    rect = Rect(bar.x, bar.bottom + ui.pt(8), min(ui.pt(WIDTH_PT), bar.width), 0.0)
    commands: list[cmd.Command] = []
    with plate("keep", rect, grows="down", alpha=0.97, is_front=True):
        with face(ui.fonts.bold):
            imgui.text_unformatted("Keep this view")
        commands += _sizes(state, ui)
        is_filming = state.film is not None
        rows: tuple[tuple[str, str, cmd.Command, bool], ...] = (
            (icons.ICON_FA_IMAGE, "Save the picture", cmd.AskPicture(), True),
            (icons.ICON_FA_TERMINAL, "Copy view as command", cmd.CopyView(), True),
            (icons.ICON_FA_FILM, "Film from the photo to here", cmd.AskFilm(), not is_filming),
        )
        imgui.push_style_var(imgui.StyleVar_.button_text_align.value, (0.0, 0.5))
        for icon, name, command, is_possible in rows:
            imgui.begin_disabled(not is_possible)
            key = label_of(type(command), state.settings.keymap)
            if imgui.button(f"{icon}   {name}{'   ' + key if key else ''}", (-1.0, ui.pt(34))):
                commands.append(command)
            imgui.end_disabled()
        imgui.pop_style_var()
    return [*commands, cmd.Toggle("keep")] if _is_done(commands) else commands


def _is_done(commands: list[cmd.Command]) -> bool:
    """Whether something was asked for that the panel need not stay for."""
    return any(not isinstance(c, cmd.SetPictureSize) for c in commands)


def _sizes(state: AppState, ui: Ui) -> list[cmd.Command]:
    index = next((i for i, (_, size) in enumerate(SIZES) if size == state.picture_size), None)
    picked = choice(ui, "size", [(name, i) for i, (name, _) in enumerate(SIZES)], index)
    camera = state.view.camera
    w, h = state.picture_size or (camera.width, camera.height)
    small(ui, f"{w} × {h} px")
    return [] if picked is None else [cmd.SetPictureSize(SIZES[picked][1])]


def draw_film(state: AppState, ui: Ui, rect: Rect) -> tuple[list[cmd.Command], float]:
    """Draws how far the film is; returns what was asked for, and the height, imgui units."""
    film = state.film
    if film is None:
        return [], 0.0
    commands: list[cmd.Command] = []
    with plate("film", Rect(rect.x, rect.y, rect.width, 0.0), grows="down"):
        room = imgui.get_content_region_avail().x
        what = "Stopping" if film.is_cancelling else f"Film {100 * film.fraction:.0f} %"
        button = ui.pt(84)
        imgui.align_text_to_frame_padding()
        text = f"{icons.ICON_FA_FILM}  {what}   {film.path.name}"
        imgui.text_unformatted(elided(text, room - button - ui.pt(8)))
        imgui.same_line(imgui.get_style().window_padding.x + room - button)
        imgui.begin_disabled(film.is_cancelling)
        if imgui.button("Cancel##film", (button, 0.0)):
            commands.append(cmd.CancelFilm())
        imgui.end_disabled()
        draw_bar(ui, film.fraction, state.now_s, is_unknown=film.fraction <= 0.0)
        height = imgui.get_window_height()
    return commands, height + ui.pt(8)
