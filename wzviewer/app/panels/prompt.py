"""Bottom centre: what should be there, Generate or Cancel, progress by stage, refusal."""

import math
from itertools import pairwise

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.layout import Rect
from wzviewer.app.panels.offers import draw_offers
from wzviewer.app.panels.surface import Ui, colored, elided, face, plate, primary, small, tooltip, wrapped
from wzviewer.app.state import AppState, Job
from wzviewer.app.theme import u32

HINTS = (
    "Add something here, such as “a ladybug”, or leave empty for finer detail",
    "Add something, or leave empty",
)
AUTO_HINTS = ("Add something here, such as “a ladybug”; finer detail comes by itself", "Add something here")
BUTTON_PT = 112.0
LAST_STAGE = 5  # of the paper


def draw_prompt(state: AppState, ui: Ui) -> list[cmd.Command]:
    """Draws the prompt line, and above it what it may become, the progress or the refusal."""
    commands: list[cmd.Command] = []
    rect = ui.layout.prompt
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(7), ui.pt(7)))
    with plate("prompt", rect):
        asked, is_typing = _line(state, ui, rect)
        commands += asked
    imgui.pop_style_var()
    above = Rect(rect.x, rect.y - ui.pt(8), rect.width, 0.0)
    if is_typing and state.offers and not state.refusal:
        asked, height = draw_offers(state, ui, above)
        commands += asked
        above = Rect(above.x, above.y - height - ui.pt(8), above.width, 0.0)
    if state.job is not None:
        _progress(state, ui, state.job, above)
    elif state.refusal:
        with plate("refusal", above, grows="up"):
            wrapped(ui, state.refusal, ui.colors.error, theme.SMALL_PT + 0.5)
    return commands


def _line(state: AppState, ui: Ui, rect: Rect) -> tuple[list[cmd.Command], bool]:
    """The field and its button; returns also whether the cursor is in the field."""
    commands: list[cmd.Command] = []
    button = ui.pt(BUTTON_PT)
    imgui.set_next_item_width(imgui.get_content_region_avail().x - button - ui.pt(7))
    if state.panels.wants_prompt_focus:
        imgui.set_keyboard_focus_here()
        commands.append(cmd.FocusPrompt(False))
    hints = AUTO_HINTS if state.settings.auto_detail else HINTS
    hint = hints[0] if rect.width > ui.pt(560) else hints[1]
    changed, text, steps = _field(state, hint)
    commands += [cmd.ChooseOffer(step) for step in steps]
    if changed and not imgui.is_key_pressed(imgui.Key.escape):  # which would bring back the old text
        commands.append(cmd.EditPrompt(text))
    # A click on an offer takes the cursor out of the field in the same frame.
    is_typing = imgui.is_item_active() or (imgui.is_item_deactivated() and imgui.is_mouse_clicked(0))
    enters = (imgui.Key.enter, imgui.Key.keypad_enter)
    if imgui.is_item_deactivated() and any(imgui.is_key_pressed(key, repeat=False) for key in enters):
        commands.append(cmd.Generate())
    _mark_unknown(state, ui)
    imgui.same_line(0.0, ui.pt(7))
    return commands + _action(state, ui, (button, ui.layout.prompt.height - ui.pt(14))), is_typing


def _field(state: AppState, hint: str) -> tuple[bool, str, list[int]]:
    """The line of text; Tab takes the marked offer, Up and Down mark another (the third result)."""
    F, steps = imgui.InputTextFlags_, list[int]()
    offers, chosen = state.offers, state.offer

    def on_key(data: imgui.InputTextCallbackData) -> int:
        if data.event_flag == F.callback_history.value:
            steps.append(1 if data.event_key == imgui.Key.down_arrow else -1)
        elif data.event_flag == F.callback_completion.value and offers:
            data.delete_chars(0, data.buf_text_len)
            data.insert_chars(0, offers[min(chosen, len(offers) - 1)].prompt)
        elif data.event_activated and not imgui.is_mouse_down(0):  # by a key: behind what is there
            data.cursor_pos = data.selection_start = data.selection_end = data.buf_text_len
        return 0

    flags = F.callback_completion.value | F.callback_history.value | F.callback_always.value
    changed, text = imgui.input_text_with_hint("##prompt", hint, state.prompt, flags, on_key)
    return changed, text, steps


def _mark_unknown(state: AppState, ui: Ui) -> None:
    """A line below every unknown word, as long as all of the text is in view."""
    lower, upper = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    padding = imgui.get_style().frame_padding
    if imgui.calc_text_size(state.prompt).x > upper.x - lower.x - 2 * padding.x:
        return
    y = upper.y - padding.y + ui.pt(2)
    for first, last in state.reading.unknown:
        x = lower.x + padding.x + imgui.calc_text_size(state.prompt[:first]).x
        width = imgui.calc_text_size(state.prompt[first:last]).x
        imgui.get_window_draw_list().add_line((x, y), (x + width, y), u32(ui.colors.error), ui.pt(2))


def _action(state: AppState, ui: Ui, size: tuple[float, float]) -> list[cmd.Command]:
    if state.job is not None or state.is_goal_waiting:
        is_cancelling = state.job is not None and state.job.is_cancelling
        imgui.begin_disabled(is_cancelling)
        pressed = imgui.button("Stopping …" if is_cancelling else f"{icons.ICON_FA_XMARK}  Cancel", size)
        imgui.end_disabled()
        tooltip("Stop making this level   Esc")
        return [cmd.CancelJob()] if pressed else []
    with primary(ui), face(ui.fonts.bold):
        label = "Generate" if len(state.scene) or state.photo is None else "Make 3D"
        pressed = imgui.button(label, size)
    tooltip("New detail where you look   Enter")
    return [cmd.Generate()] if pressed else []


def _progress(state: AppState, ui: Ui, job: Job, above: Rect) -> None:
    """Stage by stage: what runs now, how far, for how long."""
    with plate("progress", above, grows="up"):
        since_s = job.stages[-1].start_s if job.stages else job.started_s
        elapsed = f"{max(state.now_s - job.started_s, 0.0):.1f} s"
        room = imgui.get_content_region_avail().x
        imgui.text_unformatted(elided(_headline(state, job), room - ui.pt(60)))
        imgui.same_line(room - imgui.calc_text_size(elapsed).x + imgui.get_style().window_padding.x)
        with colored(ui.colors.muted):
            imgui.text_unformatted(elapsed)
        draw_bar(ui, job.fraction, state.now_s, is_unknown=job.fraction <= 0.0)
        past = _past(job)
        small(ui, elided(past, room) if past else f"{max(state.now_s - since_s, 0.0):.1f} s in this step")


def _waiting(state: AppState, job: Job) -> str:
    if not state.is_worker_ready:
        return "Starting the worker"
    return "Reading the photo" if job.kind == "photo" else "Looking at the view"


def _headline(state: AppState, job: Job) -> str:
    if job.is_cancelling:
        return "Stopping …"
    if not job.stages:
        return _waiting(state, job)
    stage = job.stages[-1]
    if job.is_auto:
        return f"Auto detail: {stage.name}"
    number = f"{stage.number}/{LAST_STAGE}   " if stage.number else ""
    return f"{number}{stage.name[:1].upper()}{stage.name[1:]}"


def _past(job: Job) -> str:
    """The steps that are done, with their seconds."""
    parts = [f"{a.name} {b.start_s - a.start_s:.1f} s" for a, b in pairwise(job.stages)]
    return " · ".join(parts[-3:])


def draw_bar(ui: Ui, fraction: float, now_s: float, is_unknown: bool) -> None:
    """A thin line; while nothing is known, a light that wanders."""
    at, width, height = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x, ui.pt(4)
    draw = imgui.get_window_draw_list()
    draw.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), u32(ui.colors.hover), height / 2)
    if is_unknown:
        left = (0.5 + 0.5 * math.sin(2.2 * now_s)) * 0.8 * width
        ends = (at.x + left, at.x + left + 0.2 * width)
    else:
        ends = (at.x, at.x + max(min(fraction, 1.0) * width, height))
    draw.add_rect_filled((ends[0], at.y), (ends[1], at.y + height), u32(ui.colors.accent), height / 2)
    imgui.dummy((width, height + ui.pt(2)))
