"""Offsets of feet and the divergent component of motion; where and when the next foot lands."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.control.gait.divergent import offset_weights
from plantigrade.control.gait.edges import lifts, on_one_side
from plantigrade.control.gait.planner import FootstepLimits, FootstepSettings, next_step
from plantigrade.control.gait.swing import SwingOffset

OMEGA, STEP = 3.2, 0.002
SINGLE, STEPS = 0.5, 12  # length of a step [s], their number


@pytest.fixture(scope="module")
def alpha():
    """One foot after the other, each alone for half a second."""
    n = round(SINGLE / STEP)
    return np.repeat(np.eye(STEPS), n, axis=0)


@pytest.fixture(scope="module")
def beta(alpha):
    return offset_weights(alpha, OMEGA, STEP)


def test_the_weights_of_offsets_sum_to_one_and_fade_from_step_to_step(beta):
    np.testing.assert_allclose(beta.sum(axis=1), 1.0, atol=1e-12)
    n = round(SINGLE / STEP)
    # At the start of a step, its own share of what comes is 1 - exp(-omega T).
    np.testing.assert_allclose(beta[0, 0], 1.0 - np.exp(-OMEGA * SINGLE), atol=2e-3)
    np.testing.assert_allclose(beta[0, 1] / beta[n, 1], np.exp(-OMEGA * SINGLE), rtol=1e-2)


def test_in_flight_the_weights_wait_for_the_landing():
    alpha = np.array([[1.0, 0.0]] * 3 + [[0.0, 0.0]] * 4 + [[0.0, 1.0]] * 3)
    beta = offset_weights(alpha, OMEGA, STEP)
    np.testing.assert_allclose(beta[3:7], np.tile([0.0, 1.0], (4, 1)))


def pendulum(xi, foot, seconds):
    """Return where the divergent component is after standing on a foot."""
    return foot + np.exp(OMEGA * seconds) * (xi - foot)


def wide(**settings):
    zero = np.zeros(2)
    return FootstepLimits(np.eye(2), np.array([0.5, 0.1]), 1.0, 5.0, -5.0, zero, **settings)


def test_the_next_foot_lands_where_the_pendulum_goes_on_undisturbed(beta):
    """Offsets that shrink from step to step are each found again at their own step."""
    n = round(SINGLE / STEP)
    feet = np.array([[0.4 * k, 0.1 * (-1.0) ** k] for k in range(STEPS)])
    planned = feet[-1]  # the divergent component of the motion itself, at each touchdown
    xi = {STEPS - 1: planned}
    for k in range(STEPS - 2, -1, -1):
        planned = feet[k] + np.exp(-OMEGA * SINGLE) * (planned - feet[k])
        xi[k] = planned
    offsets = np.zeros((STEPS, 2))
    offsets[0] = [0.05, -0.02]
    offsets[1:] = (
        np.array([0.08, 0.03]) * FootstepSettings().offset_decay ** np.arange(STEPS - 1)[:, None]
    )
    start = xi[0] + beta[0] @ offsets
    gone = 0.2
    now = pendulum(start, feet[0] + offsets[0], gone)
    step = next_step(
        now,
        pendulum(xi[0], feet[0], gone),
        xi[1],
        OMEGA,
        SINGLE - gone,
        offsets[0],
        offsets[0],
        float(beta[n, 0]),
        FootstepSettings().split(1, beta[n, 1:], 1)[1],
        wide(settings=FootstepSettings(rates=(1.0,))),
    )
    np.testing.assert_allclose(step.offset, offsets[1], atol=2e-3)
    assert step.rate == 1.0


def test_what_is_undisturbed_steps_as_planned_in_its_own_time():
    xi, foot = np.array([0.05, 0.02]), np.zeros(2)
    then = pendulum(xi, foot, 0.3)
    zero = np.zeros(2)
    step = next_step(xi, xi, then, OMEGA, 0.3, zero, zero, 0.0, 1.0, wide())
    np.testing.assert_allclose(step.offset, 0.0, atol=1e-12)
    assert step.rate == 1.0


def test_a_push_outward_is_answered_by_a_sooner_step_within_the_limits():
    xi, foot, zero = np.array([0.05, 0.02]), np.zeros(2), np.zeros(2)
    then = pendulum(xi, foot, 0.4)
    box = FootstepLimits(
        np.eye(2),
        np.array([0.5, 0.1]),
        1.0,
        0.9,
        0.07,
        np.array([-0.5, 0.0]),
        max_foot_acceleration=60.0,
    )
    pushed = xi - [0.0, 0.18]  # to the side of the foot that stands: the other cannot follow
    step = next_step(pushed, xi, then, OMEGA, 0.4, zero, zero, 0.0, 1.0, box)
    assert step.rate > 1.0
    assert 0.1 + step.offset[1] >= box.crossover_width - 1e-9  # no farther across than in front
    assert step.unconstrained[1] < step.offset[1]


def test_a_swinging_foot_reaches_its_offset_in_time_at_rest():
    swing, goal = SwingOffset(np.array([0.1, 0.0])), np.array([0.1, 0.15])
    for left in np.arange(0.4, 0.0, -STEP):
        swing.lead(goal, float(left), STEP)
    np.testing.assert_allclose(swing.offset, goal, atol=2e-3)
    np.testing.assert_allclose(swing.velocity, 0.0, atol=0.1)


def test_of_two_rates_the_one_is_taken_whose_miss_the_next_foot_makes_up_on_its_own_side():
    box = FootstepLimits(
        np.eye(2), np.array([0.4, 0.1]), 1.0, 0.9, 0.07, np.zeros(2), max_foot_acceleration=60.0
    )
    missed = np.array([[0.0, -0.2], [0.0, 0.2]])  # the left foot lands; the right one comes next
    outward, inward = box.next_step_cost(missed)
    assert outward < 0.1 * inward
    assert box.next_step_cost(np.array([[0.0, -0.8]]))[0] > 10.0 * outward  # no leg is so long


def test_a_foot_crosses_over_only_in_front_of_the_other():
    box = FootstepLimits(
        np.eye(2), np.array([0.0, 0.1]), 1.0, 0.9, 0.07, np.zeros(2), max_foot_acceleration=60.0
    )
    ((beside, ahead),) = box.constrained(np.array([[0.1, -0.4], [0.5, -0.4]]))
    assert 0.1 + beside[1] == pytest.approx(0.07)
    assert box.crossover_width < 0.0 and 0.1 + ahead[1] == pytest.approx(box.crossover_width)


def test_a_foot_that_would_have_to_be_too_fast_costs_more():
    box = FootstepLimits(
        np.eye(2),
        np.array([0.4, 0.1]),
        1.0,
        0.9,
        0.07,
        np.array([-0.6, 0.0]),
        max_foot_acceleration=60.0,
    )
    slow, fast = box.swing_cost(np.zeros((2, 2)), np.array([0.4, 0.1]))
    assert slow == 0.0 < fast


def test_a_foot_held_back_goes_on_from_there_and_no_longer_inward():
    swing = SwingOffset(np.array([0.1, 0.0]))
    swing.lead(np.array([0.1, -0.3]), 0.2, STEP)
    assert swing.velocity[1] < 0.0
    swing.hold_back(np.array([0.0, 1.0]), 0.02)
    assert swing.velocity[1] == swing.acceleration[1] == 0.0
    assert swing.offset[1] == pytest.approx(0.02, abs=1e-3)


def test_a_foot_may_be_nearer_to_the_line_of_the_other_one_the_farther_ahead_it_is():
    held = []
    for ahead in (0.1, 0.5, -0.5):
        swing = SwingOffset(np.array([ahead, -0.3]))
        swing.pass_beside(np.zeros(2), np.array([0.0, 0.2]), np.eye(2), 1.0, 1.0, 0.0)
        held.append(swing.offset[1])
    # 0.08 to its side, and less by what it is farther off than 0.3 leg lengths.
    assert held == pytest.approx([0.08, -0.02, -0.02])


def test_a_swinging_foot_is_lifted_over_an_edge_and_nowhere_else():
    ground = Ground(steps=(GroundStep(1.0, 0.1),))
    x = np.concatenate([np.full(20, 0.5), np.linspace(0.5, 1.3, 61), np.full(20, 1.3)])
    stands = np.ones(101, dtype=bool)
    stands[20:81] = False
    low = np.zeros((101, 1, 3))
    low[:, 0, 0] = x
    low[:, 0, 2] = np.where(x < 1.0, 0.05, 0.1) * (x > 0.5)
    lift = lifts(ground, low, stands, 0.01)
    passes = (np.abs(x - 1.0) < 0.05) & ~stands
    assert (low[passes, 0, 2] + lift[passes]).min() > 0.11
    assert not lift[stands].any() and not lift[x < 0.7].any()
    assert not lifts(Ground(), low, stands, 0.01).any()


def test_a_foot_lands_wholly_on_the_level_it_is_planned_to():
    ground = Ground(steps=(GroundStep(1.0, 0.1),))
    low = np.array([[1.08, 0.0, 0.1], [1.30, 0.0, 0.1]])
    ahead = np.array([1.0, 0.0])
    np.testing.assert_allclose(on_one_side(ground, low, np.zeros(2), ahead), 0.0)
    back = on_one_side(ground, low, np.array([-0.12, 0.03]), ahead)
    assert 1.08 + back[0] >= 1.02 - 1e-9 and back[1] == 0.03
    assert back[0] < -0.03  # no farther than need be


def test_a_foot_that_is_on_its_way_already_gets_farther_in_time():
    box = FootstepLimits(
        np.eye(2), np.zeros(2), 1.0, 0.9, 0.07, np.zeros(2), max_foot_acceleration=60.0
    )
    goal, left = np.array([[0.3, 0.0]]), np.array([0.15])
    assert box.swing_cost(goal, left)[0] > 0.0
    swift = replace(box, foot_velocity=np.array([3.0, 0.0]))
    assert swift.swing_cost(goal, left)[0] == 0.0
