"""Holding another thread back, and waiting for it, without ever hanging."""

import threading

PATIENCE_S = 20.0


class Gate:
    """Open at first; while it is closed, `pass_through` waits."""

    def __init__(self):
        self.open, self.entered = threading.Event(), threading.Semaphore(0)
        self.open.set()

    def pass_through(self):
        """For the thread that is held back."""
        self.entered.release()
        assert self.open.wait(PATIENCE_S)

    def wait(self):
        """Until one more call has come to the gate."""
        assert self.entered.acquire(timeout=PATIENCE_S)


def until(condition):
    """Waits for what another thread does."""
    ticks = threading.Event()
    for _ in range(int(PATIENCE_S / 0.005)):
        if condition():
            return
        ticks.wait(0.005)
    raise AssertionError("it never came")
