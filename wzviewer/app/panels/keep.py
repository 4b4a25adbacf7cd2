"""Below the toolbar, on request: picture, command and film of the view; and the film in the making."""

from dataclasses import replace
from typing import Any

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.keeping import size_of
from wzviewer.app.keys import label_of
from wzviewer.app.layout import Rect
from wzviewer.app.panels.prompt import draw_bar
from wzviewer.app.panels.surface import (
    Ui,
    choice,
    face,
    plate,
    primary,
    small,
    switch,
    tooltip,
    wrapped,
)
from wzviewer.app.panels.wording import left_text
from wzviewer.app.shooting import film_line, film_s, film_size, why_no_film
from wzviewer.app.state import AppState

WIDTH_PT = 320.0
SIZES: tuple[tuple[str, tuple[int, int] | None], ...] = (
    ("Window", None),
    ("1080p", (1920, 1080)),
    ("4K", (3840, 2160)),
    ("8K", (7680, 4320)),
)
FILM_SIZES: tuple[tuple[str, tuple[int, int] | None], ...] = (
    ("Window", None),
    ("480p", (854, 480)),
    ("1080p", (1920, 1080)),
    ("4K", (3840, 2160)),
)
TABS = (("Picture", "picture"), ("Film", "film"))
SOURCES = (
    ("Way here", "way", "From the whole photo to this view"),
    ("Orbit", "orbit", "A swing about this view, to both sides"),
    ("Timeline", "keys", "Through the keys of the timeline (L)"),
)
KINDS = (("MP4", ".mp4"), ("GIF", ".gif"))
RATES = {
    ".mp4": (("24", 24.0), ("30", 30.0), ("60", 60.0)),
    ".gif": (("10", 10.0), ("20", 20.0), ("25", 25.0)),
}
ANGLES = tuple((f"{angle:g}°", angle) for angle in (5.0, 8.0, 15.0, 30.0))
LENGTH_S = (0.5, 600.0)


def draw_keep(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the panel."""
    if not state.panels.keep or not len(state.scene):
        return []
    side = ui.layout.side
    rect = replace(side, width=min(ui.pt(WIDTH_PT), side.width))
    with plate("keep", rect, grows="down", alpha=0.97, scrolls=True, is_front=True):
        commands = _chosen(state, ui, "tab", TABS)
        commands += _film_part(state, ui) if state.plan.tab == "film" else _picture_part(state, ui)
    return [*commands, cmd.Toggle("keep")] if _is_done(commands) else commands


def _is_done(commands: list[cmd.Command]) -> bool:
    """Whether something was asked for that the panel need not stay for."""
    return any(not isinstance(c, cmd.SetPictureSize | cmd.SetPlan) for c in commands)


def _picture_part(state: AppState, ui: Ui) -> list[cmd.Command]:
    commands = _sizes(state, ui, SIZES, size_of(state))
    is_changed, is_on = switch(ui, "No background", state.plan.is_transparent)
    tooltip("Where there is nothing, the picture is transparent")
    if is_changed:
        commands.append(_plan(state, is_transparent=is_on))
    commands += _action(ui, icons.ICON_FA_IMAGE, "Save the picture", cmd.AskPicture(), is_first=True)
    return commands + _action(ui, icons.ICON_FA_TERMINAL, "Copy view as command", cmd.CopyView())


def _film_part(state: AppState, ui: Ui) -> list[cmd.Command]:
    plan = state.plan
    commands = _chosen(state, ui, "source", tuple(s[:2] for s in SOURCES))
    small(ui, next(about for _, source, about in SOURCES if source == plan.source))
    if plan.source == "orbit":
        commands += _chosen(state, ui, "orbit_deg", ANGLES)
    commands += _sizes(state, ui, FILM_SIZES, film_size(state))
    small(ui, "Kind, and frames per second")
    commands += _kind_and_rate(state, ui) + _length(state, ui)
    reason = why_no_film(state)
    if reason:
        wrapped(ui, reason[:1].upper() + reason[1:].rstrip(".") + ".", ui.colors.error, 13.5)
    else:
        small(ui, film_line(state))
    is_possible = not reason and state.film is None
    commands += _action(ui, icons.ICON_FA_FILM, "Save the film", cmd.AskFilm(), is_possible, True)
    if plan.source == "keys" and not state.panels.timeline:
        commands += _action(ui, icons.ICON_FA_ROUTE, "Show the timeline   L", cmd.Toggle("timeline"))
    return commands


def _kind_and_rate(state: AppState, ui: Ui) -> list[cmd.Command]:
    room, gap = imgui.get_content_region_avail().x, ui.pt(14)
    commands = _chosen(state, ui, "suffix", KINDS, 0.4 * room)
    imgui.same_line(0.0, gap)
    return commands + _chosen(state, ui, "fps", RATES[state.plan.suffix], 0.6 * room - gap)


def _length(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Seconds: dragged or typed; a button goes back to what suits the path."""
    imgui.align_text_to_frame_padding()
    small(ui, "Length")
    imgui.same_line(ui.pt(84))
    imgui.set_next_item_width(ui.pt(96))
    present = max(film_s(state), LENGTH_S[0])
    is_changed, seconds = imgui.drag_float("##length", present, 0.05, *LENGTH_S, "%.1f s")
    tooltip("Drag, or double click and type")
    if is_changed:
        return [_plan(state, seconds=min(max(seconds, LENGTH_S[0]), LENGTH_S[1]))]
    if state.plan.seconds is None:
        return []
    imgui.same_line()
    is_pressed = imgui.button(f"{icons.ICON_FA_ARROW_ROTATE_LEFT}##natural length")
    tooltip("As long as suits it")
    return [_plan(state, seconds=None)] if is_pressed else []


def _sizes(state: AppState, ui: Ui, sizes: tuple[Any, ...], size: tuple[int, int]) -> list[cmd.Command]:
    """Buttons for the usual sizes, and a line to type another."""
    options = [(name, i) for i, (name, _) in enumerate(sizes)]
    is_typed = bool(state.plan.size_text.strip())
    index = next((i for i, (_, s) in enumerate(sizes) if s == state.picture_size and not is_typed), None)
    picked = choice(ui, "size", options, index)
    imgui.set_next_item_width(-1.0)
    hint = f"{size[0]} × {size[1]}"
    is_changed, text = imgui.input_text_with_hint("##typed size", hint, state.plan.size_text)
    tooltip("Type another size, as 1600x900")
    if state.plan.size_fault:
        small(ui, state.plan.size_fault, ui.colors.error)
    if picked is not None:
        return [cmd.SetPictureSize(sizes[picked][1])]
    return [_plan(state, size_text=text)] if is_changed else []


def _chosen(
    state: AppState, ui: Ui, key: str, options: tuple[tuple[Any, ...], ...], room: float | None = None
) -> list[cmd.Command]:
    """A row of buttons for a field of the plan."""
    picked = choice(ui, key, options, getattr(state.plan, key), room)
    return [] if picked is None else [_plan(state, **{key: picked})]


def _plan(state: AppState, **changes: Any) -> cmd.SetPlan:  # noqa: ANN401 - fields of the plan
    return cmd.SetPlan(replace(state.plan, **changes))


def _action(
    ui: Ui, icon: str, name: str, command: cmd.Command, is_possible: bool = True, is_first: bool = False
) -> list[cmd.Command]:
    """A wide button; the first one is the primary."""
    key = label_of(type(command))
    text = f"{icon}   {name}{'   ' + key if key else ''}"
    imgui.begin_disabled(not is_possible)
    if is_first:
        with primary(ui), face(ui.fonts.bold):
            is_pressed = imgui.button(text, (-1.0, ui.pt(36)))
    else:
        is_pressed = imgui.button(text, (-1.0, ui.pt(34)))
    imgui.end_disabled()
    return [command] if is_pressed else []


def draw_film(state: AppState, ui: Ui, rect: Rect, is_front: bool = False) -> tuple[list[cmd.Command], float]:
    """Draws how far the film is, in front to be read only; returns what was asked for, and the height."""
    film = state.film
    if film is None:
        return [], 0.0
    commands: list[cmd.Command] = []
    flags = imgui.WindowFlags_.no_inputs.value if is_front else 0
    with plate("film", Rect(rect.x, rect.y, rect.width, 0.0), flags, grows="down", is_front=is_front):
        room = imgui.get_content_region_avail().x
        share = "" if film.is_picture else f" {100 * film.fraction:.0f} %"
        left = left_text(state.clock_s - film.started_s, film.fraction)
        share += f", {left}" if left else ""
        what = "Stopping" if film.is_cancelling else f"{film.kind.capitalize()}{share}"
        button = ui.pt(72)
        imgui.align_text_to_frame_padding()
        icon = icons.ICON_FA_IMAGE if film.is_picture else icons.ICON_FA_FILM
        text, name = f"{icon}  {what}", f"  {film.path.name}"
        has_room = imgui.calc_text_size(text + name).x <= room - button - ui.pt(4)
        imgui.text_unformatted(text + name if has_room else text)
        tooltip(str(film.path))
        imgui.same_line(imgui.get_style().window_padding.x + room - button)
        imgui.begin_disabled(film.is_cancelling)
        if imgui.button("Cancel##film", (button, 0.0)):
            commands.append(cmd.CancelFilm())
        imgui.end_disabled()
        draw_bar(ui, film.fraction, state.now_s, is_unknown=film.fraction <= 0.0)
        height = imgui.get_window_height()
    return commands, height + ui.pt(8)
