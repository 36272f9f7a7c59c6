"""A solved spline at any time: configurations, and the contact forces that explain them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.motion.filters import interpolate
from plantigrade.spatial.conventions import wxyz_to_xyzw, xyzw_to_wxyz
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.forces_between import explaining


@dataclass(frozen=True, eq=False)
class Sampled:
    """A motion at many times."""

    time: Float[Array, " n_times"]  #: Times [s]
    qpos: Float[Array, "n_times nq"]  #: MuJoCo's configuration (n_times, nq)
    qvel: Float[Array, "n_times nv"]  #: MuJoCo's velocity (n_times, nv)
    qacc: Float[Array, "n_times nv"]  #: MuJoCo's acceleration (n_times, nv)
    q: Float[Array, "n_times nv"]  #: Coordinates in OpenSim's order (n_times, nv)
    force: Float[Array, "n_times n_sites 3"]  #: Contact forces, world (n_times, n_sites, 3) [N]
    #: Which sites the plan has on the ground (n_times, n_sites)
    standing: Bool[Array, "n_times n_sites"]


def sample(
    body: ContactBody,
    plan: ContactPlan,
    problem: Problem,
    coefficients: Float[Array, "n_coefficients nv"],
    forces: Float[Array, "n_nodes n_unknowns"],
    times: Float[Array, " n_times"],
    friction: float,
) -> Sampled:
    """Return a motion at times [s], also beyond the end of a periodic one.

    Contact forces are near the straight line from node to node, and explain the motion
    (:mod:`~plantigrade.trajopt.transcription.forces_between`).
    """
    closure, span, n_sites = problem.closure, plan.duration, len(body.sites)
    lap = np.zeros(len(times), int)
    inside = np.asarray(times, float)
    knots, values = problem.nodes, forces
    if closure is not None:
        lap = np.floor(inside / span + 1e-12).astype(int)
        inside = np.clip(inside - lap * span, 0.0, np.nextafter(span, 0.0))
        knots = np.append(knots, span)
        values = np.vstack([values, values[:1][:, closure.u_source] * closure.u_sign])
    q, v, a = problem.states(coefficients, inside)
    u = interpolate(inside, knots, values)
    standing = (
        np.stack([plan.standing(s, inside) for s in body.sites], axis=1)
        if n_sites
        else np.zeros((len(times), 0), bool)
    )
    if closure is not None:
        for turn in range(1, int(lap.max(initial=0)) + 1):
            at = lap >= turn
            q[at] = q[at][:, closure.source] * closure.sign + closure.shift
            v[at], a[at] = (x[at][:, closure.source] * closure.sign for x in (v, a))
            u[at] = u[at][:, closure.u_source] * closure.u_sign
            standing[at] = standing[at][:, closure.u_source[::3] // 3]
    qpos, qvel, qacc = body.symbolic.to_mujoco(q, v, a)
    force = u.reshape(len(times), n_sites, 3) * body.weight
    force = explaining(body, q, v, a, force, standing, friction, np.asarray(times, float))
    if plan.motion is not None:
        qpos[:, :3] += plan.motion.displacement(inside)
        qvel[:, :3] += plan.motion.velocity(inside)
        qacc[:, :3] += plan.motion.acceleration(inside)
        q = body.human.to_coordinates(qpos)[1]
    if plan.slope:
        qpos, qvel, qacc, force = _in_world(plan.to_world, qpos, qvel, qacc, force)
        q = body.human.to_coordinates(qpos)[1]
    return Sampled(np.asarray(times, float), qpos, qvel, qacc, q, force, standing)


def _in_world(R: Array, qpos: Array, qvel: Array, qacc: Array, force: Array):
    """Return a motion turned from the axes of the ground to world axes."""
    place, velocity, acceleration = (x.copy() for x in (qpos, qvel, qacc))
    for x in (place, velocity, acceleration):
        x[:, :3] = x[:, :3] @ R.T
    turned = Rotation.from_matrix(R) * Rotation.from_quat(wxyz_to_xyzw(qpos[:, 3:7]))
    place[:, 3:7] = xyzw_to_wxyz(turned.as_quat())
    return place, velocity, acceleration, force @ R.T
