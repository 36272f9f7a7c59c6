"""Resampling of motions and signals at other times."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.motion import Motion


def resampled(motion: Motion, time: Float[Array, " n"]) -> Motion:
    """Return a motion at other times [s], interpolated, and constant beyond its ends."""
    if np.array_equal(motion.time, time):
        return motion
    qpos = motion.qpos.copy()
    turned = np.sum(qpos[1:, 3:7] * qpos[:-1, 3:7], axis=1) < 0  # equal rotation with opposite sign
    qpos[1:, 3:7] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
    here, speed = (interpolate(time, motion.time, values) for values in (qpos, motion.qvel))
    here[:, 3:7] /= np.linalg.norm(here[:, 3:7], axis=1, keepdims=True)
    return Motion(time, here, speed, motion.joint_names, events=motion.events)


def interpolate(
    time: Float[Array, " n"], clock: Float[Array, " m"], values: Float[Array, " m *channels"]
) -> Float[Array, " n *channels"]:
    """Return a signal at other times [s], linearly interpolated, and constant beyond its ends."""
    columns = values.reshape(len(values), -1).T
    found = np.stack([np.interp(time, clock, column) for column in columns], axis=1)
    return found.reshape(len(time), *values.shape[1:])
