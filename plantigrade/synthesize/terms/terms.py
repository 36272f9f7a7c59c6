r"""What a task is made of: conditions and costs, each a small class with one method.

A term puts its limits and weights into an
:class:`~plantigrade.synthesize.problem.assembly.Assembly`.
Nothing here knows which task it is in; a task of one's own is a list of these, and a term of one's
own is a class with ``put``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.assembly import Assembly
from plantigrade.synthesize.problem.formulation import friction_rows, hold_contacts


@runtime_checkable
class Term(Protocol):
    """A condition or a cost."""

    def put(self, a: Assembly) -> None:
        """Put limits and weights into a problem."""


@dataclass(frozen=True)
class Dynamics:
    """The equations of motion: nothing but gravity and contact moves the root."""

    def put(self, a: Assembly) -> None:
        """Ask for the rows, whose first six are equations."""
        a.rows("dynamics")


@dataclass(frozen=True)
class Contact:
    """What stands, stands still; the rest stays above the ground.

    Attributes:
        friction: Coefficient of friction.
        force: Largest vertical force of a site [body weights].
    """

    friction: float = 0.8
    force: float = 3.0

    def put(self, a: Assembly) -> None:
        """Hold sites, and let those carry that stand on both sides of a node."""
        hold_contacts(a.body, a.plan, a.nodes, a.rows("contact"), a.rows("contact speed"))
        friction = a.add(friction_rows(a.body, len(a.nodes), self.friction))
        for k, site in enumerate(a.body.sites):
            carries = a.plan.carrying(site, a.nodes)
            side = self.friction * self.force
            a.u_lower[carries, 3 * k : 3 * k + 3] = (-side, -side, 0.0)
            a.u_upper[carries, 3 * k : 3 * k + 3] = (side, side, self.force)
            friction.lower[carries, 4 * k : 4 * k + 4] = 0.0


@dataclass(frozen=True)
class Pose:
    """Coordinates, and rest, at one instant.

    Attributes:
        time: When [s]; a node.
        coordinates: Values [rad, m].
        at_rest: Whether all rates are zero.
        held: Whether contact is left to the pose: rows that fix the feet are dropped at this node,
            because they would say twice what the coordinates say.
    """

    time: float
    coordinates: Mapping[str, float]
    at_rest: bool = True
    held: bool = True

    def put(self, a: Assembly) -> None:
        """Fix coordinates and rates."""
        k = int(np.argmin(np.abs(a.nodes - self.time)))
        q, v = a.rows("coordinates"), a.rows("speeds")
        for name, value in self.coordinates.items():
            i = a.column(name)
            q.lower[k, i] = q.upper[k, i] = value
        if self.at_rest:
            v.lower[k] = v.upper[k] = 0.0
        if self.held:
            for rows in (a.rows("contact"), a.rows("contact speed")):
                rows.lower[k], rows.upper[k] = -np.inf, np.inf


@dataclass(frozen=True)
class Limits:
    """Joint ranges, speeds and torques of the person.

    Attributes:
        ranges: Narrower ranges of coordinates, by name without or with side [rad].
        speed: Largest speed of a joint [rad/s].
        strength: Part of the person's joint torques that may be used.
        margin: How far within their ranges joints stay at nodes [rad]; between nodes they may
            swing out a little.
        reserve: Part of the strength that is not used at nodes, for the same reason.
    """

    ranges: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: {"knee_angle": (0.0, 2.6)}
    )
    speed: float = 15.0
    strength: float = 1.0
    margin: float = 0.01
    reserve: float = 0.08

    def put(self, a: Assembly) -> None:
        """Limit coordinates, rates and torques."""
        human = a.body.human
        low, high = human.limits
        own = [self.ranges.get(n, self.ranges.get(n[:-2])) for n in a.names[6:]]
        low = np.array([x if r is None else max(x, r[0]) for x, r in zip(low, own, strict=True)])
        high = np.array([x if r is None else min(x, r[1]) for x, r in zip(high, own, strict=True)])
        room = np.minimum(self.margin, (high - low) / 4)
        a.limit(a.rows("coordinates"), low + room, high - room, columns=slice(6, None))
        a.limit(a.rows("speeds"), -self.speed, self.speed, columns=slice(6, None))
        torque = human.model.jnt_actfrcrange[1:] / a.body.torque
        torque = torque * self.strength * (1.0 - self.reserve)
        stiff, rows, nh = a.body.stiff, a.rows("dynamics"), len(torque)
        for i, name in enumerate(a.names[6:]):  # what a joint bears, tissue and muscles together
            row = 6 + 2 * nh + stiff.index(name) if name in stiff else 6 + i
            a.limit(rows, torque[i, 0], torque[i, 1], columns=[row])


@dataclass(frozen=True)
class Torque:
    r"""Cost :math:`\int \sum w_j (\tau_j / \tau_1)^2 dt` of muscles' torques (Eq. 15).

    Attributes:
        weight: Weight of every joint [1/s].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1.0
    joints: Mapping[str, float] = field(default_factory=dict)

    def put(self, a: Assembly) -> None:
        """Weigh torques."""
        rows = a.rows("dynamics")
        w = np.zeros(rows.weight.shape)
        nh = len(a.names) - 6
        w[:, 6 : 6 + nh] = 2.0 * self.weight * _factors(a.names[6:], self.joints)
        a.pull(rows, w)


@dataclass(frozen=True)
class Work:
    r"""Cost :math:`\int \sum w_j |\tau_j \dot q_j| dt` of what muscles work, per 100 J.

    Attributes:
        weight: Weight of every joint.
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 0.1
    joints: Mapping[str, float] = field(default_factory=dict)

    def put(self, a: Assembly) -> None:
        """Weigh work rates."""
        rows = a.rows("dynamics")
        nh = len(a.names) - 6
        w = self.weight * _factors(a.names[6:], self.joints)
        rows.gain[:, 6 + nh : 6 + 2 * nh] += w * a.weights[:, None]


@dataclass(frozen=True)
class Acceleration:
    r"""Cost :math:`\int \sum w_j \ddot q_j^2 dt`: what keeps a spline quiet between its nodes.

    Attributes:
        weight: Weight [s³/rad²].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1e-3
    joints: Mapping[str, float] = field(default_factory=dict)

    def put(self, a: Assembly) -> None:
        """Weigh accelerations."""
        rows = a.rows("accelerations")
        w = np.broadcast_to(2.0 * self.weight * _factors(a.names, self.joints), rows.weight.shape)
        a.pull(rows, w)


@dataclass(frozen=True)
class Jerk:
    r"""Cost :math:`\int \sum w_j \dddot q_j^2 dt`: quiet between nodes, and free to be quick.

    Attributes:
        weight: Weight [s⁵/rad²].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1e-8
    joints: Mapping[str, float] = field(default_factory=dict)

    def put(self, a: Assembly) -> None:
        """Weigh jerk."""
        a.jerk += 2.0 * self.weight * _factors(a.names, self.joints)


@dataclass(frozen=True)
class Posture:
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j)^2 dt` of being away from a posture.

    Attributes:
        weights: Weight of coordinates, by name without or with side.
        targets: Their targets [rad, m]; zero if absent.
    """

    weights: Mapping[str, float]
    targets: Mapping[str, float] = field(default_factory=dict)

    def put(self, a: Assembly) -> None:
        """Weigh coordinates."""
        rows = a.rows("coordinates")
        w, t = np.zeros(rows.weight.shape), np.zeros(rows.weight.shape)
        w[:] = 2.0 * _factors(a.names, self.weights, 0.0)
        t[:] = _factors(a.names, self.targets, 0.0)
        a.pull(rows, w, t)


@dataclass(frozen=True)
class PostureAt:
    r"""Cost :math:`w \sum (q_j - \bar q_j)^2` at one instant: a posture to start from or end in.

    A cost and no equation, so that feet that stand and a posture that nearly fits them agree.

    Attributes:
        time: When [s]; a node.
        q: The posture, in the order of the person's coordinates [rad, m].
        weight: Weight.
    """

    time: float
    q: tuple[float, ...]
    weight: float = 0.5

    def put(self, a: Assembly) -> None:
        """Weigh coordinates at a node."""
        k = int(np.argmin(np.abs(a.nodes - self.time)))
        rows = a.rows("coordinates")
        w, target = np.zeros(rows.weight.shape), np.zeros(rows.weight.shape)
        w[k], target[k] = 2.0 * self.weight / a.weights[k], self.q  # an instant's, no integral's
        a.pull(rows, w, target)


@dataclass(frozen=True)
class Track:
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j(t))^2 dt` of being away from a motion.

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

    def put(self, a: Assembly) -> None:
        """Weigh the distance."""
        rows = a.rows("coordinates")
        target = np.stack([np.interp(a.nodes, self.times, x) for x in self.q.T], axis=1)
        w = np.broadcast_to(2.0 * self.weight * _factors(a.names, self.joints), rows.weight.shape)
        a.pull(rows, w, target)


@dataclass(frozen=True)
class Forces:
    r"""Cost of contact forces [body weights]: :math:`\int w |f|^2 + w_s |\dot f|^2 dt`.

    Attributes:
        size: Weight of the forces themselves, which shares a load between neighbours [1/s].
        rate: Weight of their rates [s].
    """

    size: float = 1e-3
    rate: float = 5e-3

    def put(self, a: Assembly) -> None:
        """Weigh forces."""
        from plantigrade.synthesize.problem.formulation import force_rows

        rows = a.add(force_rows(a.body, len(a.nodes)))
        a.pull(rows, np.full(rows.weight.shape, 2.0 * self.size))
        a.u_smooth += 2.0 * self.rate / a.steps[:, None]


def _factors(
    names: tuple[str, ...], given: Mapping[str, float], otherwise: float = 1.0
) -> Float[Array, " n"]:
    """Return a number for every coordinate, by its name or its name without side."""
    return np.array(
        [given.get(n, given.get(n.removesuffix("_r").removesuffix("_l"), otherwise)) for n in names]
    )
