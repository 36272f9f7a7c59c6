"""Ground reactions without plates: statics, equilibrium, symmetry, what was put in comes out."""

import numpy as np
import pytest

from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.load_intervals import LoadInterval, Support
from plantigrade.dynamics.plates import FootForces
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion

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


def test_each_foot_carries_half_of_a_person_who_stands(human):
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
    always = [LoadInterval(s, float(first), float(last), False, False, False) for s in "rl"]
    seat = Support("seat", "pelvis", (-0.05, 0.0, -0.1))
    contacts = (*always, LoadInterval("seat", float(first), float(last), False, False, False))
    n, weight = motion.n_frames, human.mass * G
    feet = estimate_forces(human, motion).forces
    light = FootForces(
        0.3 * feet.force, feet.point, feet.torque, np.ones((n, 2), bool), np.ones(n, bool)
    )
    found = estimate_forces(human, motion, measured=light, contacts=contacts, supports=(seat,))
    np.testing.assert_allclose(found.support_force[:, 0, 2] / weight, 0.7, atol=5e-3)
