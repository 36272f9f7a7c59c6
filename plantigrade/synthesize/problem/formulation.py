r"""The rows of a motion on true contact forces: dynamics, contact, friction, limits, costs.

At every node the six equations of the root hold exactly with the forces of the ground, so every
joint torque is the one the joint really does. A place of the foot that stands is held where the
footprint has it; its sphere rolls, so that material on the ground is at rest.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.plan import SAME, ContactPlan, Footprint
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.models import Human
from plantigrade.synthesize.problem.nlp import ConstraintFamily
from plantigrade.synthesize.transcription.derivatives import derivatives_of

if TYPE_CHECKING:
    import casadi

TORQUE = 100.0
"""A torque of 1 in rows, and a work rate of 1, of a person of the reference mass and height
[N m, W]; others' go with mass times height, as strengths do."""

STIFF = ("hip_flexion", "knee_angle", "ankle_angle", "mtp_angle")

EDGE = 0.5
"""Where work rates are rounded off, in units of rows."""


@dataclass(frozen=True)
class Body:
    """A person with the places that can carry force, ready to be made rows of.

    Attributes:
        human: The person.
        sites: Places that can carry force.
        symbolic: Equations of motion.
        passive: Whether tissue bears part of the torques, so that muscles bear the rest.
        kept: What was made once for this body and is used again.
    """

    human: Human
    sites: tuple[ContactSite, ...]
    symbolic: SymbolicHuman
    passive: bool = True
    kept: dict[Any, Any] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(
        cls,
        human: Human,
        sites: Sequence[ContactSite],
        *,
        passive: bool = True,
        plan: ContactPlan | None = None,
    ) -> "Body":
        """Return the body of a person.

        Args:
            human: The person.
            sites: Places that can carry force.
            passive: Whether tissue bears part of the torques.
            plan: Says how the ground slopes; level if absent. Motions are in the axes of the
                ground, in which gravity leans.
        """
        symbolic = SymbolicHuman(human)
        if plan is not None:
            symbolic.gravity = plan.to_world.T @ symbolic.gravity
        return cls(human, tuple(sites), symbolic, passive)

    def function(
        self, key: Any, expression: Callable[..., Any], n_parameters: int = 0
    ) -> "casadi.Function":
        """Return a function of a node, made where it has not been before.

        Args:
            key: What it is called; with numbers where it depends on them.
            expression: (ca, q, qd, qdd, u, p) ↦ column of rows.
            n_parameters: Length of p.
        """
        import casadi as ca

        if ("function", key) not in self.kept:
            q, v, a = (ca.SX.sym(x, self.symbolic.nv) for x in ("q", "qd", "qdd"))
            u, p = ca.SX.sym("u", 3 * len(self.sites)), ca.SX.sym("p", n_parameters)
            r = expression(ca, q, v, a, u, p)
            self.kept["function", key] = ca.Function("rows", [q, v, a, u, p], [r])
        return self.kept["function", key]

    @property
    def weight(self) -> float:
        """Body weight [N]."""
        return self.symbolic.mass * float(np.linalg.norm(self.symbolic.gravity))

    @property
    def torque(self) -> float:
        """A torque of 1 in rows [N m], and a work rate of 1 [W]."""
        return TORQUE * scale(self.human.mass, self.human.height)

    @property
    def stiff(self) -> tuple[str, ...]:
        """Hinges at which tissue bears a part of the torque that counts beside its limit."""
        stems = STIFF if self.passive else ()
        return tuple(n for n in self.symbolic.names[6:] if n.rsplit("_", 1)[0] in stems)

    @property
    def force_names(self) -> tuple[str, ...]:
        """Names of node unknowns, three forces a site."""
        return tuple(f"force {axis} of {s.name}" for s in self.sites for axis in "xyz")


def dynamics_rows(body: Body, n_nodes: int) -> ConstraintFamily:
    r"""Return what is missing at the root, what muscles do, and how hard they work.

    The first six rows are force [body weights] and moment [body weight · m] that nothing explains;
    they are set to zero here. Then come the torques of muscles, :math:`\tau` less what tissue
    bears [:attr:`Body.torque`], and their work rates, :math:`\sqrt{(\tau \dot q)^2 + \epsilon^2}`
    less :math:`\epsilon`; last the whole torques of joints whose tissue bears much
    (:attr:`Body.stiff`). All these are left free.
    """
    sym = body.symbolic

    def expression(ca, q, v, a, u, p):
        forces = ca.reshape(u, 3, len(body.sites)) * body.weight
        tau = sym.inverse_dynamics(list(body.sites))(q, v, a, forces)
        muscle = tau[6:]
        if body.passive:
            factor = scale(body.human.mass, body.human.height)
            muscle = muscle - ca.vertcat(*passive_moments(sym.names[6:], q[6:], v[6:], factor))
        muscle = muscle / body.torque
        power = muscle * v[6:]
        work = ca.sqrt(power * power + EDGE**2) - EDGE
        whole = [tau[sym.names.index(n)] / body.torque for n in body.stiff]
        return ca.vertcat(tau[:6] / body.weight, muscle, work, *whole)

    names = tuple(f"root {w} {x}" for w in ("force", "moment") for x in "xyz")
    names += tuple(f"torque of {n}" for n in sym.names[6:])
    names += tuple(f"work rate of {n}" for n in sym.names[6:])
    names += tuple(f"whole torque of {n}" for n in body.stiff)
    function = body.function("dynamics", expression)
    rows = ConstraintFamily.free("dynamics", function, names, n_nodes, scale=body.torque)
    rows.lower[:, :6] = rows.upper[:, :6] = 0.0
    return rows


def place_rows(
    body: Body, headings: Float[Array, "n_nodes n_sites"], *, rates: bool
) -> ConstraintFamily:
    r"""Return where every site is, the rolling of its sphere taken off; or how fast that moves.

    A sphere of radius :math:`\rho` on a foot pitched by :math:`\theta` and rolled by
    :math:`\varphi` (about the foot's heading) stands still where

    .. math:: \xi = c + \rho\, (\theta\, e_1 + \varphi\, e_2)

    does not change, :math:`c` being its centre and :math:`\theta > 0` toes up: the centre then
    moves as the sphere rolls. The third row is the height of the lowest point.
    """
    sym = body.symbolic

    def expression(ca, q, v, a, u, p):
        low = sym.positions(list(body.sites))(q)
        rotation = sym.frames()(q)[1]
        rows = []
        for k, site in enumerate(body.sites):
            i = body.human.body(site.body) - 1
            R, rho = rotation[:, 3 * i : 3 * i + 3], site.radius
            c, s = p[2 * k], p[2 * k + 1]
            pitch, roll = ca.asin(R[2, 0]), ca.atan2(R[2, 1], R[2, 2])
            x = low[0, k] + rho * pitch * c - rho * roll * s
            y = low[1, k] + rho * pitch * s + rho * roll * c
            rows += [x, y, low[2, k]]
        r = ca.vertcat(*rows)
        return ca.cse(ca.mtimes(ca.jacobian(r, q), v) if rates else r)

    name, unit = ("contact speed", "mm/s") if rates else ("contact", "mm")
    names = tuple(f"{axis} of {s.name}" for s in body.sites for axis in "xyz")
    if rates:
        names = tuple(f"speed {n}" for n in names)
    parameters = np.stack([np.cos(headings), np.sin(headings)], axis=2).reshape(len(headings), -1)
    function = body.function(name, expression, 2 * len(body.sites))
    return ConstraintFamily.free(name, function, names, len(headings), parameters, unit, 1000.0)


def friction_rows(body: Body, n_nodes: int, friction: float) -> ConstraintFamily:
    r"""Return a pyramid inside the friction cone: :math:`|f_x|, |f_y| \le \mu f_z / \sqrt 2`."""
    side = friction / np.sqrt(2.0)

    def expression(ca, q, v, a, u, p):
        rows = []
        for k in range(len(body.sites)):
            x, y, z = (u[3 * k + i] for i in range(3))
            rows += [side * z - x, side * z + x, side * z - y, side * z + y]
        return ca.vertcat(*rows)

    names = tuple(
        f"friction {axis} at {s.name}" for s in body.sites for axis in ("+x", "-x", "+y", "-y")
    )
    function = body.function(("friction", side), expression)
    return ConstraintFamily.free("friction", function, names, n_nodes, unit="body weights")


def force_rows(body: Body, n_nodes: int) -> ConstraintFamily:
    """Return contact forces themselves, to weigh them [body weights]."""
    function = body.function("forces", lambda ca, q, v, a, u, p: u)
    return ConstraintFamily.free("forces", function, body.force_names, n_nodes, unit="body weights")


def motion_rows(body: Body, n_nodes: int, what: str) -> ConstraintFamily:
    """Return coordinates, their rates or accelerations as rows, to limit or weigh them.

    Args:
        body: The person.
        n_nodes: Number of nodes.
        what: ``"coordinates"``, ``"speeds"`` or ``"accelerations"``.
    """
    i = ("coordinates", "speeds", "accelerations").index(what)
    function = body.function(what, lambda ca, *states: states[i])
    prefix = ("", "speed of ", "acceleration of ")[i]
    return ConstraintFamily.free(
        what, function, tuple(prefix + n for n in body.symbolic.names), n_nodes
    )


def site_targets(body: Body, footprint: Footprint) -> dict[str, Float[Array, " 3"]]:
    """Return where the sites of a flat foot on a footprint are: x, y and height [m].

    In x and y the rolling of the spheres is taken off, as in :func:`place_rows`.
    """
    kept = f"flat {footprint.side}"
    if kept not in body.kept:
        body.kept[kept] = flat_sites(body.human, body.sites, footprint.side)
    c, s = np.cos(footprint.heading), np.sin(footprint.heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return {n: np.array(footprint.position) + turn @ x for n, x in body.kept[kept].items()}


def hold_contacts(
    body: Body,
    plan: ContactPlan,
    nodes: Float[Array, " n_nodes"],
    place: ConstraintFamily,
    speed: ConstraintFamily,
) -> None:
    """Fix every standing site where the plan has it, and keep the others above the ground.

    Of the rows of a foot only as many are fixed as are independent: the others follow, because the
    segments of a foot are rigid. At nodes where a contact begins or ends, the speed of what begins
    or ends is zero too; between nodes it is the positions at neighbouring ones that keep it.
    """
    index = {site.name: k for k, site in enumerate(body.sites)}
    lowest = min((s.footprint.position[2] for s in plan.stances), default=0.0)
    for k, site in enumerate(body.sites):
        if site.side:
            place.lower[:, 3 * k + 2] = lowest
    for stance in plan.stances:
        during = (nodes >= stance.strike - SAME) & (nodes <= stance.off + SAME)
        for k, site in enumerate(body.sites):  # a heel that has risen does not sink into its tread
            if site.side == stance.footprint.side:
                place.lower[during, 3 * k + 2] = stance.footprint.position[2]
    for stance in plan.stances:
        targets = site_targets(body, stance.footprint)
        spans = {index[n]: stance.interval(body.sites[index[n]].part) for n in targets}
        _hold(
            body,
            nodes,
            _lasting(plan, spans),
            {index[n]: x for n, x in targets.items()},
            place,
            speed,
            stance.footprint.heading,
        )
    if plan.supports:
        spans = {index[s.site.name]: (s.start, s.stop) for s in plan.supports}
        at = {index[s.site.name]: np.array(s.position) for s in plan.supports}
        _hold(body, nodes, _lasting(plan, spans), at, place, speed)


def _lasting(
    plan: ContactPlan, spans: dict[int, tuple[float, float]]
) -> dict[int, tuple[float, float]]:
    """Return spans, those that last from the start or to the end of a motion for ever."""
    if plan.periodic:
        return spans
    return {
        k: (-np.inf if a <= SAME else a, np.inf if b >= plan.duration - SAME else b)
        for k, (a, b) in spans.items()
    }


def _hold(
    body: Body,
    nodes: Float[Array, " n_nodes"],
    spans: dict[int, tuple[float, float]],
    targets: dict[int, Float[Array, " 3"]],
    place: ConstraintFamily,
    speed: ConstraintFamily,
    heading: float = 0.0,
) -> None:
    """Fix sites that move as one while they stand: site → from when to when, and where."""
    jacobian = _rows_at_rest(body, heading)
    spans = {k: (start, stop) for k, (start, stop) in spans.items() if stop > start}
    for i, t in enumerate(nodes):
        down = [k for k, (start, stop) in spans.items() if start - SAME <= t <= stop + SAME]
        through = [k for k in down if spans[k][0] < t - SAME and t + SAME < spans[k][1]]
        key = ("rows", tuple(through), tuple(down), round(heading, 3))
        if key not in body.kept:
            first = _independent(jacobian, through, [])
            body.kept[key] = first, _independent(jacobian, down, first)
        first, every = body.kept[key]
        for row in every:
            place.lower[i, row] = place.upper[i, row] = targets[row // 3][row % 3]
        for k in down:  # those that follow need no limit
            if 3 * k + 2 not in every:
                place.lower[i, 3 * k + 2] = -np.inf
        for row in every[len(first) :]:
            speed.lower[i, row] = speed.upper[i, row] = 0.0


def _rows_at_rest(body: Body, heading: float = 0.0) -> Float[Array, "n_rows nv"]:
    """Return the Jacobian of all place rows in quiet standing.

    Rows are along world axes, so which of them are independent depends on where the feet point: two
    heels beside each other turn about the vertical with x of one, two behind each other with y.

    Args:
        body: The person.
        heading: Where the person stands to, from x towards y [rad].
    """
    key = ("at rest", round(heading, 3))
    if key not in body.kept:
        towards = np.full((1, len(body.sites)), key[1])
        place = place_rows(body, towards, rates=False)
        standing, nv = body.human.standing()[None], body.symbolic.nv
        q, v, a = body.symbolic.from_mujoco(standing, np.zeros((1, nv)), np.zeros((1, nv)))
        q[:, body.symbolic.names.index("pelvis_rotation")] += key[1]
        u = np.zeros((1, 3 * len(body.sites)))
        J = derivatives_of(place.function).jacobian(q, v, a, u, place.parameters)[1]
        body.kept[key] = J[0, :, :nv].copy()
    return body.kept[key]


def _independent(
    jacobian: Float[Array, "n_rows nv"], sites: Sequence[int], first: Sequence[int]
) -> list[int]:
    """Return rows of sites that are independent of each other, those of ``first`` before others."""
    chosen = list(first)
    base = np.zeros((0, jacobian.shape[1]))
    for row in chosen:
        base = _with(base, jacobian[row])
    rest = [3 * k + i for k in sites for i in range(3) if 3 * k + i not in chosen]
    while rest:
        left = np.array([np.linalg.norm(_off(base, jacobian[row])) for row in rest])
        best = int(np.argmax(left))
        if left[best] < 1e-3:
            break
        row = rest.pop(best)
        base = _with(base, jacobian[row])
        chosen.append(row)
    return chosen


def _off(base: Array, row: Array) -> Array:
    return row - base.T @ (base @ row)


def _with(base: Array, row: Array) -> Array:
    new = _off(base, _off(base, row))
    return np.vstack([base, new / np.linalg.norm(new)])


def headings(
    body: Body, plan: ContactPlan, nodes: Float[Array, " n_nodes"]
) -> Float[Array, "n_nodes n_sites"]:
    """Return the heading of the footprint each site stands on, or stood on last [rad]."""
    out = np.zeros((len(nodes), len(body.sites)))
    for k, site in enumerate(body.sites):
        for stance in plan.stances:
            if stance.footprint.side == site.side:
                out[nodes >= stance.strike - 1e-9, k] = stance.footprint.heading
    return out
