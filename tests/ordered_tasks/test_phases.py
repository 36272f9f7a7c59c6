"""Phases from events, with complete and missing events."""

import numpy as np
import pytest

from plantigrade.errors import ParameterError, ReproduceError
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.motion import GaitEvent
from plantigrade.ordered_tasks import reference_of
from plantigrade.ordered_tasks.gait import leg_shortest, phase_ends, shank_upright
from plantigrade.ordered_tasks.phases import phases_between, walking_events
from tests.models.presets import person
from tests.ordered_tasks.walks import reference

STRIDE = 1.1


def events(strides: float = 2.0, start: float = 0.0) -> list[GaitEvent]:
    """Even walking: right heel strike at the start, toe off at 60 % of the stride."""
    table = [("r", "heel_strike", 0.0), ("l", "toe_off", 0.1), ("l", "heel_strike", 0.5)]
    table += [("r", "toe_off", 0.6)]
    found = [
        GaitEvent(start + STRIDE * (k + share), side, kind)
        for k in range(int(np.ceil(strides)) + 1)
        for side, kind, share in table
        if k + share <= strides + 1e-9
    ]
    return sorted(found, key=lambda e: e.time)


def test_a_cycle_has_two_double_and_two_single_supports():
    phases = phases_between(walking_events(events(1.0)))
    assert [p.kind for p in phases] == ["double", "single", "double", "single"]
    assert [p.swing for p in phases] == ["l", "l", "r", "r"]
    np.testing.assert_allclose([p.duration for p in phases], STRIDE * np.array([0.1, 0.4] * 2))


def test_phases_are_contiguous_and_alternate():
    found = walking_events(events(3.0))
    phases = phases_between(found)
    assert len(phases) == len(found) - 1 == 12
    for a, b in zip(phases[:-1], phases[1:], strict=True):
        assert a.stop == b.start
        assert a.kind != b.kind
        if a.kind == "double":
            assert a.swing == b.swing  # the foot that will swing next


def test_order_of_the_list_does_not_matter():
    shuffled = events(2.0)
    np.random.default_rng(0).shuffle(shuffled)
    assert walking_events(shuffled) == tuple(events(2.0))


def test_a_missing_event_divides_the_walk_and_the_longer_part_counts():
    whole = events(4.0)
    gone = 5
    assert walking_events(whole[:gone] + whole[gone + 1 :]) == tuple(whole[gone + 1 :])


def test_a_stop_ends_the_walk():
    """A long double support counts as standing."""
    first, second = events(1.0), events(2.0, start=9.0)
    first = [e for e in first if e.time < 1.0]  # ends with the right toe off at 0.66 s
    joined = [*first, GaitEvent(8.9, "r", "heel_strike"), *second[1:]]
    found = walking_events(joined)
    assert found[0].time > 8.0 and len(found) == len(second)


def test_two_consecutive_steps_of_one_foot_divide_the_walk():
    whole = events(3.0)
    step = [GaitEvent(1.30, "r", "toe_off"), GaitEvent(1.45, "r", "heel_strike")]
    turned = sorted([*whole, *step], key=lambda e: e.time)
    found = walking_events(turned)
    assert len(found) < len(turned)
    assert all(b.time - a.time < STRIDE for a, b in zip(found[:-1], found[1:], strict=True))
    kinds = [(e.side, e.kind) for e in found]
    for (side, kind), (next_side, next_kind) in zip(kinds[:-1], kinds[1:], strict=True):
        assert kind != next_kind
        assert (side == next_side) == (kind == "toe_off")


def test_too_few_events_raise():
    assert walking_events([]) == ()
    assert phases_between(()) == ()
    walk = textbook_walk(person("42", "two-segment"), cycles=1)
    with pytest.raises(ReproduceError, match="at least three"):
        reference_of(walk.human, walk.time, walk.qpos, list(walk.events[:2]))


def test_stances_seen_whole_and_in_part():
    found = stances(events(2.0), "l", 0.0, 2.2)
    assert [stance.whole for stance in found] == [False, True, False]
    assert found[0].start == 0.0 and found[-1].stop == 2.2
    starts = [stance.start for stance in found[1:]]
    np.testing.assert_allclose(starts, [0.5 * STRIDE, 1.5 * STRIDE])


def test_phase_ends_of_each_division():
    known = reference()
    two, four, six, eight = (phase_ends(known, n) for n in ("two", "four", "six", "eight"))
    singles = [p for p in known.phases if p.kind == "single"]
    assert set(two) <= set(four) <= set(six) <= set(eight)
    assert len(four) == len(known.phases)
    assert len(six) == len(four) + len(singles)
    assert len(eight) == len(four) + 2 * len(singles)
    for ends in (two, four, six, eight):
        assert (np.diff(ends) > 0).all() and ends[-1] == known.stop
    strikes = [e.time for e in known.events if e.kind == "heel_strike"]
    assert set(two) <= {*strikes, known.stop}
    with pytest.raises(ParameterError, match="two, four, six, eight"):
        phase_ends(known, "five")


def test_a_swing_is_divided_where_the_leg_is_shortest():
    """The instant lies within the swing, near the maximum knee flexion."""
    known = reference()
    for phase in known.phases:
        if phase.kind == "single":
            at = leg_shortest(known, phase)
            assert phase.start < at < phase.stop
            knee = 7 + known.human.hinge(f"knee_angle_{phase.swing}")
            swing = known.at(np.linspace(phase.start, phase.stop, 60))[:, knee]
            assert known.at(at)[knee] > swing.min() + 0.7 * np.ptp(swing)


def test_mid_swing_ends_where_the_shank_is_vertical():
    """The instant follows that of the shortest leg; the ankle is then below the knee."""
    known = reference()
    for phase in known.phases:
        if phase.kind == "single":
            shortest = leg_shortest(known, phase)
            at = shank_upright(known, phase, shortest)
            assert shortest < at < phase.stop
            bodies = [f"tibia_{phase.swing}", f"foot_{phase.swing}"]
            joints = PointSet(known.human, bodies, np.zeros((2, 3)))
            knee, ankle = joints.path(known.at(np.array([at])))[0]
            assert abs(ankle - knee)[0] < 0.02 < knee[2] - ankle[2]
