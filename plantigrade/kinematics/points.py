"""Points fixed to bodies: where they are and how they move with the configuration."""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human


class Points:
    """Evaluates points fixed to the bodies of one Human at configurations.

    Having called :meth:`at` *is* having run forward kinematics: positions and Jacobians belong
    to the configuration given last, which is returned by value and cannot go stale unseen.

    Args:
        human: The person.
        bodies: Body name of each point.
        local: Position of each point in its body's frame [m].
    """

    def __init__(self, human: Human, bodies: list[str], local: Float[Array, "n_points 3"]):
        self.model = human.model
        self.human = human
        self._data = mujoco.MjData(self.model)
        self.body = np.array([human.body(b) for b in bodies], dtype=int)
        self.local = np.array(local, dtype=float)
        self._hinge_body = self.model.jnt_bodyid[1:]
        self.moves = self._ancestry()[self.body][:, self._hinge_body].astype(float)

    def _ancestry(self) -> np.ndarray:
        """Return (n_bodies, n_bodies) booleans: column body is the row body or its ancestor."""
        n = self.model.nbody
        table = np.eye(n, dtype=bool)
        for body in range(1, n):
            table[body] |= table[self.model.body_parentid[body]]
        return table

    def set_geometry(self, body_positions: Float[Array, "n_bodies 3"]) -> None:
        """Use other body offsets (other segment lengths) from now on; masses stay as they were.

        The model of the Human itself is left as it is: this object works on a copy.
        """
        if self.model is self.human.model:
            import copy

            self.model = copy.deepcopy(self.human.model)
            self._data = mujoco.MjData(self.model)
        self.model.body_pos[2:] = body_positions[1:]

    def at(self, qpos: Float[Array, " nq"]) -> Float[Array, "n_points 3"]:
        """Return the points' world positions [m] at a configuration."""
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self._data)
        rotation = self._data.xmat.reshape(-1, 3, 3)[self.body]
        self.position = self._data.xpos[self.body] + np.matmul(
            rotation, self.local[:, :, None]
        ).squeeze(-1)
        return self.position

    @property
    def origins(self) -> Float[Array, "n_bodies 3"]:
        """World position of every body's frame, world included, at the last configuration [m]."""
        return self._data.xpos.copy()

    @property
    def rotations(self) -> Float[Array, "n_bodies 3 3"]:
        """Rotation of every body, world included, at the last configuration."""
        return self._data.xmat.reshape(-1, 3, 3).copy()

    def jacobian(self) -> Float[Array, "n_points 3 nv"]:
        """Return the Jacobian of the positions with respect to MuJoCo's velocity.

        The columns follow ``qvel``: root linear (world), root angular (body axes), hinges.
        """
        data, p = self._data, self.position
        n = len(p)
        J = np.zeros((n, 3, self.model.nv))
        J[:, 0, 0] = J[:, 1, 1] = J[:, 2, 2] = 1.0
        axes = np.concatenate([data.xmat[1].reshape(3, 3).T, data.xaxis[1:]])  # (3 + n_hinges, 3)
        anchors = np.concatenate([np.broadcast_to(data.xpos[1], (3, 3)), data.xanchor[1:]])
        x = p[:, 0:1] - anchors[:, 0]
        y = p[:, 1:2] - anchors[:, 1]
        z = p[:, 2:3] - anchors[:, 2]
        ax, ay, az = axes[:, 0], axes[:, 1], axes[:, 2]
        turned = J[:, :, 3:]
        turned[:, 0] = ay * z - az * y
        turned[:, 1] = az * x - ax * z
        turned[:, 2] = ax * y - ay * x
        turned[:, :, 3:] *= self.moves[:, None, :]
        return J

    def integrate(self, qpos: Float[Array, " nq"], step: Float[Array, " nv"]):
        """Return the configuration reached from ``qpos`` along a tangent step."""
        result = np.array(qpos)
        mujoco.mj_integratePos(self.model, result, step, 1.0)
        return result
