"""A gait with forces satisfies the equations of motion and the contact constraints."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from plantigrade.constants import FRICTION, SIDES
from plantigrade.dynamics.centroid import centroid, without_constraints
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.ordered_tasks import GaitReference, ReproducedGait, rebuild, reference_of
from plantigrade.ordered_tasks.gait_support import (
    GaitSupport,
    consistent_displacement,
    with_recorded_heel_rise,
    with_shifted_com,
)
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.wbc import Footing, OrderedMotion, TaskOrder, move
from plantigrade.wbc.tasks import ComTask, ContactTask, TimedPosture
from tests.models.presets import person
from tests.ordered_tasks.walks import reference as unfiltered_reference


@cache
def reference() -> GaitReference:
    """The textbook walk, filtered as a recording is; its piecewise curves have corners."""
    known = unfiltered_reference()
    time, qpos = known.motion.time, known.motion.qpos
    smooth = differentiate(known.human, time, qpos, 6.0)
    return reference_of(known.human, time, smooth.qpos, known.events)


@cache
def gait() -> ReproducedGait:
    return rebuild(reference(), forces=True)


def walk() -> OrderedMotion:
    return gait().motion


def support() -> GaitSupport:
    found = gait().support
    assert found is not None
    return found


@cache
def moved_person() -> Human:
    """The person with the centre of mass of the trunk corrected by the estimated forces."""
    return walk().human


def weight() -> float:
    return reference().human.mass * 9.81


def applied(k: int, data) -> np.ndarray:
    """Generalised force of the ground at a tick, from MuJoCo's ``mj_applyFT``."""
    human, motion = moved_person(), walk()
    total, none = np.zeros(human.model.nv), np.zeros(3)
    for i, (name, _, _) in enumerate(human.contact_points):
        if motion.contact_force[k, i].any():
            body = int(human.model.geom_bodyid[human.model.geom(name).id])
            force, point = motion.contact_force[k, i], motion.contact_point[k, i]
            mujoco.mj_applyFT(human.model, data, force, none, point, body, total)
    return total


def test_inverse_dynamics_of_plain_mujoco_finds_the_same_moments_and_nothing_at_the_root():
    motion = walk()
    model = without_constraints(moved_person())
    data = mujoco.MjData(model)
    for k in range(0, len(motion.time), 7):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion.qpos[k], motion.qvel[k], motion.qacc[k]
        mujoco.mj_inverse(model, data)
        explained = data.qfrc_inverse - applied(k, data)
        assert np.abs(explained[:6]).max() < 1e-6 * weight()
        np.testing.assert_allclose(explained[6:], motion.qfrc[k, 6:], atol=1e-6 * weight())


def test_forces_equal_the_rates_of_linear_and_angular_momentum():
    motion = walk()
    whole = centroid(moved_person(), motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None and whole.moment is not None
    np.testing.assert_allclose(motion.contact_force.sum(axis=1), whole.force, atol=1e-6 * weight())
    arm = np.nan_to_num(motion.contact_point) - whole.com[:, None]
    moment = np.cross(arm, motion.contact_force).sum(axis=1)
    np.testing.assert_allclose(moment, whole.moment, atol=1e-6 * weight())


def test_contact_forces_are_unilateral_and_within_the_friction_cone():
    force = walk().contact_force
    assert (force[..., 2] >= 0).all()
    sideways = np.linalg.norm(force[..., :2], axis=-1)
    assert (sideways <= FRICTION * force[..., 2] + 1e-9).all()


def test_joint_moments_stay_within_strength():
    low, high = moved_person().model.jnt_actfrcrange[1:].T
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
    model = without_constraints(moved_person())
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


def test_velocities_are_continuous():
    motion = walk()
    step = motion.time[1] - motion.time[0]
    np.testing.assert_allclose(np.diff(motion.qvel, axis=0), step * motion.qacc[:-1], atol=1e-9)


def test_the_motion_stays_close_to_the_recorded_gait():
    known, motion = reference(), walk()
    apart = np.rad2deg(motion.qpos - known.at(motion.time))
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in SIDES:
            column = apart[:, 7 + known.human.hinge(f"{name}_{side}")]
            assert np.sqrt((column**2).mean()) < 8
    path = centroid(motion.human, motion.qpos, motion.qvel).com
    desired = np.array([support().reference.com(float(t))[0] for t in motion.time])
    assert np.linalg.norm(path - desired, axis=1).max() < 0.03


def test_mean_vertical_force_is_body_weight_and_swing_feet_carry_nothing():
    motion = walk()
    total = motion.contact_force[..., 2].sum(axis=1) / weight()
    assert total.mean() == pytest.approx(1.0, abs=0.05)
    for phase in reference().phases:
        if phase.kind == "single":
            inside = (motion.time > phase.start + 1e-6) & (motion.time < phase.stop - 1e-6)
            assert np.abs(motion.record().foot(phase.swing).force[inside]).max() < 1e-6 * weight()


def test_forces_are_close_to_the_estimate_from_the_recorded_motion():
    """Without the estimate shear varied by a third of body weight, pressure by 10 cm."""
    motion, record = walk(), walk().record()
    desired = np.array([support().wrench_at(float(t)) for t in motion.time])
    for k, side in enumerate(SIDES):
        foot = record.foot(side)
        apart = (foot.force - desired[:, k, :3]) / weight()
        assert (np.sqrt((apart**2).mean(axis=0)) < [0.03, 0.03, 0.08]).all()
        loaded = foot.force[:, 2] > 0.1 * weight()
        starts = np.flatnonzero(np.diff(loaded.astype(int)) == 1) + 1
        for start in starts:
            stop = start + int(np.argmin(np.append(loaded[start:], False)))
            ahead = np.diff(foot.centre_of_pressure[start:stop, 0])
            assert -ahead[ahead < 0].sum() < 0.04


def test_hip_accelerations_are_smooth_across_phases():
    """A law towards each posture in turn had errors of 12 rad/s², as large as the signal."""
    known, motion = reference().motion, walk()
    apart = []
    for side in SIDES:
        hip = 6 + reference().human.hinge(f"hip_flexion_{side}")
        recorded = np.interp(motion.time, known.time, known.qacc[:, hip])
        apart.append(motion.qacc[:, hip] - recorded)
    assert np.sqrt(np.mean(np.square(apart))) < 11


def test_the_floor_constraint_excludes_the_forefoot_during_roll_off():
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


def test_path_momentum_and_forces_are_consistent():
    """Newton's and Euler's laws hold between the force, the path and the angular momentum."""
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
    """A person who stands on both feet and moves the centre of mass."""
    human = person("42", "two-segment")
    sole = ContactSchedule(reference())
    contact = ContactTask(sole.points, lambda t: np.ones(len(sole.points), bool))
    pose = human.standing()
    still = TimedPosture(lambda t: (pose, t + 0.3), lambda t: np.zeros(human.model.nv))
    order = TaskOrder([[contact], [ComTask(com(BodyState(human, pose).com))]], still)
    return move(human, order, pose, stop=0.5, ground=Footing())


def test_both_feet_carry_the_same_load_in_quiet_standing():
    motion = standing(Trajectory.fixed)
    mass = person("42", "two-segment").mass
    right, left = (motion.record().foot(side).force[-1, 2] for side in SIDES)
    assert right + left == pytest.approx(mass * 9.81, rel=1e-3)
    assert right == pytest.approx(left, rel=0.02)


def test_vertical_forces_stay_positive():
    """A centre of mass with a target below free fall accelerates at most with gravity."""
    t = np.linspace(0, 1, 50)
    motion = standing(lambda c: Trajectory(t, c + np.outer(-10 * t**2, [0, 0, 1.0])))
    whole = centroid(person("42", "two-segment"), motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None
    assert whole.force[:, 2].min() > -1e-6 * weight()


def test_an_order_without_contact_raises():
    human = person("42", "two-segment")
    order = TaskOrder([[ComTask(Trajectory.fixed(np.zeros(3)))]])
    with pytest.raises(ParameterError, match="ContactTask"):
        move(human, order, human.standing(), stop=0.1, ground=Footing())


def test_contacts_of_heel_and_ball_end_at_the_recorded_rise():
    """With later ends the heel had to make up two centimetres."""
    known = reference()
    held = tuple(replace(c, stop=c.stop - 0.05) for c in known.contacts)
    found = with_recorded_heel_rise(replace(known, held=held)).contacts
    for ours, early, late in zip(found, held, known.contacts, strict=True):
        assert ours == (late if late.region == "toes" else early)


def test_the_path_follows_fast_accelerations_and_resists_slow_ones():
    """The gain at the frequency w is 1 / (1 + (s / (w^2 d))^2)."""
    t, push, away = np.linspace(0, 20, 4001), 0.2, 0.005
    for rate in (2.0, 2 * np.pi, 20.0):
        found = consistent_displacement(t, np.sin(rate * t)[:, None], push, away)[:, 0]
        middle = (t > 5) & (t < 15)
        share = 1 / (1 + (push / (rate**2 * away)) ** 2)
        np.testing.assert_allclose(
            found[middle], -share * np.sin(rate * t[middle]) / rate**2, atol=2e-3 / rate**2
        )


def test_a_shift_of_the_whole_body_moves_the_mass_of_the_trunk():
    known = reference()
    shift = np.array([-0.012, 0.004, 0.0])
    moved = with_shifted_com(known, shift)
    paths = [
        np.array([s.com for s in sweep(r.human, known.motion.qpos[::20])]) for r in (known, moved)
    ]
    np.testing.assert_allclose((paths[1] - paths[0]).mean(axis=0), shift, atol=1e-3)
    assert moved.human.mass == known.human.mass
    again = Human.from_dict(moved.human.to_dict())
    np.testing.assert_allclose(again.model.body_ipos, moved.human.model.body_ipos, atol=1e-12)
    with pytest.raises(ParameterError, match="trunk"):
        known.human.with_trunk_mass([0.0, 0.2, 0.0])
