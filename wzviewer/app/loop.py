"""The frame loop: Algorithm 1, lines 1-9.  Thread 2 (lines 10-32) is `wzviewer.worker`."""

import os
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from imgui_bundle import imgui

from wzviewer.app import commands as cmd
from wzviewer.app.answers import answered
from wzviewer.app.apply import apply, drain, preview, tick
from wzviewer.app.dialogs import SystemDialogs
from wzviewer.app.documents import demo_photo
from wzviewer.app.drawing import BACKGROUND, SceneDrawing
from wzviewer.app.errands import OnThread
from wzviewer.app.input import Hand, read_input, typed_ahead
from wzviewer.app.journal import Journal, JournalFolder, NoJournal
from wzviewer.app.layout import Rect, arrange
from wzviewer.app.pacing import SOFTWARE_TARGET_S, Pace, wait_s
from wzviewer.app.panels.screen import draw_screen
from wzviewer.app.panels.surface import Ui
from wzviewer.app.panels.timeline import foot_height
from wzviewer.app.places import shows_photo
from wzviewer.app.prompting import with_vocabulary
from wzviewer.app.recents import NoRecents, RecentFolder, RecentStore
from wzviewer.app.recovery import ask_to_recover
from wzviewer.app.services import Client, SceneRenderer, Services
from wzviewer.app.settings import NoStore, SettingsFile, Store
from wzviewer.app.state import empty_state
from wzviewer.app.theme import BODY_PT, PALETTES, restyle
from wzviewer.app.thumbnails import Thumbnails
from wzviewer.app.viewing import advance, refocus
from wzviewer.app.window import GlfwWindow, OffscreenWindow, Pulse, Window
from wzviewer.app.words import NoWords, WordFile, WordStore
from wzviewer.core.photos import encode_png, fit_photo, load_photo, whole_file
from wzviewer.core.types import ByteArray
from wzviewer.errors import WzError
from wzviewer.worker.client import WorkerClient

SMALLEST_PT = (480.0, 360.0)  # window that all panels fit into
SHOWN_FRAMES = 120  # in the plot of frame times
POLL_BUDGET_S = 0.004  # of a frame, for what the worker sends


class App:
    """The window, the scene and the worker, frame by frame.

    Args:
        window: to draw in.
        client: Thread 2.
        renderer: of the scene; a `SceneDrawing` when None.
        store: where settings are kept; None keeps none.
        journal: where finished levels are kept until they are saved; None keeps none.
        recents: where the files opened lately are kept; None keeps none.
        words: where the worker's vocabulary is kept; None keeps none.
        reopen: opens another window, of a size, once the graphics card has been reset; None ends then.
    """

    def __init__(
        self,
        window: Window,
        client: Client,
        renderer: SceneRenderer | None = None,
        store: Store | None = None,
        journal: Journal | None = None,
        recents: RecentStore | None = None,
        words: WordStore | None = None,
        *,
        reopen: Callable[[tuple[int, int]], Window] | None = None,
    ) -> None:
        # Before the first kernel: threads that spin for each other keep the cores from frames and worker.
        os.environ.setdefault("OMP_WAIT_POLICY", "passive")
        client.start()  # at once: it takes seconds until it is ready
        self.window, self._reopen = window, reopen
        store = store or NoStore()
        settings, complaint = store.load()
        renderer = renderer or SceneDrawing(window.context, rasterizer=settings.rasterizer)
        kept = (store, journal or NoJournal())
        services = Services(client, renderer, SystemDialogs(), *kept, recents=recents or NoRecents())
        self.services = replace(services, errands=OnThread(), words=words or NoWords())
        self.state = replace(empty_state(*window.size_px), settings=settings)
        self.state = with_vocabulary(self.state, self.services.words.load())
        if complaint:
            self.state = self.state.with_toast(complaint, "error")
        self.state = ask_to_recover(self.services, self.state)
        self.pace = Pace(target_s=self.services.renderer.target_s)
        self.frame_s = 0.0  # what the last new picture took
        self._painted: object = None  # the last picture
        self._times_ms: deque[float] = deque(maxlen=SHOWN_FRAMES)
        self._hand = Hand()
        self._thumbnails = Thumbnails(window.context)
        self._backdrop: ByteArray | None = None
        self._path: Path | None = None
        self._had_leftover = self.state.leftover is not None
        self._title = ""
        self._began_s = 0.0  # of the last frame
        self._style = ("dark", window.scale)

    def run(self, path: Path | None = None, frames: int | None = None) -> None:
        """Algorithm 1, lines 1-9.

        Args:
            path: photo or scene to begin with.
            frames: stop after so many, not counting those while a file is read or written; None runs
                until the window is closed.
        """
        self._path = path or self._path
        self._open_first()  # lines 1-3: E_0 <- ReconstructScene(I_0, C_0), C_render <- C_0
        count = 0
        while not self.state.is_closing and (frames is None or count < frames):  # lines 4, 5 and 9
            self._renew()
            self._restyle()
            pulse = self.window.begin(self._wait_s())
            self._began_s = time.perf_counter()
            self._tick(pulse)  # line 32, seen from here: E_{i+1} has come; and the motions go on
            commands = self._panels()
            self.window.draw(self._paint)  # lines 6-7: O_render <- Render(E_0 .. E_i, C_render)
            self.window.show()
            self.do(*commands)  # line 8: C_render <- UserCameraControl(), and all else that was asked
            count += self.state.errand is None

    def _open_first(self) -> None:
        """Opens what the app was started with; the question about a crash comes first."""
        if self._path is None or self.state.panels.dialog == "recover" or self.state.errand is not None:
            return
        path, self._path = self._path, None
        if not (self._had_leftover and self.state.has_document):  # else that was recovered
            self.do(cmd.Open(path))

    def do(self, *commands: cmd.Command) -> None:
        """Carries out commands."""
        self.state = apply(self.services, self.state, commands)

    def close(self) -> None:
        """Ends the worker and frees everything."""
        self.services.errands.close()  # what is being saved is saved
        self.services.client.close()
        self.services.journal.close()
        self.services.filmer.close()
        self.services.recents.close()
        self.services.words.close()
        self.services.log.detach()
        self._thumbnails.close()
        self.services.renderer.close()
        self.window.close()

    def _renew(self) -> None:
        """Opens another window where the graphics card was reset: only pictures are lost, and remade."""
        if self._reopen is None or not self.window.is_lost:
            return
        size = self.window.size
        for held in (self._thumbnails, self.services.renderer, self.window):
            with suppress(Exception):  # what they held is gone already
                held.close()
        self.window = self._reopen(size)
        rasterizer = self.state.settings.rasterizer
        self.services = replace(self.services, renderer=SceneDrawing(self.window.context, None, rasterizer))
        self._thumbnails, self._painted = Thumbnails(self.window.context), None
        self._style, self._title = ("dark", self.window.scale), ""
        self.state = self.state.with_toast("The graphics card was reset. Nothing is lost.")

    def _restyle(self) -> None:
        """Takes over theme and size of the text, as far as the window has room for it."""
        settings, width_px = self.state.settings, self.window.size_px
        largest = min(width_px[0] / SMALLEST_PT[0], width_px[1] / SMALLEST_PT[1])
        scale = min(self.window.scale * settings.font_pt / BODY_PT, max(largest, self.window.scale))
        if self._style != (settings.theme, scale):
            self._style = (settings.theme, scale)
            restyle(scale, PALETTES[settings.theme])

    def _tick(self, pulse: Pulse) -> None:
        """Time passes: motions, the worker's events, the window's."""
        now_s, stalled_s = self.state.now_s + pulse.dt_s, self.state.stalled_s + pulse.stalled_s
        self.state = replace(self.state, now_s=now_s, stalled_s=stalled_s)
        self._open_first()
        self.state = preview(self.services, advance(self.state, pulse.dt_s), pulse.dt_s)
        self.state = drain(self.services, self.state, POLL_BUDGET_S)
        for kind, path in self.services.dialogs.poll():
            self.state = answered(self.services, self.state, kind, path)
        width, height = self.window.size_px
        if width > 0 and height > 0:
            self.do(cmd.Resize(width, height))
        for path in pulse.dropped[-1:]:
            self.do(cmd.Drop(path, pulse.dropped_at_px))
        if pulse.wants_close:
            self.do(cmd.Close())
        self.state = refocus(self.services, self.state)
        self.state = tick(self.services, self.state, imgui.get_io().want_text_input)
        self._name_window()

    def _paint(self, framebuffer: Any) -> None:  # noqa: ANN401 - a moderngl object
        """Draws the scene; a picture at rest is drawn once and kept."""
        state = self.state
        width, height = self.window.size_px
        if not len(state.scene) or width <= 0 or height <= 0:
            framebuffer.clear(*BACKGROUND)
            return
        began_s = time.perf_counter()
        self.services.renderer.sync(state.scene)
        fraction = self.pace.fraction(state.is_moving)
        picture = self.services.renderer.draw(state.view.camera, fraction, state.is_moving, state.look)
        picture.present_to(framebuffer, (0, 0, width, height))
        is_new, self._painted = picture is not self._painted, picture
        if state.is_moving and is_new:  # the same one once more costs nothing, and says nothing
            on_cpu_s = time.perf_counter() - began_s  # a graphics card works on after that
            self.frame_s = max(on_cpu_s, self.services.renderer.gpu_s)
            self.pace = self.pace.measured(True, self.frame_s)
            self._times_ms.append(1e3 * self.frame_s)

    def _panels(self) -> list[cmd.Command]:
        """Draws the panels; returns what they and the input ask for."""
        ui = self._ui()
        self.do(*typed_ahead(self.state))
        commands = draw_screen(self.state, ui)
        self._hand, asked = read_input(self.state, self._hand, self.window.letters, self.window.modifiers)
        return commands + asked

    def _ui(self) -> Ui:
        size = imgui.get_io().display_size
        state, thumbnails = self.state, self._thumbnails
        shown: set[object] = {level.index for level in state.scene}
        photo = thumbnails.of_photo(state.photo) if shows_photo(state) else None
        backdrop = None if state.has_document else thumbnails.of_photo(self._start_picture(), "start")
        shown |= ({"photo"} if photo else set()) | ({"start"} if backdrop else set())
        is_starting = not state.has_document or state.panels.start
        recents = {} if not is_starting else thumbnails.of_recents(state.recents)
        thumbnails.keep_only(shown | set(recents))
        statistics = {**self._timing(), **self.services.renderer.statistics()} if len(state.scene) else {}
        foot = foot_height(state, self._style[1])
        layout = replace(
            arrange(size.x, size.y - foot, self._style[1]), window=Rect(0.0, 0.0, size.x, size.y)
        )
        pictures = (thumbnails.of_scene(state.scene), photo, backdrop)
        target_ms = 1e3 * self.services.renderer.target_s
        numbers = (statistics, tuple(self._times_ms), target_ms)
        log = self.services.log.lines(state.log.level) if state.log.is_open else ()
        colors, letters = PALETTES[self._style[0]], self.window.letters
        return Ui(layout, self.window.fonts, *pictures, *numbers, colors, recents, letters, log)

    def _start_picture(self) -> ByteArray | None:
        if self._backdrop is None and (path := demo_photo()) is not None:
            try:
                self._backdrop = fit_photo(load_photo(path))
            except WzError:
                return None
        return self._backdrop

    def _timing(self) -> dict[str, str]:
        percent = f"{100 * self.pace.fraction(True):.0f} %"
        return {"Frame in motion": f"{1e3 * self.frame_s:.0f} ms at {percent}"}

    def _wait_s(self) -> float:
        state = self.state
        has_toasts = any(toast.is_alive(state.now_s) for toast in state.toasts)
        is_busy = has_toasts or state.job is not None or state.film is not None or state.errand is not None
        is_moving = state.is_moving or not self.services.renderer.is_settled
        shares = state.job is not None and self.services.renderer.target_s == SOFTWARE_TARGET_S
        return wait_s(is_moving, is_busy, time.perf_counter() - self._began_s if shares else None)

    def _name_window(self) -> None:
        mark = "• " if self.state.is_dirty else ""
        title = f"{mark}{self.state.name} - wzviewer" if self.state.name else "wzviewer"
        if title != self._title:
            self._title = title
            self.window.set_title(title)


def run_app(
    path: Path | None,
    *,
    frames: int | None = None,
    screenshot: Path | None = None,
    headless: bool = False,
    synthesizer: str = "builtin",
) -> None:
    """Opens the window on a photo, a scene or the start page, and stays until it is closed.

    Args:
        path: photo or scene, or None.
        frames: stop after so many frames.
        screenshot: write what the last frame showed to a PNG.
        headless: draw off screen, without a display.
        synthesizer: backend of the worker.

    Raises:
        ContextError: when there is no display or no OpenGL 3.3.
        OutputError: when the screenshot cannot be written.
    """
    make = OffscreenWindow if headless else GlfwWindow
    window: Window = make()
    kept: tuple[Any, ...] = ()
    if not headless:
        kept = (SettingsFile.of_user(), JournalFolder.of_user(), RecentFolder.of_user())
        kept += (WordFile.of_user(synthesizer),)
    app = App(window, WorkerClient(synthesizer, yields=True), None, *kept, reopen=make)
    if not headless:
        app.services.log.attach()
    try:
        app.run(path, frames)
        if screenshot is not None:
            with whole_file(screenshot) as file:
                file.write(encode_png(app.window.read_pixels()))
    finally:
        app.close()
