"""``wzviewer models``: backends, what they can be asked for, and what others would add."""

import argparse
import sys
import textwrap

from wzviewer.worker.models.builtin.objects.words import CHANGES, LOOKS, SUBSTANCES, known_words
from wzviewer.worker.models.catalogue import BACKENDS, WOULD_ADD

_INDENT = " " * 11


def run(options: argparse.Namespace) -> None:
    """Lists the backends and the prompts they understand; ``check`` says which can run here."""
    for name, summary in BACKENDS.items():
        state = "ready; needs no weights" if name == "builtin" else "not installed"
        sys.stdout.write(f"{name:10} {state if options.action == 'check' else summary}\n")
    if options.action != "check":
        sys.stdout.write("\n".join([*_prompts(), "", *_wrapped("A downloaded model", WOULD_ADD), ""]))


def _prompts() -> list[str]:
    """Returns lines that say what a prompt may ask of the builtin backend."""
    words = known_words()
    lines = ["", 'Prompts, such as "two small red ladybugs on the leaf, wet with dew":']
    for title, entries in (
        ("objects", words["objects"]),
        ("counts", words["counts"]),
        ("sizes", words["sizes"]),
        ("colours", words["colors"]),
        ("patterns", words["patterns"]),
        ("made of", tuple(dict.fromkeys(SUBSTANCES.values()))),
        ("over all", tuple(dict.fromkeys(CHANGES.values()))),
        ("places", ("left", "right", "top", "bottom", "centre")),
        ("looked for", tuple(LOOKS)),
    ):
        lines += _wrapped(title, ", ".join(entries))
    return [*lines, *_wrapped("images", "the path of a PNG, JPEG or WebP file is inserted as it is")]


def _wrapped(title: str, text: str) -> list[str]:
    first = f"{title:10} " if len(title) < len(_INDENT) else f"{title} "
    return textwrap.wrap(text, 100, initial_indent=first, subsequent_indent=_INDENT)
