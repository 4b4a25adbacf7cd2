"""Files that were open lately, kept between runs with a small picture of each.

::

    recent.json      the list, newest first, written whole
    pictures/ID.png  ID is a digest of the path: nothing in the list names a file to be read

A thread reads and writes; the frame loop only says what was opened and takes over the newest list.  A
list that is damaged is begun anew, and the user is told.
"""

import hashlib
import json
import logging
import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from wzviewer.core.photos import decode_png, encode_png, fit_photo, whole_file
from wzviewer.core.types import ByteArray
from wzviewer.errors import WzError

LOG = logging.getLogger(__name__)
MAX_FILES = 12
MAX_LIST_BYTES = 1 << 18
LATEST_S = 1e11  # some 3000 years from now: what a calendar can still name
MAX_PATH = 4096  # characters; more is no path of any system
PICTURE_PX = 320  # long side: twice what is shown, for dense screens
MAX_PICTURE_BYTES = 1 << 20
LIST, PICTURES = "recent.json", "pictures"
DAMAGE = (OSError, ValueError, RecursionError, WzError)


@dataclass(frozen=True, eq=False)
class RecentFile:
    """A file that was open.

    Attributes:
        path: absolute.
        opened_s: when, s since 1970.
        picture: (h, w, 3) uint8, small; None where there is none.
        is_missing: whether it was not there when last looked for.
    """

    path: Path
    opened_s: float
    picture: ByteArray | None = None
    is_missing: bool = False


@dataclass(frozen=True, eq=False)
class Recents:
    """The list, newest first.

    Attributes:
        files: at most `MAX_FILES`.
        complaint: what was wrong with the list, one sentence; said once.
    """

    files: tuple[RecentFile, ...] = ()
    complaint: str = ""


class RecentStore(Protocol):
    """Where the list lives between runs."""

    def note(self, path: Path, image: ByteArray) -> None:
        """Puts a file, with its picture (h, w, 3) uint8 of any size, at the top."""

    def remove(self, path: Path) -> None:
        """Takes a file off the list; the file itself stays."""

    def clear(self) -> None:
        """Empties the list."""

    def poll(self) -> Recents | None:
        """Returns the list when it has changed since the last call."""
        ...

    def close(self) -> None:
        """Waits until all is written."""


class NoRecents:
    """Remembers nothing."""

    def note(self, path: Path, image: ByteArray) -> None:
        """Does nothing."""

    def remove(self, path: Path) -> None:
        """Does nothing."""

    def clear(self) -> None:
        """Does nothing."""

    def poll(self) -> Recents | None:
        """Returns None."""
        return None

    def close(self) -> None:
        """Does nothing."""


class RecentFolder:
    """The list on disk.

    Args:
        folder: of the list and its pictures; made when needed.
        clock: time now, s since 1970.
    """

    def __init__(self, folder: Path, clock: Callable[[], float] = time.time) -> None:
        self._folder, self._clock = folder, clock
        self._pictures: dict[Path, ByteArray] = {}  # of the thread: each is read once
        self._news: queue.SimpleQueue[Recents] = queue.SimpleQueue()
        self._work: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread = threading.Thread(target=self._work_on, daemon=True)
        self._work.put(lambda: self._publish(*self._read()))

    @classmethod
    def of_user(cls) -> "RecentFolder":
        """Returns the list in the user's state folder."""
        from platformdirs import user_state_path

        return cls(user_state_path("wzviewer", appauthor=False))

    def note(self, path: Path, image: ByteArray) -> None:
        """Puts a file at the top; the picture is made in the thread."""
        self._begin()
        opened = RecentFile(path.absolute(), self._clock(), image)
        self._work.put(lambda: self._note(opened))

    def remove(self, path: Path) -> None:
        """Takes a file off the list."""
        self._begin()
        self._work.put(lambda: self._keep([f for f in self._read()[0] if f.path != path]))

    def clear(self) -> None:
        """Empties the list."""
        self._begin()
        self._work.put(lambda: self._keep([]))

    def poll(self) -> Recents | None:
        """Returns the newest list, or None."""
        self._begin()
        newest: Recents | None = None
        while not self._news.empty():
            news = self._news.get()
            newest = replace(news, complaint=news.complaint or (newest.complaint if newest else ""))
        return newest

    def wait(self) -> None:
        """Waits until all that was asked for is done."""
        self._begin()
        self._work.join()

    def _begin(self) -> None:
        """Not before the first frame: it imports OpenCV, whose folder a worker started now would inherit."""
        if self._thread.ident is None:
            self._thread.start()

    def close(self) -> None:
        """Ends the thread."""
        self._begin()
        self._work.put(None)
        self._thread.join(10.0)

    # ------------------------------------------------------------- thread

    def _work_on(self) -> None:
        while (work := self._work.get()) is not None:
            try:
                work()
            except DAMAGE as error:  # a full disk is no reason to stop
                LOG.warning("recent files: %s", error)
            self._work.task_done()

    def _note(self, opened: RecentFile) -> None:
        others = [f for f in self._read()[0] if f.path != opened.path]
        if opened.picture is not None:
            self._pictures[opened.path] = small = fit_photo(opened.picture, PICTURE_PX)
            with suppress(*DAMAGE):  # without a picture the list is still of use
                place = self._place_of(opened.path)
                place.parent.mkdir(parents=True, exist_ok=True)
                with whole_file(place) as file:
                    file.write(encode_png(small))
        self._keep([replace(opened, picture=None), *others])

    def _keep(self, files: list[RecentFile]) -> None:
        """Writes the list, and deletes the pictures of what is no longer on it."""
        files = files[:MAX_FILES]
        self._folder.mkdir(parents=True, exist_ok=True)
        record = {"files": [{"path": str(f.path), "opened_s": f.opened_s} for f in files]}
        with whole_file(self._folder / LIST) as file:
            file.write(json.dumps(record, indent=1).encode())
        self._publish(files, "")
        wanted = {self._place_of(f.path) for f in files}
        for place in (self._folder / PICTURES).glob("*.png"):
            if place not in wanted:
                place.unlink(missing_ok=True)

    def _publish(self, files: list[RecentFile], complaint: str) -> None:
        shown = (replace(f, picture=self._picture(f.path), is_missing=not _is_there(f.path)) for f in files)
        self._news.put(Recents(tuple(shown), complaint))

    def _read(self) -> tuple[list[RecentFile], str]:
        """The list as it is now: another window may have written to it."""
        path = self._folder / LIST
        try:
            if not path.is_file():
                return [], ""
            if path.stat().st_size > MAX_LIST_BYTES:
                raise ValueError("too large")
            return read_list(path.read_text("utf-8")), ""
        except (OSError, ValueError, RecursionError) as error:
            LOG.warning("recent files: %s", error)
            return [], f"The list of recent files could not be read ({error}): it begins anew."

    def _picture(self, path: Path) -> ByteArray | None:
        if path not in self._pictures:
            with suppress(*DAMAGE):
                place = self._place_of(path)
                if place.is_file() and place.stat().st_size <= MAX_PICTURE_BYTES:
                    image = decode_png(place.read_bytes(), place.name)
                    self._pictures[path] = fit_photo(image, PICTURE_PX)
        return self._pictures.get(path)

    def _place_of(self, path: Path) -> Path:
        digest = hashlib.sha256(str(path).encode("utf-8", "surrogatepass")).hexdigest()
        return self._folder / PICTURES / f"{digest[:24]}.png"


def read_list(text: str) -> list[RecentFile]:
    """Reads the list; entries that are malformed or occur twice are left out.

    Raises:
        ValueError: when it is no list at all.
    """
    record = json.loads(text)
    entries = record.get("files") if isinstance(record, dict) else None
    if not isinstance(entries, list):
        raise ValueError("it is not a list")
    files: dict[Path, RecentFile] = {}
    for entry in entries:
        file = _read_entry(entry)
        if file is not None and len(files) < MAX_FILES:
            files.setdefault(file.path, file)
    return list(files.values())


def _read_entry(entry: object) -> RecentFile | None:
    path, opened_s = (entry.get("path"), entry.get("opened_s")) if isinstance(entry, dict) else (None, None)
    if not isinstance(path, str) or not 0 < len(path) <= MAX_PATH or "\0" in path:
        return None
    if isinstance(opened_s, bool) or not isinstance(opened_s, int | float) or not 0 <= opened_s <= LATEST_S:
        return None
    return RecentFile(Path(path), float(opened_s)) if Path(path).is_absolute() else None


def _is_there(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
