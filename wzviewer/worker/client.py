"""What the app holds of the worker: start, ask, poll, cancel, close.  Imports no torch.

The client owns the process and its shared memory.  It never blocks a frame: `poll` takes a time
budget.  A worker that dies, hangs, or does not answer a cancel is killed and replaced, with a fresh
pipe and fresh slots, and the finished levels are replayed to it before its next request.
"""

import contextlib
import multiprocessing
import sys
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from wzviewer.core import messages as m
from wzviewer.core.assembly import LevelAssembly, replay_arrays
from wzviewer.core.camera import Camera
from wzviewer.core.records import camera_to_json, header_of
from wzviewer.core.scene import PHOTO, Level, Scene
from wzviewer.core.types import ByteArray
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.worker.transport import Arrays, Channel, TransportError, make_memory

CANCEL_GRACE_S = 0.7  # then the worker is killed; the contract says one second in all
PATIENT_S = 6.0  # the same where another request waits for the worker: a fresh one takes longer
HEARTBEAT_LIMIT_S = 30.0  # without a sign of life the worker counts as hung
START_LIMIT_S = 180.0  # a slow disk, a busy machine: importing takes its time
LONGEST_GAP_S = 1.0  # between two polls, that counts: a laptop that slept stopped both sides
MAX_FAILED_STARTS = 3  # in a row; then the worker is left alone until it is asked for something


@dataclass(frozen=True)
class Event:
    """Something that the worker reported; ``request_id`` is 0 where none is concerned."""

    request_id: int


@dataclass(frozen=True)
class WorkerStarted(Event):
    """The worker can take requests, with prompts of these words."""

    vocabulary: Vocabulary = field(default_factory=Vocabulary)


@dataclass(frozen=True)
class StageProgressed(Event):
    """A stage began or got further; ``fraction`` of the whole level, [0, 1]."""

    stage: int
    name: str
    fraction: float


@dataclass(frozen=True, eq=False)
class LevelPreviewed(Event):
    """A complete revision of a level that is still being made."""

    level: Level
    revision: int


@dataclass(frozen=True, eq=False)
class LevelFinished(Event):
    """A level is final."""

    level: Level


@dataclass(frozen=True)
class LevelDropped(Event):
    """A request ended without a level: cancelled, refused, or failed."""

    what: str
    why: str
    hint: str = ""
    cancelled: bool = False
    bad_input: bool = False
    detail: str = ""


@dataclass(frozen=True)
class WorkerLost(Event):
    """The worker died or hung and has been started again.

    Attributes:
        why: what happened to it.
        is_after_cancel: whether it was busy with what was cancelled, and was ended for that.
    """

    why: str
    is_after_cancel: bool = False


class WorkerClient:
    """The worker as the app sees it.

    Args:
        synthesizer: backend name; "builtin" needs no weights.
        entry: child entry point, for tests; `wzviewer.worker.process.main` by default.
        yields: whether the worker leaves the cores to whoever wants them: frames that are drawn beside it.
    """

    def __init__(
        self,
        synthesizer: str = "builtin",
        entry: Any = None,  # noqa: ANN401
        yields: bool = False,
    ) -> None:
        self._synthesizer, self._entry, self._yields = synthesizer, entry, yields
        self._context = multiprocessing.get_context("spawn")
        self._levels: list[Level] = []
        self._known: set[int] = set()  # levels that the present worker process holds
        self._events: deque[Event] = deque()
        self._next_request = 1
        self._assembly: LevelAssembly | None = None
        self._cancelled_at: float | None = None
        self._grace_s = CANCEL_GRACE_S
        self.request_id = 0  # of the running request; 0 when idle
        self.ready = False
        self._process: Any = None
        self._failed_starts = 0

    @property
    def is_busy(self) -> bool:
        """Whether a request is running."""
        return self.request_id != 0

    @property
    def pid(self) -> int | None:
        """Process id of the worker, if it runs."""
        return self._process.pid if self._process is not None else None

    def start(self) -> None:
        """Starts the process; returns at once, `WorkerStarted` follows through `poll`."""
        from wzviewer.worker.process import main

        parent_pipe, child_pipe = self._context.Pipe(duplex=True)
        self._memory, self._is_named = make_memory(), True
        names = tuple(memory.name for memory in self._memory)
        given = () if self._entry else (self._yields,)
        arguments = (child_pipe, names[1], names[0], self._synthesizer, *given)
        self._process = self._context.Process(target=self._entry or main, args=arguments, daemon=True)
        wait_for_import("cv2")
        self._process.start()
        child_pipe.close()
        self._channel = Channel(parent_pipe, self._memory[0], self._memory[1])
        self._known, self.ready = set(), False
        self._silence_s, self._polled_s = 0.0, time.perf_counter()

    def load(self, scene: Scene) -> None:
        """Takes over a scene; its levels are sent to the worker when a request needs them."""
        if self._process is not None:
            self._send(m.ForgetScene())
        self._known = set()
        self._levels = list(scene)

    def reconstruct(self, image: ByteArray, seed: int = 0, photo: ByteArray | None = None) -> int:
        """Asks for E_0 from a photo; forgets all levels; returns the request id.

        Args:
            image: (h, w, 3) uint8, the photo in its working size.
            seed: of the generators.
            photo: (H, W, 3) uint8, the same with more pixels, if it has any; see `photos.finer_photo`.
        """
        self.load(Scene())
        request_id = self._begin()
        arrays = {"image": image} if photo is None else {"image": image, PHOTO: photo}
        self._send(m.ReconstructScene(request_id, seed), arrays)
        return request_id

    def synthesize(
        self,
        parent: int,
        camera: Camera,
        prompt: str = "",
        seed: int = 0,
        cutout: ByteArray | None = None,
        beside: Sequence[int] = (),
    ) -> int:
        """Asks for the level that ``camera`` sees inside level ``parent``; returns the request id.

        Args:
            parent: index of the level that is refined.
            camera: C of the new level.
            prompt: U; with a cut-out, its name.
            seed: of every generator.
            cutout: (h, w, 4) uint8 sRGB and alpha, put into the picture instead of what U names.
            beside: levels that the new one will lie over, from `core.beside.levels_beside`.
        """
        request_id = self._begin()
        for index in sorted({*self._path(parent), *beside}):
            if index not in self._known:
                level = self._levels[index]
                self._send(m.ReplayLevel(header_of(level)), replay_arrays(level))
                self._known.add(index)
        index = len(self._levels)
        record = camera_to_json(camera)
        arrays = {} if cutout is None else {m.CUTOUT: cutout}
        self._send(m.SynthesizeLevel(request_id, index, parent, record, prompt, seed, list(beside)), arrays)
        return request_id

    def _send(self, message: m.Message, arrays: Arrays | None = None) -> None:
        # A worker that is gone is noticed, and replaced, by the next poll.
        with contextlib.suppress(OSError):
            self._channel.send(message, arrays)

    def _path(self, index: int) -> list[int]:
        chain: list[int] = []
        step: int | None = index
        while step is not None:
            chain.append(step)
            step = self._levels[step].parent
        return chain[::-1]

    def _begin(self) -> int:
        if self.is_busy:
            raise RuntimeError("a request is running; cancel it or wait")
        if self._process is None:
            self._failed_starts = 0
            self.start()
        self.request_id, self._next_request = self._next_request, self._next_request + 1
        self._assembly = LevelAssembly()
        self._cancelled_at = None
        return self.request_id

    def cancel(self, grace_s: float = CANCEL_GRACE_S) -> None:
        """Cancels the running request; `LevelDropped` follows within a second.

        Args:
            grace_s: how long the worker has to stop by itself.  Then it is killed, and the next request
                waits until another one has read its models: where nobody waits for the cancel itself,
                more of it is quicker.
        """
        if self.is_busy and self._cancelled_at is None:
            self._cancelled_at, self._grace_s = time.perf_counter(), grace_s
            self._send(m.Cancel(self.request_id))

    def poll(self, budget_s: float = 0.002) -> list[Event]:
        """Returns what happened since the last call; handles a lost worker; never blocks."""
        if self._process is not None:
            self._listen(budget_s)
        events, self._events = list(self._events), deque()
        return events

    def _listen(self, budget_s: float) -> None:
        try:
            for delivery in self._channel.poll(budget_s):
                self._silence_s = 0.0
                self._unname()
                self._handle(delivery.message, delivery.arrays)
        except (EOFError, OSError, TransportError, ValueError) as error:
            self._replace_worker(self._reason(error))
        if self._process is not None:
            self._check_liveness()

    def _unname(self) -> None:
        """Once both sides hold the slots they need no name: nothing is left behind, however the app ends."""
        if self._is_named:
            self._is_named = False
            for memory in self._memory:
                memory.unlink()

    def channel_wait(self, timeout_s: float) -> None:
        """Sleeps until the worker says something, at most ``timeout_s``."""
        if self._process is None:
            return
        with contextlib.suppress(OSError):
            self._channel.pipe.poll(timeout_s)

    def wait(self, request_id: int, timeout_s: float = 600.0) -> list[Event]:
        """Polls until a request has ended; returns all events.  For tests and the command line."""
        events: list[Event] = []
        deadline = time.perf_counter() + timeout_s
        while time.perf_counter() < deadline:
            events += self.poll(0.02)
            if any(_ends(e, request_id) for e in events):
                return events
            self.channel_wait(0.01)
        raise TimeoutError(f"request {request_id} took over {timeout_s} s")

    def _handle(self, message: m.Message, arrays: dict[str, Any]) -> None:
        if isinstance(message, m.WorkerReady):
            self.ready, self._failed_starts = True, 0
            self._events.append(WorkerStarted(0, Vocabulary.from_json(message.words)))
        elif getattr(message, "request_id", None) == self.request_id and self._assembly is not None:
            self._handle_request(message, arrays, self._assembly)

    def _handle_request(self, message: m.Message, arrays: dict[str, Any], assembly: LevelAssembly) -> None:
        request_id = self.request_id
        if isinstance(message, m.StageStarted):
            self._events.append(StageProgressed(request_id, message.stage, message.name, message.fraction))
        elif isinstance(message, m.LevelBegun):
            assembly.begin(message.header, arrays)
        elif isinstance(message, m.SurfelsAppended | m.SurfelsReplaced):
            revision = getattr(message, "revision", 0)
            if assembly.add(message.start, message.total, arrays):
                self._events.append(LevelPreviewed(request_id, assembly.level(), revision))
        elif isinstance(message, m.LevelCommitted):
            self._finish(assembly.finish(message.header, arrays))
        elif isinstance(message, m.LevelAborted):
            fields = (message.what, message.why, message.hint, message.cancelled, message.bad_input)
            self._drop(LevelDropped(request_id, *fields))
        elif isinstance(message, m.WorkerFailed):
            self._drop(LevelDropped(request_id, "worker", message.why, detail=message.detail))

    def _finish(self, level: Level) -> None:
        self._levels.append(level)
        self._known.add(level.index)
        self._events.append(LevelFinished(self.request_id, level))
        self.request_id = 0

    def _drop(self, event: LevelDropped) -> None:
        if self._cancelled_at is not None:
            event = replace(event, cancelled=True, why="cancelled")
        self._events.append(event)
        self.request_id = 0

    def _check_liveness(self) -> None:
        now = time.perf_counter()
        self._silence_s += min(now - self._polled_s, LONGEST_GAP_S)
        self._polled_s = now
        limit_s = HEARTBEAT_LIMIT_S if self.ready else START_LIMIT_S
        if self._cancelled_at is not None and self.is_busy and now - self._cancelled_at > self._grace_s:
            self._replace_worker("did not answer the cancel in time", is_after_cancel=True)
        elif not self._process.is_alive():
            self._replace_worker(self._reason(None))
        elif self._silence_s > limit_s:
            self._replace_worker(f"gave no sign of life for {limit_s:.0f} s")

    def _reason(self, error: Exception | None) -> str:
        self._process.join(0.2)
        code = self._process.exitcode
        if code is not None and code < 0:
            return f"was killed by signal {-code}" + (" (out of memory?)" if code == -9 else "")
        return f"ended with status {code}" if code is not None else f"broke the protocol ({error})"

    def _replace_worker(self, why: str, is_after_cancel: bool = False) -> None:
        self._stop()
        if self.is_busy:
            self._drop(LevelDropped(self.request_id, "worker", f"the worker {why}", "Try again."))
        self._failed_starts += not self.ready
        if self._failed_starts >= MAX_FAILED_STARTS:
            why = f"{why}; it failed {MAX_FAILED_STARTS} times in a row and is not started again until needed"
            self._process = None
        else:
            self.start()
        self._events.append(WorkerLost(0, why, is_after_cancel))

    def _stop(self) -> None:
        self._process.kill()
        self._process.join(5.0)
        self._channel.pipe.close()
        self._unname()
        for memory in self._memory:
            memory.close()

    def close(self) -> None:
        """Ends the process and frees the shared memory."""
        if self._process is None:
            return
        with contextlib.suppress(OSError):
            self._channel.send(m.Shutdown())
            self._process.join(0.5)
        self._stop()
        self._process = None

    def __enter__(self) -> "WorkerClient":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _ends(event: Event, request_id: int) -> bool:
    return event.request_id == request_id and isinstance(event, LevelFinished | LevelDropped)


def wait_for_import(name: str, limit_s: float = 5.0) -> None:
    """Waits while another thread imports a module that stands in ``sys.path`` until it is there.

    OpenCV's own folder does.  A child takes the path as it is at its start, and would find OpenCV's
    ``typing`` before Python's, and end.
    """
    deadline_s = time.perf_counter() + limit_s
    while any(Path(entry).name == name for entry in sys.path) and time.perf_counter() < deadline_s:
        time.sleep(0.005)
