"""Joint torques: Eqs. 1 and 2 of the report and their replacement for lengthening muscles."""

import numpy as np
import pytest

from plantigrade.dynamics.muscle_speed import (
    GAMMA,
    MAX_ECCENTRIC_FACTOR,
    OMEGA_0,
    velocity_factor,
)
from plantigrade.vaulting import VaultingTable
from plantigrade.vaulting.joint_torques import (
    EXTENSION_SIGN,
    JOINT_STOPS,
    STRENGTH_BELLS,
    muscle_torques,
    relative_load,
    stop_torques,
    strengths,
)


@pytest.mark.parametrize("omega", [0.0, 3.0, 12.0, 20.0])
def test_the_velocity_factor_of_shortening_muscle_is_that_of_the_report(omega):
    expected = (OMEGA_0 - omega) / (OMEGA_0 + GAMMA * omega)
    assert velocity_factor(np.array(omega / OMEGA_0)) == pytest.approx(expected)


def test_the_velocity_factor_of_lengthening_has_no_pole():
    ratio = np.linspace(-2.0, 2.0, 4001)
    h = velocity_factor(ratio)
    assert np.all(np.diff(h) <= 1e-12) and h.max() < MAX_ECCENTRIC_FACTOR and h.min() == 0.0
    slope = np.diff(h) / np.diff(ratio)
    assert slope[1999] == pytest.approx(slope[2000], rel=0.02)  # smooth at rest


def test_full_effort_at_the_optimal_angle_is_the_strength_of_both_limbs(segments):
    strength = strengths(segments.human)
    for k, effort in enumerate((1.0, -1.0)):
        angle = [bells[k][0] for bells in STRENGTH_BELLS]
        torque = np.array(muscle_torques(strength, angle, np.zeros(5), np.full(5, effort)))
        assert torque * EXTENSION_SIGN * effort == pytest.approx(strength[:, k])
    low, high = segments.human.model.jnt_actfrcrange[1 + segments.human.hinge("knee_angle_r")]
    assert strength[3].tolist() == [-2 * low, 2 * high]  # the knee extends in its negative sense
    nothing = muscle_torques(strength, np.ones(5), np.ones(5), np.zeros(5))
    assert not np.any(nothing)


def test_stops_act_only_beyond_the_range(segments):
    strength = strengths(segments.human)
    inside = [0.5 * (s.low + s.high) for s in JOINT_STOPS]
    assert not np.any(stop_torques(strength, inside, np.full(5, 9.0)))
    for sign in (1.0, -1.0):
        beyond = [(s.high if sign > 0 else s.low) + 0.05 * sign for s in JOINT_STOPS]
        rest = np.array(stop_torques(strength, beyond, np.zeros(5)))
        moving = np.array(stop_torques(strength, beyond, np.full(5, sign)))
        assert np.all(rest * sign < 0) and np.all(np.abs(moving) > np.abs(rest))
        assert not np.any(
            np.array(stop_torques(strength, beyond, np.full(5, -99.0 * sign))) * sign > 0
        )


def test_the_relative_load_is_one_at_the_eccentric_limit(segments):
    strength = strengths(segments.human)
    torque = np.zeros(5)
    assert relative_load(strength, torque) == 0.0
    torque[2] = -MAX_ECCENTRIC_FACTOR * strength[2, 0]  # the hip extends in its negative sense
    assert relative_load(strength, torque) == pytest.approx(1.0)


def test_the_table_force_follows_the_equation_and_is_never_tensile():
    table = VaultingTable(
        stiffness=100.0, damping=5.0, shear_stiffness=10.0, shear_damping=0.0, grip=5.0
    )
    _, up = table.force(0.0, -0.05, 0.0, -2.0, np)
    assert up == pytest.approx(1e3 * (100.0 * 0.05**2 + 5.0 * 0.05 * 2.0))
    assert table.force(0.1, 0.01, 0.0, -3.0, np) == (0.0, 0.0)  # in the air
    assert table.force(0.0, -0.05, 0.0, 9.0, np)[1] == 0.0  # leaving fast
    back, up = table.force(0.02, -0.05, 0.0, 0.0, np)
    assert back == pytest.approx(-1e4 * 0.02**2, rel=1e-3)
    slipping, up = VaultingTable(grip=0.5).force(0.5, -0.05, 0.0, 0.0, np)
    assert slipping == pytest.approx(-0.5 * up)
