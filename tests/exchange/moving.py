"""Runs in which everything moves."""

import numpy as np

from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run


def moving(human: Human, n: int = 6) -> Run:
    """Return a run of a person in which every joint moves, within its limits."""
    rng = np.random.default_rng(1)
    low, high = human.limits
    pose = rng.uniform(0.4 * low, 0.4 * high, (2, len(low)))
    share = np.linspace(0, 1, n)[:, None]
    qpos = np.tile(human.standing(), (n, 1))
    qpos[:, 7:] = (1 - share) * pose[0] + share * pose[1]
    qpos[:, :3] += np.linspace([0, 0, 0], [0.4, 0.1, 0.05], n)
    quat = np.array([1.0, 0.1, -0.2, 0.3]) + share * np.array([0.0, 0.2, 0.1, -0.5])
    qpos[:, 3:7] = quat / np.linalg.norm(quat, axis=1, keepdims=True)
    motion = Motion(np.arange(n) / 50, qpos, np.zeros((n, human.model.nv)), human.joint_names)
    return Run(Record(human, motion), "fit")
