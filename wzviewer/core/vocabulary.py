"""The words that a synthesizer understands, as it tells the app: for completion while one types.

The exact grammar lives with the synthesizer, which has the last word.  What is marked here is refused
there as well; what is not marked may still be.
"""

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass

TOKEN = re.compile(r"[a-z0-9]+")
JOINS = frozenset({"and", "s"})
LONG_WORD = 5  # letters; from there on one wrong letter is understood
NEAREST_CUTOFF = 0.6  # of difflib's similarity, as in the synthesizer's own refusals
MAX_OFFERS = 5
NAME_WORDS = 3  # of the longest name
SEVERAL = frozenset("two three four five six seven eight nine few some several many pair".split()) | set(
    "23456789"
)
ENDINGS = (("f", "ves"), ("us", "i"), ("y", "ies"), ("", "es"), ("", "s"))  # of singular and plural
UNCHANGED = ("fish", "trout", "salmon", "carp", "koi", "perch")  # endings of names that are their own plural


@dataclass(frozen=True)
class Vocabulary:
    """The known words; empty while nothing is known, and then nothing is marked.

    Attributes:
        objects: what can be made, each by one name.
        synonyms: further names of those.
        qualities: sizes, colours, substances and counts.
        places: where on the picture, or on what.
        prepositions: after one of them follows a place.
        fillers: words without a meaning of their own, such as articles.
        file_suffixes: of pictures that may be named instead.
        coverings: phrases that cover what is there, such as "covered in moss".
        weathers: phrases of weather and light, such as "in fog".
        substances: phrases that follow an object, such as "made of gold".
    """

    objects: tuple[str, ...] = ()
    synonyms: tuple[str, ...] = ()
    qualities: tuple[str, ...] = ()
    places: tuple[str, ...] = ()
    prepositions: tuple[str, ...] = ()
    fillers: tuple[str, ...] = ()
    file_suffixes: tuple[str, ...] = ()
    coverings: tuple[str, ...] = ()
    weathers: tuple[str, ...] = ()
    substances: tuple[str, ...] = ()

    def to_json(self) -> dict[str, list[str]]:
        """Returns lists of words by name."""
        return {name: list(words) for name, words in vars(self).items()}

    @classmethod
    def from_json(cls, record: Mapping[str, object]) -> "Vocabulary":
        """Restores a vocabulary; lists that are missing are empty, what is no word is left out."""
        found: dict[str, tuple[str, ...]] = {}
        for name in cls.__dataclass_fields__:
            words = record.get(name)
            found[name] = tuple(w for w in words if isinstance(w, str)) if isinstance(words, list) else ()
        return cls(**found)

    @property
    def names(self) -> tuple[str, ...]:
        """All names of objects."""
        return self.objects + self.synonyms


@dataclass(frozen=True)
class Offer:
    """A prompt that is one key away.

    Attributes:
        word: what is offered.
        prompt: the whole line with it.
    """

    word: str
    prompt: str


@dataclass(frozen=True)
class Reading:
    """How a prompt is understood so far.

    Attributes:
        unknown: (first, last + 1) character of every word that is not known.
        offers: completions of the last word, or known words for the first unknown one.
        has_object: whether something is named that can be made.
    """

    unknown: tuple[tuple[int, int], ...] = ()
    offers: tuple[Offer, ...] = ()
    has_object: bool = False


def read_prompt(prompt: str, vocabulary: Vocabulary) -> Reading:
    """Marks the words of a prompt that are not known, and offers known ones."""
    if not vocabulary.objects or _names_file(prompt, vocabulary):
        return Reading()
    text = prompt.lower()
    spans = [m.span() for m in TOKEN.finditer(text)]
    words = [text[a:b] for a, b in spans]
    in_names = _words_of_names(words, vocabulary)
    others = _other_words(vocabulary)
    unknown = [
        span
        for k, (span, word) in enumerate(zip(spans, words, strict=True))
        if k not in in_names and not _is_known(word, others)
    ]
    is_typing = bool(spans) and spans[-1][1] == len(prompt)
    offers = _completions(prompt, spans, vocabulary) if is_typing else ()
    if is_typing and unknown and unknown[-1] == spans[-1] and _begins_a_word(words[-1], vocabulary):
        unknown.pop()  # it may still become one
    if unknown and (not offers or unknown[0] != spans[-1]):  # what is wrong comes before what is unfinished
        offers = _nearest(prompt, unknown[0], vocabulary)
    return Reading(tuple(unknown), offers, bool(in_names))


def starters(vocabulary: Vocabulary) -> tuple[Offer, ...]:
    """Returns what an empty line may begin with."""
    phrases = [f"{_article(name)} {name}" for name in vocabulary.objects]
    return tuple(Offer(phrase, phrase) for phrase in phrases)


def _article(name: str) -> str:
    return "an" if name[0] in "aeiou" else "a"


def _names_file(prompt: str, vocabulary: Vocabulary) -> bool:
    text = prompt.strip().lower()
    return text.startswith("image:") or bool(
        vocabulary.file_suffixes and text.endswith(vocabulary.file_suffixes)
    )


def _other_words(vocabulary: Vocabulary) -> frozenset[str]:
    groups = (vocabulary.qualities, vocabulary.places, vocabulary.prepositions, vocabulary.fillers)
    return frozenset(word for group in groups for word in group) | JOINS


def _words_of_names(words: list[str], vocabulary: Vocabulary) -> set[int]:
    """Places of the words that belong to a name of an object, in singular or plural."""
    names = frozenset(vocabulary.names)
    found: set[int] = set()
    for k in range(len(words)):
        for length in range(min(NAME_WORDS, len(words) - k), 0, -1):
            forms = _forms(" ".join(words[k : k + length]))
            if names.intersection(forms) or (length == 1 and any(_is_near(form, names) for form in forms)):
                found |= set(range(k, k + length))
                break
    return found


def _forms(name: str) -> list[str]:
    """The name as it stands and the singulars it may be the plural of."""
    forms = [name]
    if name.endswith("ies"):
        forms.append(name[:-3] + "y")
    if name.endswith("s"):
        forms.append(name[:-1])
    if name.startswith("drops of"):
        forms.append(name.replace("drops", "drop"))
    return forms


def _is_known(word: str, others: frozenset[str]) -> bool:
    return word in others or _is_near(word, others)


def _is_near(word: str, known: frozenset[str]) -> bool:
    return len(word) >= LONG_WORD and any(len(w) >= LONG_WORD and is_one_off(word, w) for w in known)


def is_one_off(a: str, b: str) -> bool:
    """Whether one letter inserted, left out, changed, or two swapped make a into b."""
    if abs(len(a) - len(b)) > 1 or a == b:
        return a == b
    k = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    swapped = a[k : k + 2] == b[k : k + 2][::-1] and a[k + 2 :] == b[k + 2 :]
    return swapped or a[k + 1 :] == b[k + 1 :] or a[k + 1 :] == b[k:] or a[k:] == b[k + 1 :]


def _begins_a_word(part: str, vocabulary: Vocabulary) -> bool:
    words = {w for phrase in (*vocabulary.names, *_other_words(vocabulary)) for w in phrase.split()}
    return any(w.startswith(part) for w in words)


def _completions(prompt: str, spans: list[tuple[int, int]], vocabulary: Vocabulary) -> tuple[Offer, ...]:
    """What the last words may become: names first, by as many words as they may already have."""
    offers: dict[str, Offer] = {}
    for length in range(min(NAME_WORDS, len(spans)), 0, -1):
        start = spans[-length][0]
        part = prompt[start:].lower()
        if length == 1 and len(part) < 2 and part in vocabulary.fillers:
            continue  # "a" is an article, not the beginning of "above"
        possible = _possible(prompt[:start], vocabulary)
        if part in vocabulary.names:  # it is one already, unless it should be the plural
            plural = plural_of(part, vocabulary)
            is_short = part not in possible and plural in possible
            return (Offer(plural, prompt[:start] + plural),) if is_short else ()
        for word in possible:
            if word.startswith(part) and word != part:
                offers.setdefault(word, Offer(word, prompt[:start] + word))
    return tuple(offers.values())[:MAX_OFFERS]


def _possible(before: str, vocabulary: Vocabulary) -> tuple[str, ...]:
    """The words that may stand behind the beginning of a prompt, the likeliest first."""
    phrase = re.split(r"[,;&+]|\band\b", before.lower())[-1]
    if set(TOKEN.findall(phrase)) & set(vocabulary.prepositions):
        return (*vocabulary.places, *vocabulary.qualities)
    objects, synonyms = vocabulary.objects, vocabulary.synonyms
    if SEVERAL & set(TOKEN.findall(phrase)):
        objects, synonyms = (_plurals(names, vocabulary) for names in (objects, synonyms))
    return (*objects, *vocabulary.qualities, *synonyms, *vocabulary.prepositions)


def _plurals(names: tuple[str, ...], vocabulary: Vocabulary) -> tuple[str, ...]:
    """Plurals of names, each once; a name whose plural would not be understood is left out."""
    found = (plural_of(name, vocabulary) for name in names)
    return tuple(dict.fromkeys(plural for plural in found if plural))


def plural_of(name: str, vocabulary: Vocabulary) -> str:
    """Returns the plural of a name as a synthesizer understands it, or nothing where it knows none."""
    known = frozenset(vocabulary.names)
    first, of, rest = name.partition(" of ")
    if of:
        return f"{first}s{of}{rest}"
    if name.endswith(UNCHANGED) or any(other in known for other in _with_ending(name, 1, 0)):
        return name  # or it is one already
    irregular = next((other for other in _with_ending(name, 0, 1) if other in known), "")
    if irregular or name.endswith("f"):
        return irregular
    if name.endswith("y") and name[-2] not in "aeiou":
        return f"{name[:-1]}ies"
    return f"{name}es" if name.endswith(("ch", "sh", "x", "z")) else f"{name}s"


def _with_ending(name: str, old: int, new: int) -> list[str]:
    """The name with another of the pairs of `ENDINGS` that it has; 0 is the singular's."""
    pairs = (pair for pair in ENDINGS if name.endswith(pair[old]))
    return [name[: len(name) - len(pair[old])] + pair[new] for pair in pairs]


def _nearest(prompt: str, span: tuple[int, int], vocabulary: Vocabulary) -> tuple[Offer, ...]:
    """Known words in place of an unknown one."""
    known = _possible(prompt[: span[0]], vocabulary)
    word = prompt[span[0] : span[1]].lower()
    near = difflib.get_close_matches(word, known, MAX_OFFERS, NEAREST_CUTOFF)
    words = list(dict.fromkeys([*near, *known]))[:MAX_OFFERS]
    return tuple(Offer(w, prompt[: span[0]] + w + prompt[span[1] :]) for w in words)
