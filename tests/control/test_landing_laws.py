"""The pendulum without a body: its energy and strikes, and where its feet are to land."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from plantigrade.arrays import Array
from plantigrade.constants import GRAVITY
from plantigrade.control.pendulum.landing import DEEPEST, DROPS, STRETCHED, Reach
from plantigrade.control.pendulum.landing import landing as predicted
from plantigrade.control.pendulum.landing_laws import (
    LAWS,
    DivergentLaw,
    EnergyLaw,
    Strike,
    carried,
    energy,
    leg_length,
    strike_angle,
    struck,
)
from plantigrade.control.pendulum.plan import reaction_of
from plantigrade.models import Human

LEG = 0.95


def test_the_mass_at_constant_height_is_carried_as_the_linear_pendulum():
    omega = float(np.sqrt(GRAVITY / LEG))
    place, speed = carried(np.array([0.1, -0.02]), np.array([0.4, 0.1]), np.zeros(2), omega, 0.3)
    ode = solve_ivp(
        lambda t, y: [*y[2:], *(omega**2 * y[:2])],
        (0, 0.3),
        [0.1, -0.02, 0.4, 0.1],
        rtol=1e-10,
        atol=1e-12,
    )
    np.testing.assert_allclose([*place, *speed], ode.y[:, -1], rtol=1e-7)
    # Its orbital energy stays.
    for x, v, x0, v0 in zip(place, speed, (0.1, -0.02), (0.4, 0.1), strict=True):
        assert v**2 - (omega * x) ** 2 == pytest.approx(v0**2 - (omega * x0) ** 2)


def test_a_strike_takes_what_moves_along_the_new_leg():
    between = 0.7
    # Velocity across the old leg, split along and across the new one.
    velocity = 1.3 * np.array([np.cos(0.3), -np.sin(0.3)])
    across = np.array([np.cos(0.4), np.sin(0.4)])
    assert struck(1.3, between) == pytest.approx(velocity @ across)


def test_the_leg_that_strikes_a_slope_reaches_from_the_mass_to_the_slope():
    slope, trailing, leading, height = 0.2, 0.25, 0.35, 1.0
    length = float(leg_length(height, trailing, leading, slope))
    mass = np.array([height * np.tan(trailing), height])
    foot = mass + length * np.array([np.sin(leading), -np.cos(leading)])
    assert foot[1] == pytest.approx(np.tan(slope) * foot[0])
    level = float(leg_length(height, trailing, leading))
    assert level == pytest.approx(height / np.cos(leading))


@pytest.mark.parametrize("slope", [-0.15, 0.0, 0.15])
def test_the_angle_found_leaves_the_energy_that_was_asked_for(slope):
    speed, trailing, leading = 1.5, 0.3, 0.33
    goal = float(energy(speed, trailing, leading, leg_length(1.0, trailing, leading, slope)))
    found = strike_angle(speed, trailing, 1.0, goal, slope)
    assert float(found) == pytest.approx(leading, abs=1e-9)
    faster = strike_angle(np.array([1.5, 1.7, 1.9]), trailing, 1.0, goal, slope)
    assert (np.diff(faster) > 0.01).all()  # who is faster steps farther
    # However fast it was, the mass has the energy of the recorded one afterwards.
    for speed, angle in zip((1.5, 1.7, 1.9), faster, strict=True):
        length = float(leg_length(1.0, trailing, angle, slope))
        rate = float(struck(speed, trailing + angle)) / length
        kept = 0.5 * rate**2 + GRAVITY / length * np.cos(angle)
        assert float(kept) == pytest.approx(goal, rel=1e-9)
    assert strike_angle(0.0, trailing, 1.0, 12.0, slope) < 1e-6  # too slow for any step


OMEGA, PERIOD = float(np.sqrt(GRAVITY / LEG)), 0.5


@pytest.fixture(scope="module")
def strike() -> Strike:
    """The strike of a periodic walk of the linear pendulum: 0.6 m ahead, 0.12 m apart."""
    step = np.array([0.6, 0.12])
    c, s = np.cosh(OMEGA * PERIOD), np.sinh(OMEGA * PERIOD)
    start = 0.5 * np.array([-0.6, 0.12])  # in the middle between the feet
    speed = OMEGA / s * np.array([0.3 * (c + 1), 0.06 * (1 - c)])
    com, velocity = carried(start, speed, np.zeros(2), OMEGA, PERIOD)
    return Strike(com, velocity, LEG, np.zeros(2), step, np.eye(2), OMEGA)


def walked(law, strike: Strike, steps: int, com, velocity) -> tuple[Array, Array]:
    """Return how places of the feet go on from a state at a strike: without a double stance."""
    stands, side, feet = strike.stands, 1.0, []
    for _ in range(steps):
        mirror = np.array([1.0, side])
        mine = replace(
            strike,
            com=stands + mirror * (strike.com - strike.stands),
            velocity=mirror * strike.velocity,
            stands=stands,
            lands=stands + mirror * (strike.lands - strike.stands),
        )
        stands = law.place(com[None], velocity[None], stands, mine)[0]
        feet.append(stands)
        com, velocity = carried(com, velocity, stands, OMEGA, PERIOD)
        side = -side
    return np.array(feet), velocity


@pytest.mark.parametrize("name", list(LAWS))
def test_undisturbed_both_laws_walk_the_periodic_orbit(name, strike):
    feet, velocity = walked(LAWS[name], strike, 6, strike.com, strike.velocity)
    np.testing.assert_allclose(np.diff(feet[:, 0]), 0.6, atol=1e-6)
    np.testing.assert_allclose(np.diff(feet[:, 1]), [-0.12, 0.12, -0.12, 0.12, -0.12], atol=1e-6)
    np.testing.assert_allclose(velocity, strike.velocity, atol=1e-5)


def test_after_a_push_the_extrapolated_centre_brings_the_orbit_back(strike):
    push = np.array([0.3, 0.1])
    _, velocity = walked(DivergentLaw(), strike, 8, strike.com, strike.velocity + push)
    np.testing.assert_allclose(velocity, strike.velocity, atol=1e-6)
    # The energy law steps farther, too, but less: it counts on what the strike takes.
    pushed = (strike.com[None], (strike.velocity + push)[None], strike.stands, strike)
    far = [law.place(*pushed)[0] - strike.lands for law in (EnergyLaw(True), DivergentLaw())]
    assert 0.0 < far[0][0] < far[1][0] and 0.0 < far[0][1] < far[1][1]


def test_what_is_out_of_reach_is_taken_sooner_or_shortened_and_feet_may_cross(strike):
    still = {"swing_offset": np.zeros(2), "speed": np.zeros(2), "hip": np.zeros(2)}
    still |= {"high": 0.8, "rises": 0.0}
    still |= {"moved": np.zeros(2), "moves": np.zeros(2), "reaction": 0.0}
    reach = Reach(
        axes=np.eye(2), nominal=strike.lands, side=1.0, leg_length=0.9, min_width=0.06, **still
    )
    half = np.array([0.0, -0.02])
    slow = predicted(
        DivergentLaw(), half, strike.velocity, np.zeros(2), np.zeros(2), 0.2, strike, reach
    )
    fast = predicted(
        DivergentLaw(), half, strike.velocity + [1.2, 0.0], np.zeros(2), np.zeros(2), 0.2, strike,
        reach,
    )  # fmt: skip
    assert fast.rate > slow.rate and fast.after < slow.after
    assert fast.place[0] > slow.place[0]
    past = reach.settings.crossover_length * 0.9
    asked = np.array([[3.0, 0.1], [0.1, 0.03], [0.8, -0.1], [0.0, 2.0]])
    beside, ahead, behind = (strike.lands + way for way in reach.constrained(asked - strike.lands))
    np.testing.assert_allclose(beside[0], [reach.max_length, 0.1])
    np.testing.assert_allclose(beside[1], [0.1, 0.06])  # beside the other foot: not through it
    np.testing.assert_allclose(beside[3], [0.0, reach.max_width])
    np.testing.assert_allclose(ahead[1:3], [[past, 0.03], [0.8, -0.1]])
    np.testing.assert_allclose(behind[1:3], [[-past, 0.03], [-past, -0.1]])
    assert len(replace(reach, may_cross=False).constrained(asked)) == 1
    late = reach.swing_cost(np.array([[0.3, 0.0], [0.9, 0.0]]), np.array([0.3, 0.1]))
    assert late[0] == 0.0 < late[1]  # feet are no faster than they can be
    time = np.array([0.05, 0.1, 0.6])
    later = reach.at(np.zeros((3, 2)), time)
    place = strike.lands + later.constrained(np.tile([0.0, 2.0], (3, 1)))[0]
    # No farther than a leg reaches from a hip that goes down; then no wider than the box.
    high = np.maximum(0.8 - 0.5 * DROPS * time[:2] ** 2, (STRETCHED - DEEPEST) * 0.9)
    span = np.linalg.norm(place, axis=1)
    np.testing.assert_allclose(span[:2], np.sqrt((STRETCHED * 0.9) ** 2 - high**2))
    assert span[0] < span[1] < span[2] and np.all(place[:, 1] <= reach.max_width)


def test_a_landing_place_makes_up_for_the_leg_that_is_led_there(strike):
    omega, time, kappa = 3.3, 0.4, 0.05
    moved, moves = np.array([0.05, -0.1]), np.array([0.3, -0.6])
    reach = Reach(
        axes=np.eye(2), nominal=strike.lands, side=1.0, leg_length=0.9, min_width=0.06,
        swing_offset=np.zeros(2), speed=np.zeros(2), hip=np.zeros(2), high=0.8, rises=0.0,
        moved=moved, moves=moves, reaction=kappa,
    )  # fmt: skip
    asked = np.array([0.1, -0.3])
    offset = reach.made_up(asked[None], np.array([time]), omega)[0]
    # The way of the foot, a cubic that ends at rest, and what its acceleration does to the mass.
    t = np.linspace(0.0, time, 2001)[:, None]
    way = offset - moved
    a, b = (6 * way - 4 * moves * time) / time**2, (6 * moves * time - 12 * way) / time**3
    push = kappa * (a + b * t) * np.exp(omega * (time - t)) / omega
    went = trapezoid(push, t[:, 0], axis=0)
    np.testing.assert_allclose(offset - asked, went, atol=0.004)
    assert np.abs(went).max() > 0.01


def test_a_leg_takes_a_twentieth_of_its_way_from_the_mass():
    for human in (Human.create(height=1.5, mass=50.0), Human.create(height=1.95, mass=110.0)):
        assert 0.04 < reaction_of(human) < 0.06
