"""Terms for tasks other than walking."""

from dataclasses import dataclass

import numpy as np

from plantigrade.contact.ground import treads
from plantigrade.contact.plan import SAME, Footprint
from plantigrade.contact.site import Point
from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.synthesize.problem.assembly import Assembly
from plantigrade.synthesize.problem.formulation import site_targets
from plantigrade.synthesize.problem.nlp import ConstraintFamily
from plantigrade.synthesize.tasks.walking_plan import unrolled


def node_at(a: Assembly, time: float) -> int:
    """Return the node of a time.

    Raises:
        ParameterError: If there is no node within a step of it.
    """
    k = int(np.argmin(np.abs(a.nodes - time)))
    if abs(a.nodes[k] - time) > max(a.steps):
        raise ParameterError(
            f"{time:g} s is outside the motion, which lasts from {a.nodes[0]:g} to "
            f"{a.nodes[-1]:g} s"
        )
    return k


def rows_of(
    a: Assembly, name: str, names: tuple[str, ...], expression, unit: str = ""
) -> ConstraintFamily:
    """Return rows of one's own, made where they were not asked for before.

    Args:
        a: The problem.
        name: Of the rows.
        names: Of every row.
        expression: (q, qd, qdd, u) ↦ column of rows, in units in which 1 is large.
        unit: Unit of a row.
    """
    import casadi as ca

    nv, nu = len(a.names), 3 * len(a.body.sites)
    q, v, acc = (ca.SX.sym(x, nv) for x in ("q", "qd", "qdd"))
    u, p = ca.SX.sym("u", nu), ca.SX.sym("p", 0)
    function = ca.Function("rows", [q, v, acc, u, p], [expression(q, v, acc, u)])
    return a.add(ConstraintFamily.free(name, function, names, len(a.nodes), unit=unit))


BESIDE = 0.06
"""How far beside where it is expected a swinging foot clears a step [m]."""


@dataclass(frozen=True)
class Rest:
    """No speed at an instant, in whatever posture.

    Attributes:
        time: When [s]; a node.
    """

    time: float

    def put(self, a: Assembly) -> None:
        """Fix rates."""
        rows, k = a.rows("speeds"), node_at(a, self.time)
        rows.lower[k] = rows.upper[k] = 0.0


@dataclass(frozen=True)
class Within:
    """A coordinate stays between limits for a while.

    Attributes:
        coordinate: Its name.
        low: Lower limit [rad, m].
        high: Upper limit.
        start: From when [s].
        stop: To when [s]; to the end if infinite.
    """

    coordinate: str
    low: float = -np.inf
    high: float = np.inf
    start: float = 0.0
    stop: float = np.inf

    def put(self, a: Assembly) -> None:
        """Narrow the limits."""
        during = (a.nodes >= self.start - SAME) & (a.nodes <= self.stop + SAME)
        a.limit(
            a.rows("coordinates"),
            self.low,
            self.high,
            columns=[a.column(self.coordinate)],
            nodes=np.flatnonzero(during).tolist(),
        )


@dataclass(frozen=True)
class PowerLimit:
    """No joint works faster than muscles can, generating or absorbing.

    Isometric strength alone lets a joint be as strong when it moves fast. In good jumps the whole
    body reaches 50 to 60 W/kg, which six joints share (estimate).

    Attributes:
        limit: Of each joint, per body mass [W/kg].
    """

    limit: float = 10.0

    def put(self, a: Assembly) -> None:
        """Limit work rates."""
        rows, n = a.rows("dynamics"), len(a.names) - 6
        columns = [i for i, name in enumerate(rows.names) if name.startswith("work rate")]
        if len(columns) != n:
            raise ParameterError("this formulation has no work rates to limit")
        most = self.limit * a.body.symbolic.mass / a.body.torque
        a.limit(rows, upper=most, columns=columns)


@dataclass(frozen=True)
class Quiet:
    r"""Cost :math:`\sum w \ddot q_j^2` at one instant: what is at rest there sets in softly.

    A cost, because the equation :math:`\ddot q = 0` at a straight leg would leave the nodes beside
    it next to no freedom.

    Attributes:
        time: When [s]; a node.
        weight: Weight [s⁴/rad²].
    """

    time: float
    weight: float = 1e-2

    def put(self, a: Assembly) -> None:
        """Weigh accelerations."""
        rows, k = a.rows("accelerations"), node_at(a, self.time)
        w = np.zeros(rows.weight.shape)
        w[k] = 2.0 * self.weight / a.weights[k]  # an instant's, not an integral's
        a.pull(rows, w)


@dataclass(frozen=True)
class Above:
    """A place of the body stays above a level whenever it does not rest there: a seat.

    Attributes:
        site: Its name among the body's sites.
        height: Of the level [m].
    """

    site: str
    height: float

    def put(self, a: Assembly) -> None:
        """Limit the height of the lowest point."""
        names = [s.name for s in a.body.sites]
        if self.site not in names:
            raise ParameterError(f"no site {self.site!r}; there are {', '.join(names)}")
        k = names.index(self.site)
        free = ~a.plan.standing(a.body.sites[k], a.nodes)
        free[[0, -1]] = False  # where a posture says more
        a.limit(
            a.rows("contact"), self.height, columns=[3 * k + 2], nodes=np.flatnonzero(free).tolist()
        )


@dataclass(frozen=True)
class Clearance:
    r"""A foot in the air is at least :math:`h \sin^2(\pi s)` high at part :math:`s` of its swing.

    Steps in the ground are cleared where a foot that goes smoothly from print to print meets them.

    Attributes:
        height: In the middle of the swing [m].
    """

    height: float = 0.02

    def put(self, a: Assembly) -> None:
        """Limit heights of the places that can touch."""
        rows, steps = a.rows("contact"), treads(a.plan)
        for side in ("r", "l"):
            flat = site_targets(a.body, Footprint(side, (0.0, 0.0, 0.0)))
            reach = {name: float(at[0]) for name, at in flat.items()}
            stances = [s for s in unrolled(a.plan) if s.footprint.side == side]
            for one, two in zip(stances[:-1], stances[1:], strict=True):
                swing = (a.nodes > one.off) & (a.nodes < two.strike)
                part = (a.nodes[swing] - one.off) / (two.strike - one.off)
                way = two.footprint.position[0] - one.footprint.position[0]
                gone = one.footprint.position[0] + way * part**3 * (10 - 15 * part + 6 * part**2)
                above = self.height * np.sin(np.pi * part) ** 2
                for k, site in enumerate(a.body.sites):
                    if site.side == side:
                        ahead = reach[site.name]
                        margin = np.where((part > 0.02) & (part < 0.98), BESIDE, 0.0)
                        low = steps.height(gone + ahead, margin) + above
                        at = np.flatnonzero(swing).tolist()
                        a.limit(rows, low[:, None], columns=[3 * k + 2], nodes=at)
                        if two.footprint.position[2] < one.footprint.position[2]:
                            back = (gone + ahead - BESIDE)[:, None]  # it does not lag behind
                            a.limit(rows, back, columns=[3 * k], nodes=at)


@dataclass(frozen=True)
class Reach:
    """A point of the body is at a place at one instant: a hand at its target.

    Attributes:
        point: The point.
        target: Where it shall be, world [m]; NaN for an axis that is free.
        time: When [s]; a node.
    """

    point: Point
    target: tuple[float, float, float]
    time: float

    def put(self, a: Assembly) -> None:
        """Fix the position."""
        try:
            positions = a.body.symbolic.positions([self.point])
        except CoordinateNotFound as error:
            raise ParameterError(str(error)) from error
        names = tuple(f"{axis} of {self.point.body} that reaches" for axis in "xyz")
        name = f"reach of {self.point.body} {self.point.position}"
        rows = rows_of(a, name, names, lambda q, v, acc, u: positions(q), "m")
        k, target = node_at(a, self.time), np.array(self.target, dtype=float)
        if target.shape != (3,) or np.isinf(target).any():
            raise ParameterError(f"a target is three places [m], not {self.target}")
        axes = ~np.isnan(target)
        rows.lower[k, axes] = rows.upper[k, axes] = target[axes]


@dataclass(frozen=True)
class CentreOfMass:
    """Where the centre of mass is at one instant, how fast it goes, or how much that is worth.

    Attributes:
        time: When [s]; a node.
        position: World [m]; NaN where free.
        velocity: World [m/s]; NaN where free.
        gain: What a metre up and a metre a second up at this instant take from the cost.
    """

    time: float
    position: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    velocity: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    gain: tuple[float, float] = (0.0, 0.0)

    def put(self, a: Assembly) -> None:
        """Fix or reward rows of the centre of mass."""
        import casadi as ca

        sym = a.body.symbolic

        def expression(q, v, acc, u):
            return ca.vertcat(sym.com()(q), sym.momentum()(q, v)[0] / sym.mass)

        names = tuple(f"{what} of the centre of mass" for what in ("x", "y", "z"))
        rows = rows_of(
            a, "centre of mass", (*names, *(f"speed {n}" for n in names)), expression, "m"
        )
        k, wanted = node_at(a, self.time), np.array([*self.position, *self.velocity], float)
        given = ~np.isnan(wanted)
        rows.lower[k, given] = rows.upper[k, given] = wanted[given]
        rows.gain[k, [2, 5]] -= self.gain


@dataclass(frozen=True)
class HeadStability:
    r"""Cost :math:`\int w_\omega |\omega|^2 + w_l \vartheta^2 dt` of a head that turns, or leans.

    Attributes:
        turning: Weight of its angular velocity :math:`\omega` [s/rad²].
        leaning: Weight of its lean :math:`\vartheta` from the vertical [1/(s rad²)].
    """

    turning: float = 0.05
    leaning: float = 0.05

    def put(self, a: Assembly) -> None:
        """Weigh the head's rates and lean."""
        import casadi as ca

        sym = a.body.symbolic
        i = a.body.human.body("head") - 1

        def expression(q, v, acc, u):
            R = sym.frames()(q)[1][:, 3 * i : 3 * i + 3]
            return ca.vertcat(sym.angular_velocities()(q, v)[:, i], R[0, 2], R[1, 2])

        names = (*(f"turning of the head about {x}" for x in "xyz"), "head forward", "head left")
        rows = rows_of(a, "head", names, expression)
        w = np.zeros(rows.weight.shape)
        w[:, :3], w[:, 3:] = 2.0 * self.turning, 2.0 * self.leaning
        a.pull(rows, w)


@dataclass(frozen=True)
class Symmetry:
    r"""Cost :math:`\int w \sum (q_r - q_l)^2 dt` of joints that differ between the sides.

    Bending and turning of trunk and head count as well, and the pelvis' list and rotation.

    Attributes:
        weight: Weight [1/(s rad²)].
    """

    weight: float = 1.0

    def put(self, a: Assembly) -> None:
        """Weigh the differences."""
        import casadi as ca

        names = a.names
        pairs = [(i, names.index(n[:-2] + "_l")) for i, n in enumerate(names) if n.endswith("_r")]
        middle = [
            i
            for i, n in enumerate(names)
            if n in ("pelvis_list", "pelvis_rotation")
            or n.endswith(("_bending", "neck_rotation"))
            or n.endswith("_rotation")
            and n[:-9] in ("lumbar", "thorax", "lower_thorax")
        ]

        def expression(q, v, acc, u):
            return ca.vertcat(*(q[i] - q[j] for i, j in pairs), *(q[i] for i in middle))

        rows = rows_of(
            a,
            "symmetry",
            (*(f"difference of {names[i][:-2]}" for i, _ in pairs), *(names[i] for i in middle)),
            expression,
        )
        a.pull(rows, np.full(rows.weight.shape, 2.0 * self.weight))
