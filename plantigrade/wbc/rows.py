"""Rows of the generalised acceleration that tasks desire, and their cost."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.wbc.level import Level


@runtime_checkable
class Objective(Protocol):
    r"""An objective with the cost :math:`\dot v^T A^T W A \dot v - 2 \dot v^T A^T W b`."""

    @property
    def matrix(self) -> Array:
        """Matrix :math:`A`."""
        ...

    @property
    def weighted(self) -> Array:
        """The same with weights, :math:`W A`."""
        ...

    @property
    def pull(self) -> Array:
        """Desired value, with weights, :math:`W b`."""
        ...


@dataclass(frozen=True, eq=False)
class Rows:
    r"""Rows of the generalised acceleration: :math:`A \dot v = b`, in the least-squares sense.

    Attributes:
        matrix: :math:`A`.
        right: :math:`b`.
        weight: Cost of a squared unit of what is missed, of each row or of all.
        name: Name of the task, for messages.
        at_least: Whether it is an inequality, :math:`A \dot v \ge b`, for strict orders alone.
    """

    matrix: Float[Array, "n_rows nv"]
    right: Float[Array, " n_rows"]
    weight: float | Float[Array, " n_rows"] = 1.0
    name: str = ""
    at_least: bool = False

    def along(self, directions: Float[Array, "n_rows k"]) -> "Rows":
        """Return the rows along directions."""
        right = directions @ self.right
        return Rows(directions @ self.matrix, right, self.weight, self.name, self.at_least)

    def missed(self, qacc: Float[Array, " nv"]) -> Float[Array, " n_rows"]:
        """Return the error of each row; zero where an inequality is satisfied."""
        missed = self.matrix @ qacc - self.right
        return np.minimum(missed, 0.0) if self.at_least else missed

    @property
    def level(self) -> Level:
        """The same as a level of a hierarchy, each row by the root of its weight."""
        matrix, right = self.matrix, self.right
        if not isinstance(self.weight, float) or self.weight != 1.0:
            root = np.broadcast_to(np.sqrt(self.weight), len(right))
            matrix, right = root[:, None] * matrix, root * right
        above = np.full(len(right), np.inf) if self.at_least else right
        return Level(matrix, right, above, self.name)

    @property
    def weighted(self) -> Float[Array, "n_rows nv"]:
        """Each row times its weight.

        Raises:
            ParameterError: If the rows are an inequality.
        """
        if self.at_least:
            raise ParameterError(f"{self.name} is an inequality; only a TaskOrder satisfies it")
        w = self.weight
        return (w[:, None] if isinstance(w, np.ndarray) else w) * self.matrix

    @property
    def pull(self) -> Float[Array, " n_rows"]:
        """Desired value, times its weight."""
        return self.weight * self.right


@dataclass(frozen=True, eq=False)
class PointRows:
    """Accelerations that material points are to have, multiplied out for each of their bodies.

    However many points a body has, its motion has six rows.

    Attributes:
        points: The points.
        chosen: Which of them count.
        right: Their accelerations, less those that they have by themselves [m/s²].
        weight: Cost of a squared unit of what is missed.
    """

    points: RigidPoints
    chosen: Bool[Array, " k"]
    right: Float[Array, "k 3"]
    weight: float

    @classmethod
    def still(
        cls,
        points: RigidPoints,
        chosen: Bool[Array, " k"],
        gap: Float[Array, " k"],
        normal: Float[Array, "*k 3"],
        *,
        stiffness: float,
        damping: float,
        weight: float,
        drift: Float[Array, "k 3"] | float = 0.0,
    ) -> "PointRows":
        """Return rows that bring points to rest, on the ground.

        Args:
            points: The points.
            chosen: Which of them.
            gap: How high each is above the ground [m].
            normal: Normal of the ground, there or everywhere.
            stiffness: Stiffness of the height of points above it [1/s²].
            damping: Damping of the velocity of all [1/s].
            weight: Cost of a squared unit missed [per (m/s²)²].
            drift: Velocity of the ground [m/s].
        """
        right = damping * (drift - points.velocity) - points.bias
        right -= (stiffness * np.maximum(gap, 0.0))[:, None] * normal
        return cls(points, chosen, right, weight)

    @property
    def matrix(self) -> Float[Array, "d nv"]:
        """Jacobian of the bodies."""
        J = self.points.body_jacobian
        return J.reshape(-1, J.shape[2])

    @cached_property
    def _counted(self) -> Float[Array, "n_bodies k"]:
        """Weight of each point in the sums of its body."""
        return self.points.membership * (self.weight * self.chosen)

    @property
    def weighted(self) -> Float[Array, "d nv"]:
        """The same, by what the points make of the bodies' motion."""
        P = self.points.lever
        squares = np.matmul(P.transpose(0, 2, 1), P).reshape(-1, 36)
        metric = (self._counted @ squares).reshape(-1, 6, 6)
        return np.matmul(metric, self.points.body_jacobian).reshape(self.matrix.shape)

    @property
    def pull(self) -> Float[Array, " d"]:
        """Desired accelerations of the points, as those of the bodies."""
        each = np.matmul(self.right[:, None], self.points.lever)[:, 0]
        return (self._counted @ each).ravel()


def cost(
    tasks: Sequence[Objective], desired: Float[Array, " nv"], weight: float | Float[Array, " nv"]
) -> tuple[Float[Array, "nv nv"], Float[Array, " nv"]]:
    """Return the cost of a generalised acceleration: its Hessian, and the right side."""
    nv = len(desired)
    own = weight if isinstance(weight, np.ndarray) else np.full(nv, float(weight))
    if not tasks:
        return np.diag(own), own * desired
    A = np.concatenate([task.matrix for task in tasks])
    H = A.T @ np.concatenate([task.weighted for task in tasks])
    H.flat[:: nv + 1] += own
    return H, np.concatenate([task.pull for task in tasks]) @ A + own * desired
