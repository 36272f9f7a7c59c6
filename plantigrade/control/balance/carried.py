"""A posture held on ground that moves."""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance.reference import Held, Reference, Wanted
from plantigrade.kinematics.state import PointSet, State, integrate
from plantigrade.world import World

PLATE = "platform"
"""Name of the body that moves."""
UPRIGHT, POSTURE = 0.3, 0.03
"""Weights of pelvis and joints, beside feet and centre of mass at 1."""


def held(world: World, qpos: Float[Array, " nq"]) -> Reference:
    """Return the reference of who holds a posture in a world."""
    if mujoco.mj_name2id(world.model, mujoco.mjtObj.mjOBJ_BODY, PLATE) < 0:
        return Held(world.human, np.array(qpos))
    return Carried(world, qpos)


class Carried:
    """A posture on a plate that moves: feet go with it, the body stays upright above them.

    Every tick a step of inverse kinematics leads the posture on.

    Args:
        world: The world with the plate.
        qpos: The posture, feet on the plate as it is now.
    """

    def __init__(self, world: World, qpos: Float[Array, " nq"]):
        human = world.human
        self._data, self._plate = world.data, world.model.body(PLATE).id
        self._start = self._body = body = State(human, qpos)
        self._names = sorted({s.body for s in contact_sites(human)})
        self._segments = [human.body(name) for name in self._names]
        self._points = PointSet(human, self._names, np.zeros((len(self._names), 3)))
        self._spheres = PointSet.of(human, contact_sites(human))
        self._everywhere = np.ones(len(self._spheres), dtype=bool)
        place, turn = self._pose()
        self._place = (body.origins[self._segments] - place) @ turn
        self._turn = turn.T @ body.rotations[self._segments]
        self._com = (body.com - place) @ turn * [1.0, 1.0, 0.0]
        self._high = body.com[2] - (place + turn @ self._com)[2]
        self._time, self._wanted = -1.0, self._of(body, np.zeros(human.model.nv))

    def at(self, time: float) -> Wanted:
        """Return the posture for where the plate is."""
        if time == self._time:
            return self._wanted
        before, since = self._wanted.qpos, time - self._time
        place, turn = self._pose()
        body, nv = self._body.moved_to(before), len(self._wanted.qvel)
        under = place + turn @ self._com
        com = np.array([*under[:2], under[2] + self._high])
        wanted = turn @ self._turn
        for _ in range(2):
            now = body.rotations[self._segments]
            turned = 0.5 * np.cross(now.swapaxes(1, 2), wanted.swapaxes(1, 2)).sum(axis=1)
            away = place + self._place @ turn.T - body.origins[self._segments]
            spins = [body.angular_jacobian(i) for i in self._segments]
            back = -body.difference(self._start.qpos)
            rows = [
                body.jacobian(self._points).reshape(-1, nv),
                np.vstack(spins),
                body.com_jacobian,
                np.diag(np.r_[[0.0] * 3, [UPRIGHT] * 3, [POSTURE] * (nv - 6)])[3:],
            ]
            values = [away.ravel(), turned.ravel(), com - body.com]
            values += [UPRIGHT * back[3:6], POSTURE * back[6:]]
            step = np.linalg.lstsq(np.vstack(rows), np.concatenate(values), rcond=None)[0]
            body = body.moved_to(integrate(body.model, body.qpos, step))
        speed = body.difference(before) / since if self._time >= 0 else np.zeros(nv)
        self._time, self._wanted = time, self._of(body.moved_to(body.qpos, speed), speed)
        return self._wanted

    def _of(self, body: State, speed: Float[Array, " nv"]) -> Wanted:
        """Return a posture as what is wanted."""
        return Wanted(
            np.array(body.qpos),
            speed,
            np.zeros(len(speed)),
            body.com,
            np.array(body.com_velocity),
            np.zeros(3),
            body.position(self._spheres),
            self._everywhere,
        )

    def _pose(self) -> tuple[Float[Array, " 3"], Float[Array, "3 3"]]:
        """Return where the plate is, and its axes."""
        turn = self._data.xmat[self._plate].reshape(3, 3)
        return self._data.xpos[self._plate].copy(), turn.copy()
