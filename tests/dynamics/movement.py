"""Movements whose derivatives are known in closed form, and wrenches on feet."""

import numpy as np

from plantigrade.dynamics.plates import FootForces
from plantigrade.models import Human


def movement(human: Human, n: int = 201, dt: float = 0.005, seed: int = 0, turn: float = 0.6):
    """Return time, qpos, qvel, qacc of sines in every coordinate and a tumbling pelvis.

    The pelvis turns about a fixed tilted axis by an angle that is itself a sine, so that its
    angular velocity and acceleration are that axis times the angle's derivatives.
    """
    rng = np.random.default_rng(seed)
    model = human.model
    t = np.arange(n) * dt

    def sines(size, count):
        amplitude = size * rng.uniform(0.3, 1.0, count)
        w = 2 * np.pi * rng.uniform(0.4, 1.2, count)
        phase = rng.uniform(0, 2 * np.pi, count)
        angle = t[:, None] * w + phase
        return (
            amplitude * np.sin(angle),
            amplitude * w * np.cos(angle),
            -amplitude * w**2 * np.sin(angle),
        )

    qpos = np.tile(human.standing(), (n, 1))
    qvel, qacc = np.zeros((n, model.nv)), np.zeros((n, model.nv))
    x, v, a = sines(0.2, 3)
    qpos[:, :3] += x
    qvel[:, :3], qacc[:, :3] = v, a
    x, v, a = sines(turn, 1)
    axis = np.array([0.6, -0.48, 0.64])
    qpos[:, 3] = np.cos(x[:, 0] / 2)
    qpos[:, 4:7] = np.sin(x / 2) * axis
    qvel[:, 3:6], qacc[:, 3:6] = v * axis, a * axis
    x, v, a = sines(0.4, model.nv - 6)
    qpos[:, 7:] += x
    qvel[:, 6:], qacc[:, 6:] = v, a
    return t, qpos, qvel, qacc


def feet_forces(force, point, torque) -> FootForces:
    """Return forces given as arrays (n, 2, 3) as if two plates had measured them throughout."""
    n = len(force)
    return FootForces(
        np.asarray(force, float),
        np.asarray(point, float),
        np.asarray(torque, float),
        np.ones((n, 2), bool),
        np.ones(n, bool),
    )
