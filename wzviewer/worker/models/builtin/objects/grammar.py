"""Words -> what to insert: ``[COUNT] [SIZE] [COLOUR|PATTERN|SUBSTANCE] OBJECT [PREPOSITION PLACE]``.

A prompt that is not understood is refused at once: a refusal is better than a wrong object.
"""

import difflib
import re
from dataclasses import dataclass
from pathlib import Path

from wzviewer.core.vocabulary import Vocabulary
from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects import butterflies, insects, things
from wzviewer.worker.models.builtin.objects.bodies import Builder, Tint, linear

BUILDERS: dict[str, Builder] = {
    "ladybug": insects.ladybug,
    "butterfly": butterflies.butterfly,
    "blue morpho": butterflies.morpho,
    "cabbage white": butterflies.cabbage_white,
    "beetle": insects.beetle,
    "water drop": things.drop,
    "lego brick": things.brick,
    "pebble": things.pebble,
}
NAMES = {
    **{name: name for name in BUILDERS},
    **dict.fromkeys(
        ("lady bug", "ladybird", "lady bird", "ladybird beetle", "ladybug beetle", "ladybeetle"), "ladybug"
    ),
    **dict.fromkeys(("monarch", "monarch butterfly"), "butterfly"),
    **dict.fromkeys(("morpho", "morpho butterfly", "blue morpho butterfly"), "blue morpho"),
    **dict.fromkeys(("cabbage butterfly", "cabbage white butterfly"), "cabbage white"),
    **dict.fromkeys(("bug", "ground beetle", "scarab", "insect", "carabid"), "beetle"),
    **dict.fromkeys(
        ("drop", "droplet", "dewdrop", "dew drop", "raindrop", "rain drop", "waterdrop", "water droplet"),
        "water drop",
    ),
    **dict.fromkeys(("drop of water", "drop of dew", "dew"), "water drop"),
    **dict.fromkeys(("brick", "lego", "toy brick", "building brick"), "lego brick"),
    **dict.fromkeys(("stone", "rock"), "pebble"),
}
COUNTS = {
    **dict.fromkeys(("a", "an", "the", "one", "single", "1"), 1),
    **{
        "two": 2,
        "pair": 2,
        "2": 2,
        "three": 3,
        "3": 3,
        "few": 4,
        "four": 4,
        "4": 4,
        "five": 5,
        "5": 5,
        "some": 4,
    },
    **{"several": 6, "six": 6, "6": 6, "seven": 7, "7": 7, "eight": 8, "8": 8, "many": 9, "nine": 9, "9": 9},
}
SIZES = {
    **dict.fromkeys(("tiny", "minute", "miniature"), 0.12),
    **dict.fromkeys(("small", "little"), 0.22),
    **dict.fromkeys(("big", "large"), 0.6),
    **dict.fromkeys(("huge", "giant", "enormous"), 0.8),
}
COLORS = {
    "red": (200, 18, 12),
    "crimson": (150, 12, 30),
    "orange": (235, 110, 14),
    "yellow": (236, 190, 18),
    "green": (52, 128, 38),
    "blue": (28, 78, 196),
    "cyan": (30, 168, 190),
    "turquoise": (30, 168, 160),
    "purple": (108, 44, 150),
    "violet": (112, 58, 180),
    "pink": (232, 120, 160),
    "white": (232, 228, 216),
    "black": (38, 35, 34),
    "grey": (128, 126, 122),
    "gray": (128, 126, 122),
    "brown": (112, 66, 36),
    "golden": (226, 160, 40),
    "gold": (226, 160, 40),
    "silver": (190, 192, 196),
    "copper": (190, 100, 56),
}
PATTERNS = {"spotted": "spotted", "dotted": "spotted", "plain": "plain", "spotless": "plain"}
SUBSTANCES = dict.fromkeys(("metal", "metallic", "golden", "gold", "silver", "copper", "shiny"), "metal")
PREPOSITIONS = {
    "on",
    "onto",
    "in",
    "at",
    "near",
    "by",
    "upon",
    "over",
    "above",
    "beside",
    "inside",
    "to",
    "along",
    "under",
    "from",
}
VERBS = {
    "sitting",
    "sits",
    "resting",
    "crawling",
    "perched",
    "standing",
    "lying",
    "walking",
    "landing",
    "there",
    "is",
    "with",
    "of",
}
WHERE = {
    "left": (-0.24, 0.0),
    "right": (0.24, 0.0),
    "top": (0.0, -0.22),
    "upper": (0.0, -0.22),
    "bottom": (0.0, 0.22),
    "lower": (0.0, 0.22),
    "centre": (0.0, 0.0),
    "center": (0.0, 0.0),
    "middle": (0.0, 0.0),
}
SURFACES = frozenset(
    """petal petals leaf leaves flower flowers blossom bloom stem stalk branch twig bark trunk tree bush
    plant grass moss meadow field ground soil earth sand beach rock rocks stone stones boulder cliff
    mountain hill slope snow ice water lake pond river sea wave puddle wall roof house building window
    door floor table chair sofa couch carpet rug pillow cushion cloth fabric wood plank board bench
    shelf street road path pavement cobblestones cobblestone bridge car bicycle wheel metal glass paper
    book hand finger skin fur feather fruit apple mushroom sunflower rose disc disk seed seeds side
    corner edge surface picture image view scene foreground background photo here it sky cloud clouds
    village tower statue painting canvas frame lamp screen fence gate step steps stair stairs staircase
    tile tiles brickwork pot vase basket bed desk""".split()
)
IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
DEFAULT_SIZE = 0.40
NO_TINT = Tint()
_ARTICLES = {"a", "an", "the", "and"}
_QUALITIES = {**SIZES, **COLORS, **PATTERNS, **SUBSTANCES}


@dataclass(frozen=True)
class Request:
    """One kind of object to insert.

    Attributes:
        name: a key of `BUILDERS`, or "image".
        count: how many.
        size: share of the view's width.
        tint: colour, pattern and substance words, resolved.
        offset: (x, y) place relative to the centre, in widths and heights.
        path: the image file, if name is "image".
    """

    name: str
    count: int = 1
    size: float = DEFAULT_SIZE
    tint: Tint = NO_TINT
    offset: tuple[float, float] = (0.0, 0.0)
    path: str = ""


@dataclass(frozen=True)
class Edit:
    """A parsed prompt: objects in the order they are inserted; none for an empty prompt."""

    prompt: str
    objects: tuple[Request, ...] = ()


def vocabulary() -> Vocabulary:
    """Returns the words that `parse` knows, for completion while one types."""
    return Vocabulary(
        objects=tuple(BUILDERS),
        synonyms=tuple(name for name in NAMES if name not in BUILDERS),
        qualities=tuple(dict.fromkeys((*_QUALITIES, *COUNTS))),
        places=tuple(dict.fromkeys(("petal", "leaf", "flower", "stem", "stone", *sorted(SURFACES), *WHERE))),
        prepositions=tuple(sorted(PREPOSITIONS)),
        fillers=tuple(sorted(_ARTICLES | VERBS)),
        file_suffixes=IMAGE_SUFFIXES,
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
    requests = [_phrase(prompt, phrase) for phrase in _phrases(words)]
    if not requests:
        raise _refusal(prompt, words[:1])
    return Edit(prompt, tuple(requests))


def _image(prompt: str, path: str) -> Request:
    if not Path(path).expanduser().is_file():
        raise PromptError(
            repr(prompt), "there is no such image file", "Give the path of a PNG, JPEG or WebP file"
        )
    return Request("image", path=str(Path(path).expanduser()))


def _phrases(words: list[str]) -> list[list[str]]:
    """Splits at "and" and commas; what names no object belongs to the phrase that follows."""
    phrases: list[list[str]] = []
    current: list[str] = []
    for word in [*words, "and"]:
        if word not in {"and", ",", ";", "&", "+"}:
            current.append(word)
        elif any(_object_at(current, k) for k in range(len(current))):
            phrases.append(current)
            current = []
    if current and phrases:
        phrases[-1] += current
    elif current:
        phrases.append(current)
    return phrases


def _phrase(prompt: str, words: list[str]) -> Request:
    """Reads one phrase: qualities, the object, the place."""
    head, place = _split_place(words)
    found = [(k, match) for k in range(len(head)) if (match := _object_at(head, k))]
    if not found:
        raise _refusal(prompt, [w for w in head if not _known(w)] or head)
    start, (name, length, plural) = found[-1] if found[0][1][1] == 1 else found[0]
    qualities = head[:start]
    unknown = [w for w in qualities + head[start + length :] if not _known(w)]
    unknown += [
        w
        for w in place
        if w not in SURFACES and w not in WHERE and w not in _QUALITIES and w not in _ARTICLES | VERBS
    ]
    if unknown:
        raise _refusal(prompt, unknown)
    counts = [COUNTS[_corrected(w)] for w in qualities if _corrected(w) in COUNTS and w not in {"the"}]
    count = max(counts, default=3 if plural else 1)
    size = next((SIZES[_corrected(w)] for w in qualities if _corrected(w) in SIZES), DEFAULT_SIZE)
    return Request(name, 3 if plural and count == 1 else count, size, _tint(qualities), _offset(place))


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
        for form, plural in forms:
            near = _one_off(form, NAMES) if len(form) >= 5 and length == 1 else None
            if near:
                return NAMES[near], length, plural
    return None


def _forms(name: str) -> list[tuple[str, bool]]:
    """Returns the name as it stands and the singulars it may be the plural of."""
    forms = [(name, False)]
    if name.endswith("ies"):
        forms.append((name[:-3] + "y", True))
    if name.endswith("s") and not name.endswith("ss"):
        forms.append((name[:-1], True))
    if name.startswith("drops of") or name.startswith("pair of"):
        forms.append((name.replace("drops", "drop"), True))
    return forms


def _known(word: str) -> bool:
    return _corrected(word) in {**COUNTS, **_QUALITIES} or word in VERBS or word in _ARTICLES


def _corrected(word: str) -> str:
    """Returns the known quality that a word of five letters or more misspells by one letter."""
    table = {**COUNTS, **_QUALITIES}
    if word in table or len(word) < 5:
        return word
    return _one_off(word, table) or word


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
    vocabulary = [*NAMES, *_QUALITIES, *COUNTS, *SURFACES, *WHERE]
    near = [w for word in unknown for w in difflib.get_close_matches(word, vocabulary, 3, 0.6)]
    objects = list(dict.fromkeys([NAMES[w] for w in near if w in NAMES] + list(BUILDERS)))
    words = list(dict.fromkeys(w for w in near if w not in NAMES))
    meant = f"Did you mean {', '.join(words)}? " if words else ""
    known = ", ".join(f"a {name}" for name in objects)
    missing = " ".join(dict.fromkeys(unknown)) or prompt.strip()
    return PromptError(
        repr(prompt), f'"{missing}" is not understood', f"{meant}Known: {known}; also an image file"
    )
