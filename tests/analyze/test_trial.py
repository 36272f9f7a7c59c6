"""A fitted recording analysed: mass, forces, moments and energy as physics has them."""

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.constants import GRAVITY as G
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.textbook_recording import recorded, textbook_walk
from plantigrade.models import Human
from plantigrade.motion import ForcePlate, Subject
from tests.analyze.plated_walk import (
    MASS,
    analyse,
    plain,
    plated_walk,
    standing_fit,
    without_plates,
)


@pytest.fixture(scope="module")
def exact():
    """The walk with plates, analysed without a filter."""
    return analyse(plated_walk().fit(), cutoff=None)


def inner(trial) -> slice:
    """Frames away from the ends, where a derivative has one side to go by."""
    return slice(10, trial.motion.n_frames - 10)


def test_the_ground_carries_the_walk(exact):
    """Forces of mass times acceleration leave nothing at the pelvis."""
    weight = MASS * G
    force = np.linalg.norm(exact.moments.residual_force, axis=1)[inner(exact)]
    moment = np.linalg.norm(exact.moments.residual_moment, axis=1)[inner(exact)]
    assert force.max() < 0.01 * weight
    assert moment.max() < 0.01 * weight * 1.0  # a hundredth of body weight at a metre
    assert exact.figures["residual_force_max_n"] < 0.01 * weight


def test_moments_are_those_of_a_direct_computation(exact):
    """Each foot's wrench through its Jacobian, with nothing but MuJoCo."""
    made = plated_walk()
    model = plain(made.walk.human)
    data = mujoco.MjData(model)
    for f in range(10, len(made.qpos) - 10, 7):
        data.qpos[:] = made.qpos[f]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        tau = made.tau[f].copy()
        for plate in made.plates:
            if plate.force[f, 2] == 0:
                continue
            jacp, jacr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            foot = model.body(f"foot_{plate.side}").id
            mujoco.mj_jac(model, data, jacp, jacr, plate.cop[f], foot)
            tau -= jacp.T @ plate.force[f] + jacr.T @ [0.0, 0.0, plate.free_moment[f]]
        np.testing.assert_allclose(exact.moments.tau[f], tau, atol=1e-6)


def test_joints_and_ground_pay_for_the_energy(exact):
    """Power of the joints and of the ground is the rate of kinetic and potential energy."""
    motion = exact.motion
    model = plain(exact.fit.human)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    energy, power = [], []
    for f in range(motion.n_frames):
        data.qpos[:], data.qvel[:] = motion.qpos[f], motion.qvel[f]
        mujoco.mj_forward(model, data)
        mujoco.mj_energyVel(model, data)
        energy.append(data.energy.sum())
        at = exact.moments.power[f].sum()
        for k, side in enumerate(exact.forces.sides):
            point = exact.forces.point[f, k]
            if not np.isfinite(point).all():
                continue
            jacp, jacr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            mujoco.mj_jac(model, data, jacp, jacr, point, model.body(f"foot_{side}").id)
            at += exact.forces.force[f, k] @ (jacp @ motion.qvel[f])
            at += exact.forces.torque[f, k] @ (jacr @ motion.qvel[f])
        power.append(at)
    rate = np.gradient(np.array(energy), motion.time)
    use = inner(exact)
    off = np.array(power)[use] - rate[use]
    assert np.sqrt(np.mean(off**2)) < 0.03 * np.sqrt(np.mean(rate[use] ** 2))


def test_filtering_motion_and_forces_alike_keeps_them_together():
    trial = analyse(plated_walk().fit())
    share = trial.figures["residual_force_rms_share"]
    assert share < 0.05, "the usual bound of a residual force"


def test_segments_share_what_the_foot_carries():
    """With hinged toes the record says which segment carries, and the sum is the foot's."""
    made = plated_walk(feet="two-segment")
    trial = analyse(made.fit(), cutoff=None)
    record = trial.record()
    assert [s.body for s in record.sites] == ["foot_r", "toes_r", "foot_l", "toes_l"]
    assert all(s.measured for s in record.sites)
    for k, side in enumerate(trial.forces.sides):
        mine = [i for i, s in enumerate(record.sites) if s.side == side]
        total = record.contact_force[:, mine].sum(axis=1)
        np.testing.assert_allclose(total, trial.forces.force[:, k], atol=1e-9)
    loaded = np.linalg.norm(record.contact_force, axis=2) > 0
    assert (np.isfinite(record.contact_point).all(axis=2) == loaded).all()
    assert loaded[:, 1].any() and loaded[:, 3].any()


def test_contacts_of_many_bones_add_up():
    """The same wrench about the origin, whatever the foot is made of."""
    made = plated_walk(feet="multi-segment")
    trial = analyse(made.fit(), cutoff=None)
    record, forces = trial.record(), trial.forces
    assert len(record.sites) > 4
    for k, side in enumerate(forces.sides):
        mine = [i for i, s in enumerate(record.sites) if s.side == side]
        arm = np.nan_to_num(record.contact_point[:, mine])
        load = record.contact_force[:, mine]
        moment = (np.cross(arm, load) + record.contact_torque[:, mine]).sum(axis=1)
        at = np.nan_to_num(forces.point[:, k])
        np.testing.assert_allclose(
            moment, np.cross(at, forces.force[:, k]) + forces.torque[:, k], atol=1e-6
        )
        np.testing.assert_allclose(load.sum(axis=1), forces.force[:, k], atol=1e-9)


def test_the_plates_weigh_a_walker():
    """A person fitted too light is weighed by the impulse of a stride."""
    trial = analyse(plated_walk().fit(known_mass=False, mass=55.0))
    assert trial.fit.human.mass == pytest.approx(MASS, rel=0.01)
    assert trial.figures["mass_kg"] == trial.fit.human.mass
    assert any("force plates measured" in w for w in trial.notes)
    assert trial.fit.human.height == pytest.approx(1.74)


@pytest.mark.parametrize("given_mass", [None, 55.0])
def test_a_given_mass_is_kept(given_mass):
    fit = plated_walk().fit(known_mass=given_mass is None)
    trial = analyse(fit, mass=given_mass)
    assert trial.fit.human.mass == pytest.approx(given_mass or MASS)
    doubted = [w for w in trial.notes if "mass" in w]
    assert (
        not doubted
        if given_mass is None
        else "55.0 kg, but the force plates measured 71" in doubted[0]
    )


def test_without_forces_the_mass_is_a_guess_and_says_so():
    trial = analyse(without_plates(plated_walk().fit(known_mass=False)))
    assert trial.forces is None and trial.measured is None
    assert trial.ground is not None and not trial.ground.measured.any()
    assert any("mass is unknown" in w for w in trial.notes)


def test_moments_of_a_foot_off_the_plates_are_noted_as_estimated():
    fit = plated_walk().fit()
    one = replace(fit, recording=replace(fit.recording, plates=fit.recording.plates[:1]))
    trial = analyse(one)
    assert trial.ground is not None and not trial.ground.measured.all()
    said = [note for note in trial.notes if "stands on no force plate" in note]
    assert said and all("estimated" in note for note in said)
    assert not any("moments are unknown" in note for note in trial.notes)


@pytest.mark.parametrize(("height", "index"), [(1.04, 15.4), (1.44, 17.3), (1.81, 22.0)])
def test_a_mass_that_is_not_given_is_that_of_people_of_this_stature(height, index):
    """Body mass index of the growth charts' median child, and of a healthy adult."""
    walk = textbook_walk(Human.create(height, 50.0), speed=1.3 * np.sqrt(height / 1.8), cycles=1)
    unknown = replace(recorded(walk, Path("walk.c3d")), subject=Subject(height=height))
    trial = analyse(fit_markers(unknown))
    mass = trial.fit.human.mass
    assert mass == pytest.approx(index * height**2, rel=0.02)
    said = [note for note in trial.notes if "mass is unknown" in note]
    assert len(said) == 1 and f"{mass:.1f} ± " in said[0] and "--mass" in said[0]


def plate(where, push, *, half=0.3, wide=None, rate=1000, seconds=1.5) -> ForcePlate:
    """A plate about a point that carries a steady weight with a little noise [N]."""
    time = np.arange(int(rate * seconds)) / rate
    rng = np.random.default_rng(3)
    force = np.zeros((len(time), 3))
    force[:, 2] = push + (rng.normal(0, 2.0, len(time)) if push else 0.0)
    cop = np.tile([where[0], where[1], 0.0], (len(time), 1))
    if not push:
        cop[:] = np.nan
    out = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
    corners = [where[0], where[1], 0] + out * [half, wide or half, 0]
    return ForcePlate("1", time, force, cop, np.zeros(len(time)), corners)


def soles(human) -> dict[str, np.ndarray]:
    """Middle of each sole of the standing person."""
    from plantigrade.dynamics.plates import sole_points

    points = sole_points(human, human.standing()[None])
    return {s: points[s][0].mean(axis=0) for s in "rl"}


@pytest.mark.parametrize("how", ["a plate per foot", "one plate"])
def test_the_plates_weigh_a_standing_person(how):
    human = Human.create(1.68, 58.0, "female")
    weight = 66.3 * G
    at = soles(human)
    if how == "one plate":
        plates = (plate((at["r"] + at["l"]) / 2, weight, half=0.6),)
    else:
        apart = abs(at["l"][1] - at["r"][1]) / 2
        plates = tuple(
            plate(at[s], share * weight, wide=apart) for s, share in (("r", 0.55), ("l", 0.45))
        )
    trial = analyse(standing_fit(human, plates))
    assert trial.cycles == ()
    assert trial.fit.human.mass == pytest.approx(66.3, rel=0.005)


def test_one_foot_off_the_plate_gives_no_mass():
    human = Human.create(1.68, 58.0, "female")
    trial = analyse(standing_fit(human, (plate(soles(human)["r"], 320.0, half=0.07),)))
    assert trial.fit.human.mass == pytest.approx(58.0), "half a person was taken for a whole one"


def test_a_few_frames_are_analysed_without_a_filter():
    human = Human.create(1.7, 60.0)
    for n in (3, 5, 11):
        trial = analyse(standing_fit(human, (), n))
        assert trial.motion.n_frames == n
        np.testing.assert_allclose(trial.motion.qpos, trial.fit.qpos, atol=1e-12)


def test_another_mass_keeps_the_lengths():
    human = Human.create(1.70, 60.0, "female", lengths={"thigh": 0.45, "hand": 0.16})
    heavier = human.with_mass(80.0)
    assert heavier.mass == pytest.approx(80.0) and heavier.height == human.height
    np.testing.assert_allclose(heavier.model.body_pos, human.model.body_pos, atol=1e-12)


@pytest.mark.slow
def test_the_measured_walk_is_weighed(data):
    """The plates of a public walk carry what its scaled OpenSim model weighs: 85.3 kg."""
    from plantigrade.workflows.fit import fit_trial

    folder = data / "opensim" / "rajagopal_walk"
    text = (folder / "subject_walk_scaled.osim").read_text(encoding="utf-8")
    masses = [float(m) for m in re.findall(r"<mass>\s*([-+.\deE]+)\s*</mass>", text)]
    assert sum(masses) == pytest.approx(85.27, abs=0.01)
    trial = fit_trial(folder / "markers_walk.trc")[1]
    assert trial.fit.human.mass == pytest.approx(sum(masses), rel=0.01)
