"""The system's own file dialogs, asked without stopping the frame loop."""

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from imgui_bundle import portable_file_dialogs as pfd

LINUX_DIALOGS = ("zenity", "kdialog", "matedialog", "qarma")
OPEN_FILTERS = [
    "Photos and scenes",
    "*.jpg *.jpeg *.png *.webp *.JPG *.JPEG *.PNG *.wz",
    "All files",
    "*",
]


class SystemDialogs:
    """Dialogs of the desktop, one at a time."""

    def __init__(self) -> None:
        self._kind = ""
        self._running: Any = None

    def ask_open(self, folder: str) -> bool:
        """Shows the open dialog; False when the system has none."""
        start = folder + os.sep
        return self._start("open", lambda: pfd.open_file("Open a photo or a scene", start, OPEN_FILTERS))

    def ask_save(self, suggestion: str) -> bool:
        """Shows the save dialog; False when the system has none."""
        filters = ["Scene", "*.wz"]
        return self._start("save", lambda: pfd.save_file("Save the scene", suggestion, filters))

    def ask_picture(self, suggestion: str) -> bool:
        """Shows the dialog for a picture; False when the system has none."""
        filters = ["Picture", "*.png"]
        return self._start("picture", lambda: pfd.save_file("Save the picture", suggestion, filters))

    def ask_film(self, suggestion: str) -> bool:
        """Shows the dialog for a film; False when the system has none."""
        filters = ["Film", "*.mp4 *.gif"]
        return self._start("film", lambda: pfd.save_file("Save the film", suggestion, filters))

    def ask_path(self, suggestion: str, is_opening: bool) -> bool:
        """Shows the dialog for a camera path, or in a folder to open one; False when the system has none."""
        filters = ["Camera path", "*.json"]
        if is_opening:
            start = suggestion + os.sep
            return self._start("open path", lambda: pfd.open_file("Open a camera path", start, filters))
        return self._start("save path", lambda: pfd.save_file("Save the camera path", suggestion, filters))

    def poll(self) -> Sequence[tuple[str, Path]]:
        """Returns the answer, once there is one: (open, save or picture; path)."""
        if self._running is None or not self._running.ready(0):
            return []
        answer, self._running = self._running.result(), None
        path = answer[0] if isinstance(answer, list) and answer else answer
        return [(self._kind, Path(path))] if path else []

    def _start(self, kind: str, make: Any) -> bool:  # noqa: ANN401 - a class of a library without types
        if not has_system_dialogs():
            return False
        if self._running is None:
            self._kind, self._running = kind, make()
        return True


def has_system_dialogs() -> bool:
    """Whether the desktop can show file dialogs; Linux needs a program for them."""
    if sys.platform in ("win32", "darwin"):
        return True
    return any(shutil.which(name) for name in LINUX_DIALOGS)
