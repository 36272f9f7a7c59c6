"""Ground reactions without plates: statics, equilibrium, symmetry, what was put in comes out."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.contact.ground import Ground
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.force_program import ForceProgram
from plantigrade.dynamics.force_rows import ForceLayout, PathPrior, objective
from plantigrade.dynamics.force_scales import PHASE, ForceScales, UsualStance
from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.loading import Support, find_loading
from plantigrade.dynamics.plates import FootForces
from plantigrade.dynamics.required_forces import required_forces
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs
from tests.analyze.plated_walk import plated_walk

G = 9.81


def standing(human, n=40, rate=100.0):
    """Return a motion of quiet standing."""
    time = np.arange(n) / rate
    qpos = np.tile(human.standing(), (n, 1))
    zero = np.zeros((n, human.model.nv))
    return Motion(time, qpos, zero, human.joint_names, zero)


@pytest.fixture(scope="module")
def human():
    return Human.create(1.74, 71.0)


def test_each_foot_carries_half_of_a_standing_person(human):
    found = estimate_forces(human, standing(human))
    np.testing.assert_allclose(found.forces.force[..., 2] / (human.mass * G), 0.5, atol=2e-3)
    np.testing.assert_allclose(found.forces.force[..., :2] / (human.mass * G), 0.0, atol=0.02)
    assert found.noise == 1.0
    assert np.isfinite(found.forces.point).all()


def test_a_motion_without_accelerations_is_refused(human):
    motion = standing(human)
    without = Motion(motion.time, motion.qpos, motion.qvel, motion.joint_names)
    with pytest.raises(ParameterError, match="no accelerations"):
        estimate_forces(human, without)


def test_a_foot_that_was_measured_stays_as_measured(human):
    motion = standing(human)
    n, weight = motion.n_frames, human.mass * G
    whole = estimate_forces(human, motion).forces
    force, valid = np.zeros((n, 2, 3)), np.zeros((n, 2), bool)
    force[:, 0, 2], valid[:, 0] = 0.7 * weight, True
    plates = FootForces(force, whole.point, np.zeros((n, 2, 3)), valid, np.zeros(n, bool))
    found = estimate_forces(human, motion, measured=plates)
    np.testing.assert_array_equal(found.forces.force[:, 0], force[:, 0])
    np.testing.assert_allclose(found.forces.force[:, 1, 2] / weight, 0.3, atol=0.01)
    assert found.measured[:, 0].all() and not found.measured[:, 1].any()
    assert (found.force_band[:, 0] == 0).all() and (found.force_band[:, 1] > 0).all()


def test_a_seat_takes_what_the_feet_do_not(human):
    motion = standing(human)
    first, last = motion.time[[0, -1]]
    always = [ContactInterval(s, "sole", float(first), float(last), False, False) for s in "rl"]
    seat = Support("seat", "pelvis", (-0.05, 0.0, -0.1))
    contacts = (*always, ContactInterval("", "seat", float(first), float(last), False, False))
    n, weight = motion.n_frames, human.mass * G
    feet = estimate_forces(human, motion).forces
    light = FootForces(
        0.3 * feet.force, feet.point, feet.torque, np.ones((n, 2), bool), np.ones(n, bool)
    )
    found = estimate_forces(human, motion, measured=light, contacts=contacts, supports=(seat,))
    np.testing.assert_allclose(found.support_force[:, 0, 2] / weight, 0.7, atol=5e-3)


def swaying(human, n=120, rate=100.0):
    """Return a body that moves up and sideways as one piece, and the force that it needs [BW]."""
    motion = standing(human, n, rate)
    t, w = motion.time, 2 * np.pi * np.array([0.8, 1.1])
    angle = w * t[:, None]
    qpos, qvel, qacc = motion.qpos.copy(), motion.qvel.copy(), motion.qvel.copy()
    size = np.array([0.03, 0.02])  # [m]
    qpos[:, 1:3] += size * np.sin(angle)
    qvel[:, 1:3], qacc[:, 1:3] = size * w * np.cos(angle), -size * w**2 * np.sin(angle)
    force = np.zeros((n, 3))
    force[:, 1:] = qacc[:, 1:3] / G
    force[:, 2] += 1.0
    return Motion(t, qpos, qvel, human.joint_names, qacc), force


def test_both_feet_together_give_what_the_motion_needs(human):
    motion, force = swaying(human)
    found = estimate_forces(human, motion)
    total = found.forces.force.sum(axis=1) / (human.mass * G)
    np.testing.assert_allclose(total, force, atol=0.02)
    assert found.noise < 2.0 and found.residual_force < 0.01


def test_the_foot_off_the_plate_carries_the_rest(human):
    motion, force = swaying(human)
    n, weight = motion.n_frames, human.mass * G
    share = 0.5 + 0.2 * np.sin(2 * np.pi * 0.5 * motion.time)[:, None]  # that no motion tells
    point = estimate_forces(human, motion).forces.point
    given, valid = np.zeros((n, 2, 3)), np.zeros((n, 2), bool)
    given[:, 1], valid[:, 1] = share * force * weight, True
    plates = FootForces(given, point, np.zeros((n, 2, 3)), valid, np.zeros(n, bool))
    found = estimate_forces(human, motion, measured=plates)
    rest = (1.0 - share[:, 0]) * force[:, 2]
    np.testing.assert_allclose(found.forces.force[:, 0, 2] / weight, rest, atol=0.03)
    free = estimate_forces(human, motion)
    assert found.force_band[:, 0, 2].mean() < 0.5 * free.force_band[:, 0, 2].mean()


def noisy(human, motion, seed=0):
    """Return a motion with noise of 2 mm and 0.6° below 5 Hz in every coordinate."""
    rng, n, nv = np.random.default_rng(seed), motion.n_frames, human.model.nv
    spectrum = np.fft.rfft(rng.normal(size=(n, nv)), axis=0)
    spectrum[np.fft.rfftfreq(n, motion.time[1]) > 5.0] = 0.0
    noise = np.fft.irfft(spectrum, n, axis=0)
    noise *= np.r_[[0.002] * 3, [np.deg2rad(0.6)] * (nv - 3)] / noise.std(axis=0)
    qpos = motion.qpos.copy()
    for frame in range(n):
        mujoco.mj_integratePos(human.model, qpos[frame], noise[frame], 1.0)
    d = differentiate(human, motion.time, qpos, 6.0)
    return replace(motion, qpos=d.qpos, qvel=d.qvel, qacc=d.qacc)


def test_a_noisy_motion_is_found_out_and_its_bands_hold_the_truth(human):
    motion, force = swaying(human, n=200)
    shaken = noisy(human, motion)
    clean, found = estimate_forces(human, motion), estimate_forces(human, shaken)
    assert found.noise > max(2.0, 1.5 * clean.noise)
    true, weight = clean.forces.force, human.mass * G
    inside = np.abs(found.forces.force - true) <= found.force_band
    assert inside.mean(axis=(0, 1)).min() > 0.8
    assert found.force_band.mean() < 0.25 * weight  # and say something
    raw = centroid(human, shaken.qpos, shaken.qvel, shaken.qacc).force / weight
    total = found.forces.force.sum(axis=1) / weight
    assert np.std(total - force, axis=0)[1] < 0.8 * np.std(raw - force, axis=0)[1]


def test_few_frames_and_forces_on_another_clock_are_refused(human):
    motion = standing(human)
    with pytest.raises(ParameterError, match="3 frames are too few"):
        estimate_forces(human, motion.frames(slice(0, 3)))
    forces = estimate_forces(human, motion).forces
    with pytest.raises(ParameterError, match="put both on one clock"):
        estimate_forces(human, motion.frames(slice(0, 20)), measured=forces)


def test_in_a_turn_the_usual_force_to_the_side_weighs_less(human):
    motion = standing(human, 60)
    feet = (ContactInterval("r", "foot", 0.0, 0.59), ContactInterval("l", "foot", 0.0, 0.59))
    weights = []
    for pull in (0.0, 0.1):  # to the left [BW]
        qacc = motion.qvel.copy()
        qacc[:, 1] = pull * G
        needs = required_forces(human, motion, qacc, feet)
        contact = np.ones((60, 2), bool)
        ahead = np.tile([1.0, 0.0], (60, 2, 1))
        nowhere = np.full((60, 2, 2), np.nan)
        prior = PathPrior(
            nowhere, np.ones((60, 2, 2)), np.zeros((60, 2)), ahead, np.full((60, 2), np.nan)
        )
        rows = objective(needs, ForceLayout.of(contact), prior, effort=False)
        A, _ = rows.system()
        weights.append(np.abs(A[rows.blocks["side"]]).max())
    assert weights[0] == pytest.approx(1.0) and weights[1] < 0.25


def test_the_lean_of_the_shanks_is_that_of_the_body_on_any_ground(human):
    motion = standing(human, 8)
    feet = (ContactInterval("r", "sole", 0.0, 0.1), ContactInterval("l", "sole", 0.0, 0.1))
    qacc = np.zeros_like(motion.qvel)
    forward = Rotation.from_euler("y", 0.2)  # about the left axis
    qpos = motion.qpos.copy()
    qpos[:, 3:7] = (forward * Rotation.from_quat(qpos[:, [4, 5, 6, 3]])).as_quat()[:, [3, 0, 1, 2]]
    upright = required_forces(human, motion, qacc, feet).lean
    for ground in (Ground(), Ground(slope=0.1)):
        leaning = required_forces(human, replace(motion, qpos=qpos), qacc, feet, (), ground).lean
        np.testing.assert_allclose(leaning - upright, 0.2, atol=0.01)


def test_a_slope_under_turned_gravity_is_level_ground(human):
    """All that the program says turns with the ground, bands of the feet included.

    Feet do not roll here: the roll-over follows the shank's lean from the vertical of gravity.
    """
    walk = plated_walk()
    motion = Motion(
        walk.walk.time, walk.qpos, walk.qvel, human.joint_names, walk.qacc, walk.walk.events
    )
    ground = Ground(slope=np.deg2rad(9.0))
    R, down = ground.to_world, np.array([0.0, 0.0, -G])
    up = Rotation.from_matrix(R)
    qpos, qvel, qacc = (np.array(x) for x in (walk.qpos, walk.qvel, walk.qacc))
    qpos[:, :3], qvel[:, :3] = qpos[:, :3] @ R.T, qvel[:, :3] @ R.T
    qpos[:, 3:7] = (up * Rotation.from_quat(qpos[:, [4, 5, 6, 3]])).as_quat()[:, [3, 0, 1, 2]]
    qacc[:, :3] = qacc[:, :3] @ R.T + down - R @ down  # as if gravity had turned, too
    turned = replace(motion, qpos=qpos, qvel=qvel, qacc=qacc)
    steps = find_loading(walk.walk.human, motion).contacts
    flat = tuple(replace(each, region="sole") for each in steps)
    level = estimate_forces(walk.walk.human, motion, contacts=flat)
    found = estimate_forces(walk.walk.human, turned, contacts=flat, ground=ground)
    np.testing.assert_allclose(found.forces.force, level.forces.force @ R.T, atol=0.5)
    np.testing.assert_allclose(found.forces.point, level.forces.point @ R.T, atol=1e-3)
    np.testing.assert_allclose(found.forces.torque, level.forces.torque @ R.T, atol=0.1)
    np.testing.assert_allclose(found.com_shift, R @ level.com_shift, atol=1e-4)
    np.testing.assert_allclose(found.force_band[..., 1], level.force_band[..., 1], atol=2.0)


STEP, BOTH = 0.5, 0.14  # from one landing to the next, and with both feet on the ground [s]


def steps(first: float, last: float) -> tuple[ContactInterval, ...]:
    """Return the stances of steps on the spot that a recording from ``first`` to ``last`` sees."""
    found = []
    for i in range(-2, 8):
        start, stop = i * STEP, (i + 1) * STEP + BOTH
        begins, ends = start > first, stop < last
        if start < last and stop > first:
            span = max(start, first), min(stop, last)
            found.append(ContactInterval("rl"[i % 2], "foot", *span, bool(begins), bool(ends)))
    return tuple(found)


def in_line(human, n: int) -> Motion:
    """Return a body that stands with one foot in the place of the other, and sinks and rises."""
    motion, _ = swaying(human, n)
    qpos, qvel, qacc = motion.qpos.copy(), motion.qvel.copy(), motion.qacc.copy()
    state = next(iter(sweep(human, qpos[:1])))
    hip, foot = (state.origin(human.body(f"{name}_l")) for name in ("femur", "foot"))
    for side in "rl":
        qpos[:, 7 + human.hinge(f"hip_adduction_{side}")] = np.arctan2(hip[1], (hip - foot)[2])
    qpos[:, 1], qvel[:, 1], qacc[:, 1] = qpos[0, 1], 0.0, 0.0
    return replace(motion, qpos=qpos, qvel=qvel, qacc=qacc)


@pytest.mark.parametrize("part", [0.25, 0.5, 0.75])
def test_feet_share_the_load_at_the_ends_as_if_the_recording_went_on(human, part):
    """A cut in double support changes little of how far the load has gone over."""
    motion, weight = in_line(human, 270), human.mass * G
    time = motion.time
    whole = estimate_forces(human, motion, contacts=steps(-1.0, 9.0)).forces.force[..., 2]
    for kept in (time <= 3 * STEP + part * BOTH, time >= STEP + part * BOTH):
        some = motion.frames(np.flatnonzero(kept))
        contacts = steps(some.time[0], some.time[-1])
        found = estimate_forces(human, some, contacts=contacts).forces.force[..., 2]
        off = (found - whole[kept]) / weight
        for end in (slice(15), slice(-15, None)):  # 0.15 s
            assert np.sqrt(np.mean(off[end] ** 2)) < 0.13


def test_a_load_that_goes_over_late_and_at_once_is_seen():
    """The net moment tells how feet far apart share the load, however evenly it usually goes over.

    Each foot has its usual centre of pressure. Either the load goes over evenly, or it stays on the
    rear foot for two thirds of a double support.
    """
    plated = plated_walk()
    human, time = plated.walk.human, plated.walk.time
    motion = Motion(
        time, plated.qpos, plated.qvel, human.joint_names, plated.qacc, plated.walk.events
    )
    contacts = find_loading(human, motion).contacts
    needs = required_forces(human, motion, plated.qacc, contacts)
    gone, arm = np.zeros((len(time), 2)), np.zeros((len(time), 2, 3))
    stands = np.zeros((len(time), 2), dtype=bool)
    for each in contacts:
        k, here = "rl".index(each.side), each.frames(time)
        gone[here, k] = each.share(time[here], each.stop - each.start)
        stands[here, k] = True
        ahead = human.dimensions.foot_length * np.interp(
            gone[here, k], PHASE, UsualStance().cop_forward
        )
        arm[here, k, :2] = ahead[:, None] * needs.heading[here, k]
    both = stands.all(axis=1)
    inner = [run for run in runs(both) if run.start > 5 and run.stop < len(time) - 5]
    within = np.concatenate([np.r_[run] for run in inner])
    missed, bends = [], []
    for late in (False, True):
        share = stands / np.maximum(stands.sum(axis=1, keepdims=True), 1)
        for run in inner:
            front = int(np.argmin(gone[run.start]))
            passed = np.linspace(0.0, 1.0, run.stop - run.start)
            share[run, front] = np.clip(3.0 * passed - 2.0, 0.0, 1.0) if late else passed
            share[run, 1 - front] = 1.0 - share[run, front]
        force = share[..., None] * needs.force[:, None]
        moment = np.cross(needs.base + arm - needs.com[:, None], force).sum(axis=1)
        scales = ForceScales.of(walks=True)
        program = ForceProgram(human, replace(needs, moment=moment), contacts, (), None, scales)
        program.solve()
        off = program.wrench[within, :2, 2] - force[within, :, 2]
        missed.append(np.sqrt(np.mean(off**2)))
        bends.append(program.bending.max())
    assert bends[0] == 1.0 < bends[1]
    assert missed[0] < 0.12
    assert missed[1] < 0.29  # 0.34 if forces bend no more than usual
