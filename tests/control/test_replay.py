"""Replay: a whole motion carried out in a world."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.gait.clearance import clearance_of
from plantigrade.control.gait.person import world_sites
from plantigrade.control.gait.phase import GaitPhaseSettings, GaitState, Touchdown
from plantigrade.control.gait.reference import STEP, before, period_of, reference_of
from plantigrade.control.gait.tasks import desired_accelerations, leg_joints
from plantigrade.control.replay import Replay, ReplaySettings
from plantigrade.control.replay.approach import ApproachSettings, with_approach
from plantigrade.control.replay.summary import (
    describe_end,
    describe_steps,
    describe_stray,
    describe_touchdowns,
    touchdown_figures,
)
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.record import Record, Run
from plantigrade.world import Push, World

STORED = Path(__file__).parents[1] / "stored"


@pytest.fixture(scope="module")
def side_step() -> Record:
    """A step to the side that satisfies the equations of motion."""
    return Run.load(STORED / "side-step").record


@pytest.fixture(scope="module")
def replay(side_step) -> Replay:
    return Replay(side_step)


def world_for(replay: Replay, *acting) -> World:
    motion = replay.record.motion
    return World(
        replay.human,
        replay.ground,
        acting,
        rate=replay.rates.physics,
        control_rate=replay.rates.control,
        recording=False,
        qpos=motion.qpos[0],
        qvel=motion.qvel[0],
    )


def test_the_tables_hold_the_motion_its_forces_and_its_stances(side_step, replay):
    reference = replay.reference
    motion = side_step.motion
    row = reference.at(0.4)
    there = motion.at(np.array([motion.time[0] + 0.4])).qpos[0]
    np.testing.assert_allclose(row.q[:3], there[:3], atol=1e-6)
    # What the ground gives moves the centre of mass.
    given = row.force.sum(axis=0) / side_step.human.mass - [0.0, 0.0, GRAVITY]
    np.testing.assert_allclose(row.com_acceleration, given, atol=1e-9)
    sides = [s.side for s in reference.schedule.stances]
    assert sorted(sides) == ["l", "l", "r", "r"]  # each foot stands, steps, stands
    assert reference.ends and reference.period is None
    first, alpha, beta = reference.schedule.weights(0.4)
    assert first == 0
    np.testing.assert_allclose([alpha.sum(), beta.sum()], 1.0, atol=1e-9)


def test_a_motion_that_begins_at_rest_does_not_repeat_and_one_that_ends_as_it_began_does(side_step):
    assert period_of(side_step)[0] is None
    n = 101
    motion = side_step.motion.frames(np.zeros(n, dtype=int))
    qpos, qvel = motion.qpos.copy(), np.zeros_like(motion.qvel)
    qpos[:, 0] += np.linspace(0.0, 1.3, n)
    qvel[:, 0] = 1.3
    gliding = replace(motion, time=np.linspace(0.0, 1.0, n), qpos=qpos, qvel=qvel, qacc=None)
    period, advance = period_of(Record(side_step.human, gliding))
    assert period == pytest.approx(1.0)
    np.testing.assert_allclose(advance, [1.3, 0.0, 0.0], atol=1e-9)
    reference = reference_of(Record(side_step.human, gliding))
    np.testing.assert_allclose(reference.at(2.5).q[0] - reference.at(0.5).q[0], 2.6, atol=1e-9)
    qvel[[0, -1], 0] = 0.0  # a slow walk almost stops between steps
    assert period_of(Record(side_step.human, replace(gliding, qvel=qvel)))[0] is not None


def test_too_short_a_motion_is_refused(side_step):
    short = replace(side_step.motion.frames(slice(0, 1)))
    with pytest.raises(ParameterError, match="several frames"):
        reference_of(Record(side_step.human, short))


def test_undisturbed_it_asks_for_what_the_motion_itself_has(replay):
    world = world_for(replay)
    state = world.reset()
    for _ in range(30):
        state = world.step(replay(state))
    command = replay(state)
    ref = replay.reference.at(replay.gait.phase)
    passive = world.data.qfrc_passive[6:] + world.data.qfrc_applied[6:]
    most = np.abs(np.array(replay.human.model.jnt_actfrcrange[1:])).max(axis=1)
    off = (command.torque + passive - ref.tau) / most
    assert np.abs(off).max() < 0.03
    assert command.signals["tracking_error"] < np.deg2rad(0.6)
    assert replay.gait.phase == pytest.approx(state.time + STEP, abs=1e-5)


@pytest.fixture
def gait(replay) -> GaitState:
    return GaitState(replay.reference, 700.0)


def swinging(gait: GaitState) -> int:
    """Return the foot that swings in a side step, 0 right, 1 left."""
    stances = gait.reference.schedule.stances
    return SIDES.index(next(s for s in stances if np.isfinite(s.start)).side)


def step(gait: GaitState, load, offsets=((0.0, 0.0, 0.0),) * 2, far=(False, False)) -> None:
    gait.update(gait.phase, STEP, np.array(load), np.array(offsets), np.eye(2), far)


def test_a_foot_that_touches_early_stands_at_once_and_the_phase_hurries_after_it(gait):
    i = swinging(gait)
    foot = gait.feet[i]
    load, offsets = [350.0, 350.0], [[0.03, 0.01, 0.0]] * 2
    while foot.in_stance or gait.phase < foot.touchdown - 0.02:
        step(gait, load)
        load[i] = 350.0 * foot.in_stance
        gait.advance(gait.phase, STEP, 1.0)
    load[i] = 100.0
    step(gait, load, offsets, (True, True))
    assert not foot.in_stance  # far from its footstep it only grazes the ground
    step(gait, load, offsets)
    assert foot.in_stance and foot.early
    assert gait.touchdowns[-1].early == pytest.approx(0.02, abs=0.003)
    np.testing.assert_allclose(gait.offset(foot.stance), offsets[i])
    for _ in range(5):
        gait.advance(gait.phase, STEP, 1.0)
    assert gait.rate > 1.1


def test_a_foot_swings_from_where_it_is_not_from_where_it_stood(gait):
    i = swinging(gait)
    offsets, stood = np.zeros((2, 3)), gait.feet[i].stance
    while gait.feet[i].in_stance:
        offsets[i] += [-0.01, 0.02, 0.0]  # its heel rises otherwise than in the motion
        step(gait, [350.0, 350.0], offsets)
        gait.advance(gait.phase, STEP, 1.0)
    np.testing.assert_array_equal(gait.feet[i].swing.offset, offsets[i, :2])
    assert np.abs(offsets[i] - gait.offset(stood)).max() > 0.01


def test_a_foot_that_finds_no_ground_stops_the_phase_and_descends(gait):
    foot = gait.feet[swinging(gait)]
    while foot.wait <= 0.1:
        step(gait, [350.0 * f.in_stance for f in gait.feet])
        gait.advance(gait.phase, STEP, 1.0)
    assert gait.phase == pytest.approx(foot.touchdown) and gait.rate == 0.0
    speed = gait.settings.late_descent_speed
    assert foot.descent == pytest.approx(speed * foot.wait, rel=1e-6)


def test_arms_that_pass_through_the_body_are_held_out_of_it(side_step):
    motion = side_step.motion.frames(slice(0, 3))
    qpos = motion.qpos.copy()
    for side in ("r", "l"):
        qpos[:, 7 + side_step.human.hinge(f"arm_add_{side}")] = np.deg2rad(10.0)
    inside = Record(side_step.human, replace(motion, qpos=qpos))
    found = clearance_of(inside)
    assert found.arms > 0.002
    assert min(found.abduction) > 0.0
    assert found.legs == 0.0


def test_touchdowns_are_described(replay):
    axes, zero = np.eye(2), np.zeros(3)
    steps = [
        Touchdown(1.0, "r", 0.01, zero, axes),
        Touchdown(1.5, "l", -0.03, np.array([-0.05, 0.08, 0.0]), axes),
    ]
    assert describe_steps(steps) == [
        "Stepped 5 cm short and 8 cm to the left with the left foot at 1.5 s."
    ]
    sentence = describe_touchdowns(steps)
    assert sentence.startswith("2 touchdowns: 1 sooner than planned by 10 ms, 1 later")
    assert describe_touchdowns([]) == ""
    figures = touchdown_figures(steps)
    assert (figures["touchdowns_early"], figures["touchdowns_late"]) == (1, 1)
    assert figures["touchdown_late_max_s"] == pytest.approx(0.03)


def test_a_body_far_beside_its_motion_is_described():
    assert describe_stray(np.array([0.1, -0.2])) == ""
    assert "led the person 0.50 m beside it" in describe_stray(np.array([0.3, -0.4]))


def test_a_motion_that_is_cut_off_in_a_step_ends_on_both_feet_and_says_so(side_step, replay):
    schedule, motion = replay.reference.schedule, side_step.motion
    lifts = [s for s in schedule.stances if schedule.standing(s.side, s.stop + 0.1) is None]
    n = int(np.searchsorted(motion.time - motion.time[0], lifts[0].stop + 0.1))
    part = Record(side_step.human, motion.frames(np.arange(n)), ground=side_step.ground)
    cut = reference_of(part)
    stands = [cut.schedule.standing(side, cut.duration - 1e-3) for side in SIDES]
    assert None not in stands and not cut.ends
    assert describe_end(cut, 0.5 * cut.duration) == ""
    assert "not at rest" in describe_end(cut, cut.duration + 0.1)
    assert describe_end(replay.reference, replay.reference.duration + 0.1) == ""


@pytest.mark.slow
def test_a_side_step_survives_where_its_start_is_disturbed_and_it_is_pushed(replay):
    world = world_for(replay, Push(force=50.0, duration=0.2, direction=0.0, time=0.5))
    rng = np.random.default_rng(3)
    motion = replay.record.motion
    state = world.reset(qvel=motion.qvel[0] + 0.05 * rng.standard_normal(motion.qvel.shape[1]))
    while world.time < motion.duration + 0.5 and world.fall is None:
        state = world.step(replay(state))
    assert world.fall is None
    last = replay.reference.at(motion.duration)
    assert np.linalg.norm(state.body.com[:2] - last.com[:2]) < 0.1


@pytest.mark.slow
def test_who_is_pushed_while_standing_takes_a_step_and_the_motion_goes_on_after_it(side_step):
    motion = side_step.motion
    n = 61
    rest = motion.frames(np.full(n, motion.n_frames - 1))
    none = np.zeros_like(rest.qvel)
    rest = replace(rest, time=np.linspace(0.0, 3.0, n), qvel=none, qacc=none)
    replay = Replay(Record(side_step.human, rest))
    assert replay.reference.ends
    world = world_for(replay, Push(force=180.0, duration=0.2, direction=0.0, time=0.1))
    state, waited = world.reset(), False
    while world.time < 2.0 and world.fall is None:
        state = world.step(replay(state))
        waited |= replay.recovery.waiting
    assert world.fall is None
    assert waited and not replay.recovery.waiting  # the motion went on
    assert replay.recovery.steps >= 1
    assert replay.gait.phase < world.time - 0.3
    assert max(t.offset[0] for t in replay.gait.touchdowns) > 0.1
    assert "Stepped" in " ".join(replay.summary().sentences)


def test_contacts_ahead_are_found_across_the_end_of_a_period():
    on = np.array([[True, False], [False, False], [False, True], [False, False], [True, False]])
    whole = before(on, 1, periodic=True)
    np.testing.assert_array_equal(whole[:, 0], [True, False, False, True, True])
    np.testing.assert_array_equal(whole[:, 1], [False, True, True, False, False])
    np.testing.assert_array_equal(before(on, 2, periodic=True)[:, 1], [1, 1, 1, 0, 1])
    assert before(on, 2, periodic=False).shape == on.shape
    np.testing.assert_array_equal(before(on, 0, periodic=True), on)


def test_legs_bent_by_steps_are_slowed_and_not_led_to_the_motion(replay):
    ref, legs = replay.reference.at(0.2), leg_joints(replay.human)
    qpos = ref.q + 0.0
    qpos[7:] += 0.3
    body, settings = BodyState(replay.human, qpos, ref.v), replay.tasks.settings
    led = desired_accelerations(ref, 1.0, body, settings)
    slack = desired_accelerations(ref, 1.0, body, settings, legs)
    np.testing.assert_allclose(led[6:], ref.a[6:] - 30.0)
    np.testing.assert_allclose(slack[6:][legs], ref.a[6:][legs])
    np.testing.assert_array_equal(slack[6:][~legs], led[6:][~legs])
    assert legs.sum() >= 10


def test_an_instant_can_be_held_still(replay):
    ref = replay.reference.at(0.8)
    held = ref.still()
    assert np.abs(ref.v).max() > 0.0
    assert not held.v.any() and not held.foot_velocity.any()
    np.testing.assert_array_equal(held.q, ref.q)
    np.testing.assert_array_equal(held.cop, ref.com)


def test_a_foot_that_glides_over_the_ground_is_lifted_and_comes_down_at_a_steady_speed(walk):
    recorded, own = reference_of(walk), ApproachSettings(clearance=0.05, smoothing_time=1e-6)
    of_side = [np.array([s.side == side for s in world_sites(walk)]).nonzero()[0] for side in SIDES]
    found = with_approach(recorded, of_side, walk.ground, own)
    for i, spheres in enumerate(of_side):
        stands = np.any(recorded.rows.contact[:, spheres] > 0.5, axis=1)
        lift = (found.rows.foot_position - recorded.rows.foot_position)[:, i, 2]
        height = recorded.rows.contact_position[:, spheres, 2].min(axis=1) + lift
        assert lift.max() > 0.0 and not lift[stands].any() and lift.min() >= 0.0
        down = np.flatnonzero(stands[1:] & ~stands[:-1])[0]  # the last instant of a swing
        for k in (5, 20):
            assert height[down - k] >= own.speed * STEP * (k + 1) - 1e-9
        speed = (found.rows.foot_velocity - recorded.rows.foot_velocity)[:, i, 2]
        np.testing.assert_allclose(speed, np.gradient(lift, STEP), atol=1e-9)
    np.testing.assert_array_equal(found.rows.q, recorded.rows.q)
    flat = with_approach(recorded, of_side, walk.ground, replace(own, clearance=0.0))
    np.testing.assert_array_equal(flat.table, recorded.table)


def test_settings_reach_what_they_are_for(side_step, replay):
    settings = ReplaySettings(gait=GaitPhaseSettings(joint_damping=0.024))
    doubled = Replay(side_step, settings=settings)
    np.testing.assert_allclose(doubled.damping, 2.0 * replay.damping)
