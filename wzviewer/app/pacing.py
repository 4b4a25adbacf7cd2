"""Keeps motion fluid on a slow GPU: fewer pixels while the camera moves, all of them at rest."""

from dataclasses import dataclass, replace

TARGET_S = 1 / 30  # of a frame in motion
FRACTIONS = (1.0, 0.71, 0.5)  # of the resolution in each direction; fewer would be mush
MARGIN = 0.7  # a step up has to leave this share of the target unused, or it would swing
IDLE_WAIT_S = 0.1  # between frames when nothing happens
BUSY_WAIT_S = 0.03  # while the worker is making something


@dataclass(frozen=True)
class Pace:
    """How finely the next picture is drawn.

    Attributes:
        step: index into `FRACTIONS`, used while moving.
    """

    step: int = 0

    def fraction(self, is_moving: bool) -> float:
        """Returns the fraction of the resolution, 1 at rest."""
        return FRACTIONS[self.step] if is_moving else 1.0

    def measured(self, is_moving: bool, frame_s: float) -> "Pace":
        """Learns from the time that a picture took; pictures at rest say nothing about motion."""
        if not is_moving:
            return self
        if frame_s > TARGET_S and self.step + 1 < len(FRACTIONS):
            # Cost goes with the pixels at most: jump to the step that would have been in time.
            wanted = FRACTIONS[self.step] * (TARGET_S / frame_s) ** 0.5
            steps = range(self.step + 1, len(FRACTIONS))
            return replace(self, step=next((i for i in steps if FRACTIONS[i] <= wanted), len(FRACTIONS) - 1))
        if self.step > 0:
            dearer = frame_s * (FRACTIONS[self.step - 1] / FRACTIONS[self.step]) ** 2
            if dearer < MARGIN * TARGET_S:
                return replace(self, step=self.step - 1)
        return self


def wait_s(is_moving: bool, is_busy: bool) -> float:
    """Returns how long the loop may sleep for input, s: a laptop's battery is the user's."""
    if is_moving:
        return 0.0
    return BUSY_WAIT_S if is_busy else IDLE_WAIT_S
