"""Words that are known, and completion, without a synthesizer."""

import pytest

from wzviewer.core.vocabulary import Reading, Vocabulary, is_one_off, plural_of, read_prompt, starters
from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects import grammar

WORDS = grammar.vocabulary()


def unknown_in(prompt):
    return [prompt[a:b] for a, b in read_prompt(prompt, WORDS).unknown]


def offered(prompt):
    return [offer.prompt for offer in read_prompt(prompt, WORDS).offers]


@pytest.mark.parametrize(
    "prompt",
    [
        "a ladybug", "two blue butterflies", "ladybugs", "a drop of water on the petal", "drops of dew",
        "a tiny red ladybug sitting on a leaf and a beetle", "a golden scarab in the middle",
        "a ladybg", "A Blue Morpho", "the ladybug's leaf", "a ladybug, a pebble & a lego brick",
        "a monarch butterfly near the left edge", "2 stones", "photo.png", "image: a/b c.webp",
    ],
)  # fmt: skip
def test_what_the_grammar_understands_is_never_marked(prompt):
    if not prompt.startswith("image:") and not prompt.endswith("png"):
        grammar.parse(prompt.replace("the ladybug's leaf", "the ladybug"))
    assert unknown_in(prompt + " ") == []


@pytest.mark.parametrize("prompt", ["a dragon ", "a purple qwzx ladybug", "a ladybug on a spaceship "])
def test_what_is_marked_is_refused_by_the_grammar(prompt):
    assert len(unknown_in(prompt)) == 1
    with pytest.raises(PromptError):
        grammar.parse(prompt)


def test_a_word_that_is_still_being_typed_is_not_marked_while_it_may_become_one():
    assert unknown_in("a butterf") == []
    assert unknown_in("a butterf ") == ["butterf"]
    assert unknown_in("a dragon") == ["dragon"]


def test_completion_goes_on_with_the_last_word_or_words():
    assert offered("a lad")[0] == "a ladybug"
    assert "a blue morpho" in offered("a blue m")
    assert "two blue morphos" in offered("two blue m")
    assert "a ladybug on a petal" in offered("a ladybug on a pet")
    assert offered("a ladybug") == []
    assert offered("a ") == []


def test_after_a_count_things_are_offered_in_the_plural():
    assert offered("two blue butterf")[0] == "two blue butterflies"
    assert offered("two blue butterfly") == ["two blue butterflies"]
    assert offered("two blue butterflies") == []
    assert offered("three drops of w")[0] == "three drops of water"
    assert offered("a leaf with two beet")[0] == "a leaf with two beetles"
    assert offered("two ladybugs on a lea")[0] == "two ladybugs on a leaf"
    assert offered("two ladybugs and a beet")[0] == "two ladybugs and a beetle"


@pytest.mark.parametrize("name", WORDS.names)
def test_the_grammar_understands_every_plural_that_is_offered(name):
    plural = plural_of(name, WORDS)
    if not plural:
        assert name.endswith("leaf")  # "beech leaves" are not known
        return
    (one,), (two,) = (grammar.parse(prompt).objects for prompt in (f"a {name}", f"two {plural}"))
    assert unknown_in(f"two {plural} ") == []
    assert two.name == one.name
    assert two.count == 2


def test_an_unknown_word_is_offered_its_nearest():
    assert offered("a buterfli on a leaf")[0] == "a butterfly on a leaf"
    assert len(offered("a dragon")) == 5
    assert offered("a ladybug on a blosmm ")[0] == "a ladybug on a blossom "


def test_an_empty_line_begins_with_every_object():
    assert [offer.prompt for offer in starters(WORDS)][:2] == ["a ladybug", "a beetle"]
    assert starters(Vocabulary()) == ()


def test_without_words_nothing_is_marked():
    assert read_prompt("a dragon", Vocabulary()) == Reading()


def test_words_survive_the_wire_and_what_is_none_does_not():
    assert Vocabulary.from_json(WORDS.to_json()) == WORDS
    assert Vocabulary.from_json({"objects": ["a", 1], "places": 3}) == Vocabulary(objects=("a",))


def test_one_wrong_letter():
    assert is_one_off("beetle", "betle")
    assert is_one_off("beetle", "bettle")
    assert is_one_off("beetle", "beelte")
    assert not is_one_off("beetle", "bottle ")


def test_what_is_wrong_comes_before_what_is_unfinished():
    unknown_first = read_prompt("a dragon, lady", WORDS)
    assert all(offer.prompt.endswith(", lady") for offer in unknown_first.offers)
    assert next(offer.word for offer in read_prompt("a bird, lady", WORDS).offers) == "ladybug"
