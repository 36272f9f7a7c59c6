r"""What ground and muscles can do: friction, unilateral contact, strength.

**Friction.** A contact force lies in a pyramid inside the cone of friction,
:math:`f = G \lambda,\ \lambda \ge 0`, whose edges are four forces, one part up and :math:`\mu`
sideways: whatever :math:`\lambda \ge 0` comes out, the ground only pushes and nothing slips.

**Equations of motion.** With the root's rows (index 0) apart from the joints' (index j),

.. math:: M_{00} \dot v_0 + M_{0j} \dot v_j + h_0 = J_0^T f, \qquad
    M_{j0} \dot v_0 + M_{jj} \dot v_j + h_j = \tau + J_j^T f .

No muscle moves the root: the first rows give :math:`\dot v_0` from joint accelerations and forces,
:math:`\dot v = T y + t` with :math:`y = (\dot v_j, \lambda)`. In these unknowns the equations of
motion hold by themselves, to the last digit, and every task that is a row of :math:`\dot v` is a
row of :math:`y`. The second rows are the joint moments, which strength bounds.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import State
from plantigrade.wbc.hierarchy import Level

EDGES = 4  # of the friction pyramid
UNIT = 0.1  # body weights per unit of lambda: of the size of joint accelerations in y
GREATEST = 5.0  # vertical force of one point, body weights


class FrictionPyramid:
    """Contact forces as non-negative combinations of the edges of a pyramid.

    Args:
        friction: Coefficient of friction: of the cone around the pyramid.
        weight: Body weight [N].
    """

    def __init__(self, friction: float, weight: float):
        angle = 2 * np.pi * (np.arange(EDGES) + 0.5) / EDGES
        edges = [friction * np.cos(angle), friction * np.sin(angle), np.ones(EDGES)]
        self.edges = UNIT * weight * np.stack(edges)  # (3, EDGES) [N]

    def force(self, share: Float[Array, " n_shares"]) -> Float[Array, "n_points 3"]:
        """Return the forces [N]."""
        return share.reshape(-1, EDGES) @ self.edges.T


@dataclass(frozen=True)
class ReducedDynamics:
    r"""The equations of motion at one state, in the unknowns :math:`y`.

    Attributes:
        matrix: :math:`T`.
        offset: :math:`t`.
        moment_matrix: Joint moments are ``moment_matrix @ y + moment_offset`` [N m].
        moment_offset: The same.
        push: Generalised force of each unit of :math:`\lambda`.
        n_joints: Number of joint accelerations in :math:`y`.
    """

    matrix: Float[Array, "nv n"]
    offset: Float[Array, " nv"]
    moment_matrix: Float[Array, "n_joints n"]
    moment_offset: Float[Array, " n_joints"]
    push: Float[Array, "nv n_shares"]
    n_joints: int

    def rows(self, level: Level) -> Level:
        """Return rows of the acceleration as rows of :math:`y`."""
        off = level.matrix @ self.offset
        matrix = level.matrix @ self.matrix
        return Level(matrix, level.lower - off, level.upper - off, level.name)

    def strength(self, low, high) -> Level:
        """Return the rows that bound joint moments [N m], of unit length."""
        length = np.linalg.norm(self.moment_matrix, axis=1)
        return Level(
            self.moment_matrix / length[:, None],
            (low - self.moment_offset) / length,
            (high - self.moment_offset) / length,
            "strength",
        )

    def acceleration(self, y: Float[Array, " n"]) -> Float[Array, " nv"]:
        """Return the generalised acceleration."""
        return self.matrix @ y + self.offset


def reduced_dynamics(
    state: State,
    points: SitePoints,
    touching: np.ndarray,
    pyramid: FrictionPyramid,
) -> ReducedDynamics:
    """Return the equations of motion at a state.

    Args:
        state: The state.
        points: The contact sites; forces act at the lowest points of their spheres.
        touching: Indices of the points that carry.
        pyramid: What forces they carry.
    """
    M, h = state.mass_matrix, state.bias
    J = state.jacobian(points)[touching].copy()
    for i, p in enumerate(touching):
        turn = state.angular_jacobian(int(points.body[p]))
        J[i, 0] -= (
            turn[1] * points.radius[p]
        )  # velocity of what lies below the centre: + w x (0, 0, -r)
        J[i, 1] += turn[0] * points.radius[p]
    G = np.einsum("kcv,cf->vkf", J, pyramid.edges).reshape(len(h), -1)
    n_joints, n_shares = len(h) - 6, G.shape[1]
    root = np.linalg.solve(M[:6, :6], np.hstack([-M[:6, 6:], G[:6], -h[:6, None]]))
    matrix = np.zeros((len(h), n_joints + n_shares))
    matrix[:6] = root[:, :-1]
    matrix[6:, :n_joints] = np.eye(n_joints)
    offset = np.zeros(len(h))
    offset[:6] = root[:, -1]
    moment_matrix = M[6:] @ matrix
    moment_matrix[:, n_joints:] -= G[6:]
    return ReducedDynamics(matrix, offset, moment_matrix, M[6:] @ offset + h[6:], G, n_joints)
