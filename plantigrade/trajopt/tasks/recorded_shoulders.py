r"""Shoulders of a recording past the singularity of their angles.

Where an arm goes through the level sideways, two of the three angles of its shoulder turn by up to
half a turn while it moves by a few degrees, faster than any joint. The nearest path of the angles
that a joint can follow,

.. math:: \min_q \int \frac{\lVert \log \bar R(t)^T R(q) \rVert^2}{\sigma^2}
    + \frac{\lVert \ddot q \rVert^2}{\alpha^2} \, dt,

is found by Gauss-Newton steps; :math:`R` is the rotation of the upper arm. It cuts the corner: by
less than the arm's distance from the singularity where it passes.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.ball_joints import BallJoint, ball_joints
from plantigrade.models import Human
from plantigrade.motion import Motion

MAX_STEPS = 60  # Gauss-Newton steps; a passage takes 5 to 20
DONE = 1e-4  # [1] relative fall of the cost at which they end


@dataclass(frozen=True)
class ShoulderPath:
    r"""What is weighed against each other.

    Attributes:
        error: :math:`\sigma`, how exactly a recording has the rotation of an upper arm [rad].
        acceleration: :math:`\alpha`, at which a joint reaches its greatest speed, 15 rad/s, within
            a tenth of a second [rad/s²].
    """

    error: float = 0.05
    acceleration: float = 150.0

    def of(self, human: Human, motion: Motion) -> Float[Array, "n_frames nq"]:
        """Return the configurations of a motion whose shoulder angles go on, with such paths.

        Shoulders that stay away from the singularity are as they were.
        """
        qpos = motion.qpos.copy()
        for each in ball_joints(human, qpos):
            k = 7 + np.array(each.hinges)
            qpos[:, k] = self._path(each, qpos[:, k], motion.rate)
        return qpos

    def _path(
        self, joint: BallJoint, angles: Float[Array, "n 3"], rate: float
    ) -> Float[Array, "n 3"]:
        """Return the path nearest to the rotations of given angles [rad]."""
        from scipy import sparse
        from scipy.sparse.linalg import spsolve

        n = len(angles)
        bend = sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(n - 2, n))  # type: ignore
        bend = sparse.kron(bend, sparse.eye(3)) * (rate**2 / self.acceleration)
        stiff = (bend.T @ bend).tocsc()

        def apart(x: Array) -> Array:
            return joint.between(angles, x) / self.error

        def cost(x: Array) -> float:
            return float((apart(x) ** 2).sum() + ((bend @ x.ravel()) ** 2).sum())

        x, now, damping = angles, cost(angles), 1e-3
        for _ in range(MAX_STEPS):
            J = joint.axes(x) / self.error
            slope = (np.swapaxes(J, 1, 2) @ apart(x)[..., None]).ravel() + stiff @ x.ravel()
            hessian = sparse.block_diag(np.swapaxes(J, 1, 2) @ J, format="csc") + stiff
            step = spsolve(hessian + damping * sparse.eye(3 * n, format="csc"), -slope)
            new = x + step.reshape(n, 3)
            then = cost(new)
            if then >= now:
                damping *= 10.0
                continue
            done = now - then < DONE * now
            x, now, damping = new, then, max(0.1 * damping, 1e-6)
            if done:
                break
        return x
