"""``wzviewer [FILE]``: the desktop app."""

import argparse

from wzviewer.core.files import is_scene_file, load_scene
from wzviewer.core.photos import load_photo


def run(options: argparse.Namespace) -> None:
    """Checks the file while the terminal can still say so, then opens the window."""
    if options.file is not None:
        (load_scene if is_scene_file(options.file) else load_photo)(options.file)
    from wzviewer.app.loop import run_app

    run_app(options.file)
