"""Prompts: what is understood, what is refused, and what the refusal says."""

import pytest

from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects.bodies import linear
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
from wzviewer.worker.models.builtin.objects.grammar import COLORS

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


def test_colour_words_joined_by_and_belong_to_one_object():
    (request,) = parse("a red and black ladybug").objects
    assert request.tint.color == linear(*COLORS["red"])


def test_substance_and_pattern_words():
    assert parse("a golden beetle").objects[0].tint.substance == "metal"
    assert parse("a plain ladybug").objects[0].tint.pattern == "plain"


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


def test_image_file(tmp_path):
    path = tmp_path / "cat.PNG"
    path.write_bytes(b"x")
    for prompt in (str(path), f"image:{path}"):
        (request,) = parse(prompt).objects
        assert (request.name, request.path) == ("image", str(path))
