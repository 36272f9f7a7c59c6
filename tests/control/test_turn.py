"""Turns of a walk: what is foreseen of them, and that they are walked."""

import numpy as np
import pytest

from experiments.walk_trial import world_of
from experiments.walking import walking
from plantigrade.control.pendulum import WalkCommand, Walker, walk_of
from plantigrade.control.pendulum.path import path_of
from plantigrade.control.pendulum.turn import PredictedTurn, Turn, TurnSettings

SPEED, OMEGA, STEP, DURATION = 1.3, 3.2, 0.005, 0.55
FASTEST = TurnSettings().max_rate


def on_a_circle() -> Turn:
    turn = Turn()
    for _ in range(800):
        turn.update(10.0, SPEED, DURATION, OMEGA, STEP)
    return turn


def test_round_a_circle_feet_that_land_on_it_keep_the_mass_on_it():
    """The extrapolated centre, driven from foot to foot, is where it was in the axes of the way."""
    turn = on_a_circle()
    assert turn.rate == FASTEST
    angle, inward, half = turn.predicted(0.5)
    assert angle == pytest.approx(0.5 * FASTEST) and half == pytest.approx(0.5 * DURATION * FASTEST)
    assert turn.predicted(0.1)[1] == pytest.approx(inward, rel=1e-6)
    grows, a = np.exp(OMEGA * DURATION), FASTEST * DURATION
    before = SPEED * DURATION / (grows - 1.0)  # of the foot, when it strikes
    ahead = SPEED / OMEGA - before
    xi, foot = np.array([before, inward]), np.zeros(2)  # from a foot that strikes
    radius = SPEED / FASTEST
    # The next foot: on the circle, ahead in the direction of the way by then.
    way = radius * np.array([np.sin(a), 1.0 - np.cos(a)])
    foot = way + ahead * np.array([np.cos(a), np.sin(a)]) - [ahead, 0.0]
    after = grows * xi - foot
    turned = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) @ after
    assert turned[1] == pytest.approx(inward, abs=0.004)
    assert 0.5 < inward / (SPEED * FASTEST / OMEGA**2) < 0.9


def test_with_ever_shorter_steps_it_is_what_a_circle_asks_for():
    turn = Turn()
    for _ in range(800):
        turn.update(10.0, SPEED, 0.4, OMEGA, STEP)
    longer = turn.predicted(0.0)[1]
    assert longer > on_a_circle().predicted(0.0)[1]
    assert longer < SPEED * FASTEST / OMEGA**2


def test_what_is_foreseen_comes():
    """A turn of 30° to the left, from straight on to straight on."""
    turn, angle, rows = Turn(), 0.0, []
    for _ in range(1600):
        turn.update(np.deg2rad(30.0) - angle, SPEED, DURATION, OMEGA, STEP)
        rows.append((angle, turn.rate, *turn.predicted(0.4)[:2], turn.predicted(0.0)[1]))
        angle += STEP * turn.rate
    angles, rate, later, inward, now = np.array(rows).T
    assert angles[-1] == pytest.approx(np.deg2rad(30.0), abs=1e-3)
    n = round(0.4 / STEP)
    assert later[:-n] == pytest.approx(angles[n:] - angles[:-n], abs=0.01)
    assert inward[:-n] == pytest.approx(now[n:], abs=0.004)
    assert now[0] > 0.005 and now[-1] == pytest.approx(0.0, abs=1e-3)
    # It is over before the turn is: nothing inward is needed where straight steps follow.
    assert now[np.searchsorted(-rate[600:], -0.02) + 600] < 0.2 * now.max()


def test_a_turn_to_the_right_is_the_mirrored_one():
    left, right = Turn(), Turn()
    for _ in range(60):
        left.update(0.5, SPEED, DURATION, OMEGA, STEP)
        right.update(-0.5, SPEED, DURATION, OMEGA, STEP)
    assert right.predicted(0.3) == pytest.approx([-x for x in left.predicted(0.3)])


def test_a_walk_straight_on_leans_nowhere():
    turn = Turn()
    turn.update(0.0, SPEED, DURATION, OMEGA, STEP)
    assert (turn.rate, turn.predicted(0.5)) == (0.0, PredictedTurn())


def steps(data, bearings: str, seconds: float) -> tuple[list[float], Walker]:
    """Return the width of every step of a walk with bearings [m], and the walker."""
    one = walking("pendulum", data)
    walker = Walker(walk_of(one.record), WalkCommand(path=path_of(bearings)))
    world = world_of(one, walker)
    state, widths = world.reset(), []
    while world.time < seconds and world.fall is None:
        state = world.step(walker(state))
        if len(walker.pendulum.footfalls) > len(widths):
            foot = walker.pendulum.foot_positions
            widths.append(float(foot[1, 1] - foot[0, 1]))
    assert world.fall is None
    return widths, walker


@pytest.mark.slow
def test_bearings_that_change_to_and_fro_are_walked(data):
    """Before a turn was foreseen, feet that ended one crossed each other, and the walk fell."""
    words = [f"{bearing}@{2.7 * k:g}" for k, bearing in enumerate((30, 0, -30, 0), 1)]
    widths, walker = steps(data, "bearing:0," + ",".join(words), 13.5)
    assert min(widths) > -0.05 and max(widths) < 0.3
    off = [x.error for x in walker.pendulum.footfalls if x.error is not None]
    assert np.median(off) < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("start", [2.7, 2.85, 3.15, 3.45, 3.75])
def test_a_turn_is_walked_with_steps_of_human_width_whenever_it_begins(data, start):
    """Feet that had to keep apart from the other one fell short, and the next stepped 0.5 m out."""
    widths, _ = steps(data, f"bearing:0,30@{start:g}", start + 3.0)
    assert min(widths) > -0.05 and max(widths) < 0.27
