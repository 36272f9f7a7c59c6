"""Work of muscles: what tissue bears is not theirs."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.gait_shape import muscle_work
from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record


def test_muscles_do_no_work_if_tissue_provides_all_torques():
    human = Human.create(joints="43")
    rng = np.random.default_rng(0)
    time = np.linspace(0.0, 1.0, 50)
    names = human.coordinates
    q = 0.1 * np.sin(2 * np.pi * time[:, None] + rng.uniform(size=len(names)))
    v = np.gradient(q, time, axis=0)
    qpos = np.hstack([np.tile(human.standing()[:7], (50, 1)), q])
    motion = Motion(time, qpos, np.hstack([np.zeros((50, 6)), v]), human.joint_names)
    factor = scale(human.mass, human.height)
    tissue = np.stack(passive_moments(names, list(q.T), list(v.T), factor), axis=1)
    torque = np.hstack([np.zeros((50, 6)), tissue])
    record = Record(human, motion, qfrc_actuator=torque)
    assert muscle_work(record) == pytest.approx((0.0, 0.0), abs=1e-9)
    torque = torque.copy()
    torque[:, 6] += np.sign(v[:, 0])  # 1 N m that always pushes: work is the way it pushes along
    done, _ = muscle_work(replace(record, qfrc_actuator=torque))
    assert done == pytest.approx(np.trapezoid(np.abs(v[:, 0]), time))
    with pytest.raises(ParameterError, match="no joint torques"):
        muscle_work(replace(record, qfrc_actuator=None))
