"""Torques of joints: Eqs. 1 and 2, where they hold, and what replaces them."""

import numpy as np
import pytest

from plantigrade.vaulting import Table
from plantigrade.vaulting.strength import (
    BELLS,
    GAMMA,
    LENGTHENING,
    OMEGA_0,
    OPENS,
    STOPS,
    stops,
    strengths,
    torques,
    use,
    velocity_factor,
)


@pytest.mark.parametrize("omega", [0.0, 3.0, 12.0, 20.0])
def test_the_velocity_factor_of_shortening_is_the_reports(omega):
    expected = (OMEGA_0 - omega) / (OMEGA_0 + GAMMA * omega)
    assert velocity_factor(np.array(omega / OMEGA_0)) == pytest.approx(expected)


def test_the_velocity_factor_of_lengthening_has_no_pole():
    ratio = np.linspace(-2.0, 2.0, 4001)
    h = velocity_factor(ratio)
    assert np.all(np.diff(h) <= 1e-12) and h.max() < LENGTHENING and h.min() == 0.0
    slope = np.diff(h) / np.diff(ratio)
    assert slope[1999] == pytest.approx(slope[2000], rel=0.02)  # smooth at rest


def test_full_effort_at_the_best_angle_is_the_strength_of_both_limbs(segments):
    strength = strengths(segments.human)
    for k, effort in enumerate((1.0, -1.0)):
        angle = [bells[k][0] for bells in BELLS]
        torque = np.array(torques(strength, angle, np.zeros(5), np.full(5, effort)))
        assert torque * OPENS * effort == pytest.approx(strength[:, k])
    low, high = segments.human.model.jnt_actfrcrange[1 + segments.human.hinge("knee_angle_r")]
    assert strength[3].tolist() == [-2 * low, 2 * high]  # the knee extends in its negative sense
    nothing = torques(strength, np.ones(5), np.ones(5), np.zeros(5))
    assert not np.any(nothing)


def test_stops_push_back_and_only_beyond_the_range(segments):
    strength = strengths(segments.human)
    inside = [0.5 * (s.low + s.high) for s in STOPS]
    assert not np.any(stops(strength, inside, np.full(5, 9.0)))
    for sign in (1.0, -1.0):
        beyond = [(s.high if sign > 0 else s.low) + 0.05 * sign for s in STOPS]
        rest = np.array(stops(strength, beyond, np.zeros(5)))
        moving = np.array(stops(strength, beyond, np.full(5, sign)))
        assert np.all(rest * sign < 0) and np.all(np.abs(moving) > np.abs(rest))
        assert not np.any(np.array(stops(strength, beyond, np.full(5, -99.0 * sign))) * sign > 0)


def test_the_use_of_strength_is_one_at_the_limit(segments):
    strength = strengths(segments.human)
    torque = np.zeros(5)
    assert use(strength, torque) == 0.0
    torque[2] = -LENGTHENING * strength[2, 0]  # the hip extends in its negative sense
    assert use(strength, torque) == pytest.approx(1.0)


def test_the_table_pushes_by_the_reports_equation_and_never_pulls():
    table = Table(stiffness=100.0, damping=5.0, shear_stiffness=10.0, shear_damping=0.0, grip=5.0)
    _, up = table.force(0.0, -0.05, 0.0, -2.0, np)
    assert up == pytest.approx(1e3 * (100.0 * 0.05**2 + 5.0 * 0.05 * 2.0))
    assert table.force(0.1, 0.01, 0.0, -3.0, np) == (0.0, 0.0)  # in the air
    assert table.force(0.0, -0.05, 0.0, 9.0, np)[1] == 0.0  # leaving fast
    back, up = table.force(0.02, -0.05, 0.0, 0.0, np)
    assert back == pytest.approx(-1e4 * 0.02**2, rel=1e-3)
    slipping, up = Table(grip=0.5).force(0.5, -0.05, 0.0, 0.0, np)
    assert slipping == pytest.approx(-0.5 * up)
