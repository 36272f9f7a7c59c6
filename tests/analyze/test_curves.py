"""Curves over the cycle: on the side's own cycles, in their units, NaN where nobody knows."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import gait_curves
from plantigrade.analyze.clinical import clinical_angles
from plantigrade.analyze.curves import coordinates_of, known
from plantigrade.spatial.conventions import about_vertical, turned
from tests.analyze.plated_walk import MASS, analyse, plated_walk, without_plates


@pytest.fixture(scope="module")
def trial():
    """The walk with plates, analysed without a filter."""
    return analyse(plated_walk().fit(), cutoff=None)


@pytest.fixture(scope="module")
def curves(trial):
    """Its curves."""
    return gait_curves(trial.record())


def test_each_side_has_a_row_for_each_of_its_cycles(curves):
    for side in "rl":
        n = sum(c.side == side for c in curves.cycles)
        assert n >= 1
        assert curves.angles[f"knee_angle_{side}"].shape == (n, len(curves.percent))
        assert curves.forces[f"up_{side}"].shape == (n, len(curves.percent))
    right = sum(c.side == "r" for c in curves.cycles)
    assert len(curves.angles["pelvis_list"]) == right


def test_ends_of_a_curve_are_the_angles_at_the_heel_strikes(trial, curves):
    motion = trial.motion
    knee = np.rad2deg(motion.qpos[:, 7 + trial.fit.human.hinge("knee_angle_l")])
    mine = [c for c in curves.cycles if c.side == "l"]
    for cycle, row in zip(mine, curves.angles["knee_angle_l"], strict=True):
        ends = np.interp([cycle.start, cycle.stop], motion.time, knee)
        np.testing.assert_allclose(row[[0, -1]], ends, atol=0.1)


@pytest.mark.parametrize("heading", [np.pi / 2, -2.8])
def test_the_pelvis_turns_with_the_way(trial, curves, heading):
    """Behind a bend it leans and turns as before it, against the direction of walking."""
    record = trial.record()
    qpos = record.motion.qpos.copy()
    qpos[:, :3] = qpos[:, :3] @ about_vertical(heading).T
    qpos[:, 3:7] = turned(qpos[:, 3:7], heading)
    bent = replace(record, motion=replace(record.motion, qpos=qpos))
    found, own = clinical_angles(bent), clinical_angles(record)
    for name in ("pelvis_tilt", "pelvis_list", "pelvis_rotation"):
        assert found[f"{name}_l"] == pytest.approx(own[f"{name}_l"], abs=2.5)
        assert gait_curves(bent).angles[name] == pytest.approx(curves.angles[name], abs=2.5)


def test_a_steady_walk_carries_its_weight(curves):
    """Over a stride the mean of both feet's vertical forces is body weight."""
    up = [np.nanmean(curves.forces[f"up_{s}"]) for s in "rl"]
    assert sum(up) == pytest.approx(1.0, abs=0.01)
    forward = [np.nanmean(curves.forces[f"forward_{s}"]) for s in "rl"]
    assert sum(forward) == pytest.approx(0.0, abs=0.01)


def test_moments_are_per_mass_and_power_is_moment_times_speed(trial, curves):
    motion, tau = trial.motion, trial.record().qfrc_actuator
    i = 6 + trial.fit.human.hinge("ankle_angle_r")
    cycle = next(c for c in curves.cycles if c.side == "r")
    inside = (motion.time >= cycle.start) & (motion.time <= cycle.stop)
    peak = tau[inside, i].min() / MASS
    assert curves.moments["ankle_angle_r"][0].min() == pytest.approx(peak, rel=0.02)
    power = (tau[inside, i] * motion.qvel[inside, i]).max() / MASS
    assert curves.powers["ankle_angle_r"][0].max() == pytest.approx(power, rel=0.03)


def test_unknown_forces_are_nan_and_so_are_the_moments_above_them(trial, curves):
    """A foot that stood beside its plate has a force, but not this one."""
    record = trial.record()
    right = [k for k, s in enumerate(record.sites) if s.side == "r"]
    table = record.contact_known.copy()
    cycle = next(c for c in curves.cycles if c.side == "r")
    at = cycle.start + 0.2 * cycle.duration
    beside = np.abs(record.motion.time - at) < 0.05 * cycle.duration
    table[np.ix_(beside, right)] = False
    hidden = gait_curves(replace(record, contact_known=table))
    dark = np.abs(hidden.percent - 20) < 3
    for name in ("hip_flexion_r", "ankle_angle_r"):
        assert np.isnan(hidden.moments[name][0, dark]).all(), name
        assert np.isnan(hidden.powers[name][0, dark]).all(), name
    assert np.isnan(hidden.forces["up_r"][0, dark]).all()
    bright = np.abs(hidden.percent - 60) < 3
    np.testing.assert_array_equal(
        hidden.moments["hip_flexion_r"][0, bright], curves.moments["hip_flexion_r"][0, bright]
    )
    # The other leg hangs on its own foot, arms and trunk on none; angles are seen, not measured.
    for name in ("hip_flexion_l", "arm_flex_r", "lumbar_extension"):
        np.testing.assert_array_equal(hidden.moments[name], curves.moments[name], err_msg=name)
    np.testing.assert_array_equal(hidden.angles["knee_angle_r"], curves.angles["knee_angle_r"])


def test_a_cycle_of_which_little_is_known_is_left_out(trial, curves):
    record = trial.record()
    table = record.contact_known.copy()
    cycle = next(c for c in curves.cycles if c.side == "r")
    inside = (record.motion.time >= cycle.start) & (record.motion.time < cycle.stop - 0.02)
    right = [k for k, s in enumerate(record.sites) if s.side == "r"]
    table[np.ix_(inside, right)] = False
    hidden = gait_curves(replace(record, contact_known=table))
    assert len(hidden.moments["knee_angle_r"]) == len(curves.moments["knee_angle_r"]) - 1


def test_without_forces_there_are_angles_alone():
    bare = analyse(without_plates(plated_walk().fit()), cutoff=None)
    curves = gait_curves(bare.record())
    assert len(curves.angles["knee_angle_r"]) and not curves.moments and not curves.forces


def test_without_cycles_every_curve_is_empty(trial):
    motion = replace(trial.motion, events=())
    curves = gait_curves(replace(trial.record(), motion=motion))
    assert curves.cycles == ()
    assert all(len(rows) == 0 for rows in curves.angles.values())


def test_coordinates_are_the_humans(trial):
    names, values = trial.fit.human.to_coordinates(trial.motion.qpos)
    table = coordinates_of(trial.record())
    assert table.names == names
    np.testing.assert_allclose(table.values, values, atol=1e-12)


def test_the_midline_needs_the_forces_of_both_feet(trial):
    table = trial.record().contact_known.copy()
    left = [k for k, s in enumerate(trial.record().sites) if s.side == "l"]
    table[5, left] = False
    record = replace(trial.record(), contact_known=table)
    assert np.isnan(known(record, None)[5]) and np.isnan(known(record, "l")[5])
    assert known(record, "r")[5] == 1
