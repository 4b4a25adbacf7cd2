"""Progress of generation on a terminal, in a log, or not at all.  Always on stderr."""

import sys
from types import TracebackType
from typing import Any, Self

from wzviewer.worker.client import Event, LevelPreviewed, StageProgressed


class Progress:
    """A bar on a terminal; plain lines elsewhere; silent when asked.

    Args:
        silent: report nothing.
    """

    def __init__(self, silent: bool = False) -> None:
        self._silent = silent
        self._bar: Any = None
        self._task: Any = None
        if not silent and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
            from rich.progress import Progress as RichProgress

            columns = (TextColumn("{task.description:36}"), BarColumn(), TimeElapsedColumn())
            self._bar = RichProgress(*columns, console=Console(stderr=True))

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def begin(self, title: str) -> None:
        """Starts a piece of work."""
        self._title = title
        if self._bar is not None:
            self._task = self._bar.add_task(title, total=1.0)
        else:
            self.line(title)

    def event(self, event: Event) -> None:
        """Shows a stage or a preview."""
        if isinstance(event, StageProgressed):
            self.step(event.name, event.fraction)
        elif isinstance(event, LevelPreviewed) and self._bar is None and event.revision == 0:
            self.line("  preview")

    def step(self, name: str, fraction: float) -> None:
        """Shows how far the present piece of work is, in [0, 1]."""
        if self._bar is not None:
            self._bar.update(self._task, completed=fraction, description=f"{self._title}: {name}")
        else:
            self.line(f"  {name}")

    def done(self) -> None:
        """Ends the present piece of work."""
        if self._bar is not None:
            self._bar.update(self._task, completed=1.0, description=self._title)

    def line(self, text: str) -> None:
        """Writes a plain line."""
        if not self._silent:
            sys.stderr.write(text + "\n")
            sys.stderr.flush()
