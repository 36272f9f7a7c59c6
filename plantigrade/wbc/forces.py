r"""Motion by forces: joint accelerations and contact forces, chosen together.

The unknowns are joint accelerations and the shares of the friction pyramids' edges; the equations
of motion hold by themselves (:mod:`plantigrade.wbc.friction`). Above all tasks stand the strength
of the joints and how much a foot may carry; below them all stand the least contact forces, near
those of the instant before. They decide what mechanics leaves open: how points of one foot, and of
two feet, share the load.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION, GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State
from plantigrade.wbc.friction import (
    EDGES,
    GREATEST,
    UNIT,
    FrictionPyramid,
    ReducedDynamics,
    reduced_dynamics,
)
from plantigrade.wbc.hierarchy import Level
from plantigrade.wbc.order import TaskOrder, stacked
from plantigrade.wbc.tasks import ContactTask

REACH = 0.01  # a point higher above the ground than this carries nothing [m]
# What the last level weighs against the squared posture error [rad²/s⁴], per squared unit of force:
SMALL, STEADY = 1.0, 1.0  # its size, its change from the instant before


@dataclass(frozen=True)
class GroundForces:
    """What the ground can do.

    Attributes:
        friction: Coefficient of friction.
        load: Greatest vertical force of a foot (``"r"`` or ``"l"``) at a time [body weights]; no
            limit if absent.
    """

    friction: float = FRICTION
    load: Callable[[str, float], float] | None = None


class ForceUnknowns:
    """The hierarchical program of one tick in joint accelerations and contact forces.

    Args:
        state: The first state.
        order: The tasks. The sites of its contact task carry the forces.
        ground: What the ground can do.

    Raises:
        ParameterError: If the order has no contact task.
    """

    impacts = False  # forces let nothing jump

    def __init__(self, state: State, order: TaskOrder, ground: GroundForces):
        contact = next((t for t in order.tasks if isinstance(t, ContactTask)), None)
        if contact is None:
            raise ParameterError(
                f"the order ({', '.join(order.names)}) has no ContactTask; forces act at its sites"
            )
        self.contact, self.load, model = contact, ground.load, state.model
        self.sites = contact.points.sites
        self.sides = np.array([site.side for site in self.sites])
        self.pyramid = FrictionPyramid(ground.friction, state.mass * GRAVITY)
        self.strength = np.where(
            model.jnt_actfrclimited[1:, None].astype(bool), model.jnt_actfrcrange[1:], [-1e6, 1e6]
        ).T
        self.before = np.zeros((len(self.sites), EDGES))
        self.on = np.zeros(0, dtype=int)
        self.dynamics: ReducedDynamics

    def program(
        self, state: State, time: float, rows: list[list[Level]], wanted, bounds
    ) -> dict[str, Any]:
        """Return the arguments of :func:`~plantigrade.wbc.hierarchy.solve_hierarchy`."""
        height = self.contact.points.height(state)
        self.on = np.flatnonzero(self.contact.on & (height < REACH))
        self.dynamics = reduced_dynamics(state, self.contact.points, self.on, self.pyramid)
        hard = [self.dynamics.strength(*self.strength), *self._loads(time)]
        n_shares = self.dynamics.push.shape[1]
        preferred, metric = _preference(self.dynamics, wanted, self.before[self.on].ravel())
        low, high = bounds
        return {
            "levels": [stacked(hard), *(self.dynamics.rows(stacked(level)) for level in rows)],
            "lower": np.concatenate([low[6:], np.zeros(n_shares)]),
            "upper": np.concatenate([high[6:], np.full(n_shares, GREATEST / UNIT)]),
            "preferred": preferred,
            "metric": metric,
        }

    def answer(self, state: State, x: Float[Array, " n"]) -> dict[str, Array]:
        """Return the acceleration of an answer, and its forces."""
        y = x.copy()
        share = y[self.dynamics.n_joints :]
        np.maximum(share, 0.0, out=share)  # what is left of the solver's tolerance
        self.before[:] = 0.0
        self.before[self.on] = share.reshape(-1, EDGES)
        qacc = self.dynamics.acceleration(y)
        force = np.zeros((len(self.sites), 3))
        point = np.full((len(self.sites), 3), np.nan)
        force[self.on] = self.pyramid.force(share)
        point[self.on] = state.position(self.contact.points)[self.on]
        point[self.on, 2] -= self.contact.points.radius[self.on]
        tau = state.mass_matrix @ qacc + state.bias - self.dynamics.push @ share
        return {"qacc": qacc, "qfrc": tau, "contact_force": force, "contact_point": point}

    def _loads(self, time: float) -> list[Level]:
        """Return the rows that bound the vertical force of each foot."""
        if self.load is None:
            return []
        sides, n_joints = self.sides[self.on], self.dynamics.n_joints
        rows, bound = [], []
        for side in SIDES:
            most = self.load(side, time)
            mine = sides == side
            if mine.any() and most < GREATEST:
                rows.append(np.concatenate([np.zeros(n_joints), np.repeat(mine, EDGES)]))
                bound.append(most / UNIT)
        if not rows:
            return []
        return [Level(np.array(rows), np.full(len(rows), -np.inf), np.array(bound), "load")]


def _preference(dynamics: ReducedDynamics, wanted, before) -> tuple[np.ndarray, np.ndarray]:
    """Return what the last level prefers, and its metric."""
    metric = dynamics.matrix.T @ dynamics.matrix
    right = dynamics.matrix.T @ (wanted - dynamics.offset)
    forces = np.arange(dynamics.n_joints, len(metric))
    metric[forces, forces] += SMALL + STEADY
    right[forces] += STEADY * before
    return np.linalg.solve(metric, right), metric
