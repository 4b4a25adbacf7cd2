"""Fluid motion on slow machines."""

import pytest

from wzviewer.app.pacing import FRACTIONS, TARGET_S, Pace, wait_s


def settled(cost_s):
    pace = Pace()
    for _ in range(20):
        pace = pace.measured(True, cost_s * pace.fraction(True) ** 2)
    return pace


def test_at_rest_the_picture_is_whole():
    slow = settled(1.0)
    assert slow.fraction(False) == 1.0
    assert slow.fraction(True) == FRACTIONS[-1]
    assert slow.measured(False, 9.0) == slow


def test_a_fast_machine_never_loses_a_pixel():
    assert settled(0.001) == Pace()


def test_it_recovers_and_does_not_swing():
    pace = settled(3.0 * TARGET_S)
    assert 0 < pace.step
    steps = set()
    for _ in range(20):
        pace = pace.measured(True, 1.5 * TARGET_S * pace.fraction(True) ** 2)
        steps.add(pace.step)
    assert len(steps) == 1
    for _ in range(5):
        pace = pace.measured(True, 0.1 * TARGET_S * pace.fraction(True) ** 2)
    assert pace.step == 0


def test_an_idle_window_sleeps():
    assert wait_s(True, True) == 0.0
    assert 0.0 < wait_s(False, True) < wait_s(False, False)


def test_where_the_processor_is_shared_the_worker_gets_the_rest_of_each_frame():
    assert wait_s(True, True, 0.010) == pytest.approx(1 / 20 - 0.010)
    assert wait_s(True, True, 0.060) == 0.0
    assert wait_s(False, True, 0.010) == wait_s(False, True)
