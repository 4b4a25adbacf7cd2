"""Selection and order off the frame thread: frames go on with the newest order there is.

An order stays good while the camera moves little: a zoom changes no depth at all, an orbit of a degree
hardly any.  So a new one is asked for only when the camera has turned, gone or zoomed by more than a
threshold, relative to the distance of what it looks at (a fixed one would re-sort always or never after
a zoom of x8^5), or when it has come to rest.  The thread makes one order at a time, always for the
newest camera.  Pages that an order names are not written again while it may be drawn (`Pages.reclaim`).
"""

import threading
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.gl.visible import Choice, LevelState, Ordered, select

TURN_DEG = 0.5
SHIFT_SHARE = 0.005  # of the focus distance
DRIFT_SHARE = 0.06  # of the image; less than half of what is kept around it

States = Mapping[int, LevelState]


@dataclass(frozen=True, eq=False)
class Job:
    """What an order is made for."""

    states: States
    camera: Camera
    choice: Choice

    def is_same(self, other: "Job") -> bool:
        """Whether both would give the same order."""
        same_scene = self.states is other.states and self.choice == other.choice
        return same_scene and self.camera.key == other.camera.key

    def is_near(self, other: "Job", focus_depth: float) -> bool:
        """Whether an order for one serves the other in motion."""
        if self.states is not other.states or self.choice != other.choice:
            return False
        return is_near(self.camera, other.camera, focus_depth)


@dataclass(frozen=True, eq=False)
class Newest:
    """The newest order.

    Attributes:
        ordered: it.
        is_current: whether it was made from the present levels.
        is_exact: whether it was also made for this very camera.
    """

    ordered: Ordered
    is_current: bool
    is_exact: bool


class OrderQueue:
    """A thread that orders for the newest camera."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._wanted: Job | None = None  # not begun
        self._latest: Job | None = None  # the last one asked for
        self._seen: Job | None = None  # of the last call of `ask`
        self._running: Job | None = None
        self._done: tuple[Job, Ordered] | None = None
        self._error: Exception | None = None
        self._closing = self._has_made = False
        self._thread: threading.Thread | None = None

    def ask(self, states: States, camera: Camera, choice: Choice) -> None:
        """Has an order made if the last one asked for does not serve."""
        job = Job(states, camera, choice)
        rests = self._seen is not None and self._seen.is_same(job)
        self._seen = job
        with self._changed:
            if self._latest is not None and self._done is not None:
                depth = self._done[1].selection.focus.depth
                if self._latest.is_same(job) or (not rests and self._latest.is_near(job, depth)):
                    return
            self._latest = self._wanted = job
            self._start()
            self._changed.notify_all()

    def newest(self, states: States, camera: Camera, choice: Choice) -> Newest:
        """Returns the newest order; waits where there is none: for the first of all.

        Raises:
            Exception: whatever an order asked for before has failed with.
            RuntimeError: after `close`, when there is none.
        """
        with self._changed:
            while self._done is None and self._error is None and not self._closing:
                self._changed.wait()
            error, self._error = self._error, None
            if error is not None:
                raise error
            if self._done is None:
                raise RuntimeError("the queue was closed before there was an order")
            job, ordered = self._done
        now = Job(states, camera, choice)
        return Newest(ordered, job.states is states, job.is_same(now))

    @property
    def is_first(self) -> bool:
        """Whether `newest` would wait because no order has been made yet."""
        with self._changed:
            return not (self._has_made or self._error is not None or self._closing)

    def forget_older(self, states: States) -> None:
        """Never returns an order of other levels again: the pages that it names may be written."""
        with self._changed:
            if self._done is not None and self._done[0].states is not states:
                self._done = None
            self._wanted = _of_states(self._wanted, states)
            self._running = _of_states(self._running, states)
            self._latest = _of_states(self._latest, states)

    def close(self) -> None:
        """Ends the thread."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()

    def _start(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, name="ordering", daemon=True)
            self._thread.start()

    def _work(self) -> None:
        while True:
            with self._changed:
                while self._wanted is None and not self._closing:
                    self._changed.wait()
                if self._closing:
                    return
                job, self._wanted = self._wanted, None
                self._running = job
            assert job is not None  # the loop above waited for one
            try:
                self._finish(job, select(job.states, job.camera, job.choice).ordered())
            except Exception as error:  # the frame thread shall hear of it, not wait for ever
                with self._changed:
                    self._error, self._latest = error, None
                    self._changed.notify_all()

    def _finish(self, job: Job, ordered: Ordered) -> None:
        with self._changed:
            if self._running is job:  # else it was forgotten
                self._done, self._error, self._has_made = (job, ordered), None, True
                self._changed.notify_all()


def _of_states(job: Job | None, states: States) -> Job | None:
    return job if job is not None and job.states is states else None


def is_near(one: Camera, other: Camera, focus_depth: float) -> bool:
    """Whether two cameras see nearly the same order, and the same part of the scene.

    Args:
        one: a camera.
        other: a camera.
        focus_depth: distance of what is looked at, world units.
    """
    if (one.width, one.height) != (other.width, other.height):
        return False
    turn = one.rotation @ other.rotation.T
    sine = np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    if sine > np.sin(np.radians(TURN_DEG)) or np.trace(turn) < 1.0:
        return False
    if np.linalg.norm(one.position - other.position) > SHIFT_SHARE * focus_depth:
        return False
    corners = [(0.0, 0.0), (one.width, 0.0), (0.0, one.height), (one.width, one.height)]
    points = np.array([one.unproject(x, y, focus_depth) for x, y in corners])
    drift = np.abs(other.project(points)[:, :2] - np.array(corners)).max()
    return bool(drift <= DRIFT_SHARE * max(one.width, one.height))
