"""Stand-ins for the outside of the app: a worker that answers at once, small levels, no dialogs."""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from wzviewer.app.history import restored
from wzviewer.app.look import Look
from wzviewer.app.services import PLAIN, Services
from wzviewer.app.state import AppState, View
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene, coverage_for
from wzviewer.core.surfels import Surfels
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.worker import client as ev

WIDTH, HEIGHT = 136, 90
WORDS = Vocabulary(
    objects=("ladybug", "butterfly", "blue morpho", "beetle", "bird"),
    qualities=("blue", "two", "tiny"),
    places=("leaf", "left"),
    prepositions=("on",),
    fillers=("a", "the"),
)


def checker(width: int, height: int, seed: int = 0, cells: int = 8) -> np.ndarray:
    """A coloured checkerboard (h, w, 3) uint8 that is unlike any other seed's."""
    rng = np.random.default_rng(seed)
    colors = rng.integers(40, 230, (cells, cells, 3))
    rows = np.arange(height) * cells // height
    columns = np.arange(width) * cells // width
    return colors[rows[:, None], columns[None, :]].astype(np.uint8)


def make_level(
    scene: Scene, parent: int | None, camera: Camera, image: np.ndarray, prompt: str = "", dented: bool = True
) -> Level:
    """A level whose surface is a plane with a dent, one surfel a pixel."""
    height, width = image.shape[:2]
    frame = LevelFrame.of_camera(camera, 1.0)
    y, x = np.mgrid[0:height, 0:width] + 0.5
    dent = 6.0 * np.exp(-((x - width / 2) ** 2 + (y - height / 2) ** 2) / (0.02 * width**2))
    relief = (dent if dented else 0.0 * dent).astype(np.float32)
    z = 1.0 + frame.unit * relief.astype(np.float64)
    world = np.stack([(x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z], -1)
    centre = np.array([(width / 2 - camera.cx) / camera.fx, (height / 2 - camera.cy) / camera.fy, 1.0])
    means = ((world - centre) / frame.unit).reshape(-1, 3).astype(np.float32)
    n = len(means)
    surfels = Surfels(
        means,
        np.tile(np.float32([1, 0, 0, 0]), (n, 1)),
        np.full((n, 2), 0.55, np.float32),
        np.full(n, 0.99, np.float32),
        image.reshape(-1, 3).astype(np.float32) / np.float32(255),
        (z / z.mean()).reshape(-1).astype(np.float32),
        coverage_for(scene, parent, camera, frame, means),
    )
    index = len(scene) if parent is not None else 0
    return Level(index, parent, camera, frame, surfels, image, relief, prompt)


def make_scene(num_levels: int = 1, width: int = WIDTH, height: int = HEIGHT) -> Scene:
    """A chain of finished levels about the middle of the picture."""
    scene = Scene()
    camera = Camera.initial(width, height)
    for index in range(num_levels):
        parent = index - 1 if index else None
        prompt = f"thing {index}" if index else ""
        scene.append(make_level(scene, parent, camera, checker(width, height, index), prompt))
        scene.commit(index)
        camera = camera.zoomed_to_region(0.5, 0.5, 8.0)
    return scene


class FakeClient:
    """Thread 2 without a process: every poll brings the next event.

    Attributes:
        calls: what was asked for, by name.
        refuses: prompts that are refused.
        fails: whether requests end in a fault.
    """

    def __init__(self) -> None:
        self.calls: list[tuple[object, ...]] = []
        self.seeds: list[int] = []
        self.beside: list[list[int]] = []
        self.cutouts: list[np.ndarray] = []
        self.refuses: set[str] = set()
        self.fails = False
        self.is_busy = False
        self.grace_s = 0.0
        self._scene = Scene()
        self._queue: deque[ev.Event] = deque()
        self._request_id = 0

    def start(self) -> None:
        self.calls.append(("start",))
        self._queue.append(ev.WorkerStarted(0))

    def close(self) -> None:
        self.calls.append(("close",))

    def load(self, scene: Scene) -> None:
        self.calls.append(("load", len(scene)))
        self._scene = Scene()
        for level in scene:
            self._scene.append(level)

    def reconstruct(self, image: np.ndarray, seed: int = 0, photo: np.ndarray | None = None) -> int:
        self.calls.append(("reconstruct", image.shape))
        request_id = self._begin()
        self._scene = Scene()
        camera = Camera.initial(image.shape[1], image.shape[0])
        return self._make(request_id, make_level(self._scene, None, camera, image))

    def synthesize(
        self,
        parent: int,
        camera: Camera,
        prompt: str = "",
        seed: int = 0,
        cutout: np.ndarray | None = None,
        beside: Sequence[int] = (),
    ) -> int:
        self.calls.append(("synthesize", parent, prompt))
        self.beside.append(list(beside))
        self.seeds.append(seed)
        self.cutouts += [] if cutout is None else [cutout]
        request_id = self._begin()
        if prompt in self.refuses:
            drop = ev.LevelDropped(
                self._request_id, "prompt", f"no {prompt} here", "Try a bird.", bad_input=True
            )
            self._queue.append(drop)
            return request_id
        image = checker(camera.width, camera.height, len(self._scene) + 7)
        level = make_level(self._scene, parent, camera, image, prompt)
        return self._make(request_id, replace(level, seed=seed))

    def cancel(self, grace_s: float = 0.7) -> None:
        self.calls.append(("cancel",))
        self.grace_s = grace_s
        if self._queue and len(self._scene):
            self._scene.abort(len(self._scene) - 1)
        self._queue.clear()
        self._queue.append(ev.LevelDropped(self._request_id, "generation", "cancelled", cancelled=True))

    def poll(self, budget_s: float = 0.002) -> list[ev.Event]:
        events = [self._queue.popleft()] if self._queue else []
        while self._queue and isinstance(self._queue[0], ev.WorkerLost):
            events.append(self._queue.popleft())  # in the same breath as the request that it took along
        if any(isinstance(e, ev.LevelFinished | ev.LevelDropped) for e in events):
            self.is_busy = False
        return events

    def _begin(self) -> int:
        if self.is_busy:
            raise RuntimeError("a request is running")
        self.is_busy = True
        self._request_id += 1
        return self._request_id

    def lose(self) -> None:
        """The worker dies."""
        self._queue.clear()
        if self._request_id:
            self._queue.append(ev.LevelDropped(self._request_id, "worker", "the worker was killed"))
        self._queue.append(ev.WorkerLost(0, "was killed by signal 9"))

    def _make(self, r: int, level: Level) -> int:
        if self.fails:
            self._queue.append(ev.LevelDropped(r, "worker", "out of memory"))
            return r
        self._scene.append(level)
        coarse = level.with_surfels(level.surfels.with_(colors=0.5 + 0.5 * level.surfels.colors))
        self._queue += [
            ev.StageProgressed(r, 1, "new scale image", 0.1),
            ev.LevelPreviewed(r, coarse, 0),
            ev.StageProgressed(r, 3, "surfels", 0.5),
            ev.LevelPreviewed(r, level, 1),
            ev.StageProgressed(r, 5, "optimisation", 0.8),
            ev.LevelFinished(r, level),
        ]
        return r


class FakeRenderer:
    """Sees a plane at depth 1 everywhere and draws nothing."""

    target_s = 1 / 60
    gpu_s = 0.0
    is_settled = True

    def sync(self, scene: Scene) -> bool:
        return True

    def draw(
        self, camera: Camera, fraction: float = 1.0, is_moving: bool = False, look: Look = PLAIN
    ) -> "FakePicture":
        return FakePicture(camera.width, camera.height)

    def picture(self, camera: Camera, look: Look = PLAIN, transparent: bool = False) -> np.ndarray:
        colors = checker(camera.width, camera.height)
        alpha = np.full((camera.height, camera.width, 1), 128, np.uint8)
        return np.concatenate([colors, alpha], -1) if transparent else colors

    def pick(self, camera: Camera, x_px: float, y_px: float) -> tuple[float, int] | None:
        return 1.0, 0

    def statistics(self) -> dict[str, str]:
        return {"Surfels drawn": "0"}

    def close(self) -> None:
        pass


class FakePicture:
    def __init__(self, width: int, height: int) -> None:
        self.shape = (height, width)

    def present_to(self, framebuffer: object, viewport: object = None) -> None:
        pass

    def read_color8(self) -> np.ndarray:
        return checker(self.shape[1], self.shape[0])


class FakeDialogs:
    """A desktop without dialogs, or one that gives prepared answers."""

    def __init__(self, answers: list[tuple[str, Path]] | None = None) -> None:
        self.answers = answers

    def ask_open(self, folder: str) -> bool:
        return self.answers is not None

    def ask_save(self, suggestion: str) -> bool:
        return self.answers is not None

    def ask_picture(self, suggestion: str) -> bool:
        return self.answers is not None

    def ask_film(self, suggestion: str) -> bool:
        return self.answers is not None

    def ask_path(self, suggestion: str, is_opening: bool) -> bool:
        return self.answers is not None

    def poll(self) -> list[tuple[str, Path]]:
        answers, self.answers = self.answers or [], [] if self.answers is not None else None
        return answers


def fake_services(**others: object) -> Services:
    return Services(FakeClient(), FakeRenderer(), FakeDialogs(), **others)


def state_with(scene: Scene, width: int = 640, height: int = 420) -> AppState:
    """A document that is open and saved."""
    view = View.at_home(scene[0].camera, width, height)
    state = AppState(view, scene, name="fake.wz")
    return replace(state, history=restored(scene), saved=(state.num_finished, scene.marks))
