"""The words that the worker understands, kept between runs: it takes seconds until it says them itself.

One small JSON file in the user's cache, of one version and one synthesizer; any other, or a damaged one,
counts as none.  It is read once, before the first frame, and written by a thread.
"""

import json
import logging
import threading
from pathlib import Path
from typing import Protocol

from wzviewer import __version__
from wzviewer.core.photos import whole_file
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.errors import WzError

LOG = logging.getLogger(__name__)
MAX_FILE_BYTES = 1 << 17  # the built-in words take 7 kB
MAX_WORDS = 2000  # of one kind; the built-in synthesizer has 148 at most
MAX_WORD_CHARS = 60


class WordStore(Protocol):
    """Where the words live between runs."""

    def load(self) -> Vocabulary:
        """Returns the words that were kept; none when there are none."""
        ...

    def keep(self, vocabulary: Vocabulary) -> None:
        """Keeps what the worker has just said."""

    def close(self) -> None:
        """Waits until it is written."""


class NoWords:
    """Keeps nothing."""

    def load(self) -> Vocabulary:
        """Returns no words."""
        return Vocabulary()

    def keep(self, vocabulary: Vocabulary) -> None:
        """Does nothing."""

    def close(self) -> None:
        """Does nothing."""


class WordFile:
    """The words in a JSON file.

    Args:
        path: of the file; its folder is made when needed.
        synthesizer: whose words they are.
        version: of the program that knows them.
    """

    def __init__(self, path: Path, synthesizer: str = "builtin", version: str = __version__) -> None:
        self.path, self._origin = path, {"version": version, "synthesizer": synthesizer}
        self._kept = Vocabulary()
        self._thread: threading.Thread | None = None

    @classmethod
    def of_user(cls, synthesizer: str) -> "WordFile":
        """Returns the file in the user's cache folder."""
        from platformdirs import user_cache_path

        return cls(user_cache_path("wzviewer", appauthor=False) / "words.json", synthesizer)

    def load(self) -> Vocabulary:
        """Reads the file; what is no word is left out."""
        try:
            if not self.path.is_file() or self.path.stat().st_size > MAX_FILE_BYTES:
                return Vocabulary()
            record = json.loads(self.path.read_text("utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            LOG.warning("words: %s", error)
            return Vocabulary()
        is_ours = isinstance(record, dict) and {k: record.get(k) for k in self._origin} == self._origin
        words = record.get("words") if is_ours else None
        self._kept = read_words(words) if isinstance(words, dict) else Vocabulary()
        return self._kept

    def keep(self, vocabulary: Vocabulary) -> None:
        """Has the file written, unless it says so already."""
        if vocabulary == self._kept:
            return
        self.close()  # of a worker that was replaced: written long ago
        self._kept = vocabulary
        self._thread = threading.Thread(target=self._write, args=(vocabulary,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Waits until it is written."""
        if self._thread is not None:
            self._thread.join(10.0)

    def _write(self, vocabulary: Vocabulary) -> None:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self.path) as file:
                file.write(json.dumps({**self._origin, "words": vocabulary.to_json()}).encode())
        except (OSError, WzError) as error:  # the worker says them again the next time
            LOG.warning("words: %s", error)


def read_words(record: dict[str, object]) -> Vocabulary:
    """Restores a vocabulary from a file that anyone may have written: short printable words, not too many."""
    lists = {name: words for name, words in record.items() if isinstance(words, list)}
    good = {name: [w for w in words if _is_word(w)][:MAX_WORDS] for name, words in lists.items()}
    return Vocabulary.from_json(good)


def _is_word(word: object) -> bool:
    return (
        isinstance(word, str) and 0 < len(word.strip()) == len(word) <= MAX_WORD_CHARS and word.isprintable()
    )
