"""The last messages of the app and of its worker, for the log window.

A handler of Python's logging with a bounded memory.  It is attached by whoever runs the app and
detached when the app ends, so nothing is global.
"""

import logging
from collections import deque
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from wzviewer.worker import client as ev

LOG = logging.getLogger(__name__)
ROOT = "wzviewer"  # of all loggers here
MAX_LINES = 1000
MAX_CHARACTERS = 8000  # of a message; the end of a traceback says what happened
LEVELS = ((logging.INFO, "All"), (logging.WARNING, "Warnings"), (logging.ERROR, "Errors"))


@dataclass(frozen=True)
class LogLine:
    """A message.

    Attributes:
        time_s: when, s since 1970.
        level: as logging counts: 20 information, 30 warning, 40 error.
        source: the logger, without the package's name.
        text: the message, and the traceback if there is one.
    """

    time_s: float
    level: int
    source: str
    text: str

    def __str__(self) -> str:
        when = datetime.fromtimestamp(self.time_s)
        return f"{when:%H:%M:%S} {logging.getLevelName(self.level).lower():7} {self.source}: {self.text}"


class Logbook(logging.Handler):
    """Keeps the last messages, from any thread.

    Args:
        capacity: how many.
    """

    def __init__(self, capacity: int = MAX_LINES) -> None:
        super().__init__(logging.INFO)
        self._lines: deque[LogLine] = deque(maxlen=capacity)
        self._level_before = logging.NOTSET

    def attach(self) -> None:
        """Listens to everything that wzviewer logs."""
        logger = logging.getLogger(ROOT)
        self._level_before = logger.level
        logger.setLevel(min(logger.getEffectiveLevel(), logging.INFO))
        logger.addHandler(self)

    def detach(self) -> None:
        """Listens no longer."""
        logger = logging.getLogger(ROOT)
        if self in logger.handlers:
            logger.removeHandler(self)
            logger.setLevel(self._level_before)

    def emit(self, record: logging.LogRecord) -> None:
        """Takes a message; the terminal gets warnings as it would without this."""
        text = self.format(record)
        text = text if len(text) <= MAX_CHARACTERS else "…" + text[-MAX_CHARACTERS:]
        source = record.name.removeprefix(f"{ROOT}.")
        self._lines.append(LogLine(record.created, record.levelno, source, text))
        if logging.lastResort is not None and not logging.getLogger().handlers:
            if record.levelno >= logging.lastResort.level:
                logging.lastResort.handle(record)

    def lines(self, level: int = logging.INFO) -> tuple[LogLine, ...]:
        """Returns the messages from a level on, the newest last."""
        self.acquire()
        try:
            return tuple(line for line in self._lines if line.level >= level)
        finally:
            self.release()


def log_notices(before: Any, after: Any) -> None:  # noqa: ANN401 - AppState, which knows of this module
    """Logs what the user was told between two states of the app."""
    if after.toasts is before.toasts:
        return
    told = {toast.text for toast in before.toasts}
    for toast in after.toasts:
        if toast.text not in told:
            details = f"\n{toast.details}" if toast.details else ""
            LOG.log(logging.ERROR if toast.kind == "error" else logging.INFO, "%s%s", toast.text, details)


def log_event(event: ev.Event) -> None:
    """Logs what the worker reported, progress and previews apart."""
    if isinstance(event, ev.WorkerStarted):
        LOG.info("the worker is ready")
    elif isinstance(event, ev.WorkerLost):
        LOG.error("the worker %s", event.why)
    elif isinstance(event, ev.LevelFinished):
        stages = ", ".join(f"{name} {record.seconds:.1f} s" for name, record in event.level.stages.items())
        about = f": {stages}" if stages else ""
        LOG.info("level %d is finished, %s surfels%s", event.level.index, len(event.level.surfels), about)
    elif isinstance(event, ev.LevelDropped):
        LOG.log(
            logging.INFO if event.cancelled else logging.WARNING, "no level: %s %s", event.what, event.why
        )
