"""The worker process: takes requests, runs `synthesis`, streams levels.  First to `import torch`.

Three threads: a reader, so that credits and a cancel arrive while the main thread computes; a
heartbeat; and the main thread, which owns the models and works on one request at a time.
"""

import ctypes
import logging
import os
import queue
import sys
import threading
import time
import traceback
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core import messages as m
from wzviewer.core.assembly import CHUNK_SURFELS, MAP_PREFIX, level_of, surfel_arrays
from wzviewer.core.records import camera_from_json, header_of
from wzviewer.core.scene import PHOTO, Level
from wzviewer.errors import Cancelled, InputError
from wzviewer.worker.transport import Arrays, Channel, Delivery, TransportError

HEARTBEAT_S = 0.5
NICE = 10
BELOW_NORMAL_PRIORITY_CLASS = 0x4000  # of the Windows API
log = logging.getLogger(__name__)


def main(
    pipe: Connection, outgoing_name: str, incoming_name: str, synthesizer: str, yields: bool = False
) -> None:
    """Entry point of the spawned process; returns when the app is gone or says so."""
    if yields:
        yield_to_frames()
    outgoing, incoming = SharedMemory(outgoing_name), SharedMemory(incoming_name)
    Worker(Channel(pipe, outgoing, incoming), synthesizer).run()


def yield_to_frames() -> None:
    """Lowers the priority of this process: where cores are few, the frames of the app come first."""
    try:
        if sys.platform == "win32":
            kernel = ctypes.windll.kernel32
            kernel.SetPriorityClass(kernel.GetCurrentProcess(), BELOW_NORMAL_PRIORITY_CLASS)
        elif sys.platform == "linux":  # the one class that a waking thread of the app need not wait for
            for thread in _threads():
                os.sched_setscheduler(thread, os.SCHED_IDLE, os.sched_param(0))
        else:
            os.nice(NICE)
    except OSError:
        log.info("the priority of the worker stays as it is")


def _threads() -> list[int]:
    """Linux ids of all threads of this process: numpy's import starts some before `main` is called."""
    return [int(path.name) for path in Path("/proc/self/task").iterdir()]


class Worker:
    """The child's side of the conversation."""

    def __init__(self, channel: Channel, synthesizer: str) -> None:
        self._channel = channel
        self._synthesizer_name = synthesizer
        self._inbox: queue.Queue[Delivery | None] = queue.Queue()
        self._cancelled: set[int] = set()
        self._levels: dict[int, Level] = {}

    def run(self) -> None:
        """Works until told to stop."""
        threading.Thread(target=self._read, daemon=True).start()
        threading.Thread(target=self._beat, daemon=True).start()
        from wzviewer.worker.models.registry import load_synthesizer

        self._models = load_synthesizer(self._synthesizer_name)
        words = self._models.editor.vocabulary().to_json()
        self._channel.send(m.WorkerReady(os.getpid(), words))
        self._models.warm_up(self._inbox.empty)
        while (delivery := self._inbox.get()) is not None:
            self._handle(delivery)

    def _read(self) -> None:
        try:
            while True:
                for delivery in self._channel.receive():
                    if isinstance(delivery.message, m.Cancel):
                        self._cancelled.add(delivery.message.request_id)
                    elif isinstance(delivery.message, m.Shutdown):
                        os._exit(0)
                    else:
                        self._inbox.put(delivery)
        except (EOFError, OSError, TransportError):
            os._exit(0)  # the app is gone: nothing is left to do, and nothing to lose

    def _beat(self) -> None:
        while True:  # at once: the first sign says that the slots are held on this side too
            try:
                self._channel.send(m.Heartbeat())
            except OSError:
                os._exit(0)
            time.sleep(HEARTBEAT_S)

    def _handle(self, delivery: Delivery) -> None:
        message, arrays = delivery.message, delivery.arrays
        if isinstance(message, m.ForgetScene):
            self._levels.clear()
        elif isinstance(message, m.ReplayLevel):
            level = level_of(message.header, arrays)
            self._levels[level.index] = level
        elif isinstance(message, m.ReconstructScene | m.SynthesizeLevel):
            self._answer(message, arrays)

    def _answer(self, message: m.ReconstructScene | m.SynthesizeLevel, arrays: Arrays) -> None:
        request_id = message.request_id
        try:
            self._commit(request_id, self._make(message, arrays))
        except Cancelled:
            self._send(m.LevelAborted(request_id, "generation", "cancelled", cancelled=True))
        except InputError as error:
            self._send(m.LevelAborted(request_id, error.what, error.why, error.hint, bad_input=True))
        except MemoryError:
            detail = traceback.format_exc()
            self._send(m.WorkerFailed(request_id, "ran out of memory; try a smaller --size", detail))
        except Exception as error:  # the boundary of the process: reported once, with its traceback
            detail = traceback.format_exc()
            self._send(m.WorkerFailed(request_id, f"{type(error).__name__}: {error}", detail))

    def _make(self, message: m.ReconstructScene | m.SynthesizeLevel, arrays: Arrays) -> Level:
        from wzviewer.worker.synthesis import reconstruct_scene, synthesize_level

        report = StreamReport(self._channel, message.request_id, self._check(message.request_id))
        if isinstance(message, m.ReconstructScene):
            self._levels.clear()
            image, photo = np.asarray(arrays["image"]), arrays.get(PHOTO)
            return reconstruct_scene(image, message.seed, self._models, report, photo)
        camera = camera_from_json(message.camera)
        path, beside = self._path(message.parent), [self._levels[index] for index in message.beside]
        request = (message.index, camera, message.prompt, message.seed)
        return synthesize_level(path, *request, self._models, report, arrays.get(m.CUTOUT), beside)

    def _path(self, index: int) -> list[Level]:
        chain = [self._levels[index]]
        while (parent := chain[-1].parent) is not None:
            chain.append(self._levels[parent])
        return chain[::-1]

    def _check(self, request_id: int) -> "CancelCheck":
        return CancelCheck(self._cancelled, request_id)

    def _commit(self, request_id: int, level: Level) -> None:
        self._levels[level.index] = level
        maps = {MAP_PREFIX + k: v for k, v in level.maps.items()}
        arrays: dict[str, NDArray[Any]] = {"image": level.image, "relief": level.relief, **maps}
        self._send(m.LevelCommitted(request_id, header_of(level)), arrays)

    def _send(self, message: m.Message, arrays: Arrays | None = None) -> None:
        self._channel.send(message, arrays)
        while not self._channel.pump():
            time.sleep(0.001)


class CancelCheck:
    """Raises `Cancelled` once the request has been cancelled; called often by every stage."""

    def __init__(self, cancelled: set[int], request_id: int) -> None:
        self._cancelled, self._request_id = cancelled, request_id

    def __call__(self) -> None:
        """Returns, or raises `Cancelled`."""
        if self._request_id in self._cancelled:
            raise Cancelled


class StreamReport:
    """Sends what happens during a request to the app (see `synthesis.Report`)."""

    def __init__(self, channel: Channel, request_id: int, check: CancelCheck) -> None:
        self._channel, self._request_id, self.check = channel, request_id, check
        self._revision = 0

    def stage(self, stage: int, name: str, fraction: float) -> None:
        """Reports that a stage began or got further."""
        self.check()
        self._channel.send(m.StageStarted(self._request_id, stage, name, float(fraction)))

    def level(self, level: Level) -> None:
        """Streams a complete revision of the level: first the preview, then refinements."""
        if self._revision == 0:
            arrays: dict[str, NDArray[Any]] = {"image": level.image, "relief": level.relief}
            header = header_of(replace(level, notes={}))
            self._channel.send(m.LevelBegun(self._request_id, header), arrays)
        total = len(level.surfels)
        for start, piece in level.surfels.pieces(CHUNK_SURFELS):
            self._channel.send(self._chunk(start, total), surfel_arrays(piece))
            while not self._channel.pump():
                self.check()
                time.sleep(0.001)
        self._revision += 1

    def _chunk(self, start: int, total: int) -> m.Message:
        if self._revision == 0:
            return m.SurfelsAppended(self._request_id, start, total)
        return m.SurfelsReplaced(self._request_id, start, total, self._revision)
