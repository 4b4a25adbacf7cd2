"""A film, or a large picture, made by ``wzviewer render`` in a process of its own.

So the frame loop never waits for it: a thread writes the scene and the camera path to a temporary
folder, follows the progress of the process, and ends it when the user cancels.  The film grows in a
hidden folder beside its place and is moved there once it is whole, so that a cancelled one, or one
whose process was killed, leaves nothing.
"""

import json
import math
import queue
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from wzviewer.app.look import Look
from wzviewer.commands.cameras import FPS
from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.core.files import save_scene
from wzviewer.core.records import camera_to_json
from wzviewer.core.scene import Scene
from wzviewer.core.types import DoubleArray
from wzviewer.errors import WzError

SECONDS_PER_LEVEL = 2.0  # for every x8 of magnification
SHORTEST_S, HOLD_S = 2.0, 0.8
STEP = re.compile(r"frame (\d+) of (\d+)")
END_WAIT_S = 2.0
Request = Callable[[Path, Path], list[str]]  # a folder to use, and where to write: the command line


@dataclass(frozen=True)
class FilmNews:
    """What happened to a film: ``fraction`` of it, and at its end the reason why there is none."""

    fraction: float
    is_over: bool = False
    why_not: str = ""
    is_cancelled: bool = False


class Filmer(Protocol):
    """Makes one film or picture at a time."""

    def start(
        self, scene: Scene, cameras: Sequence[Camera], path: Path, look: Look, fps: float = FPS
    ) -> None:
        """Begins; `poll` tells how it goes."""

    def start_picture(
        self, scene: Scene, camera: Camera, path: Path, look: Look, transparent: bool = False
    ) -> None:
        """Begins a picture; `poll` tells how it goes."""

    def cancel(self) -> None:
        """Ends it without a film."""

    def poll(self) -> list[FilmNews]:
        """Returns what happened since the last call."""
        ...

    def close(self) -> None:
        """Ends whatever runs."""


def natural_film_s(home: Camera, here: Camera) -> float:
    """Returns the length of a film from the photo to the view: 2 s for every x8, and the rests."""
    ratio = here.focal_px / here.width * home.width / home.focal_px
    folds = abs(math.log(ratio)) / math.log(ZOOM_FACTOR)
    return max(SHORTEST_S, SECONDS_PER_LEVEL * folds) + 2 * HOLD_S


def film_cameras(
    home: Camera,
    here: Camera,
    focus: DoubleArray,
    size: tuple[int, int],
    fps: float = FPS,
    duration_s: float | None = None,
) -> list[Camera]:
    """Returns the way from the photo to the view: even in log focal length, resting at both ends.

    Args:
        home: the whole picture.
        here: the view.
        focus: (3,) world point that the view looks at.
        size: width and height of the film, px; odd ones lose their last row or column.
        fps: frames per second.
        duration_s: of the film; None is what suits it.
    """
    start, end = home.resized(*size), here.resized(*size)
    natural_s = natural_film_s(start, end)
    count = max(round((duration_s or natural_s) * fps), 2)
    way_s = natural_s - 2 * HOLD_S
    shares = [min(max((natural_s * i / (count - 1) - HOLD_S) / way_s, 0.0), 1.0) for i in range(count)]
    return [navigation.interpolated(start, end, focus, s * s * (3.0 - 2.0 * s)) for s in shares]


def snapshot(scene: Scene) -> Scene:
    """Returns the finished levels as a scene of their own: the app's may grow meanwhile."""
    copy = Scene()
    for level in scene:
        if scene.is_committed(level.index):
            copy.append(level)
            copy.commit(level.index)
    for index, mark in scene.marks.items():
        if index < len(copy):
            copy.set_mark(index, mark)
    return copy


class FilmProcess:
    """A `Filmer` that runs the command line."""

    def __init__(self) -> None:
        self._news: queue.SimpleQueue[FilmNews] = queue.SimpleQueue()
        self._process: subprocess.Popen[str] | None = None
        self._thread: threading.Thread | None = None
        self._cancelled = threading.Event()

    def start(
        self, scene: Scene, cameras: Sequence[Camera], path: Path, look: Look, fps: float = FPS
    ) -> None:
        """Begins; `poll` tells how it goes."""
        copy, film = snapshot(scene), list(cameras)
        self._begin(path, lambda folder, made: write_request(folder, copy, film, made, look, fps))

    def start_picture(
        self, scene: Scene, camera: Camera, path: Path, look: Look, transparent: bool = False
    ) -> None:
        """Begins a picture; `poll` tells how it goes."""
        copy = snapshot(scene)
        self._begin(path, lambda folder, made: picture_request(folder, copy, camera, made, look, transparent))

    def cancel(self) -> None:
        """Ends it without a film."""
        self._cancelled.set()
        if self._process is not None:
            self._process.terminate()

    def poll(self) -> list[FilmNews]:
        """Returns what happened since the last call."""
        news = []
        with suppress(queue.Empty):
            while True:
                news.append(self._news.get_nowait())
        return news

    def close(self) -> None:
        """Ends whatever runs."""
        self.cancel()
        if self._thread is not None:
            self._thread.join(END_WAIT_S)

    def _begin(self, path: Path, request: Request) -> None:
        self._cancelled.clear()
        self._thread = threading.Thread(target=self._make, args=(path, request), daemon=True)
        self._thread.start()

    def _make(self, path: Path, request: Request) -> None:
        why_not = ""
        try:
            with (
                tempfile.TemporaryDirectory(prefix="wzviewer-film-") as folder,
                tempfile.TemporaryDirectory(
                    prefix=".wzviewer-film-", dir=path.parent, ignore_cleanup_errors=True
                ) as beside,
            ):
                made = Path(beside) / path.name
                why_not = self._run(request(Path(folder), made))
                if not why_not and not self._cancelled.is_set():
                    made.replace(path)
        except (OSError, WzError) as error:
            why_not = str(error)
        self._news.put(FilmNews(1.0, True, why_not, self._cancelled.is_set()))

    def _run(self, command: list[str]) -> str:
        """Follows the command; returns why it failed, or nothing."""
        if self._cancelled.is_set():
            return "cancelled"
        last = ""
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=pipe, text=True) as process:
            self._process = process
            if self._cancelled.is_set():  # asked for before there was a process to end
                process.terminate()
            assert process.stderr is not None  # it was asked for
            for line in process.stderr:
                found = STEP.search(line)
                if found:
                    self._news.put(FilmNews(int(found[1]) / max(int(found[2]), 1)))
                last = line.strip() or last
        self._process = None
        return last.removeprefix("error: ") if process.returncode else ""


def write_request(
    folder: Path, scene: Scene, cameras: list[Camera], path: Path, look: Look, fps: float = FPS
) -> list[str]:
    """Writes scene and camera path into a folder; returns the command line that makes the film.

    Raises:
        OutputError: when the folder cannot be written.
    """
    save_scene(scene, folder / "scene.wz")
    frames = {"fps": fps, "frames": [camera_to_json(camera) for camera in cameras]}
    (folder / "path.json").write_text(json.dumps(frames), "utf-8")
    command = [sys.executable, "-m", "wzviewer", "render", str(folder / "scene.wz"), "-o", str(path)]
    command += ["--size", f"{cameras[0].width}x{cameras[0].height}", "--fps", f"{fps:g}"]
    return [*command, "--path", str(folder / "path.json"), *look_options(look)]


def picture_request(
    folder: Path, scene: Scene, camera: Camera, path: Path, look: Look, transparent: bool
) -> list[str]:
    """Writes a scene into a folder; returns the command line that makes a picture.

    Raises:
        OutputError: when the folder cannot be written.
    """
    save_scene(scene, folder / "scene.wz")
    command = [sys.executable, "-m", "wzviewer", "render", str(folder / "scene.wz"), "-o", str(path)]
    command += ["--camera", json.dumps(camera_to_json(camera)), *look_options(look)]
    return [*command, "--transparent"] if transparent else command


def look_options(look: Look) -> list[str]:
    """Returns the options of ``wzviewer render`` that draw a scene as the window does."""
    options = ["--blend", look.blend] if look.blend != "transmittance" else []
    options += [] if look.modulation else ["--no-modulation"]
    return options + ([] if look.merged else ["--no-antialias"])
