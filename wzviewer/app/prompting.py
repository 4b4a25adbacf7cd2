"""The prompt line: reads what is typed, offers known words, and refuses before the worker is asked."""

from dataclasses import replace

from wzviewer.app import commands as cmd
from wzviewer.app.services import Services
from wzviewer.app.state import AppState
from wzviewer.core.vocabulary import Reading, Vocabulary, read_prompt

SUBSTANCE = "made of "


def edit_prompt(services: Services, state: AppState, command: cmd.EditPrompt) -> AppState:
    """The prompt line holds another text; a refusal belongs to the text before."""
    return with_prompt(state, command.text)


def take_offer(services: Services, state: AppState, command: cmd.TakeOffer) -> AppState:
    """Puts an offered prompt into the line."""
    state = with_prompt(state, command.prompt)
    return replace(state, panels=replace(state.panels, prompt_focus=cmd.FocusPrompt().frames))


def choose_offer(services: Services, state: AppState, command: cmd.ChooseOffer) -> AppState:
    """Marks another offer; after the last one comes the first."""
    count = len(state.offers)
    return replace(state, offer=(state.offer + command.step) % count if count else 0)


def focus_prompt(services: Services, state: AppState, command: cmd.FocusPrompt) -> AppState:
    """Puts the cursor into the prompt line, a frame nearer each time."""
    return replace(state, panels=replace(state.panels, prompt_focus=command.frames))


def add_phrase(services: Services, state: AppState, command: cmd.AddPhrase) -> AppState:
    """Puts a material or the like into the line, or takes it out again."""
    return with_prompt(state, with_phrase(state.prompt, command.phrase))


def with_phrase(prompt: str, phrase: str) -> str:
    """Returns a prompt with a phrase more, or without it where it had it.

    What things are made of follows the first thing at once, and there is one of it; all else comes last.
    """
    parts = [part.strip() for part in prompt.split(",") if part.strip()]
    if not phrase.startswith(SUBSTANCE) or not parts:
        return ", ".join(p for p in parts if p != phrase) if phrase in parts else ", ".join([*parts, phrase])
    thing, _, before = parts[0].partition(f" {SUBSTANCE}")
    parts[0] = thing if f"{SUBSTANCE}{before}" == phrase else f"{thing} {phrase}"
    return ", ".join(parts)


def with_prompt(state: AppState, text: str) -> AppState:
    """Returns the state with another text in the prompt line."""
    reading = read_prompt(text, state.vocabulary)
    return replace(state, prompt=text, refusal="", reading=reading, offer=0)


def with_vocabulary(state: AppState, vocabulary: Vocabulary) -> AppState:
    """Returns the state once the worker has said which words it knows."""
    reading, refusal = read_prompt(state.prompt, vocabulary), state.refusal
    if refusal and refusal == refusal_of(state.prompt, state.reading):  # by words of before
        refusal = refusal_of(state.prompt, reading)
    return replace(state, vocabulary=vocabulary, reading=reading, refusal=refusal, offer=0)


def refusal_of(prompt: str, reading: Reading) -> str:
    """Returns why a prompt cannot be asked for; empty when the worker has to say."""
    if not reading.unknown:
        return ""
    first, last = reading.unknown[0]
    near = ", ".join(offer.word for offer in reading.offers)
    known = f" Known words nearest to it: {near}." if near else ""
    return f"“{prompt[first:last]}” is not known.{known}"
