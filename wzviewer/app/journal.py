"""Finished levels on disk as soon as they are made, so that a crash loses at most the one in the making.

::

    journal/SESSION/lock            held while the app lives: what is not held was left by a crash
                    000.level ...   one archive a level, written whole
                    state.json      name and file of the document, marks of its levels, keys of its timeline

A thread writes; the frame loop only says how things stand.  A document that is saved, or closed with
the user's consent, needs no journal, and its session is emptied.
"""

import json
import logging
import os
import queue
import shutil
import threading
import time
import zipfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol

from wzviewer.app.timeline import FIELD, record_of
from wzviewer.core.constants import MAX_LEVELS
from wzviewer.core.files import get_level, put_level
from wzviewer.core.keyframes import KeyPath
from wzviewer.core.marks import marks_from_json, marks_to_json
from wzviewer.core.photos import whole_file
from wzviewer.core.records import header_of
from wzviewer.core.scene import Level, Scene
from wzviewer.errors import WzError

NO_KEYS = KeyPath()
LOG = logging.getLogger(__name__)
MAX_STATE_BYTES = 1 << 20
MANIFEST, STATE, LOCK = "manifest.json", "state.json", "lock"
DAMAGE = (OSError, ValueError, KeyError, TypeError, RecursionError, zipfile.BadZipFile, WzError)


@dataclass(frozen=True)
class Leftover:
    """A session that ended without closing.

    Attributes:
        folder: where it lies.
        name: of its document.
        count: of its levels.
        num_unseen: of these, variants that were not chosen and the like.
        source: the file that it was made of or saved in, if there was one.
    """

    folder: Path
    name: str
    count: int
    num_unseen: int = 0
    source: Path | None = None

    @property
    def what(self) -> str:
        """What it holds, as far as the user saw it."""
        seen = self.count - self.num_unseen
        levels = "1 level" if seen == 1 else f"{seen} levels"
        return f"{levels} of {self.name}" if self.name else levels


class Journal(Protocol):
    """Keeps finished levels while they are in no file."""

    def keep(self, scene: Scene, name: str, keys: KeyPath = NO_KEYS, source: Path | None = None) -> None:
        """Says which levels and keys of the timeline are in no file; costs nothing when nothing changed."""

    def clear(self) -> None:
        """Says that no level is only here."""

    def leftover(self) -> Leftover | None:
        """Returns the newest session that a crash left behind."""
        ...

    def recover(self, leftover: Leftover) -> Scene:
        """Reads it, as far as it is whole; raises ValueError when there is nothing."""
        ...

    def discard(self, leftover: Leftover) -> None:
        """Deletes it."""

    def close(self) -> None:
        """Ends the session; a clean end leaves nothing behind."""


class NoJournal:
    """Keeps nothing."""

    def keep(self, scene: Scene, name: str, keys: KeyPath = NO_KEYS, source: Path | None = None) -> None:
        """Does nothing."""

    def clear(self) -> None:
        """Does nothing."""

    def leftover(self) -> Leftover | None:
        """Returns None."""
        return None

    def recover(self, leftover: Leftover) -> Scene:
        """Is never asked."""
        raise ValueError("there is no journal")

    def discard(self, leftover: Leftover) -> None:
        """Does nothing."""

    def close(self) -> None:
        """Does nothing."""


class JournalFolder:
    """A journal on disk.

    Args:
        folder: of all sessions.
        session: name of this one, unlike any other's.
    """

    def __init__(self, folder: Path, session: str) -> None:
        self._sessions, self._own = folder, folder / session
        self._asked: tuple[object, ...] = ()
        self._keys = NO_KEYS
        self._written: set[int] = set()
        self._scene: Scene | None = None
        self._lock: BinaryIO | None = None
        self._work: queue.Queue[tuple[str, object] | None] = queue.Queue()
        self._thread = threading.Thread(target=self._write_on, daemon=True)
        self._thread.start()

    @classmethod
    def of_user(cls) -> "JournalFolder":
        """Returns the journal in the user's data folder."""
        from platformdirs import user_data_path

        folder = user_data_path("wzviewer", appauthor=False) / "journal"
        return cls(folder, f"{time.time_ns()}-{os.getpid()}")

    def keep(self, scene: Scene, name: str, keys: KeyPath = NO_KEYS, source: Path | None = None) -> None:
        """Has levels written that are finished and not yet kept, and what is said about them."""
        finished = tuple(level for level in scene if scene.is_committed(level.index))
        asked = (id(scene), len(finished), scene.marks, name, source)
        if asked == self._asked and keys is self._keys:
            return
        if scene is not self._scene:
            self.clear()
            self._scene = scene
        self._asked, self._keys = asked, keys
        for level in finished:
            if level.index not in self._written:
                self._written.add(level.index)
                self._work.put(("level", level))
        timeline = {FIELD: record_of(keys)} if keys.keys else {}
        origin = {"source": str(source)} if source is not None else {}
        self._work.put(("state", {"name": name, **origin, **marks_to_json(scene.marks), **timeline}))

    def clear(self) -> None:
        """Has the session emptied."""
        if self._asked:
            self._asked, self._scene = (), None
            self._written.clear()
            self._work.put(("clear", None))

    def leftover(self) -> Leftover | None:
        """Returns the newest session of another run that is not alive and holds a level."""
        with suppress(OSError):
            for folder in sorted(self._sessions.iterdir(), key=lambda p: p.stat().st_mtime, reverse=True):
                count = len(list(folder.glob("*.level"))) if folder.is_dir() else 0
                if folder != self._own and count and not _is_held(folder / LOCK):
                    said = _read_state(folder)
                    marks = marks_from_json(said, count).values()
                    unseen = sum(mark.sight != "shown" for mark in marks)
                    source = said.get("source")
                    origin = Path(source) if isinstance(source, str) else None
                    return Leftover(folder, str(said.get("name", "")), count, unseen, origin)
        return None

    def recover(self, leftover: Leftover) -> Scene:
        """Reads a session up to the first level that is not whole."""
        scene = Scene()
        for index in range(min(leftover.count, MAX_LEVELS)):
            try:
                scene.append(_read_level(leftover.folder / f"{index:03d}.level", index))
            except DAMAGE as error:
                LOG.warning("journal: level %d: %s", index, error)
                break
            scene.commit(index)
        said = _read_state(leftover.folder)
        for index, mark in marks_from_json(said, len(scene)).items():
            scene.set_mark(index, mark)
        scene.unknown_fields = {FIELD: said[FIELD]} if FIELD in said else {}
        if not len(scene):
            raise ValueError("nothing in it can be read")
        return scene

    def discard(self, leftover: Leftover) -> None:
        """Has a session deleted, after all that was asked for before."""
        self._work.put(("discard", leftover.folder))

    def close(self) -> None:
        """Waits for the thread, and removes the session."""
        self._work.put(None)
        self._thread.join(30.0)
        if self._lock is not None:
            self._lock.close()
        shutil.rmtree(self._own, ignore_errors=True)

    def wait(self) -> None:
        """Waits until all that was asked for is on disk."""
        self._work.join()

    # ------------------------------------------------------------- thread

    def _write_on(self) -> None:
        while (item := self._work.get()) is not None:
            try:
                self._write(*item)
            except DAMAGE as error:  # a full disk must not end the session
                LOG.warning("journal: %s", error)
            self._work.task_done()

    def _write(self, kind: str, what: object) -> None:
        if kind == "clear":
            for path in (*self._own.glob("*.level"), self._own / STATE):
                path.unlink(missing_ok=True)
            return
        if isinstance(what, Path):
            shutil.rmtree(what, ignore_errors=True)
            return
        self._own.mkdir(parents=True, exist_ok=True)
        if self._lock is None:
            self._lock = (self._own / LOCK).open("wb")
            _hold(self._lock)
        if isinstance(what, Level):
            _write_level(self._own / f"{what.index:03d}.level", what)
        else:
            with whole_file(self._own / STATE) as file:
                file.write(json.dumps(what).encode())


def _write_level(path: Path, level: Level) -> None:
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr(MANIFEST, json.dumps(header_of(level)))
        put_level(archive, level)


def _read_level(path: Path, index: int) -> Level:
    with zipfile.ZipFile(path) as archive:
        if archive.getinfo(MANIFEST).file_size > MAX_STATE_BYTES:
            raise ValueError("the manifest is too large")
        return get_level(archive, index, json.loads(archive.read(MANIFEST)))


def _read_state(folder: Path) -> dict[str, object]:
    with suppress(OSError, ValueError, RecursionError):
        if (folder / STATE).stat().st_size <= MAX_STATE_BYTES:
            record = json.loads((folder / STATE).read_text("utf-8"))
            return record if isinstance(record, dict) else {}
    return {}


def _hold(file: BinaryIO) -> None:
    """Locks an open file for as long as this process lives.

    Raises:
        OSError: when another process holds it.
    """
    try:
        import fcntl
    except ImportError:
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_held(path: Path) -> bool:
    try:
        with path.open("r+b") as file:
            _hold(file)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False
