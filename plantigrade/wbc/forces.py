r"""Motion with forces: joint accelerations and contact forces, solved together.

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

Above all tasks stands the strength of the joints; below them all stand the least contact forces,
near those of the instant before. They decide what mechanics leaves open: how points of one foot,
and of two feet, share the load.

Where it is known what force each foot should carry, its wrench joins the level of the centre of
mass: force by body mass, and the moment about the desired centre of pressure by body mass and a
lever arm. A path and forces that do not quite belong together then each give way a little, instead
of the forces without end.

A foot carries wherever its sole is on the ground, also where it rolls: a point of it less and less
as it rises.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION, GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState
from plantigrade.wbc.level import Level
from plantigrade.wbc.order import TaskOrder, stacked
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks import ComTask, ContactTask
from plantigrade.wbc.touching import FORCE_UNIT, N_EDGES, level_pyramid


@dataclass(frozen=True, kw_only=True)
class ForceSettings:
    """Contact forces of a strict order."""

    max_point_force: float = 5.0
    """Greatest vertical force of one point [body weights]. Chosen."""
    carrying_height: float = 0.005
    """Height up to which a point carries fully [m]. Chosen; at twice that it carries nothing."""
    wrench_weight: float = 0.3
    """Weight of the feet's wrenches against the centre of mass. Chosen."""
    wrench_lever: float = 0.2
    """Lever arm at which an error of their moment counts as one of the force [m]. Chosen."""
    min_foot_load: float = 0.035
    """Load below which a foot is in the air and has no centre of pressure [body weights].
    Chosen."""


@dataclass(frozen=True)
class Footing:
    """Forces that the ground can provide.

    Attributes:
        friction: Coefficient of friction.
        wrench: Desired load of each foot (r, l) at a time, force [N] and moment about the world's
            origin [N m]; anything if absent.
        settings: Bounds and costs of the forces.
    """

    friction: float = FRICTION
    wrench: Callable[[float], Float[Array, "2 6"]] | None = None
    settings: ForceSettings = ForceSettings()


@dataclass(frozen=True)
class ReducedDynamics:
    r"""The equations of motion at one state, in the unknowns :math:`y`."""

    matrix: Float[Array, "nv n"]  #: :math:`T`
    offset: Float[Array, " nv"]  #: :math:`t`
    #: Joint moments are ``moment_matrix @ y + moment_offset`` [N m]
    moment_matrix: Float[Array, "n_joints n"]
    moment_offset: Float[Array, " n_joints"]  #: The same
    push: Float[Array, "nv n_shares"]  #: Generalised force of each unit of :math:`\lambda`
    n_joints: int  #: Number of joint accelerations in :math:`y`

    def rows(self, level: Level) -> Level:
        """Return rows of the acceleration as rows of :math:`y`."""
        off, matrix = level.matrix @ self.offset, level.matrix @ self.matrix
        lower = level.lower - off
        upper = lower if level.upper is level.lower else level.upper - off
        return Level(matrix, lower, upper, level.name)

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
    state: BodyState, points: SitePoints, touching: np.ndarray, edges: Float[Array, "3 n_edges"]
) -> ReducedDynamics:
    """Return the equations of motion at a state.

    Args:
        points: The contact sites; forces act at the lowest points of their spheres.
        touching: Indices of the points that carry.
        edges: Edges of their friction pyramid, forces as columns [N].
    """
    M, h = state.mass_matrix, state.bias
    J = state.jacobian(points)[touching].copy()
    for i, p in enumerate(touching):
        turn = state.angular_jacobian(int(points.body[p]))
        J[i, 0] -= turn[1] * points.radius[p]  # below the centre: + w x (0, 0, -r)
        J[i, 1] += turn[0] * points.radius[p]
    G = np.einsum("kcv,cf->vkf", J, edges).reshape(len(h), -1)
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


class ForceUnknowns:
    """The hierarchical program of one tick in joint accelerations and contact forces.

    Forces act at the sites of the order's contact task.
    """

    impacts = False  # forces let nothing jump

    def __init__(self, state: BodyState, order: TaskOrder, ground: Footing):
        contact = next((t for t in order.tasks if isinstance(t, ContactTask)), None)
        if contact is None:
            raise ParameterError(
                f"the order ({', '.join(order.names)}) has no ContactTask; forces act at its sites"
            )
        self.contact, model = contact, state.model
        self.wrench, self.weight = ground.wrench, state.mass * GRAVITY
        self.settings = ground.settings
        self.shared = next(
            (
                k
                for k, tasks in enumerate(order.levels)
                if any(isinstance(t, ComTask) for t in tasks)
            ),
            len(order.levels) - 1,
        )
        self.sites = contact.points.sites
        self.sides = np.array([site.side for site in self.sites])
        self.edges = FORCE_UNIT * self.weight * level_pyramid(ground.friction)
        self.strength = np.where(
            model.jnt_actfrclimited[1:, None].astype(bool), model.jnt_actfrcrange[1:], [-1e6, 1e6]
        ).T
        self.before = np.zeros((len(self.sites), N_EDGES))
        self.on = np.zeros(0, dtype=int)
        self.dynamics: ReducedDynamics

    def program(
        self, state: BodyState, time: float, rows: list[list[Rows]], desired, bounds
    ) -> dict[str, Any]:
        """Return the arguments of :func:`~plantigrade.wbc.hierarchy.solve_hierarchy`."""
        height = self.contact.points.height(state)
        stands = {side: bool(self.contact.on[self.sides == side].any()) for side in SIDES}
        standing = np.array([stands[side] for side in self.sides])
        s = self.settings
        full, nothing = s.carrying_height, 2 * s.carrying_height
        self.on = np.flatnonzero(standing & (height < nothing))
        self.dynamics = reduced_dynamics(state, self.contact.points, self.on, self.edges)
        strength = self.dynamics.strength(*self.strength)
        share = np.clip((nothing - height[self.on]) / (nothing - full), 0.0, 1.0)
        most = share * s.max_point_force / FORCE_UNIT
        needed = [[self.dynamics.rows(stacked([row.level for row in level]))] for level in rows]
        needed[self.shared] += self._wrenches(state, time)
        before = self.before[self.on].ravel()
        preferred, metric = _preference(self.dynamics, desired, before)
        low, high = bounds
        return {
            "levels": [strength, *(stacked(level) for level in needed)],
            "lower": np.concatenate([low[6:], np.zeros(N_EDGES * len(most))]),
            "upper": np.concatenate([high[6:], np.repeat(most, N_EDGES)]),
            "preferred": preferred,
            "metric": metric,
        }

    def answer(self, state: BodyState, x: Float[Array, " n"]) -> dict[str, Array]:
        """Return the acceleration of an answer, and its forces."""
        y = x.copy()
        share = y[self.dynamics.n_joints :]
        np.maximum(share, 0.0, out=share)  # what is left of the solver's tolerance
        self.before[:] = 0.0
        self.before[self.on] = share.reshape(-1, N_EDGES)
        qacc = self.dynamics.acceleration(y)
        force = np.zeros((len(self.sites), 3))
        point = np.full((len(self.sites), 3), np.nan)
        force[self.on] = share.reshape(-1, N_EDGES) @ self.edges.T
        point[self.on] = state.position(self.contact.points)[self.on]
        point[self.on, 2] -= self.contact.points.radius[self.on]
        tau = state.mass_matrix @ qacc + state.bias - self.dynamics.push @ share
        return {"qacc": qacc, "qfrc": tau, "contact_force": force, "contact_point": point}

    def _wrenches(self, state: BodyState, time: float) -> list[Level]:
        """Return the rows of the desired wrench of each foot on the ground."""
        if self.wrench is None:
            return []
        place = state.position(self.contact.points)[self.on]
        place[:, 2] -= self.contact.points.radius[self.on]
        mass, found, s = self.weight / GRAVITY, [], self.settings
        scale = s.wrench_weight / mass * np.array([1.0, 1.0, 1.0, *[1.0 / s.wrench_lever] * 3])
        for side, desired in zip(SIDES, self.wrench(time), strict=True):
            mine = np.flatnonzero(self.sides[self.on] == side)
            if not len(mine):
                continue
            force, moment = desired[:3], desired[3:]
            about = place[mine].mean(axis=0)
            if force[2] > s.min_foot_load * self.weight:  # about the desired centre of pressure
                about = np.array([-moment[1], moment[0], 0.0]) / force[2]
            rows = np.zeros((6, self.dynamics.matrix.shape[1]))
            columns = self.dynamics.n_joints + N_EDGES * mine[:, None] + np.arange(N_EDGES)
            rows[:3, columns] = self.edges[:, None, :]
            rows[3:, columns] = np.cross(
                (place[mine] - about)[:, None, :], self.edges.T[None]
            ).transpose(2, 0, 1)
            right = np.concatenate([force, moment - np.cross(about, force)])
            found.append(Level.equation(rows * scale[:, None], right * scale, f"wrench {side}"))
        return found


def _preference(dynamics: ReducedDynamics, desired, before) -> tuple[np.ndarray, np.ndarray]:
    """Return what the last level prefers, and its metric.

    A unit of force costs as much as one of acceleration, and so does its change from the instant
    before.
    """
    metric = dynamics.matrix.T @ dynamics.matrix
    right = dynamics.matrix.T @ (desired - dynamics.offset)
    forces = np.arange(dynamics.n_joints, len(metric))
    metric[forces, forces] += 2.0
    right[forces] += before
    return np.linalg.solve(metric, right), metric
