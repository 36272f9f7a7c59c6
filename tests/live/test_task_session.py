"""A task that is changed while it is solved."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from plantigrade.errors import ParameterError
from plantigrade.live.task_controls import Control
from plantigrade.live.task_session import (
    MAX_OUTDATED_TIME,
    SETTLING_TIME,
    TaskSession,
    run,
    with_reference,
)
from plantigrade.record import Run
from tests.pages.walker import walk, walker

SPEED = Control(name="speed", label="speed", unit="m/s", low=0.5, high=2.0, value=1.0)
RECORD = walk(walker(), duration=0.1)


class Solver:
    """Solves at once, or fails; what happens meanwhile can be given."""

    def __init__(self):
        self.time, self.speeds, self.warm, self.meanwhile = 100.0, [], [], []

    def __call__(self, values, warm, progress):
        self.speeds.append(values["speed"])
        self.warm.append(warm)
        while self.meanwhile:
            wait, act = self.meanwhile.pop(0)
            self.time += wait
            act()
            progress("warm start", SimpleNamespace(number=3))
        if values["speed"] > 1.8:
            raise ParameterError("nobody walks so fast")
        status = "ok" if values["speed"] < 1.6 else "the foot slips"
        return Run(replace(RECORD), "synthesize", "A walk", "", status)


@pytest.fixture
def solver():
    """A solver, and the time."""
    return Solver()


@pytest.fixture
def session(solver):
    """A task that has been solved once."""
    made = TaskSession([SPEED], solver, lambda: solver.time)
    assert made.advance() and not made.advance()
    return made


def change(session, solver, speed):
    """Change the speed, wait, and solve."""
    session.set("speed", speed)
    solver.time += SETTLING_TIME
    assert session.advance()


def test_a_change_is_solved_from_the_last_motion_once_it_rests(session, solver):
    first = session.shown
    assert solver.warm == [None] and first.values == {"speed": 1.0}
    session.set("speed", 1.1)
    assert not session.advance()
    session.set("speed", 1.2)
    solver.time += SETTLING_TIME
    assert session.advance() and not session.advance()
    assert solver.speeds == [1.0, 1.2] and solver.warm[1] is first.run.record
    assert session.shown.values == {"speed": 1.2} and session.busy == ""


def test_the_last_good_motion_stays(session, solver):
    good = session.shown
    change(session, solver, 1.7)
    assert session.shown is good and session.message == "the foot slips"
    change(session, solver, 1.9)
    assert session.shown is good and session.message == "nobody walks so fast"
    change(session, solver, 1.4)
    assert session.shown.values == {"speed": 1.4} and session.message == ""
    assert solver.warm[-1] is good.run.record


def test_a_first_motion_is_shown_even_if_it_failed(solver):
    session = TaskSession([replace(SPEED, value=1.7)], solver, lambda: solver.time)
    session.advance()
    assert session.shown.run.status == session.message == "the foot slips"


def test_what_is_outdated_is_given_up_late_and_finished_early(session, solver):
    solver.meanwhile = [(0.0, lambda: session.set("speed", 1.3))]
    change(session, solver, 1.2)
    assert session.shown.values == {"speed": 1.2}  # it follows while a slider moves
    solver.time += SETTLING_TIME
    assert session.advance() and session.shown.values == {"speed": 1.3}
    late = MAX_OUTDATED_TIME + 0.1
    solver.meanwhile = [(late, lambda: session.set("speed", 1.5))]
    change(session, solver, 1.4)
    assert session.shown.values == {"speed": 1.3} and session.busy == ""
    solver.time += SETTLING_TIME
    assert session.advance() and session.shown.values == {"speed": 1.5}


def test_the_stage_is_told_and_the_display_is_woken(session, solver):
    seen = []

    def look():
        session.changed.clear()
        seen.append(session.busy)

    solver.meanwhile = [(0.0, lambda: None), (0.0, look)]
    change(session, solver, 1.2)
    assert seen == ["warm start, iteration 3"] and session.changed.is_set()


def test_motions_are_kept_compared_and_returned_to(session, solver):
    session.keep()
    session.keep()
    first = session.shown
    change(session, solver, 1.4)
    assert session.kept == (first,)
    session.compare(0)
    drawn = with_reference(session.shown, session.compared)
    assert list(drawn.references.values()) == [first.run.record.motion]
    session.restore(0)
    solver.time += SETTLING_TIME
    assert session.values == {"speed": 1.0} and session.shown is first
    assert not session.advance()  # it is there already
    assert with_reference(session.shown, session.compared) is first.run.record
    session.compare(None)
    assert session.compared is None
    for act in (session.compare, session.restore):
        with pytest.raises(ParameterError, match="kept"):
            act(1)


def test_values_that_no_control_has_are_refused(session):
    for name, value in (("sped", 1.0), ("speed", 3.0), ("speed", "fast")):
        with pytest.raises(ParameterError):
            session.set(name, value)
    session.set("speed", 1.5)
    session.reset()
    assert session.values == {"speed": 1.0}


def test_the_end_of_a_session_ends_what_is_being_solved(session, solver):
    solver.meanwhile = [(0.0, session.ended.set)]
    session.set("speed", 1.2)
    solver.time += SETTLING_TIME
    run(session)
    assert session.shown.values == {"speed": 1.0} and session.values == {"speed": 1.2}
