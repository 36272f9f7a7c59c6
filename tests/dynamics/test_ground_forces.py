"""Ground reactions without plates: statics, equilibrium, symmetry, what was put in comes out."""

import numpy as np
import pytest

from plantigrade.dynamics.ground_forces import estimate_forces
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
