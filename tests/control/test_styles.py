"""Walks that turn into others while they go on, and upper bodies of something else."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.control.gait.reference import reference_of
from plantigrade.control.pendulum import WalkCommand, Walker
from plantigrade.control.pendulum.command import RECORDED, Style
from plantigrade.control.pendulum.styles import Styles
from plantigrade.control.pendulum.transition import PhaseMap, Transition, instants
from plantigrade.control.pendulum.upper_body import (
    POSES,
    BlendedUpperBody,
    FixedPose,
    source_of,
    upper_hinges,
)
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record


@pytest.fixture(scope="module")
def slower(walk) -> Record:
    """A slower walk of the same person, whose arms swing less."""
    motion, human = walk.motion, walk.human
    qpos, qvel = motion.qpos.copy(), motion.qvel / 1.2
    for side in "rl":
        i = human.hinge(f"arm_flex_{side}")
        qpos[:, 7 + i] *= 0.5
        qvel[:, 6 + i] *= 0.5
    return Record(human, Motion(1.2 * motion.time, qpos, qvel, human.joint_names))


@pytest.fixture(scope="module")
def both(walk, slower):
    """Tables of both walks, the new one first, whose feet lift later."""
    new = reference_of(slower)
    later = tuple(replace(s, stop=s.stop + 0.05) for s in new.schedule.stances)
    return replace(new, schedule=replace(new.schedule, stances=later)), reference_of(walk)


def test_feet_strike_and_lift_at_like_instants_of_both_walks(both):
    new, old = both
    mapped = PhaseMap(new.schedule, old.schedule)
    ours, theirs = instants(new.schedule), instants(old.schedule)
    back = (np.array([mapped.to_old(x) for x in ours]) - theirs) / old.duration
    np.testing.assert_allclose(back - np.round(back), 0.0, atol=1e-9)
    phases = np.linspace(-0.3, 3.0, 40)
    there = np.array([mapped.to_old(x) for x in phases])
    np.testing.assert_allclose([mapped.to_new(x) for x in there], phases, atol=1e-9)
    assert (np.diff(there) > 0.0).all()
    assert mapped.to_old(1.0 + new.duration) - mapped.to_old(1.0) == pytest.approx(old.duration)


def test_a_transition_begins_as_the_old_walk_in_its_own_time_and_ends_as_the_new(both):
    new, old = both
    transition = Transition(new, old)
    before, step = 0.37 * old.duration, 1e-3
    phase = transition.phases.to_new(before)
    cadence = transition.cadence(phase)
    found = transition.at(new.at(phase), phase, cadence)
    was = old.at(before)
    np.testing.assert_allclose(found.q[7:], was.q[7:], atol=1e-9)
    rates = [(each.v, each.com_velocity, each.foot_velocity) for each in (found, was)]
    for ours, theirs in zip(*rates, strict=True):
        np.testing.assert_allclose(cadence * ours, theirs, atol=1e-9)
    ahead = old.at(before + step).q - was.q
    later = transition.at(new.at(phase + cadence * step), phase + cadence * step, cadence).q
    np.testing.assert_allclose((later - found.q)[7:], ahead[7:], atol=1e-6)
    apart = found.com[:2] - found.cop[:2]
    np.testing.assert_allclose(cadence**2 * apart, (was.com - was.cop)[:2], atol=1e-9)
    assert not transition.advance(60.0)
    found = transition.at(new.at(phase), phase, transition.cadence(phase))
    np.testing.assert_allclose(found.row, new.at(phase).row, atol=1e-4)


def test_a_walk_changes_into_another_in_single_support(walk, slower, world_of):
    other = Style(name="stroll", record=slower, time=0.4)
    walker = Walker(walk, WalkCommand(own="walk", walks=(other,)))
    world = world_of(walker)
    state, own = world.step(walker(world.reset())), walker.pendulum.reference.speed
    before = np.zeros(36)
    while not walker.styles.changes and world.time < 1.5:
        before = walker.pendulum.reference.at(walker.pendulum.gait.phase).q[7:]
        state = world.step(walker(state))
    assert world.fall is None
    (switched,) = walker.styles.changes
    assert switched.name == "stroll" and 0.4 <= switched.time < 1.5 and switched.foot in "rl"
    paced, gait = walker.pendulum.reference, walker.pendulum.gait
    jumps = np.abs(paced.at(gait.phase).q[7:] - before)
    assert jumps.max() < np.deg2rad(8.0)  # of two control steps at most
    assert sum(foot.in_stance for foot in gait.feet) == 1
    assert paced.speed * paced.transition.mean_cadence == pytest.approx(own, rel=1e-3)
    assert any("stroll" in said for said in walker.summary().sentences)
    assert walker.summary().figures["switched_s"] == switched.time


def test_what_cannot_be_walked_is_refused(walk, begun_by_another):
    with pytest.raises(ParameterError, match="degrees of freedom"):
        Walker(walk, WalkCommand(walks=(Style(name="other", record=begun_by_another),)))
    still = Record(walk.human, walk.motion.frames(np.arange(30)))
    with pytest.raises(ParameterError, match="every foot stands once"):
        Walker(walk, WalkCommand(own="walk", walks=(Style(name="end", record=still),)))


@pytest.fixture(scope="module")
def begun_by_another(walk) -> Record:
    """Two frames of somebody with other joints."""
    human = Human.create(1.7, 65.0, "female", "66")
    qpos = np.tile(human.standing(), (2, 1))
    time, rest = np.array([0.0, 1.0]), np.zeros((2, human.model.nv))
    return Record(human, Motion(time, qpos, rest, human.joint_names))


def test_a_pose_is_of_spine_neck_and_arms_within_their_limits(walk):
    human = walk.human
    with pytest.raises(
        ParameterError, match="'knee_angle_r' of the upper body; there are .*lumbar_extension"
    ):
        FixedPose.of(human, {"knee_angle_r": 0.3})
    with pytest.raises(ParameterError, match="elbow_flex_r=300° must be"):
        FixedPose.of(human, {"elbow_flex_r": np.deg2rad(300.0)})
    assert upper_hinges(human).sum() == human.coordinates.index("hip_flexion_l")


def test_an_upper_body_keeps_the_legs_and_lowers_the_mass_as_its_posture_does(walk, both):
    human, reference = walk.human, both[1]
    raised = FixedPose.of(human, {"arm_flex_r": 1.5, "arm_flex_l": 1.5})
    bowed = FixedPose.of(human, {"lumbar_extension": -0.5})
    for pose, higher in ((raised, True), (bowed, False)):
        upper = BlendedUpperBody(human, reference, pose, None, 0.0)
        upper.time = 10.0
        plain, row = reference.at(0.4), reference.at(0.4)
        upper.apply(row, 0.4, 1.0)
        hinges = upper_hinges(human)
        np.testing.assert_array_equal(row.q[7:][~hinges], plain.q[7:][~hinges])
        np.testing.assert_allclose(row.q[7:][pose.hinges], pose.angles)
        assert (row.com[2] > plain.com[2]) == higher
        body = BodyState(human, np.array(plain.q))
        posed = np.array(plain.q)
        posed[7:] = row.q[7:]
        assert (body.moved_to(posed).com[2] > body.com[2]) == higher


def test_an_upper_body_of_another_walk_is_in_step_and_leans_as_that_in_the_world(walk, both):
    new, old = both
    tilted = replace(new, table=new.table.copy())  # the pelvis turned forward under the trunk
    human, angle = walk.human, 0.2
    names, values = human.to_coordinates(tilted.rows.q)
    values[:, names.index("pelvis_tilt")] -= angle
    values[:, names.index("lumbar_extension")] += angle
    tilted.rows.q = human.from_coordinates(names, values)
    source = source_of(human, tilted, old, 0.0)
    plain = source_of(human, new, old, 0.0)
    rows = [old.at(0.3), old.at(0.3)]
    for each, row in zip((source, plain), rows, strict=True):
        each.apply(row, 0.3, 0.0, 1.0)
    np.testing.assert_allclose(rows[0].q, rows[1].q, atol=1e-6)
    like = PhaseMap(old.schedule, new.schedule, lifts=False).to_old(0.3)
    arm = 7 + human.hinge("arm_flex_r")
    assert rows[1].q[arm] == pytest.approx(new.at(like).q[arm], abs=1e-9)


def test_styles_are_chosen_by_number_and_begin_anew(walk, slower):
    pose = FixedPose.of(walk.human, {"elbow_flex_r": 1.0})
    walker = Walker(
        walk,
        WalkCommand(
            own="walk",
            walks=(Style(name="stroll", record=slower),),
            uppers=(Style(name="elbow", pose=pose, time=1.0), Style(name=RECORDED, time=2.0)),
        ),
    )
    styles: Styles = walker.styles
    style, upper = styles.targets
    assert style.names == ("walk", "stroll") and upper.names == (RECORDED, "elbow")
    assert walker.targets[3:] == styles.targets
    for time, chosen in ((0.5, 0.0), (1.0, 1.0), (2.0, 0.0)):
        styles.update(time, walks=False)
        assert upper.value == chosen
    style.set(1.0)
    styles.update(2.5, walks=False)  # who stands takes it at once
    assert styles.name == "stroll"
    assert walker.pendulum.reference.recorded.period == pytest.approx(slower.motion.duration)
    styles.begin()
    assert styles.name == "walk" and style.value == 0.0


@pytest.mark.parametrize("joints", ["42", "43", "58", "66"])
def test_named_poses_have_both_arms_alike_whatever_was_recorded(joints):
    human = Human.create(joints=joints)
    for name, angles in POSES.items():
        pose = FixedPose.of(human, {n: float(np.deg2rad(angle)) for n, angle in angles.items()})
        held = dict(zip(np.array(human.coordinates)[pose.hinges], pose.angles, strict=True))
        arms = {n[:-2] for n in held if n.startswith(("arm", "elbow"))}
        assert name == "leaning" or arms == {"arm_flex", "arm_add", "arm_rot", "elbow_flex"}
        assert all(held[f"{n}_r"] == held[f"{n}_l"] for n in arms)
