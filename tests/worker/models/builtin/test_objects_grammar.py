"""Prompts: what is understood, what is refused, and what the refusal says."""

import pytest

from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects.bodies import linear
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS
from wzviewer.worker.models.builtin.objects.words import (
    CHANGES,
    COLORS,
    COUNTS,
    NAMES,
    SIZES,
    SUBSTANCES,
    known_words,
)

parse = ObjectEditor.parse


@pytest.mark.parametrize(
    ("prompt", "name", "count", "size"),
    [
        ("a ladybug on the petal", "ladybug", 1, 0.4),
        ("Ladybird", "ladybug", 1, 0.4),
        ("two tiny lady bugs", "ladybug", 2, 0.12),
        ("ladybugs", "ladybug", 3, 0.4),
        ("a ladybgu", "ladybug", 1, 0.4),
        ("a large butterfly sitting at the top left", "butterfly", 1, 0.6),
        ("a few butterflies", "butterfly", 4, 0.4),
        ("the small red beetle", "beetle", 1, 0.22),
        ("a samll beetle", "beetle", 1, 0.22),
        ("a drop of water on a leaf", "water drop", 1, 0.4),
        ("many water drops", "water drop", 9, 0.4),
        ("a huge yellow lego brick in the centre", "lego brick", 1, 0.8),
        ("a stone on the stone", "pebble", 1, 0.4),
        ("a monarch butterfly", "butterfly", 1, 0.4),
        ("a blue morpho", "blue morpho", 1, 0.4),
        ("a robin on the branch", "bird", 1, 0.4),
        ("three small goldfish", "goldfish", 3, 0.22),
        ("a seashell on the beach", "conch shell", 1, 0.4),
        ("autumn leaves", "maple leaf", 3, 0.4),
        ("a leaf in the snow", "leaf", 1, 0.4),
        ("a wooden cat", "cat", 1, 0.4),
        ("a crystal bird", "bird", 1, 0.4),
        ("two daisies", "flower", 2, 0.4),
        ("a kitten made of gold", "cat", 1, 0.4),
        ("a rusty old key", "key", 1, 0.4),
        ("a beautiful butterfly flying over the meadow", "butterfly", 1, 0.4),
    ],
)
def test_understands(prompt, name, count, size):
    (request,) = parse(prompt).objects
    assert (request.name, request.count, request.size) == (name, count, size)


def test_two_objects_keep_their_own_words():
    first, second = parse("a big green beetle and a small butterfly on the left").objects
    assert (first.name, first.size, first.offset) == ("beetle", 0.6, (0.0, 0.0))
    assert (second.name, second.size) == ("butterfly", 0.22)
    assert first.tint.color == linear(*COLORS["green"])
    assert second.tint.color is None
    assert second.offset[0] < 0


def test_with_joins_two_objects():
    names = [request.name for request in parse("a small sparrow with a golden key").objects]
    assert names == ["sparrow", "key"]
    assert parse("a stone covered with moss").objects[0].tint.substance == "moss"


def test_colour_words_joined_by_and_belong_to_one_object():
    (request,) = parse("a red and black ladybug").objects
    assert request.tint.color == linear(*COLORS["red"])


def test_substance_and_pattern_words():
    assert parse("a golden beetle").objects[0].tint.substance == "metal"
    assert parse("a plain ladybug").objects[0].tint.pattern == "plain"


@pytest.mark.parametrize("name", sorted(NAMES))
def test_every_name_and_its_plural_mean_their_object(name):
    (one,) = parse(f"a {name}").objects
    assert (one.name, one.count) == (NAMES[name], 1)
    if not name.endswith(("s", "sh", "ch", "f", "um", "ox", "fungus", "penny", "sky")) and " of " not in name:
        plural = name[:-1] + "ies" if name.endswith("y") and name[-2] not in "aeiou" else name + "s"
        (more,) = parse(plural).objects
        assert (more.name, more.count) == (NAMES[name], 3)


@pytest.mark.parametrize("word", sorted({*CHANGES, *SUBSTANCES, *COLORS, *SIZES, *COUNTS}))
def test_every_quality_can_be_said(word):
    parse(word if word in CHANGES and word not in SUBSTANCES else f"{word} cat")


@pytest.mark.parametrize(
    ("prompt", "substance", "changes"),
    [
        ("a mossy stone", "moss", ()),
        ("a stone covered in thick moss", "moss", ()),
        ("a cat made of marble", "marble", ()),
        ("a bird covered in snow", "", ("snow",)),
        ("a ladybug on the leaf, wet with dew", "", ("dew",)),
        ("a bird at night", "", ("night",)),
        ("a fish in the fog", "", ("fog",)),
        ("a red key and rust", "", ("rust",)),
    ],
)
def test_substances_belong_to_objects_and_weather_to_the_picture(prompt, substance, changes):
    edit = parse(prompt)
    assert edit.objects[0].tint.substance == substance
    assert tuple(c.name for c in edit.changes) == changes


@pytest.mark.parametrize(
    ("prompt", "changes"),
    [
        ("covered in moss", {"moss": 0.75}),
        ("everything covered in thick moss", {"moss": 1.0}),
        ("rusty", {"rust": 0.75}),
        ("wet with dew", {"dew": 0.75}),
        ("light snow", {"snow": 0.45}),
        ("let it snow", {"snow": 0.75}),
        ("at sunset", {"sunset": 0.75}),
        ("fog and frost", {"fog": 0.75, "frost": 0.75}),
        ("the rocks covered in moss, misty", {"moss": 0.75, "fog": 0.75}),
        ("forst", {"frost": 0.75}),
    ],
)
def test_changes_of_the_whole_picture(prompt, changes):
    edit = parse(prompt)
    assert edit.objects == ()
    assert {c.name: c.amount for c in edit.changes} == changes
    assert edit


def test_nothing_to_do_is_false():
    assert not parse("  ")


def test_words_for_completion_are_those_understood():
    assert set(known_words()["objects"]) == set(BUILDERS)
    assert set(known_words()["names"]) == set(NAMES)


@pytest.mark.parametrize("prompt", ["", "   ", "\n"])
def test_empty_prompt_inserts_nothing(prompt):
    assert parse(prompt).objects == ()


@pytest.mark.parametrize(
    "prompt",
    [
        "a unicorn",
        "asdf",
        "a frobnicated ladybug",
        "a ladybug on the zzyzx",
        "on the petal",
        "red",
        "and",
        "covered in gravy",
        "everything",
        "a cat made of cheese",
        "missing.png",
    ],
)
def test_refuses(prompt):
    with pytest.raises(PromptError) as caught:
        parse(prompt)
    assert caught.value.what == repr(prompt)
    assert caught.value.exit_status == 2
    assert "\n" not in caught.value.line()


def test_refusal_names_what_is_known_nearest_first():
    with pytest.raises(PromptError) as caught:
        parse("a butterfloid")
    assert caught.value.hint.startswith("Known: a butterfly")
    with pytest.raises(PromptError) as caught:
        parse("a purplish ladybug")
    assert "purple" in caught.value.hint
    assert "also an image file" in caught.value.hint


@pytest.mark.parametrize(("word", "kin"), [("dog", "a cat"), ("eagles", "a bird"), ("rose", "a flower")])
def test_refusal_offers_the_nearest_kin(word, kin):
    with pytest.raises(PromptError) as caught:
        parse(f"a big {word}")
    assert f"Known: {kin}, " in caught.value.hint


def test_image_file(tmp_path):
    path = tmp_path / "cat.PNG"
    path.write_bytes(b"x")
    for prompt in (str(path), f"image:{path}"):
        (request,) = parse(prompt).objects
        assert (request.name, request.path) == ("image", str(path))
