"""What has been asked for and is not made yet: one goal at a time, the others wait in a queue."""

from dataclasses import dataclass, replace

from wzviewer.core.camera import Camera
from wzviewer.core.types import ByteArray, DoubleArray

MAX_WAITING = 8
AGAIN_S = 1.5  # a second Escape within it means all that waits


@dataclass(frozen=True, eq=False)
class Goal:
    """A level that is asked for: seen by ``camera``, reached perhaps through levels between.

    Attributes:
        camera: C of the level, as far as its region goes.
        prompt: U.
        focus: (3,) world point at its centre.
        count: of variants that are wanted, this one included.
        like: index of the level that another of is wanted, with another seed; None for a new one.
        is_early: whether it was asked for before there was a surface, so that its focus is to be found.
        cutout: (h, w, 4) uint8 sRGB and alpha, a picture that is put in; None for none.
    """

    camera: Camera
    prompt: str
    focus: DoubleArray
    count: int = 1
    like: int | None = None
    cutout: ByteArray | None = None
    is_early: bool = False


@dataclass(frozen=True, eq=False)
class Queue:
    """Goals that wait for the running request to end.

    Attributes:
        goals: the next one first.
        cancelled_s: when a request was cancelled last, s.
    """

    goals: tuple[Goal, ...] = ()
    cancelled_s: float = -1e9

    @property
    def is_full(self) -> bool:
        """Whether no more can wait."""
        return len(self.goals) >= MAX_WAITING

    def with_last(self, goal: Goal) -> "Queue":
        """Returns the queue with one more goal at its end."""
        return replace(self, goals=(*self.goals, goal))

    def with_first(self, goal: Goal) -> "Queue":
        """Returns the queue with a goal before all others."""
        return replace(self, goals=(goal, *self.goals))

    def without(self, place: int) -> "Queue":
        """Returns the queue without the goal at a place; no such place changes nothing."""
        return replace(self, goals=tuple(g for k, g in enumerate(self.goals) if k != place))
