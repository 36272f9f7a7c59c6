"""Costs of departing from a recorded motion: coordinates, accelerations, forces of the ground."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.motion.filters import interpolate
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.terms.solid import ROW_SCALE, SolidLimbs, legs
from plantigrade.trajopt.terms.term import Term, per_coordinate


@dataclass(frozen=True)
class Track(Term):
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j(t))^2 dt` of departing from a motion."""

    times: Float[Array, " n_times"]  #: Times of the motion [s]
    q: Float[Array, "n_times nv"]  #: Its coordinates, in the order of the person's
    weight: float = 10.0  #: Weight of every coordinate [1/s]
    joints: Mapping[str, float] = field(default_factory=dict)  #: Factor of single coordinates

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        family = b.family("coordinates")
        w = 2.0 * self.weight * per_coordinate(b.names, self.joints)
        b.penalise(family, w, interpolate(b.nodes, self.times, self.q))


@dataclass(frozen=True)
class TrackAcceleration(Term):
    r"""Cost :math:`\int w \sum_j (\ddot q_j - \bar{\ddot q}_j(t))^2 dt`.

    It keeps the correction smooth where feet are moved to their footprints.
    """

    times: Float[Array, " n_times"]  #: Times of the motion [s]
    q: Float[Array, "n_times nv"]  #: Its coordinates, in the order of the person's
    weight: float = 1e-4  #: Weight of every joint [s³/rad²]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        from scipy.interpolate import CubicSpline

        family = b.family("accelerations")
        target = CubicSpline(self.times, self.q)(b.nodes, 2)
        b.penalise(family, 2.0 * self.weight, target)


@dataclass(frozen=True)
class PartLegs(Term):
    r"""Legs keep apart; where those of the recording are in each other they are drawn apart.

    Where the recorded legs are apart, their distance :math:`d` is limited as in
    :class:`~plantigrade.trajopt.terms.solid.SolidLimbs`. But they are not as thick as the person's,
    whose thighs may be in each other where they pass, and whose feet where they stand together.
    There a cost :math:`\int w (d - \bar d)^2 dt` draws them apart. Arms are free: with rows of
    their own a walk takes ten times as long.
    """

    times: Float[Array, " n_times"]  #: Times of the recording [s]
    q: Float[Array, "n_times nv"]  #: Its coordinates, in the order of the person's
    apart: float = SolidLimbs().margin  #: :math:`\bar d`, how far they keep apart [m]
    #: :math:`w` [1/(m² s)]: 3 mm in each other costs as much as the angles of a leg 3° off
    weight: float = 1e5
    #: How much deeper in each other than the recorded ones legs may be [m]: footprints lie as far
    #: beside the recorded feet
    deeper: float = 0.02
    nearer: float = 0.005  #: How much nearer other legs may come, for the same reason [m]

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit and weigh the distance."""
        family = b.add(legs(b.body, len(b.nodes)))
        none = [np.zeros(family.function.size_in(i)) for i in range(1, 5)]
        recorded = interpolate(b.nodes, self.times, self.q)
        own = np.array([np.asarray(family.function(q, *none)).ravel() for q in recorded])
        least, inside = ROW_SCALE * self.apart, own < ROW_SCALE * self.apart
        deeper, nearer = own - ROW_SCALE * self.deeper, least - ROW_SCALE * self.nearer
        b.limit(family, lower=np.where(inside, deeper, nearer))
        b.penalise(family, np.where(inside, 2.0 * self.weight / ROW_SCALE**2, 0.0), least)


@dataclass(frozen=True)
class FootWrenches:
    r"""Where the wrench on each foot is expected, and how closely; feet in the order r, l."""

    times: Float[Array, " n_times"]  #: Times [s]
    force: Float[Array, "n_times 2 3"]  #: Force on each foot, world [body weights]
    point: Float[Array, "n_times 2 2"]  #: Its centre of pressure on the ground, x and y, world [m]
    torque: Float[Array, "n_times 2"]  #: Free moment there, about the vertical [body weights · m]
    #: Standard error of the force [body weights]; infinite where nothing is known
    force_error: Float[Array, "n_times 2 3"]
    point_error: Float[Array, "n_times 2 2"]  #: Error of the centre of pressure [m]
    torque_error: Float[Array, "n_times 2"]  #: Error of the free moment [body weights · m]

    def at(self, nodes: Float[Array, " n_nodes"]) -> "FootWrenches":
        """Return the wrenches at other times [s]; what is not known next to a time is not there."""

        def of(x: Array) -> Array:
            return interpolate(nodes, self.times, x)

        def error(x: Array) -> Array:
            with np.errstate(divide="ignore"):
                return 1.0 / np.maximum(of(1.0 / x), 1e-9)

        return FootWrenches(
            nodes,
            of(self.force),
            of(self.point),
            of(self.torque),
            error(self.force_error),
            error(self.point_error),
            error(self.torque_error),
        )


@dataclass(frozen=True)
class TrackFeet(Term):
    r"""Cost :math:`\int w \sum_i (r_i / \sigma_i)^2 dt` of departing from the expected wrenches.

    Six rows a foot: the force :math:`F = \sum_k f_k` less the expected one, and the moment
    :math:`\sum_k (p_k - c) \times f_k` about the expected centre of pressure :math:`c`, less the
    free moment. A moment about :math:`c` is the load times how far off the centre of pressure is,
    so its error is that of the centre times the expected load. A load binds as far as it
    is known. Where only the heel carries, the centre along x is where the heel is, and is not
    weighed: it would unload a foot whose forefoot carries later than the tissue of a real one.
    """

    feet: FootWrenches  #: Expected wrenches
    weight: float = 1.0  #: :math:`w` [1/s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        there = self.feet.at(b.nodes)
        family = b.add(_foot_wrenches(b, there.point))
        load = np.maximum(there.force[..., 2], MIN_POSITION_LOAD)
        turn = there.point_error[..., ::-1] * load[..., None]  # about x by the error along y
        turn[_on_heel(b), 1] = np.inf
        error = np.concatenate([there.force_error, turn, there.torque_error[..., None]], axis=2)
        target = np.zeros_like(error)
        target[..., :3], target[..., 5] = there.force, there.torque
        shape = len(b.nodes), 12
        b.penalise(family, 2.0 * self.weight / error.reshape(shape) ** 2, target.reshape(shape))


@dataclass(frozen=True)
class JointMoments:
    """Expected joint moments with standard deviations."""

    times: Float[Array, " n_times"]  #: Times [s]
    names: tuple[str, ...]  #: Hinges
    moment: Float[Array, "n_times n_hinges"]  #: Their moments [N m]
    #: Standard errors of these [N m]; infinite where nothing is known
    error: Float[Array, "n_times n_hinges"]


@dataclass(frozen=True)
class TrackMoments(Term):
    r"""Cost :math:`\int w \sum_j ((\tau_j - \bar\tau_j) / \sigma_j)^2 dt` on joint moments.

    Only of joints whose tissue bears much (:attr:`ContactBody.stiff`): hip, knee and ankle in their
    main plane.
    """

    joints: JointMoments  #: Expected moments
    weight: float = 1.0  #: :math:`w` [1/s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the distance."""
        given, unit = self.joints, b.body.torque
        columns = [given.names.index(name) for name in b.body.stiff]
        target = interpolate(b.nodes, given.times, given.moment[:, columns]) / unit
        sure = interpolate(b.nodes, given.times, unit / given.error[:, columns])
        b.penalise(b.family("joint torque"), 2.0 * self.weight * sure**2, target)


MIN_POSITION_LOAD = 0.1  # [body weights] minimum load for a reliable centre of pressure


def _on_heel(b: ProblemBuilder) -> Bool[Array, "n_nodes 2"]:
    """Return where a foot stands, and nothing before its heel carries."""
    found = np.zeros((len(b.nodes), len(SIDES)), dtype=bool)
    for i, side in enumerate(SIDES):
        for site in (s for s in b.body.sites if s.side == side and s.part == "heel"):
            found[:, i] |= b.plan.standing(site, b.nodes)
        for site in (s for s in b.body.sites if s.side == side and s.part != "heel"):
            found[:, i] &= ~b.plan.carrying(site, b.nodes)
    return found


def _foot_wrenches(b: ProblemBuilder, points: Float[Array, "n_nodes 2 2"]) -> ConstraintFamily:
    """Return force and moment about a point of the ground, of each foot."""
    body = b.body

    def expression(ca, q, v, a, u, p):
        place, f = body.symbolic.positions(list(body.sites))(q), ca.reshape(u, 3, len(body.sites))
        rows = []
        for i, side in enumerate(SIDES):
            own = [k for k, site in enumerate(body.sites) if site.side == side]
            c = ca.vertcat(p[2 * i], p[2 * i + 1], 0)
            rows += [
                sum(f[:, k] for k in own),
                sum(ca.cross(place[:, k] - c, f[:, k]) for k in own),
            ]
        return ca.vertcat(*rows)

    names = tuple(
        f"{what} {axis} of foot {side}"
        for side in SIDES
        for what in ("force", "moment")
        for axis in "xyz"
    )
    function = body.function("foot wrenches", expression, 4)
    parameters = points.reshape(len(points), 4)
    return ConstraintFamily.free(
        "foot wrenches", function, names, len(points), parameters, "body weights"
    )
