r"""Contact as families of rows: where every site is, how fast it moves, friction, forces.

A site of the foot that stands is held where the footprint has it; its sphere rolls, so that
material on the ground is at rest.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from types import MappingProxyType

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan, Footprint
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.spatial.conventions import about_axis, about_vertical
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.transcription.derivatives import derivatives_of

ACROSS = np.array([0.0, 1.0, 0.0])  # axis of a forward pitch
MAX_UNLOADED_DEPTH = 0.001
"""Maximum depth of an unloaded sphere in the ground at a node [m]; 2 mm between nodes."""


def site_places(
    body: ContactBody, headings: Float[Array, "n_nodes n_sites"], *, rates: bool
) -> ConstraintFamily:
    r"""Return where every site is, the rolling of its sphere taken off; or how fast that moves.

    A sphere of radius :math:`\rho` on a foot pitched by :math:`\theta` and rolled by
    :math:`\varphi` (about the foot's heading) stands still where

    .. math:: \xi = c + \rho\, (\theta\, e_1 + \varphi\, e_2)

    does not change, :math:`c` being its centre and :math:`\theta > 0` toes up: the centre then
    moves as the sphere rolls. The third row is the height of the lowest point. A shank that kneels
    is pitched from where it lies on the ground.
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
            if body.pitch[k]:  # regular where it stands upright again
                R = R @ ca.DM(about_axis(ACROSS, -body.pitch[k : k + 1])[0])
                pitch = ca.atan2(R[2, 0], R[0, 0] * c + R[1, 0] * s)
                roll = ca.atan2(R[2, 1], R[1, 1] * c - R[0, 1] * s)
            x = low[0, k] + rho * pitch * c - rho * roll * s
            y = low[1, k] + rho * pitch * s + rho * roll * c
            rows += [x, y, low[2, k]]
        r = ca.vertcat(*rows)
        return ca.cse(ca.jtimes(r, q, v) if rates else r)

    name, unit = ("contact speed", "mm/s") if rates else ("contact", "mm")
    names = tuple(f"{axis} of {s.name}" for s in body.sites for axis in "xyz")
    if rates:
        names = tuple(f"speed {n}" for n in names)
    parameters = np.stack([np.cos(headings), np.sin(headings)], axis=2).reshape(len(headings), -1)
    function = body.function(name, expression, 2 * len(body.sites))
    return ConstraintFamily.free(name, function, names, len(headings), parameters, unit, 1000.0)


def friction_pyramid(body: ContactBody, n_nodes: int, friction: float) -> ConstraintFamily:
    r"""Return a pyramid inside the friction cone: :math:`|f_x|, |f_y| \le \mu f_z / \sqrt 2`.

    The axes are those of the surface under each site.
    """
    sides = body.friction(friction) / np.sqrt(2.0)

    def expression(ca, q, v, a, u, p):
        rows = []
        for k, (axes, side) in enumerate(zip(body.surfaces, sides, strict=True)):
            local = u[3 * k : 3 * k + 3]
            if not np.array_equal(axes, np.eye(3)):
                local = ca.DM(axes.T) @ local
            x, y, z = (local[i] for i in range(3))
            rows += [side * z - x, side * z + x, side * z - y, side * z + y]
        return ca.vertcat(*rows)

    names = tuple(
        f"friction {axis} at {s.name}" for s in body.sites for axis in ("+x", "-x", "+y", "-y")
    )
    function = body.function(("friction", *map(float, sides)), expression)
    return ConstraintFamily.free("friction", function, names, n_nodes, unit="body weights")


def site_forces(body: ContactBody, n_nodes: int) -> ConstraintFamily:
    """Return contact forces themselves, to weigh them [body weights]."""
    function = body.function("forces", lambda ca, q, v, a, u, p: u)
    return ConstraintFamily.free("forces", function, body.force_names, n_nodes, unit="body weights")


def site_targets(body: ContactBody, footprint: Footprint) -> dict[str, Float[Array, " 3"]]:
    """Return where the sites of a flat foot on a footprint are: x, y and height [m].

    In x and y the rolling of the spheres is taken off, as in :func:`site_places`.
    """
    flat = body.cache.get(
        ("flat foot", footprint.side), lambda: flat_sites(body.human, body.sites, footprint.side)
    )
    turn = about_vertical(footprint.heading)
    return {n: np.array(footprint.position) + turn @ x for n, x in flat.items()}


def hold_contacts(
    body: ContactBody,
    plan: ContactPlan,
    nodes: Float[Array, " n_nodes"],
    place: ConstraintFamily,
    speed: ConstraintFamily,
    *,
    soft_landing: bool = True,
) -> None:
    """Fix every standing site where the plan has it, and keep the others above the ground.

    Only the independent rows of a foot are fixed: the others follow, because the segments of a foot
    are rigid. At nodes where a contact begins or ends, the speed of what begins
    or ends is zero too; between nodes it is the positions at neighbouring ones that keep it.
    Without ``soft_landing`` the speed of what begins is free: it stops within a step of the nodes.
    """
    index = {site.name: k for k, site in enumerate(body.sites)}
    lowest = min((s.footprint.position[2] for s in plan.stances), default=0.0)
    depth = _depths(body, plan)
    for k, site in enumerate(body.sites):
        if site.side:
            place.lower[:, 3 * k + 2] = lowest - depth[k]
    for stance in plan.stances:
        during = (nodes >= stance.heel_strike - TIME_TOLERANCE) & (
            nodes <= stance.toe_off + TIME_TOLERANCE
        )
        for k, site in enumerate(body.sites):  # a heel that has risen does not sink into its tread
            if site.side == stance.footprint.side:
                place.lower[during, 3 * k + 2] = stance.footprint.position[2] - depth[k]
    for stance in plan.stances:
        targets = site_targets(body, stance.footprint)
        spans = {index[n]: stance.interval(body.sites[index[n]].part) for n in targets}
        at = {index[n]: np.tile(x, (len(nodes), 1)) for n, x in targets.items()}
        spans = _lasting(plan, spans)
        heading = stance.footprint.heading
        _hold(body, nodes, spans, at, place, speed, heading, soft_landing=soft_landing)
    for span in sorted({(s.start, s.stop) for s in plan.supports}):
        held = [s for s in plan.supports if (s.start, s.stop) == span]
        spans = {index[s.site.name]: span for s in held}
        at = {index[s.site.name]: s.places(nodes) for s in held}
        moving = {index[s.site.name]: s.velocity(nodes) for s in held}
        _hold(body, nodes, _lasting(plan, spans), at, place, speed, moving=moving)


def keep_soles_up(
    body: ContactBody,
    plan: ContactPlan,
    nodes: Float[Array, " n_nodes"],
    soles: ConstraintFamily,
    spheres: Sequence[ContactSite],
) -> None:
    """Keep spheres of the feet that carry no force in a plan from sinking into the ground.

    They are on segments that stand on other spheres, and may sink where those begin to lift: a heel
    that rolls inwards on its outer edge.
    """
    standing = body.human.standing()[None]
    zero = np.zeros((1, body.symbolic.nv))
    q, v, a = body.symbolic.from_mujoco(standing, zero, zero)
    u, p = np.zeros((1, 3 * len(body.sites))), np.zeros((1, 0))
    flat = derivatives_of(soles.function).values(q, v, a, u, p)[0]
    deep = np.minimum(flat, 0.0) - MAX_UNLOADED_DEPTH
    lowest = min((s.footprint.position[2] for s in plan.stances), default=0.0)
    soles.lower[:] = lowest + deep
    for stance in plan.stances:
        during = (nodes >= stance.heel_strike - TIME_TOLERANCE) & (
            nodes <= stance.toe_off + TIME_TOLERANCE
        )
        for k, sphere in enumerate(spheres):
            if sphere.side == stance.footprint.side:
                soles.lower[during, k] = stance.footprint.position[2] + deep[k]


def soles_of(
    body: ContactBody, n_nodes: int
) -> tuple[ConstraintFamily | None, tuple[ContactSite, ...]]:
    """Return heights of the spheres of the feet that are no sites, and these; None for none."""
    ends = tuple(f"_{site.name}" for site in body.sites)
    spheres = tuple(s for s in contact_sites(body.human) if not s.name.endswith(ends))
    if not spheres:
        return None, ()

    def expression(ca, q, v, a, u, p):
        return ca.cse(body.symbolic.positions(list(spheres))(q)[2, :].T)

    names = tuple(f"z of {s.name}" for s in spheres)
    function = body.function("soles", expression)
    return ConstraintFamily.free("soles", function, names, n_nodes, None, "mm", 1000.0), spheres


def _depths(body: ContactBody, plan: ContactPlan) -> Float[Array, " n_sites"]:
    """Return how far below the ground each site is while its foot stands flat [m].

    Soles that a user defines are flat to a millimetre. A site that is a little lower than the
    others may stay there when it no longer stands: to be on the ground one node later it would have
    to jump.
    """
    sides = {stance.footprint.side for stance in plan.stances}
    flat: dict[str, Array] = {}
    for side in sorted(sides):
        flat |= site_targets(body, Footprint(side, (0.0, 0.0, 0.0)))
    low = [-float(flat[s.name][2]) if s.name in flat else 0.0 for s in body.sites]
    return np.maximum(low, 0.0)


def _lasting(
    plan: ContactPlan, spans: dict[int, tuple[float, float]]
) -> dict[int, tuple[float, float]]:
    """Return spans without limit where they reach the start or the end of a motion."""
    if plan.periodic:
        return spans
    return {
        k: (
            -np.inf if a <= TIME_TOLERANCE else a,
            np.inf if b >= plan.duration - TIME_TOLERANCE else b,
        )
        for k, (a, b) in spans.items()
    }


def _hold(
    body: ContactBody,
    nodes: Float[Array, " n_nodes"],
    spans: dict[int, tuple[float, float]],
    targets: dict[int, Float[Array, "n_nodes 3"]],
    place: ConstraintFamily,
    speed: ConstraintFamily,
    heading: float = 0.0,
    *,
    soft_landing: bool = True,
    moving: Mapping[int, Float[Array, "n_nodes 3"]] = MappingProxyType({}),
) -> None:
    """Fix sites that move as one while they stand, or follow moving surfaces.

    Args:
        spans: When each site stands [s].
        targets: Where it is then, node by node [m].
        moving: Velocity of its surface [m/s]; zero for those that are not there.
    """
    jacobian = _rows_at_rest(body, heading)
    spans = {k: (start, stop) for k, (start, stop) in spans.items() if stop > start}
    for i, t in enumerate(nodes):
        down = [
            k
            for k, (start, stop) in spans.items()
            if start - TIME_TOLERANCE <= t <= stop + TIME_TOLERANCE
        ]
        through = [
            k for k in down if spans[k][0] < t - TIME_TOLERANCE and t + TIME_TOLERANCE < spans[k][1]
        ]
        first, every = body.cache.get(
            ("independent rows", tuple(through), tuple(down), round(heading, 3)),
            partial(_independent_rows, jacobian, through, down),
        )
        for row in every:
            place.lower[i, row] = place.upper[i, row] = targets[row // 3][i, row % 3]
        for k in down:  # those that follow need no limit
            if 3 * k + 2 not in every:
                place.lower[i, 3 * k + 2] = -np.inf
        slow = every
        if not soft_landing:
            stood = [k for k in down if spans[k][0] < t - TIME_TOLERANCE]
            slow = body.cache.get(
                ("independent rows", tuple(through), tuple(stood), round(heading, 3)),
                partial(_independent_rows, jacobian, through, stood),
            )[1]
        for row in slow[len(first) :]:
            still = row // 3 not in moving
            speed.lower[i, row] = speed.upper[i, row] = (
                0.0 if still else moving[row // 3][i, row % 3]
            )


def _rows_at_rest(body: ContactBody, heading: float = 0.0) -> Float[Array, "n_rows nv"]:
    """Return the Jacobian of all place rows in quiet standing, turned to a heading.

    Rows are along world axes, so which of them are independent depends on where the feet point: two
    parallel heels turn about the vertical with x of one, two in line with y.
    """
    angle = round(heading, 3)

    def make() -> Array:
        place = site_places(body, np.full((1, len(body.sites)), angle), rates=False)
        standing, nv = body.human.standing()[None], body.symbolic.nv
        q, v, a = body.symbolic.from_mujoco(standing, np.zeros((1, nv)), np.zeros((1, nv)))
        q[:, body.symbolic.names.index("pelvis_rotation")] += angle
        u = np.zeros((1, 3 * len(body.sites)))
        J = derivatives_of(place.function).jacobian(q, v, a, u, place.parameters)[1]
        return J[0, :, :nv].copy()

    return body.cache.get(("contact jacobian at rest", angle), make)


def _independent_rows(jacobian: Array, through: list[int], down: list[int]):
    """Return independent rows of sites that stand on, then those and the ones of all sites."""
    first = _independent(jacobian, through, [])
    return first, _independent(jacobian, down, first)


def _independent(jacobian: Array, sites: Sequence[int], first: Sequence[int]) -> list[int]:
    """Return rows of sites that are independent of each other, those of ``first`` before others."""

    def off(row: Array) -> Array:
        return row - base.T @ (base @ row)

    def extended(row: Array) -> Array:
        new = off(off(row))
        return np.vstack([base, new / np.linalg.norm(new)])

    chosen = list(first)
    base = np.zeros((0, jacobian.shape[1]))
    for row in chosen:
        base = extended(jacobian[row])
    rest = [3 * k + i for k in sites for i in range(3) if 3 * k + i not in chosen]
    while rest:
        left = [float(np.linalg.norm(off(jacobian[row]))) for row in rest]
        best = int(np.argmax(left))
        if left[best] < 1e-3:
            break
        chosen.append(rest.pop(best))
        base = extended(jacobian[chosen[-1]])
    return chosen


def headings(
    body: ContactBody, plan: ContactPlan, nodes: Float[Array, " n_nodes"]
) -> Float[Array, "n_nodes n_sites"]:
    """Return the heading of the footprint each site stands on, or stood on last [rad]."""
    out = np.zeros((len(nodes), len(body.sites)))
    for k, site in enumerate(body.sites):
        for stance in plan.stances:
            if stance.footprint.side == site.side:
                out[nodes >= stance.heel_strike - TIME_TOLERANCE, k] = stance.footprint.heading
    return out
