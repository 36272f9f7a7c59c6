import numpy as np
import pytest
import scipy.interpolate

from plantigrade.errors import ParameterError
from plantigrade.motion import GaitEvent
from plantigrade.motion.cycles import cut_cycles, frames_near, normalise, normalise_cycles


def events(*rows):
    return [GaitEvent(t, s, {"h": "heel_strike", "t": "toe_off"}[k]) for t, s, k in rows]


def test_cycles_and_their_events():
    found = cut_cycles(
        events((0.0, "r", "h"), (0.1, "l", "t"), (0.5, "l", "h"), (0.6, "r", "t"), (1.0, "r", "h"))
    )
    assert len(found) == 1
    cycle = found[0]
    assert (cycle.side, cycle.duration, cycle.percent(cycle.toe_off)) == ("r", 1.0, 60.0)
    assert (cycle.opposite_toe_off, cycle.opposite_heel_strike) == (0.1, 0.5)


def test_missed_steps_make_no_cycle():
    rows = [(0.0, "r", "h"), (0.6, "r", "t"), (1.0, "r", "h"), (2.0, "r", "h"), (6.0, "r", "h")]
    assert [c.stop for c in cut_cycles(events(*rows))] == [1.0]


def test_normalise():
    time = np.arange(200) / 100
    curve = normalise(time, np.sin(2 * np.pi * time), 0.25, 1.25)
    np.testing.assert_allclose(curve, np.cos(2 * np.pi * np.linspace(0, 1, 101)), atol=1e-5)
    cycles = cut_cycles(events((0.25, "r", "h"), (0.8, "r", "t"), (1.25, "r", "h")))
    assert normalise_cycles(time, np.ones((200, 2, 3)), cycles).shape == (1, 101, 2, 3)
    assert normalise_cycles(time, np.ones(200), ()).shape == (0, 101)
    with pytest.raises(ParameterError, match="end after"):
        normalise(time, time, 1.0, 1.0)


def strides(count):
    """Return a clock, a curve and the cycles of so many seconds, a stride each."""
    time = np.arange(100 * count + 1) / 100
    heels = [GaitEvent(float(k), "r", "heel_strike") for k in range(count + 1)]
    return time, np.sin(2 * np.pi * time) + 0.1 * time, cut_cycles(heels)


def test_the_work_grows_with_the_recording_not_with_its_square(monkeypatch):
    fitted = []

    class Counted(scipy.interpolate.CubicSpline):
        def __init__(self, x, y, *rest, **options):
            fitted.append(len(x))
            super().__init__(x, y, *rest, **options)

    monkeypatch.setattr(scipy.interpolate, "CubicSpline", Counted)
    work = []
    for count in (10, 20):
        fitted.clear()
        assert normalise_cycles(*strides(count)).shape == (count, 101)
        work.append(sum(fitted))  # samples that splines are fitted to
    assert work[1] < 2.2 * work[0]


def test_a_curve_over_one_cycle_needs_the_frames_near_it():
    time, values, cycles = strides(8)
    for cycle, whole in zip(cycles, normalise_cycles(time, values, cycles), strict=True):
        near = frames_near(time, cycle)
        assert len(time[near]) <= 201
        part = normalise_cycles(time[near], values[near], [cycle])[0]
        np.testing.assert_allclose(part, whole, rtol=0, atol=1e-14)
