r"""Material points of bodies at one instant, given by the motion of their bodies.

With the body's angular velocity :math:`\omega` and the velocity :math:`v` of its origin, what is at
:math:`r` from there moves with

.. math:: v + \omega \times r = P \, (\omega, v), \qquad P = [-[r]_\times \;\; 1] .

However many points a body has, its six rows say all: sums over points are sums of :math:`P^T P`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float, Int

CROSS = np.zeros((3, 9))  # v @ CROSS are the entries of the matrix of the cross product with v
CROSS[[2, 1, 0], [3, 2, 7]], CROSS[[2, 1, 0], [1, 6, 5]] = 1.0, -1.0
_MINUS_CROSS = -CROSS
_ONE = np.eye(3)


@dataclass(frozen=True, eq=False)
class RigidPoints:
    """Points of a few bodies, and how these move; turns first, as MuJoCo has them."""

    owner: Int[Array, " k"]  #: Body of each point, as an index
    arm: Float[Array, "k 3"]  #: Position of each point from the origin of its body [m]
    body_jacobian: Float[Array, "n_bodies 6 nv"]  #: Jacobian of the bodies' motion
    body_velocity: Float[Array, "n_bodies 6"]  #: Their motion [rad/s, m/s]
    #: Its rate where the generalised acceleration is zero, along with the bodies
    body_bias: Float[Array, "n_bodies 6"]

    def __len__(self) -> int:
        return len(self.owner)

    @cached_property
    def lever(self) -> Float[Array, "k 3 6"]:
        r"""Matrix from the motion of its body to that of each point, :math:`P`."""
        P = np.empty((len(self), 3, 6))
        P[:, :, :3] = (self.arm @ _MINUS_CROSS).reshape(-1, 3, 3)
        P[:, :, 3:] = _ONE
        return P

    @cached_property
    def jacobian(self) -> Float[Array, "k 3 nv"]:
        """Jacobian of the points."""
        return np.matmul(self.lever, self.body_jacobian[self.owner])

    @cached_property
    def velocity(self) -> Float[Array, "k 3"]:
        """Velocity of the points [m/s]."""
        return np.matmul(self.lever, self.body_velocity[self.owner][:, :, None])[:, :, 0]

    @cached_property
    def bias(self) -> Float[Array, "k 3"]:
        """Acceleration of the points where the generalised one is zero [m/s²]."""
        rate = np.matmul(self.lever, self.body_bias[self.owner][:, :, None])[:, :, 0]
        spin = (self.body_velocity[:, :3] @ CROSS).reshape(-1, 3, 3)
        spin = np.matmul(spin, spin)
        rate += np.matmul(spin[self.owner], self.arm[:, :, None])[:, :, 0]
        return rate

    @cached_property
    def membership(self) -> Float[Array, "n_bodies k"]:
        """1 where a point is on a body, 0 elsewhere: sums over the points of each body."""
        own = np.zeros((len(self.body_velocity), len(self)))
        own[self.owner, np.arange(len(self))] = 1.0
        return own
