"""Two-way transport: a pipe of small typed messages, and shared-memory slots for arrays.

A message with arrays is followed by *pieces*, each copied into a free slot; the receiver copies it
out and returns the slot as a *credit*.  Without a free slot the sender waits, so a slow receiver
never sees more than its slots.  Frames are bytes: one letter, then JSON::

    M  the message, and names, dtypes and shapes of its arrays
    P  slot, bytes and CRC of the next piece
    C  slot that is free again

This module imports no torch and runs on both sides.
"""

import math
import sys
import threading
import time
import zlib
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.messages import Json, Message, decode, encode, from_bytes, to_bytes
from wzviewer.core.types import ByteArray

SLOT_BYTES = 1 << 20
NUM_SLOTS = 32  # each way: the arrays of a few chunks, so that a frame finds more than one waiting
MAX_ARRAY_BYTES = 4 << 30  # of one message
ALLOWED_KINDS = "fiub"
UNTOLD = "ignore::UserWarning:multiprocessing.resource_tracker"

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Delivery:
    """A message that arrived whole, with its arrays."""

    message: Message
    arrays: dict[str, NDArray[Any]]


class TransportError(RuntimeError):
    """The other side broke the protocol, or is gone."""


class Channel:
    """One end of the transport.

    Args:
        pipe: duplex pipe end.
        outgoing: shared memory that this side writes.
        incoming: shared memory that the other side writes.
    """

    def __init__(self, pipe: Connection, outgoing: SharedMemory, incoming: SharedMemory) -> None:
        self.pipe = pipe
        self._outgoing, self._incoming = outgoing, incoming
        self._free = deque(range(NUM_SLOTS))
        self._queue: deque[tuple[bytes, list[NDArray[np.uint8]]]] = deque()
        self._partial: _Partial | None = None
        self._lock = threading.RLock()  # a reader thread returns credits while another sends

    def send(self, message: Message, arrays: Arrays | None = None) -> None:
        """Queues a message and sends what the credits allow; see `pump` and `flush`."""
        arrays = {k: np.ascontiguousarray(v) for k, v in (arrays or {}).items()}
        manifest = [[k, v.dtype.str, list(v.shape)] for k, v in arrays.items()]
        header = b"M" + to_bytes({"message": encode(message), "arrays": manifest})
        bodies = [v.reshape(-1).view(np.uint8) for v in arrays.values() if v.nbytes]
        with self._lock:
            self._queue.append((header, bodies))
            self._pump()

    def pump(self) -> bool:
        """Sends queued frames while slots are free; returns whether everything is sent."""
        with self._lock:
            return self._pump()

    def _pump(self) -> bool:
        while self._queue:
            header, bodies = self._queue[0]
            if header:
                self.pipe.send_bytes(header)
                self._queue[0] = (b"", bodies)
            if not self._pump_pieces(bodies):
                return False
            self._queue.popleft()
        return True

    def _pump_pieces(self, bodies: list[ByteArray]) -> bool:
        while bodies:
            if not self._free:
                return False
            piece, rest = bodies[0][:SLOT_BYTES], bodies[0][SLOT_BYTES:]
            self._send_piece(piece)
            bodies[:1] = [rest] if len(rest) else []
        return True

    def _send_piece(self, piece: ByteArray) -> None:
        slot = self._free.popleft()
        offset = slot * SLOT_BYTES
        view = _bytes_of(self._outgoing)
        view[offset : offset + len(piece)] = piece
        record = {"slot": slot, "bytes": len(piece), "crc": zlib.crc32(piece.data)}
        self.pipe.send_bytes(b"P" + to_bytes(record))

    def receive(self) -> list[Delivery]:
        """Reads one frame, which must be waiting, and returns what became complete.

        Raises:
            EOFError: when the other side is gone.
            TransportError: when the frame breaks the protocol.
        """
        frame = self.pipe.recv_bytes()
        try:
            kind, record = frame[:1], from_bytes(frame[1:])
            if kind == b"C":
                self._free.append(int(record["slot"]) % NUM_SLOTS)
                self.pump()
            elif kind == b"P" and self._partial is not None:
                self._take_piece(self._partial, record)
            elif kind == b"M" and self._partial is None:
                self._partial = _Partial.begin(record)
            else:
                raise ValueError(f"unexpected frame {kind!r}")
        except (KeyError, TypeError, ValueError) as error:
            raise TransportError(str(error)) from error
        return self._complete()

    def _complete(self) -> list[Delivery]:
        if self._partial is None or not self._partial.is_complete:
            return []
        done, self._partial = self._partial, None
        return [Delivery(done.message, done.arrays)]

    def _take_piece(self, partial: "_Partial", record: Json) -> None:
        slot, count = int(record["slot"]), int(record["bytes"])
        if not (0 <= slot < NUM_SLOTS and 0 < count <= SLOT_BYTES):
            raise ValueError("piece out of range")
        data = _bytes_of(self._incoming)[slot * SLOT_BYTES :][:count].copy()
        if zlib.crc32(data.data) != record["crc"]:
            raise ValueError("piece is damaged")
        partial.fill(data)
        with self._lock:
            self.pipe.send_bytes(b"C" + to_bytes({"slot": slot}))

    def poll(self, budget_s: float = 0.0) -> Iterator[Delivery]:
        """Yields what is complete among waiting frames, within a time budget; never blocks.

        What the caller does with a delivery counts, too: unpacking one takes longer than reading it.

        Raises:
            EOFError: when the other side is gone.
            TransportError: when a frame breaks the protocol.
        """
        deadline = time.perf_counter() + budget_s
        while self.pipe.poll(0):
            yield from self.receive()
            if time.perf_counter() >= deadline:
                break
        self.pump()


class _Partial:
    """A message whose arrays are still arriving."""

    def __init__(self, message: Message, arrays: dict[str, NDArray[Any]]) -> None:
        self.message, self.arrays = message, arrays
        self._targets = deque(a.reshape(-1).view(np.uint8) for a in arrays.values() if a.nbytes)
        self._filled = 0

    @classmethod
    def begin(cls, record: Json) -> "_Partial":
        message = decode(record["message"])
        arrays, total = {}, 0
        for name, dtype_str, shape in record["arrays"]:
            dtype = np.dtype(str(dtype_str))
            if dtype.kind not in ALLOWED_KINDS or any(not isinstance(k, int) or k < 0 for k in shape):
                raise ValueError(f"array {name!r} is malformed")
            total += dtype.itemsize * math.prod(shape)
            if total > MAX_ARRAY_BYTES:
                raise ValueError(f"arrays of {total} bytes")
            arrays[str(name)] = np.empty(shape, dtype)
        return cls(message, arrays)

    @property
    def is_complete(self) -> bool:
        return not self._targets

    def fill(self, data: ByteArray) -> None:
        target = self._targets[0] if self._targets else np.empty(0, np.uint8)
        end = self._filled + len(data)
        if end > len(target):
            raise ValueError("piece is longer than its array")
        target[self._filled : end] = data
        self._filled = end
        if end == len(target):
            self._targets.popleft()
            self._filled = 0


def _bytes_of(memory: SharedMemory) -> ByteArray:
    assert memory.buf is not None  # only after close()
    return np.frombuffer(memory.buf, np.uint8)


def make_memory() -> tuple[SharedMemory, SharedMemory]:
    """Allocates the slots of both directions; the app owns and unlinks them."""
    _start_tracker()
    size = NUM_SLOTS * SLOT_BYTES
    return SharedMemory(create=True, size=size), SharedMemory(create=True, size=size)


def _start_tracker() -> None:
    """Starts Python's tracker, which frees the slots of an app that was killed, without its warning.

    It takes warning options from this process as it starts.
    """
    if sys.platform == "win32":  # there memory goes with its last user
        return
    from multiprocessing import resource_tracker

    sys.warnoptions.append(UNTOLD)
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(UNTOLD)
