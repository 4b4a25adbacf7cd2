"""What the app needs of the outside, as small protocols, so that each has a stand-in for tests."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from imgui_bundle import imgui

from wzviewer.app.errands import AtOnce, Errands
from wzviewer.app.filming import Filmer, FilmProcess
from wzviewer.app.journal import Journal, NoJournal
from wzviewer.app.logbook import Logbook
from wzviewer.app.look import Look
from wzviewer.app.recents import NoRecents, RecentStore
from wzviewer.app.settings import NoStore, Store
from wzviewer.app.words import NoWords, WordStore
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.worker.client import CANCEL_GRACE_S, Event

PLAIN = Look()


class Client(Protocol):
    """Thread 2 as the app sees it; `wzviewer.worker.client.WorkerClient`."""

    def start(self) -> None:
        """Starts the worker process."""

    def close(self) -> None:
        """Ends it."""

    def load(self, scene: Scene) -> None:
        """Takes over a scene."""

    def reconstruct(self, image: ByteArray, seed: int = 0, photo: ByteArray | None = None) -> int:
        """Asks for E_0 from a photo in its working size, and with more pixels if it has them."""
        ...

    def synthesize(
        self,
        parent: int,
        camera: Camera,
        prompt: str = "",
        seed: int = 0,
        cutout: ByteArray | None = None,
        beside: Sequence[int] = (),
    ) -> int:
        """Asks for a further level, perhaps with a picture (h, w, 4) put into it, over others beside it."""
        ...

    def cancel(self, grace_s: float = CANCEL_GRACE_S) -> None:
        """Stops the running request; a worker that does not hear of it within a time is replaced."""

    def poll(self, budget_s: float = 0.002) -> list[Event]:
        """Returns what happened."""
        ...


class Picture(Protocol):
    """A rendered picture, still on the GPU; valid until the next one."""

    def present_to(self, framebuffer: Any, viewport: tuple[int, int, int, int] | None = None) -> None:  # noqa: ANN401
        """Draws it into a framebuffer, stretched to a viewport (x, y, width, height) in px."""

    def read_color8(self) -> ByteArray:
        """Returns (h, w, 3) uint8."""
        ...


class SceneRenderer(Protocol):
    """Lines 6-7 of Algorithm 1, as the app sees them.

    Attributes:
        target_s: time that a picture in motion may take.
    """

    target_s: float

    @property
    def is_settled(self) -> bool:
        """Whether the last picture is the exact one for its camera."""
        ...

    @property
    def gpu_s(self) -> float:
        """What the graphics card itself took for a recent picture, s; 0 while unknown."""
        ...

    def sync(self, scene: Scene) -> bool:
        """Takes over some of what changed in the scene; returns whether that was all."""
        ...

    def draw(
        self, camera: Camera, fraction: float = 1.0, is_moving: bool = False, look: Look = PLAIN
    ) -> Picture:
        """Renders the scene at a fraction of the resolution; in motion less exactly."""
        ...

    def picture(self, camera: Camera, look: Look = PLAIN, transparent: bool = False) -> ByteArray:
        """Renders at full quality and any size: (h, w, 3) uint8, or (h, w, 4) without a background."""
        ...

    def pick(self, camera: Camera, x_px: float, y_px: float) -> tuple[float, int] | None:
        """Returns depth in world units and level index at a pixel; None on emptiness."""
        ...

    def statistics(self) -> dict[str, str]:
        """Returns lines for the statistics panel."""
        ...

    def close(self) -> None:
        """Frees the GPU."""


class Dialogs(Protocol):
    """File dialogs that do not stop the frame loop."""

    def ask_open(self, folder: str) -> bool:
        """Shows the open dialog, in a folder; False when the system has none."""
        ...

    def ask_save(self, suggestion: str) -> bool:
        """Shows the save dialog; False when the system has none."""
        ...

    def ask_picture(self, suggestion: str) -> bool:
        """Shows the dialog for a picture; False when the system has none."""
        ...

    def ask_film(self, suggestion: str) -> bool:
        """Shows the dialog for a film; False when the system has none."""
        ...

    def ask_path(self, suggestion: str, is_opening: bool) -> bool:
        """Shows the dialog for a camera path; to open one, in a folder.  False when the system has none."""
        ...

    def poll(self) -> Sequence[tuple[str, Path]]:
        """Returns the answers given since the last call: (open, save or picture; path)."""
        ...


@dataclass(frozen=True, eq=False)
class Services:
    """The outside world of the app."""

    client: Client
    renderer: SceneRenderer
    dialogs: Dialogs
    store: Store = field(default_factory=NoStore)
    journal: Journal = field(default_factory=NoJournal)
    filmer: Filmer = field(default_factory=FilmProcess)
    recents: RecentStore = field(default_factory=NoRecents)
    words: WordStore = field(default_factory=NoWords)
    log: Logbook = field(default_factory=Logbook)
    errands: Errands = field(default_factory=AtOnce)
    copy: Callable[[str], None] = imgui.set_clipboard_text
