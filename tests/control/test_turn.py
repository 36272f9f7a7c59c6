"""Turns of a walk: what is foreseen of them, and that they are walked."""

import numpy as np
import pytest

from plantigrade.control.pendulum import Walker, Wish, walk_of
from plantigrade.control.pendulum.route import path
from plantigrade.control.pendulum.turn import AHEAD, FASTEST, FINE, Turn, steered
from plantigrade.experiments.walking import walking
from plantigrade.workflows.harness import world_for

SPEED, OMEGA, STEP = 1.3, 3.2, 0.005


def test_round_a_circle_the_mass_is_inward_by_what_the_bend_needs():
    turn = Turn()
    for _ in range(800):
        turn.look(10.0, SPEED, OMEGA, STEP)
    assert turn.rate == FASTEST
    assert turn.inward == pytest.approx(SPEED * FASTEST / OMEGA**2, rel=1e-3)
    assert turn.drift == pytest.approx(0.0, abs=1e-4)
    angle, inward, drift = turn.after(0.5)
    assert angle == pytest.approx(0.5 * FASTEST)
    assert abs(inward) < 1e-4 and abs(drift) < 1e-4


def test_what_is_foreseen_comes_and_obeys_the_pendulum():
    """A turn of 30° to the left, from straight on to straight on."""
    turn, angle, rows = Turn(), 0.0, []
    for k in range(1600):
        turn.look(np.deg2rad(30.0) - angle, SPEED, OMEGA, STEP)
        rows.append((k * STEP, angle, turn.rate, turn.inward, turn.drift, *turn.after(0.4)))
        angle += STEP * turn.rate
    time, angles, rate, inward, drift, later, farther, _ = np.array(rows).T
    assert angles[-1] == pytest.approx(np.deg2rad(30.0), abs=1e-3)
    assert inward[-1] == pytest.approx(0.0, abs=1e-4)
    n = round(0.4 / STEP)
    assert later[:-n] == pytest.approx(angles[n:] - angles[:-n], abs=0.01)
    assert farther[:-n] == pytest.approx(inward[n:] - inward[:-n], abs=0.004)
    # The extrapolated centre is driven away from what the bend needs: begun before, ended before.
    xi, need = inward + drift / OMEGA, SPEED * rate / OMEGA**2
    grows = np.gradient(xi, time)
    assert np.median(np.abs(grows - OMEGA * (xi - need))) < 0.01
    assert xi[np.argmax(need)] > 0.0 and np.argmax(inward) > np.argmax(xi)


def test_a_turn_to_the_right_is_the_mirrored_one():
    left, right = Turn(), Turn()
    for _ in range(60):
        left.look(0.5, SPEED, OMEGA, STEP)
        right.look(-0.5, SPEED, OMEGA, STEP)
    assert right.after(0.3) == pytest.approx([-x for x in left.after(0.3)])
    assert (right.inward, right.drift) == pytest.approx((-left.inward, -left.drift))


def test_who_goes_straight_on_leans_nowhere_and_the_horizon_has_an_end():
    turn = Turn()
    turn.look(0.0, SPEED, OMEGA, STEP)
    assert (turn.rate, turn.inward, turn.drift, turn.after(0.5)) == (0.0, 0.0, 0.0, (0.0, 0.0, 0.0))
    turn.look(0.5, SPEED, OMEGA, STEP)
    assert turn.after(2.0 * AHEAD * FINE) == pytest.approx(turn.after(AHEAD * FINE), abs=1e-6)
    assert steered(1.0, 0.0, 0.1) == pytest.approx(0.1) and steered(9.0, 1.0, 9.0) == FASTEST


@pytest.mark.slow
@pytest.mark.parametrize("sign", [1, -1])
def test_bearings_that_change_to_and_fro_are_walked(data, sign):
    """Before a turn was foreseen, feet that ended one crossed each other, and the walk fell."""
    one = walking("pendulum", data)
    walk = walk_of(one.record)
    words = [f"{sign * 30 * (k % 2)}@{2.0 + 2.7 * k:g}" for k in range(1, 5)]
    walker = Walker(walk, Wish(way=path("bearing:0," + ",".join(words))))
    world = world_for(one, walker)
    state, landings, apart = world.reset(), 0, []
    while world.time < 16.0 and world.fall is None:
        state = world.step(walker(state))
        if len(walker.pendulum.landings) > landings:
            landings = len(walker.pendulum.landings)
            foot = walker.pendulum._foot
            apart.append(foot[1, 1] - foot[0, 1])
    assert world.fall is None
    assert min(apart) > -0.05 and max(apart) < 0.3  # of the ankles, sideways [m]
    off = [x.error for x in walker.pendulum.landings if x.error is not None]
    assert np.median(off) < 0.04
