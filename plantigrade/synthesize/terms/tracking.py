"""Costs of departing from a recorded motion: coordinates, accelerations, ground wrench."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.builder import ProblemBuilder
from plantigrade.synthesize.terms.term import Term, per_coordinate


@dataclass(frozen=True)
class Track(Term):
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j(t))^2 dt` of departing from a motion.

    Attributes:
        times: Times of the motion [s].
        q: Its coordinates, in the order of the person's.
        weight: Weight of every coordinate [1/s].
        joints: Factor of single coordinates.
    """

    times: Float[Array, " n_times"]
    q: Float[Array, "n_times nv"]
    weight: float = 10.0
    joints: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        family = b.family("coordinates")
        w = 2.0 * self.weight * per_coordinate(b.names, self.joints)
        b.penalise(family, w, _at(b.nodes, self.times, self.q))


@dataclass(frozen=True)
class TrackAcceleration(Term):
    r"""Cost :math:`\int w \sum_j (\ddot q_j - \bar{\ddot q}_j(t))^2 dt`.

    It keeps the correction smooth where feet are moved to their footprints.

    Attributes:
        times: Times of the motion [s].
        q: Its coordinates, in the order of the person's.
        weight: Weight of every joint [s³/rad²].
    """

    times: Float[Array, " n_times"]
    q: Float[Array, "n_times nv"]
    weight: float = 1e-4

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        from scipy.interpolate import CubicSpline

        family = b.family("accelerations")
        target = CubicSpline(self.times, self.q)(b.nodes, 2)
        b.penalise(family, 2.0 * self.weight, target)


@dataclass(frozen=True)
class TrackWrench(Term):
    r"""Cost :math:`\int w_f |F - \bar F(t)|^2 + w_m |M - \bar M(t)|^2 dt` of the ground's wrench.

    :math:`F = \sum_k f_k` and :math:`M = \sum_k (p_k - c) \times f_k`, about the centre of mass
    :math:`c`, which set the acceleration of the centre of mass and the rate of angular momentum:
    a recording shows these better than single joints where the recorded feet slide.

    Attributes:
        times: Times [s].
        force: :math:`\bar F`, world [body weights].
        moment: :math:`\bar M`, world [body weights · m].
        weight: :math:`w_f`.
        turning: :math:`w_m`.
    """

    times: Float[Array, " n_times"]
    force: Float[Array, "n_times 3"]
    moment: Float[Array, "n_times 3"]
    weight: float = 300.0
    turning: float = 300.0

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        import casadi as ca

        sym, points = b.body.symbolic, list(b.body.sites)
        names = tuple(f"{what} of the ground {x}" for what in ("push", "moment") for x in "xyz")

        def wrench(q, v, a, u):
            arm, com = sym.positions(points)(q), sym.com()(q)
            f = ca.reshape(u, 3, len(points))
            turn = sum(ca.cross(arm[:, k] - com, f[:, k]) for k in range(len(points)))
            return ca.vertcat(ca.sum2(f), turn)

        family = b.custom_family("wrench", names, wrench, "body weights")
        target = _at(b.nodes, self.times, np.hstack([self.force, self.moment]))
        b.penalise(family, 2.0 * np.repeat([self.weight, self.turning], 3), target)


def _at(nodes: Array, times: Array, values: Array) -> Array:
    """Return columns interpolated at nodes."""
    return np.stack([np.interp(nodes, times, x) for x in values.T], axis=1)
