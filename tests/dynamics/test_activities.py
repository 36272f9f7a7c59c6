"""Forces of what is no walk: what was put in comes out, and a seat is part of the equilibrium."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.analyze.estimated_forces import estimate_figures, support_forces
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.dynamics.force_bands import BandFactors
from plantigrade.dynamics.ground_forces import ForceScales, estimate_forces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.loading import RUNNING_FREQUENCY_RATIO
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, pelvis_angles_to_quaternion
from plantigrade.trajopt.tasks.chair import seated_posture
from plantigrade.workflows.fit import fit_trial, run_of
from plantigrade.workflows.settings import FitSettings

TIME = np.arange(24) / 50.0


@pytest.fixture(scope="module")
def human() -> Human:
    return Human.create(height=1.75, mass=70.0)


def at_rest(human: Human, qpos: np.ndarray) -> Motion:
    still = np.zeros((len(TIME), human.model.nv))
    return Motion(TIME, np.tile(qpos, (len(TIME), 1)), still, human.joint_names, still)


@pytest.fixture(scope="module")
def sitting(human):
    q = seated_posture(human, 0.45)
    quat = pelvis_angles_to_quaternion(q[None, :3])[0]
    motion = at_rest(human, np.concatenate([OPENSIM_TO_WORLD @ q[3:6], quat, q[6:]]))
    return motion, estimate_forces(human, motion)


def test_seat_and_feet_carry_a_sitting_person(human, sitting):
    motion, found = sitting
    assert [(s.name, s.body) for s in found.supports] == [("seat", "pelvis")]
    weight = human.mass * GRAVITY
    seat, feet = found.support_force[:, 0], found.forces.force.sum(axis=1)
    np.testing.assert_allclose((seat + feet) / weight, np.tile([0.0, 0.0, 1.0], (24, 1)), atol=0.01)
    assert (seat[:, 2] > 0.7 * weight).all()
    assert (feet[:, 2] > 0.02 * weight).all()
    tau = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, found.forces).tau
    push = support_forces(human, motion, found)
    assert (tau[:, 2] > 0.7 * weight).all()
    assert np.abs((tau - push)[:, :3]).max() < 0.02 * weight
    np.testing.assert_array_equal(push[:, 6:], 0.0)  # on the pelvis: no joint feels it
    peak = estimate_figures(human, found)["estimate_seat_force_peak_n"]
    assert peak == seat[:, 2].max()


def test_standing_feet_press_as_little_against_each_other_as_joints_can_do_with(human):
    """The motion does not tell it: without the least of activations nothing would."""
    qpos = human.standing()
    for side in SIDES:
        qpos[7 + human.hinge(f"hip_adduction_{side}")] -= 0.2
        qpos[7 + human.hinge(f"subtalar_angle_{side}")] += 0.2
    qpos[2] -= lowest(human, qpos[None])[0]
    found = estimate_forces(human, at_rest(human, qpos)).forces
    right, left = found.force[12] / (human.mass * GRAVITY)
    # legs apart: each force passes inward, near the hip
    hip = human.model.body_pos[human.body("femur_l")][1]
    out = found.point[12, 1, 1] - hip
    assert out > 0.05
    height = qpos[2] + human.model.body_pos[human.body("femur_l")][2]
    np.testing.assert_allclose(left[1], -0.5 * out / height, atol=0.025)
    np.testing.assert_allclose(right, left * [1.0, -1.0, 1.0], atol=1e-3)
    assert left[1] < -0.02


def aloft(human: Human) -> Motion:
    """Return a fall from 3 m that ends before the ground."""
    motion = at_rest(human, human.standing())
    qpos, qvel, qacc = motion.qpos.copy(), motion.qvel.copy(), motion.qvel.copy()
    qpos[:, 2] += 3.0 - 0.5 * GRAVITY * TIME**2
    qvel[:, 2], qacc[:, 2] = -GRAVITY * TIME, -GRAVITY
    return Motion(TIME, qpos, qvel, human.joint_names, qacc)


def test_what_never_touches_the_ground_is_refused_and_known_contacts_are_not(human):
    with pytest.raises(ParameterError, match="no foot touches the ground"):
        estimate_forces(human, aloft(human))
    late = (ContactInterval("r", "foot", TIME[-1] + 1.0, TIME[-1] + 2.0),)  # in no frame
    assert (estimate_forces(human, aloft(human), contacts=late).forces.force == 0.0).all()


def test_scales_follow_what_is_done():
    walk, stand = ForceScales.of(walks=True), ForceScales.of(walks=False)
    run = ForceScales.of(walks=False, pace=RUNNING_FREQUENCY_RATIO)
    assert walk == ForceScales()
    assert np.isinf(walk.effort)
    assert stand.effort == run.effort == 1.0
    assert run.bend[2] / walk.bend[2] == pytest.approx((run.rate / walk.rate) ** 2)


def test_a_jump_keeps_higher_frequencies_and_flies_without_force(data):
    trial = fit_trial(data / "deepmimic" / "humanoid3d_jump.txt")[1]
    assert trial.cutoff == 15.0
    assert trial.ground is not None
    assert trial.ground.flies
    force, time = trial.ground.forces.force[..., 2], trial.motion.time
    assert (force[(time > 0.86) & (time < 1.2)] == 0).all()
    assert force[time < 0.75].sum(axis=1).min() > 0


def test_bands_follow_what_is_done():
    """Pressure of a jump is less certain than of a walk; forces are at least half as uncertain."""
    walk, jump, squat = (
        BandFactors.of(walks=walks, flies=flies, sits=False)
        for walks, flies in ((True, False), (False, True), (False, False))
    )
    chair = BandFactors.of(walks=False, flies=False, sits=True)
    for name, usual in vars(walk).items():
        assert getattr(jump, name) >= (usual if name.startswith("point") else 0.5 * usual)
        least = 0.5 if name in ("forward", "sideways", "vertical") else 0.4
        for slow in (squat, chair):
            assert least * usual <= getattr(slow, name) <= usual
    legs = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")
    np.testing.assert_array_equal(walk.moments(legs), [walk.hip, walk.knee, walk.other])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "mass"),
    [
        ("opencap_subject4/DJ1.trc", None),
        ("running_subject04/run300.trc", 80.47),
        ("opencap_subject4/STS1.trc", None),
    ],
)
def test_bands_hold_what_plates_measured(data, name, mass):
    """Also where the centre of pressure is at an edge of the sole, which draws do not move."""
    held = estimated(data / "opensim" / name, mass=mass)
    for what in ("vertical_force", "pressure_x", "ankle_angle_moment", "knee_angle_moment"):
        assert held[f"{what}_in_band_pct"] > 84.0, what


@pytest.mark.slow
def test_a_box_below_the_feet_brings_forces_and_moments_nearer(data):
    """The band of the centre of pressure is too narrow there: at push-off the soles are too low."""
    path = data / "opensim/opencap_subject4/DJ1.trc"
    level, box = (estimated(path, boxes=boxes) for boxes in (False, True))
    for what in ("ankle_angle_moment", "knee_angle_moment", "hip_flexion_moment"):
        assert box[f"{what}_rmse_nm_kg"] < 0.9 * level[f"{what}_rmse_nm_kg"]
        assert box[f"{what}_in_band_pct"] > 90.0
    assert box["pressure_x_rmse_mm"] < 0.8 * level["pressure_x_rmse_mm"]
    assert box["vertical_force_in_band_pct"] > 84.0 and box["pressure_x_in_band_pct"] > 75.0


def estimated(path: Path, mass: float | None = None, *, boxes: bool = False) -> Mapping[str, float]:
    """Return the figures of a fit whose plates are withheld, on level ground or on its box."""
    settings = FitSettings(without_plates=True, mass=mass)
    return run_of(*fit_trial(path, settings, boxes=boxes), settings).figures


def made(task: str) -> tuple[pg.Record, slice]:
    """Return a synthesised motion, and every fourth of its frames."""
    return pg.synthesize(task).record, slice(None, None, 4)


@pytest.mark.slow
def test_a_squat_gives_back_the_forces_it_was_made_with():
    record, some = made("squat")
    found = estimate_forces(record.human, record.motion.frames(some))
    for k, side in enumerate(SIDES):
        true = record.foot(side)
        off = (found.forces.force[:, k] - true.force[some]) / record.weight
        assert (np.sqrt(np.mean(off**2, axis=0)) < [0.005, 0.02, 0.005]).all()
        place = found.forces.point[:, k] - true.centre_of_pressure[some]
        assert (np.nanmedian(np.abs(place), axis=0)[:2] < [0.002, 0.008]).all()
    assert found.supports == ()


@pytest.mark.slow
def test_rising_from_a_chair_gives_back_what_seat_and_feet_carried():
    record, some = made("sit-to-stand")
    found = estimate_forces(record.human, record.motion.frames(some))
    seat = [i for i, site in enumerate(record.sites) if not site.side]
    assert record.contact_force is not None
    true = record.contact_force[some, seat, 2].sum(axis=1)
    off = (found.support_force[:, 0, 2] - true) / record.weight
    assert np.sqrt(np.mean(off**2)) < 0.1
    late = record.motion.time[some] > 0.9
    for k, side in enumerate(SIDES):
        off = (found.forces.force[:, k] - record.foot(side).force[some])[late] / record.weight
        assert (np.sqrt(np.mean(off**2, axis=0)) < [0.005, 0.02, 0.015]).all()
