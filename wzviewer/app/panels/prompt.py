"""Bottom centre: what should be there, Generate or Cancel, progress by stage, refusal."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from imgui_bundle import icons_fontawesome_6 as icons
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app import theme
from wzviewer.app.generation import is_busy, is_next, makes_room
from wzviewer.app.layout import Rect
from wzviewer.app.panels.actions import CHEVRON_PT, TOOL_PT, draw_more, draw_tools, has_tools
from wzviewer.app.panels.branches import tree_rows
from wzviewer.app.panels.materials import draw_materials
from wzviewer.app.panels.offers import draw_offers
from wzviewer.app.panels.surface import (
    Ui,
    colored,
    elided,
    face,
    plate,
    primary,
    quiet,
    small,
    tooltip,
    wrapped,
)
from wzviewer.app.panels.tree import height_of
from wzviewer.app.panels.variants import draw_variants
from wzviewer.app.panels.waiting import draw_waiting
from wzviewer.app.panels.wording import stage_text
from wzviewer.app.state import AppState, Job
from wzviewer.app.theme import u32
from wzviewer.core.scene import Scene

HINTS = (
    "Add something here, such as “a ladybug”, or leave empty for finer detail",
    "Such as “a ladybug”, or empty for finer detail",
    "Add something, or leave empty",
    "Add something",
)
AUTO_HINTS = (
    "Add something here, such as “a ladybug”; finer detail comes by itself",
    "Add something here, such as “a ladybug”",
    "Add something here",
    "Add something",
)
BUTTON_PT = 100.0
# Heights of what may stand above the line, with the gap below.
OFFERS_PT, REFUSAL_PT, PROGRESS_PT, WAITING_PT, VARIANTS_PT, MATERIALS_PT = (
    46.0,
    60.0,
    84.0,
    46.0,
    76.0,
    240.0,
)
LAST_STAGE = 5  # of the paper
SEPARATOR = " · "
LONG_STEP_S = 8.0  # more than any step needs once everything is compiled


def draw_prompt(state: AppState, ui: Ui) -> tuple[list[cmd.Command], Rect]:
    """Draws the prompt line, and above it what it may become, the progress or the refusal.

    Returns:
        What was asked for, and the place of all that stands above the line; without height for nothing.
    """
    commands: list[cmd.Command] = []
    rect = ui.layout.prompt
    imgui.push_style_var(imgui.StyleVar_.window_padding.value, (ui.pt(7), ui.pt(7)))
    with plate("prompt", rect):
        asked, is_typing = _line(state, ui, rect)
        commands += asked
    imgui.pop_style_var()
    base = _base(state, ui, is_typing)
    above = Rect(base.x, rect.y - ui.pt(8), base.width, 0.0)
    has_offers = is_typing and bool(state.offers) and not (state.refusal or state.panels.materials)
    stack: list[tuple[bool, Callable[[AppState, Ui, Rect], tuple[list[cmd.Command], float]]]] = [
        (has_offers, draw_offers),
        (state.panels.materials, draw_materials),
        (bool(state.refusal), _refusal),
        (state.job is not None, _progress),
        (bool(state.queue.goals), draw_waiting),
        (state.variants is not None and not is_typing, draw_variants),
    ]
    for _, draw in (item for item in stack if item[0]):
        asked, height = draw(state, ui, above)
        commands += asked
        above = Rect(above.x, above.y - (height + ui.pt(8) if height else 0.0), above.width, 0.0)
    return commands, replace(above, height=rect.y - ui.pt(8) - above.y)


def _base(state: AppState, ui: Ui, is_typing: bool) -> Rect:
    """Where the stack above the line stands: beside a tree that reaches down to it."""
    beside, rect = ui.layout.stack, ui.layout.prompt
    if beside == rect or not state.panels.tree:
        return rect
    bottom = ui.layout.tree.y + height_of(ui, len(tree_rows(state.scene)))
    parts = (
        (is_typing, OFFERS_PT),
        (bool(state.refusal), REFUSAL_PT),
        (state.job is not None, PROGRESS_PT),
        (bool(state.queue.goals), WAITING_PT),
        (state.variants is not None, VARIANTS_PT),
        (state.panels.materials, MATERIALS_PT),
    )
    reach = ui.pt(sum(height for is_there, height in parts if is_there))
    return beside if bottom > rect.y - reach else rect


def _refusal(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    with plate("refusal", above, grows="up"):
        wrapped(ui, state.refusal, ui.colors.error, theme.SMALL_PT + 0.5)
        return [], imgui.get_window_height()


def _line(state: AppState, ui: Ui, rect: Rect) -> tuple[list[cmd.Command], bool]:
    """The field and its button; returns also whether the cursor is in the field."""
    commands: list[cmd.Command] = []
    button, height = ui.pt(BUTTON_PT), ui.layout.prompt.height - ui.pt(14)
    tools = ui.pt(2 * TOOL_PT) if has_tools(ui, rect) else 0.0
    beside = button + ui.pt(CHEVRON_PT + 7 + 2) + tools
    imgui.set_next_item_width(imgui.get_content_region_avail().x - beside)
    left = state.panels.prompt_focus
    if left == cmd.FocusPrompt().frames:
        imgui.set_keyboard_focus_here()
    commands += [cmd.FocusPrompt(left - 1)] if left else []
    hints = AUTO_HINTS if state.settings.auto_detail else HINTS
    hint = next((h for h in hints if imgui.calc_text_size(h).x < rect.width - beside - ui.pt(34)), "")
    padding = (imgui.get_style().frame_padding.x, (height - imgui.get_font_size()) / 2)
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, padding)  # as high as the buttons beside it
    changed, text, steps = _field(state, hint)
    imgui.pop_style_var()
    commands += [cmd.ChooseOffer(step) for step in steps]
    if changed and not imgui.is_key_pressed(imgui.Key.escape):  # which would bring back the old text
        commands.append(cmd.EditPrompt(text))
    # A click on an offer takes the cursor out of the field in the same frame.
    is_typing = imgui.is_item_active() or (imgui.is_item_deactivated() and imgui.is_mouse_clicked(0))
    enters = (imgui.Key.enter, imgui.Key.keypad_enter)
    if imgui.is_item_deactivated() and any(imgui.is_key_pressed(key, repeat=False) for key in enters):
        commands.append(cmd.Generate())
    _mark_unknown(state, ui)
    if tools:
        commands += draw_tools(state, ui, height)
    imgui.same_line(0.0, ui.pt(7))
    commands += _action(state, ui, (button, height))
    return commands + draw_more(state, ui, height), is_typing


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
    is_typed = bool(state.prompt.strip())
    if is_busy(state) and is_typed and not makes_room(state):
        pressed = imgui.button(f"{icons.ICON_FA_PLUS}  Queue", size)
        tooltip("Make this next   Enter")
        return [cmd.Generate()] if pressed else []
    if is_busy(state) and not is_typed:
        is_cancelling = state.job is not None and state.job.is_cancelling and not is_next(state)
        imgui.begin_disabled(is_cancelling)
        pressed = imgui.button("Stopping …" if is_cancelling else f"{icons.ICON_FA_XMARK}  Cancel", size)
        imgui.end_disabled()
        tooltip("Stop making this level   Esc")
        return [cmd.CancelJob()] if pressed else []
    with primary(ui), face(ui.fonts.bold):
        is_flat = not len(state.scene) and state.photo is not None
        pressed = imgui.button("Make 3D" if is_flat else "Generate", size)
    tooltip("Make the photo a 3D scene   Enter" if is_flat else "New detail where you look   Enter")
    return [cmd.Generate()] if pressed else []


def _progress(state: AppState, ui: Ui, above: Rect) -> tuple[list[cmd.Command], float]:
    """Stage by stage: what runs now, how far, for how long."""
    job, pressed = state.job, False
    if job is None:
        return [], 0.0
    with plate("progress", above, grows="up"):
        since_s = job.stages[-1].start_s if job.stages else job.started_s
        elapsed = f"{max(state.clock_s - job.started_s, 0.0):.1f} s"
        room = imgui.get_content_region_avail().x
        imgui.text_unformatted(elided(headline(state, job), room - ui.pt(90)))
        left = room + imgui.get_style().window_padding.x
        imgui.same_line(left - imgui.calc_text_size(elapsed).x - ui.pt(26))
        with colored(ui.colors.muted):
            imgui.text_unformatted(elapsed)
            pressed = _cross(ui, left)
        draw_bar(ui, job.fraction, state.now_s, is_unknown=job.fraction <= 0.0)
        line = below_bar(job, state.clock_s - since_s, is_first(state.scene, job))
        with face(ui.fonts.regular, theme.SMALL_PT):
            line = newest(line, room)
        small(ui, line)
        is_over = job.is_cancelling and not is_next(state)
        return [cmd.CancelJob()] if pressed and not is_over else [], imgui.get_window_height()


def _cross(ui: Ui, right: float) -> bool:
    """A small cross in the line, its right edge at ``right``."""
    imgui.same_line(right - ui.pt(20))
    imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.0, 0.0))
    with quiet():
        pressed = imgui.button(f"{icons.ICON_FA_XMARK}##stop", (ui.pt(20), imgui.get_text_line_height()))
    imgui.pop_style_var()
    tooltip("Stop making this level   Esc")
    return pressed


def _waiting(state: AppState, job: Job) -> str:
    if not state.is_worker_ready:
        return "Getting ready"
    return "Reading the photo" if job.kind == "photo" else "Looking at the view"


def headline(state: AppState, job: Job) -> str:
    """What is going on, in a line."""
    if job.is_cancelling and not is_next(state):
        return "Stopping …"
    if job.is_cancelling:  # auto detail: what was asked for waits for it
        what = f"“{state.goal.prompt}”" if state.goal is not None and state.goal.prompt else "New detail"
        return f"{what} comes next"
    if not job.stages:
        return _waiting(state, job)
    stage = job.stages[-1]
    name = stage_text(stage.name)
    if job.is_auto:
        return f"Auto detail: {name}"
    number = f"{stage.number}/{LAST_STAGE}   " if stage.number else ""
    what = f"“{job.prompt}”: {name}" if job.prompt else f"{name[:1].upper()}{name[1:]}"
    return f"{number}{what}"


def below_bar(job: Job, seconds: float, may_compile: bool) -> str:
    """The steps that are done; or how long this one takes, where it is the first, or a long one."""
    return so_far(seconds, may_compile) if seconds > LONG_STEP_S else _past(job) or so_far(seconds)


def newest(line: str, width: float) -> str:
    """Returns as many of the last steps of a line as fit into a width in the current face."""
    while SEPARATOR in line and imgui.calc_text_size(line).x > width:
        line = line.partition(SEPARATOR)[2]
    return elided(line, width)


def so_far(seconds: float, may_compile: bool = True) -> str:
    """How long a step takes; a long one compiles, as it does once on every machine."""
    line, is_long = f"{max(seconds, 0.0):.1f} s in this step", seconds > LONG_STEP_S
    return f"{line}{SEPARATOR}the first time it can take a minute or two" if is_long and may_compile else line


def is_first(scene: Scene, job: Job) -> bool:
    """Whether nothing like it, with words or without, has been finished in this scene yet."""
    made = (level for level in scene if level.index and scene.is_committed(level.index))
    return job.kind == "photo" or not any(bool(level.prompt) == bool(job.prompt) for level in made)


def _past(job: Job) -> str:
    """The steps that are done, with their seconds."""
    parts = [f"{stage_text(a.name)} {b.start_s - a.start_s:.1f} s" for a, b in pairwise(job.stages)]
    return SEPARATOR.join(parts[-3:])


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
