"""Words -> what to insert and what to change.

``[COUNT] [SIZE] [COLOUR|PATTERN|SUBSTANCE] OBJECT [made of SUBSTANCE] [PREPOSITION PLACE]``, joined by
commas or "and" with others and with changes of the whole picture: ``covered in moss``, ``rusty``, ``wet
with dew``, ``light snow``, ``at sunset``.  A prompt that is not understood is refused at once: a refusal
is better than a wrong object.
"""

import difflib
import re
from dataclasses import dataclass, field
from pathlib import Path

from wzviewer.core.types import FloatArray
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects.traits import Tint, linear
from wzviewer.worker.models.builtin.objects.words import (
    ABOVE,
    ADJECTIVES,
    ALOFT,
    AMOUNTS,
    CHANGES,
    COLORS,
    COUNTS,
    FILLERS,
    FLIERS,
    FLIGHT,
    JOINTS,
    KIN,
    LIGHTS,
    NAMES,
    PATTERNS,
    PLURALS,
    PREPOSITIONS,
    RELATIONS,
    SIZES,
    SUBSTANCES,
    SURFACES,
    USUAL_AMOUNT,
    USUAL_SIZE,
    VERBS,
    WATERS,
    WHERE,
    WITHIN,
    known_words,
)

__all__ = ["COLORS", "Change", "Edit", "Request", "known_words", "parse"]

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
NO_TINT = Tint()
_ARTICLES = {"a", "an", "the", "and"}
_SEPARATORS = {"and", ",", ";", "&", "+"}
_COUNTED = set(COUNTS) - {"the"}
_BRINGERS = {"of", "in", "with", "from", "by", "out"}
_BETWEEN = {*AMOUNTS, "a", "an", "the", "of", "fresh"}
_NOUNS = (
    "gold silver copper bronze brass steel iron wood stone granite marble porcelain glass ice plastic".split()
)
_JOINED = {"sunset": "at", "night": "at"}
_QUALITIES = {**SIZES, **COLORS, **PATTERNS, **SUBSTANCES}


@dataclass(frozen=True)
class Request:
    """One kind of object to insert.

    Attributes:
        name: a key of `nouns.BUILDERS`, or "image".
        count: how many.
        size: share of the view's width.
        tint: colour, pattern and substance words, resolved.
        offset: (x, y) place relative to the centre, in widths and heights.
        path: the image file, if name is "image".
        place: nouns and colours of its place, see `places`.
        relation: "on", "beside" or "under" its place.
        hovers: whether it is in the air above its place.
        submerged: whether it is below the surface of water.
        sized: whether a word says how large it is.
        pixels: (h, w, 4) sRGB and alpha, 0..1, instead of a file; or None.
    """

    name: str
    count: int = 1
    size: float = USUAL_SIZE
    tint: Tint = NO_TINT
    offset: tuple[float, float] = (0.0, 0.0)
    path: str = ""
    place: tuple[str, ...] = ()
    relation: str = "on"
    hovers: bool = False
    submerged: bool = False
    sized: bool = False
    pixels: FloatArray | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Change:
    """A change of the whole picture: a value of `words.CHANGES`, and how much of it, 0..1."""

    name: str
    amount: float = USUAL_AMOUNT


@dataclass(frozen=True)
class Edit:
    """A parsed prompt: objects in the order they are inserted, then changes; none for an empty prompt."""

    prompt: str
    objects: tuple[Request, ...] = ()
    changes: tuple[Change, ...] = ()

    def __bool__(self) -> bool:
        """Tells whether there is anything to do."""
        return bool(self.objects or self.changes)


def vocabulary() -> Vocabulary:
    """Returns the words that `parse` knows, for completion while one types."""
    objects = known_words()["objects"]
    changes = dict.fromkeys(CHANGES.values())
    return Vocabulary(
        objects=objects,
        synonyms=tuple(name for name in (*NAMES, *PLURALS) if name not in objects),
        qualities=tuple(dict.fromkeys((*_QUALITIES, *COUNTS, *CHANGES, *AMOUNTS))),
        places=tuple(dict.fromkeys(("petal", "leaf", "flower", "stem", "stone", *sorted(SURFACES), *WHERE))),
        prepositions=tuple(sorted(PREPOSITIONS)),
        fillers=tuple(sorted({*_ARTICLES, *VERBS, *ADJECTIVES, *FILLERS, *JOINTS})),
        file_suffixes=IMAGE_SUFFIXES,
        coverings=tuple(f"covered in {name}" for name in changes if name not in LIGHTS),
        weathers=tuple(f"{_JOINED.get(name, 'in')} {name}" for name in sorted(LIGHTS)),
        substances=tuple(f"made of {name}" for name in _NOUNS if name in SUBSTANCES),
    )


def parse(prompt: str) -> Edit:
    """Parses a prompt.

    Raises:
        PromptError: for any word or file that is not known; the nearest known words come first.
    """
    text = prompt.strip()
    if not text:
        return Edit(prompt)
    if text.lower().startswith("image:") or text.lower().endswith(IMAGE_SUFFIXES):
        return Edit(prompt, (_image(prompt, text.removeprefix("image:").strip()),))
    words = re.findall(r"[a-z0-9]+|[,;&+]", text.lower().replace("'s", ""))
    requests: list[Request] = []
    changes: list[Change] = []
    for phrase in _phrases(words):
        if _has_object(phrase):
            request, more = _phrase(prompt, phrase)
            requests.append(request)
            changes += more
        else:
            changes += _weather(prompt, phrase)
    if not requests and not changes:
        raise _refusal(prompt, words[:1])
    return Edit(prompt, tuple(requests), tuple({c.name: c for c in changes}.values()))


def _image(prompt: str, path: str) -> Request:
    if not Path(path).expanduser().is_file():
        raise PromptError(
            repr(prompt), "there is no such image file", "Give the path of a PNG, JPEG or WebP file"
        )
    return Request("image", path=str(Path(path).expanduser()))


def _phrases(words: list[str]) -> list[list[str]]:
    """Splits at "and" and commas; what says nothing by itself belongs to the phrase that follows."""
    phrases: list[list[str]] = []
    current: list[str] = []
    for k, word in enumerate([*words, "and"]):
        joins = word in _SEPARATORS or (
            word == "with" and _has_object(current) and _has_object(words[k + 1 :])
        )
        if not joins:
            current.append(word)
        elif _has_object(current) or (_has_change(current) and current[0] not in _COUNTED):
            phrases.append(current)
            current = []
    if current and phrases:
        phrases[-1] += current
    elif current:
        phrases.append(current)
    return phrases


def _has_object(words: list[str]) -> bool:
    rest, brought = _without_coverings(words)
    head, _ = _split_place(rest)
    if brought and words[0] == "the" and all(w in SURFACES or w in _ARTICLES for w in head):
        return False  # what is in the picture already: "the rocks covered in moss"
    return any(_object_at(head, k) for k in range(len(head)))


def _has_change(words: list[str]) -> bool:
    return any(_corrected(w, CHANGES) in CHANGES for w in words)


def _weather(prompt: str, words: list[str]) -> list[Change]:
    """Reads a phrase without an object: what happens to the whole picture."""
    amount = next((AMOUNTS[w] for w in words if w in AMOUNTS), USUAL_AMOUNT)
    found = [CHANGES[_corrected(w, CHANGES)] for w in words if _corrected(w, CHANGES) in CHANGES]
    allowed = {*AMOUNTS, *FILLERS, *JOINTS, *ADJECTIVES, *SURFACES, *_ARTICLES, *VERBS, *PREPOSITIONS}
    unknown = [w for w in words if w not in allowed and _corrected(w, CHANGES) not in CHANGES]
    if unknown or not found:
        raise _refusal(prompt, [w for w in words if w in KIN] or unknown or words)
    if "rain" in found and "dew" in found:  # "wet with dew"
        found.remove("rain")
    return [Change(name, amount) for name in dict.fromkeys(found)]


def _without_coverings(words: list[str]) -> tuple[list[str], list[str]]:
    """Takes out "made of gold", "covered in thick moss": returns (the rest, what they bring)."""
    rest: list[str] = []
    brought: list[str] = []
    k = 0
    while k < len(words):
        joint = words[k] in JOINTS and k + 2 < len(words) and words[k + 1] in _BRINGERS
        end = k + 2
        while joint and end < len(words) - 1 and words[end] in _BETWEEN:
            end += 1
        if joint and (words[end] in SUBSTANCES or words[end] in CHANGES):
            brought += words[k + 2 : end + 1]
            k = end + 1
        else:
            rest.append(words[k])
            k += 1
    return rest, brought


def _phrase(prompt: str, words: list[str]) -> tuple[Request, list[Change]]:
    """Reads one phrase: qualities, the object, what it is made of, the place."""
    words, brought = _without_coverings(words)
    head, place = _split_place(words)
    found = [(k, match) for k in range(len(head)) if (match := _object_at(head, k))]
    start, (name, length, plural) = found[-1] if found[0][1][1] == 1 else found[0]
    qualities = head[:start]
    changes = [w for w in place + head[start + length :] if CHANGES.get(w) in LIGHTS]
    changes += [w for w in brought if w in CHANGES and w not in SUBSTANCES]
    place = [w for w in place if w not in changes]
    unknown = [w for w in qualities + head[start + length :] if not _known(w) and w not in changes]
    allowed = {*SURFACES, *WHERE, *_QUALITIES, *_ARTICLES, *VERBS, *ADJECTIVES}
    unknown += [w for w in place if w not in allowed and _object_at([w], 0) is None]
    if unknown:
        raise _refusal(prompt, unknown)
    counts = [COUNTS[_corrected(w)] for w in qualities if _corrected(w) in COUNTS and w not in {"the"}]
    count = max(counts, default=3 if plural else 1)
    size = next((SIZES[_corrected(w)] for w in qualities if _corrected(w) in SIZES), None)
    count = 3 if plural and count == 1 else count
    _refuse_flight(prompt, name, words)
    said = set(words)
    preposition = next((w for w in words if w in PREPOSITIONS), "on")
    wet = bool(WATERS & set(place)) and preposition in WITHIN
    request = Request(
        name,
        count,
        size or USUAL_SIZE,
        _tint(qualities + brought),
        _offset(place),
        place=tuple(w for w in place if w in SURFACES or w in COLORS),
        relation="on" if wet else RELATIONS.get(preposition, "on"),
        hovers=bool(said & FLIGHT) or preposition in ABOVE or bool(ALOFT & set(place)),
        submerged=wet or "underwater" in said,
        sized=size is not None,
    )
    amount = next((AMOUNTS[w] for w in brought if w in AMOUNTS), USUAL_AMOUNT)
    return request, [Change(CHANGES[w], amount) for w in changes]


def _refuse_flight(prompt: str, name: str, words: list[str]) -> None:
    """What is drawn at rest is not hung into the air with folded wings."""
    flight = next((w for w in words if w in FLIGHT), None)
    if flight and name not in FLIERS:
        raise PromptError(
            repr(prompt),
            f'"{flight}" does not go with a {name}, which is drawn at rest',
            f"Leave the word out, or let one of these fly: a {', a '.join(FLIERS)}",
        )


def _split_place(words: list[str]) -> tuple[list[str], list[str]]:
    """Separates what comes before the first preposition; "drop of water" is one noun."""
    for k, word in enumerate(words):
        if word in PREPOSITIONS:
            return words[:k], [w for w in words[k + 1 :] if w not in PREPOSITIONS]
    return words, []


def _tint(words: list[str]) -> Tint:
    fixed = [_corrected(w) for w in words]
    color = next((COLORS[w] for w in fixed if w in COLORS), None)
    pattern = next((PATTERNS[w] for w in fixed if w in PATTERNS), "")
    substance = next((SUBSTANCES[w] for w in fixed if w in SUBSTANCES), "")
    return Tint(linear(*color) if color else None, pattern, substance)


def _offset(place: list[str]) -> tuple[float, float]:
    steps = [WHERE[w] for w in place if w in WHERE]
    return sum(s[0] for s in steps), sum(s[1] for s in steps)


def _object_at(words: list[str], k: int) -> tuple[str, int, bool] | None:
    """Returns (name, words used, plural) of the longest object name that begins at word k."""
    for length in (3, 2, 1):
        if k + length > len(words):
            continue
        name = " ".join(words[k : k + length])
        forms = _forms(name)
        exact = next(((NAMES[form], length, plural) for form, plural in forms if form in NAMES), None)
        if exact:
            return exact
        if name in CHANGES or name in _QUALITIES or name in COUNTS:
            continue
        for form, plural in forms:
            near = _one_off(form, NAMES) if len(form) >= 5 and length == 1 else None
            if near:
                return NAMES[near], length, plural
    return None


def _forms(name: str) -> list[tuple[str, bool]]:
    """Returns the name as it stands and the singulars it may be the plural of."""
    forms = [(name, False)]
    if name in PLURALS:
        forms.append((PLURALS[name], True))
    if name.endswith("ies"):
        forms.append((name[:-3] + "y", True))
    if name.endswith("s") and not name.endswith("ss"):
        forms.append((name[:-1], True))
    if name.startswith("drops of") or name.startswith("pair of"):
        forms.append((name.replace("drops", "drop"), True))
    return forms


def _known(word: str) -> bool:
    return (
        _corrected(word) in {**COUNTS, **_QUALITIES}
        or word in VERBS
        or word in ADJECTIVES
        or word in _ARTICLES
    )


def _corrected(word: str, table: dict[str, str] | None = None) -> str:
    """Returns the known quality that a word of five letters or more misspells by one letter."""
    known: dict[str, object] = {**COUNTS, **_QUALITIES} if table is None else {**table}
    if word in known or len(word) < 5 or word in AMOUNTS or word in FILLERS:
        return word
    return _one_off(word, known) or word


def _one_off(word: str, table: dict[str, object] | dict[str, str]) -> str | None:
    return next((w for w in table if len(w) >= 5 and _distance_one(word, w)), None)


def _distance_one(a: str, b: str) -> bool:
    """Tells whether one letter inserted, left out, changed, or two swapped make a into b."""
    if abs(len(a) - len(b)) > 1 or a == b:
        return a == b
    k = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    return (
        a[k + 1 :] == b[k + 1 :]
        or a[k + 1 :] == b[k:]
        or a[k:] == b[k + 1 :]
        or (a[k : k + 2] == b[k : k + 2][::-1] and a[k + 2 :] == b[k + 2 :])
    )


def _refusal(prompt: str, unknown: list[str]) -> PromptError:
    """Builds the error: what was not understood, and what is known, the nearest first."""
    vocabulary = [*NAMES, *_QUALITIES, *COUNTS, *CHANGES, *SURFACES, *WHERE]
    near = [w for word in unknown for w in difflib.get_close_matches(word, vocabulary, 3, 0.6)]
    kin = [KIN[form] for word in unknown for form, _ in _forms(word) if form in KIN]
    objects = kin + [NAMES[w] for w in near if w in NAMES] + list(known_words()["objects"])
    objects = list(dict.fromkeys(objects))
    words = list(dict.fromkeys(w for w in near if w not in NAMES))
    meant = f"Did you mean {', '.join(words)}? " if words else ""
    known = ", ".join(f"{'an' if name[0] in 'aeiou' else 'a'} {name}" for name in objects)
    missing = " ".join(dict.fromkeys(unknown)) or prompt.strip()
    changes = ", ".join(dict.fromkeys(CHANGES.values()))
    return PromptError(
        repr(prompt),
        f'"{missing}" is not understood',
        f"{meant}Known: {known}; over all: {changes}; also an image file",
    )
