"""Every message between app and worker, one frozen class each.

::

    app ──► worker   ReconstructScene  SynthesizeLevel  ReplayLevel  ForgetScene  Cancel  Shutdown
    worker ──► app   WorkerReady  Heartbeat  StageStarted  LevelBegun  SurfelsAppended  SurfelsReplaced
                     LevelCommitted  LevelAborted  WorkerFailed

Commands are imperative, events are past tense.  Messages are small JSON; arrays travel beside them in
shared memory (`worker.transport`).  No pickle and no code crosses the wire.  ``supersedes`` says that
a newer message of the class makes an undelivered older one pointless.
"""

import json
from dataclasses import asdict, dataclass, field, fields
from typing import Any, ClassVar

Json = dict[str, Any]
Indices = list[int]
MAX_MESSAGE_BYTES = 4 << 20
CUTOUT = "cutout"  # array of a `SynthesizeLevel`


@dataclass(frozen=True)
class Message:
    """Base of all messages."""

    direction: ClassVar[str] = ""
    supersedes: ClassVar[bool] = False


@dataclass(frozen=True)
class ReconstructScene(Message):
    """Make E_0 (line 1).  Arrays: ``image`` (h, w, 3) uint8; perhaps ``photo``, the same but finer."""

    direction: ClassVar[str] = "app->worker"
    request_id: int
    seed: int = 0


@dataclass(frozen=True)
class SynthesizeLevel(Message):
    """Make E_{i+1} (lines 10-32) seen by ``camera``, with the prompt U, over the levels ``beside`` it.

    Arrays: perhaps ``cutout`` (h, w, 4) uint8 sRGB and alpha, put in; then the prompt is its name.
    """

    direction: ClassVar[str] = "app->worker"
    request_id: int
    index: int
    parent: int
    camera: Json
    prompt: str = ""
    seed: int = 0
    beside: Indices = field(default_factory=list)


@dataclass(frozen=True)
class ReplayLevel(Message):
    """Take over a finished level.  Arrays: packed surfels, ``image``, ``relief``, ``map:NAME``."""

    direction: ClassVar[str] = "app->worker"
    header: Json


@dataclass(frozen=True)
class ForgetScene(Message):
    """Drop all levels."""

    direction: ClassVar[str] = "app->worker"


@dataclass(frozen=True)
class Cancel(Message):
    """Stop working on a request."""

    direction: ClassVar[str] = "app->worker"
    request_id: int


@dataclass(frozen=True)
class Shutdown(Message):
    """End the process."""

    direction: ClassVar[str] = "app->worker"


@dataclass(frozen=True)
class WorkerReady(Message):
    """The worker can take requests, with prompts of these words (`core.vocabulary`)."""

    direction: ClassVar[str] = "worker->app"
    pid: int
    words: Json = field(default_factory=dict)


@dataclass(frozen=True)
class Heartbeat(Message):
    """The worker is alive; sent twice a second."""

    direction: ClassVar[str] = "worker->app"
    supersedes: ClassVar[bool] = True
    stage: str = ""


@dataclass(frozen=True)
class StageStarted(Message):
    """A stage of the paper began, or got further: ``fraction`` of the whole level in [0, 1]."""

    direction: ClassVar[str] = "worker->app"
    supersedes: ClassVar[bool] = True
    request_id: int
    stage: int
    name: str
    fraction: float


@dataclass(frozen=True)
class LevelBegun(Message):
    """A level is in the making.  Arrays: ``image``, ``relief`` of the preview."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    header: Json


@dataclass(frozen=True)
class SurfelsAppended(Message):
    """A chunk of the preview.  Arrays: the surfels.  Complete when ``start + count == total``."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    start: int
    total: int


@dataclass(frozen=True)
class SurfelsReplaced(Message):
    """A chunk of a refined revision that will take the preview's place as a whole."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    start: int
    total: int
    revision: int


@dataclass(frozen=True)
class LevelCommitted(Message):
    """The last revision is final.  Arrays: ``image``, ``relief``, ``map:NAME``."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    header: Json


@dataclass(frozen=True)
class LevelAborted(Message):
    """The level will not be made."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    what: str
    why: str
    hint: str = ""
    cancelled: bool = False
    bad_input: bool = False


@dataclass(frozen=True)
class WorkerFailed(Message):
    """The worker met a fault; ``detail`` is its traceback, for the log."""

    direction: ClassVar[str] = "worker->app"
    request_id: int
    why: str
    detail: str = field(default="", repr=False)


MESSAGE_TYPES: dict[str, type[Message]] = {
    c.__name__: c
    for c in (
        ReconstructScene,
        SynthesizeLevel,
        ReplayLevel,
        ForgetScene,
        Cancel,
        Shutdown,
        WorkerReady,
        Heartbeat,
        StageStarted,
        LevelBegun,
        SurfelsAppended,
        SurfelsReplaced,
        LevelCommitted,
        LevelAborted,
        WorkerFailed,
    )
}


def encode(message: Message) -> Json:
    """Returns a message as JSON with its type name."""
    return {"type": type(message).__name__, **asdict(message)}


def decode(record: Json) -> Message:
    """Restores a message.

    Raises:
        ValueError: for an unknown type, or fields that are missing, unknown or of another type.
    """
    body = dict(record)
    cls = MESSAGE_TYPES.get(str(body.pop("type", "")))
    if cls is None:
        raise ValueError(f"unknown message {record.get('type')!r}")
    types = {f.name: f.type for f in fields(cls)}
    for name, value in body.items():
        if name not in types or not _matches(value, types[name]):
            raise ValueError(f"{cls.__name__}.{name} is malformed")
    try:
        return cls(**body)
    except TypeError as error:
        raise ValueError(f"{cls.__name__} lacks a field") from error


def _matches(value: object, annotation: object) -> bool:
    if annotation is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if annotation is int:
        return isinstance(value, int) and not isinstance(value, bool)
    if annotation == Indices:
        return isinstance(value, list) and all(_matches(item, int) for item in value)
    return isinstance(value, dict if annotation == Json else annotation)  # type: ignore[arg-type]


def to_bytes(record: Json) -> bytes:
    """Serialises JSON compactly."""
    return json.dumps(record, separators=(",", ":")).encode()


def from_bytes(data: bytes) -> Json:
    """Parses JSON.

    Raises:
        ValueError: when it is too long, not JSON or not an object.
    """
    if len(data) > MAX_MESSAGE_BYTES:
        raise ValueError(f"message of {len(data)} bytes")
    record = json.loads(data)
    if not isinstance(record, dict):
        raise ValueError("message is not an object")
    return record
