"""Terms of posture: fixed or preferred, at an instant or throughout."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.contact.plan import ContactPlan, path_heading
from plantigrade.models.mirror import mirrored_name
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import AtInstant, Term, mirrored_values, per_coordinate


@dataclass(frozen=True)
class Pose(AtInstant):
    """Coordinates, and rest, at one instant."""

    coordinates: Mapping[str, float]  #: Values [rad, m]
    at_rest: bool = True  #: Whether all rates are zero
    #: Whether the pose fixes the feet; contact constraints at this node are then dropped as
    #: redundant
    held: bool = True

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix coordinates and rates."""
        k = b.node(self.time)
        q, v = b.family("coordinates"), b.family("speeds")
        for name, value in self.coordinates.items():
            i = b.column(name)
            q.lower[k, i] = q.upper[k, i] = value
        if self.at_rest:
            v.lower[k] = v.upper[k] = 0.0
        if self.held:
            for family in (b.family("contact"), b.family("contact speed")):
                family.lower[k], family.upper[k] = -np.inf, np.inf

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return every coordinate, and rest."""
        when = (self.time,)
        fixed = [
            Condition(name, "coordinate", when, (float(x),), (float(x),), name)
            for name, x in self.coordinates.items()
            if not (plan.slope and name.startswith("pelvis"))
        ]
        return (*fixed, *(Rest(self.time).conditions(body, plan) if self.at_rest else ()))

    def mirrored(self) -> "Pose":
        """Return the pose in the mirror."""
        return replace(self, coordinates=mirrored_values(self.coordinates))


@dataclass(frozen=True)
class Rest(AtInstant):
    """Zero velocity at an instant, in any posture."""

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix rates."""
        family, k = b.family("speeds"), b.node(self.time)
        family.lower[k] = family.upper[k] = 0.0

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return that nothing moves."""
        return (Condition("rest", "rest", (self.time,), (0.0,), (0.0,)),)


@dataclass(frozen=True)
class Quiet(AtInstant):
    r"""Cost :math:`\sum w \ddot q_j^2` at one instant, so that a movement starts or ends smoothly.

    It is a cost because requiring :math:`\ddot q = 0` of a straight leg would leave the
    neighbouring nodes hardly any freedom.
    """

    weight: float = 1e-2  #: Weight [s⁴/rad²]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh accelerations."""
        family, k = b.family("accelerations"), b.node(self.time)
        w = np.zeros(family.weight.shape)
        w[k] = 2.0 * self.weight / b.weights[k]  # at an instant, not an integral
        b.penalise(family, w)


@dataclass(frozen=True)
class Posture(Term):
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j)^2 dt` of being away from a posture.

    Attributes:
        weights: Weight of coordinates, by name without or with side.
        targets: Their targets [rad, m]; zero if absent.
        start: Start of the cost [s].
        stop: End of the cost [s]; that of the motion if infinite.
    """

    weights: Mapping[str, float]
    targets: Mapping[str, float] = field(default_factory=dict)
    start: float = 0.0
    stop: float = np.inf

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh coordinates."""
        family = b.family("coordinates")
        w = np.zeros(family.weight.shape)
        w[b.during(self.start, self.stop)] = 2.0 * per_coordinate(b.names, self.weights, 0.0)
        b.penalise(family, w, per_coordinate(b.names, self.targets, 0.0))

    def mirrored(self) -> "Posture":
        """Return the posture in the mirror."""
        weights = {mirrored_name(k): w for k, w in self.weights.items()}
        return replace(self, weights=weights, targets=mirrored_values(self.targets))


@dataclass(frozen=True)
class LumbopelvicRhythm(Term):
    r"""Cost :math:`\int w (q + \rho (h_r + h_l) / 2)^2 dt` of a back that does not follow the hips.

    :math:`q` is the extension of the lumbar joint, :math:`h_r` and :math:`h_l` are the flexion of
    the hips. People flex hips and lumbar spine together: by 3° and 1° when they raise a knee
    [Tully2002]_ and when they lean forward to rise from a chair [Tully2005]_; of the angle between
    thigh and trunk 13 to 38 % is turning of the pelvis, and both go together with correlations of
    0.89 to 1 [Bohannon2017]_. Torques hardly say where the lumbar joint is: in a squat the sum of
    all other costs differs by 1 % between 4° of extension and 15° of flexion.
    """

    #: Weight :math:`w` [1/(s rad²)]. Chosen: with a third of it, rising from sitting on the floor
    #: flexes the lumbar joint to its limit
    weight: float = 3.0
    #: Lumbar flexion for one of the hips, rho [1]. Chosen between those of squats, 13 to 26°
    #: [McKean2010]_ or about a fifth, and of rising from a chair, a third
    ratio: float = 0.25

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the difference, where the person has a lumbar joint."""
        names = ("lumbar_extension", "hip_flexion_r", "hip_flexion_l")
        if names[0] not in b.names:
            return
        lumbar, right, left = (b.column(name) for name in names)

        def expression(q, v, a, u):
            return q[lumbar] + self.ratio * (q[right] + q[left]) / 2

        family = b.custom_family("lumbopelvic rhythm", ("lumbar joint beside hips",), expression)
        b.penalise(family, 2.0 * self.weight)


@dataclass(frozen=True)
class PostureAt(AtInstant):
    r"""Cost :math:`w \sum (q_j - \bar q_j)^2` of a posture to start from or end in.

    It is a cost, not an equation, because the posture may not quite fit the feet on the ground.
    """

    q: tuple[float, ...]  #: The posture, in the order of the person's coordinates [rad, m]
    weight: float = 0.5  #: Weight

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh coordinates at a node."""
        k, family = b.node(self.time), b.family("coordinates")
        w = np.zeros(family.weight.shape)
        w[k] = 2.0 * self.weight / b.weights[k]  # at an instant, not an integral
        b.penalise(family, w, np.array(self.q))


@dataclass(frozen=True)
class Upright(Term):
    r"""Cost of a part of the body that leans, turns away from the way, or turns fast.

    It is :math:`\int w_f f^2 + w_s s^2 + w_a a^2 + w_\omega |\omega|^2 dt`: :math:`f` and :math:`s`
    are the components forward and to the left of the upward axis of the part, :math:`a` that of its
    forward axis to the left, :math:`\omega` its angular velocity. Upright is against gravity, and
    forward the way of the walk. Costs of joint angles do not say it: a trunk that leans with its
    pelvis has straight joints. People keep head and trunk steady in space, for eyes and vestibular
    organs [Pozzo1990]_, [Winter1995]_; its weight relative to muscle torques is an *estimate*.

    Attributes:
        body: Name of the part: ``"head"``, ``"thorax"``; ``"trunk"`` is the trunk of any joint set.
        forward: Weight of leaning forward [1/s].
        sideways: Weight of leaning sideways [1/s].
        away: Weight of being turned away from the way [1/s].
        turning: Weight of the angular velocity [s/rad²].
    """

    body: str = "head"
    forward: float = 0.0
    sideways: float = 0.0
    away: float = 0.0
    turning: float = 0.0

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh lean, heading and rates."""
        sym, human = b.body.symbolic, b.body.human
        name = human.trunk if self.body == "trunk" else self.body
        i = human.body(name) - 1
        up = -sym.gravity / np.linalg.norm(sym.gravity)
        ahead = np.cross([0.0, 1.0, 0.0], up)  # level, along x

        def expression(ca, q, v, a, u, p):
            R = sym.frames()(q)[1][:, 3 * i : 3 * i + 3]
            x, y = ca.dot(R[:, 2], ca.DM(ahead)), R[1, 2]
            fx, fy = ca.dot(R[:, 0], ca.DM(ahead)), R[1, 0]
            c, s = p[0], p[1]
            rows = [c * x + s * y, c * y - s * x, c * fy - s * fx]
            return ca.vertcat(*rows, sym.angular_velocities()(q, v)[:, i])

        function = b.body.function(("upright", name), expression, 2)
        names = (f"{name} forward", f"{name} left", f"{name} turned left")
        names += tuple(f"turning of the {name} about {x}" for x in "xyz")
        way = path_heading(b.plan, b.nodes)
        way = np.stack([np.cos(way), np.sin(way)], axis=1)
        family = ConstraintFamily.free(f"upright {name}", function, names, len(b.nodes), way)
        weights = [self.forward, self.sideways, self.away, *[self.turning] * 3]
        b.penalise(b.add(family), 2.0 * np.array(weights))


@dataclass(frozen=True)
class Facing(Term):
    r"""Cost :math:`\int w (r - \psi)^2 dt` of a pelvis turned by :math:`r` off the heading."""

    weight: float = 1.0  #: :math:`w` [1/(s rad²)]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the pelvis' rotation."""
        family = b.family("coordinates")
        w = np.zeros(family.weight.shape)
        w[:, b.column("pelvis_rotation")] = 2.0 * self.weight
        b.penalise(family, w, path_heading(b.plan, b.nodes)[:, None])


@dataclass(frozen=True)
class Symmetry(Term):
    r"""Cost :math:`\int w \sum (q_r - q_l)^2 dt` of joints that differ between the sides.

    Bending and turning of trunk and head count as well, and the pelvis' list and rotation.
    """

    weight: float = 1.0  #: Weight [1/(s rad²)]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the differences."""
        import casadi as ca

        names = b.names
        pairs = [(i, names.index(n[:-2] + "_l")) for i, n in enumerate(names) if n.endswith("_r")]
        lateral = ("_list", "_bending", "_rotation")
        middle = [i for i, n in enumerate(names) if mirrored_name(n) == n and n.endswith(lateral)]

        def expression(q, v, a, u):
            return ca.vertcat(*(q[i] - q[j] for i, j in pairs), *(q[i] for i in middle))

        family = b.custom_family(
            "symmetry",
            (*(f"difference of {names[i][:-2]}" for i, _ in pairs), *(names[i] for i in middle)),
            expression,
        )
        b.penalise(family, 2.0 * self.weight)
