"""A gait moved by forces obeys mechanics, whatever the tasks ask for."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from plantigrade.constants import FRICTION, SIDES
from plantigrade.dynamics.centroid import centroid, without_constraints
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State, sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.ordered_tasks import Reference, ReproducedGait, rebuild, reference_of
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.ordered_tasks.support import Support, displaced, rolled_off, with_shift
from plantigrade.wbc import Footing, OrderedMotion, TaskOrder, move
from plantigrade.wbc.tasks import ComTask, ContactTask, PassingPosture
from tests.models.presets import person
from tests.ordered_tasks.walks import reference as as_it_is


@cache
def reference() -> Reference:
    """The textbook walk, filtered as a recording is: its drawn curves have corners."""
    known = as_it_is()
    time, qpos = known.motion.time, known.motion.qpos
    smooth = differentiate(known.human, time, qpos, 6.0)
    return reference_of(known.human, time, smooth.qpos, known.events)


@cache
def gait() -> ReproducedGait:
    return rebuild(reference(), forces=True)


def walk() -> OrderedMotion:
    return gait().motion


def support() -> Support:
    found = gait().support
    assert found is not None
    return found


@cache
def carried() -> Human:
    """Who is moved: the trunk's mass lies where the forces tell."""
    return walk().human


def weight() -> float:
    return reference().human.mass * 9.81


def applied(k: int, data) -> np.ndarray:
    """Generalised force of the ground at a tick, by MuJoCo's own routine."""
    human, motion = carried(), walk()
    total, none = np.zeros(human.model.nv), np.zeros(3)
    for i, (name, _, _) in enumerate(human.contact_points):
        if motion.contact_force[k, i].any():
            body = int(human.model.geom_bodyid[human.model.geom(name).id])
            force, point = motion.contact_force[k, i], motion.contact_point[k, i]
            mujoco.mj_applyFT(human.model, data, force, none, point, body, total)
    return total


def test_inverse_dynamics_of_plain_mujoco_finds_the_same_moments_and_nothing_at_the_root():
    motion = walk()
    model = without_constraints(carried())
    data = mujoco.MjData(model)
    for k in range(0, len(motion.time), 7):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion.qpos[k], motion.qvel[k], motion.qacc[k]
        mujoco.mj_inverse(model, data)
        explained = data.qfrc_inverse - applied(k, data)
        assert np.abs(explained[:6]).max() < 1e-6 * weight()
        np.testing.assert_allclose(explained[6:], motion.qfrc[k, 6:], atol=1e-6 * weight())


def test_forces_accelerate_the_centre_of_mass_and_turn_the_body():
    motion = walk()
    whole = centroid(carried(), motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None and whole.moment is not None
    np.testing.assert_allclose(motion.contact_force.sum(axis=1), whole.force, atol=1e-6 * weight())
    arm = np.nan_to_num(motion.contact_point) - whole.com[:, None]
    moment = np.cross(arm, motion.contact_force).sum(axis=1)
    np.testing.assert_allclose(moment, whole.moment, atol=1e-6 * weight())


def test_the_ground_pushes_and_does_not_slip():
    force = walk().contact_force
    assert (force[..., 2] >= 0).all()
    sideways = np.linalg.norm(force[..., :2], axis=-1)
    assert (sideways <= FRICTION * force[..., 2] + 1e-9).all()


def test_joint_moments_stay_within_strength():
    low, high = carried().model.jnt_actfrcrange[1:].T
    tau = walk().qfrc[:, 6:]
    assert (tau > low - 1e-3).all() and (tau < high + 1e-3).all()
    assert np.abs(walk().qfrc[:, :6]).max() < 1e-6 * weight()


def test_forces_act_at_the_ground_on_points_of_the_soles():
    motion = walk()
    carries = motion.contact_force.any(axis=2)
    height = motion.contact_point[carries][:, 2]
    assert height.min() > -0.005 and height.max() < 0.011
    assert len(motion.sites) == motion.contact_force.shape[1]


def test_power_of_forces_and_moments_changes_the_energy():
    """The work of joints and ground is the gain in energy, but for the finite step."""
    motion = walk()
    model = without_constraints(carried())
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    energy, power, moved = [], [], []
    step = motion.time[1] - motion.time[0]
    for k in range(len(motion.time)):
        data.qpos[:], data.qvel[:] = motion.qpos[k], motion.qvel[k]
        mujoco.mj_forward(model, data)
        energy.append(data.energy.sum())
        velocity = motion.qvel[k] + 0.5 * step * motion.qacc[k]  # in the middle of the step
        power.append((motion.qfrc[k] + applied(k, data)) @ velocity)
        moved.append(np.abs(motion.qfrc[k] * velocity).sum())
    work = np.concatenate([[0.0], np.cumsum(power[:-1]) * step])
    gained = np.array(energy) - energy[0]
    assert np.abs(work - gained).max() < 0.02 * np.sum(moved) * step


def test_nothing_jumps():
    motion = walk()
    step = motion.time[1] - motion.time[0]
    np.testing.assert_allclose(np.diff(motion.qvel, axis=0), step * motion.qacc[:-1], atol=1e-9)


def test_it_is_still_the_gait():
    known, motion = reference(), walk()
    apart = np.rad2deg(motion.qpos - known.at(motion.time))
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in SIDES:
            column = apart[:, 7 + known.human.hinge(f"{name}_{side}")]
            assert np.sqrt((column**2).mean()) < 8
    path = centroid(motion.human, motion.qpos, motion.qvel).com
    wanted = np.array([support().reference.com(float(t))[0] for t in motion.time])
    assert np.linalg.norm(path - wanted, axis=1).max() < 0.03


def test_the_ground_carries_the_body_on_average_and_each_foot_in_turn():
    motion = walk()
    total = motion.contact_force[..., 2].sum(axis=1) / weight()
    assert total.mean() == pytest.approx(1.0, abs=0.05)
    for phase in reference().phases:
        if phase.kind == "single":
            inside = (motion.time > phase.start + 1e-6) & (motion.time < phase.stop - 1e-6)
            assert np.abs(motion.record().foot(phase.swing).force[inside]).max() < 1e-6 * weight()


def test_forces_are_those_that_the_recorded_motion_tells():
    """They once ran back and forth: by a third of body weight in shear, 10 cm on the ground."""
    motion, record = walk(), walk().record()
    wanted = np.array([support().wrench_at(float(t)) for t in motion.time])
    for k, side in enumerate(SIDES):
        foot = record.foot(side)
        apart = (foot.force - wanted[:, k, :3]) / weight()
        assert (np.sqrt((apart**2).mean(axis=0)) < [0.03, 0.03, 0.08]).all()
        loaded = foot.force[:, 2] > 0.1 * weight()
        starts = np.flatnonzero(np.diff(loaded.astype(int)) == 1) + 1
        for start in starts:
            stop = start + int(np.argmin(np.append(loaded[start:], False)))
            ahead = np.diff(foot.centre_of_pressure[start:stop, 0])
            assert -ahead[ahead < 0].sum() < 0.04


def test_the_hips_do_not_feel_where_one_phase_ends_and_the_next_begins():
    """Aimed at each posture in turn they were 12 rad/s² off, as much as they accelerate at all."""
    known, motion = reference().motion, walk()
    apart = []
    for side in SIDES:
        hip = 6 + reference().human.hinge(f"hip_flexion_{side}")
        recorded = np.interp(motion.time, known.time, known.qacc[:, hip])
        apart.append(motion.qacc[:, hip] - recorded)
    assert np.sqrt(np.mean(np.square(apart))) < 11


def test_the_floor_lets_the_forefoot_of_a_rolling_foot_be():
    schedule = ContactSchedule(reference())
    rolled = 0
    for t in motion_times():
        on, guarded = schedule(t), schedule.guarded(t)
        assert not (on & guarded).any()
        for side in SIDES:
            foot = schedule.side == side
            heel, fore = foot & (schedule.region == "heel"), foot & (schedule.region != "heel")
            rolls = on[fore].any() and not on[heel].any()
            assert guarded[heel].all() == (not on[heel].any())
            assert (guarded[fore] == (~on[fore] & (not rolls))).all()
            rolled += bool(rolls)
    assert rolled > 10


def motion_times() -> list[float]:
    return walk().time.tolist()


def test_path_momentum_and_forces_belong_together():
    """Force by mass bends the path, its moment about the path turns the body: nothing fights."""
    known = support()
    h = 1e-4
    for t in np.linspace(known.reference.start + 0.1, known.reference.stop - 0.1, 9).tolist():
        force, moment = known.wrench_at(t)[:, :3].sum(axis=0), known.wrench_at(t)[:, 3:].sum(axis=0)
        com, _, bend = known.com(t)
        mass = known.reference.human.mass
        np.testing.assert_allclose(force / mass, bend + [0, 0, 9.81], atol=0.05)
        rate = (known.momentum(t + h)[0] - known.momentum(t - h)[0]) / (2 * h)
        np.testing.assert_allclose(moment - np.cross(com, force), rate, atol=0.01 * weight())


def standing(com) -> OrderedMotion:
    """Somebody who stands on both feet and moves the centre of mass."""
    human = person("42", "two-segment")
    sole = ContactSchedule(reference())
    contact = ContactTask(sole.points, lambda t: np.ones(len(sole.points), bool))
    pose = human.standing()
    still = PassingPosture(lambda t: (pose, t + 0.3), lambda t: np.zeros(human.model.nv))
    order = TaskOrder([[contact], [ComTask(com(State(human, pose).com))]], still)
    return move(human, order, pose, stop=0.5, ground=Footing())


def test_who_stands_still_is_carried_by_both_feet_alike():
    motion = standing(Trajectory.fixed)
    mass = person("42", "two-segment").mass
    right, left = (motion.record().foot(side).force[-1, 2] for side in SIDES)
    assert right + left == pytest.approx(mass * 9.81, rel=1e-3)
    assert right == pytest.approx(left, rel=0.02)


def test_nobody_falls_upwards():
    """A centre of mass asked to drop faster than gravity drops at most as fast as gravity."""
    t = np.linspace(0, 1, 50)
    motion = standing(lambda c: Trajectory(t, c + np.outer(-10 * t**2, [0, 0, 1.0])))
    whole = centroid(person("42", "two-segment"), motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None
    assert whole.force[:, 2].min() > -1e-6 * weight()


def test_an_order_without_contact_is_refused():
    human = person("42", "two-segment")
    order = TaskOrder([[ComTask(Trajectory.fixed(np.zeros(3)))]])
    with pytest.raises(ParameterError, match="ContactTask"):
        move(human, order, human.standing(), stop=0.1, ground=Footing())


def test_heel_and_ball_let_go_where_the_recorded_ones_rise():
    """They were held until they had risen by two centimetres, and then had to catch up."""
    known = reference()
    held = tuple(replace(c, stop=c.stop - 0.05) for c in known.contacts)
    found = rolled_off(replace(known, held=held)).contacts
    for ours, early, late in zip(found, held, known.contacts, strict=True):
        assert ours == (late if late.region == "toes" else early)


def test_a_path_follows_a_fast_push_and_resists_a_slow_one():
    """Of a push a sin(w t) it takes the share 1 / (1 + (s / (w^2 d))^2)."""
    t, push, away = np.linspace(0, 20, 4001), 0.2, 0.005
    for rate in (2.0, 2 * np.pi, 20.0):
        found = displaced(t, np.sin(rate * t)[:, None], push, away)[:, 0]
        middle = (t > 5) & (t < 15)
        share = 1 / (1 + (push / (rate**2 * away)) ** 2)
        np.testing.assert_allclose(
            found[middle], -share * np.sin(rate * t[middle]) / rate**2, atol=2e-3 / rate**2
        )


def test_the_mass_of_the_trunk_is_moved_where_the_forces_tell():
    known = reference()
    shift = np.array([-0.012, 0.004, 0.0])
    moved = with_shift(known, shift)
    paths = [
        np.array([s.com for s in sweep(r.human, known.motion.qpos[::20])]) for r in (known, moved)
    ]
    np.testing.assert_allclose((paths[1] - paths[0]).mean(axis=0), shift, atol=1e-3)
    assert moved.human.mass == known.human.mass
    again = Human.from_dict(moved.human.to_dict())
    np.testing.assert_allclose(again.model.body_ipos, moved.human.model.body_ipos, atol=1e-12)
    with pytest.raises(ParameterError, match="trunk"):
        known.human.with_trunk_mass([0.0, 0.2, 0.0])
