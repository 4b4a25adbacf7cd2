"""Keeps motion fluid on a slow machine: fewer pixels while the camera moves, all of them at rest.

Surfels follow the pixels: at half the resolution every 2x2 of them are drawn as one (`SPACING_PX`), so
cost goes with the number of pixels wherever the time is spent.
"""

from dataclasses import dataclass, replace

TARGET_S = 1 / 60  # of a frame in motion
SOFTWARE_TARGET_S = 1 / 24  # where OpenGL runs on the CPU
FRACTIONS = (1.0, 0.71, 0.5, 0.35, 0.25)  # of the resolution in each direction; fewer would be mush
SPACING_PX = 1.42  # on the screen in motion: of 2x2 merged surfels at 0.71, and of 4x4 at 0.35
MARGIN = 0.7  # a step up has to leave this share of the target unused, or it would swing
IDLE_WAIT_S = 0.1  # between frames when nothing happens
BUSY_WAIT_S = 0.03  # while the worker is making something
SHARED_FRAME_S = 1 / 20  # in motion, where frames and the worker share the processor: it shall get on, too


@dataclass(frozen=True)
class Pace:
    """How finely the next picture is drawn.

    Attributes:
        step: index into `FRACTIONS`, used while moving.
        target_s: time that a picture in motion may take.
    """

    step: int = 0
    target_s: float = TARGET_S

    def fraction(self, is_moving: bool) -> float:
        """Returns the fraction of the resolution, 1 at rest."""
        return FRACTIONS[self.step] if is_moving else 1.0

    def measured(self, is_moving: bool, frame_s: float) -> "Pace":
        """Learns from the time that a picture took; pictures at rest say nothing about motion."""
        if not is_moving:
            return self
        if frame_s > self.target_s and self.step + 1 < len(FRACTIONS):
            # Cost goes with the pixels at most: jump to the step that would have been in time.
            wanted = FRACTIONS[self.step] * (self.target_s / frame_s) ** 0.5
            steps = range(self.step + 1, len(FRACTIONS))
            return replace(self, step=next((i for i in steps if FRACTIONS[i] <= wanted), len(FRACTIONS) - 1))
        if self.step > 0:
            dearer = frame_s * (FRACTIONS[self.step - 1] / FRACTIONS[self.step]) ** 2
            if dearer < MARGIN * self.target_s:
                return replace(self, step=self.step - 1)
        return self


def wait_s(is_moving: bool, is_busy: bool, shared_s: float | None = None) -> float:
    """Returns how long the loop may sleep for input, s: a laptop's battery is the user's.

    Args:
        is_moving: whether the next frame shows another picture.
        is_busy: whether something is under way.
        shared_s: since the last frame began, s, where the worker wants the same processor; else None.
    """
    if is_moving:
        return 0.0 if shared_s is None else max(SHARED_FRAME_S - shared_s, 0.0)
    return BUSY_WAIT_S if is_busy else IDLE_WAIT_S
