"""MuJoCo's memory, shared by the states of one person, and results that are computed once."""

from functools import wraps
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float


class MujocoMemory:
    """MuJoCo's memory, shared by all states that come from one another."""

    def __init__(self, model: mujoco.MjModel):
        self.model, self.data = model, mujoco.MjData(model)
        self.holds: object = None  # which state the data belongs to
        self.velocities = False  # whether they have been evaluated too
        self.mass, self.gravity = float(model.body_mass.sum()), model.opt.gravity.copy()

    def at(self, state: Any, *, velocities: bool) -> mujoco.MjData:
        """Return the data evaluated at a state."""
        model, data = self.model, self.data
        if self.holds is not state._known:
            data.qpos[:], data.qvel[:] = state.qpos, state.qvel
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            self.holds, self.velocities = state._known, False
        if velocities and not self.velocities:
            mujoco.mj_comVel(model, data)
            self.velocities = True
        return data


def moved_by(model: mujoco.MjModel) -> Float[Array, "n_bodies nv"]:
    """Return which velocities move a body: 1, others 0."""
    above = np.zeros((model.nbody, model.nv))
    for body in range(1, model.nbody):
        above[body] = above[model.body_parentid[body]]
        start = model.body_dofadr[body]
        above[body, start : start + model.body_dofnum[body]] = 1.0
    return above


def once(compute):
    """Remember what a method of a state found for a set of points; of few points, all there is."""
    name = compute.__name__

    @wraps(compute)
    def remembered(state, points):
        found = state._known.get(id(points))
        if found is None:  # the points are kept, so that no others get their id
            found = state._few(points) if points.few else {}
            state._known[id(points)] = found
            found["points"] = points
        if name not in found:
            found[name] = read_only(compute(state, points))
        return found[name]

    return remembered


def read_only(array: Array) -> Array:
    """Return a read-only array."""
    array.flags.writeable = False
    return array
