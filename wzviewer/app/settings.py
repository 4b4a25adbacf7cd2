"""What the user prefers, kept between runs in one small JSON file that is written whole.

A file that is damaged, or a value out of its range, never stops the app: the default stands in, and the
user is told.
"""

import json
import logging
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal, Protocol, cast, get_args

from wzviewer.core.photos import whole_file
from wzviewer.errors import WzError

LOG = logging.getLogger(__name__)
ThemeName = Literal["dark", "light"]
KeymapName = Literal["wzviewer", "authors"]
RasterizerName = Literal["auto", "shaders", "kernels"]
FONT_RANGE_PT = (13.0, 22.0)
MAX_FILE_BYTES = 1 << 16


@dataclass(frozen=True)
class Settings:
    """Preferences.

    Attributes:
        theme: dark or light panels.
        font_pt: size of the text, pt.
        reduced_motion: jump where a flight would go, and no eased zoom.
        auto_detail: ask for detail by itself where the view rests beyond what there is.
        rasterizer: who draws; takes effect at the next start.
        keymap: whose keys: wzviewer's, or those of the viewer that the paper's authors released.
        hint_seen: whether the hint on the first photo was read, and is not shown again.
    """

    theme: ThemeName = "dark"
    font_pt: float = 16.0
    reduced_motion: bool = False
    auto_detail: bool = True
    rasterizer: RasterizerName = "auto"
    keymap: KeymapName = "wzviewer"
    hint_seen: bool = False


def read_settings(record: Mapping[str, object]) -> tuple[Settings, tuple[str, ...]]:
    """Returns settings, and the names of those that were malformed and are now the default."""
    good: dict[str, Any] = {}
    bad: list[str] = []
    for field in fields(Settings):
        if field.name not in record:
            continue
        value = record[field.name]
        if _is_valid(field.name, value):
            good[field.name] = float(cast(float, value)) if field.name == "font_pt" else value
        else:
            bad.append(field.name)
    return Settings(**good), tuple(bad)


def _is_valid(name: str, value: object) -> bool:
    choices = {"theme": ThemeName, "rasterizer": RasterizerName, "keymap": KeymapName}
    if name in choices:
        return value in get_args(choices[name])
    if name == "font_pt":
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and FONT_RANGE_PT[0] <= cast(float, value) <= FONT_RANGE_PT[1]
    return isinstance(value, bool)


class Store(Protocol):
    """Where settings live between runs."""

    def load(self) -> tuple[Settings, str]:
        """Returns the settings, and a sentence about what was wrong with them."""
        ...

    def save(self, settings: Settings) -> str:
        """Keeps the settings; returns a sentence when that is not possible."""
        ...


class NoStore:
    """Settings that live as long as the app."""

    def load(self) -> tuple[Settings, str]:
        """Returns the defaults."""
        return Settings(), ""

    def save(self, settings: Settings) -> str:
        """Keeps nothing."""
        return ""


class SettingsFile:
    """Settings in a JSON file.

    Args:
        path: of the file; its folder is made when needed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def of_user(cls) -> "SettingsFile":
        """Returns the file in the user's configuration folder."""
        from platformdirs import user_config_path

        return cls(user_config_path("wzviewer", appauthor=False) / "settings.json")

    def load(self) -> tuple[Settings, str]:
        """Reads the file; defaults stand in for what is missing or malformed."""
        try:
            if not self.path.is_file():
                return Settings(), ""
            if self.path.stat().st_size > MAX_FILE_BYTES:
                raise ValueError("too large")
            record = json.loads(self.path.read_text("utf-8"))
            if not isinstance(record, dict):
                raise ValueError("not an object")
        except (OSError, ValueError, RecursionError) as error:
            LOG.warning("settings: %s", error)
            return Settings(), f"The settings could not be read ({error}): the defaults are used."
        settings, bad = read_settings(record)
        sentence = f"Settings reset to the default: {', '.join(bad)}." if bad else ""
        return settings, sentence

    def save(self, settings: Settings) -> str:
        """Writes the file whole or not at all."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self.path) as file:
                file.write(json.dumps(asdict(settings), indent=1).encode())
        except (OSError, WzError) as error:
            return f"The settings could not be kept: {error}"
        return ""
