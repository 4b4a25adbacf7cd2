"""Files are read and written beside the frame loop: no frame waits on a disk.

::

    start(errand, work) ──► a thread runs work() ──► poll() ──► errand.done(services, state, result)

One errand runs at a time.  `AtOnce` does the work where it stands: for tests, and wherever there is no loop.
"""

import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol

from wzviewer.errors import WzError

LOG = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Errand:
    """Something that is done to a file.

    Attributes:
        line: what is being done, for the user.
        done: takes (services, state, result of the work) to the state after.
        failed: takes (services, state, one line) to the state after.
    """

    line: str
    done: Callable[[Any, Any, Any], Any]
    failed: Callable[[Any, Any, str], Any]


class Errands(Protocol):
    """Where work on files is done."""

    def start(self, errand: Errand, work: Callable[[], Any]) -> None:
        """Begins the work; the one before must have been polled."""

    def poll(self) -> tuple[Errand, Any, str] | None:
        """Returns (errand, result, fault) once the work has ended; the fault is empty when it went well."""
        ...

    def close(self) -> None:
        """Waits for the work: a file that is being saved is saved."""


class AtOnce:
    """Does the work in `start`."""

    def __init__(self) -> None:
        self._ended: tuple[Errand, Any, str] | None = None

    def start(self, errand: Errand, work: Callable[[], Any]) -> None:
        """Does it."""
        self._ended = (errand, *_outcome(work))

    def poll(self) -> tuple[Errand, Any, str] | None:
        """Returns it once."""
        ended, self._ended = self._ended, None
        return ended

    def close(self) -> None:
        """Nothing is left to do."""


class OnThread:
    """Does the work on a thread of its own."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="files")
        self._running: tuple[Errand, Future[tuple[Any, str]]] | None = None

    def start(self, errand: Errand, work: Callable[[], Any]) -> None:
        """Begins it."""
        assert self._running is None, "one errand at a time"
        self._running = (errand, self._pool.submit(_outcome, work))

    def poll(self) -> tuple[Errand, Any, str] | None:
        """Returns it once it has ended."""
        if self._running is None or not self._running[1].done():
            return None
        (errand, future), self._running = self._running, None
        return (errand, *future.result())

    def close(self) -> None:
        """Waits for it."""
        self._pool.shutdown()


def _outcome(work: Callable[[], Any]) -> tuple[Any, str]:
    """Returns the result and why there is none."""
    try:
        return work(), ""
    except WzError as error:
        return None, error.line()
    except (OSError, MemoryError) as error:
        return None, str(error) or type(error).__name__
    except Exception as error:  # the boundary of the thread: told once
        LOG.exception("an errand failed")
        return None, f"{type(error).__name__}: {error}"
