"""The pendulum without a body: its energy and strikes, footsteps by both laws and within reach."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from plantigrade.constants import GRAVITY
from plantigrade.control.gait.person import GaitPerson
from plantigrade.control.pendulum import PendulumSettings
from plantigrade.control.pendulum.footstep import FootReach, next_footstep
from plantigrade.control.pendulum.landing_laws import (
    LAWS,
    DivergentLaw,
    EnergyLaw,
    ReferenceTouchdown,
    energy_after_strike,
    landing_angle,
    leg_length,
    linear_pendulum,
    speed_after_strike,
)
from plantigrade.models import Human

LEG = 0.95
OMEGA, PERIOD = float(np.sqrt(GRAVITY / LEG)), 0.5
SETTINGS = PendulumSettings()


def test_the_linear_pendulum_moves_as_its_equation_of_motion_says():
    place, speed = linear_pendulum(
        np.array([0.1, -0.02]), np.array([0.4, 0.1]), np.zeros(2), OMEGA, 0.3
    )
    ode = solve_ivp(
        lambda t, y: [*y[2:], *(OMEGA**2 * y[:2])],
        (0, 0.3),
        [0.1, -0.02, 0.4, 0.1],
        rtol=1e-10,
        atol=1e-12,
    )
    np.testing.assert_allclose([*place, *speed], ode.y[:, -1], rtol=1e-7)


def test_a_strike_takes_the_velocity_along_the_new_leg():
    # Velocity across the old leg, split along and across the new one.
    velocity = 1.3 * np.array([np.cos(0.3), -np.sin(0.3)])
    across = np.array([np.cos(0.4), np.sin(0.4)])
    assert speed_after_strike(1.3, 0.7) == pytest.approx(velocity @ across)


def test_the_leg_that_strikes_a_slope_reaches_from_the_mass_to_the_slope():
    slope, trailing, leading, height = 0.2, 0.25, 0.35, 1.0
    length = float(leg_length(height, trailing, leading, slope))
    mass = np.array([height * np.tan(trailing), height])
    foot = mass + length * np.array([np.sin(leading), -np.cos(leading)])
    assert foot[1] == pytest.approx(np.tan(slope) * foot[0])
    assert leg_length(height, trailing, leading) == pytest.approx(height / np.cos(leading))


@pytest.mark.parametrize("slope", [-0.15, 0.0, 0.15])
def test_the_landing_angle_leaves_the_desired_energy(slope):
    speed, trailing, leading = 1.5, 0.3, 0.33
    length = leg_length(1.0, trailing, leading, slope)
    energy = float(energy_after_strike(speed, trailing, leading, length))
    assert landing_angle(speed, trailing, 1.0, energy, slope) == pytest.approx(leading, abs=1e-9)
    speeds = np.array([1.5, 1.7, 1.9])
    angles = landing_angle(speeds, trailing, 1.0, energy, slope)
    assert (np.diff(angles) > 0.01).all()  # faster, it steps farther
    left = energy_after_strike(speeds, trailing, angles, leg_length(1.0, trailing, angles, slope))
    np.testing.assert_allclose(left, energy, rtol=1e-9)
    assert landing_angle(0.0, trailing, 1.0, 12.0, slope) < 1e-6  # too slow for any step


@pytest.fixture(scope="module")
def touchdown() -> ReferenceTouchdown:
    """That of a periodic walk of the linear pendulum: 0.6 m ahead, 0.12 m apart."""
    step = np.array([0.6, 0.12])
    c, s = np.cosh(OMEGA * PERIOD), np.sinh(OMEGA * PERIOD)
    start = 0.5 * np.array([-0.6, 0.12])  # in the middle between the feet
    speed = OMEGA / s * np.array([0.3 * (c + 1), 0.06 * (1 - c)])
    com, velocity = linear_pendulum(start, speed, np.zeros(2), OMEGA, PERIOD)
    return ReferenceTouchdown(com, velocity, LEG, np.zeros(2), step, OMEGA)


def walked(law, touchdown: ReferenceTouchdown, steps: int, com, velocity):
    """Return footsteps from a state at a touchdown on, and the last velocity; no double support."""
    stance, side, feet = touchdown.stance_foot, 1.0, []
    for _ in range(steps):
        mirror = np.array([1.0, side])
        mine = replace(
            touchdown,
            com=stance + mirror * (touchdown.com - touchdown.stance_foot),
            com_velocity=mirror * touchdown.com_velocity,
            stance_foot=stance,
            footstep=stance + mirror * (touchdown.footstep - touchdown.stance_foot),
        )
        stance = law.footsteps(com[None], velocity[None], stance, mine)[0]
        feet.append(stance)
        com, velocity = linear_pendulum(com, velocity, stance, OMEGA, PERIOD)
        side = -side
    return np.array(feet), velocity


@pytest.mark.parametrize("name", list(LAWS))
def test_undisturbed_all_laws_walk_the_periodic_orbit(name, touchdown):
    feet, velocity = walked(LAWS[name], touchdown, 6, touchdown.com, touchdown.com_velocity)
    np.testing.assert_allclose(np.diff(feet[:, 0]), 0.6, atol=1e-6)
    np.testing.assert_allclose(np.diff(feet[:, 1]), [-0.12, 0.12, -0.12, 0.12, -0.12], atol=1e-6)
    np.testing.assert_allclose(velocity, touchdown.com_velocity, atol=1e-5)


def test_after_a_push_the_extrapolated_centre_brings_the_orbit_back(touchdown):
    pushed = touchdown.com_velocity + [0.3, 0.1]
    _, velocity = walked(DivergentLaw(), touchdown, 8, touchdown.com, pushed)
    np.testing.assert_allclose(velocity, touchdown.com_velocity, atol=1e-6)
    # The energy law steps farther, too, but less: it counts on what the strike takes.
    state = touchdown.com[None], pushed[None], touchdown.stance_foot, touchdown
    energy, divergent = (
        law.footsteps(*state)[0] - touchdown.footstep for law in (EnergyLaw(True), DivergentLaw())
    )
    assert (0.0 < energy).all() and (energy < divergent).all()


def test_a_foot_carries_alone_where_the_stance_foot_is_lifted_sooner(touchdown):
    """Without its double support the walk steps as the one that has none."""
    share, moved = 0.3, np.array([0.05, -0.1])
    nearer = share * (touchdown.footstep - touchdown.stance_foot)
    alone = replace(touchdown, com=touchdown.com - nearer, transferred=share)
    state = (touchdown.com + moved)[None], touchdown.com_velocity[None], touchdown.stance_foot
    own, expected = (DivergentLaw().footsteps(*state, ref) for ref in (alone, touchdown))
    np.testing.assert_allclose(own, expected, atol=1e-12)


@pytest.fixture
def reach(touchdown) -> FootReach:
    """The reach of a foot at rest."""
    return FootReach(
        axes=np.eye(2),
        nominal=touchdown.footstep,
        side=1.0,
        leg_length=0.9,
        min_width=0.06,
        swing_offset=np.zeros(2),
        settings=SETTINGS.footsteps,
        reach=SETTINGS.plan,
        max_descent=SETTINGS.tasks.weights.max_vertical_acceleration,
        clear_way=np.array([0.2, 0.08]),
        foot_velocity=np.zeros(2),
        max_foot_acceleration=SETTINGS.gait.swing.max_acceleration,
        hip=np.zeros(2),
        hip_height=0.8,
        hip_rise=0.0,
        offset=np.zeros(2),
        offset_velocity=np.zeros(2),
        leg_momentum=0.0,
    )


def test_footsteps_out_of_reach_are_sooner_or_shortened_and_feet_may_cross(touchdown, reach):
    com, origin = np.array([0.0, -0.02]), np.zeros(2)
    light = replace(reach, max_foot_acceleration=np.inf)  # the leg alone counts
    slow, fast = (
        next_footstep(DivergentLaw(), com, velocity, origin, origin, 0.2, touchdown, light)
        for velocity in (touchdown.com_velocity, touchdown.com_velocity + [1.2, 0.0])
    )
    assert fast.rate > slow.rate and fast.time < slow.time
    assert fast.position[0] > slow.position[0]
    past = reach.settings.crossover_length * 0.9
    asked = np.array([[3.0, 0.1], [0.1, 0.03], [0.8, -0.1], [0.0, 2.0]]) - touchdown.footstep
    beside, ahead, behind = (touchdown.footstep + way for way in reach.constrained(asked))
    np.testing.assert_allclose(beside[0], [reach.max_length, 0.1])
    np.testing.assert_allclose(beside[1], [0.1, 0.06])  # beside the other foot: not through it
    np.testing.assert_allclose(beside[3], [0.0, reach.max_width])
    np.testing.assert_allclose(ahead[1:3], [[past, 0.03], [0.8, -0.1]])
    np.testing.assert_allclose(behind[1:3], [[-past, 0.03], [-past, -0.1]])
    in_turn = replace(reach, may_cross=False).constrained(asked)
    placed = np.concatenate([touchdown.footstep + way for way in in_turn])
    assert placed[:, 1].min() == 0.0  # in line, but not across
    cost = reach.swing_cost(np.array([[0.3, 0.0], [0.9, 0.0]]), np.array([0.3, 0.1]))
    assert cost[0] == 0.0 < cost[1]  # feet are no faster than they can be
    later = replace(light, hip_height=0.9).at(np.zeros((3, 2)), np.array([0.05, 0.1, 0.6]))
    position = touchdown.footstep + later.constrained(np.tile([0.0, 2.0], (3, 1)))[0]
    # No farther than a leg reaches from a hip that descends; then no wider than the limit.
    span = np.linalg.norm(position, axis=1)
    np.testing.assert_allclose(span[:2], later.spans[:2])
    assert span[0] < span[1] < span[2] and np.all(position[:, 1] <= reach.max_width)


def test_a_foot_that_crosses_keeps_its_way(touchdown, reach):
    asked = np.array([[0.3, -0.3]]) - touchdown.footstep
    for taken, signs in ((0, [0, 1, -1]), (1, [0, 1]), (-1, [0, -1])):
        ways = replace(reach, way_taken=taken).constrained(asked)
        assert [reach.crossing_way(way[0]) for way in ways] == signs


def test_a_footstep_is_no_farther_than_the_swing_foot_comes(touchdown, reach):
    most, time = reach.max_foot_acceleration, np.array([0.1, 0.4])
    foot = replace(reach, swing_offset=np.array([-0.5, 0.0]), foot_velocity=np.array([1.0, 0.0]))
    soon, late = foot.at(np.full((2, 2), 0.1), time).constrained(np.zeros((2, 2)))[0]
    assert soon[0] == pytest.approx(-0.5 + 2.0 / 3.0 * 0.1 + most * 0.1**2 / 6.0)
    np.testing.assert_allclose(late, 0.0, atol=1e-12)
    assert foot.swing_cost(soon[None], time[:1])[0] == pytest.approx(0.0, abs=1e-9)


def test_a_miss_ahead_counts_once_all_steps_to_come_cannot_make_it_up(reach):
    assert SETTINGS.footsteps.lasting_room(3.0) > SETTINGS.footsteps.lasting_room(4.0) > 1.0
    missed = np.array([[0.6 * reach.max_length, 0.0]])
    lasting = replace(reach, lasting_room=1.2)
    assert lasting.next_step_cost(missed)[0] < 0.1 * reach.next_step_cost(missed)[0]


def test_a_footstep_compensates_for_the_momentum_of_the_leg(reach):
    omega, time, kappa = 3.3, 0.4, 0.05
    start, velocity = np.array([0.05, -0.1]), np.array([0.3, -0.6])
    moving = replace(reach, offset=start, offset_velocity=velocity, leg_momentum=kappa)
    asked = np.array([0.1, -0.3])
    offset = moving.compensated(asked[None], np.array([time]), omega)[0]
    # The way of the foot, a cubic that ends at rest, and the effect of its acceleration.
    t, way = np.linspace(0.0, time, 2001)[:, None], offset - start
    a = (6 * way - 4 * velocity * time) / time**2
    b = (6 * velocity * time - 12 * way) / time**3
    effect = kappa * (a + b * t) * np.exp(omega * (time - t)) / omega
    went = trapezoid(effect, t[:, 0], axis=0)
    np.testing.assert_allclose(offset - asked, went, atol=0.004)
    assert np.abs(went).max() > 0.01


def test_a_swing_leg_has_a_twentieth_of_the_momentum(walk):
    for human in (Human.create(height=1.5, mass=50.0), Human.create(height=1.95, mass=110.0)):
        assert 0.04 < GaitPerson.of(replace(walk, human=human)).leg_momentum < 0.06
