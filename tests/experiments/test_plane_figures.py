"""Figures of all planes of a walk that was solved, and what is known of them beforehand."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.plane_figures import load_figures, plane_figures, published
from plantigrade.analyze import gait_curves
from plantigrade.errors import ParameterError
from tests.trajopt.coarse_walk import SPEED, person, solved

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def record():
    return solved().record(samples_per_interval=4, strides=1)


@pytest.fixture(scope="module")
def figures(record):
    return plane_figures(record)


def test_trunk_and_head_are_upright_and_arms_swing_against_the_legs(figures):
    assert figures["trunk_lean_deg"] < 3.0
    assert figures["head_lean_deg"] < 2.0
    assert figures["friction_used"] < 0.36
    usual = published(person(), SPEED)
    for name in ("arm_swing_deg", "arm_phase_deg"):
        low, high = usual[name]
        assert low < figures[name] < high
    assert 90.0 < figures["pelvis_trunk_phase_deg"] < 270.0


def test_the_feet_point_out_as_planned(figures):
    assert figures["foot_progression_out_deg"] == pytest.approx(5.0, abs=4.0)


def test_a_lean_that_is_added_is_found(record, figures):
    """A trunk that leans by 5° more over one leg, and back over the other."""
    motion = record.motion
    qpos = motion.qpos.copy()
    wave = np.deg2rad(5.0) * np.sin(2 * np.pi * motion.time / motion.time[-1])
    qpos[:, 7 + record.human.hinge("lumbar_bending")] += wave
    leaning = plane_figures(replace(record, motion=replace(motion, qpos=qpos)))
    assert leaning["trunk_lean_deg"] - figures["trunk_lean_deg"] > 2.0


def test_loads_are_of_human_size(record):
    found = load_figures(gait_curves(record))
    assert 1.0 < found["ankle_plantarflexor_nm_kg"] < 2.0
    assert found["hip_extensor_early_nm_kg"] > found["hip_extensor_late_swing_nm_kg"] > 0.0
    assert found["hip_abductor_nm_kg"] > 0.4
    assert found["ground_force_pushing_bw"] == pytest.approx(
        found["ground_force_braking_bw"], rel=0.5
    )


def test_centre_of_mass_of_people_moves_more_up_and_less_sideways_the_faster_they_walk():
    slow, fast = (published(person(), v) for v in (0.7, 1.6))
    assert slow["com_up_down_mm"][0] < fast["com_up_down_mm"][0]
    assert slow["com_sideways_mm"][1] > fast["com_sideways_mm"][1]


def test_a_motion_without_a_stride_has_none(record):
    still = replace(record, motion=replace(record.motion, events=()))
    with pytest.raises(ParameterError, match="complete stride"):
        plane_figures(still)
