"""Estimated forces compared with measured ones: stance only, foot by foot."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import compare_forces
from plantigrade.analyze.gait_forces import STANCE_LOAD, measured_signals
from plantigrade.constants import SIDES
from tests.pages.walker import walk, walker


@pytest.fixture(scope="module")
def measured():
    """A walk over plates: sites 0 and 1 are the right and left foot."""
    return walk(walker(), duration=2.4, rate=50.0)


def off(record, **arrays):
    """Return the record with other forces or moments."""
    return replace(record, references={}, **arrays)


def stance(record, side):
    return record.foot(side).force[:, 2] > STANCE_LOAD * record.weight


def test_the_same_forces_agree(measured):
    c = compare_forces(measured, measured)
    assert c.sides == SIDES
    assert (c.vertical_r, c.forward_r, c.sideways_r) == pytest.approx((1, 1, 1))
    assert max(c.vertical_rmse, c.forward_rmse, *c.pressure_median_m) < 1e-12
    assert c.covered == {} and c.moment_r["knee_angle"] == pytest.approx(1)


def test_only_stance_counts(measured):
    """A method that knows stance from swing and nothing more has no correlation to show."""
    force = np.zeros_like(measured.contact_force)
    for k, side in enumerate(SIDES):
        standing = stance(measured, side)
        force[standing, k, 2] = measured.foot(side).force[standing, 2].mean()
    c = compare_forces(off(measured, contact_force=force), measured)
    assert not c.vertical_r > 0.1, "constant in stance: no correlation, or none to tell"
    for foot, side in zip(c.feet, SIDES, strict=True):
        np.testing.assert_array_equal(foot.stance, stance(measured, side))
        spread = np.std(foot.measured[foot.stance, 2])
        assert foot.force_rmse[2] == pytest.approx(spread, rel=1e-6)


def test_figures_are_means_over_feet(measured):
    """An error of one foot counts half, however long the other was on a plate."""
    force = measured.contact_force.copy()
    force[:, 0, 0] += 0.04 * measured.weight
    known = np.ones((measured.motion.n_frames, 2), bool)
    known[len(known) // 3 :, 0] = False
    short = replace(measured, contact_known=known)
    c = compare_forces(off(measured, contact_force=force), short)
    assert c.forward_rmse == pytest.approx(0.02)
    assert c.feet[0].stance.sum() < c.feet[1].stance.sum()


def test_what_was_estimated_is_not_compared_with(measured):
    is_measured = np.ones((measured.motion.n_frames, 2), bool)
    is_measured[:, 1] = False
    nv = measured.human.model.nv
    n = measured.motion.n_frames
    signals = {
        "forces.measured": is_measured,
        "forces.band": np.ones((n, 2, 3)),
        "forces.point_band": np.ones((n, 2, 2)),
        "forces.torque_band": np.ones((n, 2)),
        "forces.moment_band": np.ones((n, nv)),
    }
    partly = replace(measured, signals=signals)
    assert partly.foot("l").known.all() and not partly.foot("l").measured.any()
    assert compare_forces(off(measured), partly).sides == ("r",)
    seen = measured_signals(off(measured), partly)["measured.force"]
    assert np.isfinite(seen[:, 0]).all() and np.isnan(seen[:, 1]).all()


def test_a_centre_of_pressure_that_runs_back(measured):
    """It goes 5 mm back and forth again in every frame of the right foot's stance."""
    point = measured.contact_point.copy()
    point[::2, 0, 0] -= 0.2
    c = compare_forces(off(measured, contact_point=point), measured)
    right, left = c.feet
    frames = right.stance.sum() / 3  # of each of its stances, about
    assert right.backward_m > 0.05 * frames and left.backward_m == left.backward_measured_m
    assert c.pressure_rmse_m[0] == pytest.approx(0.5 * right.pressure_rmse_m[0])


def test_bands_cover_what_lies_in_them(measured):
    """Forces 10 N off everywhere: a band of 11 N covers them, one of 9 N does not."""
    n, nv = measured.motion.n_frames, measured.human.model.nv
    band = np.full((n, 2, 3), 11.0)
    band[:, :, 1] = 9.0
    signals = {
        "forces.measured": np.zeros((n, 2), bool),
        "forces.band": band,
        "forces.point_band": np.full((n, 2, 2), 1e-3),
        "forces.torque_band": np.full((n, 2), 1e-3),
        "forces.moment_band": np.full((n, nv), 1e-3),
    }
    force = measured.contact_force + 10.0
    c = compare_forces(replace(off(measured, contact_force=force), signals=signals), measured)
    assert c.covered["forward_force"] == c.covered["vertical_force"] == 1.0
    assert c.covered["sideways_force"] == 0.0 and c.covered["pressure_x"] == 1.0
    assert c.metrics()["knee_angle_moment_in_band_pct"] == 100.0
