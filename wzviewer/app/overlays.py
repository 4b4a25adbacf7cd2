"""What is summoned over all else: the palette of commands, and the log window."""

import logging
from dataclasses import dataclass


@dataclass(frozen=True)
class PaletteView:
    """The palette.

    Attributes:
        is_open: whether it is shown.
        text: typed so far.
        marked: which of the hits is marked; counts on beyond the last one.
    """

    is_open: bool = False
    text: str = ""
    marked: int = 0


@dataclass(frozen=True)
class LogView:
    """The log window.

    Attributes:
        is_open: whether it is shown.
        level: of the least messages that are shown.
    """

    is_open: bool = False
    level: int = logging.INFO
