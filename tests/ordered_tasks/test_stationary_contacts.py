"""Contacts end when a region leaves its stance position; swing heels are guided until landing."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.state import BodyState
from plantigrade.ordered_tasks import TASKS, gait_order
from plantigrade.ordered_tasks.gait import rates_through
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.ordered_tasks.stationary_contacts import stationary_contacts
from plantigrade.wbc.stepping import first_state
from plantigrade.wbc.tasks import ContactTask
from tests.models.presets import person
from tests.ordered_tasks.walks import reference

TIME = np.linspace(0.0, 1.0, 101)


@pytest.mark.parametrize(("region", "rises"), [("heel", True), ("toes", False)])
def test_a_contact_ends_when_the_region_leaves_its_position(region, rises):
    """The whole body moves up or forwards at 0.1 m/s from 0.6 s on."""
    human = person("42", "two-segment")
    qpos = np.tile(human.standing(), (len(TIME), 1))
    qpos[:, 2 if rises else 0] += np.maximum(TIME - 0.6, 0.0) * 0.1
    events = [ContactInterval("r", region, 0.1, 0.9), ContactInterval("l", region, 0.1, 0.65)]
    late, early = stationary_contacts(human, TIME, qpos, events)
    assert late.stop == pytest.approx(0.6 + 0.01 / 0.1, abs=0.011)
    assert early == events[1]  # it had not left when the contact ended


def test_a_contact_at_the_end_of_the_recording_is_unchanged():
    human = person("42", "two-segment")
    qpos = np.tile(human.standing(), (len(TIME), 1))
    qpos[:, 0] += np.maximum(TIME - 0.6, 0.0)
    last = ContactInterval("r", "toes", 0.1, 1.0)
    assert stationary_contacts(human, TIME, qpos, [last]) == (last,)


def test_a_late_heel_is_guided_until_it_lands():
    known = reference()
    schedule = ContactSchedule(known, known.held)
    contact = ContactTask(schedule.points, schedule)
    strike = next(e for e in known.events if e.kind == "heel_strike" and e.time > known.start + 0.3)
    time = strike.time + 1e-3
    high = known.at(time)
    high[2] += 0.05
    state = BodyState(known.human, high)
    contact.begin(state, time)
    assert len(schedule.swing(strike.side)(state, time)) == 0  # landed according to the schedule
    assert len(schedule.swing(strike.side, contact)(state, time)) == 2


def test_the_heel_of_a_flat_foot_is_not_guided_forwards():
    known = reference()
    schedule = ContactSchedule(known, known.held)
    contact = max((c for c in known.held if c.region == "heel"), key=lambda c: c.stop - c.start)
    ends = [c.stop for c in known.held if c.side == contact.side and c.region == "toes"]
    last = min(stop for stop in ends if stop > contact.stop)
    directions = schedule.roll(contact.side)
    flat = BodyState(known.human, known.at(contact.start + 0.5 * (contact.stop - contact.start)))
    steep = BodyState(known.human, known.at(last - 0.01))
    assert len(directions(flat, contact.stop + 1e-3)) == 0
    assert len(directions(steep, last - 0.01)) == 1


def test_feet_below_the_ground_are_raised_vertically():
    known = reference()
    strike = next(e.time for e in known.events if e.kind == "heel_strike")
    qpos = known.at(strike)
    qpos[2] -= 0.02
    sunk = BodyState(known.human, qpos)
    order = gait_order(known, TASKS["default"])
    lifted = first_state(sunk, order, strike)
    for side in ("r", "l"):
        way = lifted.position(known.heel_point[side])[0] - sunk.position(known.heel_point[side])[0]
        assert abs(way[0]) < 0.012, side
    assert ContactSchedule(known, known.held).points.height(lifted).min() > -0.002


def test_rates_of_a_linear_motion_are_constant():
    """The sign of quaternions does not matter."""
    human = person("42", "two-segment")
    knots = np.array([0.0, 0.1, 0.5, 0.6, 1.0])
    knee = 7 + human.hinge("knee_angle_r")
    postures = np.tile(human.standing(), (5, 1))
    postures[:, 0] += 1.3 * knots
    postures[:, knee] = 0.2 + 0.5 * knots
    rates = rates_through(human, knots, postures)
    np.testing.assert_allclose(rates[:, 0], 1.3, atol=1e-6)
    np.testing.assert_allclose(rates[:, knee - 1], 0.5, atol=1e-6)
    postures[2, 3:7] *= -1
    np.testing.assert_allclose(rates_through(human, knots, postures), rates, atol=1e-9)


def test_the_forces_stage_keeps_the_contacts_of_the_events():
    known = reference()
    shorter = replace(known, held=known.contacts[:1])
    by_events = ContactSchedule(shorter)
    assert by_events(known.start + 0.2).any()
    assert not ContactSchedule(shorter, shorter.held)(known.stop - 0.05).any()
