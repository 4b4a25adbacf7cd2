"""Take the README's pictures of the window, off screen, on the demo scene.

    wzviewer demo -> demo.wz ─┐
                              ├─> App in an OffscreenWindow, moved as a user would ─> readme/*.webp
    vocabulary of prompts ────┘

Run `wzviewer demo --no-window` and then
`python assets/make_readme_pictures.py wzviewer-demo/demo.wz`.  The app is the real one; only the worker
is left out, so that nothing is made while the pictures are taken.
"""

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.look import Look
from wzviewer.app.loop import App
from wzviewer.app.recents import RecentFolder
from wzviewer.app.settings import Settings
from wzviewer.app.window import OffscreenWindow
from wzviewer.core.camera import Camera
from wzviewer.core.files import load_scene
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.worker.client import Event, WorkerStarted
from wzviewer.worker.models.builtin.objects.grammar import vocabulary

FOLDER = Path(__file__).parent / "readme"
SIZE_PX = (1280, 800)
QUALITY = 84  # of WebP, percent
SETTLE_FRAMES, MOST_FRAMES = 30, 2000


class Worker:
    """Thread 2 that knows its words and makes nothing."""

    def __init__(self) -> None:
        self._events: list[Event] = []

    def start(self) -> None:
        """Says which words it knows."""
        self._events.append(WorkerStarted(0, vocabulary()))

    def close(self) -> None:
        """Does nothing."""

    def load(self, scene: Scene) -> None:
        """Does nothing."""

    def reconstruct(self, image: ByteArray, seed: int = 0) -> int:
        """Is never asked."""
        raise RuntimeError("no photo is opened here")

    def synthesize(self, parent: int, camera: Camera, prompt: str = "", seed: int = 0) -> int:
        """Is never asked: auto detail is off."""
        raise RuntimeError("no level is made here")

    def cancel(self) -> None:
        """Does nothing."""

    def poll(self, budget_s: float = 0.002) -> list[Event]:
        """Returns what was not yet told."""
        events, self._events = self._events, []
        return events


class Stage:
    """The app, and what is done to it for a picture."""

    def __init__(self, scene: Path, recents: RecentFolder) -> None:
        self.scene = scene
        self.app = App(OffscreenWindow(SIZE_PX), Worker(), recents=recents)
        settings = Settings(auto_detail=False, hint_seen=True)
        self.app.state = replace(self.app.state, settings=settings)

    def run_until(self, holds: Callable[[App], bool]) -> None:
        """Lets time pass until something holds, and the picture is the exact one."""
        for _ in range(MOST_FRAMES):
            self.app.run(None, 1)
            is_resting = not self.app.state.is_moving and self.app.services.renderer.is_settled
            if is_resting and holds(self.app):
                break
        self.app.run(None, SETTLE_FRAMES)

    def open(self) -> None:
        """Opens the scene, which is read beside the frames."""
        self.app.do(cmd.Open(self.scene))
        self.run_until(lambda app: app.state.errand is None and len(app.state.scene) > 0)

    def go_to(self, level: int, notches: float = 0.0) -> None:
        """Flies to a level, and further by turns of the wheel."""
        self.app.do(cmd.GoToLevel(level))
        self.run_until(lambda app: app.state.view.flight is None)
        if notches:
            self.app.do(cmd.Zoom(SIZE_PX[0] / 2, SIZE_PX[1] / 2, notches))
            self.run_until(lambda app: app.state.view.spring.is_resting)
        self.app.state = replace(self.app.state, toasts=())

    def type(self, text: str) -> None:
        """Types into the line that has the cursor."""
        self.app.run(None, 3)
        imgui.get_io().add_input_characters_utf8(text)
        self.app.run(None, 3 + len(text))

    def take(self, name: str) -> None:
        """Writes what the window shows."""
        self.app.run(None, SETTLE_FRAMES)
        image = cv2.cvtColor(self.app.window.read_pixels(), cv2.COLOR_RGB2BGR)
        path = FOLDER / f"{name}.webp"
        cv2.imwrite(str(path), image, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
        print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


def start_page(stage: Stage) -> None:
    """What one sees first, with files of before."""
    stage.run_until(lambda app: bool(app.state.recents.files))
    stage.take("start")


def prompt(stage: Stage) -> None:
    """Deep in the scene, a word half typed."""
    stage.go_to(2, notches=-2.0)  # the whole ladybug below the toolbar
    stage.app.do(cmd.FocusPrompt())
    stage.type("a blue b")
    stage.take("prompt")


def behind(stage: Stage) -> None:
    """Which level draws what, between two of them."""
    stage.open()
    stage.go_to(1, notches=-6.0)
    stage.app.do(cmd.Toggle("statistics"), cmd.SetLook(Look("levels")))
    stage.take("behind")
    stage.app.do(cmd.Toggle("statistics"), cmd.SetLook(Look()))


def timeline(stage: Stage) -> None:
    """A film of four views, one of them selected."""
    stage.open()
    stage.app.do(cmd.Toggle("timeline"))
    for level in range(4):
        stage.go_to(level)
        stage.app.do(cmd.AddKey())
        stage.app.run(None, 5)
    stage.go_to(1)
    stage.take("timeline")
    stage.app.do(cmd.Toggle("timeline"))


def recent_files(scene: Scene, folder: Path) -> RecentFolder:
    """A list of files as it may be after an evening, with pictures of the demo's levels."""
    recents = RecentFolder(folder / "state")
    names = {0: "meadow.png", 1: "butterfly.wz", 2: "ladybug.wz", 3: "ladybug, closer.wz"}
    for level in scene:
        path = folder / names.get(level.index, f"level {level.index}.wz")
        path.touch()
        recents.note(path, level.image)
    recents.wait()
    return recents


def main() -> None:
    """Takes all pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("scene", type=Path, help="the demo.wz that `wzviewer demo` has written")
    scene = parser.parse_args().scene
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(scene, recent_files(load_scene(scene), Path(folder)))
        for picture in (start_page, behind, timeline, prompt):
            picture(stage)
        stage.app.close()


if __name__ == "__main__":
    main()
