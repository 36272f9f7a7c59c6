r"""The conditions of section V and the objective, one family of rows for each.

===============  ========  =================================================================
rows             equation  what
===============  ========  =================================================================
``boundary``     17        coordinates and rates at the start and at the end
``coordinates``  18        limits of coordinates, between
``rates``        18        limits of rates, between
``forces``       19, 15    limits of the generalised forces; the objective's squares
``forces``       24, 25    its rows named ``edge``: zero-moment point in the support polygon
``pelvis``       20        speed of the pelvis, squared: smooth at rest
``floor``        21        contact points not below the ground
``places``       22        contact points where their foot stands
``slip``         23        contact points that stand do not move
``arms``         26        arm and leg of a side swing to opposite sides
``knee``         27        a swinging knee is bent
``apex``         28        height that the pelvis would reach
===============  ========  =================================================================

**Generalised forces** are those of inverse dynamics (Eq. 1) without any contact force, as in
the paper: the six of the root carry the body, and the torques of the legs are those of legs that
hang. The root's are the force on the pelvis and the moment about it, world axes. In the objective
:math:`\sum_j Q^T W Q / Q_\mathrm{max}^2` the paper leaves the diagonal of :math:`W` open; it speaks
of "all joint torques", so here it is one for the joints and zero for the root, of which nobody's
muscles are the cause. With the root's forces in it the least objective is a body in free fall at
every sample: the vertical force is 2 % of body weight at each of them, and 170 % between.

**Posture.** Where the legs hang, Eq. 15 hardly cares how pelvis, trunk and legs are turned, and its
optimum bends the trunk by 60° to save a newton metre. A small cost of angles away from the neutral
pose (:data:`POSTURE`) takes that out and halves the iterations. The
objective in tables is Eq. 15 alone.

**Feet that stand still.** Positions (22) and velocities (23) of both feet at all samples are more
equations than the spline has coefficients: with feet that never move, sitting has 112 independent
ones at its inner samples for the 100 coefficients of legs and pelvis. No motion satisfies them; the
paper's tolerance on constraints, 0.04 in whatever unit, hides it. Here positions are exact, and
velocities within that tolerance, 0.04 m/s.

**Zero-moment point.** Eq. 25 is multiplied by the vertical force, which is not negative (Eq. 19):
the same condition, without the division of Eq. 24.

**Arms.** Eq. 26 takes the toes for the leg. They are a foot's length ahead of the ankle, so the leg
counts as in front for most of the cycle, and the arm of the same side must stay behind. This, not
"the low values" of the rows, is why the paper's walker has both arms behind the body.
"""

from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import Point
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.zhakatayev2023.body import PaperBody, Pose
from plantigrade.trajopt.zhakatayev2023.motions import PaperMotion
from plantigrade.trajopt.zhakatayev2023.polygons import corners, edges

MAX_ANGLE = np.pi / 3  # [rad]
MAX_ELBOW_ANGLE = 2 * np.pi / 3  # [rad]
MAX_RATE = 5.0  # [rad/s]
MAX_TORQUE = 200.0  # [N m] Q_max
MAX_LOAD = 1.4  # [body weights] vertical force
KNEE = np.pi / 3  # of a swinging knee [rad]
SLIP = 0.04  # how still a foot stands [m/s], the paper's tolerance
POSTURE = 0.005  # [1/rad²]
_ROOT = 6
EDGE = "edge"
TRANSLATIONS = ("pelvis_tx", "pelvis_ty", "pelvis_tz")


def limits(body: PaperBody, motion: PaperMotion, start: Pose, end: Pose) -> tuple[Pose, Pose]:
    """Return lower and upper limits of the coordinates (Eq. 18) [rad, m]."""
    lower, upper = body.neutral - MAX_ANGLE, body.neutral + MAX_ANGLE
    for name in ("knee_angle", "elbow_flex"):
        for side in SIDES:
            i = body.index(f"{name}_{side}")
            lower[i], upper[i] = body.neutral[i], body.neutral[i] + MAX_ELBOW_ANGLE
    if motion.start == "seated":
        for side in SIDES:
            upper[body.index(f"hip_flexion_{side}")] = MAX_ELBOW_ANGLE
    for name in TRANSLATIONS:
        i = body.index(name)
        low, high = sorted((start[i], end[i]))
        below = motion.sink if name == "pelvis_ty" else motion.leeway
        lower[i], upper[i] = low - below, high + motion.leeway
    if motion.name == "walk":  # q_2 from 0 to 2 m
        i = body.index("pelvis_tx")
        lower[i], upper[i] = start[i], start[i] + 2.0
    return lower, upper


def boundary(body: PaperBody, motion: PaperMotion, start: Pose, end: Pose) -> ConstraintFamily:
    """Return Eq. 17; of a jump's end, all but the speed up."""
    import casadi as ca

    names = (*body.names, *(f"{n} rate" for n in body.names))
    rows = _rows(body, motion, "boundary", ca.vertcat(*body.inputs[:2]), names)
    rest = np.zeros(len(start))
    for k, pose in ((0, start), (-1, end)):
        rows.lower[k] = rows.upper[k] = np.concatenate([pose, rest])
    if motion.jump:
        up = len(body.names) + body.index("pelvis_ty")
        rows.lower[-1, up], rows.upper[-1, up] = 0.0, motion.take_off
    return rows


def coordinates(body: PaperBody, motion: PaperMotion, start: Pose, end: Pose) -> ConstraintFamily:
    """Return the limits of coordinates between start and end (Eq. 18), and the cost of posture."""
    rows = _rows(body, motion, "coordinates", body.inputs[0], body.names, "deg", 180 / np.pi)
    rows.lower[1:-1], rows.upper[1:-1] = limits(body, motion, start, end)
    angles = [i for i, n in enumerate(body.names) if n not in TRANSLATIONS]
    rows.weight[1:-1, angles] = 2.0 * POSTURE
    rows.target[:] = body.neutral
    return rows


def rates(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the limits of rates between start and end (Eq. 18)."""
    rows = _rows(body, motion, "rates", body.inputs[1], body.names, "rad/s")
    rows.lower[1:-1], rows.upper[1:-1] = -MAX_RATE, MAX_RATE
    return rows


def forces(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the limits of generalised forces (Eq. 19), the objective (Eq. 15) and the edges.

    The rows after the generalised forces are, for every edge of the support polygon, the moment
    of the ground reaction about it, outwards [N m]: how far the zero-moment point is outside
    times the vertical force (Eqs. 24, 25). They share the dynamics, so they share the function.
    """
    import casadi as ca

    q, qd, qdd, u, _ = body.inputs
    where, half_planes = footholds(body, motion)[..., :2], []
    for k in range(motion.n_samples):
        feet = {s: where[k, 6 * i : 6 * i + 6] for i, s in enumerate(SIDES) if motion.contact[s][k]}
        half_planes.append(edges(corners(feet)))
    n = max(len(each) for each in half_planes)
    parameters = np.zeros((motion.n_samples, 3 * n))
    for k, each in enumerate(half_planes):
        parameters[k, : each.size] = each.ravel()
    p = ca.SX.sym("p", 3 * n)
    tau = body.symbolic.inverse_dynamics()(q, qd, qdd)
    force, moment = tau[:3], tau[3:6]
    centre = ca.vertcat(q[3], -q[5], q[4])  # of the pelvis, world
    x = centre[0] * force[2] - centre[2] * force[0] - moment[1]
    y = centre[1] * force[2] - centre[2] * force[1] + moment[0]
    off = [p[3 * i] * x + p[3 * i + 1] * y - p[3 * i + 2] * force[2] for i in range(n)]
    root = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
    names = (*(f"root {name}" for name in root), *body.names[_ROOT:])
    names += tuple(f"{EDGE} {i + 1}" for i in range(n))
    function = ca.Function("forces", [q, qd, qdd, u, p], [ca.vertcat(tau, *off) / MAX_TORQUE])
    rows = ConstraintFamily.free(
        "forces", function, names, motion.n_samples, parameters, "N m", MAX_TORQUE
    )
    nv = len(body.names)
    rows.lower[:, :nv], rows.upper[:, :nv] = -1.0, 1.0
    rows.lower[:, 2], rows.upper[:, 2] = 0.0, MAX_LOAD * body.weight / MAX_TORQUE
    rows.weight[:, _ROOT:nv] = 2.0
    for k, each in enumerate(half_planes):
        rows.upper[k, nv : nv + len(each)] = 0.0
    return rows


def pelvis(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the squared speed of the pelvis (Eq. 20)."""
    import casadi as ca

    speed = ca.sumsqr(body.inputs[1][3:6])
    rows = _rows(body, motion, "pelvis", speed, ("speed squared",), "m²/s²")
    if motion.speed:
        rows.lower[1:-1], rows.upper[1:-1] = np.square(motion.speed)[:, None, None]
    return rows


def floor(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the heights of contact points that do not stand (Eq. 21)."""
    position = body.symbolic.positions(body.contacts)(body.inputs[0])
    rows = _rows(body, motion, "floor", position[2, :].T, body.contact_names, "mm", 1e3)
    stands = standing(motion)
    for k in range(1, motion.n_samples - 1):
        rows.lower[k, ~stands[k]] = 0.0
    return rows


def places(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return where contact points are (Eq. 22), fixed where Λ is one."""
    position = body.symbolic.positions(body.contacts)(body.inputs[0]).reshape((-1, 1))
    names = tuple(f"{n} {axis}" for n in body.contact_names for axis in "xyz")
    rows = _rows(body, motion, "places", position, names, "mm", 1e3)
    stands, where = np.repeat(standing(motion), 3, axis=1), footholds(body, motion)
    target = where.reshape(len(where), -1)[stands]
    rows.lower[stands] = rows.upper[stands] = target
    return rows


def slip(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the velocities of contact points (Eq. 23), zero where Λ is one."""
    velocity = body.symbolic.velocities(body.contacts)(*body.inputs[:2]).reshape((-1, 1))
    names = tuple(f"{n} {axis}" for n in body.contact_names for axis in "xyz")
    rows = _rows(body, motion, "slip", velocity, names, "m/s")
    stands = np.repeat(standing(motion), 3, axis=1)
    rows.lower[stands], rows.upper[stands] = -SLIP, SLIP
    if motion.jump:  # they leave the ground
        rows.lower[-1], rows.upper[-1] = -np.inf, np.inf
    return rows


def arms(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the products of Eq. 26, right side first."""
    import casadi as ca

    parts = ("hand", "humerus", "toes", "femur")
    points = [Point(f"{part}_{side}") for side in SIDES for part in parts]
    x = body.symbolic.positions(points)(body.inputs[0])[0, :]
    products = ca.vertcat((x[0] - x[1]) * (x[2] - x[3]), (x[4] - x[5]) * (x[6] - x[7]))
    rows = _rows(body, motion, "arms", products, ("right", "left"), "m²")
    if motion.arms:
        rows.upper[1:-1] = 0.0
    return rows


def knee(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the knee angles (Eq. 27), at least 60° where the foot swings."""
    angles = body.inputs[0][[body.index(f"knee_angle_{side}") for side in SIDES]]
    rows = _rows(body, motion, "knee", angles, ("right", "left"), "deg", 180 / np.pi)
    if motion.knee:
        for i, side in enumerate(SIDES):
            rows.lower[~np.array(motion.contact[side]), i] = KNEE
    return rows


def apex(body: PaperBody, motion: PaperMotion) -> ConstraintFamily:
    """Return the height that the pelvis reaches in free flight, and its gain (Eq. 28)."""
    q, qd, *_ = body.inputs
    g = float(np.linalg.norm(body.symbolic.gravity))
    rows = _rows(body, motion, "apex", q[4] + qd[4] ** 2 / (2 * g), ("height",), "m")
    rows.gain[-1] = -motion.jump
    return rows


def standing(motion: PaperMotion) -> Bool[Array, "n_samples 12"]:
    """Return whether each contact point stands at each sample: both Λ, transposed."""
    return np.repeat(np.column_stack([motion.contact[s] for s in SIDES]), 6, axis=1)


def footholds(body: PaperBody, motion: PaperMotion) -> Float[Array, "n_samples 12 3"]:
    """Return where each contact point stands at each sample, if it does, world [m]."""
    moved = np.repeat(np.stack([motion.places[s] for s in SIDES], axis=1), 6, axis=1)
    return body.resting + np.dstack([moved[..., 0], -moved[..., 1], 0 * moved[..., 0]])


def _rows(
    body: PaperBody,
    motion: PaperMotion,
    name: str,
    expression: Any,
    names: tuple[str, ...],
    unit: str = "",
    scale: float = 1.0,
) -> ConstraintFamily:
    import casadi as ca

    function = ca.Function(name, list(body.inputs), [expression])
    return ConstraintFamily.free(name, function, names, motion.n_samples, unit=unit, scale=scale)
