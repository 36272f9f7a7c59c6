"""Forces that no plate measured: kept apart from measured ones, refused where they cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import Tolerances, compare_forces, estimated_forces, gait_curves
from plantigrade.analyze.check import check
from plantigrade.analyze.estimated_forces import estimate, residual_wrench
from plantigrade.analyze.norms_of_runs import person_curves
from plantigrade.contact.ground import Ground
from plantigrade.dynamics.inverse import inverse_dynamics
from tests.analyze.plated_walk import analyse, plated_walk, without_plates


@pytest.fixture(scope="module")
def plated():
    return analyse(plated_walk().fit())


@pytest.fixture(scope="module")
def withheld():
    return analyse(plated_walk().fit(), without_plates=True)


@pytest.fixture(scope="module")
def partly():
    """The same walk, the left plate missing."""
    fit = plated_walk().fit()
    right = fit.recording.plates[:1]
    return analyse(replace(fit, recording=replace(fit.recording, plates=right)))


def test_withheld_plates_are_compared_and_enter_nothing(plated, withheld):
    """All that is estimated is as if there had never been plates."""
    bare = analyse(without_plates(plated_walk().fit()))  # equal trials give equal forces, too
    assert withheld.forces is None and withheld.weighed is None
    assert withheld.motion.events == bare.motion.events
    record = withheld.record()
    np.testing.assert_array_equal(record.contact_force, bare.record().contact_force)
    np.testing.assert_array_equal(record.qfrc_actuator, bare.record().qfrc_actuator)
    assert bare.measured is None and any("withheld" in note for note in withheld.notes)
    for side in "rl":
        seen, full = withheld.measured.foot(side), plated.measured.foot(side)
        np.testing.assert_array_equal(seen.known, full.measured)
        np.testing.assert_allclose(seen.force[seen.known], full.force[full.measured], atol=1e-9)


def test_estimated_forces_count_nowhere_as_measured(withheld):
    record = withheld.record()
    curves, every = gait_curves(record), gait_curves(record, estimated=True)
    assert not curves.moments and not curves.forces and not curves.powers
    assert len(every.moments["knee_angle_r"]) and len(every.forces["up_l"])
    assert not any("moment" in n or "force" in n for n in person_curves(record)), "nobody's norm"
    figures = withheld.figures
    assert not any(n.startswith("residual") or "moment_peak" in n for n in figures)
    assert "com_ahead_mm" not in figures and figures["forces_estimated_pct"] == 100.0
    assert compare_forces(record, record).feet == (), "an estimate is no measure of another"


def test_a_foot_off_its_plate(plated, partly):
    """What the right plate tells is kept to the last digit; the left foot is estimated."""
    assert partly.forces is not None and partly.ground is not None
    record, is_measured = partly.record(), partly.ground.measured
    right, left = record.foot("r"), record.foot("l")
    assert right.known.all() and left.known.all(), "known at all, measured or not"
    assert left.measured.mean() < 0.6 < right.measured.mean() + 0.4
    sure = is_measured[:, 0] & plated.forces.valid_side[:, 0]
    np.testing.assert_array_equal(partly.ground.forces.force[sure, 0], plated.forces.force[sure, 0])
    np.testing.assert_allclose(
        partly.moments["knee_angle_r"][sure], plated.moments["knee_angle_r"][sure], atol=1e-9
    )
    frames = partly.figures["residual_frames"]
    assert frames == partly.forces.valid.sum() < record.motion.n_frames
    off = (left.force - plated.forces.force[:, 1])[:, 2] / record.weight
    assert 0 < np.sqrt(np.mean(off**2)) < 0.15


@pytest.mark.parametrize(
    ("lost", "change", "said"),
    [
        (0.6, {}, "the residual force is 0.35 body weights; another support"),
        (np.nan, {}, "another support"),
        (0.0, {"com_shift": np.array([0.2, 0.0, 0.0])}, "residual moment is"),
        (0.0, {"com_shift": np.array([0.0, 0.07, 0.0])}, "70 mm from that of the body"),
    ],
)
def test_what_feet_cannot_carry_is_refused(withheld, monkeypatch, lost, change, said):
    """A force that nothing gives, through the centre of mass; a shift that no body has."""
    found = replace(withheld.ground, **change)
    monkeypatch.setattr(estimated_forces, "estimate_forces", lambda *_, **__: found)
    if lost:
        weight = withheld.record().weight

        def pushed(*motion):
            moments = inverse_dynamics(*motion)
            tau = np.zeros_like(moments.tau)
            tau[:, 0] = lost * weight
            return replace(moments, tau=tau)

        monkeypatch.setattr(estimated_forces, "inverse_dynamics", pushed)
    ground, moments, notes = estimate(withheld.fit.human, withheld.motion, None, withheld.soles)
    assert ground is None and moments is None and said in notes[0]


def test_what_is_left_over_is_what_nothing_gives(withheld):
    """An estimate without one foot leaves over what that foot gives."""
    human, motion, ground = withheld.fit.human, withheld.motion, withheld.ground
    force = ground.forces.force.copy()
    force[:, 0] = 0.0
    less = replace(ground, forces=replace(ground.forces, force=force))
    moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, less.forces)
    lost = np.sqrt(np.mean(ground.forces.force[:, 0] ** 2))
    weight = withheld.record().weight
    assert residual_wrench(human, motion, less, moments)[0] == pytest.approx(lost / weight, abs=0.1)
    assert withheld.figures["estimate_residual_force_rms_bw"] < 0.15 < lost / weight


@pytest.mark.parametrize(
    ("noise", "half", "said"),
    [(1.2, 0.2, ""), (3.1, 0.3, "3.1 times as"), (1.0, 0.7, "±0.70")],
)
def test_where_the_knee_is_not_to_be_trusted(withheld, monkeypatch, noise, half, said):
    band = np.full_like(withheld.ground.moment_band, half * withheld.fit.human.mass)
    found = replace(withheld.ground, noise=noise, moment_band=band)
    monkeypatch.setattr(estimated_forces, "estimate_forces", lambda *_, **__: found)
    ground, _, notes = estimate(withheld.fit.human, withheld.motion, None, withheld.soles)
    assert ground is found and said in " ".join(notes) and bool(said) == bool(notes)
    assert not notes or "do not trust" in notes[0]


def test_where_feet_stand_on_other_ground_the_option_is_named(withheld):
    """The second stance of a foot is 17 cm above the first; all rise, or not as is said."""
    fit, soles = withheld.fit, withheld.soles.copy()
    slope = Ground(slope=np.deg2rad(7.0))
    qpos = withheld.motion.qpos.copy()
    qpos[:, 2] += np.tan(slope.slope) * qpos[:, 0]
    motion = replace(withheld.motion, qpos=qpos)
    soles[len(soles) // 2 :] += 0.17
    ground, _, notes = estimate(fit.human, motion, None, soles)
    assert (
        ground is None and "the ground is not level: stances of a foot differ by 17 cm" in notes[0]
    )
    assert "fit the markers with --ground slope:7" in notes[0]
    ground, _, notes = estimate(fit.human, motion, None, soles, Ground(slope=0.3))
    assert ground is None and "do not match the given ground" in notes[0]
    ground, _, notes = estimate(fit.human, motion, None, withheld.soles, slope)
    assert not any("given ground" in note for note in notes)


def test_the_checker_lets_forces_of_a_recording_leave_over_what_is_noise(partly):
    """Not to the last newton, as of a motion that its forces made; but no leg may be missing."""
    record = partly.record()
    root = ("root_force", "root_force_rms", "root_moment", "root_moment_rms", "momentum")
    verdict = check(record)
    strict = check(record, Tolerances())
    assert verdict.measures["root_force_rms"].limit == 5.0
    assert {f.quantity for f in strict.findings} & set(root)
    light = replace(record, contact_force=0.7 * record.contact_force)
    found = [f for f in check(light).findings if f.quantity in root]
    assert found and "estimated forces" in found[0].sentence()
