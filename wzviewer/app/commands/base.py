"""Base of everything that may be asked for."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Command:
    """Base of all commands."""
