"""What is chosen in the Keep panel, and a film in the making: frozen records."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from wzviewer.commands.cameras import FPS, ORBIT_DEG

Tab = Literal["picture", "film"]
Source = Literal["way", "orbit", "keys"]


@dataclass(frozen=True)
class KeepPlan:
    """The next picture and the next film; their size is `AppState.picture_size`.

    Attributes:
        tab: which of the two is shown.
        is_transparent: whether a picture has no background.
        size_text: a size as typed, "WxH"; empty when one of the buttons was pressed.
        size_fault: what is wrong with it.
        source: of the film: from the photo to here, about what is looked at, or through the keys.
        suffix: kind of the film, ".mp4" or ".gif".
        fps: frames per second.
        seconds: length of the film; None is what suits it.
        orbit_deg: to either side.
    """

    tab: Tab = "picture"
    is_transparent: bool = False
    size_text: str = ""
    size_fault: str = ""
    source: Source = "way"
    suffix: str = ".mp4"
    fps: float = FPS
    seconds: float | None = None
    orbit_deg: float = ORBIT_DEG


@dataclass(frozen=True)
class Film:
    """A film in the making.

    Attributes:
        path: of its file.
        started_s: when it was asked for, s.
        fraction: of its frames.
        is_cancelling: whether the user asked to stop.
        is_picture: whether it is one large picture.
    """

    path: Path
    started_s: float
    fraction: float = 0.0
    is_cancelling: bool = False
    is_picture: bool = False

    @property
    def kind(self) -> str:
        """What it is, as notices say it."""
        return "picture" if self.is_picture else "film"
