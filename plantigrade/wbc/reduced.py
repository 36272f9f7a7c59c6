r"""The whole-body program without its accelerations: what remains is in the shares alone.

The root's accelerations follow from its equations of motion,

.. math:: \dot v_r = M_{rr}^{-1} (-M_{rj} \dot v_j + W_r^T u - h_r) ,

with :math:`u` the wrenches of the ground on the bodies; without torque limits those of the joints
are free, and the best of them follow from the Cholesky factor :math:`L` of their Hessian,

.. math:: \dot v_j = -L^{-T} (y + X u) .
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import get_lapack_funcs

from plantigrade.arrays import Array, Float, Int

gesv, potrf, trtrs = get_lapack_funcs(("gesv", "potrf", "trtrs"), dtype=np.float64)
_SIX = np.eye(6)


@dataclass(frozen=True, eq=False)
class InstantDynamics:
    """The equations of motion at one instant."""

    M: Float[Array, "nv nv"]  #: Joint-space inertia
    h: Float[Array, " nv"]  #: Gravity, centrifugal and Coriolis terms
    armature: Float[Array, " n"]  #: Inertia added to each hinge by the plant [kg m²]
    given: Float[Array, " n"]  #: Passive torques of the joints [N m]
    W: Float[Array, "d nv"]  #: Jacobian of the bodies that touch, six rows for each

    def torque(self, qacc: Float[Array, " nv"], wrench: Float[Array, " d"]) -> Float[Array, " n"]:
        """Return the motor torques of accelerations, with wrenches on the bodies."""
        tau = self.M[6:] @ qacc + self.armature * qacc[6:]
        tau += self.h[6:] - self.given - wrench @ self.W[:, 6:]
        return tau

    def solved_root(self, by_body: bool) -> Float[Array, "6 columns"]:
        """Return the root's accelerations by those of joints, by wrenches, and the constant part.

        Args:
            by_body: Whether by the wrench on each body, or by that on the root alone.
        """
        M, n = self.M, len(self.given)
        c = len(self.W) if by_body else 6
        right = np.empty((6, n + c + 1), order="F")
        right[:, :n], right[:, -1] = -M[:6, 6:], -self.h[:6]
        right[:, n:-1] = self.W[:, :6].T if by_body else _SIX
        return gesv(M[:6, :6], right, overwrite_b=True)[2]


@dataclass(frozen=True, eq=False)
class TorqueCost:
    """The cost of torques off the desired ones."""

    desired: Float[Array, " n"]  #: Torques [N m]
    weight: Float[Array, " n"]  #: Cost of a squared newton metre off them


class Reduced:
    """The program with accelerations eliminated, those of the best joints following the shares.

    Attributes:
        K: Map from shares to wrenches on the bodies, or on the root alone.
        S: Hessian of the cost of that.
        q: Its slope at zero.

    Raises:
        LinAlgError: If tasks leave accelerations of joints open.
    """

    def __init__(
        self,
        dynamics: InstantDynamics,
        H: Float[Array, "nv nv"],
        g: Float[Array, " nv"],
        K: Float[Array, "d m"],
        torques: TorqueCost | None,
    ):
        self._dynamics, self._wrench = dynamics, K
        n = self._n = len(dynamics.given)
        self.K = dynamics.W[:, :6].T @ K if torques is None else K
        self._root = root = dynamics.solved_root(torques is not None)
        cost = _acceleration_cost(H, g, root)
        if torques is not None:
            rows = _torque_rows(dynamics, root)
            rows[:, -1] -= torques.desired
            cost += rows.T @ (torques.weight[:, None] * rows)
        self._factor, info = potrf(cost[:n, :n].T, lower=True)
        if info:
            raise np.linalg.LinAlgError
        solved = trtrs(self._factor, cost[n:, :n].T, lower=True)[0]
        left = cost[n:-1, n:] - solved[:, :-1].T @ solved
        self.S, self.q = left[:, :-1], left[:, -1]
        self._X, self._y = solved[:, :-1], solved[:, -1]

    def accelerations(
        self, share: Float[Array, " m"], along: Float[Array, " n"] | float = 0.0
    ) -> tuple[Float[Array, " nv"], Float[Array, " n"]]:
        """Return accelerations and torques of shares, joints off the best by ``along``."""
        n, root = self._n, self._root
        carried = self.K @ share
        joints = trtrs(self._factor, along - self._y - self._X @ carried, lower=True, trans=1)[0]
        top = root[:, :n] @ joints + root[:, n:-1] @ carried + root[:, -1]
        qacc = np.concatenate([top, joints])
        return qacc, self._dynamics.torque(qacc, self._wrench @ share)

    def torques(
        self, which: Int[Array, " k"]
    ) -> tuple[Float[Array, "n k"], Float[Array, "k m"], Float[Array, " k"]]:
        """Return torques by joint accelerations off the best, by shares, and the constant part."""
        n, dynamics, root = self._n, self._dynamics, self._root
        below = dynamics.M[6 + which]
        by_joints = below[:, 6:] + below[:, :6] @ root[:, :n]
        by_joints[np.arange(len(which)), which] += dynamics.armature[which]
        held = trtrs(self._factor, by_joints.T, lower=True)[0]
        rows = (below[:, :6] @ root[:, n:-1] - held.T @ self._X) @ self.K
        rows -= dynamics.W[:, 6 + which].T @ self._wrench
        still = below[:, :6] @ root[:, -1] + (dynamics.h[6:] - dynamics.given)[which]
        return held, rows, still - self._y @ held


def _acceleration_cost(H: Array, g: Array, root: Array) -> Float[Array, "columns columns"]:
    """Return the cost of accelerations by those of joints, by wrenches, and the constant part."""
    n = len(g) - 6
    moved = H[:6, :6] @ root
    moved[:, :n] += H[:6, 6:]
    moved[:, -1] -= g[:6]
    cost = root.T @ moved
    cost[:n] += H[6:, :6] @ root
    cost[:n, :n] += H[6:, 6:]
    cost[:n, -1] -= g[6:]
    cost[-1, :n] = cost[:n, -1]
    return cost


def _torque_rows(dynamics: InstantDynamics, root: Array) -> Float[Array, "n columns"]:
    """Return torques by accelerations of joints, by wrenches on bodies, and the constant part."""
    n = len(dynamics.given)
    rows = dynamics.M[6:, :6] @ root
    rows[:, :n] += dynamics.M[6:, 6:]
    rows.reshape(-1)[:: rows.shape[1] + 1] += dynamics.armature
    rows[:, n:-1] -= dynamics.W[:, 6:].T
    rows[:, -1] += dynamics.h[6:] - dynamics.given
    return rows
