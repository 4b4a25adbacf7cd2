"""``wzviewer models``: backends and what they add."""

import argparse
import sys

from wzviewer.worker.models.catalogue import BACKENDS


def run(options: argparse.Namespace) -> None:
    """Lists the backends; ``check`` says which can run here."""
    for name, summary in BACKENDS.items():
        state = "ready; needs no weights" if name == "builtin" else "not installed"
        sys.stdout.write(f"{name:10} {state if options.action == 'check' else summary}\n")
