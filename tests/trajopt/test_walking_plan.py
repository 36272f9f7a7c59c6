"""Plans of a walk: what is published about steps, and what follows from walking itself."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.tasks.walking_plan import (
    periodic_walk_plan,
    standing_distance,
    walk_plan,
)
from plantigrade.trajopt.transcription.mesh import nodes_of

HUMAN = Human.create(1.74, 71.0)
SPEEDS = [0.3, 0.6, 1.0, 1.3, 1.6, 2.0, 2.2]
STATURES = [1.50, 1.74, 1.95]


TIMES = ("heel_strike", "foot_flat", "heel_off", "forefoot_off", "toe_off")


def falls(plan):
    """Footprints in order of their strikes; those stood on from the start first."""
    return [s.footprint for s in plan.stances]


def supports(plan, side, times):
    """Whether any part of a foot is on the ground."""
    out = np.zeros(len(times), bool)
    for s in plan.unrolled():
        out |= (s.footprint.side == side) & (times >= s.heel_strike) & (times <= s.toe_off)
    return out


def test_free_walking_of_adults():
    # Walkway norms of adults at about 1.3 m/s: 105 to 118 steps a minute, stance 60 to 65 %; of
    # children at the same dimensionless speed 59 %. Preferred steps of Kuo's power law are shorter.
    p = gait_parameters(HUMAN, 1.3)
    assert 0.60 < p.step_length < 0.80 and 100 < p.cadence < 125
    assert 0.58 <= p.stance_fraction <= 0.64
    assert 0.05 < p.step_width < 0.15 and 4 < np.rad2deg(p.toe_out) < 8
    assert 0.05 < p.foot_flat < 0.12 and 0.30 < p.heel_off < 0.41
    assert p.heel_off < 0.5 < p.forefoot_off < p.stance_fraction


@pytest.mark.parametrize("height", STATURES)
def test_faster_means_longer_and_more_frequent_steps_and_less_stance(height):
    all_ = [gait_parameters(Human.create(height, 60.0), v) for v in SPEEDS]
    for name, sign in (("step_length", 1), ("cadence", 1), ("stance_fraction", -1)):
        assert np.all(sign * np.diff([getattr(p, name) for p in all_]) >= 0), name
    for p, speed in zip(all_, SPEEDS, strict=True):
        assert p.step_length / p.step_time == pytest.approx(speed)
        assert p.double_support >= 0 and p.swing_time + 2 * p.double_support < p.stride_time


def test_people_of_any_size_walk_alike_at_the_same_dimensionless_speed():
    small, tall = gait_parameters(0.7, 1.0), gait_parameters(1.05, np.sqrt(1.5))
    for name in ("step_length", "step_width"):
        assert getattr(tall, name) / getattr(small, name) == pytest.approx(1.5)
    assert tall.stance_fraction == pytest.approx(small.stance_fraction)
    assert tall.step_time / small.step_time == pytest.approx(np.sqrt(1.5))


def test_step_length_over_cadence_is_that_of_adults_at_all_speeds():
    """[Murakami2017]: 62 m/min with 98 steps/min, and the same ratio at all higher speeds."""
    for v in SPEEDS:
        p = gait_parameters(0.93, v)
        assert p.step_length / p.cadence == pytest.approx(62.0 / 98.0**2, rel=0.01)


def test_own_step_length_and_cadence():
    p = gait_parameters(HUMAN, 1.2, step_length=0.6)
    assert p.step_length == 0.6 and p.cadence == pytest.approx(120.0)
    assert gait_parameters(HUMAN, 1.2, cadence=120.0).step_length == pytest.approx(0.6)
    assert gait_parameters(HUMAN, 1.2, cadence=120.0, step_length=0.6).cadence == pytest.approx(120)


@pytest.mark.parametrize(
    ("speed", "options", "words"),
    [
        (0.2, {}, "speed must be 0.3–2.2 m/s for walking"),
        (2.5, {}, "speed must be 0.3–2.2 m/s for walking"),
        (float("nan"), {}, "speed must be 0.3–2.2 m/s for walking"),
        (1.2, {"step_length": 1.5}, "step_length must be .* not 1.5"),
        (1.2, {"step_length": 0.6, "cadence": 100.0}, "leave out step length or cadence"),
        (0.4, {"cadence": 0.0}, "must be positive"),
        (2.0, {"step_length": 0.1}, "takes 0.05 s"),
    ],
)
def test_what_is_no_walk_is_refused(speed, options, words):
    with pytest.raises(ParameterError, match=words):
        gait_parameters(HUMAN, speed, **options)


def test_stance_out_of_order_is_refused():
    with pytest.raises(ParameterError, match="a walking stance goes"):
        replace(gait_parameters(HUMAN, 1.0), heel_off=0.02)


@pytest.mark.parametrize("first", ["r", "l"])
@pytest.mark.parametrize("speed", [0.4, 1.3, 2.0])
def test_still_walk_still(speed, first):
    p = gait_parameters(HUMAN, speed)
    plan = walk_plan(HUMAN, p, steps=4, first=first)
    feet = falls(plan)
    x = np.array([f.position[0] for f in feet])
    y = np.array([f.position[1] for f in feet])
    # Half steps at both ends, feet beside one another at the start and the end.
    np.testing.assert_allclose(x / p.step_length, [0, 0, 1, 2, 3, 3], atol=1e-12)
    assert [f.side for f in feet[1:]] == [first, *[first, "l" if first == "r" else "r"] * 2]
    assert all((f.side == "l") == (f.position[1] > 0) for f in feet)
    assert np.ptp(y[:2]) == pytest.approx(standing_distance(HUMAN)) == pytest.approx(np.ptp(y[-2:]))
    assert np.ptp(y[2:4]) == pytest.approx((p.step_width + standing_distance(HUMAN)) / 2, abs=0.05)
    # One foot at least is always down, both at the start and the end, one alone in between.
    t = np.linspace(0, plan.duration, 2001)
    down = np.stack([supports(plan, side, t) for side in "rl"])
    assert down.any(axis=0).all() and down[:, 0].all() and down[:, -1].all()
    moving = (t > plan.stances[1].toe_off) & (t < plan.stances[-1].heel_strike)
    share = np.mean(~down.all(axis=0)[moving])
    assert share == pytest.approx(
        4 * p.swing_time / (4 * p.swing_time + 3 * p.double_support), abs=0.01
    )
    # The rest is long enough to fall over to one foot: the body is a pendulum.
    assert plan.stances[1].toe_off == pytest.approx(
        2 * np.sqrt(HUMAN.dimensions.leg_length / GRAVITY)
    )


def test_stances_are_in_order_and_a_foot_has_one_at_a_time():
    plan = walk_plan(HUMAN, gait_parameters(HUMAN, 1.2), steps=7)
    assert np.all(np.diff([s.heel_strike for s in plan.stances]) >= 0)
    for side in "rl":
        own = [s for s in plan.stances if s.footprint.side == side]
        assert all(a.toe_off < b.heel_strike for a, b in zip(own[:-1], own[1:], strict=True))


@pytest.mark.parametrize("speed", [0.5, 1.3, 2.0])
def test_periodic_plan_goes_on_as_its_mirror_image(speed):
    p = gait_parameters(HUMAN, speed)
    plan = periodic_walk_plan(HUMAN, p)
    left, right = plan.stances
    assert plan.periodic and plan.duration == p.step_time
    assert (left.footprint.side, right.footprint.side) == ("l", "r")
    assert right.heel_strike == 0.0 and left.heel_strike == -p.step_time
    assert left.toe_off == pytest.approx((p.stance_fraction - 0.5) * p.stride_time)
    assert plan.mirrored and plan.advance == pytest.approx(p.step_length)
    # What lies beyond the end is the mirror image of what is at the start.
    stances = plan.unrolled(before=3, after=3)
    for a, b in zip(stances[:-1], stances[1:], strict=True):
        assert a.footprint.side != b.footprint.side
        assert b.footprint.heading == -a.footprint.heading
        step = np.subtract(b.footprint.position, a.footprint.position)
        np.testing.assert_allclose(np.abs(step), [p.step_length, p.step_width, 0.0], atol=1e-12)
        for name in TIMES:
            assert getattr(b, name) - getattr(a, name) == pytest.approx(p.step_time)
    own = (left.heel_strike, right.heel_strike)
    assert [s for s in stances if s.heel_strike in own] == [left, right]
    # Over a whole stride each foot is down for its share of it.
    t = np.linspace(0, p.stride_time, 4001)[:-1]
    for side in "rl":
        assert supports(plan, side, t).mean() == pytest.approx(p.stance_fraction, abs=1e-3)


def test_no_force_at_the_strike_of_a_periodic_walk():
    plan = periodic_walk_plan(HUMAN, gait_parameters(HUMAN, 1.3))
    heel = next(s for s in foot_sites(HUMAN) if s.side == "r" and s.part == "heel")
    assert plan.standing(heel, np.array([0.0]))[0]
    assert not plan.carrying(heel, np.array([0.0]))[0]


def test_half_a_stride_is_a_piece_of_a_long_walk():
    p = gait_parameters(HUMAN, 1.3)
    long = walk_plan(HUMAN, p, steps=6)
    there = [s for s in long.stances if s.footprint.side == "r"][2]  # a walking step
    lefts = [s for s in long.stances if s.footprint.side == "l"]
    before = [s for s in lefts if s.heel_strike < there.heel_strike][-1]
    left, right = periodic_walk_plan(HUMAN, p).stances
    for a, b in ((before, left), (there, right)):
        for name in TIMES[1:]:
            assert getattr(a, name) - there.heel_strike == pytest.approx(getattr(b, name)), name


@pytest.mark.parametrize("turn", [0.8, -2.5])
def test_turning_keeps_to_a_circle(turn):
    p = gait_parameters(HUMAN, 1.0)
    plan = walk_plan(HUMAN, p, steps=8, turn=turn)
    feet = falls(plan)
    radius = 7 * p.step_length / turn
    out = [np.hypot(f.position[0], f.position[1] - radius) for f in feet]
    for f, distance in zip(feet, out, strict=True):
        inside = (f.side == "l") == (turn > 0)
        assert (distance < abs(radius)) == inside
    mean = (feet[-1].heading + feet[-2].heading) / 2
    assert mean == pytest.approx(turn)
    # mirrored in x, a turn to the left is one to the right
    image = falls(walk_plan(HUMAN, p, steps=8, turn=-turn, first="l"))
    for f, g in zip(feet, image, strict=True):
        np.testing.assert_allclose(np.multiply(f.position, [1, -1, 1]), g.position, atol=1e-12)


def test_up_a_stair():
    p = gait_parameters(HUMAN, 0.5)
    plan = walk_plan(HUMAN, p, steps=4, heights=(0.15, 0.30, 0.45, 0.45))
    assert [f.position[2] for f in falls(plan)] == [0, 0, 0.15, 0.30, 0.45, 0.45]


@pytest.mark.parametrize("stop", ["standing", "walking"])
def test_a_walk_may_begin_in_the_middle(stop):
    p = gait_parameters(HUMAN, 1.2)
    plan = walk_plan(HUMAN, p, steps=3, start="walking", stop=stop)
    assert [s.footprint.side for s in plan.stances] == ["l", "r", "l", "r", "l"]
    assert plan.stances[1].heel_strike == 0.0 > plan.stances[0].heel_strike
    if stop == "walking":
        assert plan.stances[-1].heel_strike == pytest.approx(plan.duration)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"steps": 1}, "at least 2"),
        ({"steps": 3, "turn": 4.0}, "take more steps"),
        ({"steps": 3, "turn": float("nan")}, "take more steps"),
        ({"steps": 3, "heights": (0.1,)}, "1 heights for 3 steps"),
        ({"steps": 3, "heights": (0.1, float("inf"), 0.1)}, "finite"),
        ({"steps": 3, "heights": (0.1, 0.9, 0.9)}, "in one step"),
    ],
)
def test_plans_that_make_no_walk_are_refused(options, words):
    with pytest.raises(ParameterError, match=words):
        walk_plan(HUMAN, gait_parameters(HUMAN, 1.0), **options)


def test_a_whole_stride_is_two_half_strides():
    """The same stances at the same times, whichever way the plan repeats."""
    half = periodic_walk_plan(HUMAN, gait_parameters(HUMAN, 1.2))
    whole = half.full_stride()
    assert whole.duration == 2 * half.duration and whole.advance == 2 * half.advance
    assert not whole.mirrored and whole.full_stride() is whole
    assert [s.footprint.side for s in whole.stances] == ["l", "r", "l"]
    for one, other in zip(
        half.unrolled(before=3, after=5), whole.unrolled(before=1, after=2), strict=True
    ):
        np.testing.assert_allclose(one.times, other.times, atol=1e-12)
        np.testing.assert_allclose(one.footprint.position, other.footprint.position, atol=1e-12)
        assert one.footprint.side == other.footprint.side


@pytest.mark.parametrize("nodes_per_second", [10.0, 20.0, 47.0])
@pytest.mark.parametrize("speed", [0.6, 1.3, 2.0])
def test_nodes(speed, nodes_per_second):
    p = gait_parameters(HUMAN, speed)
    for plan in (walk_plan(HUMAN, p, steps=4), periodic_walk_plan(HUMAN, p)):
        nodes = nodes_of(plan, nodes_per_second)
        gaps = np.diff(nodes)
        assert gaps.min() > 0 and gaps.max() <= 1 / nodes_per_second + 1e-12
        at = np.searchsorted(nodes, plan.switches)
        np.testing.assert_array_equal(nodes[at], plan.switches)
        assert np.diff(at).min() >= 2
        assert at[0] == 0 and at[-1] == len(nodes) - 1
